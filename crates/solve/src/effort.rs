use std::time::{Duration, Instant};

use cranny_plan::{Budget, Observer, Outcome, PlanError, Problem, Statistics, default_planner, search};
use cranny_spatial::other_seed;

/// Iterations of the first searches on from a grasp that was reached: most need fewer than a hundred.
const FIRST_ITERATIONS: u64 = 250;
/// After so many that found none the next ones may take twice as many.
const SEARCHES_PER_DOUBLING: u32 = 8;
/// Iterations of the shortest searches where an object is put down. From most grasps there is no way, and from some it is
/// found soon: to look long from few is worse than to look shortly from many.
const PLACE_ITERATIONS: u64 = 500;

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

    /// Adds the cost of a search to the account.
    pub fn count(&mut self, statistics: &Statistics, outcome: Outcome) {
        self.spent = self.spent.with(statistics);
        self.exhausted += u32::from(outcome == Outcome::BudgetExhausted);
    }

    /// A path that solves a problem, if a search with the next budget finds one.
    pub fn search(
        &mut self,
        problem: &Problem,
        observer: &dyn Observer,
    ) -> Result<Option<Vec<Vec<f64>>>, PlanError> {
        let planner = default_planner(problem);
        let report = search(planner.as_ref(), problem, &self.next_budget(), self.seed, &mut Stop(observer))?;
        self.count(&report.statistics, report.outcome);
        Ok((report.outcome == Outcome::Solved).then_some(report.path))
    }

    /// The seed of the search of this number for one thing.
    pub fn seed_of(&self, number: u64) -> u64 {
        other_seed(self.seed, number)
    }
}

/// Passes on nothing but that the search should stop.
pub(crate) struct Stop<'a>(pub &'a dyn Observer);

impl Observer for Stop<'_> {
    fn should_stop(&self) -> bool {
        self.0.should_stop()
    }
}

/// The term of this number, from 1 on, of 1, 1, 2, 1, 1, 2, 4, 1, 1, 2, 1, 1, 2, 4, 8, …: the length, as a multiple of the
/// first, of each of many searches whose run time is unknown (Luby, Sinclair & Zuckerman 1993, §3).
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
