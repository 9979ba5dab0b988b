use cranny_collision::{Cell, Scratch, UncheckedReason};
use cranny_spatial::Pose;

use crate::search::no_grasp::all_excluded;
use crate::wall_clock::now;
use crate::{Budget, Observer, Outcome, PlanError, PlanReport, Planner, Problem, Statistics};

/// Runs a planner. If a node of its search shows a pair of links free that was not checked because it touched in
/// every sample, the pair is checked from then on: `problem` becomes one that checks it, and the search begins anew. Where
/// every grasp is excluded beforehand, by its width or as beyond reach, no search is begun.
///
/// # Errors
/// Those of the planner.
pub fn search(
    planner: &dyn Planner,
    problem: &mut Problem,
    budget: &Budget,
    seed: u64,
    observer: &mut dyn Observer,
) -> Result<PlanReport, PlanError> {
    planner.check()?;
    let begin = now();
    if let Some(failures) = all_excluded(problem).filter(|_| problem.start_is_free()) {
        let report = PlanReport::of(Err(Outcome::NoReachableGrasp), Statistics::default());
        return Ok(PlanReport { failures, ..report });
    }
    while let Some(cell) = problem.cell() {
        if !cell.unchecked().iter().any(|unchecked| unchecked.reason == UncheckedReason::AlwaysTouching) {
            break;
        }
        let cell = cell.clone();
        let before = begin.elapsed();
        let budget = Budget { time: budget.time.saturating_sub(before), ..*budget };
        let mut watch =
            PairWatch { scratch: Box::new(cell.scratch()), cell: &cell, free: Vec::new(), observer };
        let mut report = planner.plan(problem, &budget, seed, &mut watch)?;
        let mut free = std::mem::take(&mut watch.free);
        for q in &report.path {
            free.extend(cell.unchecked_but_free_at(q, &mut watch.scratch));
        }
        if free.is_empty() {
            report.statistics.planning_time_s += before.as_secs_f64();
            return Ok(report);
        }
        problem.checking_pairs(&free);
    }
    let before = begin.elapsed();
    let budget = Budget { time: budget.time.saturating_sub(before), ..*budget };
    let mut report = planner.plan(problem, &budget, seed, observer)?;
    report.statistics.planning_time_s += before.as_secs_f64();
    Ok(report)
}

/// Looks at every node for pairs that are free though they are not checked.
struct PairWatch<'a> {
    cell: &'a Cell,
    scratch: Box<Scratch>,
    free: Vec<(usize, usize)>,
    observer: &'a mut dyn Observer,
}

impl Observer for PairWatch<'_> {
    fn node_added(&mut self, tree: usize, q: &[f64], parent: Option<usize>) {
        if self.free.is_empty() {
            self.free = self.cell.unchecked_but_free_at(q, &mut self.scratch);
        }
        self.observer.node_added(tree, q, parent);
    }

    fn node_cut(&mut self, tree: usize, node: usize) {
        self.observer.node_cut(tree, node);
    }

    fn progress(&mut self, iterations: u64) {
        self.observer.progress(iterations);
    }

    fn accepts_grasp(&mut self, world_from_tip: &Pose) -> bool {
        self.observer.accepts_grasp(world_from_tip)
    }

    fn accepts_goal(&mut self, path: &[Vec<f64>]) -> bool {
        self.observer.accepts_goal(path)
    }

    fn should_stop(&self) -> bool {
        !self.free.is_empty() || self.observer.should_stop()
    }
}
