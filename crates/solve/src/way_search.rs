use std::sync::Arc;
use std::time::Instant;

use cranny_path::{PathCost, PathError, ShortcutSettings, shortcut};
use cranny_plan::{
    Budget, Improvement, Observer, OptimiseSettings, PlanError, PlanReport, Planner, Reach, Statistics,
    Unobserved, better, optimise, search,
};
use cranny_spatial::other_seed;
use cranny_task::{Carrier, Criterion, LiftOffSettings, Problem, Segment, Stage, State};

use crate::stages::chain::Chain;
use crate::stages::onward::Piece;
use crate::{Optimisation, Request, Shortening, SolveError};

/// Report of a search, and the delivered segments.
pub(crate) struct Found {
    pub report: PlanReport,
    pub segments: Vec<Segment>,
    pub unshortened: Vec<Segment>,
    pub shortening: Option<Shortening>,
    pub optimisation: Option<Optimisation>,
    /// Carrier of the first object.
    pub carrier: Option<Arc<Carrier>>,
}

/// Searches for a path to the goal of the problem alone, shortened or optimised.
pub(crate) fn found_alone(
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
        let (report, shortening) = shortened(problem, planner, report, request)?;
        (report, Some(shortening))
    } else {
        (report, None)
    };
    let path = std::mem::take(&mut report.path);
    let segments = if path.is_empty() { Vec::new() } else { vec![Segment::reach(path, Vec::new())] };
    Ok(Found { report, segments, unshortened: Vec::new(), shortening, optimisation, carrier: None })
}

/// Searches for paths through several stages. Shortening a segment keeps its ends, because the pose of the object in the hand
/// depends on them. With `optimise`, the cheapest of several paths through all stages is improved ([`optimised`]).
pub(crate) fn found_in_stages(
    problem: &Problem,
    planner: &dyn Planner,
    (stages, request): (&[Stage], &Request),
    (carrier, observer): (Option<&Arc<Carrier>>, &mut dyn Observer),
) -> Result<Found, SolveError> {
    let carrier = match (stages, carrier) {
        ([Stage::Pick(_), _, ..], Some(carrier)) => Some(carrier.clone()),
        _ => first_carrier(problem, stages)?,
    };
    let chain = Chain::new(problem, stages, request, carrier.clone())?;
    let (report, pieces) = chain.search(planner, observer)?;
    observer.search_ended();
    let begin = Instant::now();
    let as_found =
        |pieces: &[Piece]| pieces.iter().map(|(segment, _)| segment.clone()).collect::<Vec<Segment>>();
    let mut unshortened = as_found(&pieces);
    let is_found = !pieces.is_empty();
    let is_shortened = is_found && !request.keep_path;
    let changes = request.changes.unwrap_or(ShortcutSettings::default().attempts);
    let pieces = if is_shortened { shortened_pieces(pieces, changes, request.seed)? } else { pieces };
    let (segments, optimisation) = match request.optimise.filter(|_| is_found) {
        Some(settings) => {
            let first = (pieces, unshortened.clone());
            let (best, optimisation) = optimised(
                problem,
                planner,
                (stages, request, carrier.as_ref()),
                first,
                (&report, settings),
                observer,
            )?;
            unshortened = best.1;
            (as_found(&best.0), Some(optimisation))
        }
        None => (as_found(&pieces), None),
    };
    let shortening = (is_shortened && optimisation.is_none()).then(|| Shortening {
        attempts: changes,
        searches: 0,
        time_s: begin.elapsed().as_secs_f64(),
    });
    Ok(Found { report, segments, unshortened, shortening, optimisation, carrier })
}

/// Returns the carrier of the first object, if the first of several stages is a pick.
fn first_carrier(problem: &Problem, stages: &[Stage]) -> Result<Option<Arc<Carrier>>, PlanError> {
    let ([Stage::Pick(pick), _, ..], Some(start)) = (stages, State::start(problem)) else { return Ok(None) };
    let picking = start.picking(problem, pick)?;
    Ok(Some(Arc::new(Carrier::new(&picking, LiftOffSettings::default())?)))
}

/// Shortened pieces of a path through all stages, and the segments before shortening.
type Way = (Vec<Piece>, Vec<Segment>);

/// Searches for the cheapest path through all stages within the limits of time and iterations, at most as costly as the first.
///
/// 1. For half of the time and iterations, search for paths through all stages from other seeds: with other grasps,
///    configurations, placements and transfers.
/// 2. For the rest, search for better paths between the ends of each segment of the cheapest path in turn ([`better`]).
fn optimised(
    problem: &Problem,
    planner: &dyn Planner,
    (stages, request, carrier): (&[Stage], &Request, Option<&Arc<Carrier>>),
    first: Way,
    (report, settings): (&PlanReport, OptimiseSettings),
    observer: &mut dyn Observer,
) -> Result<(Way, Optimisation), SolveError> {
    /// Iteration limit of a search, as a multiple of the iterations of the first, and its least value.
    const PATIENCE: u64 = 4;
    const LEAST_ITERATIONS: u64 = 1000;
    /// Least number of iterations counted for a search, because its inverse kinematics takes time too.
    const LEAST_COUNTED: u64 = 100;
    let begin = Instant::now();
    let first_s = report.statistics.planning_time_s;
    let mut iterations = report.statistics.iterations;
    let most_iterations = settings.iterations.min(request.budget.iterations);
    let costs = TaskCost { problem, settings };
    let mut best = first;
    let mut cost = costs.of(&best.0)?;
    let mut improvements = vec![Improvement { time_s: first_s, iterations, cost }];
    // 1.
    let most_of_search = PATIENCE.saturating_mul(iterations).max(LEAST_ITERATIONS);
    for other in 1.. {
        let left = (settings.time / 2).saturating_sub(begin.elapsed());
        if left.is_zero() || iterations >= most_iterations / 2 || observer.should_stop() {
            break;
        }
        let budget = Budget { iterations: most_of_search.min(most_iterations / 2 - iterations), time: left };
        let again = Request { budget, seed: other_seed(request.seed, other), ..request.clone() };
        let (report, pieces) =
            Chain::new(problem, stages, &again, carrier.cloned())?.search(planner, observer)?;
        iterations += report.statistics.iterations.max(LEAST_COUNTED);
        if pieces.is_empty() {
            continue;
        }
        let unshortened = pieces.iter().map(|(segment, _)| segment.clone()).collect();
        let pieces = shortened_pieces(pieces, ShortcutSettings::default().attempts, again.seed)?;
        let found = costs.of(&pieces)?;
        if found < cost {
            cost = found;
            best = (pieces, unshortened);
            let time_s = first_s + begin.elapsed().as_secs_f64();
            improvements.push(Improvement { time_s, iterations, cost });
        }
    }
    // 2.
    let free = best.0.iter().filter(|(_, problem)| problem.is_some()).count().max(1);
    let time = settings.time.saturating_sub(begin.elapsed()) / u32::try_from(free).unwrap_or(u32::MAX);
    let most = most_iterations.saturating_sub(iterations) / free as u64;
    let of_piece = OptimiseSettings { time, iterations: most, score_weight: 0.0, ..settings };
    for (segment, problem) in &mut best.0 {
        let Some(problem) = problem else { continue };
        let statistics =
            Statistics { planning_time_s: begin.elapsed().as_secs_f64(), ..Statistics::default() };
        let path = segment.waypoints.clone();
        let first = PlanReport::of(Ok(path), statistics);
        let found = better(problem, first, of_piece, request.seed, observer)?;
        let of_segment = PathCost::new(problem, settings.cost, 0.0)?;
        let before = of_segment.measure(&segment.waypoints)?;
        if found.improvements.last().is_some_and(|last| last.cost < before) {
            let cheaper = found.improvements.iter().filter(|step| step.cost < before);
            improvements.extend(cheaper.map(|step| Improvement {
                time_s: first_s + step.time_s,
                iterations: iterations + step.iterations,
                cost: cost - (before - step.cost),
            }));
            cost = improvements.last().map_or(cost, |last| last.cost);
            segment.waypoints = found.report.path;
        }
        iterations += found.iterations;
    }
    let time_s = begin.elapsed().as_secs_f64();
    Ok((best, Optimisation { settings, time_s, iterations, improvements }))
}

/// Cost function of paths through all stages.
struct TaskCost<'a> {
    problem: &'a Problem,
    settings: OptimiseSettings,
}

impl TaskCost<'_> {
    /// Returns the sum over all segments, minus the reward of the first grasp.
    fn of(&self, pieces: &[Piece]) -> Result<f64, PathError> {
        let OptimiseSettings { cost, score_weight, .. } = self.settings;
        let mut total = 0.0;
        for (segment, problem) in pieces {
            let measured = PathCost::new(problem.as_ref().unwrap_or(self.problem), cost, 0.0)?;
            total += measured.measure(&segment.waypoints)?;
        }
        let of_grasp = PathCost::new(self.problem, cost, score_weight)?;
        let grasp = pieces.first().and_then(|(segment, _)| segment.waypoints.last());
        let score = grasp.and_then(|end| of_grasp.score_at(self.problem, end));
        Ok(total - of_grasp.reward(score))
    }
}

/// Shortens the paths of those pieces that can be shortened.
fn shortened_pieces(pieces: Vec<Piece>, attempts: usize, seed: u64) -> Result<Vec<Piece>, PlanError> {
    let settings = ShortcutSettings { attempts, seed };
    let shortened = pieces.into_iter().map(|(segment, problem)| {
        let Some(problem) = problem else { return Ok((segment, None)) };
        let waypoints = shortcut(&problem, &segment.waypoints, settings)?.path;
        Ok((Segment { waypoints, ..segment }, Some(problem)))
    });
    shortened.collect()
}

/// Runs the search and, with `optimise`, those for better paths.
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

/// Returns a shorter path to the goal of a problem.
fn shortened(
    problem: &Problem,
    planner: &dyn Planner,
    mut report: PlanReport,
    request: &Request,
) -> Result<(PlanReport, Shortening), PlanError> {
    let begin = Instant::now();
    let Request { seed, changes, .. } = *request;
    let settings =
        ShortcutSettings { attempts: changes.unwrap_or(ShortcutSettings::default().attempts), seed };
    let mut searches = 0;
    // Only the planner `reach` searches again, as these searches run `reach`: a path of another planner remains its own.
    if planner.name() == Reach::default().name() && changes.is_none() {
        let optimised = better(problem, report, OptimiseSettings::delivery(), seed, &mut Unobserved)?;
        (report, searches) = (optimised.report, optimised.searches);
    } else {
        report.path = shortcut(problem, &report.path, settings)?.path;
    }
    let time_s = begin.elapsed().as_secs_f64();
    Ok((report, Shortening { attempts: settings.attempts, searches, time_s }))
}
