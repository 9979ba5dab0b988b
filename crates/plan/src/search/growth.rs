use cranny_collision::Bubble;
use cranny_path::Stepper;
use cranny_robot::{Robot, between};
use cranny_task::Problem;

use crate::Observer;
use crate::search::baseline_check::BaselineCheck;
use crate::search::forest::Forest;
use crate::search::search_state::Search;
use crate::wall_clock::now;

/// Growth of a tree from one of its nodes.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Growth {
    /// Step in which the origin of no link frame moves farther than `step_m` metres.
    Step { step_m: f64 },
    /// Bur of `spines` spines, the first towards the target and the others towards random configurations, each as far as the
    /// bubble about the node is free. It is replaced by a step if the world is closer than `critical_m` metres, or if the first
    /// spine would be shorter.
    Bur { spines: usize, critical_m: f64, step_m: f64 },
}

impl Growth {
    fn step_m(self) -> f64 {
        match self {
            Self::Step { step_m } | Self::Bur { step_m, .. } => step_m,
        }
    }
}

/// Nodes grown from one node of a tree.
pub(crate) struct Grown {
    /// Branch towards the target.
    pub ahead: Branch,
    /// Other spines.
    pub aside: Vec<Branch>,
}

/// New nodes in one direction, each grown from the one before.
#[derive(Default)]
pub(crate) struct Branch {
    /// Nodes, none if it is blocked. A spine is one node, unless way points may be no farther apart than a step.
    pub nodes: Vec<Vec<f64>>,
    /// True if the last node is the target.
    pub is_target: bool,
}

impl Branch {
    /// Adds the nodes to a forest, known to observers by the index `tree`, the first below `from`; returns the last.
    pub fn add_to(
        &self,
        forest: &mut Forest,
        tree: usize,
        from: usize,
        observer: &mut dyn Observer,
    ) -> Option<usize> {
        self.nodes.iter().fold(None, |last, q| {
            let parent = last.or(Some(from));
            observer.node_added(tree, q, parent);
            Some(forest.add(q, parent))
        })
    }
}

/// Grows trees along edges that are free by the criterion of a problem.
pub(crate) struct Grower<'a> {
    pub check: BaselineCheck<'a>,
    stepper: Stepper,
    robot: &'a Robot,
    growth: Growth,
}

impl<'a> Grower<'a> {
    pub fn new(problem: &'a Problem, growth: Growth) -> Self {
        let robot = problem.robot().as_ref();
        Self { check: BaselineCheck::of(problem), stepper: Stepper::new(robot), robot, growth }
    }

    /// Grows from `q` towards `target`, another configuration (m, rad; one per joint). A bur has random spines if `explores`.
    pub fn grow(&mut self, q: &[f64], target: &[f64], explores: bool, search: &mut Search) -> Grown {
        let bur = match self.growth {
            Growth::Step { .. } => None,
            Growth::Bur { spines, critical_m, .. } => {
                let begin = now();
                let bubble = self.check.bubble(q, critical_m);
                search.statistics.collision_time_s += begin.elapsed().as_secs_f64();
                let spines = if explores { spines } else { 1 };
                bubble.and_then(|bubble| self.bur(q, &bubble, target, spines, search))
            }
        };
        bur.unwrap_or_else(|| {
            let step = self.step(q, target, search);
            let ahead = step.map(|(end, is_target)| Branch { nodes: vec![end], is_target });
            Grown { ahead: ahead.unwrap_or_default(), aside: Vec::new() }
        })
    }

    /// Takes a step from `q` towards `target` (m, rad; one per joint) unless blocked; returns its end, and true at the target.
    pub fn step(&mut self, q: &[f64], target: &[f64], search: &mut Search) -> Option<(Vec<f64>, bool)> {
        let (_, is_target) = self.stepper.towards(self.robot, q, target, self.growth.step_m());
        let (to, frames) = (self.stepper.q(), self.stepper.frames());
        let begin = now();
        let is_free = self.check.edge_to_frames_is_free(q, to, frames);
        search.statistics.collision_checks += 1;
        search.statistics.collision_time_s += begin.elapsed().as_secs_f64();
        is_free.then(|| (to.to_vec(), is_target))
    }

    /// Returns true if the whole edge between two configurations (m, rad; one per joint) is free.
    pub fn edge(&mut self, from: &[f64], to: &[f64], search: &mut Search) -> bool {
        let begin = now();
        search.statistics.collision_checks += 1;
        let is_free = self.check.edge_is_free(from, to);
        search.statistics.collision_time_s += begin.elapsed().as_secs_f64();
        is_free
    }

    /// Returns the bur about `q`, unless its first spine is shorter than a step. The bubble at `q` proves its spines.
    fn bur(
        &mut self,
        q: &[f64],
        bubble: &Bubble,
        target: &[f64],
        spines: usize,
        search: &mut Search,
    ) -> Option<Grown> {
        let first = self.spine(q, bubble, target, search);
        let (end, is_target) = &first;
        let is_long =
            *is_target || self.stepper.displacement_between(self.robot, q, end) >= self.growth.step_m();
        is_long.then(|| {
            let ahead = self.branch(q, first, search);
            let aside = (1..spines)
                .map(|_| {
                    let target = search.sample();
                    let spine = self.spine(q, bubble, &target, search);
                    self.branch(q, spine, search)
                })
                .collect();
            Grown { ahead, aside }
        })
    }

    /// Returns the end of a spine towards `target`, and true if that is the target.
    fn spine(&mut self, q: &[f64], bubble: &Bubble, target: &[f64], search: &mut Search) -> (Vec<f64>, bool) {
        let begin = now();
        let share = self.check.free_share(bubble, target);
        search.statistics.collision_checks += 1;
        search.statistics.collision_time_s += begin.elapsed().as_secs_f64();
        (between(q, target, share).collect(), share >= 1.0)
    }

    /// Returns the nodes of a spine from `q`.
    fn branch(&mut self, q: &[f64], (end, is_target): (Vec<f64>, bool), search: &mut Search) -> Branch {
        if self.check.is_proven_by_bubbles() {
            let nodes = if end == q { Vec::new() } else { vec![end] };
            return Branch { nodes, is_target };
        }
        let mut nodes: Vec<Vec<f64>> = Vec::new();
        loop {
            let from = nodes.last().map_or(q, Vec::as_slice);
            if from == end {
                return Branch { nodes, is_target };
            }
            let Some((next, _)) = self.step(from, &end, search) else {
                return Branch { nodes, is_target: false };
            };
            nodes.push(next);
        }
    }
}
