use std::time::{Duration, Instant};

use cranny_plan::{Budget, Observer, Outcome, PlanError, Statistics, default_planner, search};
use cranny_spatial::other_seed;
use cranny_task::Problem;

/// Iteration limit of the first searches after a reached grasp: most need fewer than a hundred.
const FIRST_ITERATIONS: u64 = 250;
/// Number of failed searches after which the iteration limit of the next ones doubles.
const SEARCHES_PER_DOUBLING: u32 = 8;
/// Iteration limit of the shortest searches if an object is put down. Most grasps have no path, and some have one that is found
/// soon: short searches from many grasps beat long ones from few.
const PLACE_ITERATIONS: u64 = 500;

/// Iteration limit of the searches for a later object, as a multiple of that after a grasp.
const PICK_SHARE: u64 = 8;
/// Number of grasps of a later object without a continuation after which the shortest searches give it up.
const MOST_GRASPS: u64 = 2;

/// Budget and statistics of the searches of a task after its first stage.
pub(crate) struct Effort {
    pub seed: u64,
    begin: Instant,
    time: Duration,
    /// True if an object is put down in the task.
    places: bool,
    exhausted: u32,
    /// Statistics of all searches, successful ones included.
    pub spent: Statistics,
}

impl Effort {
    /// Creates a budget with a time limit that starts now.
    pub fn new((seed, time): (u64, Duration), places: bool) -> Self {
        Self { seed, begin: Instant::now(), time, places, exhausted: 0, spent: Statistics::default() }
    }

    /// Remaining time.
    pub fn left(&self) -> Duration {
        self.time.saturating_sub(self.begin.elapsed())
    }

    /// Number of searches that ended without a path.
    pub fn exhausted(&self) -> u32 {
        self.exhausted
    }

    /// Returns the budget of the next search: by Luby's sequence if an object is put down, otherwise doubling.
    pub fn next_budget(&self) -> Budget {
        let iterations = if self.places {
            PLACE_ITERATIONS * luby(self.exhausted + 1)
        } else {
            FIRST_ITERATIONS << (self.exhausted / SEARCHES_PER_DOUBLING).min(u64::BITS / 2)
        };
        Budget { iterations, time: self.left() }
    }

    /// Returns the budget of the next search for a later object.
    pub fn next_pick_budget(&self) -> Budget {
        let budget = self.next_budget();
        Budget { iterations: budget.iterations.saturating_mul(PICK_SHARE), ..budget }
    }

    /// Number of grasps of a later object without a continuation after which it is given up.
    pub fn patience(&self) -> usize {
        usize::try_from(MOST_GRASPS * luby(self.exhausted + 1)).unwrap_or(usize::MAX)
    }

    /// Adds the statistics of a search.
    pub fn count(&mut self, statistics: &Statistics, outcome: Outcome) {
        self.spent = self.spent.with(statistics);
        self.exhausted += u32::from(outcome == Outcome::BudgetExhausted);
    }

    /// Searches, with the next budget, for a path of way points (m, rad; one value per joint) that solves a problem.
    pub fn search(
        &mut self,
        problem: &Problem,
        observer: &dyn Observer,
    ) -> Result<Option<Vec<Vec<f64>>>, PlanError> {
        let planner = default_planner(problem);
        let mut stop = Stop { observer, is_hopeless: &|| false };
        let report = search(planner.as_ref(), problem, &self.next_budget(), self.seed, &mut stop)?;
        self.count(&report.statistics, report.outcome);
        Ok((report.outcome == Outcome::Solved).then_some(report.path))
    }

    pub fn seed_of(&self, number: u64) -> u64 {
        other_seed(self.seed, number)
    }
}

/// Observer that forwards only the request to stop, and also stops a search that has become hopeless.
pub(crate) struct Stop<'a> {
    pub observer: &'a dyn Observer,
    pub is_hopeless: &'a dyn Fn() -> bool,
}

impl Observer for Stop<'_> {
    fn should_stop(&self) -> bool {
        self.observer.should_stop() || (self.is_hopeless)()
    }
}

/// Observer that forwards all events, and also stops a search that has become hopeless.
pub(crate) struct First<'a> {
    pub observer: &'a mut dyn Observer,
    pub is_hopeless: &'a dyn Fn() -> bool,
}

impl Observer for First<'_> {
    fn node_added(&mut self, tree: usize, q: &[f64], parent: Option<usize>) {
        self.observer.node_added(tree, q, parent);
    }

    fn node_cut(&mut self, tree: usize, node: usize) {
        self.observer.node_cut(tree, node);
    }

    fn progress(&mut self, iterations: u64) {
        self.observer.progress(iterations);
    }

    fn should_stop(&self) -> bool {
        self.observer.should_stop() || (self.is_hopeless)()
    }
}

/// Returns the term with this number, from 1 on, of 1, 1, 2, 1, 1, 2, 4, 1, 1, 2, 1, 1, 2, 4, 8, …: the length, as a multiple
/// of the first, of each of many searches whose run time is unknown (Luby, Sinclair & Zuckerman 1993, "Optimal speedup of Las
/// Vegas algorithms", whole: the strategy `S^univ`).
fn luby(number: u32) -> u64 {
    let mut number = u64::from(number);
    loop {
        // A run of 2ᵏ − 1 terms ends with 2ᵏ⁻¹; before it, the previous run occurs twice.
        let run = (number + 1).next_power_of_two();
        if run == number + 1 {
            return run / 2;
        }
        number -= run / 2 - 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn searches_take_twice_as_long_half_as_often() {
        let terms: Vec<u64> = (1..=15).map(luby).collect();
        assert_eq!(terms, [1, 1, 2, 1, 1, 2, 4, 1, 1, 2, 1, 1, 2, 4, 8]);
    }
}
