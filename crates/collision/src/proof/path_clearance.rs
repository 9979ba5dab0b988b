use crate::cell::{Cell, Scratch};
use crate::pair::pair_group::PairGroup;
use crate::proof::joint_curve::JointCurve;
use crate::proof::motion::Demand;
use crate::{MeasureOptions, Motion};

/// Minimum tolerance by which a measured clearance may be below the true one, in metres.
const TOLERANCE_M: f64 = 1e-5;

impl Cell {
    /// Returns the least distance over all pairs along a path of way points (m, rad; one value per joint) with proven edges, in
    /// metres: a proven lower bound, too low by at most `share` (from 0 to below 1) of the true distance plus 10 µm; infinite
    /// if there are no pairs, 0 if an edge is in contact after all. Many times faster than [`Self::least_clearance`] of every
    /// edge.
    ///
    /// 1. The least distance at the way points is an upper bound.
    /// 2. Each edge is proven to keep slightly less, from the last, where the hand is at its target, to the first.
    /// 3. If the proof of an edge fails, the distance measured there is the new bound.
    ///
    /// # Panics
    /// If a way point has not one value per joint.
    pub fn path_clearance(&self, path: &[Vec<f64>], share: f64, scratch: &mut Scratch) -> f64 {
        // 1.
        let mut least_m = path.iter().map(|q| self.clearance(q, scratch)).fold(f64::INFINITY, f64::min);
        if least_m.is_infinite() {
            return least_m;
        }
        let kept_m = |least_m: f64| least_m * (1.0 - share) - TOLERANCE_M;
        let margins = self.margins();
        let required_m = margins.required_m(false).min(margins.required_m(true));
        for edge in path.windows(2).rev() {
            let beyond_m = kept_m(least_m) - required_m;
            let demand = Demand { beyond_m, ..Demand::default() };
            // 2.
            if beyond_m <= 0.0
                || self.prove(JointCurve::Line([&edge[0], &edge[1]]), scratch, demand) != Motion::Proven
            {
                // 3.
                let ends = [&edge[0][..], &edge[1]];
                least_m = self
                    .measure_motion(ends, MeasureOptions { below_m: least_m, share, group: None }, scratch)
                    .seen_m;
                if least_m <= 0.0 {
                    return 0.0;
                }
            }
        }
        kept_m(least_m).max(0.0)
    }

    /// Returns the least distance along a path of way points (m, rad; one value per joint) over one group of pairs, in metres;
    /// infinite if the group is empty. Slower than [`Self::path_clearance`].
    ///
    /// # Panics
    /// If a way point has not one value per joint.
    pub fn group_clearance(
        &self,
        path: &[Vec<f64>],
        group: PairGroup,
        share: f64,
        scratch: &mut Scratch,
    ) -> f64 {
        let mut below_m = f64::INFINITY;
        for edge in path.windows(2).rev() {
            let measuring = MeasureOptions { below_m, share, group: Some(group) };
            below_m = self.measure_motion([&edge[0], &edge[1]], measuring, scratch).seen_m;
        }
        if below_m.is_finite() { (below_m * (1.0 - share) - TOLERANCE_M).max(0.0) } else { below_m }
    }
}
