use cranny_path::RELEASED_STEP_M;
use cranny_task::Problem;
use serde::{Deserialize, Serialize};

use crate::search::connector::{Connector, Path, connect};
use crate::search::graph::roadmap::{Roadmap, RoadmapFile};
use crate::search::growth::{Grower, Growth};
use crate::search::search_state::Search;
use crate::wall_clock::now;
use crate::{Budget, Observer, PlanError, PlanReport, Planner, Ranges, Unobserved};

/// PRM (Kavraki, Švestka, Latombe & Overmars 1996, §3; in the simple form of Karaman & Frazzoli 2011, §3.2) with the goals
/// of all grasps at once.
///
/// 1. The roadmap is read from a file, or empty. The start and the goals, which inverse kinematics finds later, become nodes.
/// 2. If no goal is connected, an iteration adds a uniform random configuration, if it is free. A new node is joined to those
///    of the `neighbours` nearest (L2 in joint space) to which the edge is proven.
/// 3. If the start and a goal are connected, the shortest path between them is taken. Its edges from a file are proven; an edge
///    without a proof is removed.
///
/// One iteration is one random configuration, one checked edge, or one batch of inverse kinematics before there is a goal.
/// Differs from the publication in 1 and 3: the roadmap grows until the query is answered, and has no enhancement phase.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Prm {
    /// Maximum number of nearest nodes to which a node is joined. Default 15.
    pub neighbours: usize,
    /// Number of goals that suffice. Default 100.
    pub goals: usize,
    /// Roadmap file to begin with, which is not modified. Default none.
    pub roadmap: Option<RoadmapFile>,
}

impl Default for Prm {
    fn default() -> Self {
        Self { neighbours: 15, goals: 100, roadmap: None }
    }
}

impl Planner for Prm {
    fn name(&self) -> &'static str {
        "prm"
    }

    fn settings(&self) -> serde_json::Value {
        serde_json::json!(self)
    }

    fn check(&self) -> Result<(), PlanError> {
        Ranges::of(self.name()).count("neighbours", self.neighbours, usize::MAX)?.count(
            "goals",
            self.goals,
            usize::MAX,
        )?;
        Ok(())
    }

    fn plan(
        &self,
        problem: &Problem,
        budget: &Budget,
        seed: u64,
        observer: &mut dyn Observer,
    ) -> Result<PlanReport, PlanError> {
        let robot = problem.robot();
        let roadmap = match &self.roadmap {
            None => Roadmap::new(robot),
            Some(file) => Roadmap::of_file(file, robot)?,
        };
        let mut graph = Graph::new(problem, roadmap, self.neighbours);
        connect(self.name(), &mut graph, self.goals, problem, (budget, seed), observer)
    }
}

impl Prm {
    /// Builds a roadmap of `nodes` nodes for the robot of a problem in its world, for any start and goal. `progress` receives
    /// the number of nodes, and returns false to stop; the roadmap is then returned as it is.
    ///
    /// # Errors
    /// [`TaskError::Goal`](cranny_task::TaskError::Goal) for a criterion other than `exact`.
    pub fn build(
        &self,
        problem: &Problem,
        nodes: usize,
        seed: u64,
        progress: &mut dyn FnMut(usize) -> bool,
    ) -> Result<Roadmap, PlanError> {
        problem.exact_cell(self.name())?;
        let mut observer = Unobserved;
        let mut search = Search::new(
            problem,
            &Budget { time: std::time::Duration::MAX, ..Budget::default() },
            seed,
            &mut observer,
        );
        let mut graph = Graph::new(problem, Roadmap::new(problem.robot()), self.neighbours);
        while graph.roadmap.len() < nodes && progress(graph.roadmap.len()) {
            graph.add_random(&mut search);
        }
        Ok(graph.roadmap)
    }
}

struct Graph<'a> {
    roadmap: Roadmap,
    neighbours: usize,
    grower: Grower<'a>,
    start: usize,
    /// Node of each goal; `None` if the goal was removed.
    goals: Vec<Option<usize>>,
}

impl<'a> Graph<'a> {
    fn new(problem: &'a Problem, roadmap: Roadmap, neighbours: usize) -> Self {
        let grower = Grower::new(problem, Growth::Step { step_m: RELEASED_STEP_M });
        Self { roadmap, neighbours, grower, start: 0, goals: Vec::new() }
    }

    /// Adds a free configuration as a node.
    fn add(&mut self, q: &[f64], search: &mut Search) -> usize {
        let begin = now();
        let near = self.roadmap.nearest(q, self.neighbours);
        search.statistics.nearest_time_s += begin.elapsed().as_secs_f64();
        let node = self.roadmap.add(q);
        let mut first = None;
        for other in near {
            if self.grower.edge(self.roadmap.q(other), q, search) {
                self.roadmap.join(node, other, true);
                first = first.or(Some(other));
            }
        }
        search.observer.node_added(0, q, first);
        node
    }

    fn add_random(&mut self, search: &mut Search) {
        let q = search.sample();
        search.statistics.collision_checks += 1;
        if self.grower.check.is_free(&q) {
            self.add(&q, search);
        }
    }

    /// Runs 3 of [`Prm`] once: proves a path, or removes an edge without a proof.
    fn connected(&mut self, search: &mut Search) -> Option<Connected> {
        let start = self.start;
        let goals: Vec<usize> = self.goals.iter().copied().flatten().collect();
        let reached: Vec<usize> =
            goals.into_iter().filter(|goal| self.roadmap.are_connected(start, *goal)).collect();
        let way = (!reached.is_empty()).then(|| self.roadmap.shortest_way(start, &reached)).flatten()?;
        if self.roadmap.refuted_edge(&way, &mut self.grower, search).is_some() {
            return Some(Connected::Refuted);
        }
        let goal = self.goals.iter().position(|goal| *goal == way.last().copied())?;
        Some(Connected::Path(way.iter().map(|node| self.roadmap.q(*node).to_vec()).collect(), goal))
    }
}

/// Result of the proof of a path in the roadmap.
enum Connected {
    Path(Path, usize),
    Refuted,
}

impl Connector for Graph<'_> {
    fn add_start(&mut self, q: &[f64], search: &mut Search) {
        self.start = self.add(q, search);
    }

    fn add_goal(&mut self, q: &[f64], search: &mut Search) {
        let node = self.add(q, search);
        self.goals.push(Some(node));
    }

    fn grow(&mut self, search: &mut Search) -> Option<(Path, usize)> {
        match self.connected(search) {
            Some(Connected::Path(path, goal)) => Some((path, goal)),
            // A roadmap of another world has many refuted paths. Each is an iteration, so that time and observer are checked.
            Some(Connected::Refuted) => None,
            None => {
                self.add_random(search);
                None
            }
        }
    }

    fn remove_goal(&mut self, goal: usize, _search: &mut Search) {
        self.goals[goal] = None;
    }

    fn nodes(&self) -> usize {
        self.roadmap.len()
    }
}
