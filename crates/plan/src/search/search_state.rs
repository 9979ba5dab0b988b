use cranny_spatial::Stream;
use cranny_task::Problem;

use crate::search::clock::Clock;
use crate::{Budget, Observer, Outcome, PlanReport, Statistics};

/// State of a search: problem, random numbers, statistics and observer.
pub struct Search<'a> {
    /// Problem to solve.
    pub problem: &'a Problem,
    /// Source of all randomness.
    pub random: Stream,
    /// Statistics up to now; every component adds its own work.
    pub statistics: Statistics,
    /// Observer of the search.
    pub observer: &'a mut dyn Observer,
    clock: Clock,
}

impl<'a> Search<'a> {
    pub(crate) fn new(
        problem: &'a Problem,
        budget: &Budget,
        seed: u64,
        observer: &'a mut dyn Observer,
    ) -> Self {
        let clock = Clock::new(budget);
        Self { problem, random: Stream::new(seed, 0), statistics: Statistics::default(), observer, clock }
    }

    /// Counts another iteration.
    ///
    /// # Errors
    /// The reason to end the search instead.
    pub(crate) fn begin_iteration(&mut self) -> Result<(), Outcome> {
        if let Some(outcome) = self.clock.verdict(self.statistics.iterations, self.observer) {
            return Err(outcome);
        }
        self.statistics.iterations += 1;
        Ok(())
    }

    /// Counts another iteration that takes milliseconds ([`Clock::verdict_now`]).
    ///
    /// # Errors
    /// The reason to end the search instead.
    pub(crate) fn begin_long_iteration(&mut self) -> Result<(), Outcome> {
        if let Some(outcome) = self.clock.verdict_now(self.statistics.iterations, self.observer) {
            return Err(outcome);
        }
        self.statistics.iterations += 1;
        Ok(())
    }

    /// Returns the rest of the budget.
    pub(crate) fn left(&self) -> Budget {
        self.clock.left(self.statistics.iterations)
    }

    /// Returns a configuration (m, rad; one per joint) drawn uniformly within the joint limits.
    pub fn sample(&mut self) -> Vec<f64> {
        self.problem.robot().random_configuration(&mut self.random)
    }

    /// Returns a configuration (m, rad; one per joint) drawn uniformly within the joint limits from the box about `q` of which
    /// no joint is farther than `half_width`.
    pub(crate) fn sample_near(&mut self, q: &[f64], half_width: f64) -> Vec<f64> {
        let limits = self.problem.robot().limits().iter().zip(q);
        let ranges = limits.map(|(limits, value)| {
            [limits.lower.max(value - half_width), limits.upper.min(value + half_width)]
        });
        ranges.map(|[low, high]| self.random.uniform_between(low, high)).collect()
    }

    pub(crate) fn report(self, ended: Result<Vec<Vec<f64>>, Outcome>) -> PlanReport {
        let planning_time_s = self.clock.elapsed_s();
        PlanReport::of(ended, Statistics { planning_time_s, ..self.statistics })
    }
}
