use cranny_robot::Robot;
use cranny_task::RoundedCorner;

use crate::timing::drives::Drives;
use crate::timing::motion_limits::{MotionLimits, TimingMethod};
use crate::timing::path_curve::{Corner, Cuts, LARGEST_SHARE, MOST_UNEVEN, PathCurve};
use crate::timing::piece_limits::{EdgePace, PieceLimits};
use crate::timing::s_curve::s_curve;
use crate::timing::time_law::TimeLaw;
use crate::timing::time_optimal::time_optimal;

/// Path as a trajectory executes it.
#[derive(Clone, Copy, Debug)]
pub struct CurvedPath<'a> {
    /// Way points: one value per joint each (m, rad).
    pub waypoints: &'a [Vec<f64>],
    /// Rounded corners, by their way points in the path, ascending; at all other corners the robot stops.
    pub corners: &'a [RoundedCorner],
    /// Limits of each edge in addition to the joint limits; none: no further limits.
    pub paces: &'a [EdgePace],
    /// Robot whose tool speed is limited; `None`: no limit.
    pub robot: Option<&'a Robot>,
    /// Drives of this robot, whose forces are limited; `None`: no limit.
    pub drives: Option<&'a Drives>,
}

/// Proof that a curved path may be changed.
pub trait CurveProof {
    /// Returns true if edge `edge` of the path may connect these ends (m, rad; one value per joint).
    fn edge(&mut self, edge: usize, ends: [&[f64]; 2]) -> bool;

    /// Returns true if a corner may have these control points ([`RoundedCorner`]; m, rad; one value per joint).
    fn corner(&mut self, waypoint: usize, control_points: &[Vec<f64>; 5]) -> bool;
}

impl<'a> CurvedPath<'a> {
    /// Creates a path with a stop at each corner, through way points (m, rad; one value per joint).
    pub fn stopping(waypoints: &'a [Vec<f64>]) -> Self {
        Self { waypoints, corners: &[], paces: &[], robot: None, drives: None }
    }

    /// Returns the corners of the path, each rounded for minimum duration among the sizes that `proven` accepts
    /// ([`CurveProof::corner`]; control points in m, rad, one value per joint). Rounded corners of this path are ignored.
    ///
    /// 1. Finds the largest proven share of both edges of each corner, by halving from the greatest and two steps of bisection.
    /// 2. Descends in the lengths that each corner cuts off its edges, one after the other, as long as the duration decreases.
    /// 3. Proves each corner that became smaller; if that fails, half of it, and so on.
    ///
    /// A large corner is passed faster, but leaves less of its edges to accelerate on. A corner that cuts off more of one edge
    /// than of the other changes the speed. Where the path turns back, a stop may be faster than any smooth corner.
    pub fn rounded(
        &self,
        limits: &MotionLimits,
        mut proven: impl FnMut(usize, &[Vec<f64>; 5]) -> bool,
    ) -> Vec<RoundedCorner> {
        let corners = PathCurve::corners(self.waypoints, &limits.velocity);
        let mut accepts =
            |corner: &Corner, cuts: Cuts| proven(corner.waypoint, &corner.rounded(cuts).control_points);
        let mut cuts = vec![[0.0; 2]; self.waypoints.len()];
        // 1.
        for corner in &corners {
            let share = proven_share(|share| accepts(corner, corner.lengths.map(|length| share * length)));
            cuts[corner.waypoint] = corner.lengths.map(|length| share * length);
        }
        // 2.
        let mut proven = cuts.clone();
        let stopping_s = self.duration_s(limits, &vec![[0.0; 2]; cuts.len()]);
        let mut least_s = self.duration_s(limits, &cuts);
        self.descend(limits, &corners, [&mut cuts, &mut proven], &mut least_s, &mut accepts);
        // 3.
        for corner in &corners {
            let cuts = &mut cuts[corner.waypoint];
            let smaller = (0..FINAL_HALVINGS).map(|halving| cuts.map(|cut| cut * 0.5_f64.powi(halving)));
            let is_proven = |cuts: &Cuts| is_same(*cuts, proven[corner.waypoint]) || accepts(corner, *cuts);
            *cuts = smaller.filter(|cuts| cuts[0] > 0.0).find(is_proven).unwrap_or_default();
        }
        if self.duration_s(limits, &cuts) > stopping_s {
            return Vec::new();
        }
        self.with_cuts(limits, &cuts)
    }

    /// Returns the corners with these cuts, one per way point.
    pub(crate) fn with_cuts(&self, limits: &MotionLimits, cuts: &[Cuts]) -> Vec<RoundedCorner> {
        let corners = PathCurve::corners(self.waypoints, &limits.velocity).into_iter();
        let rounded = corners.filter(|corner| cuts[corner.waypoint][0] > 0.0);
        rounded.map(|corner| corner.rounded(cuts[corner.waypoint])).collect()
    }

    /// Improves the cuts of each corner (2 of [`Self::rounded`]). Cuts above `proven` are proven first, smaller ones later.
    fn descend(
        &self,
        limits: &MotionLimits,
        corners: &[Corner],
        [cuts, proven]: [&mut [Cuts]; 2],
        least_s: &mut f64,
        accepts: &mut impl FnMut(&Corner, Cuts) -> bool,
    ) {
        const MOST_ROUNDS: usize = 4;
        /// Minimum share of the time that a round must save for another one, and that a change must save for a proof.
        const LEAST_GAIN: f64 = 1e-3;
        /// Change of the duration, as a share, below which a corner is left unchanged.
        const NO_CHANGE: f64 = 1e-6;
        for round in 0..MOST_ROUNDS {
            let before_s = *least_s;
            for (index, corner) in corners.iter().enumerate() {
                // Lengths of its edges that its neighbours leave.
                let left = |other: Option<&Corner>, side: usize| {
                    let taken = other.filter(|other| other.waypoint.abs_diff(corner.waypoint) == 1);
                    corner.lengths[side] * LARGEST_SHARE
                        - taken.map_or(0.0, |other| cuts[other.waypoint][1 - side])
                };
                let most =
                    [left(index.checked_sub(1).map(|i| &corners[i]), 0), left(corners.get(index + 1), 1)];
                let proven = &mut proven[corner.waypoint];
                for factors in if round == 0 { FIRST_STEPS } else { STEPS } {
                    let was = cuts[corner.waypoint];
                    let wanted = [0, 1].map(|side| (factors[side] * was[side]).min(most[side]));
                    let [less, more] = [wanted[0].min(wanted[1]), wanted[0].max(wanted[1])];
                    if is_same(wanted, was) || (more > 0.0 && less * MOST_UNEVEN < more) {
                        continue;
                    }
                    cuts[corner.waypoint] = wanted;
                    let found_s = self.duration_s(limits, cuts);
                    if (found_s - *least_s).abs() < NO_CHANGE * *least_s {
                        cuts[corner.waypoint] = was;
                        break;
                    }
                    let is_within = wanted[0] <= proven[0] && wanted[1] <= proven[1];
                    let enough_s = if is_within { 0.0 } else { LEAST_GAIN * *least_s };
                    if found_s < *least_s - enough_s && (is_within || accepts(corner, wanted)) {
                        *least_s = found_s;
                        if !is_within {
                            *proven = wanted;
                        }
                    } else {
                        cuts[corner.waypoint] = was;
                    }
                }
            }
            if before_s - *least_s < LEAST_GAIN * *least_s {
                break;
            }
        }
    }

    /// Returns the duration with these cuts; infinity if uneven corners multiply to a scale of `s` that would amplify rounding
    /// errors. The limits of tool speed and drives are left out: they are costly to bound, and limit an edge with any corners.
    pub(crate) fn duration_s(&self, limits: &MotionLimits, cuts: &[Cuts]) -> f64 {
        const MOST_SCALE: f64 = 4096.0;
        let mut scale = 1.0;
        for [before, after] in cuts.iter().filter(|cuts| cuts[0] > 0.0) {
            scale *= after / before;
            if scale.max(1.0 / scale) > MOST_SCALE {
                return f64::INFINITY;
            }
        }
        let curve = PathCurve::along(self.waypoints, &limits.velocity, cuts);
        law(&curve, limits.method, &PieceLimits::all_of(&curve, limits, self.paces, None)).duration_s
    }
}

fn is_same(a: Cuts, b: Cuts) -> bool {
    a.map(f64::to_bits) == b.map(f64::to_bits)
}

/// Maximum number of halvings of a corner that descent made smaller than a proven one and that is not proven itself.
const FINAL_HALVINGS: i32 = 4;

/// Factors of both cuts of a corner to try.
const STEPS: &[[f64; 2]] = &[[1.25, 1.0], [1.0, 1.25], [0.8, 1.0], [1.0, 0.8], [0.8, 0.8], [1.25, 1.25]];

/// Factors to try in the first round.
const FIRST_STEPS: &[[f64; 2]] = &[
    [0.5, 0.5],
    [0.5, 0.5],
    [0.5, 0.5],
    [0.5, 1.0],
    [1.0, 0.5],
    [0.5, 1.0],
    [1.0, 0.5],
    [1.5, 1.0],
    [1.0, 1.5],
    [1.5, 1.5],
    [0.0, 0.0],
];

/// Returns the time law along a curve by a method.
pub(crate) fn law(curve: &PathCurve, method: TimingMethod, limits: &[PieceLimits]) -> TimeLaw {
    match method {
        TimingMethod::TimeOptimal => time_optimal(curve, limits),
        TimingMethod::JerkLimited => s_curve(curve, limits),
    }
}

/// Returns the largest share of its edges found, up to a half, with which a corner is proven; 0 for none.
fn proven_share(mut is_proven: impl FnMut(f64) -> bool) -> f64 {
    const GREATEST: f64 = 0.49;
    const HALVINGS: usize = 6;
    const BISECTIONS: usize = 2;
    let mut share = GREATEST;
    for halving in 0..=HALVINGS {
        if is_proven(share) {
            let (mut proven, mut unproven) = (share, 2.0 * share);
            for _ in 0..if halving == 0 { 0 } else { BISECTIONS } {
                let middle = 0.5 * (proven + unproven);
                if is_proven(middle) { proven = middle } else { unproven = middle }
            }
            return proven;
        }
        share *= 0.5;
    }
    0.0
}
