use cranny_grasp::GraspSet;
use cranny_robot::Robot;
use serde::{Deserialize, Serialize};
use strum::EnumString;

use crate::joint_metric::JointMetric;
use crate::{MotionLimits, PlanError, Problem, TimingMethod, Trajectory};

/// What is measured of a path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, EnumString)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
pub enum CostKind {
    /// Its length in the metric weighted by reach: a joint weighs as many metres as it moves the farthest point beyond
    /// it per radian, at most 1, and a prismatic joint 1.
    #[default]
    Length,
    /// Its plain L2 length, metres and radians alike.
    L2,
    /// The seconds of the time-optimal trajectory along it, which stops where the path turns.
    Time,
}

/// What a path costs: what is measured of it, minus the score of its grasp times a weight.
///
/// Laws: a path costs the same forwards and backwards, and a way point on a straight edge adds nothing (test
/// `a_detour_costs_and_a_way_point_on_the_way_does_not`).
#[derive(Clone, Debug, PartialEq)]
pub struct PathCost {
    /// By which a search is bounded; it tells lengths from each other as the measure does, or nearly so.
    metric: JointMetric,
    /// Where time is measured.
    limits: Option<MotionLimits>,
    score_weight: f64,
}

impl PathCost {
    /// The cost of paths of `robot`, with `score_weight` for a score of 1, in the unit of the measure.
    ///
    /// # Errors
    /// [`PlanError::ScoreWeight`] unless the weight is finite and at least 0; those of [`MotionLimits::of`] for
    /// [`CostKind::Time`].
    pub fn new(robot: &Robot, kind: CostKind, score_weight: f64) -> Result<Self, PlanError> {
        if !(score_weight.is_finite() && score_weight >= 0.0) {
            return Err(PlanError::ScoreWeight { weight: score_weight });
        }
        let limits = match kind {
            CostKind::Time => Some(MotionLimits::of(robot, TimingMethod::TimeOptimal)?),
            CostKind::Length | CostKind::L2 => None,
        };
        let metric = match (kind, &limits) {
            (CostKind::L2, _) => JointMetric::plain(robot.dof()),
            (_, Some(limits)) => JointMetric::by_speed(limits),
            (_, None) => JointMetric::by_reach(robot),
        };
        Ok(Self { metric, limits, score_weight })
    }

    /// What is measured of a path.
    ///
    /// # Errors
    /// Those of [`Trajectory::along`] where time is measured.
    pub fn measure(&self, path: &[Vec<f64>]) -> Result<f64, PlanError> {
        match &self.limits {
            Some(limits) => Ok(Trajectory::along(path, limits)?.duration_s()),
            None => Ok(self.length(path)),
        }
    }

    /// The cost of a path to a grasp of this score in [0, 1]; a grasp without a score counts as 0.
    ///
    /// # Errors
    /// As [`Self::measure`].
    pub fn of(&self, path: &[Vec<f64>], score: Option<f64>) -> Result<f64, PlanError> {
        Ok(self.measure(path)? - self.reward(score))
    }

    /// The length of a path in the metric of a search.
    fn length(&self, path: &[Vec<f64>]) -> f64 {
        path.windows(2).map(|edge| self.metric.distance(&edge[0], &edge[1])).fold(0.0, |sum, x| sum + x)
    }

    pub(crate) fn metric(&self) -> &JointMetric {
        &self.metric
    }

    /// What a grasp of score 1 is worth.
    pub(crate) fn score_weight(&self) -> f64 {
        self.score_weight
    }

    /// What paths to each grasp of a problem cost beside their length, counted from the best there can be.
    pub(crate) fn of_grasps(&self, problem: &Problem) -> Vec<f64> {
        let set = problem.grasps().map_or(&[][..], GraspSet::grasps);
        set.iter().map(|grasp| self.score_weight - self.reward(grasp.score)).collect()
    }

    /// What a path like this costs a search, whose goals cost as [`Self::of_grasps`] says: its length in the metric of the
    /// search, and what its grasp costs.
    pub(crate) fn search_bound(&self, path: &[Vec<f64>], score: Option<f64>) -> f64 {
        self.length(path) - self.reward(score) + self.score_weight
    }

    fn reward(&self, score: Option<f64>) -> f64 {
        self.score_weight * score.unwrap_or(0.0)
    }
}
