use crate::statistics::KaplanMeier;

/// Restricted mean of `min(T, horizon)`: the mean time of a trial with the horizon as its limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestrictedMean {
    /// Horizon of the mean.
    pub horizon: f64,
    /// The mean.
    pub mean: f64,
    /// Standard error of the mean; `None` if no time varies, as for a single trial.
    pub standard_error: Option<f64>,
}

impl KaplanMeier {
    /// Computes the mean up to `horizon`, the area under the curve; `None` if the curve is unknown there: the horizon is past
    /// the last trial while some are unsolved.
    ///
    /// `μ = ∫₀^τ S`, `V = Σ over tᵢ ≤ τ of (∫ from tᵢ to τ of S)² dᵢ / (nᵢ (nᵢ − dᵢ))`. Without censoring before the
    /// horizon `μ` is the mean of `min(t, τ)` and `V` its population variance over `n`.
    ///
    /// Source: Klein & Moeschberger 2003, "Survival Analysis", eqs. (4.5.1) and (4.5.2); after Irwin 1949, "The standard
    /// error of an estimate of expectation of life", whole.
    pub fn restricted_mean(&self, horizon: f64) -> Option<RestrictedMean> {
        let ends_at_zero = self.steps().last().is_some_and(|step| step.greenwood.is_infinite());
        if self.count() == 0 || (horizon > self.last() && !ends_at_zero) {
            return None;
        }
        let (mean, variance) = self.area_and_variance(horizon);
        Some(RestrictedMean { horizon, mean, standard_error: (variance > 0.0).then(|| variance.sqrt()) })
    }

    /// Returns the area under the curve up to `horizon`; the curve is constant after the last trial.
    pub(super) fn area(&self, horizon: f64) -> f64 {
        self.area_and_variance(horizon).0
    }

    fn area_and_variance(&self, horizon: f64) -> (f64, f64) {
        // The sum runs backwards from the horizon, over the area beyond each jump.
        let steps = &self.steps()[..self.steps().partition_point(|step| step.at <= horizon)];
        let (mut area, mut variance, mut end) = (0.0, 0.0, horizon);
        for step in steps.iter().rev() {
            area += step.survival * (end - step.at);
            end = step.at;
            let (n, d) = (step.at_risk as f64, step.solved as f64);
            // No area lies beyond the jump at which the last trials are solved.
            if step.solved < step.at_risk {
                variance += area * area * d / (n * (n - d));
            }
        }
        (area + end, variance)
    }
}
