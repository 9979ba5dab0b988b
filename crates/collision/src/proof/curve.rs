use cranny_robot::between;
use cranny_spatial::ROUNDING_M;

use crate::body::tool_bound::CellBound;
use crate::cell::{Cell, Scratch};
use crate::proof::joint_curve::JointCurve;
use crate::proof::motion::{Demand, Motion};
use crate::proof::reach::Reach;
use crate::proof::tool::{Excess, TOLERANCE};
use crate::touch::contact::Contact;
use crate::{MeasureOptions, NearestPair};

/// Deviation of a segment of a curve from its chord, in metres of motion of any point of the robot, below which the segment is
/// not bisected: the resolution of a proof.
const FINEST_M: f64 = 1e-6;

/// A segment of a curve: control points of its Bézier form, parameters on the whole curve, and deviation from its chord.
struct CurvePiece {
    points: Vec<Vec<f64>>,
    from: f64,
    until: f64,
    /// Bound on the distance of any point of the robot from its position at some point of the chord, in metres.
    deviation_m: f64,
    /// Bound on the deviation of each joint from its value at that point of the chord (m, rad).
    strays: Vec<f64>,
}

impl CurvePiece {
    /// Applies the tube lemma: for chord points `c_i` of the control points `P_i`, the curve at t is the chord point
    /// `Σ B_i(t) c_i` moved by `Σ B_i(t) (P_i − c_i)`, and the Bernstein polynomials `B_i` are a convex combination. So each
    /// joint deviates from some chord point by at most `max_i |P_i − c_i|`.
    fn new(points: Vec<Vec<f64>>, [from, until]: [f64; 2], reach: &Reach) -> Self {
        let (first, last) = (&points[0], &points[points.len() - 1]);
        // Joints that move no geometry may still move a bounded link.
        const LEAST_WEIGHT_M: f64 = 0.01;
        let weights: Vec<f64> = reach.weights().iter().map(|weight| weight.max(LEAST_WEIGHT_M)).collect();
        let chord = |joint: usize| last[joint] - first[joint];
        let length2: f64 = weights.iter().enumerate().map(|(joint, w)| (w * chord(joint)).powi(2)).sum();
        let mut strays = vec![0.0_f64; first.len()];
        for point in &points[1..points.len() - 1] {
            let along: f64 = weights
                .iter()
                .enumerate()
                .map(|(joint, w)| w * w * chord(joint) * (point[joint] - first[joint]))
                .sum();
            let share = if length2 > 0.0 { (along / length2).clamp(0.0, 1.0) } else { 0.0 };
            for (joint, stray) in strays.iter_mut().enumerate() {
                *stray = stray.max((point[joint] - first[joint] - share * chord(joint)).abs());
            }
        }
        let deviation_m = reach.motion_m(|joint| strays[joint]) + ROUNDING_M;
        Self { points, from, until, deviation_m, strays }
    }

    fn chord(&self) -> [&[f64]; 2] {
        [&self.points[0], &self.points[self.points.len() - 1]]
    }

    /// Bisects the segment by de Casteljau's construction.
    fn halves(&self, reach: &Reach) -> [Self; 2] {
        let mut row = self.points.clone();
        let (mut left, mut right) = (Vec::with_capacity(row.len()), Vec::with_capacity(row.len()));
        while let (Some(first), Some(last)) = (row.first(), row.last()) {
            left.push(first.clone());
            right.push(last.clone());
            row = row.windows(2).map(|pair| between(&pair[0], &pair[1], 0.5).collect()).collect();
        }
        right.reverse();
        let middle = 0.5 * (self.from + self.until);
        [Self::new(left, [self.from, middle], reach), Self::new(right, [middle, self.until], reach)]
    }
}

/// A path of chords that approximates a curve.
#[derive(Clone, Debug)]
pub struct Chords {
    /// Way points on the curve: one value per joint each (m, rad).
    pub waypoints: Vec<Vec<f64>>,
    /// Bound on the distance of any point of the robot on the curve from its position at some point of the chords, and on the
    /// change of any distance between two links, in metres.
    pub deviation_m: f64,
}

impl Cell {
    /// Proves the motion along a polynomial curve, given by at least two control points of its Bézier form (m, rad; one value
    /// per joint each), or returns the fault. With two control points it is [`Self::motion_is_free`].
    ///
    /// 1. The curve is bisected into segments. Their control points satisfy the joint limits, and so do the segments. Bounds on
    ///    the tool are proven along the chords, with the deviation of the segments from these.
    /// 2. Distances are proven as on a straight motion, by the velocity in the middle of each interval and bounds on `q'` and
    ///    `q''`.
    ///
    /// # Panics
    /// For fewer than two control points, or one without one value per joint.
    pub fn curve_is_free(&self, control_points: &[Vec<f64>], reach: &Reach, scratch: &mut Scratch) -> Motion {
        let fault = self.fault_of_joints(control_points, FINEST_M, reach, scratch);
        fault.unwrap_or_else(|| self.prove(JointCurve::Curve(control_points), scratch, Demand::default()))
    }

    /// Returns true if [`Self::curve_is_free`] is proven with limited effort (control points: m, rad; one value per joint
    /// each), with `beyond_m` metres more than the demanded distance of every pair; also false if a small clearance would take
    /// many intervals.
    ///
    /// # Panics
    /// As [`Self::curve_is_free`].
    pub fn curve_keeps(
        &self,
        beyond_m: f64,
        control_points: &[Vec<f64>],
        reach: &Reach,
        scratch: &mut Scratch,
    ) -> bool {
        /// Deviation from their chords below which segments are not bisected, in metres.
        const FINE_M: f64 = 5e-5;
        const EFFORT: u64 = 64;
        let demand = Demand { beyond_m, effort: EFFORT, ..Demand::default() };
        let curve = match control_points {
            [a, b] => JointCurve::Line([a, b]),
            points => JointCurve::Curve(points),
        };
        self.fault_of_joints(control_points, FINE_M, reach, scratch).is_none()
            && self.first_failure(curve, scratch, demand).is_none()
    }

    /// Runs phase 1 of [`Self::curve_is_free`]. Segments within `finest_m` (m) of their chords are not bisected.
    fn fault_of_joints(
        &self,
        control_points: &[Vec<f64>],
        finest_m: f64,
        reach: &Reach,
        scratch: &mut Scratch,
    ) -> Option<Motion> {
        assert!(control_points.len() > 1, "a curve has two control points or more");
        let mut work = vec![CurvePiece::new(control_points.to_vec(), [0.0, 1.0], reach)];
        while let Some(piece) = work.pop() {
            let is_fine = |bound: &CellBound| bound.stray(&piece.strays) <= finest_m;
            let is_finest = piece.deviation_m <= finest_m && self.bounds.iter().all(is_fine);
            let [first, last] = piece.chord();
            let violation = piece.points.iter().find_map(|q| self.robot().first_limit_violation(q));
            let fault = if let Some(violation) = violation {
                let is_certain = [first, last].iter().any(|q| !self.robot().within_limits(q));
                Some((Motion::OutOfLimits { joint: violation.joint }, is_certain))
            } else {
                self.out_of_bounds_at(first, last, &piece.strays, scratch).map(|excess| {
                    let at = piece.from + excess.at * (piece.until - piece.from);
                    let is_certain = excess.by > self.bounds[excess.bound].stray(&piece.strays);
                    (Motion::from(Excess { at, ..excess }), is_certain)
                })
            };
            match fault {
                Some((fault, is_certain)) if is_finest || is_certain => return Some(fault),
                Some(_) => work.extend(piece.halves(reach).into_iter().rev()),
                None => {}
            }
        }
        None
    }

    /// Returns the least distance over all pairs along a curve (control points: m, rad; one value per joint each), in metres: a
    /// proven lower bound, too low by at most the larger of `share` of the true distance and 10 µm; infinite if there are no
    /// pairs. Also returns the pair that limits it.
    ///
    /// # Errors
    /// A pair that was measured closer than allowed, which contradicts a proof of the curve.
    ///
    /// # Panics
    /// As [`Self::curve_is_free`].
    pub fn curve_clearance(
        &self,
        control_points: &[Vec<f64>],
        share: f64,
        scratch: &mut Scratch,
    ) -> Result<(f64, Option<NearestPair>), Contact> {
        assert!(control_points.len() > 1, "a curve has two control points or more");
        let measuring = MeasureOptions { share, ..MeasureOptions::default() };
        let measured = self.measure(JointCurve::Curve(control_points), measuring, scratch);
        match measured.contradiction {
            Some((_, contact)) => Err(contact),
            None => Ok((measured.least_m, measured.nearest)),
        }
    }

    /// Returns the greatest excess over the tool bound of this index along a curve (control points: m, rad; one value per joint
    /// each), in radians or metres, as an upper bound to within some thousandths.
    ///
    /// # Panics
    /// As [`Self::curve_is_free`], or if there is no such bound.
    pub fn greatest_excess_on_curve(
        &self,
        bound: usize,
        control_points: &[Vec<f64>],
        reach: &Reach,
        scratch: &mut Scratch,
    ) -> f64 {
        assert!(control_points.len() > 1, "a curve has two control points or more");
        let mut greatest = f64::NEG_INFINITY;
        let mut work = vec![CurvePiece::new(control_points.to_vec(), [0.0, 1.0], reach)];
        while let Some(piece) = work.pop() {
            let stray = self.bounds[bound].stray(&piece.strays);
            if stray > TOLERANCE {
                work.extend(piece.halves(reach));
            } else {
                let [first, last] = piece.chord();
                greatest = greatest.max(self.greatest_excess(bound, first, last, scratch) + stray);
            }
        }
        greatest
    }

    /// Approximates a curve (control points: m, rad; one value per joint each) by chords from which it deviates by at most
    /// `tolerance_m` (m), or the resolution of a proof if that is larger.
    ///
    /// # Panics
    /// As [`Self::curve_is_free`].
    pub fn chords_of(control_points: &[Vec<f64>], tolerance_m: f64, reach: &Reach) -> Chords {
        assert!(control_points.len() > 1, "a curve has two control points or more");
        let mut chords = Chords { waypoints: vec![control_points[0].clone()], deviation_m: 0.0 };
        let mut work = vec![CurvePiece::new(control_points.to_vec(), [0.0, 1.0], reach)];
        while let Some(piece) = work.pop() {
            if piece.deviation_m <= tolerance_m.max(FINEST_M) {
                chords.deviation_m = chords.deviation_m.max(piece.deviation_m);
                chords.waypoints.push(piece.chord()[1].to_vec());
            } else {
                work.extend(piece.halves(reach).into_iter().rev());
            }
        }
        chords
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use cranny_robot::{Robot, RobotOptions};
    use cranny_shape::Solid;
    use cranny_spatial::{Pose, Stream};

    use super::*;
    use crate::{Body, Margins, World};

    const ARM: &str = r#"<robot name="arm">
      <link name="base"/>
      <link name="upper"><collision><origin xyz="0.2 0 0"/><geometry><box size="0.4 0.04 0.04"/></geometry></collision></link>
      <link name="lower"><collision><origin xyz="0.15 0 0"/><geometry><box size="0.3 0.03 0.03"/></geometry></collision></link>
      <joint name="slide" type="prismatic"><parent link="base"/><child link="cart"/><axis xyz="0 1 0"/>
        <limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
      <link name="cart"/>
      <joint name="turn" type="revolute"><parent link="cart"/><child link="upper"/><axis xyz="0 0 1"/>
        <limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
      <joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0.4 0 0"/>
        <axis xyz="0 0.6 0.8"/><limit lower="-2.5" upper="2.5" velocity="1" effort="1"/></joint>
    </robot>"#;

    fn at(points: &[Vec<f64>], t: f64) -> Vec<f64> {
        let mut row = points.to_vec();
        while row.len() > 1 {
            row = row.windows(2).map(|pair| between(&pair[0], &pair[1], t).collect()).collect();
        }
        row.remove(0)
    }

    /// Checks curves of degree 1 to 5 among boxes: a proven curve is free at every sample and keeps its measured clearance; a
    /// twentieth of the true bound misses a contact. The control points are within the limits, so these never decide.
    #[test]
    fn a_proven_curve_is_free_and_a_wrong_bound_is_caught() {
        let robot = Robot::from_urdf_text(ARM, "arm.urdf", None, &RobotOptions::default()).expect("a URDF");
        let robot = Arc::new(robot);
        let (mut stream, mut proven, mut refused, mut false_proofs) = (Stream::new(3, 0), 0, 0, 0);
        for round in 0..600_u32 {
            let bodies = (0..12).map(|k| {
                let mut at = || stream.uniform_between(-0.7, 0.7);
                let pose = Pose::translation(at(), at(), at());
                Body::new(format!("ball{k}"), pose, Solid::sphere(0.04).expect("a positive radius"))
            });
            let world = World::new(bodies.collect()).expect("finite poses");
            let cell = Cell::new(robot.clone(), world, Margins::default()).expect("good margins");
            let degree = 1 + round as usize % 5;
            let points: Vec<Vec<f64>> = (0..=degree)
                .map(|_| {
                    let widths = [0.4, 1.5, 1.5];
                    widths.iter().map(|w| stream.uniform_between(-w, *w)).collect()
                })
                .collect();
            let (reach, mut scratch) = (cell.reach(), cell.scratch());
            let samples: Vec<Vec<f64>> = (0..=200).map(|k| at(&points, f64::from(k) / 200.0)).collect();
            let seen_m =
                samples.iter().map(|q| cell.clearance(q, &mut scratch)).fold(f64::INFINITY, f64::min);
            if cell.curve_is_free(&points, &reach, &mut scratch).is_proven() {
                proven += 1;
                assert!(seen_m > 0.0, "round {round}");
                let (least_m, _) = cell.curve_clearance(&points, 0.05, &mut scratch).expect("proven");
                assert!(least_m <= seen_m + 1e-9, "{least_m} above {seen_m}");
                assert!(least_m >= 0.94 * seen_m - 2e-3, "{least_m} far below {seen_m}");
                let chords = Cell::chords_of(&points, 1e-3, &reach);
                assert!(chords.deviation_m <= 1e-3);
                let along = chords.waypoints.windows(2);
                let chord_m = along.map(|chord| cell.least_clearance(&chord[0], &chord[1], &mut scratch));
                assert!(chord_m.fold(f64::INFINITY, f64::min) <= seen_m + chords.deviation_m);
            } else {
                refused += 1;
                assert!(seen_m < 1e-2, "a curve that keeps {seen_m} m was refused");
                let wrong = Demand { factor: 0.05, ..Demand::default() };
                let proof = cell.prove(JointCurve::Curve(&points), &mut scratch, wrong);
                false_proofs += u32::from(proof.is_proven());
            }
        }
        assert!(proven > 20 && refused > 20 && false_proofs > 0, "{proven} {refused} {false_proofs}");
    }

    #[test]
    fn a_curve_that_leaves_the_limits_is_refused_and_one_whose_hull_does_alone_is_not() {
        let robot = Robot::from_urdf_text(ARM, "arm.urdf", None, &RobotOptions::default()).expect("a URDF");
        let world = World::new(Vec::new()).expect("an empty world");
        let cell = Cell::new(Arc::new(robot), world, Margins::default()).expect("good margins");
        let (reach, mut scratch) = (cell.reach(), cell.scratch());
        let hump = |top: f64| vec![vec![0.0, 0.0, 0.0], vec![top, 0.0, 0.0], vec![0.0, 0.1, 0.0]];
        // A parabola rises half as high as its middle control point.
        assert!(cell.curve_is_free(&hump(1.9), &reach, &mut scratch).is_proven());
        let beyond = cell.curve_is_free(&hump(2.1), &reach, &mut scratch);
        assert_eq!(beyond, Motion::OutOfLimits { joint: 0 });
    }
}
