use std::f64::consts::PI;
use std::sync::Arc;
use std::time::Instant;

use cranny_path::{PathError, audit_along, audit_task, path_length};
use cranny_plan::{Budget, NoGrasp, Observer, Outcome, PlanError, PlanReport, Unobserved};
use cranny_robot::Robot;
use cranny_spatial::{Pose, other_seed};
use cranny_task::{
    Carrier, FailureReason, Goal, GraspFilter, Payload, Problem, Segment, Stage, State, StateSequence,
    give_clearances, joined,
};

use crate::hold_factors::hold_firmly;
use crate::least_length::least_length;
use crate::rounding::smooth;
use crate::way_search::{Found, found_alone, found_in_stages};
use crate::{
    Answer, HoldFactors, Request, Robustness, SolveError, TaskTrajectory, Tilt, Timed, Timing, ToolSlack,
};

/// Solves a problem with the options of a request.
///
/// 1. The planner searches for a path, and for better ones if requested. With several stages, a path through one stage counts
///    only if paths through all later stages are found (see `chain.rs`).
/// 2. A path under `exact` is shortened, unless it is kept as found or was optimised. A path of the planner `reach` to a grasp
///    or a configuration is optimised a little ([`cranny_plan::OptimiseSettings::delivery`]).
/// 3. If a trajectory is requested, corners are rounded and way points moved where that saves time and is proven free. Motions
///    with an object in the hand are slowed down until the hold is firm, if required ([`Request::hold`]).
/// 4. The result is audited like a path of any other origin, curves included, before it is called solved.
/// 5. A valid path is timed, if requested.
/// 6. Tolerated deviations are computed, if requested.
/// 7. The length of every path of the task is bounded from below, if requested ([`least_length`]).
/// 8. If a path turns a joint more than half a turn beyond need ([`Robot::needless_turn`]), or the held object would slip along
///    it at any speed, other seeds are tried first.
///
/// A search that ends without a path although a proof shows that none exists ([`NoGrasp::BaseEnclosed`]) has the outcome of that proof.
/// The absence of a path is an answer ([`Outcome`]), not an error.
///
/// # Errors
/// As [`Request::check`], and those of the planner.
pub fn solve(
    problem: &Problem,
    request: &Request,
    observer: &mut dyn Observer,
) -> Result<Answer, SolveError> {
    solve_with(problem, request, None, observer)
}

/// Solves a problem as [`solve`] does, with the carrier of the first object that is picked, which was made before: it depends on
/// the cell and the object alone, and making it takes longer than many a search. Meant for many problems in one cell.
///
/// # Errors
/// As [`solve`].
pub fn solve_with(
    problem: &Problem,
    request: &Request,
    carrier: Option<&Arc<Carrier>>,
    observer: &mut dyn Observer,
) -> Result<Answer, SolveError> {
    request.check(problem)?;
    let begin = Instant::now();
    let (mut answer, mut slips) = solve_once(problem, request, (carrier, observer))?;
    // 8.
    /// Number of other seeds; more seeds rarely help.
    const OTHER_SEEDS: u64 = 8;
    /// Iteration limit of a repeated search, as a multiple of the iterations of the first, and its least value. It does not
    /// depend on the budget of the request: a plan file states only the iterations of the first search, and must reproduce the
    /// same path.
    const PATIENCE: u64 = 4;
    const LEAST_ITERATIONS: u64 = 1000;
    let is_left = request.keep_path || request.optimise.is_some() || !answer.is_solved();
    let mut turn = if is_left { 0.0 } else { needless_turn(problem.robot(), &answer) };
    for other in 1..=OTHER_SEEDS {
        if (turn <= PI && !slips) || observer.should_stop() {
            break;
        }
        let most = PATIENCE.saturating_mul(answer.statistics.iterations).max(LEAST_ITERATIONS);
        let budget = Budget { iterations: most, time: request.budget.time.saturating_sub(begin.elapsed()) };
        let again = Request { budget, seed: other_seed(request.seed, other), ..request.clone() };
        let (found, _) = solve_once(problem, &again, (carrier, &mut Unobserved))?;
        let found_turn = needless_turn(problem.robot(), &found);
        if found.is_solved() && (slips || found_turn < turn) {
            let Answer { budget, seed, statistics, .. } = answer;
            answer = Answer { budget, seed, statistics, ..found };
            (turn, slips) = (found_turn, false);
        }
    }
    Ok(answer)
}

/// Returns the greatest turn beyond need of a joint in any segment, in radians.
fn needless_turn(robot: &Robot, answer: &Answer) -> f64 {
    let turns = answer.segments.iter().map(|segment| robot.needless_turn(&segment.waypoints));
    turns.fold(0.0, f64::max)
}

/// Performs 1 to 7 of [`solve`]. Also returns true if the held object would slip along each path found.
fn solve_once(
    problem: &Problem,
    request: &Request,
    (carrier, observer): (Option<&Arc<Carrier>>, &mut dyn Observer),
) -> Result<(Answer, bool), SolveError> {
    let (asked, numbers) = request.asked(problem)?;
    let (answer, slips) = solve_asked(&asked, request, (problem, carrier, observer))?;
    let answer = match (numbers, problem.grasps()) {
        (Some(numbers), Some(grasps)) => answer.with_grasp_numbers(&numbers, grasps.len()),
        _ => answer,
    };
    Ok((answer, slips))
}

/// Performs 1 to 7 of [`solve`] for `problem`, which has only the goal grasps of `whole`, the original problem.
fn solve_asked(
    problem: &Problem,
    request: &Request,
    (whole, carrier, observer): (&Problem, Option<&Arc<Carrier>>, &mut dyn Observer),
) -> Result<(Answer, bool), SolveError> {
    let stages = request.stages_of(problem);
    let first = request.first_problem(problem)?;
    let planner = request.planner_for(&first)?;
    // 1. and 2.
    let found = match (&stages[..], request.left_out_filter(0)) {
        ([_], None) if request.stages.is_empty() => {
            found_alone(problem, planner.as_ref(), request, observer)?
        }
        ([_], Some(is_left_out)) if request.stages.is_empty() => {
            let fault = move |tip: &Pose| is_left_out(tip).then_some(FailureReason::LeftOut);
            let left = problem.clone().with_grasp_filter(GraspFilter::new(fault));
            found_alone(&left, planner.as_ref(), request, observer)?
        }
        (stages, _) => found_in_stages(problem, planner.as_ref(), (stages, request), (carrier, observer))?,
    };
    let Found {
        report: PlanReport { outcome, statistics, failures, refused, .. },
        segments,
        unshortened,
        shortening,
        optimisation,
        carrier,
    } = found;
    // 3.
    let firm = firm(problem, &stages, request, ([segments, unshortened], carrier.as_ref()))?;
    let is_firm = firm.is_some();
    let (mut segments, along, hold, rounding_s) = firm.unwrap_or_default();
    let outcome = if is_firm { outcome } else { Outcome::GaveUp };
    // 4.
    let audit = match (&segments[..], &along) {
        ([], _) => None,
        (segments, Some(along)) => Some(audit_along(problem, &stages, (segments, along), request.audit)?),
        (segments, None) => Some(audit_task(problem, &stages, segments, request.audit)?),
    };
    // 5.
    let holds = outcome == Outcome::Solved && audit.as_ref().is_some_and(|audit| audit.valid);
    let timed = match request.timing {
        Some(timing) if holds => timed(problem, timing, &segments, rounding_s)?,
        _ => None,
    };
    if let Some(audit) = &audit {
        give_clearances(&mut segments, &audit.clearances_per_edge_m);
    }
    let not_checked = audit.as_ref().map_or_else(|| problem.not_checked(), |audit| audit.not_checked.clone());
    let is_grasp_missed = matches!(
        outcome,
        Outcome::BudgetExhausted
            | Outcome::ClaimedNotProven
            | Outcome::Cancelled
            | Outcome::GaveUp
            | Outcome::NoReachableGrasp
            | Outcome::RegionOutOfReach
    );
    let no_grasp = if is_grasp_missed { NoGrasp::of(&first, &failures) } else { None };
    let outcome = proven_outcome(outcome, no_grasp.as_ref(), first.goal());
    let refused = refused.filter(|_| outcome == Outcome::ClaimedNotProven);
    let goal_faults = if outcome == Outcome::GoalsInvalid { first.goal_faults() } else { Vec::new() };
    // 6.
    let holds = holds && audit.as_ref().is_some_and(|audit| audit.valid);
    let proven = along.as_ref().filter(|_| holds);
    let tilt = proven.and_then(|along| Tilt::of(along, &segments));
    let tool = proven.map_or_else(Vec::new, |along| ToolSlack::all_of(along, &segments));
    let robustness = along.filter(|_| request.robustness && holds);
    let robustness = || Robustness::of(&robustness?, &segments);
    // 7. The bound covers paths to all grasps of the original problem, because excluded grasps may be nearer.
    let is_bounded = request.least_length && holds;
    let length = || path_length(&joined(&segments));
    let least = || if is_bounded { least_length(whole, &request.stages, length()) } else { None };
    let (robustness, least_length) = rayon::join(robustness, least);
    let limits = request.timing.map(|timing| timing.limits(problem.robot()));
    let untimed = limits.and_then(Result::err).map(|fault| fault.to_string());
    let answer = Answer {
        planner: planner.name().to_owned(),
        settings: planner.settings(),
        criterion: problem.criterion(),
        score: request.score_of(problem),
        min_score: request.min_score,
        below_min_score: None,
        goal_threshold: problem.goal_threshold(),
        budget: request.budget,
        seed: request.seed,
        joint_names: problem.robot().joint_names().to_vec(),
        outcome,
        stages: request.stages.clone(),
        segments,
        audit,
        timed,
        untimed,
        robustness,
        least_length,
        tilt,
        tool,
        hold_demanded: request.hold.filter(|_| !request.stages.is_empty()),
        hold: hold.filter(|_| holds),
        shortening: shortening.filter(|_| is_firm),
        optimisation,
        statistics,
        failures,
        goal_faults,
        no_grasp,
        refused,
        not_checked,
    };
    Ok((answer, !is_firm))
}

/// Returns the outcome that a proof gives to a search without a path.
fn proven_outcome(outcome: Outcome, reason: Option<&NoGrasp>, goal: &Goal) -> Outcome {
    let is_open = matches!(outcome, Outcome::BudgetExhausted | Outcome::ClaimedNotProven | Outcome::GaveUp);
    match (reason, goal) {
        (Some(NoGrasp::BaseEnclosed(_)), Goal::Grasps(_)) if is_open => Outcome::NoReachableGrasp,
        (Some(NoGrasp::BaseEnclosed(_)), Goal::Regions(_)) if is_open => Outcome::RegionOutOfReach,
        _ => outcome,
    }
}

/// Segments, the states along them, the firmness of the hold, and the seconds spent on rounding corners.
type Firm = (Vec<Segment>, Option<StateSequence>, Option<HoldFactors>, f64);

/// Performs 3 of [`solve`]: returns the first of these paths on which the hold is firm, slowed down as needed; `None` without
/// one. The paths turn the object differently: if the hold on the shortened path is weak, the original one is tried.
fn firm(
    problem: &Problem,
    stages: &[Stage],
    request: &Request,
    (paths, carrier): ([Vec<Segment>; 2], Option<&Arc<Carrier>>),
) -> Result<Option<Firm>, SolveError> {
    let timing = request.timing.unwrap_or_default();
    let [first, _] = &paths;
    if first.is_empty() {
        return Ok(Some(Firm::default()));
    }
    for mut segments in paths.into_iter().filter(|path| !path.is_empty()) {
        for segment in &mut segments {
            segment.pace = request.paces.of(segment.mode);
        }
        let along = StateSequence::with_carrier(problem, stages, &segments, carrier)?;
        if let Some(along) = along.as_ref().filter(|_| timing.torque_up.is_some()) {
            for (segment, state) in segments.iter_mut().zip(&along.states) {
                segment.payload = payload(state, problem)?;
            }
        }
        let begin = Instant::now();
        if let Some(along) = along.as_ref().filter(|_| request.timing.is_some_and(|timing| !timing.stops)) {
            // An optimised path keeps its stated cost.
            let may_move = !request.keep_path && request.optimise.is_none();
            smooth(problem.robot(), along, &mut segments, (timing, may_move));
        }
        let rounding_s = begin.elapsed().as_secs_f64();
        let hold = match (request.hold, &along) {
            (Some(demanded), Some(along)) if along.stopped.is_none() => {
                hold_firmly(problem, along, &mut segments, (timing, demanded))?
            }
            _ => Ok(None),
        };
        if let Ok(hold) = hold {
            return Ok(Some((segments, along, hold, rounding_s)));
        }
    }
    Ok(None)
}

/// Returns the payload of the hand in a state, if it holds an object.
fn payload(state: &State, problem: &Problem) -> Result<Option<Payload>, PathError> {
    let Some((carrier, _)) = state.held() else { return Ok(None) };
    let unknown = || PathError::UnknownMass { object: carrier.object().to_owned() };
    state.payload(problem).ok_or_else(unknown).map(Some)
}

/// Performs 5 of [`solve`] for a valid path; `None` for a robot without the required limits.
fn timed(
    problem: &Problem,
    timing: Timing,
    segments: &[Segment],
    rounding_s: f64,
) -> Result<Option<Timed>, PlanError> {
    let begin = Instant::now();
    let trajectory = TaskTrajectory::of(timing, problem.robot(), segments)?;
    Ok(trajectory.map(|trajectory| Timed { trajectory, time_s: rounding_s + begin.elapsed().as_secs_f64() }))
}
