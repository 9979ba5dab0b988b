//! `cranny_plan`: from a task to a proven, timed path.

use std::collections::BTreeMap;
use std::ffi::c_void;
use std::mem::MaybeUninit;
use std::time::Duration;

use cranny::collision::Margins;
use cranny::path::{AuditSettings, TimingMethod, audit_with};
use cranny::plan::Observer;
use cranny::record::{
    CarryGoal, PlanOptions, SpeedOption, SpeedOptions, TaskSelection, default_grasp_margin_m,
    margins_forgiving,
};
use cranny::solve::{DEFAULT_HOLD, PoseRadius, solve};
use cranny::task::{Criterion, Mode, Stage};
use serde::Deserialize;
use serde_json::{Map, Value};

use crate::boundary::{Numbers, Text, given, guarded, put};
use crate::error::{CrannyStatus, Fault};
use crate::options::{parsed, refused, word};
use crate::plan::CrannyPlan;
use crate::robot::check_dof;
use crate::scenario::{Asked, CrannyScenario};
use crate::verification::CrannyVerification;

/// Options of a plan, in the words of Python's `plan`.
#[derive(Deserialize)]
#[serde(default, deny_unknown_fields)]
#[expect(clippy::struct_excessive_bools, reason = "a keyword each")]
struct Options {
    planner: Option<String>,
    seed: u64,
    time_limit_s: f64,
    iterations: Option<u64>,
    margin_m: f64,
    grasp_margin_m: Option<f64>,
    strict_pairs: bool,
    settings: Map<String, Value>,
    goal_threshold: Option<f64>,
    shortcut: bool,
    optimise_s: Option<f64>,
    cost: Option<String>,
    score_weight: Option<f64>,
    jerk_limited: Option<bool>,
    blend: bool,
    speed: Option<Pace>,
    acceleration: Option<Pace>,
    tool_speed_m_s: Option<Pace>,
    turn_speed_deg_s: Option<Pace>,
    torque: bool,
    upright_deg: Option<f64>,
    score: Option<String>,
    min_score: Option<f64>,
    carry: Option<Carry>,
    goal_region: Option<Value>,
    place: Option<String>,
    task: Option<Task>,
    then: Option<String>,
    clear_m: Option<f64>,
    approach_m: Option<f64>,
    retreat_m: Option<f64>,
    robust: Option<[f64; 2]>,
    hold: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            planner: None,
            seed: 0,
            time_limit_s: 120.0,
            iterations: None,
            margin_m: 0.0,
            grasp_margin_m: None,
            strict_pairs: false,
            settings: Map::new(),
            goal_threshold: None,
            shortcut: true,
            optimise_s: None,
            cost: None,
            score_weight: None,
            jerk_limited: None,
            blend: true,
            speed: None,
            acceleration: None,
            tool_speed_m_s: None,
            turn_speed_deg_s: None,
            torque: false,
            upright_deg: None,
            score: None,
            min_score: None,
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

/// Limit of the motions: one number, or a number for each mode.
#[derive(Deserialize)]
#[serde(untagged)]
enum Pace {
    All(f64),
    OfModes(BTreeMap<String, f64>),
}

/// Destination of the grasped target.
#[derive(Deserialize)]
#[serde(untagged)]
enum Carry {
    Word(String),
    Configuration(Vec<f64>),
    Configurations(Vec<Vec<f64>>),
}

/// Task of several stages: its name, or its stages.
#[derive(Deserialize)]
#[serde(untagged)]
enum Task {
    Named(String),
    Stages(Vec<Stage>),
}

fn paces(pace: Option<Pace>) -> Result<Vec<SpeedOption>, Fault> {
    let of_mode = |(name, value): (String, f64)| {
        let mode = if name == "all" { None } else { Some(Mode::of_name(&name).map_err(refused)?) };
        Ok(SpeedOption { mode, value })
    };
    match pace {
        None => Ok(Vec::new()),
        Some(Pace::All(value)) => Ok(vec![SpeedOption { mode: None, value }]),
        Some(Pace::OfModes(values)) => values.into_iter().map(of_mode).collect(),
    }
}

fn carry_goal(carry: Carry, dof: usize) -> Result<CarryGoal, Fault> {
    let rows = match carry {
        Carry::Word(word) => {
            return match &word[..] {
                "home" => Ok(CarryGoal::Home),
                "out" => Ok(CarryGoal::Out),
                _ => Err(refused(format!(
                    "`carry` is '{word}', but 'home', 'out' or configurations are expected"
                ))),
            };
        }
        Carry::Configuration(q) => vec![q],
        Carry::Configurations(rows) => rows,
    };
    match rows.iter().find(|q| q.len() != dof) {
        None => Ok(CarryGoal::Configurations(rows)),
        Some(q) => {
            Err(refused(format!("`carry` has a row of {} values, but the robot has {dof} joints", q.len())))
        }
    }
}

fn seconds(what: &str, value: f64) -> Result<Duration, Fault> {
    let wrong = || refused(format!("`{what}` is {value}, but a positive number of seconds is expected"));
    if value > 0.0 { Duration::try_from_secs_f64(value).map_err(|_| wrong()) } else { Err(wrong()) }
}

impl Options {
    /// Returns the clearances that are required of a path in a task.
    fn margins(&self, asked: &Asked) -> Result<Margins, Fault> {
        let robust =
            self.robust.map(|[translation_m, rotation_rad]| PoseRadius { translation_m, rotation_rad });
        let is_wrong = |value: &f64| !(value.is_finite() && *value >= 0.0);
        if self.robust.is_some_and(|radius| radius.iter().any(is_wrong)) {
            return Err(refused("`robust` is a translation (m) and a rotation (rad), both at least 0"));
        }
        if let Some(degrees) = self.upright_deg.filter(|degrees| !(*degrees > 0.0 && *degrees <= 180.0)) {
            return Err(refused(format!(
                "`upright_deg` is {degrees}, but it must be above 0 and at most 180"
            )));
        }
        let goes_on = asked.scenario.criterion == Criterion::Exact
            && (self.carry.is_some() || self.place.is_some() || self.task.is_some());
        let margins = Margins {
            margin_m: self.margin_m,
            grasp_margin_m: self.grasp_margin_m.unwrap_or_else(|| default_grasp_margin_m(goes_on, robust)),
            tilt_rad: self.upright_deg.map(f64::to_radians),
            ..Margins::default()
        };
        Ok(margins_forgiving(&asked.scenario, margins, robust)?)
    }

    fn plan_options(self, asked: &Asked) -> Result<PlanOptions, Fault> {
        let defaults = PlanOptions::default();
        let costs = "'length', 'l2', 'time', 'clearance', 'tool', 'turn', 'smooth' or 'mix'";
        let carry = self.carry.map(|carry| carry_goal(carry, asked.scenario.robot.dof()));
        Ok(PlanOptions {
            planner: self.planner,
            settings: self.settings,
            seed: self.seed,
            time_limit: seconds("time_limit_s", self.time_limit_s)?,
            iterations: self.iterations,
            score: word("score", self.score.as_deref(), "'geometric', 'physics' or 'load'")?,
            min_score: self.min_score,
            goal_threshold: self.goal_threshold,
            keep_path: !self.shortcut,
            optimise: self.optimise_s.map(|time_s| seconds("optimise_s", time_s)).transpose()?,
            cost: word("cost", self.cost.as_deref(), costs)?,
            score_weight: self.score_weight.unwrap_or(defaults.score_weight),
            timing: self
                .jerk_limited
                .map(|limited| if limited { TimingMethod::JerkLimited } else { TimingMethod::TimeOptimal }),
            stops: !self.blend,
            paces: SpeedOptions {
                speed: paces(self.speed)?,
                acceleration: paces(self.acceleration)?,
                tool_speed: paces(self.tool_speed_m_s)?,
                turn_speed: paces(self.turn_speed_deg_s)?,
            },
            tool_m_s: asked.tool_m_s,
            torque: self.torque,
            carry: carry.transpose()?,
            goal_region: self.goal_region.map(PlanOptions::goal_of).transpose().map_err(refused)?,
            place: self.place,
            task: self.task.map(|task| match task {
                Task::Named(name) => TaskSelection::Named(name),
                Task::Stages(stages) => TaskSelection::Stages(stages),
            }),
            then: word("then", self.then.as_deref(), "'home' or 'stay'")?,
            clear_m: self.clear_m,
            approach_m: self.approach_m,
            retreat_m: self.retreat_m,
            robust: self
                .robust
                .map(|[translation_m, rotation_rad]| PoseRadius { translation_m, rotation_rad }),
            hold: self.hold,
            ..defaults
        })
    }
}

/// Function that ends a search when it returns true. A search calls it between its iterations, in the thread of cranny_plan.
pub type CrannyShouldStop = Option<extern "C" fn(context: *mut c_void) -> bool>;

/// Observer that passes the question on to the caller.
struct Stopper {
    should_stop: CrannyShouldStop,
    context: *mut c_void,
}

impl Observer for Stopper {
    fn should_stop(&self) -> bool {
        self.should_stop.is_some_and(|should_stop| should_stop(self.context))
    }
}

/// Plans a scenario: searches for a path to a grasp or goal, shortens it, proves it and times it. A search without a result is
/// no error: see cranny_plan_outcome. The caller frees the plan with cranny_plan_free.
///
/// `options`: NULL, or a JSON object with the keywords of Python's cranny.plan, such as {"seed": 7, "time_limit_s": 2}. Usual
/// ones: "planner" (a name), "seed" (0; the same seed and iterations give the same way points on every machine), "time_limit_s"
/// (120), "iterations", "margin_m" and "grasp_margin_m" (clearances that the proof must show), "optimise_s" (seconds for better
/// paths) and "cost", "speed" and "acceleration" (fractions of the limits), "tool_speed_m_s", "jerk_limited", "upright_deg",
/// "carry" ("home", "out" or configurations), "goal_region", "place", "task", "robust". docs/cpp.md lists all.
///
/// `should_stop`: NULL, or a function that is called with `context` and ends the search by returning true.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_plan(
    scenario: Option<&CrannyScenario>,
    options: Text<'_>,
    should_stop: CrannyShouldStop,
    context: *mut c_void,
    plan: Option<&mut MaybeUninit<Option<Box<CrannyPlan>>>>,
) -> CrannyStatus {
    guarded(|| {
        let asked = &given(scenario, "scenario")?.asked;
        let options = parsed::<Options>(options)?;
        let margins = options.margins(asked)?;
        let mut problem = asked.problem(margins)?;
        if options.strict_pairs {
            problem = problem.checking_all_pairs();
        }
        let options = options.plan_options(asked)?;
        let (request, task) = options.request(&problem, Some(&asked.scenario))?;
        let mut source = asked.source(margins);
        source.task = task;
        let answer = solve(&problem, &request, &mut Stopper { should_stop, context })?;
        put(plan, "plan", Some(CrannyPlan::of(asked.clone(), problem, source, answer)))
    })
}

/// Options of a verification, in the words of Python's `verify_path`.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct VerifyOptions {
    margin_m: f64,
    grasp_margin_m: f64,
    strict_pairs: bool,
    any_end: bool,
}

/// Verifies a path from any source, `rows` × `dof` way points joined by straight lines, under the criterion of a scenario. The
/// caller frees the verification with cranny_verification_free.
///
/// `options`: NULL, or a JSON object with any of "margin_m", "grasp_margin_m" (required clearances in metres), "strict_pairs"
/// (true: link pairs that are otherwise not compared count too), "any_end" (true: the path need not end at a goal).
#[unsafe(no_mangle)]
pub extern "C" fn cranny_verify_path(
    scenario: Option<&CrannyScenario>,
    path: Numbers<'_>,
    rows: usize,
    dof: usize,
    options: Text<'_>,
    verification: Option<&mut MaybeUninit<Option<Box<CrannyVerification>>>>,
) -> CrannyStatus {
    guarded(|| {
        let asked = &given(scenario, "scenario")?.asked;
        check_dof(&asked.scenario.robot, dof)?;
        let path = path.finite("path", rows, dof)?.chunks_exact(dof.max(1));
        let path: Vec<Vec<f64>> = path.map(<[f64]>::to_vec).collect();
        let VerifyOptions { margin_m, grasp_margin_m, strict_pairs, any_end } = parsed(options)?;
        let mut problem = asked.problem(Margins { margin_m, grasp_margin_m, ..Margins::default() })?;
        if strict_pairs {
            problem = problem.checking_all_pairs();
        }
        let settings = AuditSettings { at_goal: !any_end, ..AuditSettings::default() };
        let audit = audit_with(&problem, &path, settings)?;
        put(verification, "verification", Some(CrannyVerification::of(audit)))
    })
}
