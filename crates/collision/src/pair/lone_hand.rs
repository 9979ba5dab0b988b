use cranny_shape::{Solid, overlap, quick_lower_bound};
use cranny_spatial::{Pose, Rotation, Vector};

use crate::body::link_body::group_separation;
use crate::cell::{Cell, Scratch};
use crate::lane::lane_scratch::as_index;
use crate::pair::pairs::{Other, Pair};
use crate::touch::contact::{Collider, Contact};

/// Upper bound of the error of a computed depth, in metres.
const DEPTH_ERROR_M: f64 = 1e-6;

impl Cell {
    /// Returns true if the links that are rigid with the tip (the hand, and the link that carries it) keep their distance from
    /// every body of the world, with the robot's tip at `world_from_tip`. If not, every configuration with that tip pose is in
    /// collision.
    pub fn hand_is_free(&self, world_from_tip: &Pose, scratch: &mut Scratch) -> bool {
        self.hand_contact(world_from_tip, scratch).is_none()
    }

    /// Returns the first contact of these links at `world_from_tip`, if any ([`Self::hand_is_free`]).
    pub fn hand_contact(&self, world_from_tip: &Pose, scratch: &mut Scratch) -> Option<Contact> {
        self.pairs_near_hand(*world_from_tip, scratch).find_map(|(pair, world_from_link)| {
            let body = &self.bodies[pair.first];
            let Other::Part(index) = pair.second else { return None };
            let (body_index, part) = &self.around.parts[index];
            if body.quick_bound_to(&world_from_link, part, pair.required_m) > pair.required_m {
                return None;
            }
            let shapes = body.shapes.iter().map(|(pose, solid)| (world_from_link * pose, solid));
            let placed = std::iter::once((part.world_from_solid, &part.solid));
            let gap = group_separation(shapes, &placed, pair.required_m);
            (gap.lower_m < pair.required_m).then_some(Contact {
                first: Collider::Link(body.link),
                second: Collider::Body(*body_index),
                clearance_m: gap.lower_m,
                required_m: pair.required_m,
                depth_m: 0.0,
                point: None,
            })
        })
    }

    /// Returns the pairs of links that are rigid with the tip and parts of the world that are near, with the poses of the links.
    fn pairs_near_hand<'a>(
        &'a self,
        world_from_tip: Pose,
        scratch: &'a mut Scratch,
    ) -> impl Iterator<Item = (Pair, Pose)> + 'a {
        // These links are rigidly connected to the tip, so their relative poses are the same in any configuration.
        scratch.q.fill(0.0);
        self.robot.forward_kinematics(&scratch.q, &mut scratch.frames);
        let frames = &scratch.frames;
        let tip_from_root = frames.link(self.robot.tip()).inverse();
        let of_hand = self.pairs.with_parts().filter(|pairs| pairs.is_rigid_with_tip);
        of_hand.flat_map(move |pairs| {
            let world_from_link =
                world_from_tip * (tip_from_root * frames.link(self.bodies[pairs.body].link));
            let near = self.near_parts(pairs, &world_from_link, 0.0);
            near.map(move |pair| (self.pairs.get(as_index(pair)), world_from_link))
        })
    }

    /// Returns true if it is proven that the links which are rigid with the tip touch the world at every pose of the tip within a
    /// translation (m) and a rotation (rad) of `world_from_tip`. False decides nothing. The poses are divided into at most
    /// `most_boxes` boxes.
    ///
    /// 1. If two convex solids overlap by a depth, each plane has points of one on the side of the other at least that deep. A
    ///    motion in which no point of one moves farther than the depth therefore leaves an overlap.
    /// 2. A box of translations and of rotation vectors is blocked if the pair overlaps deeply enough in its middle. Otherwise
    ///    it is halved, unless the hand is free in its middle. Two rotations differ at most by the angle that is the distance of
    ///    their rotation vectors.
    pub fn hand_is_blocked_near(
        &self,
        world_from_tip: &Pose,
        (translation_m, rotation_rad): (f64, f64),
        most_boxes: usize,
        scratch: &mut Scratch,
    ) -> bool {
        let mut open = vec![TipBox::around([translation_m, rotation_rad])];
        let mut boxes = 0;
        while let Some(tip_box) = open.pop() {
            let Some(radii) = tip_box.radii([translation_m, rotation_rad]) else { continue };
            boxes += 1;
            match self.depth_beyond_motion_m(&(world_from_tip * tip_box.middle()), radii, scratch) {
                Some(depth_m) if depth_m > 0.0 => {}
                Some(_) if boxes + open.len() < most_boxes => open.extend(tip_box.halves()),
                _ => return false,
            }
        }
        true
    }

    /// Returns the most by which the depth of an overlap at `world_from_tip` exceeds the motion of the hand by a translation (m)
    /// and a rotation (rad), in metres; `None` without an overlap.
    fn depth_beyond_motion_m(
        &self,
        world_from_tip: &Pose,
        [off_m, off_rad]: [f64; 2],
        scratch: &mut Scratch,
    ) -> Option<f64> {
        let is_convex = |solid: &Solid| solid.support_point(&Vector::z()).is_some();
        let mut most: Option<f64> = None;
        for (pair, world_from_link) in self.pairs_near_hand(*world_from_tip, scratch) {
            let Other::Part(index) = pair.second else { continue };
            let (_, part) = &self.parts()[index];
            if pair.is_exempt() || !(part.solid.is_half_space() || is_convex(&part.solid)) {
                continue;
            }
            for (link_from_solid, solid) in &self.bodies[pair.first].shapes {
                let world_from_solid = world_from_link * link_from_solid;
                let others = (&part.solid, &part.world_from_solid);
                if !is_convex(solid)
                    || quick_lower_bound(solid, &world_from_solid, others.0, others.1, 0.0) > 0.0
                {
                    continue;
                }
                let Some(overlap) = overlap(solid, &world_from_solid, others.0, others.1) else { continue };
                let ball = solid.ball();
                let centre = world_from_solid * ball.center;
                let farthest_m = (centre.coords - world_from_tip.translation.vector).norm() + ball.radius_m;
                let beyond_m = overlap.depth_m - (off_m + off_rad * farthest_m + DEPTH_ERROR_M);
                if beyond_m > 0.0 {
                    return Some(beyond_m);
                }
                most = Some(most.map_or(beyond_m, |most| most.max(beyond_m)));
            }
        }
        most
    }
}

/// Length by which a turn of the hand is compared with a translation, in metres: about that of a hand.
const HAND_M: f64 = 0.15;

/// Small motions of the tip in its own frame: a box of translations (m) and one of rotation vectors (rad).
#[derive(Clone, Copy)]
struct TipBox {
    middles: [Vector; 2],
    halves: [Vector; 2],
}

impl TipBox {
    fn around(limits: [f64; 2]) -> Self {
        let halves = limits.map(Vector::repeat);
        Self { middles: [Vector::zeros(); 2], halves }
    }

    fn middle(&self) -> Pose {
        Pose::from_parts(self.middles[0].into(), Rotation::from_scaled_axis(self.middles[1]))
    }

    /// Maximum distance from the middle of those of its translations (m) and rotation vectors (rad) whose lengths do not exceed
    /// `limits`; `None` if all of them do.
    fn radii(&self, limits: [f64; 2]) -> Option<[f64; 2]> {
        let kinds = [0, 1].map(|kind| {
            let (middle, half) = (self.middles[kind], self.halves[kind]);
            let least = (middle.abs() - half).sup(&Vector::zeros()).norm();
            (least <= limits[kind]).then(|| half.norm().min(middle.norm() + limits[kind]))
        });
        Some([kinds[0]?, kinds[1]?])
    }

    /// Halves it across the side that moves the hand most.
    fn halves(self) -> [Self; 2] {
        let [along, about] = self.halves.map(|half| half.imax());
        let kind = usize::from(self.halves[1][about] * HAND_M > self.halves[0][along]);
        let axis = [along, about][kind];
        let (mut lower, mut upper) = (self, self);
        let quarter = 0.5 * self.halves[kind][axis];
        lower.halves[kind][axis] = quarter;
        upper.halves[kind][axis] = quarter;
        lower.middles[kind][axis] -= quarter;
        upper.middles[kind][axis] += quarter;
        [lower, upper]
    }
}
