use cranny_shape::{Surface, TriangleSoup};
use cranny_spatial::{Point, Vector};

use crate::{Finger, Hand, PadRectangle};

/// Two equal flat pads of a parallel hand, in the gripper frame: rectangles along x and z that face each other along y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pads {
    /// Centre along x and z, in metres.
    pub middle_m: [f64; 2],
    /// Half of the size along x and z, in metres.
    pub half_m: [f64; 2],
    /// Distance between the pads of the open hand, in metres.
    pub opening_m: f64,
    /// Position of the pad faces of the open hand along y, finger by finger, in metres.
    pub faces_m: [f64; 2],
}

/// Maximum depth of a pad behind the foremost point of the finger's inner side, in metres: a pad of 30 mm that is
/// inclined by 1° is one.
const DEPTH_M: f64 = 6e-4;
/// Minimum share of the stroke along y of a finger that moves along y.
const LEAST_ALONG_Y: f64 = 0.99;
/// Number of rays that probe a finger, along x and along z.
const RAYS: [usize; 2] = [32, 64];

impl Pads {
    /// Pads of a hand: the rectangle in which the inner sides of both fingers lie foremost, clipped to the stated
    /// rectangle, if any. `None` for a hand without exactly two fingers that move towards each other along y, or with
    /// fingers that have no surface.
    pub fn of(hand: &Hand) -> Option<Self> {
        let [first, second] = &hand.fingers[..] else { return None };
        let along_y = |finger: &Finger| finger.stroke_m.y.abs() > LEAST_ALONG_Y * finger.stroke_m.norm();
        if !(along_y(first) && along_y(second) && first.stroke_m.y * second.stroke_m.y < 0.0) {
            return None;
        }
        let mut low = [f64::NEG_INFINITY; 2];
        let mut high = [f64::INFINITY; 2];
        if let Some(PadRectangle { middle_m, half_m }) = hand.pads {
            low = [0, 1].map(|axis| middle_m[axis] - half_m[axis]);
            high = [0, 1].map(|axis| middle_m[axis] + half_m[axis]);
        }
        let mut faces_m = [0.0; 2];
        for (finger, face_m) in [first, second].into_iter().zip(&mut faces_m) {
            let side = -finger.stroke_m.y.signum();
            let inner = InnerSide::of(hand, finger.parts.clone(), side)?;
            *face_m = side * inner.foremost_m;
            let [from, to] = inner.extent_m;
            for axis in 0..2 {
                low[axis] = low[axis].max(from[axis]);
                high[axis] = high[axis].min(to[axis]);
            }
        }
        let half_m = [0, 1].map(|axis| 0.5 * (high[axis] - low[axis]));
        let middle_m = [0, 1].map(|axis| 0.5 * (high[axis] + low[axis]));
        let opening_m = hand.opening_m;
        (half_m[0] > 0.0 && half_m[1] > 0.0).then_some(Self { middle_m, half_m, opening_m, faces_m })
    }
}

/// The side of a finger that faces the other one.
struct InnerSide {
    /// Distance of its foremost point from the middle, in metres.
    foremost_m: f64,
    /// Lower and upper corner of its foremost region along x and z, in metres.
    extent_m: [[f64; 2]; 2],
}

impl InnerSide {
    fn of(hand: &Hand, parts: std::ops::Range<usize>, side: f64) -> Option<Self> {
        let mut soup = TriangleSoup::default();
        for (gripper_from_part, solid) in &hand.parts[parts] {
            soup.append(&solid.tessellation()?, gripper_from_part);
        }
        let surface = Surface::new(&soup).ok()?;
        let (center, half) = (surface.aabb().center, surface.aabb().half_extents);
        let reach_m = center.y.abs() + half.y + 1e-3;
        let mut foremost_m = f64::INFINITY;
        let mut felt = Vec::new();
        for i in 0..RAYS[0] {
            for k in 0..RAYS[1] {
                let at = |count: usize, step: usize| 2.0 * (step as f64 + 0.5) / count as f64 - 1.0;
                let x = center.x + half.x * at(RAYS[0], i);
                let z = center.z + half.z * at(RAYS[1], k);
                let hits = surface.ray_hits(&Point::new(x, 0.0, z), &(Vector::y() * side), reach_m);
                if let Some(hit) = hits.first() {
                    foremost_m = foremost_m.min(hit.distance_m);
                    felt.push(([x, z], hit.distance_m));
                }
            }
        }
        // The region extends beyond the outermost rays by half their spacing.
        let step = [half.x / RAYS[0] as f64, half.z / RAYS[1] as f64];
        let mut extent_m = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        for (at, _) in felt.iter().filter(|(_, distance_m)| *distance_m <= foremost_m + DEPTH_M) {
            for axis in 0..2 {
                extent_m[0][axis] = extent_m[0][axis].min(at[axis] - step[axis]);
                extent_m[1][axis] = extent_m[1][axis].max(at[axis] + step[axis]);
            }
        }
        (!felt.is_empty()).then_some(Self { foremost_m, extent_m })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::BoxHand;

    #[test]
    fn the_pads_of_a_hand_of_boxes_are_the_sides_of_its_fingers() {
        let boxes = BoxHand::default();
        let pads = Pads::of(&boxes.hand().unwrap()).unwrap();
        assert!((pads.half_m[0] - 0.5 * boxes.finger_width_m).abs() < 1e-9);
        assert!((pads.half_m[1] - 0.5 * boxes.finger_length_m).abs() < 1e-9);
        assert!(pads.middle_m[0].abs() < 1e-12);
        assert!((pads.middle_m[1] - (boxes.tip_ahead_m - 0.5 * boxes.finger_length_m)).abs() < 1e-9);
        for (face_m, side) in pads.faces_m.into_iter().zip([1.0, -1.0]) {
            assert!((face_m - 0.5 * side * boxes.opening_m).abs() < 1e-9, "{face_m}");
        }
    }

    #[test]
    fn stated_pads_end_where_the_fingers_do() {
        let boxes = BoxHand::default();
        let stated = PadRectangle { middle_m: [0.0, 0.0], half_m: [0.005, 0.01] };
        let hand = Hand { pads: Some(stated), ..boxes.hand().unwrap() };
        let pads = Pads::of(&hand).unwrap();
        let [low, high] = [-0.01, boxes.tip_ahead_m];
        assert!((pads.half_m[0] - 0.005).abs() < 1e-9 && (pads.half_m[1] - 0.5 * (high - low)).abs() < 1e-9);
        assert!((pads.middle_m[1] - 0.5 * (high + low)).abs() < 1e-9);
    }

    #[test]
    fn a_hand_has_no_pads_whose_fingers_do_not_close_on_each_other() {
        let hand = BoxHand::default().hand().unwrap();
        let with_stroke = |stroke_m: Vector| {
            let mut hand = hand.clone();
            hand.fingers[1].stroke_m = stroke_m;
            Pads::of(&hand)
        };
        assert!(with_stroke(hand.fingers[1].stroke_m).is_some());
        assert_eq!(with_stroke(hand.fingers[0].stroke_m), None);
        assert_eq!(with_stroke(Vector::x() * 0.04), None);
        assert_eq!(with_stroke(Vector::zeros()), None);
    }
}
