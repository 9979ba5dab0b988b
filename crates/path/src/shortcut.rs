use std::ops::Range;

use cranny_collision::{Cell, Scratch};
use cranny_grasp::Grasp;
use cranny_robot::{IkSettings, IkSolver, Robot, between};
use cranny_spatial::{Pose, Stream};
use cranny_task::{Goal, Problem, gripper_poses};

use crate::wall_clock::now;
use crate::{CostKind, PathCost, PathError};

/// Settings of [`shortcut`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShortcutSettings {
    /// Number of changes to try. Default 100; twice as many take twice as long and make the path half a per cent shorter.
    pub attempts: usize,
    /// Seed of the random changes.
    pub seed: u64,
}

impl Default for ShortcutSettings {
    fn default() -> Self {
        Self { attempts: 100, seed: 0 }
    }
}

/// Shortened path, and the time it took.
#[derive(Clone, Debug, PartialEq)]
pub struct Shortened {
    /// Way points from the same start to the same goal configuration, or to the same grasp or its twin. Every edge is proven,
    /// or lies on an edge of the given path.
    pub path: Vec<Vec<f64>>,
    /// Computation time, in seconds.
    pub time_s: f64,
}

/// Minimum saving that justifies a proof: of a shortcut, as a share of its detour; and (`LEAST_PULL`) of a moved way point, as
/// a share of its edges, since way points are moved more often.
const LEAST_GAIN: f64 = 0.02;
const LEAST_PULL: f64 = 5e-4;

/// Minimum saving for skipping a way point, as a share: none, up to rounding, since the motion stops at each way point.
const LEAST_SKIP: f64 = -1e-9;

/// Maximum number of intervals in the proof of a motion. A motion that needs more passes an obstacle very closely.
const MOST_EFFORT: u64 = 300;

/// Period of the attempts. The last of each period skips way points, the first is a random shortcut, the second and third move
/// the end if the goal is a grasp, and the others move way points.
const TURNS: usize = 5;

/// Shortens a proven path of way points (m, rad; one value per joint), by its plain L2 length, and keeps the proof: every new
/// edge is proven with the margins of the cell before it replaces a detour.
///
/// 1. Connects each way point straight to the farthest reachable later one, halving the distance after a failure. If the goal
///    is a grasp and a joint has made a full turn, the rest of the path is turned back.
/// 2. Moves a random way point, most often where the path turns most, towards the straight line between its neighbours by a
///    random share of the distance, and sideways at random by about as much. It thus slides along obstacles.
///    on its edges (Geraerts & Overmars 2007, §3); if it is blocked, between points closer to the way point. Every fifth
///    attempt repeats 1, because needless way points block the others.
/// 4. If the goal is a grasp, two of five attempts try a straight line from a random point of the path to a nearby
///    configuration with the gripper pose at the end of the path, or its twin. A redundant arm has many of them.
/// 5. Repeats 1 once more, because a motion stops wherever a path turns.
///
/// The result depends on problem, path and settings alone.
///
/// # Errors
/// [`TaskError::Goal`](cranny_task::TaskError::Goal) under a criterion other than `exact`, where nothing is proven.
///
/// # Panics
/// If a way point does not have one value per joint.
pub fn shortcut(
    problem: &Problem,
    path: &[Vec<f64>],
    settings: ShortcutSettings,
) -> Result<Shortened, PathError> {
    let begin = now();
    let cost = PathCost::new(problem, CostKind::L2, 0.0)?;
    let mut shortener = Shortener::new(problem, &cost, STOP)?;
    shortener.take(path, settings.seed);
    shortener.shorten(settings.attempts, &|| false);
    shortener.skip_way_points();
    Ok(Shortened { path: shortener.into_path(), time_s: begin.elapsed().as_secs_f64() })
}

/// Minimum saving of an additional way point in a delivered path, as a share of its cost: the motion stops there.
pub const STOP: f64 = 0.01;

/// Shortener, as in [`shortcut`], for the paths of one problem, one after the other.
pub struct Shortener<'a> {
    problem: &'a Problem,
    cell: &'a Cell,
    cost: &'a PathCost,
    stop: f64,
    scratch: Scratch,
    random: Stream,
    path: Vec<Vec<f64>>,
    costs: Vec<f64>,
    /// End poses, if the end may move to another configuration.
    hold: Option<EndPoses<'a>>,
    attempts: usize,
}

impl<'a> Shortener<'a> {
    /// Creates a shortener without a path.
    ///
    /// # Errors
    /// [`TaskError::Goal`](cranny_task::TaskError::Goal) for a criterion other than `exact`.
    pub fn new(problem: &'a Problem, cost: &'a PathCost, stop: f64) -> Result<Self, PathError> {
        let cell = problem.exact_cell("shortcut")?;
        Ok(Self {
            problem,
            cell,
            cost,
            stop,
            scratch: cell.scratch(),
            random: Stream::new(0, 1),
            path: Vec::new(),
            costs: Vec::new(),
            hold: None,
            attempts: 0,
        })
    }

    /// Starts over with another path of way points (m, rad; one value per joint).
    pub fn take(&mut self, path: &[Vec<f64>], seed: u64) {
        self.random = Stream::new(seed, 1);
        self.attempts = 0;
        self.path.clear();
        self.path.extend_from_slice(path);
        self.hold = match (self.problem.goal(), path.last()) {
            // A grasp generated by the planner was measured at exactly this end.
            _ if self.problem.grasp_measure().is_some() => None,
            (Goal::Grasps(_), Some(end)) => Some(EndPoses::at(self.problem.robot(), end, gripper_poses)),
            (Goal::Regions(_), Some(end)) => {
                Some(EndPoses::at(self.problem.robot(), end, |at| [at.world_from_gripper]))
            }
            _ => None,
        };
        self.measure_edges();
        self.skip_way_points();
    }

    /// Tries `attempts` changes of the path, and stops early once `is_over`. Returns true if all were tried.
    pub fn shorten(&mut self, attempts: usize, is_over: &dyn Fn() -> bool) -> bool {
        for _ in 0..attempts {
            if is_over() {
                return false;
            }
            self.attempts += 1;
            match self.attempts % TURNS {
                0 => self.skip_way_points(),
                1 => self.cut_at_random(),
                2 | 3 if self.hold.is_some() => self.move_end(),
                _ => self.pull_way_point(),
            }
        }
        true
    }

    /// Returns the current path: way points (m, rad; one value per joint).
    pub fn path(&self) -> &[Vec<f64>] {
        &self.path
    }

    /// Returns the current path by value: way points of one value per joint, m or rad.
    pub fn into_path(self) -> Vec<Vec<f64>> {
        self.path
    }

    fn measure_edges(&mut self) {
        let Self { path, costs, cost, scratch, .. } = self;
        costs.clear();
        costs.extend(path.windows(2).map(|edge| cost.of_edge(&edge[0], &edge[1], scratch)));
    }

    /// Operation 1 of [`shortcut`].
    fn skip_way_points(&mut self) {
        let mut at = 0;
        while at + 2 < self.path.len() {
            let mut reach = self.path.len() - 1 - at;
            while reach > 1 {
                let edges = at..at + reach;
                let chain = [at, at + reach].map(|way_point| self.path[way_point].clone());
                if self.turn_rest_towards(at, at + reach) || self.offer(edges, chain.into(), 0..1, LEAST_SKIP)
                {
                    break;
                }
                reach /= 2;
            }
            at += 1;
        }
    }

    /// Shifts the path from way point `from` on by full turns of joints to be nearest to way point `at`, and connects the two
    /// straight. Returns false if that moves nothing, violates a limit or is not free.
    fn turn_rest_towards(&mut self, at: usize, from: usize) -> bool {
        let robot = self.cell.robot();
        let mut turned = self.path[from].clone();
        if self.hold.is_none() || !robot.turn_towards(&self.path[at], &mut turned) {
            return false;
        }
        let turns: Vec<f64> = turned.iter().zip(&self.path[from]).map(|(turned, q)| turned - q).collect();
        let turn = |q: &Vec<f64>| q.iter().zip(&turns).map(|(q, turn)| q + turn).collect();
        let rest: Vec<Vec<f64>> = self.path[from..].iter().map(turn).collect();
        let may_turn = rest.iter().all(|q| robot.within_limits(q))
            && is_free(self.cell, &self.path[at], &rest[0], &mut self.scratch);
        if may_turn {
            self.path.truncate(at + 1);
            self.path.extend(rest);
            self.measure_edges();
        }
        may_turn
    }

    /// Operation 2 of [`shortcut`].
    fn pull_way_point(&mut self) {
        /// Sideways displacement, relative to the displacement towards the line.
        const ASIDE: f64 = 1.3;
        if self.path.len() < 3 {
            return;
        }
        let metric = self.cost.metric();
        // A way point is chosen more often the more it can save.
        let excess: Vec<f64> =
            self.path.windows(3).map(|way| self.excess([&way[0], &way[1], &way[2]])).collect();
        let mut left = self.random.uniform() * excess.iter().sum::<f64>();
        let is_passed = |excess: &f64| {
            left -= excess;
            left > 0.0
        };
        let at = 1 + excess[..excess.len() - 1].iter().copied().take_while(is_passed).count();
        let [before, here, after] = [at - 1, at, at + 1].map(|way_point| &self.path[way_point]);
        let lengths = [metric.distance(before, here), metric.distance(here, after)];
        let length = lengths[0] + lengths[1];
        if length <= 0.0 {
            return;
        }
        let straight: Vec<f64> = between(before, after, lengths[0] / length).collect();
        // Long moves succeed less often, but save more.
        let share = self.random.uniform().sqrt();
        let aside = ASIDE * share * metric.distance(here, &straight) / (here.len() as f64).sqrt();
        let offset: Vec<f64> = here.iter().map(|_| aside * self.random.normal()).collect();
        let mut moved = vec![0.0; here.len()];
        metric.unscale(&offset, &mut moved);
        for ((moved, here), straight) in moved.iter_mut().zip(here).zip(&straight) {
            *moved += here + share * (straight - here);
        }
        if self.cell.robot().within_limits(&moved) {
            let chain = vec![before.clone(), moved, after.clone()];
            self.offer(at - 1..at + 1, chain, 0..2, LEAST_PULL);
        }
    }

    /// Operation 3 of [`shortcut`].
    fn cut_at_random(&mut self) {
        /// Number of tries at a way point, each at half the distance of the one before.
        const TRIES: usize = 3;
        if self.path.len() < 3 {
            return;
        }
        let corner: f64 = self.costs[..=self.random.index(self.costs.len() - 1)].iter().sum();
        let total: f64 = self.costs.iter().sum();
        let mut before = self.random.uniform() * corner;
        let mut after = self.random.uniform() * (total - corner);
        for _ in 0..TRIES {
            let ((first, a), (last, b)) = (self.point_at(corner - before), self.point_at(corner + after));
            if first != last {
                let chain = vec![self.path[first].clone(), a, b, self.path[last + 1].clone()];
                // A shortcut past a single way point replaces it by two.
                let stop = if last == first + 1 { self.stop * total / (before + after) } else { 0.0 };
                let least_gain = LEAST_GAIN.max(stop);
                if self.offer(first..last + 1, chain, 1..2, least_gain) {
                    return;
                }
            }
            (before, after) = (0.5 * before, 0.5 * after);
        }
    }

    /// Operation 4 of [`shortcut`].
    fn move_end(&mut self) {
        if self.path.len() < 2 {
            return;
        }
        let at = self.random.uniform() * self.costs.iter().sum::<f64>();
        let (edge, from) = self.point_at(at);
        let Some(hold) = &mut self.hold else { return };
        let pose = &hold.poses[self.random.index(hold.poses.len())];
        let Some(end) = hold.solver.solve_from(pose, &from) else { return };
        let chain = vec![self.path[edge].clone(), from, end.q];
        self.offer(edge..self.costs.len(), chain, 1..2, LEAST_GAIN);
    }

    /// Returns the excess length of the path via `here` over the straight line from `before` to `after`.
    fn excess(&self, [before, here, after]: [&[f64]; 3]) -> f64 {
        let metric = self.cost.metric();
        metric.distance(before, here) + metric.distance(here, after) - metric.distance(before, after)
    }

    /// Returns the point up to which the path costs `cost`, after the index of its edge.
    fn point_at(&self, cost: f64) -> (usize, Vec<f64>) {
        let mut left = cost;
        let mut edge = 0;
        while edge + 1 < self.costs.len() && left > self.costs[edge] {
            left -= self.costs[edge];
            edge += 1;
        }
        let at = if self.costs[edge] > 0.0 { (left / self.costs[edge]).min(1.0) } else { 0.0 };
        (edge, between(&self.path[edge], &self.path[edge + 1], at).collect())
    }

    /// Replaces `edges` of the path by the way points `chain`, if the edges `open` of `chain` (the others lie on the path) are
    /// proven, and cost less than the replaced detour by the share `least_gain`.
    fn offer(
        &mut self,
        edges: Range<usize>,
        chain: Vec<Vec<f64>>,
        open: Range<usize>,
        least_gain: f64,
    ) -> bool {
        let Self { cell, cost, scratch, path, costs, .. } = self;
        let before: f64 = costs[edges.clone()].iter().sum();
        let is_less = |new: &[f64]| {
            let opened: f64 = new[open.clone()].iter().sum();
            let kept = new.iter().sum::<f64>() - opened;
            // Some costs are 0 on some edges; a change that saves nothing there is rejected.
            opened <= (1.0 - least_gain) * (before - kept) && (before > kept || least_gain <= 0.0)
        };
        // The clearance term is evaluated last, because it takes longest.
        let mut new: Vec<f64> = chain.windows(2).map(|edge| cost.least_of_edge(&edge[0], &edge[1])).collect();
        let mut is_taken =
            is_less(&new) && open.clone().all(|edge| is_free(cell, &chain[edge], &chain[edge + 1], scratch));
        if is_taken && cost.is_of_the_world() {
            new = chain.windows(2).map(|edge| cost.of_edge(&edge[0], &edge[1], scratch)).collect();
            is_taken = is_less(&new);
        }
        if is_taken {
            path.splice(edges.start..=edges.end, chain);
            costs.splice(edges, new);
        }
        is_taken
    }
}

/// Gripper poses that count as the end of a path.
struct EndPoses<'a> {
    solver: IkSolver<'a>,
    poses: Vec<Pose>,
}

impl<'a> EndPoses<'a> {
    /// Returns the `poses` that count as that of the tip at `end` (m, rad; one value per joint).
    fn at<const N: usize>(robot: &'a Robot, end: &[f64], poses: impl Fn(&Grasp) -> [Pose; N]) -> Self {
        /// Maximum motion of the end per shortening of a path, in metres and radians: far below the tolerance of a grasp.
        const TOLERANCE: f64 = 1e-6;
        let frames = robot.frames_at(end);
        let grasp = Grasp::at(*frames.link(robot.tip()));
        let settings = IkSettings {
            translation_tolerance_m: TOLERANCE,
            rotation_tolerance_rad: TOLERANCE,
            ..IkSettings::default()
        };
        Self { solver: IkSolver::new(robot, settings), poses: poses(&grasp).to_vec() }
    }
}

/// Returns true if the straight motion is proven.
fn is_free(cell: &Cell, a: &[f64], b: &[f64], scratch: &mut Scratch) -> bool {
    let places: [f64; 16] = std::array::from_fn(|check| (check + 1) as f64 / 16.0);
    cell.free_ahead(a, b, &places, scratch) == 16 && cell.unproven_at(MOST_EFFORT, a, b, scratch).is_none()
}
