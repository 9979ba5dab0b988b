use cranny_path::RELEASED_STEP_M;
use cranny_task::Problem;
use serde::{Deserialize, Serialize};

use crate::search::connector::{Connector, Path, connect};
use crate::search::graph::roadmap::Roadmap;
use crate::search::growth::{Grower, Growth};
use crate::search::search_state::Search;
use crate::wall_clock::now;
use crate::{Budget, Observer, PlanError, PlanReport, Planner, Ranges};

/// Lazy PRM (Bohlin & Kavraki 2000, whole) with the goals of all grasps at once.
///
/// 1. `nodes` uniform random configurations become nodes, unchecked, each joined to the `neighbours` nearest (L2 in joint space);
///    then start and goals. Goals that inverse kinematics finds later are joined in the same way.
/// 2. The nodes of the shortest path from the start to a goal are checked, alternately from both ends. The first one in
///    collision is removed.
/// 3. If all are free, the edges of the path are proven. The first one without a proof is removed. With all proven, the path is
///    the result.
/// 4. If there is no path, `enhance` configurations are added: half of them uniform, the others about the middles of random
///    removed edges, from the normal distribution whose standard deviation is half the length of the edge in each joint.
///
/// One iteration is one random configuration, one search for the shortest path with its checks, or one batch of inverse kinematics
/// before there is a goal. Differs from the publication in that there are many goals, in that nodes have a number of neighbours,
/// not a radius, and in the distribution of 4.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LazyPrm {
    /// Number of random configurations at the beginning. Default 1000.
    pub nodes: usize,
    /// Maximum number of nearest nodes to which a node is joined. Default 15, as in `prm`.
    pub neighbours: usize,
    /// Number of configurations added when no path is left. Default 100.
    pub enhance: usize,
    /// Number of goals that suffice. Default 100.
    pub goals: usize,
}

impl Default for LazyPrm {
    fn default() -> Self {
        Self { nodes: 1000, neighbours: 15, enhance: 100, goals: 100 }
    }
}

impl Planner for LazyPrm {
    fn name(&self) -> &'static str {
        "lazy-prm"
    }

    fn settings(&self) -> serde_json::Value {
        serde_json::json!(self)
    }

    fn check(&self) -> Result<(), PlanError> {
        Ranges::of(self.name())
            .count("nodes", self.nodes, usize::MAX)?
            .count("neighbours", self.neighbours, usize::MAX)?
            .count("enhance", self.enhance, usize::MAX)?
            .count("goals", self.goals, usize::MAX)?;
        Ok(())
    }

    fn plan(
        &self,
        problem: &Problem,
        budget: &Budget,
        seed: u64,
        observer: &mut dyn Observer,
    ) -> Result<PlanReport, PlanError> {
        self.check()?;
        let mut graph = Graph {
            settings: self,
            roadmap: Roadmap::new(problem.robot()),
            are_free: Vec::new(),
            grower: Grower::new(problem, Growth::Step { step_m: RELEASED_STEP_M }),
            start: 0,
            goals: Vec::new(),
            missing: self.nodes,
            is_built: false,
            seeds: Vec::new(),
        };
        connect(self.name(), &mut graph, self.goals, problem, (budget, seed), observer)
    }
}

struct Graph<'a> {
    settings: &'a LazyPrm,
    roadmap: Roadmap,
    /// True for each node that is known to be free.
    are_free: Vec<bool>,
    grower: Grower<'a>,
    start: usize,
    /// Node of each goal; `None` if the goal was removed.
    goals: Vec<Option<usize>>,
    /// Number of random configurations to add before the next search.
    missing: usize,
    /// True once 1 is complete.
    is_built: bool,
    /// Removed edges with a free end (m, rad; one value per joint): the border of free space crosses them.
    seeds: Vec<[Vec<f64>; 2]>,
}

impl Graph<'_> {
    /// Adds a node, joined to its nearest without a check.
    fn add(&mut self, q: &[f64], is_free: bool, search: &mut Search) -> usize {
        let node = self.roadmap.add(q);
        self.are_free.push(is_free);
        let first = self.join_nearest(node, search);
        search.observer.node_added(0, q, first);
        node
    }

    /// Joins a node to its nearest; returns the first.
    fn join_nearest(&mut self, node: usize, search: &mut Search) -> Option<usize> {
        let begin = now();
        let mut near = self.roadmap.nearest(self.roadmap.q(node), self.settings.neighbours.saturating_add(1));
        search.statistics.nearest_time_s += begin.elapsed().as_secs_f64();
        near.retain(|other| *other != node && !self.roadmap.are_joined(node, *other));
        for other in &near {
            self.roadmap.join(node, *other, false);
        }
        near.first().copied()
    }

    /// Performs 1 and 4 of [`LazyPrm`] for one configuration.
    fn add_random(&mut self, search: &mut Search) {
        self.missing -= 1;
        let is_seeded = self.is_built && !self.seeds.is_empty() && search.random.uniform() < 0.5;
        let q = if is_seeded { self.sample_at_seed(search) } else { search.sample() };
        self.add(&q, false, search);
        if self.missing == 0 && !std::mem::replace(&mut self.is_built, true) {
            // They were nodes before their nearest were.
            for node in std::iter::once(self.start).chain(self.goals.clone().into_iter().flatten()) {
                self.join_nearest(node, search);
            }
        }
    }

    fn sample_at_seed(&mut self, search: &mut Search) -> Vec<f64> {
        let [a, b] = &self.seeds[search.random.index(self.seeds.len())];
        let limits = search.problem.robot().limits();
        let normal = |(limits, (a, b)): (&cranny_robot::JointLimits, (&f64, &f64))| {
            let value = f64::midpoint(*a, *b) + 0.5 * (a - b).abs() * search.random.normal();
            value.clamp(limits.lower, limits.upper)
        };
        limits.iter().zip(a.iter().zip(b)).map(normal).collect()
    }

    /// Performs 2 of [`LazyPrm`]; returns true if all nodes of the path are free.
    fn nodes_are_free(&mut self, way: &[usize], search: &mut Search) -> bool {
        let last = way.len() - 1;
        for place in (0..way.len()).map(|turn| if turn % 2 == 0 { turn / 2 } else { last - turn / 2 }) {
            let node = way[place];
            if self.are_free[node] {
                continue;
            }
            search.statistics.collision_checks += 1;
            self.are_free[node] = self.grower.check.is_free(self.roadmap.q(node));
            if !self.are_free[node] {
                let beside = [place.checked_sub(1), Some(place + 1)].into_iter().flatten();
                let beside: Vec<usize> = beside.filter_map(|place| way.get(place).copied()).collect();
                beside.into_iter().filter(|other| self.are_free[*other]).for_each(|other| {
                    self.seeds.push([node, other].map(|node| self.roadmap.q(node).to_vec()));
                });
                self.roadmap.isolate(node);
                return false;
            }
        }
        true
    }

    /// Performs 2 and 3 of [`LazyPrm`] for the shortest path, if there is one.
    fn query(&mut self, search: &mut Search) -> Option<(Path, usize)> {
        let goals: Vec<usize> = self.goals.iter().copied().flatten().collect();
        let Some(way) = self.roadmap.shortest_way(self.start, &goals) else {
            self.missing = self.settings.enhance;
            return None;
        };
        if !self.nodes_are_free(&way, search) {
            return None;
        }
        if let Some(refuted) = self.roadmap.refuted_edge(&way, &mut self.grower, search) {
            self.seeds.push(refuted.map(|node| self.roadmap.q(node).to_vec()));
            return None;
        }
        let goal = self.goals.iter().position(|goal| *goal == way.last().copied())?;
        Some((way.iter().map(|node| self.roadmap.q(*node).to_vec()).collect(), goal))
    }
}

impl Connector for Graph<'_> {
    fn add_start(&mut self, q: &[f64], search: &mut Search) {
        self.start = self.add(q, true, search);
    }

    fn add_goal(&mut self, q: &[f64], search: &mut Search) {
        let node = self.add(q, true, search);
        self.goals.push(Some(node));
    }

    fn grow(&mut self, search: &mut Search) -> Option<(Path, usize)> {
        if self.missing > 0 {
            self.add_random(search);
            return None;
        }
        self.query(search)
    }

    fn remove_goal(&mut self, goal: usize, _search: &mut Search) {
        self.goals[goal] = None;
    }

    fn nodes(&self) -> usize {
        self.roadmap.len()
    }
}
