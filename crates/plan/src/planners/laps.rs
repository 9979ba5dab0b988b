use crate::wall_clock::now;
use std::time::Instant;

/// Timer for the intervals of the first of every sixteen iterations: reading the clock takes a tenth of the timed work.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Laps {
    /// End of the last interval; `None` in an iteration that is not timed.
    last: Option<Instant>,
    is_timed: bool,
    timed: u64,
}

impl Laps {
    const ONE_IN: u64 = 16;

    /// Decides whether to time the iteration of this number.
    pub fn choose(&mut self, iteration: u64) {
        self.is_timed = iteration.is_multiple_of(Self::ONE_IN);
        self.timed += u64::from(self.is_timed);
    }

    /// Begins an interval.
    pub fn begin(&mut self) {
        self.last = self.is_timed.then(now);
    }

    /// Returns the duration of the interval that ends, in seconds, and begins the next one.
    pub fn lap_s(&mut self) -> f64 {
        let Some(begin) = self.last else { return 0.0 };
        let end = now();
        self.last = Some(end);
        end.duration_since(begin).as_secs_f64()
    }

    /// Returns the factor that extrapolates the measured sum to `iterations` iterations.
    pub fn share_of(&self, iterations: u64) -> f64 {
        iterations.max(1) as f64 / self.timed.max(1) as f64
    }
}
