use cranny_path::RELEASED_STEP_M;
use cranny_robot::distance;
use cranny_task::Problem;
use serde::{Deserialize, Serialize};

use crate::neighbours::near_set::NearSet;
use crate::planners::rrt::KnownGoals;
use crate::search::connector::{Connector, Path, connect};
use crate::search::growth::{Grower, Growth};
use crate::search::search_state::Search;
use crate::wall_clock::now;
use crate::{Budget, NearestNeighbours, Observer, PlanError, PlanReport, Planner, Ranges, Rrt};

/// RRT* with the k nearest (Karaman & Frazzoli 2011, Algorithm 6 and §3.3.3) to the goals of all grasps at once: its paths
/// converge to the shortest ones (L2 in joint space).
///
/// 1. As in [`Rrt`], inverse kinematics finds goals meanwhile, and a step is taken towards a goal or a random configuration.
/// 2. Among the `k = ⌈e·(1 + 1/dof)·ln n⌉` nearest of n nodes, the parent of the new node is the one with the shortest path to
///    it and a proven edge. Each of the others is rewired to the new node if that shortens its path and the edge is proven.
/// 3. The shortest path to any goal is returned `refinements` iterations after the first path, or when the budget is spent.
///
/// One iteration is one step, or one batch of inverse kinematics before there is a goal. Differs from the publication in
/// that there are many goals, in 3, and in that the length of a step is measured at the links.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RrtStar {
    /// [`Rrt::p_goal`].
    pub p_goal: f64,
    /// [`Rrt::step_m`].
    pub step_m: f64,
    /// [`Rrt::goals`].
    pub goals: usize,
    /// Number of iterations after the first path. Default 1000.
    pub refinements: u64,
}

impl Default for RrtStar {
    fn default() -> Self {
        let Rrt { p_goal, goals, .. } = Rrt::default();
        Self { p_goal, step_m: RELEASED_STEP_M, goals, refinements: 1000 }
    }
}

impl Planner for RrtStar {
    fn name(&self) -> &'static str {
        "rrt-star"
    }

    fn settings(&self) -> serde_json::Value {
        serde_json::json!(self)
    }

    fn check(&self) -> Result<(), PlanError> {
        Ranges::of(self.name())
            .share("p_goal", self.p_goal)?
            .positive("step_m", self.step_m)?
            .count("goals", self.goals, usize::MAX)?
            .positive("refinements", self.refinements as f64)?;
        Ok(())
    }

    fn plan(
        &self,
        problem: &Problem,
        budget: &Budget,
        seed: u64,
        observer: &mut dyn Observer,
    ) -> Result<PlanReport, PlanError> {
        let mut tree = Tree {
            settings: self,
            nodes: Vec::new(),
            index: NearestNeighbours::new(problem.robot().dof()),
            near: NearSet::new(problem.robot().dof()),
            goals: KnownGoals::default(),
            arrivals: Vec::new(),
            refined: 0,
            grower: Grower::new(problem, Growth::Step { step_m: self.step_m }),
        };
        connect(self.name(), &mut tree, self.goals, problem, (budget, seed), observer)
    }
}

#[derive(Clone, Debug)]
struct Node {
    q: Vec<f64>,
    parent: Option<usize>,
    children: Vec<usize>,
    /// Length of the path from the start.
    cost: f64,
}

struct Tree<'a> {
    settings: &'a RrtStar,
    nodes: Vec<Node>,
    index: NearestNeighbours,
    near: NearSet,
    goals: KnownGoals,
    /// Nodes at goals, each with the index of its goal.
    arrivals: Vec<(usize, usize)>,
    /// Number of iterations since the first path.
    refined: u64,
    grower: Grower<'a>,
}

impl Tree<'_> {
    /// Runs 1 and 2 of [`RrtStar`].
    fn extend(&mut self, search: &mut Search) -> Option<()> {
        let (target, goal) = self.goals.target(self.settings.p_goal, search);
        let begin = now();
        let nearest = self.index.nearest(&target)?;
        search.statistics.nearest_time_s += begin.elapsed().as_secs_f64();
        let from = self.nodes[nearest].q.clone();
        if from == target {
            self.arrive(nearest, goal?);
            return None;
        }
        let (q, is_target) = self.grower.step(&from, &target, search)?;
        let begin = now();
        let near = self.near.nearest(&q, rewired(self.nodes.len(), q.len()));
        search.statistics.nearest_time_s += begin.elapsed().as_secs_f64();
        let parent = self.best_parent(nearest, &near, &q, search);
        let node = self.add(&q, Some(parent), search);
        for other in near {
            let cost = self.nodes[node].cost + distance(&q, &self.nodes[other].q);
            if cost < self.nodes[other].cost - ROUNDING
                && self.is_proven(node, &self.nodes[other].q.clone(), search)
            {
                self.join(other, node, cost);
            }
        }
        if let Some(goal) = goal.filter(|_| is_target) {
            self.arrive(node, goal);
        }
        None
    }

    /// Returns the node with the shortest path to `q`; the edge from `nearest` is proven.
    fn best_parent(&mut self, nearest: usize, near: &[usize], q: &[f64], search: &mut Search) -> usize {
        let cost = |node: usize| self.nodes[node].cost + distance(&self.nodes[node].q, q);
        let bar = cost(nearest);
        let mut better: Vec<(f64, usize)> = near.iter().map(|&node| (cost(node), node)).collect();
        better.retain(|(cost, _)| *cost < bar);
        better.sort_by(|a, b| a.0.total_cmp(&b.0));
        let proven = better.into_iter().find(|(_, node)| self.is_proven(*node, q, search));
        proven.map_or(nearest, |(_, node)| node)
    }

    fn is_proven(&mut self, from: usize, to: &[f64], search: &mut Search) -> bool {
        self.grower.edge(&self.nodes[from].q, to, search)
    }

    fn add(&mut self, q: &[f64], parent: Option<usize>, search: &mut Search) -> usize {
        search.observer.node_added(0, q, parent);
        self.index.add(q);
        let node = self.near.add(q);
        let cost = parent.map_or(0.0, |parent| self.nodes[parent].cost + distance(&self.nodes[parent].q, q));
        self.nodes.push(Node { q: q.to_vec(), parent, children: Vec::new(), cost });
        if let Some(parent) = parent {
            self.nodes[parent].children.push(node);
        }
        node
    }

    /// Gives a node another parent, with which the path to it costs `cost`.
    fn join(&mut self, node: usize, parent: usize, cost: f64) {
        if let Some(old) = self.nodes[node].parent.replace(parent) {
            self.nodes[old].children.retain(|child| *child != node);
        }
        self.nodes[parent].children.push(node);
        let less = self.nodes[node].cost - cost;
        let mut open = vec![node];
        while let Some(node) = open.pop() {
            self.nodes[node].cost -= less;
            open.extend(&self.nodes[node].children);
        }
    }

    fn arrive(&mut self, node: usize, goal: usize) {
        if !self.arrivals.contains(&(node, goal)) {
            self.arrivals.push((node, goal));
        }
    }
}

/// Minimum saving of a rewiring, above rounding errors, so that no node becomes its own ancestor.
const ROUNDING: f64 = 1e-9;

/// Returns the number of nearest nodes to check among `nodes`.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some dozens")]
fn rewired(nodes: usize, dof: usize) -> usize {
    let factor = std::f64::consts::E * (1.0 + 1.0 / dof as f64);
    (factor * libm::log(nodes as f64)).ceil().max(1.0) as usize
}

impl Connector for Tree<'_> {
    fn add_start(&mut self, q: &[f64], search: &mut Search) {
        self.add(q, None, search);
    }

    fn add_goal(&mut self, q: &[f64], _search: &mut Search) {
        self.goals.add(q);
    }

    fn grow(&mut self, search: &mut Search) -> Option<(Path, usize)> {
        self.extend(search);
        if self.arrivals.is_empty() {
            return None;
        }
        self.refined += 1;
        if self.refined > self.settings.refinements { self.best() } else { None }
    }

    fn best(&self) -> Option<(Path, usize)> {
        let by_cost =
            |a: &&(usize, usize), b: &&(usize, usize)| self.nodes[a.0].cost.total_cmp(&self.nodes[b.0].cost);
        let &(node, goal) = self.arrivals.iter().min_by(by_cost)?;
        let way = std::iter::successors(Some(node), |&node| self.nodes[node].parent);
        let mut path: Path = way.map(|node| self.nodes[node].q.clone()).collect();
        path.reverse();
        Some((path, goal))
    }

    fn remove_goal(&mut self, goal: usize, _search: &mut Search) {
        self.goals.remove(goal);
        self.arrivals.retain(|(_, arrived)| *arrived != goal);
    }

    fn nodes(&self) -> usize {
        self.nodes.len()
    }
}
