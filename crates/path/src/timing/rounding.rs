use cranny_robot::Robot;
use cranny_task::RoundedCorner;

use crate::timing::drives::Drives;
use crate::timing::motion_limits::{MotionLimits, TimingMethod};
use crate::timing::path_curve::{Corner, Cuts, LARGEST_SHARE, MOST_UNEVEN, PathCurve};
use crate::timing::piece_limits::{EdgePace, PieceLimits};
use crate::timing::s_curve::s_curve;
use crate::timing::time_law::TimeLaw;
use crate::timing::time_optimal::time_optimal;

/// A path as a trajectory runs along it.
#[derive(Clone, Copy, Debug)]
pub struct CurvedPath<'a> {
    /// Way points: one value per joint each (m, rad).
    pub waypoints: &'a [Vec<f64>],
    /// Corners that are rounded, by their way points in the path, ascending; at others there is a stop.
    pub corners: &'a [RoundedCorner],
    /// Limits of each edge besides those of the joints; none: no further limits.
    pub paces: &'a [EdgePace],
    /// The robot, whose tool's speed is limited; `None`: it is not.
    pub robot: Option<&'a Robot>,
    /// The drives of this robot, whose forces are limited; `None`: they are not.
    pub drives: Option<&'a Drives>,
}

/// Proofs that a curved path may be changed.
pub trait CurveProof {
    /// Whether an edge of the path, by its number, may lead between these ends (m, rad; one value per joint).
    fn edge(&mut self, edge: usize, ends: [&[f64]; 2]) -> bool;

    /// Whether a corner at a way point may have these control points ([`RoundedCorner`]; m, rad; one value per joint).
    fn corner(&mut self, waypoint: usize, control_points: &[Vec<f64>; 5]) -> bool;
}

impl<'a> CurvedPath<'a> {
    /// A path with a stop at each corner, through way points (m, rad; one value per joint).
    pub fn stopping(waypoints: &'a [Vec<f64>]) -> Self {
        Self { waypoints, corners: &[], paces: &[], robot: None, drives: None }
    }

    /// Its corners, each rounded as serves the time best among the sizes that `proven` accepts ([`CurveProof::corner`]; control points
    /// in m, rad, one value per joint). Corners of this path are disregarded.
    ///
    /// 1. The largest proven share of both edges of each corner: greatest first, then halved, with two steps of bisection.
    /// 2. Descent along what each corner cuts off either edge, one after the other, as long as the whole takes less time.
    /// 3. Proof of each corner that became smaller; of half of it where it is not proven, and so on.
    ///
    /// A large corner is run through faster, but leaves less of its edges to gain speed on; and one that cuts off more of one
    /// edge than of the other is a change of speed. Where the path turns back, a stop may be faster than any smooth corner.
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

    /// The corners that have these cuts, one per way point.
    pub(crate) fn with_cuts(&self, limits: &MotionLimits, cuts: &[Cuts]) -> Vec<RoundedCorner> {
        let corners = PathCurve::corners(self.waypoints, &limits.velocity).into_iter();
        let rounded = corners.filter(|corner| cuts[corner.waypoint][0] > 0.0);
        rounded.map(|corner| corner.rounded(cuts[corner.waypoint])).collect()
    }

    /// Improves what each corner cuts off its edges: 2. of [`Self::rounded`]. Cuts that are larger than `proven` are proven
    /// first; smaller ones are not yet.
    fn descend(
        &self,
        limits: &MotionLimits,
        corners: &[Corner],
        [cuts, proven]: [&mut [Cuts]; 2],
        least_s: &mut f64,
        accepts: &mut impl FnMut(&Corner, Cuts) -> bool,
    ) {
        const MOST_ROUNDS: usize = 4;
        /// A round that saves less than this share of the time is the last; for less no proof is tried.
        const LEAST_GAIN: f64 = 1e-3;
        /// A corner whose size changes the time by less than this share is left as it is.
        const NO_CHANGE: f64 = 1e-6;
        for round in 0..MOST_ROUNDS {
            let before_s = *least_s;
            for (index, corner) in corners.iter().enumerate() {
                // What its neighbours leave of its edges.
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

    /// The duration with these cuts, but for limits of the speed of the tool and of the drives: costly to bound, they limit the
    /// same edges whatever the corners.
    ///
    /// Infinite where uneven corners add up to a scale of `s` with which rounding would be felt.
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

/// Most halvings of a corner that descent made smaller than a proven one, and that is not proven itself.
const FINAL_HALVINGS: i32 = 4;

/// Factors of both cuts of a corner that are tried.
const STEPS: &[[f64; 2]] = &[[1.25, 1.0], [1.0, 1.25], [0.8, 1.0], [1.0, 0.8], [0.8, 0.8], [1.25, 1.25]];

/// Factors that are tried in the first round.
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

/// The law of time along a curve by a method.
pub(crate) fn law(curve: &PathCurve, method: TimingMethod, limits: &[PieceLimits]) -> TimeLaw {
    match method {
        TimingMethod::TimeOptimal => time_optimal(curve, limits),
        TimingMethod::JerkLimited => s_curve(curve, limits),
    }
}

/// The greatest found share of its edges up to a half with which a corner is proven; 0 for none.
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
