use cranny_spatial::Stream;
use cranny_task::RoundedCorner;

use crate::timing::motion_limits::MotionLimits;
use crate::timing::path_curve::Cuts;
use crate::timing::rounding::{CurveProof, CurvedPath};

/// Way points and rounded corners of a path.
#[derive(Clone, Debug, PartialEq)]
pub struct RefinedPath {
    /// Way points, one value per joint each (m, rad).
    pub waypoints: Vec<Vec<f64>>,
    /// Rounded corners, by their way points, ascending.
    pub corners: Vec<RoundedCorner>,
}

/// Initial and minimum step of way points, in seconds at full speed of the fastest joint.
const FIRST_STEP_S: f64 = 0.1;
const LEAST_STEP_S: f64 = 2e-3;

/// Steps tried along a direction, as factors of the last successful step.
const FACTORS: [f64; 4] = [2.0, 1.0, 0.5, 0.25];

/// Maximum number of rounds over all way points; a round that saves less than `LEAST_GAIN` of the time is the last.
const MOST_ROUNDS: usize = 12;
const LEAST_GAIN: f64 = 2e-3;

/// Maximum number of proofs per step, and minimum share of the time that a step must save for a proof.
const MOST_PROOFS: usize = 2;
const WORTH_A_PROOF: f64 = 1e-3;

/// Maximum number of sideways steps tried at an obstacle, and their size as a share of the step.
const MOST_ASIDE: usize = 3;
const ASIDE: f64 = 0.5;

impl CurvedPath<'_> {
    /// Returns the path with rounded corners ([`Self::rounded`]) and with way points moved to reduce the duration: gradient
    /// descent at each way point for which `may_move` is true, one after the other. The edges and corners of each step are
    /// proven before it is taken.
    pub fn refined(
        &self,
        limits: &MotionLimits,
        may_move: impl Fn(usize) -> bool,
        proof: &mut impl CurveProof,
    ) -> RefinedPath {
        let corners = self.rounded(limits, |at, points| proof.corner(at, points));
        let refined = RefinedPath { waypoints: self.waypoints.to_vec(), corners };
        if refined.corners.is_empty() {
            return refined;
        }
        let movable: Vec<usize> = (1..self.waypoints.len().saturating_sub(1))
            .filter(|at| may_move(*at) && refined.corners.iter().any(|corner| corner.waypoint == *at))
            .collect();
        let mut descent = Descent::new(self, limits, &refined);
        let mut steps_s = vec![FIRST_STEP_S; self.waypoints.len()];
        for _ in 0..MOST_ROUNDS {
            let before_s = descent.least_s;
            for &at in &movable {
                if steps_s[at] >= LEAST_STEP_S {
                    steps_s[at] = descent.step(at, steps_s[at], proof);
                }
            }
            if before_s - descent.least_s < LEAST_GAIN * before_s {
                break;
            }
        }
        let known = refined.corners;
        let proven = |corner: RoundedCorner| {
            let at = corner.waypoint;
            let same = known.iter().find(|known| known.waypoint == at && !descent.is_touched[at]);
            same.cloned().unwrap_or(corner)
        };
        RefinedPath {
            corners: descent.corners().into_iter().map(proven).collect(),
            waypoints: descent.waypoints,
        }
    }
}

/// Path whose way points move.
struct Descent<'a> {
    path: &'a CurvedPath<'a>,
    limits: &'a MotionLimits,
    waypoints: Vec<Vec<f64>>,
    /// Shares of both edges that the corner at each way point cuts off; 0 for none.
    shares: Vec<[f64; 2]>,
    least_s: f64,
    /// True for each way point whose corner has changed.
    is_touched: Vec<bool>,
    random: Stream,
}

impl<'a> Descent<'a> {
    fn new(path: &'a CurvedPath<'a>, limits: &'a MotionLimits, refined: &RefinedPath) -> Self {
        let waypoints = refined.waypoints.clone();
        let mut shares = vec![[0.0; 2]; waypoints.len()];
        for corner in &refined.corners {
            let [before, here, after] = [0, 1, 2].map(|k| &waypoints[corner.waypoint + k - 1]);
            shares[corner.waypoint] = [corner.share_before(before, here), corner.share_after(here, after)];
        }
        let is_touched = vec![false; waypoints.len()];
        let random = Stream::new(0, 0);
        let mut descent =
            Self { path, limits, waypoints, shares, least_s: f64::INFINITY, is_touched, random };
        descent.least_s = descent.duration_s();
        descent
    }

    fn length_s(&self, edge: usize) -> f64 {
        let ends = self.waypoints[edge].iter().zip(&self.waypoints[edge + 1]);
        ends.zip(&self.limits.velocity).map(|((a, b), v)| (b - a).abs() / v).fold(0.0, f64::max)
    }

    fn cuts(&self) -> Vec<Cuts> {
        let of = |(at, [before, after]): (usize, &[f64; 2])| {
            if *before > 0.0 { [before * self.length_s(at - 1), after * self.length_s(at)] } else { [0.0; 2] }
        };
        self.shares.iter().enumerate().map(of).collect()
    }

    fn duration_s(&self) -> f64 {
        let path = CurvedPath { waypoints: &self.waypoints, ..*self.path };
        path.duration_s(self.limits, &self.cuts())
    }

    /// Returns the duration with way point `at` moved to `q`.
    fn duration_at_s(&mut self, at: usize, q: &[f64]) -> f64 {
        let was = std::mem::replace(&mut self.waypoints[at], q.to_vec());
        let duration_s = self.duration_s();
        self.waypoints[at] = was;
        duration_s
    }

    /// Returns the direction of steepest descent at a way point (m, rad; one per joint), scaled so that the fastest joint takes
    /// a second; `None` if the duration does not change.
    fn direction(&mut self, at: usize) -> Option<Vec<f64>> {
        /// Step of the difference quotient, in seconds at full speed.
        const STEP_S: f64 = 1e-3;
        /// Minimum slope that counts.
        const LEAST_SLOPE: f64 = 1e-3;
        let here = self.waypoints[at].clone();
        let velocity = self.limits.velocity.clone();
        let mut slope = |joint: usize| {
            let mut q = here.clone();
            q[joint] += STEP_S * velocity[joint];
            (self.duration_at_s(at, &q) - self.least_s) / STEP_S
        };
        let slopes: Vec<f64> = (0..here.len()).map(&mut slope).collect();
        let greatest = slopes.iter().map(|slope| slope.abs()).fold(0.0, f64::max);
        let is_felt = greatest > LEAST_SLOPE && greatest.is_finite();
        is_felt.then(|| slopes.iter().zip(&velocity).map(|(slope, v)| -slope / greatest * v).collect())
    }

    /// Moves a way point, if that saves time and is proven, and returns the next step to try, in seconds.
    fn step(&mut self, at: usize, step_s: f64, proof: &mut impl CurveProof) -> f64 {
        let Some(direction) = self.direction(at) else { return 0.0 };
        let here = self.waypoints[at].clone();
        let moved =
            |step_s: f64| here.iter().zip(&direction).map(|(q, d)| q + step_s * d).collect::<Vec<f64>>();
        let tried = FACTORS.map(|factor| factor * step_s);
        let mut tried: Vec<(f64, f64)> =
            tried.into_iter().map(|step_s| (self.duration_at_s(at, &moved(step_s)), step_s)).collect();
        tried.sort_by(|a, b| a.0.total_cmp(&b.0));
        let enough_s = self.least_s * (1.0 - WORTH_A_PROOF);
        let mut longest_s = f64::INFINITY;
        let mut proofs = 0;
        for (duration_s, step_s) in tried {
            if duration_s >= enough_s || step_s > longest_s || proofs == MOST_PROOFS {
                continue;
            }
            proofs += 1;
            if self.takes(at, (moved(step_s), duration_s), proof) {
                return step_s;
            }
            longest_s = step_s;
        }
        // Random sideways steps may pass the obstacle with joints that do not affect the duration.
        if longest_s.is_finite() {
            for _ in 0..MOST_ASIDE {
                let aside: Vec<f64> = self
                    .limits
                    .velocity
                    .iter()
                    .map(|v| v * ASIDE * longest_s * self.random.normal())
                    .collect();
                let q: Vec<f64> =
                    moved(0.5 * longest_s).iter().zip(&aside).map(|(q, aside)| q + aside).collect();
                let duration_s = self.duration_at_s(at, &q);
                if duration_s < enough_s && self.takes(at, (q, duration_s), proof) {
                    return longest_s;
                }
            }
        }
        0.5 * step_s
    }

    /// Moves a way point and records the new duration, if the new edges and corners are proven.
    fn takes(&mut self, at: usize, (q, duration_s): (Vec<f64>, f64), proof: &mut impl CurveProof) -> bool {
        let was = std::mem::replace(&mut self.waypoints[at], q);
        let is_taken = self.is_proven(at, proof);
        if is_taken {
            self.least_s = duration_s;
            self.is_touched[at - 1..=at + 1].fill(true);
        } else {
            self.waypoints[at] = was;
        }
        is_taken
    }

    /// Returns true if all edges and corners that a way point affects are proven.
    fn is_proven(&self, at: usize, proof: &mut impl CurveProof) -> bool {
        let edge = |edge: usize| [&self.waypoints[edge][..], &self.waypoints[edge + 1][..]];
        let corners = self.corners();
        let mut near = corners.iter().filter(|corner| corner.waypoint.abs_diff(at) <= 1);
        [at - 1, at].into_iter().all(|index| proof.edge(index, edge(index)))
            && near.all(|corner| proof.corner(corner.waypoint, &corner.control_points))
    }

    fn corners(&self) -> Vec<RoundedCorner> {
        CurvedPath { waypoints: &self.waypoints, ..*self.path }.with_cuts(self.limits, &self.cuts())
    }
}
