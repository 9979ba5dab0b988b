//! The command `cranny` with one more planner: two trees that grow towards each other by proven edges.
//!
//! `cargo run --release -- bench run --scenarios 021 --planners two-trees,reach --runs 5 -o results.sqlite`

use std::process::ExitCode;

use cranny::collision::{Cell, Motion, Scratch};
use cranny::path::JointMetric;
use cranny::plan::{Connector, Forest, Path, PlanError, PlanReport, Ranges, Search, connect};
use cranny::{Budget, Observer, Planner, Problem, Registry, robot::between};
use serde::{Deserialize, Serialize};

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct TwoTrees {
    /// The longest edge, in the metric weighted by reach.
    step: f64,
}

impl Default for TwoTrees {
    fn default() -> Self {
        Self { step: 0.3 }
    }
}

impl Planner for TwoTrees {
    fn name(&self) -> &'static str {
        "two-trees"
    }

    fn settings(&self) -> serde_json::Value {
        serde_json::json!(self)
    }

    fn check(&self) -> Result<(), PlanError> {
        Ranges::of(self.name()).positive("step", self.step).map(drop)
    }

    fn plan(
        &self,
        problem: &Problem,
        budget: &Budget,
        seed: u64,
        observer: &mut dyn Observer,
    ) -> Result<PlanReport, PlanError> {
        let (cell, robot) = (problem.exact_cell(self.name())?, problem.robot());
        let sides = [0, 1].map(|_| Forest::new(robot.dof(), JointMetric::by_reach(robot)));
        let mut trees = Trees { step: self.step, cell, scratch: cell.scratch(), sides, goals: Vec::new() };
        connect(self.name(), &mut trees, 100, problem, (budget, seed), observer)
    }
}

/// A tree from the start, and one from each goal.
struct Trees<'a> {
    step: f64,
    cell: &'a Cell,
    scratch: Scratch,
    sides: [Forest; 2],
    goals: Vec<usize>,
}

impl Connector for Trees<'_> {
    fn add_start(&mut self, q: &[f64], _: &mut Search) {
        self.sides[0].add_root(q, 0.0);
    }

    fn add_goal(&mut self, q: &[f64], _: &mut Search) {
        self.goals.push(self.sides[1].add_root(q, 0.0));
    }

    fn grow(&mut self, search: &mut Search) -> Option<(Path, usize)> {
        let side = usize::from(self.sides[1].len() < self.sides[0].len());
        let (new, _) = self.extend(side, &search.sample())?;
        let meeting = self.sides[side].q(new).to_vec();
        loop {
            let (met, arrived) = self.extend(1 - side, &meeting)?;
            if arrived {
                let [from, to] = if side == 0 { [new, met] } else { [met, new] };
                let root = *self.sides[1].nodes_to_root(to).last()?;
                let back = self.sides[1].path_to(to).into_iter().rev().skip(1);
                let path = self.sides[0].path_to(from).into_iter().chain(back).collect();
                return Some((path, self.goals.iter().position(|goal| *goal == root)?));
            }
        }
    }

    fn remove_goal(&mut self, goal: usize, _: &mut Search) {
        self.sides[1].cut(self.goals[goal]);
    }

    fn nodes(&self) -> usize {
        self.sides.iter().map(Forest::len).sum()
    }
}

impl Trees<'_> {
    /// The node a step nearer to the target, if the edge to it is proven free, and whether that is the target.
    fn extend(&mut self, side: usize, target: &[f64]) -> Option<(usize, bool)> {
        let nearest = self.sides[side].nearest(target)?;
        let from = self.sides[side].q(nearest).to_vec();
        let share = (self.step / self.sides[side].distance(&from, target)).min(1.0);
        let to = if share < 1.0 { between(&from, target, share).collect() } else { target.to_vec() };
        (self.cell.motion_is_free(&from, &to, &mut self.scratch) == Motion::Proven)
            .then(|| (self.sides[side].add(&to, Some(nearest)), share >= 1.0))
    }
}

fn main() -> ExitCode {
    cranny::command::main(&Registry::default().with::<TwoTrees>().expect("a name that is not taken"))
}
