use cranny_spatial::Stream;
use cranny_task::Problem;

use crate::search::clock::Clock;
use crate::{Budget, Observer, Outcome, PlanReport, Statistics};

/// What every search has: what it is about, its random numbers, what it has cost so far, and who watches.
pub struct Search<'a> {
    /// What it is about.
    pub problem: &'a Problem,
    /// Where all randomness comes from.
    pub random: Stream,
    /// What it has cost so far; whoever does something counts it.
    pub statistics: Statistics,
    /// Who watches.
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
    /// Why the search must end instead.
    pub(crate) fn begin_iteration(&mut self) -> Result<(), Outcome> {
        if let Some(outcome) = self.clock.verdict(self.statistics.iterations, self.observer) {
            return Err(outcome);
        }
        self.statistics.iterations += 1;
        Ok(())
    }

    /// A configuration (m, rad; one per joint) drawn uniformly from within the joint limits.
    pub fn sample(&mut self) -> Vec<f64> {
        self.problem.robot().random_configuration(&mut self.random)
    }

    /// The report of how it ended.
    pub(crate) fn report(self, ended: Result<Vec<Vec<f64>>, Outcome>) -> PlanReport {
        let planning_time_s = self.clock.elapsed_s();
        PlanReport::of(ended, Statistics { planning_time_s, ..self.statistics })
    }
}
