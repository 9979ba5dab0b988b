use cranny_grasp::{Grasp, GraspError, GraspSet, ScoreKind};
use cranny_path::{AuditSettings, Drives, MotionLimits, PathError, TimingMethod, Trajectory};
use cranny_plan::{Budget, OptimiseSettings, Planner, Registry, default_planner};
use cranny_robot::Robot;
use cranny_spatial::{EXACT_ROTATION_RAD, EXACT_TRANSLATION_M, Pose, PoseDifference, Vector};
use cranny_task::{Criterion, Goal, Payload, Problem, Stage, State, TaskError};
use serde_json::{Map, Value};

use crate::{Paces, SolveError};

/// Options of [`solve`](crate::solve()). The same problem and request give the same way points on every machine, unless the
/// time limit stops the search.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// Available planners. Default: the built-in ones.
    pub registry: Registry,
    /// Name of the planner. Default: the best for the criterion.
    pub planner: Option<String>,
    /// Planner settings that differ from the defaults, by name.
    pub settings: Map<String, Value>,
    /// Budget of the search. Default: 120 s.
    pub budget: Budget,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Score used to rank grasps. Default: the load under `exact` if each grasp has one and no least score is required,
    /// otherwise the geometric score.
    pub score: Option<ScoreKind>,
    /// Least score (in [0, 1]) or load of a goal grasp. Grasps below it or without a score are not goals. Default: all grasps
    /// are goals.
    pub min_score: Option<f64>,
    /// Under `paper`: the gripper has arrived if ½·mm + ½·deg is below this, at least 0. Default: that of the problem.
    pub goal_threshold: Option<f64>,
    /// True if a proven path is left as the planner found it, and not shortened.
    pub keep_path: bool,
    /// Number of changes that are tried to shorten a path, without further searches for a better one. Default: 100, and the
    /// searches of [`OptimiseSettings::delivery`].
    pub changes: Option<usize>,
    /// Settings of the search for better paths after the first. Better paths are shortened regardless of `keep_path`.
    pub optimise: Option<OptimiseSettings>,
    /// Stages of the task. Default: the goal of the problem alone.
    pub stages: Vec<Stage>,
    /// Timing of the path; `None` for no trajectory.
    pub timing: Option<Timing>,
    /// Speed limits of motions, besides the limits of the robot.
    pub paces: Paces,
    /// Settings of the audit.
    pub audit: AuditSettings,
    /// True if tolerated deviations from a valid path are computed, which takes some milliseconds per edge.
    pub robustness: bool,
    /// True if a lower bound on path length is computed ([`least_length`](crate::least_length)), which takes about 10 ms.
    pub least_length: bool,
    /// Required factor by which loads may grow before the carried object slips, where it can be computed. Weaker grasps are
    /// refused, and motions slow down to reach it. Default [`DEFAULT_HOLD`]; 0 requires nothing; `None` skips the measurement.
    pub hold: Option<f64>,
    /// Excluded grasps: stage index, and pose of the gripper frame in the planning frame. All grasps within 2 mm and 2° of such
    /// a pose, or of its half turn about z, are excluded.
    pub left_out: Vec<(usize, Pose)>,
}

impl Default for Request {
    fn default() -> Self {
        Self {
            registry: Registry::default(),
            planner: None,
            settings: Map::new(),
            budget: Budget::default(),
            seed: 0,
            score: None,
            min_score: None,
            goal_threshold: None,
            keep_path: false,
            changes: None,
            optimise: None,
            stages: Vec::new(),
            timing: None,
            paces: Paces::default(),
            audit: AuditSettings::default(),
            robustness: false,
            least_length: false,
            hold: Some(DEFAULT_HOLD),
            left_out: Vec::new(),
        }
    }
}

/// Default of the required factor of a hold.
pub const DEFAULT_HOLD: f64 = 1.5;
/// Greatest factor of a hold that may be required.
pub const MOST_HOLD: f64 = 100.0;

/// Timing of a path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Timing {
    /// Limits in use: velocity and acceleration, or also jerk. `None`: also jerk if the robot states limits of jerk.
    pub method: Option<TimingMethod>,
    /// True if the motion stops at each corner instead of rounding those whose curve is proven free.
    pub stops: bool,
    /// True if missing limits of the robot are an error instead of an answer without a trajectory. With
    /// [`TimingMethod::JerkLimited`] they always are an error.
    pub is_demanded: bool,
    /// Direction against gravity in the planning frame, a unit vector, for effort limits of the drives; `None`: forces and
    /// torques are not limited.
    pub torque_up: Option<[f64; 3]>,
}

impl Timing {
    /// Creates the drives of a robot with the payload in its hand; `None` if their forces are not limited.
    ///
    /// # Errors
    /// As [`Drives::new`].
    pub fn drives(self, robot: &Robot, payload: Option<&Payload>) -> Result<Option<Drives>, PathError> {
        let held = payload.map(Payload::inertial);
        self.torque_up.map(|up| Drives::new(robot, &Vector::from(up), held)).transpose()
    }

    /// Returns the limits of a robot that the timing needs.
    ///
    /// # Errors
    /// As [`MotionLimits::new`].
    pub fn limits(self, robot: &Robot) -> Result<MotionLimits, PathError> {
        match self.method {
            Some(method) => MotionLimits::of(robot, method),
            None => MotionLimits::smoothest(robot),
        }
    }

    /// Computes the trajectory of a path of way points (m, rad; one value per joint), with a stop at each corner; `None` for a
    /// robot without the required limits.
    ///
    /// # Errors
    /// As [`Trajectory::along`].
    pub fn along(self, robot: &Robot, path: &[Vec<f64>]) -> Result<Option<Trajectory>, PathError> {
        self.limits(robot).ok().map(|limits| Trajectory::along(path, &limits)).transpose()
    }
}

impl Request {
    /// Checks that the request fits the problem.
    ///
    /// # Errors
    /// [`SolveError::Request`]; [`SolveError::Plan`] for an unknown planner or setting, or if a trajectory is required of a
    /// robot without the limits for it.
    pub fn check(&self, problem: &Problem) -> Result<(), SolveError> {
        self.planner_for(&self.first_problem(problem)?)?;
        self.asked(problem)?;
        let refuse = |field, problem: String| Err(SolveError::Request { field, problem });
        let is_paper = problem.criterion() == Criterion::Paper;
        match self.goal_threshold {
            Some(value) if !(value.is_finite() && value >= 0.0) => {
                return refuse(
                    "goal_threshold",
                    format!("'{value}' is not a valid threshold: expected a number, at least 0"),
                );
            }
            Some(_) if !is_paper => {
                return refuse(
                    "goal_threshold",
                    "only the paper criterion has a threshold; choose it, or leave this option out"
                        .to_owned(),
                );
            }
            _ => {}
        }
        if let Some(hold) = self.hold.filter(|hold| !(0.0..=MOST_HOLD).contains(hold)) {
            let problem =
                format!("'{hold}' is not a valid factor of loads: expected a number from 0 to {MOST_HOLD}");
            return refuse("hold", problem);
        }
        if let Some(OptimiseSettings { score_weight, .. }) = self.optimise {
            if !(score_weight.is_finite() && score_weight >= 0.0) {
                return refuse(
                    "score_weight",
                    format!("'{score_weight}' is not a valid weight: expected a number, at least 0"),
                );
            }
            if is_paper {
                return refuse(
                    "optimise",
                    "only a path that is proven under the exact criterion can be optimised".to_owned(),
                );
            }
        }
        if !self.stages.is_empty() {
            if is_paper {
                let problem =
                    "the paper criterion proves nothing, and has no tasks of stages; choose 'exact'";
                return refuse("criterion", problem.to_owned());
            }
            Stage::check_all(&self.stages, problem)?;
        }
        if let Some((name, value, values)) = self.paces.fault() {
            return refuse("pace", format!("'{value}' is not a valid {name}: expected a number {values}"));
        }
        let Some(timing) = self.timing else { return Ok(()) };
        timing.drives(problem.robot(), None)?;
        if timing.is_demanded || timing.method == Some(TimingMethod::JerkLimited) {
            timing.limits(problem.robot())?;
        }
        Ok(())
    }

    /// Returns the problem with the requested grasps, score and threshold and, with `min_score`, their original indices.
    pub(crate) fn asked(&self, problem: &Problem) -> Result<(Problem, Option<Vec<usize>>), SolveError> {
        let scored = self.scored(problem)?;
        let (chosen, numbers) = match self.min_score {
            None => (scored, None),
            Some(least) => self.above(least, &scored).map(|(chosen, numbers)| (chosen, Some(numbers)))?,
        };
        let asked = match self.goal_threshold {
            Some(threshold) => chosen.with_goal_threshold(threshold),
            None => chosen,
        };
        Ok((asked, numbers))
    }

    /// Returns the problem with the grasps of a score of at least `least`, and their indices.
    fn above(&self, least: f64, problem: &Problem) -> Result<(Problem, Vec<usize>), SolveError> {
        let refuse = |problem| SolveError::Request { field: "min_score", problem };
        let kind = self.score_of(problem);
        let (most, range) = match kind {
            ScoreKind::Load => (f64::MAX, "load: expected a number from 0"),
            ScoreKind::Geometric | ScoreKind::Physics => (1.0, "score: expected a number from 0 to 1"),
        };
        if !(0.0..=most).contains(&least) {
            return Err(refuse(format!("'{least}' is not a valid {range}")));
        }
        let grasps = match problem.grasps() {
            Some(grasps) if problem.grasp_measure().is_none() => grasps.grasps(),
            _ => return Err(refuse("there is no set of grasps whose scores could be compared".to_owned())),
        };
        let is_goal = |grasp: &Grasp| grasp.score_of(kind).is_some_and(|score| score >= least);
        let (numbers, chosen): (Vec<usize>, Vec<Grasp>) =
            grasps.iter().copied().enumerate().filter(|(_, grasp)| is_goal(grasp)).unzip();
        if chosen.is_empty() {
            let best = grasps.iter().filter_map(|grasp| grasp.score_of(kind)).reduce(f64::max);
            let best = best.map_or("none has a score".to_owned(), |best| format!("the best score is {best}"));
            return Err(refuse(format!("no grasp has a {} score of {least} or more; {best}", kind.name())));
        }
        let set = GraspSet::new(chosen).map_err(|fault| refuse(fault.to_string()))?;
        Ok((problem.with_goal(Goal::Grasps(set))?, numbers))
    }

    /// Returns the kind of score in use for the grasps of a problem.
    pub(crate) fn score_of(&self, problem: &Problem) -> ScoreKind {
        let has_loads = || {
            let set = problem.grasps().filter(|_| problem.criterion() == Criterion::Exact);
            set.is_some_and(|set| !set.is_empty() && set.grasps().iter().all(|grasp| grasp.load.is_some()))
        };
        match self.score {
            Some(kind) => kind,
            None if self.min_score.is_none() && has_loads() => ScoreKind::Load,
            None => ScoreKind::Geometric,
        }
    }

    fn scored(&self, problem: &Problem) -> Result<Problem, SolveError> {
        let kind = self.score_of(problem);
        if kind == ScoreKind::Geometric {
            return Ok(problem.clone());
        }
        let refuse = |problem| SolveError::Request { field: "score", problem };
        if problem.grasp_measure().is_some() {
            return Err(refuse("grasps that the planner generates have only the geometric score".to_owned()));
        }
        let grasps = problem
            .grasps()
            .ok_or_else(|| refuse("the goal is a configuration, which has no score".to_owned()))?;
        // By default, stated loads rank the grasps. If the request names the load as score, loads are computed.
        if self.score == Some(ScoreKind::Load) {
            let loaded = problem.loaded_grasps().ok_or_else(|| {
                let lacking = "the load of a grasp needs two flat pads that close on each other, and a target that \
                               encloses a volume";
                refuse(lacking.to_owned())
            })?;
            return Ok(problem.with_goal(Goal::Grasps(loaded.scored_by(kind)))?);
        }
        // If a least score is required, grasps without a score are not goals.
        let blank = grasps.grasps().iter().position(|grasp| grasp.score_of(kind).is_none());
        if let Some(grasp) = blank.filter(|_| self.min_score.is_none()) {
            return Err(refuse(GraspError::NoRobustScore { grasp }.to_string()));
        }
        Ok(problem.with_goal(Goal::Grasps(grasps.scored_by(kind)))?)
    }

    /// Returns a filter of the excluded grasps of a stage; `None` if there are none.
    pub(crate) fn left_out_filter(
        &self,
        stage: usize,
    ) -> Option<impl Fn(&Pose) -> bool + Send + Sync + use<>> {
        let of_stage = self.left_out.iter().filter(|(of, _)| *of == stage);
        let poses: Vec<Pose> = of_stage.map(|(_, pose)| *pose).collect();
        (!poses.is_empty()).then_some(move |grasp: &Pose| {
            let half_turn = Pose::rotation(Vector::z() * std::f64::consts::PI);
            let is_near = |other: &Pose| {
                let PoseDifference { translation_m, rotation_rad } = PoseDifference::between(other, grasp);
                translation_m <= 2.0 * EXACT_TRANSLATION_M && rotation_rad <= 2.0 * EXACT_ROTATION_RAD
            };
            poses.iter().any(|pose| is_near(pose) || is_near(&(pose * half_turn)))
        })
    }

    /// Returns the requested stages; without any, the goal of the problem as the only stage.
    pub(crate) fn stages_of(&self, problem: &Problem) -> Vec<Stage> {
        if self.stages.is_empty() { Stage::of_goal(problem) } else { self.stages.clone() }
    }

    /// Returns true if the planner generates the grasps of the first pick.
    pub fn makes_first_grasps(&self, problem: &Problem) -> bool {
        self.first_problem(problem).is_ok_and(|first| first.grasp_measure().is_some())
    }

    pub(crate) fn first_problem(&self, problem: &Problem) -> Result<Problem, TaskError> {
        match (self.stages.first(), State::start(problem)) {
            (Some(Stage::Pick(pick)), Some(start)) => start.picking(problem, pick),
            (Some(Stage::Move(goal)), Some(start)) => start.moving(goal.ends(problem).unwrap_or_default()),
            _ => Ok(problem.clone()),
        }
    }

    pub(crate) fn planner_for(&self, problem: &Problem) -> Result<Box<dyn Planner>, SolveError> {
        let default = default_planner(problem);
        let name = self.planner.as_deref().unwrap_or(default.name());
        Ok(self.registry.planner_with(name, &self.settings)?)
    }

    /// Returns the planner of a later pick: the requested one if it suits the source of the grasps of this pick (generated by
    /// the planner, or a given set); otherwise the default planner.
    pub(crate) fn later_planner_for(&self, problem: &Problem) -> Result<Box<dyn Planner>, SolveError> {
        let named = self.planner_for(problem)?;
        let is_suited = named.makes_grasps() == problem.grasp_measure().is_some();
        Ok(if is_suited { named } else { default_planner(problem) })
    }
}
