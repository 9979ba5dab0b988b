use cranny_collision::{Collider, Margins};
use cranny_plan::{GoalPool, Observer, Statistics};
use cranny_robot::between;
use cranny_scenario::Scenario;
use cranny_sense::{SeenMap, Unseen};
use cranny_shape::Aabb;
use cranny_solve::{Request, solve};
use cranny_spatial::{Point, Stream, Vector};
use cranny_task::{Goal, Problem};

use crate::worlds::{with_cells_free, with_unseen_free};
use crate::{ExploreError, FirstMeeting, MetCell, swept_cells};

/// Cells that keep the best candidate from being proven.
#[derive(Clone, Debug)]
pub struct Blockage {
    /// Candidate that they block.
    pub candidate: Candidate,
    /// Cells, in the order in which the candidate meets them; none if the candidate lies in free space, and the search alone did not
    /// find it.
    pub cells: Vec<MetCell>,
    /// First contact of the candidate with the seen space, to within 10⁻⁴ of an edge; `None` if it touches nothing.
    pub first: Option<FirstMeeting>,
}

/// Accuracy of the place of a first contact, as a share of the edge.
const PLACE: f64 = 1e-4;

/// Motion or grasp that would be free if unseen space were.
#[derive(Clone, Debug, PartialEq)]
pub enum Candidate {
    /// Path to a grasp, free of all that the cameras measured (m, rad; one value per joint).
    Path(Vec<Vec<f64>>),
    /// Path through cells in which surfaces may have been measured: there is none around them (m, rad; one value per joint).
    BlockedPath(Vec<Vec<f64>>),
    /// Configuration at a grasp (m, rad; one value per joint) whose hand or arm meets such cells.
    Grasp {
        /// Index of the grasp.
        grasp: usize,
        /// Configuration.
        q: Vec<f64>,
    },
}

impl Candidate {
    /// Returns its way points (m, rad; one value per joint); for a grasp one.
    pub fn waypoints(&self) -> &[Vec<f64>] {
        match self {
            Self::Path(path) | Self::BlockedPath(path) => path,
            Self::Grasp { q, .. } => std::slice::from_ref(q),
        }
    }
}

impl Blockage {
    /// Returns the mean of the centres of the cells, by their volumes; not a number without cells.
    pub fn center(&self) -> Point {
        mean(self.cells.iter())
    }

    /// Returns the box around all cells.
    ///
    /// # Panics
    /// Without cells.
    pub fn around(&self) -> Aabb {
        let corners: Vec<Point> =
            self.cells.iter().flat_map(|cell| [cell.aabb.low(), cell.aabb.high()]).collect();
        Aabb::around(&corners, 0.0)
    }

    /// Returns the volume of all cells, in cubic metres.
    pub fn volume_m3(&self) -> f64 {
        self.cells.iter().map(volume_m3).sum()
    }

    /// Returns the number of cells that no view has seen into.
    pub fn unseen_count(&self) -> usize {
        self.cells.iter().filter(|cell| !cell.is_occupied).count()
    }

    /// Returns the points at which cameras may aim: the middle of all cells, and of the first and the last quarter of them.
    pub(crate) fn aims(&self) -> Vec<Point> {
        let quarter = self.cells.len().div_ceil(4);
        let last = &self.cells[self.cells.len() - quarter..];
        vec![self.center(), mean(last.iter()), mean(self.cells[..quarter].iter())]
    }
}

fn volume_m3(cell: &MetCell) -> f64 {
    8.0 * cell.aabb.half_extents.product()
}

fn mean<'a>(cells: impl Iterator<Item = &'a MetCell>) -> Point {
    let (sum, weight) = cells.fold((Vector::zeros(), 0.0), |(sum, weight), cell| {
        let volume = volume_m3(cell);
        (sum + cell.aabb.center.coords * volume, weight + volume)
    });
    Point::from(sum / weight)
}

/// Number of searches for candidates, of which the one that needs the least new space counts.
const SEARCHES: u64 = 3;

/// Number of batches of inverse kinematics in which configurations at grasps are drawn.
const BATCHES: usize = 48;

/// Number of such configurations that are compared at most.
const MOST_GRASPS: usize = 160;

/// Weight of a cell in which a surface may have been measured, relative to one that no view has seen into: it is less likely to be
/// free.
const OCCUPIED_WEIGHT: f64 = 4.0;

/// Returns the cells that block the best candidate in a scenario with seen space; `None` if there is no such space, unseen space
/// is free, or there is no candidate even in the space of the known bodies alone.
///
/// 1. The candidate of a call before stays if it is still free of all that was measured.
/// 2. The problem is solved with unseen cells free. Of the paths of three seeds, the one that sweeps the least unseen volume counts.
/// 3. Without any, configurations at grasps are drawn that are free of the known bodies alone; the one counts whose links meet the
///    least volume, occupied cells weighted fourfold. If they meet nothing, the path to it is the candidate.
///
/// # Errors
/// Those of [`solve`], and [`ExploreError::Criterion`] under another criterion than `exact`.
pub fn find_blockage(
    seen: &Scenario,
    margins: Margins,
    request: &Request,
    earlier: Option<&Candidate>,
    observer: &mut dyn Observer,
) -> Result<Option<Blockage>, ExploreError> {
    let Some((candidate, cells)) = blocked_candidate(seen, margins, request, earlier, observer)? else {
        return Ok(None);
    };
    let first = first_meeting(&seen.problem(margins)?, candidate.waypoints())?;
    Ok(Some(Blockage { candidate, cells, first }))
}

/// Returns the best candidate with the cells that block it.
fn blocked_candidate(
    seen: &Scenario,
    margins: Margins,
    request: &Request,
    earlier: Option<&Candidate>,
    observer: &mut dyn Observer,
) -> Result<Option<(Candidate, Vec<MetCell>)>, ExploreError> {
    let Some(space) = seen.seen.as_ref().filter(|space| space.options.unseen == Unseen::Solid) else {
        return Ok(None);
    };
    let map = &*space.map;
    let optimistic = with_unseen_free(seen)?.problem(margins)?;
    // 1.
    if let Some(Candidate::Path(path)) = earlier
        && is_proven(&optimistic, path)?
    {
        let cells = swept_cells(optimistic.robot(), path, map, false);
        return Ok(Some((Candidate::Path(path.clone()), cells)));
    }
    // 2.
    let mut best: Option<(Vec<Vec<f64>>, Vec<MetCell>)> = None;
    let volume_of = |cells: &[MetCell]| cells.iter().map(volume_m3).sum::<f64>();
    for round in 0..SEARCHES {
        let request = Request { seed: cranny_spatial::other_seed(request.seed, round), ..plain(request) };
        let answer = solve(&optimistic, &request, observer)?;
        if !answer.is_solved() {
            break;
        }
        let path = answer.waypoints();
        let cells = swept_cells(optimistic.robot(), &path, map, false);
        if best.as_ref().is_none_or(|(_, least)| volume_of(&cells) < volume_of(least)) {
            best = Some((path, cells));
        }
    }
    if best.is_some() || observer.should_stop() {
        return Ok(best.map(|(path, cells)| (Candidate::Path(path), cells)));
    }
    // 3.
    let known = with_cells_free(seen)?.problem(margins)?;
    let Some((grasp, q)) = best_grasp(&known, map, request.seed)? else { return Ok(None) };
    let robot = known.robot();
    let cells = swept_cells(robot, std::slice::from_ref(&q), map, true);
    if !cells.is_empty() {
        return Ok(Some((Candidate::Grasp { grasp, q }, cells)));
    }
    let to_grasp = known.with_goal(Goal::Configurations(vec![q]))?;
    let answer = solve(&to_grasp, &plain(request), observer)?;
    if !answer.is_solved() {
        return Ok(None);
    }
    let path = answer.waypoints();
    let cells = swept_cells(robot, &path, map, true);
    Ok(Some((Candidate::BlockedPath(path), cells)))
}

/// Returns a request for a path alone.
fn plain(request: &Request) -> Request {
    Request {
        seed: request.seed,
        budget: request.budget,
        score: request.score,
        min_score: request.min_score,
        hold: None,
        ..Request::default()
    }
}

/// Returns the first place of a path (m, rad; one value per joint) at which a link touches anything, among 1000 on each edge,
/// refined to [`PLACE`]; for a single configuration the link in contact there.
fn first_meeting(problem: &Problem, path: &[Vec<f64>]) -> Result<Option<FirstMeeting>, ExploreError> {
    const SAMPLES: usize = 1000;
    let cell = problem.exact_cell("explore")?;
    let mut scratch = cell.scratch();
    let mut link_at = |q: &[f64]| {
        let contact = cell.first_contact(q, &mut scratch)?;
        if let Collider::Link(link) = contact.first { Some(link) } else { None }
    };
    if let [q] = path {
        return Ok(link_at(q).map(|link| FirstMeeting { edge: 0, at: 0.0, link }));
    }
    for (edge, ends) in path.windows(2).enumerate() {
        let at = |at: f64| between(&ends[0], &ends[1], at).collect::<Vec<f64>>();
        let mut samples = (0..=SAMPLES).map(|sample| sample as f64 / SAMPLES as f64);
        let Some((met, mut link)) = samples.find_map(|place| Some((place, link_at(&at(place))?))) else {
            continue;
        };
        let (mut free, mut met) = ((met - 1.0 / SAMPLES as f64).max(0.0), met);
        while met - free > PLACE {
            let middle = 0.5 * (free + met);
            match link_at(&at(middle)) {
                Some(other) => (met, link) = (middle, other),
                None => free = middle,
            }
        }
        return Ok(Some(FirstMeeting { edge, at: met, link }));
    }
    Ok(None)
}

/// Returns true if every edge of a path (m, rad; one value per joint) is proven free.
pub(crate) fn is_proven(problem: &Problem, path: &[Vec<f64>]) -> Result<bool, ExploreError> {
    let cell = problem.exact_cell("explore")?;
    let mut scratch = cell.scratch();
    Ok(path.windows(2).all(|edge| cell.motion_is_free(&edge[0], &edge[1], &mut scratch).is_proven()))
}

/// Returns the configuration at a grasp that needs the least new space, with the index of its grasp.
fn best_grasp(known: &Problem, map: &SeenMap, seed: u64) -> Result<Option<(usize, Vec<f64>)>, ExploreError> {
    let Some(mut pool) = GoalPool::of(known)? else { return Ok(None) };
    let cell = known.exact_cell("explore")?;
    let (mut random, mut scratch) = (Stream::new(seed, 0), cell.scratch());
    let mut statistics = Statistics::default();
    let mut best: Option<(f64, (usize, Vec<f64>))> = None;
    let mut compared = 0;
    for _ in 0..BATCHES {
        for (grasp, q) in pool.draw_batch(&[], &mut random, &mut scratch, &mut statistics) {
            let cells = swept_cells(known.robot(), std::slice::from_ref(&q), map, true);
            let weight = |cell: &MetCell| if cell.is_occupied { OCCUPIED_WEIGHT } else { 1.0 };
            let cost: f64 = cells.iter().map(|cell| weight(cell) * volume_m3(cell)).sum();
            if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                best = Some((cost, (grasp, q)));
            }
            compared += 1;
        }
        if compared >= MOST_GRASPS || pool.is_hopeless() {
            break;
        }
    }
    Ok(best.map(|(_, found)| found))
}
