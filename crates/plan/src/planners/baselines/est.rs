use cranny_path::RELEASED_STEP_M;
use cranny_robot::distance;
use cranny_spatial::Stream;
use cranny_task::Problem;
use serde::{Deserialize, Serialize};

use crate::neighbours::near_set::NearSet;
use crate::search::connector::{Connector, Path, connect};
use crate::search::graph::two_trees::TwoTrees;
use crate::search::growth::{Grower, Growth};
use crate::search::search_state::Search;
use crate::wall_clock::now;
use crate::{Budget, Observer, PlanError, PlanReport, Planner, Ranges};

/// Expansive space trees (Hsu, Latombe & Motwani 1997, algorithms `expansion` and `connection`, whole) with the goals of all
/// grasps at once.
///
/// The bidirectional form, which OMPL calls `BiEST`: it is that of the publication, and grasps are often in narrow places, from
/// which a tree leaves more easily than another one finds its way in.
///
/// 1. Inverse kinematics adds goal configurations, each the root of its own tree.
/// 2. Expansion, of the tree from the start and of the forest from the goals in turn: a node x is drawn with probability in
///    proportion to 1/w(x), where w counts the nodes of its side in the neighbourhood, and `samples` configurations are drawn
///    uniformly from the neighbourhood of x. Each is retained with probability 1/w, and becomes a node if the edge is proven.
/// 3. Connection: a new node is joined with the nodes of the other side within `join`, the nearest first, until an edge is proven.
///
/// The neighbourhood is the box of half width `radius`, that for connections the box of half width `join`. One iteration is one
/// expansion with its connections, or one batch of inverse kinematics before there is a goal. Differs from the publication in
/// 1, and in that the connections follow each expansion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Est {
    /// Half width of the neighbourhood, in m or rad for each joint. Default 0.4.
    pub radius: f64,
    /// Number of configurations drawn in an expansion. Default 1.
    pub samples: usize,
    /// Maximum difference of any joint between two nodes that a connection joins, in m or rad. Default 1.
    pub join: f64,
    /// Number of goals that suffice. Default 100.
    pub goals: usize,
}

impl Default for Est {
    fn default() -> Self {
        Self { radius: 0.4, samples: 1, join: 1.0, goals: 100 }
    }
}

impl Planner for Est {
    fn name(&self) -> &'static str {
        "est"
    }

    fn settings(&self) -> serde_json::Value {
        serde_json::json!(self)
    }

    fn check(&self) -> Result<(), PlanError> {
        Ranges::of(self.name())
            .positive("radius", self.radius)?
            .count("samples", self.samples, 1000)?
            .positive("join", self.join)?
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
        let dof = problem.robot().dof();
        let crowd = Crowd { near: NearSet::new(dof), counts: Vec::new() };
        let mut spaces = Spaces {
            settings: self,
            trees: TwoTrees::new(dof),
            crowds: [crowd.clone(), crowd],
            grower: Grower::new(problem, Growth::Step { step_m: RELEASED_STEP_M }),
            side: 0,
            fresh: Vec::new(),
        };
        connect(self.name(), &mut spaces, self.goals, problem, (budget, seed), observer)
    }
}

/// Nodes of a side with the number of nodes in their neighbourhoods.
#[derive(Clone)]
struct Crowd {
    near: NearSet,
    /// w of each node, itself included; 0 if it was cut off.
    counts: Vec<usize>,
}

impl Crowd {
    /// Adds a node with the others in its neighbourhood.
    fn add(&mut self, q: &[f64], near: &[usize]) {
        self.near.add(q);
        self.counts.push(near.len() + 1);
        for &other in near {
            self.counts[other] += 1;
        }
    }

    /// Draws a node with probability in proportion to 1/w.
    fn draw(&self, random: &mut Stream) -> Option<usize> {
        let living = || self.counts.iter().enumerate().filter(|(_, count)| **count > 0);
        let weight = |count: usize| 1.0 / count as f64;
        let total: f64 = living().map(|(_, count)| weight(*count)).sum();
        let mut left = random.uniform() * total;
        let drawn = living().find(|(_, count)| {
            left -= weight(**count);
            left < 0.0
        });
        // Rounding may leave nothing to be drawn.
        drawn.or_else(|| living().next_back()).map(|(node, _)| node)
    }
}

struct Spaces<'a> {
    settings: &'a Est,
    trees: TwoTrees,
    crowds: [Crowd; 2],
    grower: Grower<'a>,
    /// Side that grows next.
    side: usize,
    /// Sides and nodes that connections have not tried yet.
    fresh: Vec<(usize, usize)>,
}

impl Spaces<'_> {
    /// Performs 2 of [`Est`].
    fn expand(&mut self, search: &mut Search) -> Option<()> {
        let side = self.side;
        self.side = 1 - side;
        let from = self.crowds[side].draw(&mut search.random)?;
        let q = self.trees.sides[side].q(from).to_vec();
        for _ in 0..self.settings.samples {
            let sample = search.sample_near(&q, self.settings.radius);
            let near = self.near(side, &sample, search);
            let is_retained = search.random.uniform() * (near.len() as f64) < 1.0;
            if is_retained && self.grower.edge(&q, &sample, search) {
                let node = self.trees.add(side, &sample, Some(from), search);
                self.admit(side, node, &near);
            }
        }
        Some(())
    }

    /// Performs 3 of [`Est`] for the new nodes.
    fn connect(&mut self, search: &mut Search) -> Option<(Path, usize)> {
        while let Some((side, node)) = self.fresh.pop() {
            let q = self.trees.sides[side].q(node).to_vec();
            let begin = now();
            let others = self.crowds[1 - side].near.in_box(&q, self.settings.join).into_iter();
            let distance_to = |other| distance(&q, self.trees.sides[1 - side].q(other));
            let mut others: Vec<(f64, usize)> = others.map(|other| (distance_to(other), other)).collect();
            others.sort_by(|a, b| a.0.total_cmp(&b.0));
            search.statistics.nearest_time_s += begin.elapsed().as_secs_f64();
            for (_, other) in others {
                let end = self.trees.sides[1 - side].q(other).to_vec();
                if !self.grower.edge(&q, &end, search) {
                    continue;
                }
                let meeting = self.trees.add(side, &end, Some(node), search);
                return Some(self.trees.path_through(if side == 0 {
                    [meeting, other]
                } else {
                    [other, meeting]
                }));
            }
        }
        None
    }

    fn near(&self, side: usize, q: &[f64], search: &mut Search) -> Vec<usize> {
        let begin = now();
        let near = self.crowds[side].near.in_box(q, self.settings.radius);
        search.statistics.nearest_time_s += begin.elapsed().as_secs_f64();
        near
    }

    /// Counts a new node among the others in its neighbourhood, and marks it for connections.
    fn admit(&mut self, side: usize, node: usize, near: &[usize]) {
        self.crowds[side].add(self.trees.sides[side].q(node), near);
        self.fresh.push((side, node));
    }
}

impl Connector for Spaces<'_> {
    fn add_start(&mut self, q: &[f64], search: &mut Search) {
        let root = self.trees.add(0, q, None, search);
        self.admit(0, root, &[]);
    }

    fn add_goal(&mut self, q: &[f64], search: &mut Search) {
        let near = self.near(1, q, search);
        let root = self.trees.add_goal(q, search);
        self.admit(1, root, &near);
    }

    fn grow(&mut self, search: &mut Search) -> Option<(Path, usize)> {
        self.expand(search);
        self.connect(search)
    }

    fn remove_goal(&mut self, goal: usize, search: &mut Search) {
        let root = self.trees.root(goal);
        self.trees.remove_goal(goal, search);
        for node in root..self.crowds[1].counts.len() {
            if self.trees.sides[1].nodes_to_root(node).contains(&root) {
                self.crowds[1].counts[node] = 0;
                self.crowds[1].near.remove(node);
                self.fresh.retain(|fresh| *fresh != (1, node));
            }
        }
    }

    fn nodes(&self) -> usize {
        self.trees.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_are_drawn_in_proportion_to_one_over_their_crowd() {
        const RADIUS: f64 = 0.5;
        const DRAWS: usize = 100_000;
        let mut crowd = Crowd { near: NearSet::new(1), counts: Vec::new() };
        for q in [0.0, 0.1, 0.2, 3.0, 0.65] {
            let near = crowd.near.in_box(&[q], RADIUS);
            crowd.add(&[q], &near);
        }
        assert_eq!(crowd.counts, [3, 3, 4, 1, 2]);
        let mut random = Stream::new(1, 0);
        let mut drawn = [0.0; 5];
        for _ in 0..DRAWS {
            drawn[crowd.draw(&mut random).expect("a node")] += 1.0 / DRAWS as f64;
        }
        let total: f64 = crowd.counts.iter().map(|count| 1.0 / *count as f64).sum();
        for (drawn, count) in drawn.into_iter().zip(&crowd.counts) {
            // Five standard deviations of a share of 100 000 draws.
            assert!((drawn - 1.0 / *count as f64 / total).abs() < 0.008, "{drawn} of those with {count}");
        }
        crowd.counts = vec![0, 0, 2, 0, 0];
        assert_eq!(crowd.draw(&mut random), Some(2));
        crowd.counts = vec![0; 5];
        assert_eq!(crowd.draw(&mut random), None);
    }
}
