use std::time::Instant;

use crate::wall_clock::now;
use crate::{Budget, Observer, Outcome};

/// Tells a search when to end: the only clock that a planner has.
#[derive(Debug)]
pub struct Clock {
    begin: Instant,
    deadline: Option<Instant>,
    iterations: u64,
    calls: u64,
}

impl Clock {
    /// Starts now.
    pub fn new(budget: &Budget) -> Self {
        let begin = now();
        Self { begin, deadline: begin.checked_add(budget.time), iterations: budget.iterations, calls: 0 }
    }

    /// Seconds since it was made.
    pub fn elapsed_s(&self) -> f64 {
        self.begin.elapsed().as_secs_f64()
    }

    /// Why the search must end after `iterations`, if it must. To be asked once an iteration: it tells the observer how far
    /// the search is, and looks at the time once in sixteen calls.
    pub fn verdict(&mut self, iterations: u64, observer: &mut dyn Observer) -> Option<Outcome> {
        if iterations >= self.iterations {
            return Some(Outcome::BudgetExhausted);
        }
        /// Looking at the clock costs as much as a distance; one look in so many calls is enough.
        const LOOK_EVERY: u64 = 16;
        self.calls += 1;
        if !self.calls.is_multiple_of(LOOK_EVERY) {
            return None;
        }
        observer.progress(iterations);
        if observer.should_stop() {
            return Some(Outcome::Cancelled);
        }
        self.deadline.filter(|deadline| now() >= *deadline).map(|_| Outcome::BudgetExhausted)
    }
}
