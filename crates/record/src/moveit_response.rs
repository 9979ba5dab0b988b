use cranny_file::distinct;
use cranny_plan::Outcome;
use cranny_scenario::MoveItProblem;
use cranny_solve::{Answer, TaskTrajectory};
use cranny_task::{ConfigurationFault, Problem};
use serde_json::{Value, json};

use crate::{PlanFile, RecordError};

/// Error codes of `moveit_msgs/MoveItErrorCodes`.
mod code {
    pub const SUCCESS: i32 = 1;
    pub const PLANNING_FAILED: i32 = -1;
    pub const INVALID_MOTION_PLAN: i32 = -2;
    pub const TIMED_OUT: i32 = -6;
    pub const PREEMPTED: i32 = -7;
    pub const START_STATE_IN_COLLISION: i32 = -10;
    pub const START_STATE_VIOLATES_PATH_CONSTRAINTS: i32 = -11;
    pub const GOAL_IN_COLLISION: i32 = -12;
    pub const GOAL_VIOLATES_PATH_CONSTRAINTS: i32 = -13;
    pub const START_STATE_INVALID: i32 = -26;
    pub const GOAL_STATE_INVALID: i32 = -27;
}

/// Maximum number of faults in a message.
const MOST_FAULTS: usize = 8;

/// Returns the response to a request as `moveit_msgs/MotionPlanResponse`, and under `cranny` what was proven.
///
/// # Errors
/// [`RecordError`] for an invalid sample rate.
pub(crate) fn response(
    asked: &MoveItProblem,
    problem: &Problem,
    answer: &Answer,
    rate_hz: f64,
) -> Result<Value, RecordError> {
    let faults = match answer.outcome {
        Outcome::StartInvalid => problem.configuration_faults(problem.start()),
        Outcome::GoalsInvalid => answer.goal_faults.concat(),
        _ => Vec::new(),
    };
    let points = match &answer.timed {
        Some(timed) => timed_points(&timed.trajectory, rate_hz)?,
        None => answer.waypoints().iter().map(|waypoint| point(waypoint, &[], &[], 0.0)).collect(),
    };
    let header = || json!({"stamp": duration(0.0), "frame_id": ""});
    let audit = answer.audit.as_ref();
    let is_solved = answer.is_solved();
    Ok(json!({
        "motion_plan_response": {
            "trajectory_start": {"joint_state": {
                "header": header(), "name": answer.joint_names, "position": asked.start,
            }},
            "group_name": asked.group,
            "trajectory": {"joint_trajectory": {
                "header": header(),
                "joint_names": answer.joint_names,
                "points": if is_solved { points } else { Vec::new() },
            }},
            "planning_time": planning_time_s(answer),
            "error_code": {"val": code_of(answer, asked, &faults), "message": message(answer, asked, &faults), "source": "cranny"},
        },
        "cranny": {
            "version": PlanFile::VERSION,
            "outcome": answer.outcome,
            "planner": answer.planner,
            "valid": answer.is_valid(),
            "clearance_m": audit.and_then(|audit| audit.clearance_m),
            "clearance_limit": audit.and_then(|audit| audit.clearance_limit.as_ref()),
            "not_checked": answer.not_checked,
            "deviations": asked.deviations.iter().map(ToString::to_string).collect::<Vec<_>>(),
            "timing": answer.timed.as_ref().map(|timed| timed.trajectory.method().name()),
            "untimed": answer.untimed,
            "waypoints": answer.waypoints(),
        },
    }))
}

/// Returns the time of search, shortening and timing, in seconds, without that of reading and of the proof.
fn planning_time_s(answer: &Answer) -> f64 {
    let others_s = [
        answer.shortening.map(|shortening| shortening.time_s),
        answer.optimisation.as_ref().map(|optimisation| optimisation.time_s),
        answer.timed.as_ref().map(|timed| timed.time_s),
    ];
    answer.statistics.planning_time_s + others_s.into_iter().flatten().sum::<f64>()
}

/// Kinds of faults of a start or goal, for which MoveIt has different codes.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Limit,
    Constraint,
    Contact,
}

impl Kind {
    fn of(asked: &MoveItProblem, fault: &ConfigurationFault) -> Self {
        match fault {
            ConfigurationFault::OutOfBounds { .. } => Self::Constraint,
            // A joint constraint narrows the limits of the robot.
            ConfigurationFault::JointLimit { joint, value, .. } => {
                let mut limits = asked.robot.joint_names().iter().zip(&asked.joint_limits);
                let is_within = limits.any(|(name, limits)| name == joint && limits.contain(*value));
                if is_within { Self::Constraint } else { Self::Limit }
            }
            _ => Self::Contact,
        }
    }

    fn predicate(self) -> &'static str {
        match self {
            Self::Limit => "is beyond a joint limit",
            Self::Constraint => "violates a path constraint",
            Self::Contact => "is in collision",
        }
    }
}

/// Returns the error code of an outcome; of an invalid start or goal by the kind of its first fault.
fn code_of(answer: &Answer, asked: &MoveItProblem, faults: &[ConfigurationFault]) -> i32 {
    let of_fault =
        |[contact, bound, limit]: [i32; 3]| match faults.first().map(|fault| Kind::of(asked, fault)) {
            Some(Kind::Limit) => limit,
            Some(Kind::Constraint) => bound,
            Some(Kind::Contact) | None => contact,
        };
    match answer.outcome {
        Outcome::Solved if answer.is_valid() => code::SUCCESS,
        Outcome::Solved => code::INVALID_MOTION_PLAN,
        Outcome::BudgetExhausted => code::TIMED_OUT,
        Outcome::Cancelled => code::PREEMPTED,
        Outcome::GaveUp
        | Outcome::ClaimedNotProven
        | Outcome::NoReachableGrasp
        | Outcome::RegionOutOfReach => code::PLANNING_FAILED,
        Outcome::StartInvalid => of_fault([
            code::START_STATE_IN_COLLISION,
            code::START_STATE_VIOLATES_PATH_CONSTRAINTS,
            code::START_STATE_INVALID,
        ]),
        Outcome::GoalsInvalid => of_fault([
            code::GOAL_IN_COLLISION,
            code::GOAL_VIOLATES_PATH_CONSTRAINTS,
            code::GOAL_STATE_INVALID,
        ]),
    }
}

fn message(answer: &Answer, asked: &MoveItProblem, faults: &[ConfigurationFault]) -> String {
    if answer.outcome == Outcome::Solved && !answer.is_valid() {
        return "the path of the planner could not be proven".to_owned();
    }
    let subject = if answer.outcome == Outcome::StartInvalid { "the start" } else { "every goal" };
    let mut message = match kinds(asked, faults)[..] {
        [] => answer.outcome.sentence().to_owned(),
        [kind] => format!("{subject} {}", kind.predicate()),
        [ref others @ .., last] => {
            let others: Vec<&str> = others.iter().map(|kind| kind.predicate()).collect();
            format!("{subject} {} or {}", others.join(", "), last.predicate())
        }
    };
    for (index, fault) in faults.iter().take(MOST_FAULTS).enumerate() {
        message += if index == 0 { ": " } else { "; " };
        message += &sentence(asked, fault);
    }
    message
}

/// Describes a fault, with the range of a joint as that of its path constraint if this is what excludes its value.
fn sentence(asked: &MoveItProblem, fault: &ConfigurationFault) -> String {
    match fault {
        ConfigurationFault::JointLimit { joint, value, lower, upper }
            if Kind::of(asked, fault) == Kind::Constraint =>
        {
            let [value, lower, upper] = distinct([*value, *lower, *upper], 4);
            format!("{joint} is {value}, outside [{lower}, {upper}], the range of its path constraint")
        }
        fault => fault.to_string(),
    }
}

/// Returns the kinds of faults, each once, in their order.
fn kinds(asked: &MoveItProblem, faults: &[ConfigurationFault]) -> Vec<Kind> {
    let mut kinds: Vec<Kind> = Vec::new();
    for fault in faults {
        let kind = Kind::of(asked, fault);
        if !kinds.contains(&kind) {
            kinds.push(kind);
        }
    }
    kinds
}

fn timed_points(trajectory: &TaskTrajectory, rate_hz: f64) -> Result<Vec<Value>, RecordError> {
    /// Maximum number of points of a response: an hour and a half at 20 Hz; more would fill the memory of server and client.
    const MOST_POINTS: f64 = 100_000.0;
    let count = trajectory.duration_s() * rate_hz;
    if count > MOST_POINTS {
        let problem = format!(
            "the trajectory takes {:.0} s, which are {count:.0} points at {rate_hz} Hz, but a response has at most {MOST_POINTS} \
             (give higher max_velocity_scaling_factor and max_acceleration_scaling_factor, or start with a lower --rate)",
            trajectory.duration_s()
        );
        return Err(RecordError::PlanOptions { field: "motion_plan_request", problem });
    }
    let samples = trajectory.samples(rate_hz)?;
    Ok(samples.map(|at| point(&at.position, &at.velocity, &at.acceleration, at.time_s)).collect())
}

/// Returns a `trajectory_msgs/JointTrajectoryPoint`.
fn point(positions: &[f64], velocities: &[f64], accelerations: &[f64], time_s: f64) -> Value {
    json!({
        "positions": positions,
        "velocities": velocities,
        "accelerations": accelerations,
        "effort": [],
        "time_from_start": duration(time_s),
    })
}

/// Returns a `builtin_interfaces/Duration`, rounded to nanoseconds.
fn duration(time_s: f64) -> Value {
    let time = std::time::Duration::try_from_secs_f64(time_s).unwrap_or_default();
    json!({"sec": time.as_secs(), "nanosec": time.subsec_nanos()})
}
