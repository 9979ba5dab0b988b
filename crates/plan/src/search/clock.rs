use std::time::{Duration, Instant};

use crate::wall_clock::now;
use crate::{Budget, Observer, Outcome};

/// Clock that ends a search: the only clock of a planner.
#[derive(Debug)]
pub struct Clock {
    begin: Instant,
    deadline: Option<Instant>,
    iterations: u64,
    calls: u64,
}

impl Clock {
    /// Starts a clock now.
    pub fn new(budget: &Budget) -> Self {
        let begin = now();
        Self { begin, deadline: begin.checked_add(budget.time), iterations: budget.iterations, calls: 0 }
    }

    /// Returns the seconds since it was started.
    pub fn elapsed_s(&self) -> f64 {
        self.begin.elapsed().as_secs_f64()
    }

    /// Returns the rest of the budget after `iterations`.
    pub(crate) fn left(&self, iterations: u64) -> Budget {
        let time = self.deadline.map_or(Duration::MAX, |deadline| deadline.saturating_duration_since(now()));
        Budget { iterations: self.iterations.saturating_sub(iterations), time }
    }

    /// Returns the reason to end the search after `iterations`, if there is one. It must be called once per iteration: it
    /// reports progress to the observer and reads the time in one of sixteen calls.
    pub fn verdict(&mut self, iterations: u64, observer: &mut dyn Observer) -> Option<Outcome> {
        if iterations >= self.iterations {
            return Some(Outcome::BudgetExhausted);
        }
        /// Number of calls per clock reading, since a reading costs as much as a distance.
        const LOOK_EVERY: u64 = 16;
        self.calls += 1;
        if !self.calls.is_multiple_of(LOOK_EVERY) {
            return None;
        }
        self.verdict_now(iterations, observer)
    }

    /// Returns the reason to end the search after `iterations`, if there is one, as [`Self::verdict`] does, for iterations that
    /// take milliseconds: it reads the time in each call.
    pub(crate) fn verdict_now(&self, iterations: u64, observer: &mut dyn Observer) -> Option<Outcome> {
        if iterations >= self.iterations {
            return Some(Outcome::BudgetExhausted);
        }
        observer.progress(iterations);
        if observer.should_stop() {
            return Some(Outcome::Cancelled);
        }
        self.deadline.filter(|deadline| now() >= *deadline).map(|_| Outcome::BudgetExhausted)
    }
}
