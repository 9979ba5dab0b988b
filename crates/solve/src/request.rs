use cranny_grasp::{Grasp, GraspError, GraspSet, ScoreKind};
use cranny_path::{AuditSettings, Drives, MotionLimits, PathError, TimingMethod, Trajectory};
use cranny_plan::{Budget, OptimiseSettings, Planner, Registry, default_planner};
use cranny_robot::Robot;
use cranny_spatial::{EXACT_ROTATION_RAD, EXACT_TRANSLATION_M, Pose, PoseDifference, Vector};
use cranny_task::{Criterion, Goal, Payload, Problem, Stage, State, TaskError};
use serde_json::{Map, Value};

use crate::{Paces, SolveError};

/// How a problem is to be solved. The same problem and request give the same way points on every machine, unless time
/// cuts the search short.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// The planners that there are. Default: the built-in ones.
    pub registry: Registry,
    /// Name of the planner. Default: the best for the criterion.
    pub planner: Option<String>,
    /// What differs from its default settings, by name.
    pub settings: Map<String, Value>,
    /// What the search may spend. Default: 120 s.
    pub budget: Budget,
    /// What all randomness is drawn from.
    pub seed: u64,
    /// Score of the grasps that counts, wherever one is better than another. Default: the load under `exact` where each
    /// grasp has one and no least score is demanded, else the geometric score.
    pub score: Option<ScoreKind>,
    /// Least score of that kind, in [0, 1], or least load, of the grasps that are goals: those below it, or without a score,
    /// are none. Default: all are.
    pub min_score: Option<f64>,
    /// Under `paper`: arrived where ½·mm + ½·deg is below this, at least 0. Default: what the problem says.
    pub goal_threshold: Option<f64>,
    /// Whether a proven path is left as the planner found it, and not shortened.
    pub keep_path: bool,
    /// How to look for better paths once there is one; they are shortened whatever `keep_path` says.
    pub optimise: Option<OptimiseSettings>,
    /// The stages of the task. Default: the goal of the problem alone.
    pub stages: Vec<Stage>,
    /// How the path gets its time; `None` where nobody asks for a trajectory.
    pub timing: Option<Timing>,
    /// How fast motions may be, besides the limits of the robot.
    pub paces: Paces,
    /// What is judged of the path.
    pub audit: AuditSettings,
    /// Whether it is worked out how far things may be from where a path that holds has them: some milliseconds an edge.
    pub robustness: bool,
    /// Bounds the length of every path of the task from below ([`least_length`](crate::least_length)): some ten milliseconds.
    pub least_length: bool,
    /// Factor by which loads may grow before the hand lets slip what it carries, at least, where that can be computed: other
    /// grasps are none, and motions are slowed down for it. Default [`DEFAULT_HOLD`]; 0 demands nothing; `None` leaves it
    /// unmeasured.
    pub hold: Option<f64>,
    /// Grasps that are left out, each of a stage, by the pose of the gripper frame in the planning frame; those within
    /// 2 mm and 2° too.
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

/// The factor of a hold that is demanded unless another one is.
pub const DEFAULT_HOLD: f64 = 1.5;
/// Greatest factor of a hold that may be demanded.
pub const MOST_HOLD: f64 = 100.0;

/// How a path gets its time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Timing {
    /// Within limits of velocity and acceleration, or of jerk too; `None`: of jerk too where the robot states them.
    pub method: Option<TimingMethod>,
    /// Stop at each corner, and do not round those whose curve is proven free.
    pub stops: bool,
    /// Whether a robot without the limits that this needs is refused, and not answered without a trajectory. A jerk
    /// limit is always demanded.
    pub is_demanded: bool,
    /// Direction against gravity in the planning frame, a unit vector, under which the drives of the robot keep their efforts;
    /// `None`: forces and torques are not limited.
    pub torque_up: Option<[f64; 3]>,
}

impl Timing {
    /// The drives of a robot with what is in its hand, where their forces are limited.
    ///
    /// # Errors
    /// As [`Drives::new`].
    pub fn drives(self, robot: &Robot, payload: Option<&Payload>) -> Result<Option<Drives>, PathError> {
        let held = payload.map(Payload::inertial);
        self.torque_up.map(|up| Drives::new(robot, &Vector::from(up), held)).transpose()
    }

    /// The limits of a robot that it needs.
    ///
    /// # Errors
    /// As [`MotionLimits::new`].
    pub fn limits(self, robot: &Robot) -> Result<MotionLimits, PathError> {
        match self.method {
            Some(method) => MotionLimits::of(robot, method),
            None => MotionLimits::smoothest(robot),
        }
    }

    /// A path of way points (m, rad; one value per joint) in time, with a stop at each corner; `None` for a robot without the
    /// limits that this needs.
    ///
    /// # Errors
    /// As [`Trajectory::along`].
    pub fn along(self, robot: &Robot, path: &[Vec<f64>]) -> Result<Option<Trajectory>, PathError> {
        self.limits(robot).ok().map(|limits| Trajectory::along(path, &limits)).transpose()
    }
}

impl Request {
    /// Whether the request goes with the problem.
    ///
    /// # Errors
    /// [`SolveError::Request`]; [`SolveError::Plan`] for an unknown planner or setting, or where a trajectory is
    /// demanded of a robot without the limits for it.
    pub fn check(&self, problem: &Problem) -> Result<(), SolveError> {
        self.planner_for(&self.first_problem(problem)?)?;
        self.asked(problem)?;
        let refuse = |field, problem: String| Err(SolveError::Request { field, problem });
        let is_paper = problem.criterion() == Criterion::Paper;
        match self.goal_threshold {
            Some(value) if !(value.is_finite() && value >= 0.0) => {
                return refuse(
                    "goal_threshold",
                    format!("'{value}' is no threshold; give a number, at least 0"),
                );
            }
            Some(_) if !is_paper => {
                return refuse(
                    "goal_threshold",
                    "only the paper criterion has a threshold; ask for that one, or leave this out"
                        .to_owned(),
                );
            }
            _ => {}
        }
        if let Some(hold) = self.hold.filter(|hold| !(0.0..=MOST_HOLD).contains(hold)) {
            let problem = format!("'{hold}' is no factor of loads; give a number from 0 to {MOST_HOLD}");
            return refuse("hold", problem);
        }
        if let Some(OptimiseSettings { score_weight, .. }) = self.optimise {
            if !(score_weight.is_finite() && score_weight >= 0.0) {
                return refuse(
                    "score_weight",
                    format!("'{score_weight}' is no weight; give a number, at least 0"),
                );
            }
            if is_paper {
                return refuse(
                    "optimise",
                    "only a proven path can be bettered, under the exact criterion".to_owned(),
                );
            }
        }
        if !self.stages.is_empty() {
            if is_paper {
                let problem = "nothing is carried under it, which proves nothing; ask for the exact one";
                return refuse("criterion", problem.to_owned());
            }
            Stage::check_all(&self.stages, problem)?;
        }
        if let Some((name, value, values)) = self.paces.fault() {
            return refuse("pace", format!("'{value}' is no {name}; give a number {values}"));
        }
        let Some(timing) = self.timing else { return Ok(()) };
        timing.drives(problem.robot(), None)?;
        if timing.is_demanded || timing.method == Some(TimingMethod::JerkLimited) {
            timing.limits(problem.robot())?;
        }
        Ok(())
    }

    /// The problem, its grasps with the score that counts and without those that are no goals, under `paper` with the
    /// threshold; and which grasps those that are left were, where some were left out.
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

    /// The problem with the grasps of a score of at least `least`, and which those are.
    fn above(&self, least: f64, problem: &Problem) -> Result<(Problem, Vec<usize>), SolveError> {
        let refuse = |problem| SolveError::Request { field: "min_score", problem };
        let kind = self.score_of(problem);
        let (most, range) = match kind {
            ScoreKind::Load => (f64::MAX, "load; give a number from 0"),
            ScoreKind::Geometric | ScoreKind::Physics => (1.0, "score; give a number from 0 to 1"),
        };
        if !(0.0..=most).contains(&least) {
            return Err(refuse(format!("'{least}' is no {range}")));
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

    /// The kind of score that counts of the grasps of a problem.
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
            return Err(refuse("a grasp of the planner's own has the geometric score alone".to_owned()));
        }
        let grasps = problem
            .grasps()
            .ok_or_else(|| refuse("the goal is a configuration, which has no score".to_owned()))?;
        // Stated loads serve for the order of preference alone; those that are asked for are computed.
        if self.score == Some(ScoreKind::Load) {
            let loaded = problem.loaded_grasps().ok_or_else(|| {
                let lacking = "the load of a grasp needs two flat pads that close on each other, and a target that \
                               encloses a volume";
                refuse(lacking.to_owned())
            })?;
            return Ok(problem.with_goal(Goal::Grasps(loaded.scored_by(kind)))?);
        }
        // Those without are no goals where a least score is demanded.
        let blank = grasps.grasps().iter().position(|grasp| grasp.score_of(kind).is_none());
        if let Some(grasp) = blank.filter(|_| self.min_score.is_none()) {
            return Err(refuse(GraspError::NoRobustScore { grasp }.to_string()));
        }
        Ok(problem.with_goal(Goal::Grasps(grasps.scored_by(kind)))?)
    }

    /// A filter of the grasps of a stage that are left out; `None` where all are in.
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

    /// The stages: those that are asked, or the goal of the problem.
    pub(crate) fn stages_of(&self, problem: &Problem) -> Vec<Stage> {
        if self.stages.is_empty() { Stage::of_goal(problem) } else { self.stages.clone() }
    }

    /// The problem of the first stage.
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

    /// The planner of a pick that follows another: the one that is asked for, where it makes grasps of its own or takes a set
    /// of them as this pick needs it; else the default one.
    pub(crate) fn later_planner_for(&self, problem: &Problem) -> Result<Box<dyn Planner>, SolveError> {
        let named = self.planner_for(problem)?;
        let is_suited = named.makes_grasps() == problem.grasp_measure().is_some();
        Ok(if is_suited { named } else { default_planner(problem) })
    }
}
