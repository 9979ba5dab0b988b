/// Range of distances that a query must resolve.
#[derive(Clone, Copy, Debug)]
pub struct Range {
    /// Distance beyond which the search may stop, in metres; `upper_m` may then be infinite.
    pub beyond_m: f64,
    /// Distance above which values up to `beyond_m`, in metres, need not be exact; infinite: all must be.
    pub exact_below_m: f64,
}

impl Range {
    /// Range of all distances up to `beyond_m`, in metres.
    pub fn to(beyond_m: f64) -> Self {
        Self { beyond_m, exact_below_m: f64::INFINITY }
    }

    /// Reach of a search that has found an upper bound of the distance, in metres.
    #[must_use]
    pub fn reach_m(&self, upper_m: f64) -> f64 {
        if upper_m < self.beyond_m { upper_m.min(self.exact_below_m) } else { self.beyond_m }
    }

    /// Returns the range for the cores of solids whose rounding shortens the distance by `by_m`, in metres.
    pub(crate) fn grown(self, by_m: f64) -> Self {
        Self { beyond_m: self.beyond_m + by_m, exact_below_m: self.exact_below_m + by_m }
    }
}
