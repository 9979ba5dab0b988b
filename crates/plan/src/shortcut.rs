use std::time::Instant;

use cranny_collision::{Cell, Scratch};
use cranny_grasp::Grasp;
use cranny_robot::{IkSettings, IkSolver, Robot, between, distance};
use cranny_spatial::{LANES, Pose, Stream};

use crate::grasp_poses::poses;
use crate::{Goal, PlanError, Problem};

/// How hard to shorten a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShortcutSettings {
    /// Random shortcuts to try. Default 100: more gain little.
    pub attempts: usize,
    /// The seed of the random shortcuts.
    pub seed: u64,
}

impl Default for ShortcutSettings {
    fn default() -> Self {
        Self { attempts: 100, seed: 0 }
    }
}

/// A shorter path, and what it cost.
#[derive(Clone, Debug, PartialEq)]
pub struct Shortened {
    /// Way points from the same start to the same goal configuration, or to the same grasp or its twin; every
    /// edge is proven, or a part of an edge of the path given.
    pub path: Vec<Vec<f64>>,
    /// Seconds spent.
    pub time_s: f64,
}

/// A shortcut that saves less than this share of its detour is not worth its proof.
const LEAST_GAIN: f64 = 0.02;

/// A shortcut that takes more intervals than this to prove passes something very closely: another will do.
const MOST_EFFORT: u64 = 300;

/// Shortens a proven path and keeps the proof: every new edge is proven with the cell's margins before it
/// replaces a detour.
///
/// 1. From each way point on, straight to the farthest later one that can be reached, halving the reach
///    where it cannot. Where the goal is a grasp, and a joint has turned around on the way there, the rest of the
///    path is turned back.
/// 2. Straight lines between random points of the path before and after a random way point, wherever they lie
///    on its edges (Geraerts & Overmars 2007, §3); where one is blocked, another nearer to the way point.
/// 3. Where the goal is a grasp, every other one leads from a random point of the path to a configuration near
///    it that brings the gripper to where the path ends, or to its twin: an arm to spare can hold it otherwise.
/// 4. Once more the first step: a motion stops wherever a path turns.
///
/// A function of problem, path and settings alone.
///
/// # Errors
/// [`PlanError::Goal`] for a problem under another criterion than `exact`, where nothing is proven.
///
/// # Panics
/// If a way point has not one value per joint.
pub fn shortcut(
    problem: &Problem,
    path: &[Vec<f64>],
    settings: ShortcutSettings,
) -> Result<Shortened, PlanError> {
    let begin = Instant::now();
    let path = shortcut_unless(&|| false, problem, path, settings)?.unwrap_or_default();
    Ok(Shortened { path, time_s: begin.elapsed().as_secs_f64() })
}

/// The path of [`shortcut`], or nothing if it `is_over` before that is done.
pub(crate) fn shortcut_unless(
    is_over: &dyn Fn() -> bool,
    problem: &Problem,
    path: &[Vec<f64>],
    settings: ShortcutSettings,
) -> Result<Option<Vec<Vec<f64>>>, PlanError> {
    let cell = problem.exact_cell("shortcut")?;
    let mut scratch = cell.scratch();
    let mut random = Stream::new(settings.seed, 1);
    let mut hold = match (problem.goal(), path.last()) {
        // A grasp of one's own was measured at this very end.
        _ if problem.grasp_measure().is_some() => None,
        (Goal::Grasps(_), Some(end)) => Some(Hold::at(problem.robot(), end)),
        _ => None,
    };
    let mut path = path.to_vec();
    skip_way_points(cell, &mut path, hold.is_some(), &mut scratch);
    for attempt in 0..settings.attempts {
        if is_over() {
            return Ok(None);
        }
        match &mut hold {
            Some(hold) if attempt % 2 == 1 => hold.cut_to_end(cell, &mut path, &mut random, &mut scratch),
            _ => cut_at_random(cell, &mut path, &mut random, &mut scratch),
        }
    }
    skip_way_points(cell, &mut path, hold.is_some(), &mut scratch);
    Ok(Some(path))
}

/// Steps 1 and 4.
fn skip_way_points(cell: &Cell, path: &mut Vec<Vec<f64>>, may_turn_end: bool, scratch: &mut Scratch) {
    let mut at = 0;
    while at + 2 < path.len() {
        let mut reach = path.len() - 1 - at;
        while reach > 1 {
            let is_turned = may_turn_end
                && turn_rest_towards(cell.robot(), path, at, at + reach, |a, b| is_free(cell, a, b, scratch));
            if is_turned || is_free(cell, &path[at], &path[at + reach], scratch) {
                path.drain(at + 1..at + reach);
                break;
            }
            reach /= 2;
        }
        at += 1;
    }
}

/// Turns the path from way point `from` on by whole turns of joints to where it is nearest to way point `at`, if that
/// moves it, within the limits, and the straight way there `is_free`.
fn turn_rest_towards(
    robot: &Robot,
    path: &mut [Vec<f64>],
    at: usize,
    from: usize,
    mut is_free: impl FnMut(&[f64], &[f64]) -> bool,
) -> bool {
    let mut turned = path[from].clone();
    if !robot.turn_towards(&path[at], &mut turned) {
        return false;
    }
    let turns: Vec<f64> = turned.iter().zip(&path[from]).map(|(turned, q)| turned - q).collect();
    let rest: Vec<Vec<f64>> =
        path[from..].iter().map(|q| q.iter().zip(&turns).map(|(q, turn)| q + turn).collect()).collect();
    let is_turned = rest.iter().all(|q| robot.within_limits(q)) && is_free(&path[at], &rest[0]);
    if is_turned {
        path[from..].clone_from_slice(&rest);
    }
    is_turned
}

/// Step 2.
fn cut_at_random(cell: &Cell, path: &mut Vec<Vec<f64>>, random: &mut Stream, scratch: &mut Scratch) {
    if path.len() < 3 {
        return;
    }
    /// Tries at one way point, each half as far from it as the one before.
    const TRIES: usize = 3;
    let lengths = edge_lengths(path);
    let corner: f64 = lengths[..=random.index(lengths.len() - 1)].iter().sum();
    let total: f64 = lengths.iter().sum();
    let (mut before, mut after) = (random.uniform() * corner, random.uniform() * (total - corner));
    for _ in 0..TRIES {
        let (first, a) = point_at(path, &lengths, corner - before);
        let (last, b) = point_at(path, &lengths, corner + after);
        if first != last && is_shortcut(cell, &a, &b, before + after, scratch) {
            path.splice(first + 1..=last, [a, b]);
            return;
        }
        (before, after) = (0.5 * before, 0.5 * after);
    }
}

/// The gripper poses that count as the end of a path.
struct Hold<'a> {
    solver: IkSolver<'a>,
    poses: [Pose; 2],
}

impl<'a> Hold<'a> {
    fn at(robot: &'a Robot, end: &[f64]) -> Self {
        /// However often a path is shortened, its end moves by no more than this each time, in metres and
        /// radians: far less than what separates a grasp from a miss.
        const TOLERANCE: f64 = 1e-6;
        let frames = robot.frames_at(end);
        let grasp =
            Grasp { world_from_gripper: *frames.link(robot.tip()), score: None, width_m: None, robust: None };
        let settings = IkSettings {
            translation_tolerance_m: TOLERANCE,
            rotation_tolerance_rad: TOLERANCE,
            ..IkSettings::default()
        };
        Self { solver: IkSolver::new(robot, settings), poses: poses(&grasp) }
    }

    /// Step 3.
    fn cut_to_end(
        &mut self,
        cell: &Cell,
        path: &mut Vec<Vec<f64>>,
        random: &mut Stream,
        scratch: &mut Scratch,
    ) {
        if path.len() < 2 {
            return;
        }
        let lengths = edge_lengths(path);
        let total: f64 = lengths.iter().sum();
        let at = random.uniform() * total;
        let (edge, from) = point_at(path, &lengths, at);
        let pose = &self.poses[random.index(self.poses.len())];
        let Some(end) = self.solver.solve_from(pose, &from) else { return };
        if is_shortcut(cell, &from, &end.q, total - at, scratch) {
            path.truncate(edge + 1);
            path.extend([from, end.q]);
        }
    }
}

fn edge_lengths(path: &[Vec<f64>]) -> Vec<f64> {
    path.windows(2).map(|edge| distance(&edge[0], &edge[1])).collect()
}

/// The edge on which the point at `length` along the path lies, and the point.
fn point_at(path: &[Vec<f64>], lengths: &[f64], length: f64) -> (usize, Vec<f64>) {
    let mut left = length;
    let mut edge = 0;
    while edge + 1 < lengths.len() && left > lengths[edge] {
        left -= lengths[edge];
        edge += 1;
    }
    let at = if lengths[edge] > 0.0 { (left / lengths[edge]).min(1.0) } else { 0.0 };
    (edge, between(&path[edge], &path[edge + 1], at).collect())
}

/// Whether the straight way is proven, and worth it in place of a detour of this length.
fn is_shortcut(cell: &Cell, a: &[f64], b: &[f64], detour: f64, scratch: &mut Scratch) -> bool {
    distance(a, b) <= (1.0 - LEAST_GAIN) * detour && is_free(cell, a, b, scratch)
}

/// Whether the straight motion is proven; a row of looks up to its end saves the proof where it would fail.
fn is_free(cell: &Cell, a: &[f64], b: &[f64], scratch: &mut Scratch) -> bool {
    let places: [f64; LANES] = std::array::from_fn(|look| (look + 1) as f64 / LANES as f64);
    cell.free_ahead(a, b, &places, scratch) == LANES
        && cell.motion_is_free_within(MOST_EFFORT, a, b, scratch).is_proven()
}
