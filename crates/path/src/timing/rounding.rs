use cranny_robot::Robot;
use cranny_task::RoundedCorner;

use crate::timing::motion_limits::{MotionLimits, TimingMethod};
use crate::timing::path_curve::PathCurve;
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
}

impl<'a> CurvedPath<'a> {
    /// A path with a stop at each corner, through way points (m, rad; one value per joint).
    pub fn stopping(waypoints: &'a [Vec<f64>]) -> Self {
        Self { waypoints, corners: &[], paces: &[], robot: None }
    }

    /// Its corners, each as large as serves the time best among the sizes that `proven` accepts: greatest first, then halved,
    /// with two steps of bisection. `proven` is given a way point and the control points of a corner there
    /// ([`RoundedCorner`]; m, rad; one value per joint). Corners of this path are disregarded.
    ///
    /// Under limits of jerk a large corner is run through faster, but leaves less of its edges to gain speed on. So smaller
    /// sizes are tried, one corner after the other, as long as the whole takes less time. Where the path turns back, a stop
    /// is faster than any smooth corner.
    pub fn rounded(
        &self,
        limits: &MotionLimits,
        mut proven: impl FnMut(usize, &[Vec<f64>; 5]) -> bool,
    ) -> Vec<RoundedCorner> {
        let velocity = &limits.velocity;
        let made = |at: usize, [before, corner, after]: &[Vec<f64>; 3]| {
            RoundedCorner::new(at, [before, corner, after])
        };
        let mut accepts = |at: usize, points: &[Vec<f64>; 3]| proven(at, &made(at, points).control_points);
        let greatest = PathCurve::radii(self.waypoints, velocity, |at, points, greatest| {
            proven_radius(greatest, |r| accepts(at, &points(r)))
        });
        let radii = self.fastest(limits, &greatest);
        let mut corners = Vec::new();
        PathCurve::radii(self.waypoints, velocity, |at, points, _| {
            let is_proven = radii[at] <= 0.0 || radii[at] >= greatest[at] || accepts(at, &points(radii[at]));
            let radius = if is_proven { radii[at] } else { greatest[at] };
            if radius > 0.0 {
                corners.push(made(at, &points(radius)));
            }
            radius
        });
        corners
    }

    /// Radii up to `greatest` with which the path takes the least time that descent along one after the other finds.
    fn fastest(&self, limits: &MotionLimits, greatest: &[f64]) -> Vec<f64> {
        const ROUNDS: usize = 2;
        let shares = match limits.method {
            TimingMethod::TimeOptimal => &[1.0, 0.0][..],
            TimingMethod::JerkLimited => &[1.0, 0.7, 0.4, 0.2, 0.08, 0.0],
        };
        let duration_s = |radii: &[f64]| {
            let curve = PathCurve::along(self.waypoints, &limits.velocity, radii);
            // The speed of the tool, costly to bound, limits the same edges whatever the corners.
            law(&curve, limits.method, &PieceLimits::all_of(&curve, limits, self.paces, None)).duration_s
        };
        let mut radii = greatest.to_vec();
        let mut least_s = duration_s(&radii);
        for _ in 0..ROUNDS {
            for index in (0..radii.len()).filter(|index| greatest[*index] > 0.0) {
                for share in shares {
                    let before = std::mem::replace(&mut radii[index], share * greatest[index]);
                    let found_s = duration_s(&radii);
                    if found_s < least_s { least_s = found_s } else { radii[index] = before }
                }
            }
        }
        radii
    }
}

/// The law of time along a curve by a method.
pub(crate) fn law(curve: &PathCurve, method: TimingMethod, limits: &[PieceLimits]) -> TimeLaw {
    match method {
        TimingMethod::TimeOptimal => time_optimal(curve, limits),
        TimingMethod::JerkLimited => s_curve(curve, limits),
    }
}

/// The greatest found radius up to `greatest` that is proven; 0 for none.
fn proven_radius(greatest: f64, mut is_proven: impl FnMut(f64) -> bool) -> f64 {
    const HALVINGS: usize = 6;
    const BISECTIONS: usize = 2;
    let mut radius = greatest;
    for halving in 0..=HALVINGS {
        if is_proven(radius) {
            let (mut proven, mut unproven) = (radius, 2.0 * radius);
            for _ in 0..if halving == 0 { 0 } else { BISECTIONS } {
                let middle = 0.5 * (proven + unproven);
                if is_proven(middle) { proven = middle } else { unproven = middle }
            }
            return proven;
        }
        radius *= 0.5;
    }
    0.0
}
