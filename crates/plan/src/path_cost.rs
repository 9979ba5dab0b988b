use cranny_robot::Robot;

use crate::PlanError;
use crate::joint_metric::JointMetric;

/// What a path costs: its length in the metric weighted by reach (a joint weighs as many metres as it moves
/// the farthest point beyond it per radian, at most 1, and a prismatic joint 1), minus the score of its grasp
/// times a weight.
///
/// Laws: `length(path) = length(path backwards)`, and a way point on a straight edge adds nothing (test
/// `a_detour_costs_and_a_way_point_on_the_way_does_not`).
#[derive(Clone, Debug, PartialEq)]
pub struct PathCost {
    metric: JointMetric,
    score_weight: f64,
}

impl PathCost {
    /// The cost of paths of `robot`, with `score_weight` for a score of 1.
    ///
    /// # Errors
    /// [`PlanError::ScoreWeight`] unless the weight is finite and at least 0.
    pub fn new(robot: &Robot, score_weight: f64) -> Result<Self, PlanError> {
        if !(score_weight.is_finite() && score_weight >= 0.0) {
            return Err(PlanError::ScoreWeight { weight: score_weight });
        }
        Ok(Self { metric: JointMetric::by_reach(robot), score_weight })
    }

    /// The length of a path in the metric weighted by reach.
    pub fn length(&self, path: &[Vec<f64>]) -> f64 {
        path.windows(2).map(|edge| self.metric.distance(&edge[0], &edge[1])).fold(0.0, |sum, x| sum + x)
    }

    /// The cost of a path to a grasp of this score in [0, 1]; a grasp without a score counts as 0.
    pub fn of(&self, path: &[Vec<f64>], score: Option<f64>) -> f64 {
        self.length(path) - self.reward(score)
    }

    pub(crate) fn reward(&self, score: Option<f64>) -> f64 {
        self.score_weight * score.unwrap_or(0.0)
    }
}
