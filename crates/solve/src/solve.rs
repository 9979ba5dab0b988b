use std::f64::consts::PI;
use std::sync::Arc;
use std::time::Instant;

use cranny_collision::Cell;
use cranny_plan::{
    Audit, AuditSettings, Budget, Carrier, CarryEnd, Criterion, Goal, MotionLimits, NoGrasp, Observer,
    OptimiseSettings, Outcome, PlacePath, Placer, PlanError, PlanReport, Planner, Problem, Reach,
    ShortcutSettings, TaskPath, Trajectory, Unobserved, audit_cut_corners, audit_task, audit_with, better,
    optimise, search, shortcut,
};
use cranny_robot::Robot;
use cranny_spatial::other_seed;

use crate::task::Task;
use crate::{
    Answer, Mode, Optimisation, Request, Robustness, Segment, Shortening, SolveError, TaskCells,
    TaskTrajectory, Timed, Timing,
};

/// Solves a problem as a request says.
///
/// 1. The planner looks for a path; better ones are looked for if that is asked. Where the object is to be carried, a
///    grasp counts only if there is a way on from it.
/// 2. A path under `exact` is shortened, unless it is to be kept or was bettered; that of `reach` to a grasp or a
///    configuration is bettered a little ([`OptimiseSettings::delivery`]).
/// 3. Whatever was found is judged like anybody's path before it is called solved.
/// 4. A path that holds gets its time, if that is asked; where corners are cut, the curve is judged too, and all that is
///    measured holds for it.
/// 5. How far things may be from where it has them is worked out, if that is asked.
/// 6. A path that turns a joint half a turn beyond need is not delivered before other seeds were tried: see
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
    // 6.
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

/// Steps 1 to 5.
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
    let planner = request.planner_for(problem)?;
    // 1.
    let (budget, seed) = (&request.budget, request.seed);
    let carry = request.carry.as_ref();
    let mut task = carry.map(|carry| Task::new(problem, carry, (seed, budget.time))).transpose()?;
    let (report, optimisation, onward) = match &mut task {
        None => {
            let (report, optimisation) = searched(planner.as_ref(), problem, request, observer)?;
            (report, optimisation, Vec::new())
        }
        Some(task) => {
            let (report, onward) = task.search(planner.as_ref(), problem, (budget, seed), observer)?;
            (report, None, onward)
        }
    };
    observer.search_ended();
    // 2.
    let is_shortened =
        problem.criterion() == Criterion::Exact && optimisation.is_none() && !request.keep_path;
    let (report, shortening) = if is_shortened && !report.path.is_empty() {
        let (report, shortening) = shortened(problem, planner.as_ref(), report, task.is_some(), seed)?;
        (report, Some(shortening))
    } else {
        (report, None)
    };
    let PlanReport { outcome, path, statistics, failures } = report;
    // 3.
    let mut segments = if path.is_empty() { Vec::new() } else { vec![Segment::reach(path, Vec::new())] };
    let (mut carrier, mut carry_to) = (None, None);
    if let Some(task) = task {
        (carrier, carry_to) = (Some(task.carrier.clone()), Some(task.end()));
        if is_shortened {
            segments.extend(task.shortened(onward)?);
        } else {
            segments.extend(onward.into_iter().map(|(segment, _)| segment));
        }
    }
    let mut audit = match &segments[..] {
        [] => None,
        segments => {
            Some(audit_segments(problem, carrier.as_ref(), segments, carry_to.as_ref(), request.audit)?)
        }
    };
    // 4.
    let holds = outcome == Outcome::Solved && audit.as_ref().is_some_and(|audit| audit.valid);
    let timed = match request.timing {
        Some(timing) if holds => timed(problem, timing, &segments)?,
        _ => None,
    };
    let cut_corners = timed.as_ref().map_or(&[][..], |timed| timed.trajectory.cut_corners());
    if let Some(audit) = &mut audit {
        audit_cut_corners(problem, cut_corners, request.audit, audit);
    }
    give_clearances(audit.as_ref(), &mut segments);
    let not_checked = audit.as_ref().map_or_else(|| problem.not_checked(), |audit| audit.not_checked.clone());
    let is_grasp_missed = matches!(
        outcome,
        Outcome::BudgetExhausted | Outcome::Cancelled | Outcome::GaveUp | Outcome::NoReachableGrasp
    );
    let no_grasp = if is_grasp_missed { NoGrasp::of(problem, &failures) } else { None };
    let goal_faults = if outcome == Outcome::GoalsInvalid { problem.goal_faults() } else { Vec::new() };
    // 5.
    let holds = holds && audit.as_ref().is_some_and(|audit| audit.valid);
    let robustness = if request.robustness && holds {
        let cells = |carrier| TaskCells::of(carrier, &segments, carry_to.as_ref());
        let cells = carrier.as_ref().map(cells).transpose()?.flatten();
        Robustness::of(problem, cells.as_ref(), &segments, cut_corners)
    } else {
        None
    };
    let limits = request.timing.map(|timing| MotionLimits::of(problem.robot(), timing.method));
    let untimed = limits.and_then(Result::err).map(|fault| fault.to_string());
    Ok(Answer {
        planner: planner.name().to_owned(),
        settings: planner.settings(),
        criterion: problem.criterion(),
        score: request.score,
        min_score: request.min_score,
        below_min_score: None,
        goal_threshold: problem.goal_threshold(),
        budget: request.budget,
        seed,
        joint_names: problem.robot().joint_names().to_vec(),
        outcome,
        segments,
        audit,
        timed,
        untimed,
        robustness,
        shortening,
        optimisation,
        statistics,
        carry_to,
        failures,
        goal_faults,
        no_grasp,
        not_checked,
    })
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

/// Gives each segment the clearances of its edges.
fn give_clearances(audit: Option<&Audit>, segments: &mut [Segment]) {
    let mut clearances_m = audit.into_iter().flat_map(|audit| &audit.clearances_per_edge_m);
    for segment in segments {
        let edges = segment.waypoints.len().max(2) - 1;
        segment.clearances_m = clearances_m.by_ref().take(edges).copied().collect();
    }
}

/// Step 4 for a path that holds; `None` for a robot without the limits for it.
fn timed(problem: &Problem, timing: Timing, segments: &[Segment]) -> Result<Option<Timed>, PlanError> {
    let begin = Instant::now();
    let cell = problem.cell().map(Arc::as_ref);
    let trajectory = TaskTrajectory::of(timing, problem.robot(), cell, segments)?;
    Ok(trajectory.map(|trajectory| Timed { trajectory, time_s: begin.elapsed().as_secs_f64() }))
}

/// Step 2 for a path, from which the object is carried on or not.
fn shortened(
    problem: &Problem,
    planner: &dyn Planner,
    mut report: PlanReport,
    is_carried_on: bool,
    seed: u64,
) -> Result<(PlanReport, Shortening), PlanError> {
    let begin = Instant::now();
    let settings = ShortcutSettings { seed, ..ShortcutSettings::default() };
    let mut searches = 0;
    // Only where the planner is the one that searches again is what it finds its own.
    if planner.name() == Reach::default().name() && !is_carried_on {
        let optimised = better(problem, report, OptimiseSettings::delivery(), seed, &mut Unobserved)?;
        (report, searches) = (optimised.report, optimised.searches);
    } else if is_carried_on {
        // The hand holds the object as it stands where the path ends: another configuration would hold it otherwise.
        let to_end =
            problem.with_goal(Goal::Configurations(report.path.last().cloned().into_iter().collect()))?;
        report.path = shortcut(&to_end, &report.path, settings)?.path;
    } else {
        report.path = shortcut(problem, &report.path, settings)?.path;
    }
    let time_s = begin.elapsed().as_secs_f64();
    Ok((report, Shortening { attempts: settings.attempts, searches, time_s }))
}

/// Judges segments that follow each other, whoever made them: the way to a grasp alone, or with the two that carry the
/// object off, to this end if one was asked.
///
/// # Errors
/// [`PlanError::Segments`] for segments that are no such task, and those of the judge.
pub fn audit_segments(
    problem: &Problem,
    carrier: Option<&Carrier>,
    segments: &[Segment],
    end: Option<&CarryEnd>,
    settings: AuditSettings,
) -> Result<Audit, PlanError> {
    let modes: Vec<Mode> = segments.iter().map(|segment| segment.mode).collect();
    let placer = match (end, carrier) {
        (Some(CarryEnd::Place(place)), Some(carrier)) => Some(Placer::new(carrier, place.clone())?),
        _ => None,
    };
    match (segments, &modes[..], carrier) {
        ([reach], [Mode::Reach], _) => audit_with(problem, &reach.waypoints, settings),
        (
            [reach, lift_off, carry, after @ ..],
            [Mode::Reach, Mode::LiftOff, Mode::Carry, put_down @ ..],
            Some(carrier),
        ) => {
            let held = [lift_off, carry].map(|segment| segment.attached.as_deref().zip(segment.opening_m));
            let place = match (put_down, after, &placer) {
                ([], [], None) => None,
                (
                    [Mode::SetDown, Mode::Retreat] | [Mode::SetDown, Mode::Retreat, Mode::Return],
                    [set_down, retreat, back @ ..],
                    Some(placer),
                ) => Some(PlacePath {
                    placer,
                    set_down: &set_down.waypoints,
                    retreat: &retreat.waypoints,
                    back: back.first().map(|back| &back.waypoints[..]),
                    held: set_down.attached.as_deref().zip(set_down.opening_m),
                }),
                _ => return Err(PlanError::Segments),
            };
            let path = TaskPath {
                reach: &reach.waypoints,
                lift_off: &lift_off.waypoints,
                carry: &carry.waypoints,
                held,
                end,
                place,
            };
            audit_task(problem, carrier, path, settings)
        }
        _ => Err(PlanError::Segments),
    }
}

impl Timing {
    /// A path in time; `None` for a robot without the limits that this needs. Corners are cut in `cell`; where none are to be
    /// cut, none is needed.
    ///
    /// # Errors
    /// [`PlanError`] for a path that cannot be timed.
    pub fn along(
        self,
        robot: &Robot,
        cell: Option<&Cell>,
        path: &[Vec<f64>],
    ) -> Result<Option<Trajectory>, PlanError> {
        let Ok(limits) = MotionLimits::of(robot, self.method) else { return Ok(None) };
        let trajectory = match cell.filter(|_| self.blend) {
            Some(cell) => Trajectory::blended(path, &limits, cell)?,
            None => Trajectory::along(path, &limits)?,
        };
        Ok(Some(trajectory))
    }
}
