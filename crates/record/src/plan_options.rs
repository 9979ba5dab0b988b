use std::time::Duration;

use cranny_collision::Margins;
use cranny_grasp::ScoreKind;
use cranny_path::{AuditSettings, CostKind, MotionLimits, TimingMethod};
use cranny_plan::{Budget, OptimiseSettings, Registry};
use cranny_scenario::{NamedTask, Scenario, ScenarioError};
use cranny_solve::{DEFAULT_HOLD, PoseRadius, Request, Timing};
use cranny_spatial::Vector;
use cranny_task::{AfterPlacing, CLEAR_M, Mode, Move, PlaceAt, Problem, Stage};
use serde_json::{Map, Value};

use crate::{RecordError, SpeedOptions};

/// Options of a plan, in the words of flags and keywords: only this type converts them to a [`Request`].
#[derive(Clone, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "a flag or keyword each")]
pub struct PlanOptions {
    /// Available planners.
    pub registry: Registry,
    /// Name of the planner; `None`: the best for the criterion.
    pub planner: Option<String>,
    /// Settings of the planner that differ from their defaults.
    pub settings: Map<String, Value>,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Time limit of the search.
    pub time_limit: Duration,
    /// Iteration limit of the search; `None`: no limit.
    pub iterations: Option<u64>,
    /// Score used to rank grasps; `None`: the default of a request ([`Request::score`]).
    pub score: Option<ScoreKind>,
    /// Least score, or load, of a grasp.
    pub min_score: Option<f64>,
    /// Threshold of the paper's criterion.
    pub goal_threshold: Option<f64>,
    /// True if the path is kept as the planner found it.
    pub keep_path: bool,
    /// Time for better paths; `None`: the first path only.
    pub optimise: Option<Duration>,
    /// Cost of a path; `None`: [`CostKind::Mix`] for a robot with limits of acceleration, otherwise [`CostKind::Length`].
    pub cost: Option<CostKind>,
    /// Weight of a grasp's score against the cost.
    pub score_weight: f64,
    /// Limits of the timing; `None`: those of jerk too if the robot states them.
    pub timing: Option<TimingMethod>,
    /// True if the motion stops at each corner and rounds none.
    pub stops: bool,
    /// Speed limits of the motions.
    pub paces: SpeedOptions,
    /// Greatest speed of the gripper frame that the problem requires, in m/s, if `paces` state none.
    pub tool_m_s: Option<f64>,
    /// True if the forces and torques of the joints are kept within the efforts of the URDF.
    pub torque: bool,
    /// True if a trajectory is required.
    pub is_timing_demanded: bool,
    /// Goal of a carry.
    pub carry: Option<CarryGoal>,
    /// Goal regions of the hand, instead of a grasp ([`Self::goal_of`]).
    pub goal_region: Option<Move>,
    /// Name of the placement goal of the target.
    pub place: Option<String>,
    /// Task of several stages.
    pub task: Option<TaskSelection>,
    /// Motion of the robot after the target has been put down. Default: home.
    pub then: Option<AfterPlacing>,
    /// Distance of the object or the hand that counts as clear, in metres.
    pub clear_m: Option<f64>,
    /// Least length of the straight approach to each grasp, in metres; `None`: as in the stages.
    pub approach_m: Option<f64>,
    /// Least length of the straight retreat from each object that is put down, in metres; `None`: as in the stages.
    pub retreat_m: Option<f64>,
    /// Error of the pose of each object that the plan must tolerate.
    pub robust: Option<PoseRadius>,
    /// Least factor of the hold on the carried object; 0 requires nothing.
    pub hold: f64,
}

/// A task of several stages.
#[derive(Clone, Debug, PartialEq)]
pub enum TaskSelection {
    /// Name of a task of the scenario.
    Named(String),
    /// List of stages.
    Stages(Vec<Stage>),
}

/// Goal of a carry.
#[derive(Clone, Debug, PartialEq)]
pub enum CarryGoal {
    /// Start configuration of the robot.
    Home,
    /// Any configuration at which the object is clear of everything but floors.
    Out,
    /// Any of these configurations (m, rad).
    Configurations(Vec<Vec<f64>>),
}

impl Default for PlanOptions {
    fn default() -> Self {
        let Request { budget, .. } = Request::default();
        Self {
            registry: Registry::default(),
            planner: None,
            settings: Map::new(),
            seed: 0,
            time_limit: budget.time,
            iterations: None,
            score: None,
            min_score: None,
            goal_threshold: None,
            keep_path: false,
            optimise: None,
            cost: None,
            score_weight: OptimiseSettings::default().score_weight,
            timing: None,
            stops: false,
            tool_m_s: None,
            paces: SpeedOptions::default(),
            torque: false,
            is_timing_demanded: false,
            carry: None,
            goal_region: None,
            place: None,
            task: None,
            then: None,
            clear_m: None,
            approach_m: None,
            retreat_m: None,
            robust: None,
            hold: DEFAULT_HOLD,
        }
    }
}

impl PlanOptions {
    /// Creates the request for a problem, from a scenario or from other files, and returns it with the scenario's task if one
    /// is requested by name.
    ///
    /// # Errors
    /// [`RecordError::PlanOptions`] for options that exclude each other, and those of [`Request::check`];
    /// [`ScenarioError::UnknownTask`](cranny_scenario::ScenarioError::UnknownTask).
    pub fn request(
        &self,
        problem: &Problem,
        scenario: Option<&Scenario>,
    ) -> Result<(Request, Option<NamedTask>), RecordError> {
        let (stages, task) = self.stages(scenario)?;
        let stages = self.straight(problem, stages)?;
        self.check_effect(&stages)?;
        let stages = match (self.robust, scenario) {
            (Some(error), Some(scenario)) => {
                scenario.forgiving(&stages, error.translation_m, error.rotation_rad)
            }
            _ => stages,
        };
        let request = Request {
            registry: self.registry.clone(),
            planner: self.planner.clone(),
            settings: self.settings.clone(),
            budget: Budget { iterations: self.iterations.unwrap_or(u64::MAX), time: self.time_limit },
            seed: self.seed,
            score: self.score,
            min_score: self.min_score,
            goal_threshold: self.goal_threshold,
            keep_path: self.keep_path,
            changes: None,
            optimise: self.optimise.map(|time| OptimiseSettings {
                time,
                score_weight: self.score_weight,
                cost: self.cost.unwrap_or_else(|| {
                    let is_timed = MotionLimits::of(problem.robot(), TimingMethod::TimeOptimal).is_ok();
                    if is_timed { CostKind::Mix } else { CostKind::Length }
                }),
                ..OptimiseSettings::default()
            }),
            stages,
            timing: Some(Timing {
                method: self.timing,
                stops: self.stops,
                is_demanded: self.is_timing_demanded || self.torque,
                torque_up: self
                    .torque
                    .then(|| problem.cell().map_or_else(Vector::z, |cell| cell.world().up()).into()),
            }),
            paces: self
                .paces
                .after(scenario.map_or(&[], |scenario| &scenario.speeds))
                .paces(self.tool_m_s)?,
            audit: AuditSettings::default(),
            robustness: true,
            least_length: true,
            hold: Some(self.hold),
            left_out: Vec::new(),
        };
        request.check(problem)?;
        Ok((request, task))
    }

    /// Parses goal regions: the name of a region of the scenario, or a region in the format of `scenario.yaml`, or a list of
    /// either.
    ///
    /// # Errors
    /// The fault, in words.
    pub fn goal_of(value: Value) -> Result<Move, String> {
        let fault = |fault: serde_json::Error| fault.to_string();
        let is_name = |value: &Value| value.is_string();
        match value {
            Value::String(name) => Ok(Move::NamedRegions(vec![name])),
            Value::Array(values) if values.iter().all(is_name) => {
                serde_json::from_value(Value::Array(values)).map(Move::NamedRegions).map_err(fault)
            }
            Value::Array(_) => serde_json::from_value(value).map(Move::Regions).map_err(fault),
            _ => serde_json::from_value(value).map(|region| Move::Regions(vec![region])).map_err(fault),
        }
    }

    /// Refuses options that have no effect on these stages: a firm hold of nothing, and a speed of motions that do not occur.
    fn check_effect(&self, stages: &[Stage]) -> Result<(), RecordError> {
        let has = |is_it: fn(&Stage) -> bool| stages.iter().any(is_it);
        let (picks, places) =
            (has(|stage| matches!(stage, Stage::Pick(_))), has(|stage| matches!(stage, Stage::Place(_))));
        // A pick as the only stage ends at the grasp.
        let carries = picks && stages.len() > 1;
        let is_approach = has(|stage| matches!(stage, Stage::Pick(pick) if pick.approach_m > 0.0));
        // A hold of 0 demands nothing.
        if !carries && self.hold > 0.0 && self.hold.to_bits() != DEFAULT_HOLD.to_bits() {
            let problem = "nothing is carried in this task".to_owned();
            return Err(RecordError::PlanOptions { field: "hold", problem });
        }
        let default_weight = OptimiseSettings::default().score_weight;
        for (field, is_given) in [
            ("cost", self.cost.is_some()),
            ("score_weight", self.score_weight.total_cmp(&default_weight).is_ne()),
        ] {
            if is_given && self.optimise.is_none() {
                let problem =
                    "nothing is optimised: give a time for it, too (--optimise, optimise_s)".to_owned();
                return Err(RecordError::PlanOptions { field, problem });
            }
        }
        // A motion home after a place.
        let returns = stages.windows(2).any(|pair| matches!(pair, [Stage::Place(_), Stage::Move(_)]));
        if let Some((field, mode)) = self.paces.twice() {
            let of = mode.map_or_else(|| "all motions".to_owned(), |mode| format!("'{}'", mode.name));
            let problem = format!("a limit for {of} is given twice");
            return Err(RecordError::PlanOptions { field, problem });
        }
        for (field, mode) in self.paces.modes() {
            let occurs = match mode {
                Mode::LIFT_OFF | Mode::CARRY => carries,
                Mode::SET_DOWN | Mode::RETREAT => places,
                Mode::RETURN => returns,
                Mode::APPROACH => is_approach,
                _ => true,
            };
            if !occurs {
                let problem = format!("there is no motion '{}' in this task", mode.name);
                return Err(RecordError::PlanOptions { field, problem });
            }
        }
        Ok(())
    }

    /// Returns stages with the requested straight approaches and retreats.
    fn straight(&self, problem: &Problem, mut stages: Vec<Stage>) -> Result<Vec<Stage>, RecordError> {
        let is_of_goal = self.approach_m.is_some() && stages.is_empty();
        if is_of_goal {
            stages = Stage::of_goal(problem);
        }
        let (mut picks, mut places) = (0, 0);
        for stage in &mut stages {
            match stage {
                Stage::Pick(pick) => {
                    pick.approach_m = self.approach_m.unwrap_or(pick.approach_m);
                    picks += 1;
                }
                Stage::Place(place) => {
                    place.retreat_m = self.retreat_m.unwrap_or(place.retreat_m);
                    places += 1;
                }
                Stage::Move(_) => {}
            }
        }
        let refuse =
            |field, problem: &str| Err(RecordError::PlanOptions { field, problem: problem.to_owned() });
        if self.approach_m.is_some() && picks == 0 {
            return refuse("approach", "nothing is grasped in this task");
        }
        if self.retreat_m.is_some() && places == 0 {
            return refuse("retreat", "it is only valid with `place` and with tasks that put an object down");
        }
        if is_of_goal && self.approach_m.is_some_and(|approach_m| approach_m.abs() <= 0.0) {
            // An approach of no length demands nothing.
            stages.clear();
        }
        Ok(stages)
    }

    /// Returns the requested stages, and the scenario's task if it was requested by name.
    fn stages(&self, scenario: Option<&Scenario>) -> Result<(Vec<Stage>, Option<NamedTask>), RecordError> {
        let refuse =
            |field, problem: &str| Err(RecordError::PlanOptions { field, problem: problem.to_owned() });
        let asked = [
            ("goal_region", self.goal_region.is_some()),
            ("carry", self.carry.is_some()),
            ("place", self.place.is_some()),
            ("task", self.task.is_some()),
        ];
        let mut asked = asked.into_iter().filter(|(_, is_asked)| *is_asked).map(|(field, _)| field);
        if let (Some(_), Some(second)) = (asked.next(), asked.next()) {
            return refuse(second, "only one of a goal region, `carry`, `place` and a task can be given");
        }
        if self.then.is_some() && self.place.is_none() {
            return refuse(
                "then",
                "it is only valid with `place`; in a task, add a stage with `move` instead",
            );
        }
        if self.clear_m.is_some()
            && self.place.is_none()
            && self.task.is_none()
            && self.carry != Some(CarryGoal::Out)
        {
            return refuse("clear", "it is only valid with `carry` out, `place` and tasks");
        }
        let clear_m = self.clear_m.unwrap_or(CLEAR_M);
        if let Some(goal) = &self.goal_region {
            return Ok((vec![Stage::Move(goal.clone())], None));
        }
        if let Some(place) = &self.place {
            let place = PlaceAt { clear_m, ..PlaceAt::named(place) };
            return Ok((Stage::put_down(place, self.then.unwrap_or_default()), None));
        }
        if let Some(task) = &self.task {
            let (stages, task) = match (task, scenario) {
                (TaskSelection::Stages(stages), _) => (stages.clone(), None),
                (TaskSelection::Named(name), Some(scenario)) => {
                    let task = scenario.task(name)?.clone();
                    (task.stages.clone(), Some(task))
                }
                (TaskSelection::Named(_), None) => return refuse("task", "only a scenario has tasks"),
            };
            let stages = stages.iter().map(|stage| match (stage, self.clear_m) {
                (Stage::Place(at), Some(clear_m)) => Stage::Place(PlaceAt { clear_m, ..at.clone() }),
                (Stage::Move(Move::Clear { .. }), Some(clear_m)) => Stage::Move(Move::Clear { clear_m }),
                _ => stage.clone(),
            });
            return Ok((stages.collect(), task));
        }
        let goal = match &self.carry {
            None => return Ok((Vec::new(), None)),
            Some(CarryGoal::Home) => Move::Home,
            Some(CarryGoal::Out) => Move::Clear { clear_m },
            Some(CarryGoal::Configurations(ends)) => Move::Configurations(ends.clone()),
        };
        Ok((vec![Stage::pick(), Stage::Move(goal)], None))
    }
}

/// Default clearance that a plan requires between the open hand and the object to pick up, in metres, if motion `goes_on` after
/// the grasp: an object that the hand grazes has moved by the time it closes. If an error of the pose must be tolerated, its
/// margin takes over.
pub fn default_grasp_margin_m(goes_on: bool, robust: Option<PoseRadius>) -> f64 {
    if goes_on && robust.is_none() { 1e-3 } else { 0.0 }
}

/// Returns margins that also tolerate an error of the pose of a scenario's target, if one is given.
///
/// # Errors
/// [`ScenarioError::NoTarget`] for a scenario without a target that could be displaced.
pub fn margins_forgiving(
    scenario: &Scenario,
    margins: Margins,
    robust: Option<PoseRadius>,
) -> Result<Margins, ScenarioError> {
    let Some(PoseRadius { translation_m, rotation_rad }) = robust else { return Ok(margins) };
    let object_margin_m = scenario.object_margin_m(translation_m, rotation_rad);
    let lacking = || ScenarioError::NoTarget { id: scenario.id.clone() };
    Ok(Margins { object_margin_m: object_margin_m.ok_or_else(lacking)?, ..margins })
}
