use std::f64::consts::PI;
use std::sync::Arc;
use std::time::Instant;

use cranny_path::{ShortcutSettings, audit_along, audit_task, shortcut};
use cranny_plan::{
    Budget, Improvement, NoGrasp, Observer, OptimiseSettings, Outcome, PlanError, PlanReport, Planner, Reach,
    Statistics, Unobserved, better, optimise, search,
};
use cranny_robot::Robot;
use cranny_spatial::{Pose, other_seed};
use cranny_task::{
    Carrier, Criterion, FailureReason, GraspFilter, Problem, Segment, Stage, StatesAlong, give_clearances,
};

use crate::chain::{Chain, Piece};
use crate::hold::hold_firmly;
use crate::rounding::smooth;
use crate::{
    Answer, Hold, Optimisation, Request, Robustness, Shortening, SolveError, TaskTrajectory, Tilt, Timed,
    Timing,
};

/// Solves a problem as a request says.
///
/// 1. The planner looks for a path; better ones are looked for if that is asked. Of several stages a path through one counts
///    only if there is one through all that follow (see `chain.rs`).
/// 2. A path under `exact` is shortened, unless it is to be kept or was bettered; that of `reach` to a grasp or a
///    configuration is bettered a little ([`OptimiseSettings::delivery`]).
/// 3. If a trajectory is asked, corners are rounded where the curve is proven free. Motions with an object in the hand are
///    slowed down until the hand holds it firmly, if that is demanded ([`Request::hold`]).
/// 4. Whatever was found is judged like anybody's path, curves included, before it is called solved.
/// 5. A path that holds gets its time, if that is asked.
/// 6. How far things may be from where it has them is worked out, if that is asked.
/// 7. A path that turns a joint half a turn beyond need is not delivered before other seeds were tried: see
///    [`Robot::needless_turn`].
///
/// That there is no path is an answer ([`Outcome`]), no error.
///
/// # Errors
/// As [`Request::check`], and those of the planner.
pub fn solve(
    problem: &Problem,
    request: &Request,
    observer: &mut dyn Observer,
) -> Result<Answer, SolveError> {
    request.check(problem)?;
    let begin = Instant::now();
    let mut answer = solve_once(problem, request, observer)?;
    // 7.
    /// More seeds find little that these do not.
    const OTHER_SEEDS: u64 = 8;
    /// A search that takes so many times the iterations of the first, and some, is not waited for. What the request
    /// allows plays no part: a plan file tells the iterations of the first search alone, and leads to the same path.
    const PATIENCE: u64 = 4;
    const LEAST_ITERATIONS: u64 = 1000;
    let is_left = request.keep_path || request.optimise.is_some() || !answer.is_solved();
    let mut turn = if is_left { 0.0 } else { needless_turn(problem.robot(), &answer) };
    for other in 1..=OTHER_SEEDS {
        if turn <= PI || observer.should_stop() {
            break;
        }
        let most = PATIENCE.saturating_mul(answer.statistics.iterations).max(LEAST_ITERATIONS);
        let budget = Budget { iterations: most, time: request.budget.time.saturating_sub(begin.elapsed()) };
        let again = Request { budget, seed: other_seed(request.seed, other), ..request.clone() };
        let found = solve_once(problem, &again, &mut Unobserved)?;
        let found_turn = needless_turn(problem.robot(), &found);
        if found.is_solved() && found_turn < turn {
            let Answer { budget, seed, statistics, .. } = answer;
            answer = Answer { budget, seed, statistics, ..found };
            turn = found_turn;
        }
    }
    Ok(answer)
}

/// The most that any segment turns a joint beyond need, in radians.
fn needless_turn(robot: &Robot, answer: &Answer) -> f64 {
    let turns = answer.segments.iter().map(|segment| robot.needless_turn(&segment.waypoints));
    turns.fold(0.0, f64::max)
}

/// Steps 1 to 6.
fn solve_once(
    problem: &Problem,
    request: &Request,
    observer: &mut dyn Observer,
) -> Result<Answer, SolveError> {
    let (asked, numbers) = request.asked(problem)?;
    let answer = solve_asked(&asked, request, observer)?;
    Ok(match (numbers, problem.grasps()) {
        (Some(numbers), Some(grasps)) => answer.with_grasp_numbers(&numbers, grasps.len()),
        _ => answer,
    })
}

/// The same of the problem as the request asks it.
fn solve_asked(
    problem: &Problem,
    request: &Request,
    observer: &mut dyn Observer,
) -> Result<Answer, SolveError> {
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
        (stages, _) => found_in_stages(problem, planner.as_ref(), (stages, request), observer)?,
    };
    let Found {
        report: PlanReport { outcome, statistics, failures, .. },
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
        Outcome::BudgetExhausted | Outcome::Cancelled | Outcome::GaveUp | Outcome::NoReachableGrasp
    );
    let no_grasp = if is_grasp_missed { NoGrasp::of(&first, &failures) } else { None };
    let goal_faults = if outcome == Outcome::GoalsInvalid { first.goal_faults() } else { Vec::new() };
    // 6.
    let holds = holds && audit.as_ref().is_some_and(|audit| audit.valid);
    let tilt = along.as_ref().filter(|_| holds).and_then(|along| Tilt::of(along, &segments));
    let robustness = along.filter(|_| request.robustness && holds);
    let robustness = robustness.and_then(|along| Robustness::of(&along, &segments));
    let limits = request.timing.map(|timing| timing.limits(problem.robot()));
    let untimed = limits.and_then(Result::err).map(|fault| fault.to_string());
    Ok(Answer {
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
        tilt,
        hold_demanded: request.hold.filter(|_| !request.stages.is_empty()),
        hold: hold.filter(|_| holds),
        shortening,
        optimisation,
        statistics,
        failures,
        goal_faults,
        no_grasp,
        not_checked,
    })
}

/// Outcome of the search, and the segments as they are delivered.
struct Found {
    report: PlanReport,
    segments: Vec<Segment>,
    /// The segments as they were found, where they were shortened.
    unshortened: Vec<Segment>,
    shortening: Option<Shortening>,
    optimisation: Option<Optimisation>,
    /// The carrier of the first object.
    carrier: Option<Arc<Carrier>>,
}

/// Steps 1 and 2 for the goal of the problem alone.
fn found_alone(
    problem: &Problem,
    planner: &dyn Planner,
    request: &Request,
    observer: &mut dyn Observer,
) -> Result<Found, SolveError> {
    let (report, optimisation) = searched(planner, problem, request, observer)?;
    observer.search_ended();
    let is_shortened =
        problem.criterion() == Criterion::Exact && optimisation.is_none() && !request.keep_path;
    let (mut report, shortening) = if is_shortened && !report.path.is_empty() {
        let (report, shortening) = shortened(problem, planner, report, request.seed)?;
        (report, Some(shortening))
    } else {
        (report, None)
    };
    let path = std::mem::take(&mut report.path);
    let segments = if path.is_empty() { Vec::new() } else { vec![Segment::reach(path, Vec::new())] };
    Ok(Found { report, segments, unshortened: Vec::new(), shortening, optimisation, carrier: None })
}

/// Steps 1 and 2 for several stages: each segment that is not bound to what carries an object is shortened, or bettered,
/// between its ends, for the hand holds an object as it stands where a segment ends.
fn found_in_stages(
    problem: &Problem,
    planner: &dyn Planner,
    (stages, request): (&[Stage], &Request),
    observer: &mut dyn Observer,
) -> Result<Found, SolveError> {
    let chain = Chain::new(problem, stages, request)?;
    let carrier = chain.first_carrier.clone();
    let (report, pieces) = chain.search(planner, observer)?;
    observer.search_ended();
    let begin = Instant::now();
    let is_found = !pieces.is_empty();
    let unshortened = pieces.iter().map(|(segment, _)| segment.clone()).collect();
    let (segments, optimisation) = match request.optimise.filter(|_| is_found) {
        Some(settings) => {
            let (segments, optimisation) = bettered(pieces, &report, (settings, request), observer)?;
            (segments, Some(optimisation))
        }
        None if request.keep_path => (pieces.into_iter().map(|(segment, _)| segment).collect(), None),
        None => (shortened_pieces(pieces, request.seed)?, None),
    };
    let is_shortened = is_found && optimisation.is_none() && !request.keep_path;
    let attempts = ShortcutSettings::default().attempts;
    let time_s = begin.elapsed().as_secs_f64();
    let shortening = is_shortened.then_some(Shortening { attempts, searches: 0, time_s });
    Ok(Found { report, segments, unshortened, shortening, optimisation, carrier })
}

/// Segments, the states along them, how firmly the hand holds what it carries, and the seconds in which corners were rounded.
type Firm = (Vec<Segment>, Option<StatesAlong>, Option<Hold>, f64);

/// Step 3: the first of these paths on which the hand holds what it carries, as fast as it does; `None` where it does on
/// none. A shortened path turns the object otherwise than the one that was found.
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
        let along = StatesAlong::with_carrier(problem, stages, &segments, carrier)?;
        let begin = Instant::now();
        if let Some(along) = along.as_ref().filter(|_| request.timing.is_some_and(|timing| !timing.stops)) {
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

fn shortened_pieces(pieces: Vec<Piece>, seed: u64) -> Result<Vec<Segment>, PlanError> {
    let settings = ShortcutSettings { seed, ..ShortcutSettings::default() };
    let shortened = pieces.into_iter().map(|(segment, problem)| match problem {
        Some(problem) => {
            let waypoints = shortcut(&problem, &segment.waypoints, settings)?.path;
            Ok(Segment { waypoints, ..segment })
        }
        None => Ok(segment),
    });
    shortened.collect()
}

/// The segments, each that can be bettered with an equal share of time and iterations; their costs are added up.
fn bettered(
    pieces: Vec<Piece>,
    report: &PlanReport,
    (settings, request): (OptimiseSettings, &Request),
    observer: &mut dyn Observer,
) -> Result<(Vec<Segment>, Optimisation), PlanError> {
    let begin = Instant::now();
    let free = pieces.iter().filter(|(_, problem)| problem.is_some()).count();
    let time = settings.time / u32::try_from(free.max(1)).unwrap_or(u32::MAX);
    let left = request.budget.iterations.saturating_sub(report.statistics.iterations);
    let most = settings.iterations.min(left / free.max(1) as u64);
    let of_piece = OptimiseSettings { time, iterations: most, score_weight: 0.0, ..settings };
    let (mut segments, mut steps) = (Vec::new(), Vec::new());
    let (mut iterations, mut first_cost) = (report.statistics.iterations, 0.0);
    for (segment, problem) in pieces {
        let Some(problem) = problem else {
            segments.push(segment);
            continue;
        };
        let statistics =
            Statistics { planning_time_s: begin.elapsed().as_secs_f64(), ..Statistics::default() };
        let path = segment.waypoints.clone();
        let first = PlanReport { outcome: Outcome::Solved, path, statistics, failures: Vec::new() };
        let found = better(&problem, first, of_piece, request.seed, observer)?;
        let costs = found.improvements;
        first_cost += costs.first().map_or(0.0, |first| first.cost);
        steps.extend(costs.windows(2).map(|pair| {
            let iterations = iterations + pair[1].iterations;
            (pair[0].cost - pair[1].cost, Improvement { iterations, ..pair[1] })
        }));
        iterations += found.iterations;
        segments.push(Segment { waypoints: found.report.path, ..segment });
    }
    let search_s = report.statistics.planning_time_s;
    let first = Improvement { time_s: search_s, iterations: report.statistics.iterations, cost: first_cost };
    let mut improvements = vec![first];
    for (saved, step) in steps {
        first_cost -= saved;
        improvements.push(Improvement { cost: first_cost, time_s: search_s + step.time_s, ..step });
    }
    Ok((segments, Optimisation { settings, time_s: begin.elapsed().as_secs_f64(), iterations, improvements }))
}

/// Step 1: the search, and with `optimise` those for better paths.
fn searched(
    planner: &dyn Planner,
    problem: &Problem,
    request: &Request,
    observer: &mut dyn Observer,
) -> Result<(PlanReport, Option<Optimisation>), PlanError> {
    let (budget, seed) = (&request.budget, request.seed);
    let Some(settings) = request.optimise else {
        return Ok((search(planner, problem, budget, seed, observer)?, None));
    };
    let optimised = optimise(planner, problem, budget, settings, seed, observer)?;
    let optimisation = Optimisation {
        settings,
        time_s: optimised.time_s,
        iterations: optimised.iterations,
        improvements: optimised.improvements,
    };
    Ok((optimised.report, Some(optimisation)))
}

/// Step 5 for a path that holds; `None` for a robot without the limits for it.
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

/// Step 2 for a path to the goal of a problem.
fn shortened(
    problem: &Problem,
    planner: &dyn Planner,
    mut report: PlanReport,
    seed: u64,
) -> Result<(PlanReport, Shortening), PlanError> {
    let begin = Instant::now();
    let settings = ShortcutSettings { seed, ..ShortcutSettings::default() };
    let mut searches = 0;
    // Only where the planner is the one that searches again is what it finds its own.
    if planner.name() == Reach::default().name() {
        let optimised = better(problem, report, OptimiseSettings::delivery(), seed, &mut Unobserved)?;
        (report, searches) = (optimised.report, optimised.searches);
    } else {
        report.path = shortcut(problem, &report.path, settings)?.path;
    }
    let time_s = begin.elapsed().as_secs_f64();
    Ok((report, Shortening { attempts: settings.attempts, searches, time_s }))
}
