use cranny_collision::Cell;
use cranny_plan::Observer;
use cranny_robot::{IkSearch, IkSearchSettings, IkSettings, between, distance};
use cranny_spatial::{Pose, Stream};
use cranny_task::{FailureReason, Move, Problem, Region, Segment, State, ends_out_of_bounds};

use crate::stages::effort::Effort;

/// Maximum number of random configurations drawn in search of clear ones …
const MOST_DRAWS: u32 = 2000;
/// … and the number of clear ones after which drawing stops.
const ENOUGH_CLEAR: usize = 8;
/// Range of each joint around its present value (m, rad) in the first draws …
const NEAREST_DRAW: f64 = 0.1;
/// … and in the last ones.
const FARTHEST_DRAW: f64 = 3.0;
/// Distance in joint space (m, rad) between the samples of a path that are checked for the required clearance.
const LOOK_EVERY: f64 = 0.05;

/// Number of random starts of inverse kinematics at a pose.
const ATTEMPTS: usize = 32;
/// Maximum number of configurations that are tried at one pose.
const CONFIGURATIONS: usize = 2;
/// Maximum number of poses of a region that are tried.
const MOST_POSES: usize = 64;

/// A path and the problem that it solves.
pub(crate) type Way = (Vec<Vec<f64>>, Problem);

/// A segment, and the problem that it solves; `None` if it must not be shortened.
pub(crate) type Piece = (Segment, Option<Problem>);

/// Goal of a motion from a state.
pub(crate) enum Towards<'a> {
    /// Any of these configurations (m, rad; one value per joint).
    Ends(&'a [Vec<f64>]),
    /// Any configuration with at least this distance, in metres, between the object in the hand and everything else.
    Clear(f64),
    /// Any pose of these regions.
    Regions(Vec<Region>),
    /// Start of the path that led here.
    Begin,
}

impl<'a> Towards<'a> {
    /// Returns the goal of a move; for a finite set, its remaining `ends` (m, rad; one value per joint), `None` if empty.
    pub fn of(goal: &Move, ends: Option<&'a [Vec<f64>]>, problem: &Problem) -> Option<Self> {
        match (ends, goal) {
            (Some(ends), _) => (!ends.is_empty()).then_some(Self::Ends(ends)),
            (None, Move::Clear { clear_m }) => Some(Self::Clear(*clear_m)),
            (None, goal) => goal.regions(problem).ok().flatten().map(Self::Regions),
        }
    }
}

impl Towards<'_> {
    /// Returns configurations (m, rad; one value per joint) that are sampled for the goal, from a state to which no path led.
    pub fn goals(&self, effort: &Effort, state: &State) -> Vec<Vec<f64>> {
        match self {
            Self::Ends(ends) => ends.to_vec(),
            Self::Clear(clear_m) => clear_goals(effort, state, &[], *clear_m).1,
            Self::Regions(regions) => region_goals(effort, state, regions),
            Self::Begin => Vec::new(),
        }
    }
}

/// Searches for a path from a state, with or without an object in the hand. The path may join `led`, the path to the grasp
/// (empty if the arm has moved since), at any configuration up to which `led` is proven free with the object too. Often only
/// the path out of a narrow passage remains to be found.
pub(crate) fn onward(
    effort: &mut Effort,
    state: &State,
    led: &[Vec<f64>],
    towards: &Towards<'_>,
    observer: &dyn Observer,
) -> Result<Way, FailureReason> {
    let failed = if state.held().is_some() { FailureReason::NotCarried } else { FailureReason::NotMoved };
    if let (Towards::Ends(ends), Some(_)) = (towards, state.held())
        && let Some(excess) = ends_out_of_bounds(state.cell(), ends)
    {
        return Err(excess);
    }
    let (back, others) = match towards {
        Towards::Clear(clear_m) => clear_goals(effort, state, led, *clear_m),
        Towards::Regions(regions) => (Vec::new(), region_goals(effort, state, regions)),
        Towards::Begin => (state.free_along(led), Vec::new()),
        Towards::Ends(ends) if led.first().is_some_and(|begin| ends.contains(begin)) => {
            (state.free_along(led), ends.to_vec())
        }
        Towards::Ends(ends) => (Vec::new(), ends.to_vec()),
    };
    // Goals nearest to the grasp come first.
    let joints: Vec<Vec<f64>> = back.iter().rev().chain(&others).cloned().collect();
    let narrow = state.moving(joints).map_err(|_| failed.clone())?;
    let mut path =
        effort.search(&narrow, observer).map_err(|_| failed.clone())?.ok_or_else(|| failed.clone())?;
    let joined = back.iter().position(|q| path.last() == Some(q)).unwrap_or(0);
    path.extend(back[..joined].iter().rev().cloned());
    let ends = match towards {
        Towards::Clear(clear_m) => {
            until_clear(state, &mut path, *clear_m);
            path[path.len() - 1..].to_vec()
        }
        Towards::Begin | Towards::Regions(_) => path[path.len() - 1..].to_vec(),
        Towards::Ends(ends) => ends.to_vec(),
    };
    Ok((path, state.moving(ends).map_err(|_| failed.clone())?))
}

/// Returns the path that led here from its last clear configuration on; if it has none, random clear configurations.
fn clear_goals(
    effort: &Effort,
    state: &State,
    led: &[Vec<f64>],
    clear_m: f64,
) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
    let cell = state.cell();
    let mut scratch = cell.scratch();
    let is_clear = |q: &[f64], scratch: &mut _| state.clearance_m(q, clear_m, scratch) >= clear_m;
    let mut back = state.free_along(led);
    if let Some(clear) = back.iter().rposition(|q| is_clear(q, &mut scratch)) {
        return (back.split_off(clear), Vec::new());
    }
    let mut random = Stream::new(effort.seed, u64::from(effort.exhausted()));
    let limits = cell.robot().limits();
    let mut found = Vec::new();
    for draw in 0..MOST_DRAWS {
        let share = f64::from(draw) / f64::from(MOST_DRAWS);
        let wide = NEAREST_DRAW + share * (FARTHEST_DRAW - NEAREST_DRAW);
        let joints = state.q.iter().zip(limits);
        let q: Vec<f64> = joints
            .map(|(value, limits)| {
                random.uniform_between(limits.lower.max(value - wide), limits.upper.min(value + wide))
            })
            .collect();
        if cell.is_free(&q, &mut scratch) && is_clear(&q, &mut scratch) {
            found.push(q);
            if found.len() == ENOUGH_CLEAR {
                break;
            }
        }
    }
    (Vec::new(), found)
}

/// Returns configurations at which the moved frame is in one of several regions.
fn region_goals(effort: &Effort, state: &State, regions: &[Region]) -> Vec<Vec<f64>> {
    let stream = |of: u64| Stream::new(effort.seed_of(of), u64::from(effort.exhausted()));
    let (cell, mut random) = (state.cell(), stream(1));
    let mut scratch = cell.scratch();
    let mut found = Vec::new();
    for (moved, pose) in Region::draws(regions, stream(0)).take(MOST_POSES) {
        let Some(world_from_tip) = state.world_from_tip(moved, &pose) else { break };
        let mut is_free = |q: &[f64]| cell.is_free(q, &mut scratch);
        let search = ik_solutions(cell, &world_from_tip, &[&state.q], &mut random, &mut is_free);
        found.extend(search.solutions().iter().map(|solution| solution.q.clone()));
        if found.len() >= ENOUGH_CLEAR {
            break;
        }
    }
    found
}

/// Searches for up to [`CONFIGURATIONS`] accepted configurations with the tip at a pose, those from `starts` first.
pub(crate) fn ik_solutions<'a>(
    cell: &'a Cell,
    world_from_tip: &Pose,
    starts: &[&[f64]],
    random: &mut Stream,
    accept: &mut dyn FnMut(&[f64]) -> bool,
) -> IkSearch<'a> {
    let ik =
        IkSettings { translation_tolerance_m: 1e-6, rotation_tolerance_rad: 1e-5, ..IkSettings::default() };
    let settings = IkSearchSettings { ik, ..IkSearchSettings::default() };
    let mut search = IkSearch::new(cell.robot(), world_from_tip, settings);
    for start in starts {
        search.next_from(start, &mut *accept);
    }
    while search.solutions().len() < CONFIGURATIONS
        && search.attempts() < ATTEMPTS
        && search.next_solution(random, ATTEMPTS, &mut *accept).is_some()
    {}
    search
}

/// Truncates a path at its first clear configuration.
fn until_clear(state: &State, path: &mut Vec<Vec<f64>>, clear_m: f64) {
    let mut scratch = state.cell().scratch();
    for edge in 1..path.len() {
        let [a, b] = [&path[edge - 1], &path[edge]];
        let pieces = (distance(a, b) / LOOK_EVERY).ceil().max(1.0);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "A path of so many metres or radians is none"
        )]
        let places = (1..=pieces.min(1e6) as u32).map(|piece| (f64::from(piece) / pieces).min(1.0));
        let mut looks = places.map(|at| between(a, b, at).collect::<Vec<f64>>());
        if let Some(clear) = looks.find(|q| state.clearance_m(q, clear_m, &mut scratch) >= clear_m) {
            path.truncate(edge);
            path.push(clear);
            return;
        }
    }
}
