use cranny_shape::Range;
use cranny_spatial::{CONTACT_M, ROUNDING_M};

use crate::Collider;
use crate::cell::{Cell, Scratch};
use crate::pair::pair_group::PairGroup;
use crate::pair::pairs::Pair;
use crate::proof::joint_curve::JointCurve;
use crate::proof::motion::travel_of;
use crate::proof::work_list::MOST_INTERVALS;
use crate::touch::contact::Contact;

/// Options of [`Cell::measure_motion`].
#[derive(Clone, Copy, Debug)]
pub struct MeasureOptions {
    /// Distance from which on pairs are ignored, in metres. Default: infinite.
    pub below_m: f64,
    /// Relative slack of the result below the true distance, from 0 to below 1; at least 10 µm applies. Default: 0.
    pub share: f64,
    /// Group of pairs that is measured. Default: all.
    pub group: Option<PairGroup>,
}

impl Default for MeasureOptions {
    fn default() -> Self {
        Self { below_m: f64::INFINITY, share: 0.0, group: None }
    }
}

/// Result of [`Cell::measure_motion`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredMotion {
    /// Least clearance, in metres, as of [`Cell::least_clearance`]; 0 if the effort was exhausted.
    pub least_m: f64,
    /// Least measured distance, in metres; [`MeasureOptions::below_m`] if no pair is closer, 0 if the effort was exhausted.
    pub seen_m: f64,
    /// Parameter on the motion, in [0, 1], at which a pair was measured closer than allowed, with that contact.
    pub contradiction: Option<(f64, Contact)>,
    /// Pair at the distance `seen_m`; `None` if no pair was measured, or the effort was exhausted: the nearest may be one that
    /// was not measured.
    pub nearest: Option<NearestPair>,
}

/// Pair that limits a clearance, with the distance demanded of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestPair {
    /// A link.
    pub first: Collider,
    /// Another link, or a body of the world.
    pub second: Collider,
    /// Least distance of the two that counts as free, in metres.
    pub required_m: f64,
    /// True if [`Margins::grasp_margin_m`](crate::Margins::grasp_margin_m) applies to it instead of
    /// [`Margins::margin_m`](crate::Margins::margin_m).
    pub has_grasp_margin: bool,
}

/// Maximum amount by which [`Cell::least_clearance`] is below the true distance, in metres.
const CLEARANCE_TOLERANCE_M: f64 = 1e-5;

/// Tolerance for pairs closer than [`CLOSE_M`], in metres.
const FINE_TOLERANCE_M: f64 = 1e-6;

/// Travel of a link within an interval above which boxes exclude nearly as much as the exact distance in its middle, in metres.
const FAR_TRAVEL_M: f64 = 0.2;

/// Distance below which the coarse tolerance could not exclude contact, in metres.
const CLOSE_M: f64 = CONTACT_M + 2.0 * CLEARANCE_TOLERANCE_M;

/// Maximum error of a measured distance, in metres.
const MEASURING_M: f64 = 1e-7;

impl Cell {
    /// Returns the least distance over all pairs along the straight motion from `a` to `b` (m, rad; one per joint), in metres:
    /// a certified lower bound, at most 10 µm too low; 0 in contact, infinite if there are no pairs. It is meant for proven
    /// motions, and takes longer the smaller the clearance is.
    ///
    /// # Panics
    /// If `a` or `b` has not one value per joint.
    pub fn least_clearance(&self, a: &[f64], b: &[f64], scratch: &mut Scratch) -> f64 {
        self.measure_motion([a, b], MeasureOptions::default(), scratch).least_m
    }

    /// Measures [`Self::least_clearance`] between two ends (m, rad; one per joint), and reports any pair closer than allowed,
    /// in `f64` alone, without the tables and lanes of a proof: a faulty proof can be refuted.
    ///
    /// # Panics
    /// If an end has not one value per joint.
    pub fn measure_motion(
        &self,
        [a, b]: [&[f64]; 2],
        measuring: MeasureOptions,
        scratch: &mut Scratch,
    ) -> MeasuredMotion {
        self.measure(JointCurve::Line([a, b]), measuring, scratch)
    }

    /// Runs [`Self::measure_motion`] along any motion.
    pub(crate) fn measure(
        &self,
        curve: JointCurve<'_>,
        measuring: MeasureOptions,
        scratch: &mut Scratch,
    ) -> MeasuredMotion {
        self.measure_within(MOST_INTERVALS, curve, measuring, scratch)
    }

    fn measure_within(
        &self,
        most_intervals: u64,
        curve: JointCurve<'_>,
        measuring: MeasureOptions,
        scratch: &mut Scratch,
    ) -> MeasuredMotion {
        scratch.rates.set(curve);
        let is_asked = |pair: &Pair| {
            !pair.is_exempt() && measuring.group.is_none_or(|group| self.group_of(pair) == group)
        };
        let [a, b] = curve.ends();
        let at_a = self.nearest_where(a, measuring.below_m, &is_asked, scratch);
        let at_b = self.nearest_where(b, at_a.0, &is_asked, scratch);
        let (mut least, mut nearest) = if at_b.0 < at_a.0 { at_b } else { at_a };
        let mut contradiction = None;
        self.check_at(curve, 0.5, 0.5, scratch, 1.0);
        // No point of a farther part comes as near during the motion.
        let reach_m = |body: usize| least + scratch.travel.of(body) + ROUNDING_M;
        let near = self.near_pairs(&scratch.frames, reach_m);
        let all: Vec<u32> = near.filter(|pair| is_asked(&self.pairs.get(*pair))).collect();
        let mut open = std::collections::VecDeque::from([(0.5, 0.5, all)]);
        let mut intervals: u64 = 0;
        let tolerance_m = |least: f64| {
            let finest = if least < CLOSE_M { FINE_TOLERANCE_M } else { CLEARANCE_TOLERANCE_M };
            // A fraction of an infinite distance is undefined.
            finest.max(if least.is_finite() { measuring.share * least } else { 0.0 })
        };
        // Branch and bound: an interval is done for a pair that cannot come below the least measured distance, less the
        // tolerance.
        while let Some((middle, half_width, pairs)) = open.pop_front() {
            intervals += 1;
            if intervals > most_intervals {
                return MeasuredMotion { least_m: 0.0, seen_m: 0.0, contradiction, nearest: None };
            }
            self.check_at(curve, middle, half_width, scratch, 1.0);
            let mut doubtful = Vec::new();
            for index in pairs {
                let pair = &self.pairs.get(index);
                let travel = travel_of(pair, scratch) + ROUNDING_M;
                let bar = |least: f64| least - tolerance_m(least) + travel;
                if self.quick_bound(pair, &scratch.frames, bar(least)) >= bar(least) {
                    continue;
                }
                // Boxes are nearly as sharp as the exact distance for links that move by more than their size.
                if travel > FAR_TRAVEL_M {
                    doubtful.push(index);
                    continue;
                }
                let exact_below_m = least.max(pair.required_m);
                let range = Range { beyond_m: exact_below_m.max(bar(least)), exact_below_m };
                let gap = self.distance_in(pair, &scratch.frames, range);
                if gap.lower_m < least {
                    (least, nearest) = (gap.lower_m, Some(*pair));
                }
                if gap.lower_m < pair.required_m - MEASURING_M && contradiction.is_none() {
                    contradiction = Some((middle, self.describe(pair, &scratch.frames)));
                }
                if least <= 0.0 {
                    let nearest = nearest.map(|pair| self.nearest_pair(&pair));
                    return MeasuredMotion { least_m: 0.0, seen_m: least, contradiction, nearest };
                }
                if gap.lower_m < bar(least) {
                    doubtful.push(index);
                }
            }
            if !doubtful.is_empty() && half_width > f64::EPSILON {
                let quarter = half_width * 0.5;
                open.push_back((middle - quarter, quarter, doubtful.clone()));
                open.push_back((middle + quarter, quarter, doubtful));
            }
        }
        let least_m = (least - tolerance_m(least)).max(0.0);
        let nearest = nearest.map(|pair| self.nearest_pair(&pair));
        MeasuredMotion { least_m, seen_m: least, contradiction, nearest }
    }

    fn nearest_pair(&self, pair: &Pair) -> NearestPair {
        let Pair { first, required_m, .. } = *pair;
        let (link, second) = (self.bodies[first].link, self.other(pair));
        let is_of_grasp = matches!(second, Collider::Body(body) if self.grasp_bodies.contains(&body));
        let has_grasp_margin = is_of_grasp && self.robot().hand_links().contains(&link);
        NearestPair { first: Collider::Link(link), second, required_m, has_grasp_margin }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use cranny_robot::{Robot, RobotOptions};
    use cranny_shape::Solid;
    use cranny_spatial::Pose;

    use super::*;
    use crate::{Body, Margins, World};

    const SLIDE: &str = r#"<robot name="slide">
      <link name="base"/>
      <link name="cart"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
      <joint name="slide" type="prismatic"><parent link="base"/><child link="cart"/><axis xyz="1 0 0"/>
        <limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
    </robot>"#;

    /// The pair that is nearest where the motion ends was named as the nearest of all, with a distance of 0.
    #[test]
    fn no_pair_is_named_when_the_effort_is_exhausted() {
        let robot = Robot::from_urdf_text(SLIDE, "slide.urdf", None, &RobotOptions::default()).unwrap();
        let ball = |name: &str, x: f64, y: f64| {
            Body::new(name, Pose::translation(x, y, 0.0), Solid::sphere(0.1).unwrap())
        };
        let world = World::new(vec![ball("at the end", 0.6, 0.3), ball("on the way", 0.0, 0.2)]).unwrap();
        let cell = Cell::new(Arc::new(robot), world, Margins::default()).unwrap();
        let mut scratch = cell.scratch();
        let line = JointCurve::Line([&[-0.6], &[0.6]]);
        let mut measured = |most| cell.measure_within(most, line, MeasureOptions::default(), &mut scratch);
        let whole = measured(MOST_INTERVALS);
        assert!((whole.seen_m - 0.05).abs() < 1e-4, "{whole:?}");
        assert_eq!(whole.nearest.map(|pair| pair.second), Some(Collider::Body(1)));
        let exhausted = measured(0);
        assert_eq!((exhausted.least_m.to_bits(), exhausted.nearest), (0, None));
    }
}
