/// Maximum number of intervals into which a proof or a measurement divides one motion: a hundred times as many as a motion of
/// a metre at a distance of 50 µm needs. Without it, a motion of many turns, or one within a few micrometres of a body, would
/// take hours and all memory.
pub(crate) const MOST_INTERVALS: u64 = 1 << 20;

/// An interval of the motion that is not certified yet, with its pairs in doubt.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Interval {
    pub middle: f64,
    pub half_width: f64,
    /// Range of its pairs in the list of pairs.
    pub pairs: (usize, usize),
}

/// Intervals that are still to be certified.
#[derive(Clone, Debug, Default)]
pub(crate) struct WorkList {
    pub intervals: Vec<Interval>,
    pub pairs: Vec<u32>,
}

impl WorkList {
    pub fn clear(&mut self) {
        self.intervals.clear();
        self.pairs.clear();
    }

    /// Adds both halves of the interval, for the pairs from `begin` on.
    pub fn push_halves(&mut self, interval: &Interval, begin: usize) {
        if begin < self.pairs.len() {
            let (half_width, pairs) = (interval.half_width * 0.5, (begin, self.pairs.len()));
            for middle in [interval.middle - half_width, interval.middle + half_width] {
                self.intervals.push(Interval { middle, half_width, pairs });
            }
        }
    }
}
