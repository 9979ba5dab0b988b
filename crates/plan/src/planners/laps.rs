use crate::wall_clock::now;
use std::time::Instant;

/// Seconds of the pieces of one iteration in so many, the first included: to look at the clock takes a tenth of what is
/// timed.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Laps {
    /// When the last piece ended; nothing in an iteration that is not timed.
    last: Option<Instant>,
    is_timed: bool,
    timed: u64,
}

impl Laps {
    const ONE_IN: u64 = 16;

    /// Before the iteration of this number.
    pub fn choose(&mut self, iteration: u64) {
        self.is_timed = iteration.is_multiple_of(Self::ONE_IN);
        self.timed += u64::from(self.is_timed);
    }

    /// A piece begins.
    pub fn begin(&mut self) {
        self.last = self.is_timed.then(now);
    }

    /// Seconds of the piece that ends, and the next one begins.
    pub fn lap_s(&mut self) -> f64 {
        let Some(begin) = self.last else { return 0.0 };
        let end = now();
        self.last = Some(end);
        end.duration_since(begin).as_secs_f64()
    }

    /// By what the sum of all is to be multiplied for so many iterations.
    pub fn share_of(&self, iterations: u64) -> f64 {
        iterations.max(1) as f64 / self.timed.max(1) as f64
    }
}
