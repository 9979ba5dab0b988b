use crate::statistics::{Interval, KaplanMeier, Z_95, two_sided_p};

/// The mean of `min(T, horizon)`: how long a trial takes if it is given no more than the horizon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestrictedMean {
    /// What it is restricted to.
    pub horizon: f64,
    /// The mean.
    pub mean: f64,
    /// Its standard error.
    pub standard_error: f64,
}

/// By how much two restricted means differ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanDifference {
    /// The first mean minus the second.
    pub difference: f64,
    /// Where the true difference lies.
    pub interval: Interval,
    /// How probable a difference as large is if there is none; `None` where neither mean has a variance.
    pub p: Option<f64>,
}

impl KaplanMeier {
    /// The mean up to `horizon`: the area under the curve; `None` if the horizon is past the last trial while
    /// some are unsolved, since nobody knows the curve there.
    ///
    /// `μ = ∫₀^τ S`, `V = Σ over tᵢ ≤ τ of (∫ from tᵢ to τ of S)² dᵢ / (nᵢ (nᵢ − dᵢ))`. Without censoring
    /// before the horizon `μ` is the mean of `min(t, τ)` and `V` its population variance over `n`.
    ///
    /// Source: Klein & Moeschberger 2003, "Survival Analysis", eqs. (4.5.1) and (4.5.2); after Irwin 1949.
    pub fn restricted_mean(&self, horizon: f64) -> Option<RestrictedMean> {
        let ends_at_zero = self.steps().last().is_some_and(|step| step.greenwood.is_infinite());
        if self.count() == 0 || (horizon > self.last() && !ends_at_zero) {
            return None;
        }
        // From the horizon backwards: the area beyond each step.
        let steps = &self.steps()[..self.steps().partition_point(|step| step.at <= horizon)];
        let (mut area, mut variance, mut end) = (0.0, 0.0, horizon);
        for step in steps.iter().rev() {
            area += step.survival * (end - step.at);
            end = step.at;
            let (n, d) = (step.at_risk as f64, step.solved as f64);
            // Nothing lies beyond the step at which the last are solved.
            if step.solved < step.at_risk {
                variance += area * area * d / (n * (n - d));
            }
        }
        Some(RestrictedMean { horizon, mean: area + end, standard_error: variance.sqrt() })
    }
}

impl RestrictedMean {
    /// This mean minus `other`, both of independent trials and the same horizon: normal, with the variances
    /// added (Royston & Parmar 2013, "Restricted mean survival time", §2).
    ///
    /// # Panics
    /// If the horizons differ.
    pub fn minus(&self, other: &Self) -> MeanDifference {
        assert!(self.horizon.total_cmp(&other.horizon).is_eq(), "{} is not {}", self.horizon, other.horizon);
        let difference = self.mean - other.mean;
        let error = libm::hypot(self.standard_error, other.standard_error);
        let interval = Interval { low: difference - Z_95 * error, high: difference + Z_95 * error };
        MeanDifference { difference, interval, p: (error > 0.0).then(|| two_sided_p(difference / error)) }
    }
}
