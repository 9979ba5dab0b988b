use crate::statistics::kaplan_meier::{ROUNDED, band};
use crate::statistics::{Interval, KaplanMeier};

/// Mean of the Kaplan–Meier estimates of several groups of trials, in which each group counts the same, however many trials it
/// has.
///
/// With `k` groups `S̄(t) = Σ Sⱼ(t)/k`, of variance `Σ Var Sⱼ(t)/k²` by Greenwood; the band is symmetric in `log(−log S̄)`, as
/// for one group. After the last trial of a group its estimate stays as it is. Of one group it is the estimate itself.
///
/// Source: Nieto & Coresh 1996, "Adjusting survival curves for confounders: a review and a new method", whole, with equal weights.
#[derive(Clone, Debug, PartialEq)]
pub struct MeanSurvival {
    steps: Vec<MeanStep>,
    last: f64,
}

/// Jump of a mean survival curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanStep {
    /// The time.
    pub at: f64,
    /// Mean share of unsolved trials from this time on.
    pub survival: f64,
    /// Confidence band of the true mean.
    pub band: Interval,
}

impl MeanSurvival {
    /// Computes the mean of the curves of `groups`.
    pub fn of(groups: &[KaplanMeier]) -> Self {
        let mut jumps: Vec<(f64, usize, f64, f64)> = Vec::new();
        for (group, curve) in groups.iter().enumerate() {
            // Where all trials of a group are solved, its estimate has no variance.
            let variance = |survival: f64, greenwood: f64| {
                if greenwood.is_finite() { survival * survival * greenwood } else { 0.0 }
            };
            let jump = |step: &crate::statistics::SurvivalStep| {
                (step.at, group, step.survival, variance(step.survival, step.greenwood))
            };
            jumps.extend(curve.steps().iter().map(jump));
        }
        jumps.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let count = groups.len() as f64;
        let mut now = vec![(1.0, 0.0); groups.len()];
        let (mut sum, mut variance, mut unsolved) = (count, 0.0_f64, groups.len());
        let mut steps: Vec<MeanStep> = Vec::new();
        for same in jumps.chunk_by(|a, b| a.0.total_cmp(&b.0).is_eq()) {
            for &(_, group, survival, own_variance) in same {
                let before = std::mem::replace(&mut now[group], (survival, own_variance));
                sum += survival - before.0;
                variance += own_variance - before.1;
                unsolved -= usize::from(survival <= 0.0);
            }
            // Exactly zero where every trial of every group is solved, without the rounding of the sums.
            let survival = if unsolved == 0 { 0.0 } else { (sum / count).clamp(0.0, 1.0) };
            let relative = variance.max(0.0) / (count * count * survival * survival);
            let greenwood = if unsolved == 0 { f64::INFINITY } else { relative };
            let band = band(survival, greenwood, steps.last().map(|step| step.band));
            steps.push(MeanStep { at: same[0].0, survival, band });
        }
        Self { steps, last: groups.iter().map(KaplanMeier::last).fold(0.0, f64::max) }
    }

    /// Returns the jumps of the curve, in order of time.
    pub fn steps(&self) -> &[MeanStep] {
        &self.steps
    }

    /// Returns the longest follow-up; 0 without trials.
    pub fn last(&self) -> f64 {
        self.last
    }

    /// Returns the median time, the least `t` with `S̄(t) ≤ ½`; `None` if it was not observed.
    pub fn median(&self) -> Option<f64> {
        self.first(|step| step.survival)
    }

    /// Returns the interval of the median time: the times at which the band contains ½. An end that was not observed is `None`.
    ///
    /// Source: Brookmeyer & Crowley 1982, "A confidence interval for the median survival time", whole.
    pub fn median_interval(&self) -> (Option<f64>, Option<f64>) {
        (self.first(|step| step.band.low), self.first(|step| step.band.high))
    }

    fn first(&self, share: impl Fn(&MeanStep) -> f64) -> Option<f64> {
        self.steps.iter().find(|step| share(step) <= 0.5 + ROUNDED).map(|step| step.at)
    }
}
