use std::sync::Arc;

use cranny_collision::{Cell, Scratch};
use cranny_grasp::GraspSet;
use cranny_robot::{Robot, between};
use cranny_spatial::PoseDifference;
use cranny_task::Problem;
use serde::{Deserialize, Serialize};
use strum::{EnumString, IntoStaticStr};

use crate::audit::end_score;
use crate::joint_metric::JointMetric;
use crate::{MotionLimits, PathError, TimingMethod, Trajectory};

/// Measure of the cost of a path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, EnumString, IntoStaticStr)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
pub enum CostKind {
    /// Path length in the metric weighted by reach ([`JointMetric::by_reach`]).
    #[default]
    Length,
    /// Plain L2 length of the path, metres and radians alike.
    L2,
    /// Duration in seconds of the time-optimal trajectory along the path, which stops where the path turns.
    Time,
    /// Path length in the metric weighted by reach, counted up to eleven times where the robot is within 20 mm of the world:
    /// [`Self::PENALTY`], [`Self::DESIRED_CLEARANCE_M`].
    Clearance,
    /// Path length of the origin of the gripper frame, in metres.
    Tool,
    /// Angle by which the gripper frame, with any held object, turns along the path, in radians.
    Turn,
    /// Path length in the metric weighted by reach, plus [`Self::CORNER_M`] per straight piece, which favours few corners.
    Smooth,
    /// Duration in seconds of the time-optimal trajectory along the path, plus [`Self::TOOL_S_PER_M`] for the length of the
    /// tool path and [`Self::TURN_S_PER_RAD`] for its rotation.
    Mix,
}

impl CostKind {
    /// Cost of a straight piece of the path under [`Self::Smooth`], in metres.
    pub const CORNER_M: f64 = 0.5;
    /// Cost of a metre of the tool path under [`Self::Mix`], in seconds.
    pub const TOOL_S_PER_M: f64 = 1.0;
    /// Cost of a radian of tool rotation under [`Self::Mix`], in seconds.
    pub const TURN_S_PER_RAD: f64 = 0.3;

    /// Desired clearance from the world under [`Self::Clearance`], in metres: more than the errors of a calibrated arm, less
    /// than the openings that it must pass.
    pub const DESIRED_CLEARANCE_M: f64 = 0.02;
    /// Relative penalty of a motion in contact under [`Self::Clearance`]: its cost is its length times one plus this factor.
    pub const PENALTY: f64 = 10.0;

    /// Returns the name used in files and on the command line.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// Cost of a path: its measure minus the weighted score of its grasp.
///
/// Laws: a path costs the same forwards and backwards. A way point on a straight edge adds nothing, except for clearances and
/// tool paths, which are sampled (test `a_detour_costs_and_a_way_point_on_the_way_does_not`).
#[derive(Clone, Debug)]
pub struct PathCost {
    /// Metric that bounds a search; under tool costs it orders paths differently from the measure.
    metric: JointMetric,
    /// Motion limits, for kinds that measure time.
    limits: Option<MotionLimits>,
    /// Collision model, for kinds that measure clearance.
    cell: Option<Arc<Cell>>,
    /// Cost of the tool path, for kinds that include it.
    tool: Option<ToolCost>,
    /// Cost of each straight piece in addition to its length.
    per_piece: f64,
    score_weight: f64,
}

/// Weights of the path of the gripper frame of a robot.
#[derive(Clone, Debug)]
struct ToolCost {
    robot: Arc<Robot>,
    per_m: f64,
    per_rad: f64,
    metric: JointMetric,
}

impl ToolCost {
    /// Returns the cost of a straight edge: the sum over chords between samples.
    fn of_edge(&self, a: &[f64], b: &[f64]) -> f64 {
        /// Spacing of the samples in the metric by reach, in metres.
        const SPACING_M: f64 = 0.05;
        /// Maximum number of chords per edge.
        const MOST: f64 = 1000.0;
        let count = (self.metric.distance(a, b) / SPACING_M).ceil().clamp(1.0, MOST);
        let mut frames = self.robot.frames();
        let mut tip = |at: f64| {
            self.robot.tip_kinematics(&between(a, b, at).collect::<Vec<f64>>(), &mut frames);
            *frames.link(self.robot.tip())
        };
        let (mut before, mut total, mut at) = (tip(0.0), 0.0, 1.0);
        while at <= count {
            let here = tip((at / count).min(1.0));
            let PoseDifference { translation_m, rotation_rad } = PoseDifference::between(&before, &here);
            total += self.per_m * translation_m + self.per_rad * rotation_rad;
            (before, at) = (here, at + 1.0);
        }
        total
    }
}

impl PathCost {
    /// Creates the cost of paths for the robot of a problem. A score of 1 is worth `score_weight`, in the unit of the measure.
    ///
    /// # Errors
    /// [`PathError::ScoreWeight`] unless the weight is finite and at least 0; those of [`MotionLimits::of`] for
    /// [`CostKind::Time`] and [`CostKind::Mix`]; [`TaskError::Goal`](cranny_task::TaskError::Goal) for [`CostKind::Clearance`]
    /// under a criterion other than `exact`.
    pub fn new(problem: &Problem, kind: CostKind, score_weight: f64) -> Result<Self, PathError> {
        if !(score_weight.is_finite() && score_weight >= 0.0) {
            return Err(PathError::ScoreWeight { weight: score_weight });
        }
        let robot = problem.robot();
        let limits = match kind {
            CostKind::Time | CostKind::Mix => Some(MotionLimits::of(robot, TimingMethod::TimeOptimal)?),
            _ => None,
        };
        let cell = match kind {
            CostKind::Clearance => Some(problem.exact_cell("cost")?.clone()),
            _ => None,
        };
        let worth = match kind {
            CostKind::Tool => Some([1.0, 0.0]),
            CostKind::Turn => Some([0.0, 1.0]),
            CostKind::Mix => Some([CostKind::TOOL_S_PER_M, CostKind::TURN_S_PER_RAD]),
            _ => None,
        };
        let tool = worth.map(|[per_m, per_rad]| ToolCost {
            robot: robot.clone(),
            per_m,
            per_rad,
            metric: JointMetric::by_reach(robot),
        });
        let metric = match (kind, &limits) {
            (CostKind::L2, _) => JointMetric::plain(robot.dof()),
            (_, Some(limits)) => JointMetric::by_speed(limits),
            (_, None) => JointMetric::by_reach(robot),
        };
        let per_piece = if kind == CostKind::Smooth { CostKind::CORNER_M } else { 0.0 };
        Ok(Self { metric, limits, cell, tool, per_piece, score_weight })
    }

    /// Returns the measure of a path of way points (m, rad; one value per joint), in the unit of its [`CostKind`].
    ///
    /// # Errors
    /// Those of [`Trajectory::along`] if time is measured.
    pub fn measure(&self, path: &[Vec<f64>]) -> Result<f64, PathError> {
        match (&self.limits, &self.cell) {
            (Some(limits), _) => {
                let tool = self
                    .tool
                    .iter()
                    .flat_map(|tool| path.windows(2).map(|edge| tool.of_edge(&edge[0], &edge[1])));
                Ok(Trajectory::along(path, limits)?.duration_s() + sum(tool))
            }
            (None, Some(cell)) => {
                let mut scratch = cell.scratch();
                Ok(sum(path.windows(2).map(|edge| self.of_edge(&edge[0], &edge[1], &mut scratch))))
            }
            (None, None) => {
                let edges = sum(path.windows(2).map(|edge| self.least_of_edge(&edge[0], &edge[1])));
                Ok(edges - self.per_piece * self.passed(path) as f64)
            }
        }
    }

    /// Returns the cost of a path of way points (m, rad; one value per joint) to a grasp with this score in [0, 1]; a grasp
    /// without a score counts as 0.
    ///
    /// # Errors
    /// As [`Self::measure`].
    pub fn of(&self, path: &[Vec<f64>], score: Option<f64>) -> Result<f64, PathError> {
        Ok(self.measure(path)? - self.reward(score))
    }

    /// Returns a lower bound of [`Self::of_edge`], which is exact unless [`Self::is_of_the_world`].
    pub(crate) fn least_of_edge(&self, a: &[f64], b: &[f64]) -> f64 {
        let tool = self.tool.as_ref().map(|tool| tool.of_edge(a, b));
        match (&self.limits, tool) {
            (Some(limits), tool) => rest_to_rest_s(a, b, limits) + tool.unwrap_or(0.0),
            (None, Some(tool)) => tool,
            (None, None) => self.metric.distance(a, b) + self.per_piece,
        }
    }

    /// Returns the number of way points between the ends of a path at which it does not turn.
    fn passed(&self, path: &[Vec<f64>]) -> usize {
        /// Relative excess of the length over the straight line, due to rounding, up to which a path does not turn.
        const SAME: f64 = 1e-12;
        let is_passed = |way: &&[Vec<f64>]| {
            let [before, here, after] = way else { return false };
            let by_way = self.metric.distance(before, here) + self.metric.distance(here, after);
            by_way <= self.metric.distance(before, after) * (1.0 + SAME)
        };
        path.windows(3).filter(is_passed).count()
    }

    /// Returns true if a path costs more the closer it comes to the world.
    pub(crate) fn is_of_the_world(&self) -> bool {
        self.cell.is_some()
    }

    /// Returns the cost that a straight edge adds to a path that turns at both ends. `scratch` is from a cell of the problem.
    pub(crate) fn of_edge(&self, a: &[f64], b: &[f64], scratch: &mut Scratch) -> f64 {
        let length = self.least_of_edge(a, b);
        let Some(cell) = &self.cell else { return length };
        /// Spacing of the samples at which clearances are measured, by reach, in metres.
        const SPACING: f64 = 2.0 * CostKind::DESIRED_CLEARANCE_M;
        /// Maximum number of samples per edge, for robots with long prismatic joints.
        const MOST: f64 = 1000.0;
        let count = (length / SPACING).ceil().clamp(1.0, MOST);
        let shortfall =
            |clearance_m: f64| 1.0 - (clearance_m / CostKind::DESIRED_CLEARANCE_M).clamp(0.0, 1.0);
        let (mut total, mut at, mut q) = (0.0, 0.5, Vec::with_capacity(a.len()));
        while at < count {
            q.clear();
            q.extend(between(a, b, at / count));
            total += shortfall(cell.world_clearance(&q, CostKind::DESIRED_CLEARANCE_M, scratch));
            at += 1.0;
        }
        length * (1.0 + CostKind::PENALTY * total / count)
    }

    /// Returns the length of a path in the metric of a search.
    fn length(&self, path: &[Vec<f64>]) -> f64 {
        sum(path.windows(2).map(|edge| self.metric.distance(&edge[0], &edge[1])))
    }

    /// Returns the metric of the joints.
    pub fn metric(&self) -> &JointMetric {
        &self.metric
    }

    /// Returns the score of the grasp at the end of a path, if scores count. `end` (m, rad; one per joint).
    pub fn score_at(&self, problem: &Problem, end: &[f64]) -> Option<f64> {
        if self.score_weight > 0.0 { end_score(problem, end) } else { None }
    }

    /// Returns the cost of each grasp of a problem relative to the best possible grasp, in addition to the path length: one
    /// value per grasp, in the unit of the cost.
    pub fn of_grasps(&self, problem: &Problem) -> Vec<f64> {
        let set = problem.grasps().map_or(&[][..], GraspSet::grasps);
        set.iter().map(|grasp| self.score_weight - self.reward(grasp.score)).collect()
    }

    /// Returns the cost of a path (way points in m, rad; one value per joint) in a search whose goals cost [`Self::of_grasps`]:
    /// its length in the metric of the search, plus the cost of its grasp.
    pub fn search_bound(&self, path: &[Vec<f64>], score: Option<f64>) -> f64 {
        self.length(path) - self.reward(score) + self.score_weight
    }

    /// Returns the discount that a grasp with this score gives on the measure of a path.
    pub fn reward(&self, score: Option<f64>) -> f64 {
        self.score_weight * score.unwrap_or(0.0)
    }
}

/// Returns the duration (s) of the time-optimal motion from rest to rest on a straight edge, set by the slowest joint.
fn rest_to_rest_s(a: &[f64], b: &[f64], limits: &MotionLimits) -> f64 {
    // Limits in units of the whole edge, per second and per second squared.
    let least = |rates: &[f64]| {
        let rate = |((a, b), limit): ((&f64, &f64), &f64)| limit / (b - a).abs();
        a.iter().zip(b).zip(rates).map(rate).fold(f64::INFINITY, f64::min)
    };
    let (velocity, acceleration) = (least(&limits.velocity), least(&limits.acceleration));
    if velocity.is_infinite() {
        0.0
    } else if velocity * velocity <= acceleration {
        velocity.recip() + velocity / acceleration
    } else {
        2.0 / acceleration.sqrt()
    }
}

fn sum(costs: impl Iterator<Item = f64>) -> f64 {
    costs.fold(0.0, |sum, x| sum + x)
}

#[cfg(test)]
mod tests {
    use cranny_robot::{JointLimits, JointUnit};
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_straight_edge_takes_as_long_as_its_trajectory(
            a in prop::collection::vec(-2.0..2.0, 3), b in prop::collection::vec(-2.0..2.0, 3),
            rates in prop::collection::vec((0.1..3.0, 0.1..10.0), 3),
        ) {
            let limits: Vec<JointLimits> = rates
                .iter()
                .map(|&(velocity, acceleration)| JointLimits {
                    lower: -2.0,
                    upper: 2.0,
                    velocity,
                    acceleration: Some(acceleration),
                    jerk: None,
                    unit: JointUnit::Radian,
                })
                .collect();
            let names: Vec<String> = (0..3).map(|joint| format!("joint {joint}")).collect();
            let limits = MotionLimits::new(&names, &limits, TimingMethod::TimeOptimal).expect("good limits");
            let trajectory = Trajectory::along(&[a.clone(), b.clone()], &limits).expect("a path");
            let seconds = rest_to_rest_s(&a, &b, &limits);
            prop_assert!((seconds - trajectory.duration_s()).abs() <= 1e-4 * seconds, "{} {}", seconds, trajectory.duration_s());
        }
    }
}
