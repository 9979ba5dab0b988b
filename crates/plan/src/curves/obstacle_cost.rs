use cranny_collision::{Cell, Collider, PairDistance, Scratch};
use cranny_robot::LinkFrames;
use cranny_spatial::{Point, Pose, Vector};
use serde::{Deserialize, Serialize};

use crate::{PlanError, Ranges};

/// Distances below which a pair costs something, beyond the demanded ones.
// Unknown keys are refused when a planner is created; the planners flatten these settings into their own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CostRange {
    /// Distance of links from the world, in metres. Default 0.2, as in the code of OMG-Planner.
    pub epsilon_m: f64,
    /// Distance of the hand from the target and its supports, in metres. Default 0.02: a hand at a grasp is near them, and OMG's
    /// 0.1 would push it away.
    pub grasp_epsilon_m: f64,
    /// Distance between links, in metres. Default 0.03: links of a folded arm are always near each other.
    pub own_epsilon_m: f64,
}

impl Default for CostRange {
    fn default() -> Self {
        Self { epsilon_m: 0.2, grasp_epsilon_m: 0.02, own_epsilon_m: 0.03 }
    }
}

impl CostRange {
    /// Checks the ranges of the settings.
    pub(crate) fn check(&self, ranges: Ranges) -> Result<Ranges, PlanError> {
        ranges
            .positive("epsilon_m", self.epsilon_m)?
            .positive("grasp_epsilon_m", self.grasp_epsilon_m)?
            .positive("own_epsilon_m", self.own_epsilon_m)
    }

    fn of(&self, pair: &PairDistance) -> f64 {
        match pair.second {
            Collider::Link(_) => self.own_epsilon_m,
            Collider::Body(_) if pair.is_of_grasp => self.grasp_epsilon_m,
            Collider::Body(_) => self.epsilon_m,
        }
    }

    fn greatest_m(&self) -> f64 {
        self.epsilon_m.max(self.grasp_epsilon_m).max(self.own_epsilon_m)
    }
}

/// Cost of a distance `d` (m) and its derivative: `−d + ε/2` below 0, `(d − ε)²/2ε` up to ε, 0 beyond (Zucker et al. 2013, eq. 21).
pub(crate) fn potential(d: f64, epsilon_m: f64) -> (f64, f64) {
    if d >= epsilon_m {
        (0.0, 0.0)
    } else if d >= 0.0 {
        let short = d - epsilon_m;
        (short * short / (2.0 * epsilon_m), short / epsilon_m)
    } else {
        (0.5 * epsilon_m - d, -1.0)
    }
}

/// Cost of the nearness of obstacles along a curve, `Σ c(d)·‖ẋ‖` over way points and pairs, with `x` the closest point of the
/// link and `d` the certified distance beyond the demanded one.
///
/// Source: Zucker et al. 2013, §3.2 and eq. 24. The publication sums over points of the links in a distance field; here each pair
/// of a link with another link or a part of the world counts, at its closest points. The motion of two links is that of one
/// relative to the other.
pub(crate) struct ObstacleCost<'a> {
    cell: &'a Cell,
    range: CostRange,
    step_s: f64,
    scratch: Scratch,
    frames: Vec<LinkFrames>,
    pairs: Vec<Vec<PairDistance>>,
}

impl<'a> ObstacleCost<'a> {
    pub fn new(cell: &'a Cell, range: CostRange, step_s: f64) -> Self {
        Self { cell, range, step_s, scratch: cell.scratch(), frames: Vec::new(), pairs: Vec::new() }
    }

    /// Writes the cost of each way point (m, rad; one value per joint) to `costs`, and adds `weight` times the functional gradient to the rows of `gradient`, the
    /// first of which is that of way point 1. The first and the last way point cost nothing.
    pub fn measure(
        &mut self,
        path: &[Vec<f64>],
        costs: &mut Vec<f64>,
        mut gradient: Option<(f64, &mut [Vec<f64>])>,
    ) {
        let Self { cell, range, step_s, scratch, frames, pairs } = self;
        let robot = cell.robot().as_ref();
        frames.resize_with(path.len(), || robot.frames());
        pairs.resize_with(path.len(), Vec::new);
        for ((q, frames), pairs) in path.iter().zip(&mut *frames).zip(&mut *pairs) {
            cell.pair_distances(q, range.greatest_m(), scratch, pairs);
            frames.clone_from(scratch.frames());
        }
        costs.clear();
        costs.resize(path.len(), 0.0);
        for index in 1..path.len().max(1) - 1 {
            let around = [&frames[index - 1], &frames[index], &frames[index + 1]];
            for pair in &pairs[index] {
                let (cost, slope) = potential(pair.distance_m - pair.required_m, range.of(pair));
                if cost <= 0.0 {
                    continue;
                }
                let Some(motion) = Motion::of(pair, around, *step_s) else { continue };
                costs[index] += cost * motion.speed;
                if let Some((weight, rows)) = &mut gradient
                    && let Some(row) = rows.get_mut(index - 1)
                {
                    // Only the part across the motion counts: along it, a push would change the timing alone.
                    let steep = motion.across(&(pair.normal * slope)) - motion.curvature * cost;
                    pair.add_motion(robot, around[1], &(steep * motion.speed * *weight), row);
                }
            }
        }
    }
}

/// Motion of the closest point of a link, relative to the other of the pair.
struct Motion {
    speed: f64,
    direction: Vector,
    /// Curvature vector of the path of the point, in 1/m.
    curvature: Vector,
}

impl Motion {
    /// Returns the motion by central differences; `None` for a point that rests.
    fn of(pair: &PairDistance, around: [&LinkFrames; 3], step_s: f64) -> Option<Self> {
        /// Speed below which a point counts as resting, in metres per second.
        const RESTING: f64 = 1e-6;
        let now = around[1];
        let place = |frames: &LinkFrames| {
            let moved = |link: usize, point: &Point| {
                let now_from_link: &Pose = now.link(link);
                (frames.link(link) * now_from_link.inverse_transform_point(point)).coords
            };
            let of_second = match pair.second {
                Collider::Link(second) => moved(second, &pair.on_second),
                Collider::Body(_) => Vector::zeros(),
            };
            moved(pair.link, &pair.on_link) - of_second
        };
        let [before, here, after] = around.map(place);
        let velocity = (after - before) / (2.0 * step_s);
        let speed = velocity.norm();
        if speed < RESTING {
            return None;
        }
        let direction = velocity / speed;
        let acceleration = (after - here * 2.0 + before) / (step_s * step_s);
        let mut motion = Self { speed, direction, curvature: Vector::zeros() };
        motion.curvature = motion.across(&acceleration) / (speed * speed);
        Some(motion)
    }

    /// Returns the part of a vector across the motion.
    fn across(&self, vector: &Vector) -> Vector {
        vector - self.direction * self.direction.dot(vector)
    }
}

#[cfg(test)]
mod tests {
    use super::potential;

    #[test]
    fn the_potential_has_the_slope_of_its_finite_differences() {
        const STEP: f64 = 1e-6;
        let at = |d: f64| potential(d, 0.2).0;
        for d in [-0.1, -1e-3, 1e-3, 0.05, 0.199, 0.3] {
            let slope = (at(d + STEP) - at(d - STEP)) / (2.0 * STEP);
            assert!((slope - potential(d, 0.2).1).abs() < 1e-5, "{d}");
        }
    }
}
