use crate::statistics::{Interval, Z_95};

/// Follow-up of one trial, in seconds or in iterations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Followed {
    /// End of the follow-up; not negative.
    pub until: f64,
    /// True if the trial was solved at that time; otherwise it is censored there.
    pub solved: bool,
}

impl Followed {
    /// Returns this follow-up cut off at `limit`.
    #[must_use]
    pub fn up_to(self, limit: f64) -> Self {
        Self { until: self.until.min(limit), solved: self.solved && self.until <= limit }
    }
}

/// Jump of a survival curve at a time when trials were solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurvivalStep {
    /// The time.
    pub at: f64,
    /// Number of trials neither solved nor censored before.
    pub at_risk: usize,
    /// Number of trials solved at that time.
    pub solved: usize,
    /// Share of unsolved trials from this time on.
    pub survival: f64,
    /// Greenwood's variance of `survival` over its square, `Σ dᵢ / (nᵢ (nᵢ − dᵢ))` up to here; infinite once all are solved.
    pub greenwood: f64,
    /// Confidence band of the true share.
    pub band: Interval,
}

/// Kaplan–Meier estimate of the share of unsolved trials at each time, from possibly censored trials.
///
/// `S(t) = Π over tᵢ ≤ t of (1 − dᵢ/nᵢ)`, with `dᵢ` solved at `tᵢ` and `nᵢ` at risk just before; trials censored at `tᵢ`
/// are still at risk there. Without censoring this is the share of times above `t`.
///
/// Source: Kaplan & Meier 1958, "Nonparametric estimation from incomplete observations", eq. (2b); variance from Greenwood
/// 1926, "The natural duration of cancer", whole; band symmetric in `log(−log S)`, so that it stays within 0 and 1:
/// Kalbfleisch & Prentice 2002, "The Statistical Analysis of Failure Time Data", §1.4.1.
#[derive(Clone, Debug, PartialEq)]
pub struct KaplanMeier {
    steps: Vec<SurvivalStep>,
    count: usize,
    last: f64,
}

/// Tolerance of shares: products of exact fractions miss a half by a few units in the last digit.
pub(super) const ROUNDED: f64 = 1e-12;

impl KaplanMeier {
    /// Estimates the curve from `trials`.
    ///
    /// # Panics
    /// If a time is negative or not finite.
    pub fn of(trials: &[Followed]) -> Self {
        assert!(
            trials.iter().all(|trial| trial.until.is_finite() && trial.until >= 0.0),
            "times are finite and not negative"
        );
        let mut sorted = trials.to_vec();
        sorted.sort_by(|a, b| a.until.total_cmp(&b.until));
        let mut steps: Vec<SurvivalStep> = Vec::new();
        let (mut survival, mut greenwood, mut before) = (1.0, 0.0, 0);
        for same in sorted.chunk_by(|a, b| a.until.total_cmp(&b.until).is_eq()) {
            let at_risk = sorted.len() - before;
            before += same.len();
            let solved = same.iter().filter(|trial| trial.solved).count();
            if solved == 0 {
                continue;
            }
            let (n, d) = (at_risk as f64, solved as f64);
            survival *= 1.0 - d / n;
            greenwood += d / (n * (n - d));
            let band = band(survival, greenwood, steps.last().map(|step| step.band));
            steps.push(SurvivalStep { at: same[0].until, at_risk, solved, survival, greenwood, band });
        }
        Self { steps, count: sorted.len(), last: sorted.last().map_or(0.0, |trial| trial.until) }
    }

    /// Returns the jumps of the curve, in order of time.
    pub fn steps(&self) -> &[SurvivalStep] {
        &self.steps
    }

    /// Returns the number of trials.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Returns the longest follow-up; 0 without trials.
    pub fn last(&self) -> f64 {
        self.last
    }

    /// Returns the share of trials not solved at `time` or before.
    pub fn survival_at(&self, time: f64) -> f64 {
        let steps = self.steps.partition_point(|step| step.at <= time);
        if steps == 0 { 1.0 } else { self.steps[steps - 1].survival }
    }

    /// Returns the median time, the least `t` with `S(t) ≤ ½`; `None` if it was not observed.
    pub fn median(&self) -> Option<f64> {
        self.quantile(0.5)
    }

    /// Returns the time at which a `share` of the trials is solved, the least `t` with `1 − S(t) ≥ share`; `None` if it was
    /// not observed. Without censoring it is the least time that this share of the times do not exceed.
    pub fn quantile(&self, share: f64) -> Option<f64> {
        self.steps.iter().find(|step| step.survival <= 1.0 - share + ROUNDED).map(|step| step.at)
    }
}

/// Computes the band `S^exp(±z √greenwood / |ln S|)`. Once all trials are solved, the variance is undefined, though a further
/// trial might take longer: the upper end keeps its last value.
fn band(survival: f64, greenwood: f64, before: Option<Interval>) -> Interval {
    if greenwood.is_infinite() {
        return Interval { low: 0.0, high: before.map_or(1.0, |band| band.high) };
    }
    let reach = Z_95 * greenwood.sqrt() / libm::log(survival).abs();
    let end = |sign: f64| libm::pow(survival, libm::exp(sign * reach));
    Interval { low: end(1.0), high: end(-1.0) }
}
