/// Distances that matter.
#[derive(Clone, Copy, Debug)]
pub struct Range {
    /// The search may stop as soon as the distance is known to exceed this, in metres; then `upper_m` may be infinite.
    pub beyond_m: f64,
    /// Distances between this and `beyond_m`, in metres, need not be measured; infinite: all are.
    pub exact_below_m: f64,
}

impl Range {
    /// All distances up to `beyond_m`, in metres.
    pub fn to(beyond_m: f64) -> Self {
        Self { beyond_m, exact_below_m: f64::INFINITY }
    }

    /// Reach of a search that has found an upper bound of the distance, in metres.
    #[must_use]
    pub fn reach_m(&self, upper_m: f64) -> f64 {
        if upper_m < self.beyond_m { upper_m.min(self.exact_below_m) } else { self.beyond_m }
    }

    /// The same for bodies whose distance is less by `by_m`, in metres.
    pub(crate) fn grown(self, by_m: f64) -> Self {
        Self { beyond_m: self.beyond_m + by_m, exact_below_m: self.exact_below_m + by_m }
    }
}
