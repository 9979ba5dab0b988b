use std::time::{Duration, Instant};

use cranny_plan::{Budget, Observer, Outcome, PlanError, Statistics, default_planner, search};
use cranny_spatial::other_seed;
use cranny_task::Problem;

/// Iterations of the first searches on from a grasp that was reached: most need fewer than a hundred.
const FIRST_ITERATIONS: u64 = 250;
/// After so many that found none the next ones may take twice as many.
const SEARCHES_PER_DOUBLING: u32 = 8;
/// Iterations of the shortest searches where an object is put down. From most grasps there is no way, and from some it is
/// found soon: to look long from few is worse than to look shortly from many.
const PLACE_ITERATIONS: u64 = 500;

/// Length of the searches for a later object, as a multiple of those for a way on from a grasp.
const PICK_SHARE: u64 = 8;
/// Grasps of a later object from which nothing leads on after which the shortest searches give it up.
const MOST_GRASPS: u64 = 2;

/// Budget and account of the searches of a task after its first stage.
pub(crate) struct Effort {
    pub seed: u64,
    begin: Instant,
    time: Duration,
    /// True if an object is put down in the task.
    places: bool,
    /// Searches that ended without a path.
    exhausted: u32,
    /// Cost of all of them.
    pub spent: Statistics,
}

impl Effort {
    /// A budget of so much time from now on.
    pub fn new((seed, time): (u64, Duration), places: bool) -> Self {
        Self { seed, begin: Instant::now(), time, places, exhausted: 0, spent: Statistics::default() }
    }

    /// Time that is left.
    pub fn left(&self) -> Duration {
        self.time.saturating_sub(self.begin.elapsed())
    }

    /// Number of searches that ended without a path.
    pub fn exhausted(&self) -> u32 {
        self.exhausted
    }

    /// Budget of the next search: by Luby's sequence where an object is put down, else doubling.
    pub fn next_budget(&self) -> Budget {
        let iterations = if self.places {
            PLACE_ITERATIONS * luby(self.exhausted + 1)
        } else {
            FIRST_ITERATIONS << (self.exhausted / SEARCHES_PER_DOUBLING).min(u64::BITS / 2)
        };
        Budget { iterations, time: self.left() }
    }

    /// Budget of the next search for a later object.
    pub fn next_pick_budget(&self) -> Budget {
        let budget = self.next_budget();
        Budget { iterations: budget.iterations.saturating_mul(PICK_SHARE), ..budget }
    }

    /// Number of grasps of a later object from which nothing may lead on before it is given up.
    pub fn patience(&self) -> usize {
        usize::try_from(MOST_GRASPS * luby(self.exhausted + 1)).unwrap_or(usize::MAX)
    }

    /// Adds the cost of a search to the account.
    pub fn count(&mut self, statistics: &Statistics, outcome: Outcome) {
        self.spent = self.spent.with(statistics);
        self.exhausted += u32::from(outcome == Outcome::BudgetExhausted);
    }

    /// A path of way points (m, rad; one value per joint) that solves a problem, if a search with the next budget
    /// finds one.
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

    /// The seed of the search of this number for one thing.
    pub fn seed_of(&self, number: u64) -> u64 {
        other_seed(self.seed, number)
    }
}

/// Passes on nothing but that the search should stop, which it also should where it has become hopeless.
pub(crate) struct Stop<'a> {
    pub observer: &'a dyn Observer,
    pub is_hopeless: &'a dyn Fn() -> bool,
}

impl Observer for Stop<'_> {
    fn should_stop(&self) -> bool {
        self.observer.should_stop() || (self.is_hopeless)()
    }
}

/// Passes on everything, and stops the search too where it has become hopeless.
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

/// The term of this number, from 1 on, of 1, 1, 2, 1, 1, 2, 4, 1, 1, 2, 1, 1, 2, 4, 8, …: the length, as a multiple of
/// the first, of each of many searches whose run time is unknown (Luby, Sinclair & Zuckerman 1993, "Optimal speedup of
/// Las Vegas algorithms", whole: the strategy `S^univ`).
fn luby(number: u32) -> u64 {
    let mut number = u64::from(number);
    loop {
        // Of the run of terms that it stands in, as long as 2ᵏ − 1, the last is 2ᵏ⁻¹; before it the last run comes twice.
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
