//! `CrannyPlan`: a planning result with everything needed to verify, follow and reproduce it.

use std::ffi::{CString, c_char};
use std::mem::MaybeUninit;
use std::path::Path;
use std::ptr::null;
use std::sync::{Arc, OnceLock};

use cranny::path::AuditSettings;
use cranny::record::{PlanFile, PlanSource};
use cranny::solve::TaskTrajectory;
use cranny::{Answer, Outcome, Problem};

use crate::boundary::{NumberBuffer, Text, answered, given, guarded, put};
use crate::error::{CrannyStatus, Fault};
use crate::robot::check_dof;
use crate::samples::CrannySamples;
use crate::scenario::{Asked, CrannyScenario};
use crate::text::c_text;
use crate::verification::CrannyVerification;

/// Result of planning: a path, its timing, its proof and the statistics of the search. It never changes.
#[derive(Debug)]
pub struct CrannyPlan {
    asked: Arc<Asked>,
    problem: Problem,
    source: PlanSource,
    file: PlanFile,
    is_valid: bool,
    trajectory: Option<TaskTrajectory>,
    path: Vec<f64>,
    planner: CString,
    outcome: CString,
    json: OnceLock<CString>,
}

impl CrannyPlan {
    /// Wraps the answer to a request.
    pub fn of(asked: Arc<Asked>, problem: Problem, source: PlanSource, answer: Answer) -> Box<Self> {
        let file = PlanFile::of(&answer, &source);
        let is_valid = answer.is_valid();
        let trajectory = answer.timed.map(|timed| timed.trajectory);
        Self::with(asked, problem, source, (file, is_valid, trajectory))
    }

    fn with(
        asked: Arc<Asked>,
        problem: Problem,
        source: PlanSource,
        (file, is_valid, trajectory): (PlanFile, bool, Option<TaskTrajectory>),
    ) -> Box<Self> {
        let path = file.waypoints.iter().flatten().copied().collect();
        let (planner, outcome) = (c_text(&file.planner), c_text(file.outcome.name()));
        let json = OnceLock::new();
        Box::new(Self { asked, problem, source, file, is_valid, trajectory, path, planner, outcome, json })
    }

    fn timed(&self) -> Result<&TaskTrajectory, Fault> {
        let problem = if self.file.waypoints.is_empty() {
            "it has no path to follow"
        } else {
            "it has no times: the robot has no limits of acceleration (give them in its limits.yaml), or the path is not valid"
        };
        self.trajectory.as_ref().ok_or(Fault::Lacking { what: "plan", problem })
    }
}

/// Reads a .plan.json of a scenario. No statement of the file is trusted: its path is verified again. The caller frees the plan
/// with cranny_plan_free.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_plan_load(
    path: Text<'_>,
    scenario: Option<&CrannyScenario>,
    plan: Option<&mut MaybeUninit<Option<Box<CrannyPlan>>>>,
) -> CrannyStatus {
    guarded(|| {
        let path = Path::new(path.read("path")?);
        let asked = given(scenario, "scenario")?.asked.clone();
        let file = PlanFile::read(path)?;
        let robot = &asked.scenario.robot;
        check_dof(robot, file.joint_names.len())?;
        file.check_joints(path, robot)?;
        let problem = asked.problem(file.margins)?;
        let source = file.source_in(&asked.scenario, &asked.source(file.margins));
        let judgement = file.judge(&source, &problem, AuditSettings::default())?;
        let is_valid = judgement.as_ref().is_some_and(|judgement| judgement.audit.valid);
        let trajectory = file.trajectory(robot)?.filter(|_| file.timing.is_some());
        let file = judgement.map_or(file, |judgement| judgement.measured);
        put(plan, "plan", Some(CrannyPlan::with(asked, problem, source, (file, is_valid, trajectory))))
    })
}

/// Frees a plan. NULL is ignored.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_plan_free(plan: Option<Box<CrannyPlan>>) {
    drop(plan);
}

/// Returns whether a path was found and verified under the criterion; false for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_plan_is_solved(plan: Option<&CrannyPlan>) -> bool {
    answered(false, || {
        let plan = given(plan, "plan")?;
        Ok(plan.file.outcome == Outcome::Solved && plan.is_valid)
    })
}

/// Returns the outcome of the search: "solved", "budget-exhausted", "gave-up", "cancelled", "start-invalid", "goals-invalid" or
/// "no-reachable-grasp". It is valid as long as the plan.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_plan_outcome(plan: Option<&CrannyPlan>) -> *const c_char {
    answered(null(), || Ok(given(plan, "plan")?.outcome.as_ptr()))
}

/// Returns the name of the planner, valid as long as the plan.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_plan_planner(plan: Option<&CrannyPlan>) -> *const c_char {
    answered(null(), || Ok(given(plan, "plan")?.planner.as_ptr()))
}

/// Returns the number of way points; 0 without a path.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_plan_waypoint_count(plan: Option<&CrannyPlan>) -> usize {
    answered(0, || Ok(given(plan, "plan")?.file.waypoints.len()))
}

/// Returns the number of joints of each way point; 0 for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_plan_dof(plan: Option<&CrannyPlan>) -> usize {
    answered(0, || Ok(given(plan, "plan")?.file.joint_names.len()))
}

/// Returns the way points from the start to the goal, waypoint_count × dof, joined by straight lines. They are valid as long as
/// the plan.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_plan_path(plan: Option<&CrannyPlan>) -> *const f64 {
    answered(null(), || Ok(given(plan, "plan")?.path.as_ptr()))
}

/// Returns the index of the grasp at the end of the path, or of the first pick; -1 without one.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_plan_grasp(plan: Option<&CrannyPlan>) -> i64 {
    answered(-1, || {
        Ok(given(plan, "plan")?.file.grasp.and_then(|grasp| i64::try_from(grasp).ok()).unwrap_or(-1))
    })
}

/// Returns the proven least clearance along the whole path in metres; NaN without a proof.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_plan_clearance_m(plan: Option<&CrannyPlan>) -> f64 {
    answered(f64::NAN, || Ok(given(plan, "plan")?.file.clearance_m.unwrap_or(f64::NAN)))
}

/// Returns the duration of the trajectory in seconds; NaN without one.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_plan_duration_s(plan: Option<&CrannyPlan>) -> f64 {
    answered(f64::NAN, || {
        Ok(given(plan, "plan")?.trajectory.as_ref().map_or(f64::NAN, TaskTrajectory::duration_s))
    })
}

/// Returns the content of the plan's file as JSON: segments, timing, statistics, reasons of a failure and the rest. It is valid
/// as long as the plan.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_plan_json(plan: Option<&CrannyPlan>) -> *const c_char {
    answered(null(), || {
        let plan = given(plan, "plan")?;
        let text = || c_text(&serde_json::to_string(&plan.file).unwrap_or_default());
        Ok(plan.json.get_or_init(text).as_ptr())
    })
}

/// Writes a .plan.json, whole or not at all.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_plan_save(plan: Option<&CrannyPlan>, path: Text<'_>) -> CrannyStatus {
    guarded(|| {
        let (plan, path) = (given(plan, "plan")?, path.read("path")?);
        Ok(plan.file.write(Path::new(path))?)
    })
}

/// Verifies the path again, like any external path, from its way points alone, and the statements of its file. The caller frees
/// the verification with cranny_verification_free. A plan without a path is an error.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_plan_verify(
    plan: Option<&CrannyPlan>,
    verification: Option<&mut MaybeUninit<Option<Box<CrannyVerification>>>>,
) -> CrannyStatus {
    guarded(|| {
        let plan = given(plan, "plan")?;
        let judgement = plan.file.judge(&plan.source, &plan.problem, AuditSettings::default())?;
        let lacking = Fault::Lacking { what: "plan", problem: "it has no path to verify" };
        put(verification, "verification", Some(CrannyVerification::of(judgement.ok_or(lacking)?.audit)))
    })
}

/// Samples the trajectory at `rate_hz` per second, with the end. The caller frees the samples with cranny_samples_free. A plan
/// without a trajectory is an error.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_plan_sample(
    plan: Option<&CrannyPlan>,
    rate_hz: f64,
    samples: Option<&mut MaybeUninit<Option<Box<CrannySamples>>>>,
) -> CrannyStatus {
    guarded(|| {
        let trajectory = given(plan, "plan")?.timed()?;
        put(samples, "samples", Some(CrannySamples::of(trajectory, rate_hz)?))
    })
}

/// Computes the state of the trajectory at `time_s` seconds from its beginning: at rest at the first way point before it, and at
/// the last one after its end. `position`, `velocity` and `acceleration` receive `dof` values each, in m or rad, per s and s²; any
/// of them may be NULL. A plan without a trajectory is an error.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_plan_state_at(
    plan: Option<&CrannyPlan>,
    time_s: f64,
    dof: usize,
    mut position: NumberBuffer<'_>,
    mut velocity: NumberBuffer<'_>,
    mut acceleration: NumberBuffer<'_>,
) -> CrannyStatus {
    guarded(|| {
        let plan = given(plan, "plan")?;
        check_dof(&plan.asked.scenario.robot, dof)?;
        if !time_s.is_finite() {
            return Err(Fault::Range { what: "time_s", value: time_s, expected: "must be finite" });
        }
        let state = plan.timed()?.sample(time_s);
        position.write_if_asked("position", &state.position)?;
        velocity.write_if_asked("velocity", &state.velocity)?;
        acceleration.write_if_asked("acceleration", &state.acceleration)
    })
}
