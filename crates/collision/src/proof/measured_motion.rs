use cranny_shape::Range;
use cranny_spatial::{CONTACT_M, ROUNDING_M};

use crate::Collider;
use crate::cell::{Cell, Scratch};
use crate::pair::pair_group::PairGroup;
use crate::pair::pairs::Pair;
use crate::proof::course::Course;
use crate::proof::motion::travel_of;
use crate::touch::contact::Contact;

/// How exactly [`Cell::measure_motion`] measures.
#[derive(Clone, Copy, Debug)]
pub struct Measuring {
    /// What is farther apart, in metres, is not asked after. Default: infinite.
    pub below_m: f64,
    /// How far what is found may lie below the truth, as a share of it, from 0 to below 1; at least 10 µm. Default: 0.
    pub share: f64,
    /// Which pairs are measured. Default: all.
    pub group: Option<PairGroup>,
}

impl Default for Measuring {
    fn default() -> Self {
        Self { below_m: f64::INFINITY, share: 0.0, group: None }
    }
}

/// What [`Cell::measure_motion`] found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredMotion {
    /// See [`Cell::least_clearance`].
    pub least_m: f64,
    /// The least distance that was seen, or beyond which nothing was asked after, in metres.
    pub seen_m: f64,
    /// Where on the motion, in [0, 1], a pair was seen closer than it may be.
    pub contradiction: Option<(f64, Contact)>,
    /// The pair that was seen at that least distance; `None` where no pair was asked after.
    pub nearest: Option<NearestPair>,
}

/// The pair that limits a clearance, and the distance that is demanded of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestPair {
    /// A link.
    pub first: Collider,
    /// Another link, or a body.
    pub second: Collider,
    /// The least distance of the two that counts as free, in metres.
    pub required_m: f64,
    /// True if [`Margins::grasp_margin_m`](crate::Margins::grasp_margin_m) applies to it instead of
    /// [`Margins::margin_m`](crate::Margins::margin_m).
    pub has_grasp_margin: bool,
}

/// How far [`Cell::least_clearance`] may lie below the truth, in metres.
const CLEARANCE_TOLERANCE_M: f64 = 1e-5;

/// The same where two things come closer than [`CLOSE_M`], in metres.
const FINE_TOLERANCE_M: f64 = 1e-6;

/// Where a link can move farther within an interval, in metres, the exact distance in its middle excludes next to
/// nothing that the boxes do not.
const FAR_TRAVEL_M: f64 = 0.2;

/// Where contact would lie within the coarse tolerance, in metres.
const CLOSE_M: f64 = CONTACT_M + 2.0 * CLEARANCE_TOLERANCE_M;

/// A distance that was measured is off by less than this, in metres.
const MEASURING_M: f64 = 1e-7;

impl Cell {
    /// The least distance over all pairs along the straight motion from `a` to `b` (m, rad; one per joint), in
    /// metres: a certified lower bound that is at most 10 µm too low; 0 if there is contact, infinite if there is
    /// nothing to touch. Meant for motions that are proven: the closer two things come, the longer it takes.
    ///
    /// # Panics
    /// If `a` or `b` has not one value per joint.
    pub fn least_clearance(&self, a: &[f64], b: &[f64], scratch: &mut Scratch) -> f64 {
        self.measure_motion([a, b], Measuring::default(), scratch).least_m
    }

    /// [`Self::least_clearance`] between two ends (m, rad; one per joint), and whether any pair was seen closer than
    /// it may be: all in `f64`, without what a proof relies on besides, so that a proof that it contradicts is none.
    ///
    /// # Panics
    /// If an end has not one value per joint.
    pub fn measure_motion(
        &self,
        [a, b]: [&[f64]; 2],
        measuring: Measuring,
        scratch: &mut Scratch,
    ) -> MeasuredMotion {
        self.measure(Course::Line([a, b]), measuring, scratch)
    }

    /// [`Self::measure_motion`] along any motion.
    pub(crate) fn measure(
        &self,
        course: Course<'_>,
        measuring: Measuring,
        scratch: &mut Scratch,
    ) -> MeasuredMotion {
        scratch.rates.set(course);
        let is_asked = |pair: &Pair| {
            !pair.is_exempt() && measuring.group.is_none_or(|group| self.group_of(pair) == group)
        };
        let [a, b] = course.ends();
        let at_a = self.nearest_where(a, measuring.below_m, &is_asked, scratch);
        let at_b = self.nearest_where(b, at_a.0, &is_asked, scratch);
        let (mut least, mut nearest) = if at_b.0 < at_a.0 { at_b } else { at_a };
        let mut contradiction = None;
        let all: Vec<u32> = self.all_pairs().filter(|pair| is_asked(&self.pairs.get(*pair))).collect();
        let mut open = std::collections::VecDeque::from([(0.5, 0.5, all)]);
        let tolerance_m = |least: f64| {
            let finest = if least < CLOSE_M { FINE_TOLERANCE_M } else { CLEARANCE_TOLERANCE_M };
            // Of what is infinitely far nothing is a share.
            finest.max(if least.is_finite() { measuring.share * least } else { 0.0 })
        };
        // Branch and bound: an interval is done with a pair once the pair cannot come below the least
        // distance that was seen, save for the tolerance.
        while let Some((middle, half_width, pairs)) = open.pop_front() {
            self.check_at(course, middle, half_width, scratch, 1.0);
            let mut doubtful = Vec::new();
            for index in pairs {
                let pair = &self.pairs.get(index);
                let travel = travel_of(pair, scratch) + ROUNDING_M;
                let bar = |least: f64| least - tolerance_m(least) + travel;
                if self.quick_bound(pair, &scratch.frames, bar(least)) >= bar(least) {
                    continue;
                }
                // Boxes are nearly as good as the exact distance where things move by more than their size.
                if travel > FAR_TRAVEL_M {
                    doubtful.push(index);
                    continue;
                }
                // Between the least distance and the bar it only matters that it is there.
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
