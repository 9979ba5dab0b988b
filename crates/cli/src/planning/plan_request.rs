use std::path::Path;

use cranny_file::counted;
use cranny_grasp::ScoreKind;
use cranny_path::TimingMethod;
use cranny_record::{CarryGoal, PlanOptions, SpeedOptions, TaskSelection, read_waypoints};
use cranny_scenario::STEPS;
use cranny_task::Move;

use crate::arguments::PlanArguments;
use crate::failure::Failure;

/// Parses the destination of `--carry`.
fn carry(given: &str, joints: usize) -> Result<CarryGoal, Failure> {
    match given {
        "home" => return Ok(CarryGoal::Home),
        "out" => return Ok(CarryGoal::Out),
        _ => {}
    }
    let values: Option<Vec<f64>> = given.split(',').map(|value| value.trim().parse().ok()).collect();
    let ends = match values {
        Some(values) if values.len() == joints => vec![values],
        Some(values) => {
            let problem =
                format!("{}, but the robot has {}", counted(values.len(), "value"), counted(joints, "joint"));
            return Err(Failure::Flag { flag: "carry", problem });
        }
        None if !Path::new(given).exists() => {
            let problem = format!(
                "'{given}' is not a valid destination: expected `home`, `out`, {} separated by commas, or a \
                 file",
                counted(joints, "value")
            );
            return Err(Failure::Flag { flag: "carry", problem });
        }
        None => read_waypoints(Path::new(given), joints)?,
    };
    Ok(CarryGoal::Configurations(ends))
}

/// Builds the request from the flags, for a robot with `joints` joints.
pub fn ask(arguments: &PlanArguments, joints: usize) -> Result<PlanOptions, Failure> {
    Ok(PlanOptions {
        planner: arguments.planner.clone(),
        settings: arguments.set.iter().cloned().collect(),
        seed: arguments.seed,
        time_limit: arguments.time_limit,
        iterations: arguments.iterations,
        score: score(arguments)?,
        min_score: arguments.min_score.map(|least| least.least),
        goal_threshold: arguments.goal_threshold,
        keep_path: arguments.no_shortcut,
        optimise: arguments.optimise,
        cost: arguments.cost.map(Into::into),
        score_weight: arguments.score_weight,
        timing: match arguments.timing {
            Some(timing) => Some(timing.into()),
            None => arguments.jerk_limited.then_some(TimingMethod::JerkLimited),
        },
        stops: arguments.stop_at_corners,
        paces: SpeedOptions {
            speed: arguments.speed.clone(),
            acceleration: arguments.acceleration.clone(),
            tool_speed: arguments.tool_speed.clone(),
            turn_speed: arguments.turn_speed.clone(),
        },
        torque: arguments.torque,
        is_timing_demanded: arguments.rate.is_some(),
        carry: arguments.carry.as_deref().map(|given| carry(given, joints)).transpose()?,
        place: arguments.place.clone(),
        goal_region: (!arguments.goal_region.is_empty())
            .then(|| Move::NamedRegions(arguments.goal_region.clone())),
        task: {
            let steps = arguments.steps.then(|| STEPS.to_owned());
            steps.or_else(|| arguments.named_task.clone()).map(TaskSelection::Named)
        },
        then: arguments.then.map(Into::into),
        clear_m: arguments.clear.map(|clear_mm| clear_mm / 1e3),
        approach_m: arguments.approach.map(|approach_cm| approach_cm / 100.0),
        retreat_m: arguments.retreat.map(|retreat_cm| retreat_cm / 100.0),
        robust: arguments.robust,
        hold: arguments.hold,
        ..PlanOptions::default()
    })
}

/// Returns the kind of score that either of its flags requests.
fn score(arguments: &PlanArguments) -> Result<Option<ScoreKind>, Failure> {
    let asked = arguments.score.map(ScoreKind::from);
    match (asked, arguments.min_score.and_then(|least| least.kind)) {
        (Some(asked), Some(of_least)) if asked != of_least => {
            let (asked, of_least) = (asked.name(), of_least.name());
            let problem = format!("its score, {of_least}, differs from that of --score, {asked}");
            Err(Failure::Flag { flag: "min-score", problem })
        }
        (asked, of_least) => Ok(asked.or(of_least)),
    }
}
