use crate::statistics::kaplan_meier::{ROUNDED, SurvivalStep};
use crate::statistics::wilson::wilson_of_share;
use crate::statistics::{Interval, KaplanMeier};

/// Mean of the Kaplan–Meier estimates of several groups of trials, in which each group counts the same, however many trials it
/// has.
///
/// With `k` groups `S̄(t) = Σ Sⱼ(t)/k`, from `S̄ − √Σ(Sⱼ − lⱼ)²/k` to `S̄ + √Σ(uⱼ − Sⱼ)²/k` with the Wilson interval `[lⱼ, uⱼ]` of
/// a rate `Sⱼ` of `Sⱼ(1 − Sⱼ)/Var Sⱼ` trials, the variance by Greenwood: without censoring these are all trials, and all of
/// them where `Sⱼ` is 0 or 1. So a group of which every trial, or none, is solved does not count as certain. Both ends of the band fall with time.
/// After the last trial of a group its estimate stays as it is. Of one group it is the estimate itself, with its own band.
///
/// Source: Nieto & Coresh 1996, "Adjusting survival curves for confounders: a review and a new method", whole, with equal
/// weights; Zou, Huang & Zhang 2009, "A note on confidence interval estimation for a linear function of binomial proportions",
/// whole.
#[derive(Clone, Debug, PartialEq)]
pub struct MeanSurvival {
    steps: Vec<MeanStep>,
    last: f64,
}

/// Estimate of one group at a time.
#[derive(Clone, Copy, Debug)]
struct Estimate {
    survival: f64,
    interval: Interval,
}

impl Estimate {
    fn of(step: &SurvivalStep, count: usize) -> Self {
        let SurvivalStep { survival, greenwood, .. } = *step;
        // The variance is that of the estimate over its square.
        let trials = if survival > 0.0 { (1.0 - survival) / (survival * greenwood) } else { count as f64 };
        Self::of_share(survival, trials)
    }

    fn of_share(survival: f64, trials: f64) -> Self {
        Self { survival, interval: wilson_of_share(survival, trials) }
    }
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
        let last = groups.iter().map(KaplanMeier::last).fold(0.0, f64::max);
        if let [only] = groups {
            let own =
                |step: &SurvivalStep| MeanStep { at: step.at, survival: step.survival, band: step.band };
            return Self { steps: only.steps().iter().map(own).collect(), last };
        }
        let with_group = |(group, curve): (usize, &KaplanMeier)| {
            let steps = curve
                .steps()
                .iter()
                .map(move |step| (step.at, group, Estimate::of(step, groups[group].count())));
            steps.collect::<Vec<_>>()
        };
        let mut jumps: Vec<(f64, usize, Estimate)> = groups.iter().enumerate().flat_map(with_group).collect();
        jumps.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let count = groups.len() as f64;
        let mut now: Vec<Estimate> =
            groups.iter().map(|curve| Estimate::of_share(1.0, curve.count() as f64)).collect();
        let mut steps: Vec<MeanStep> = Vec::new();
        for same in jumps.chunk_by(|a, b| a.0.total_cmp(&b.0).is_eq()) {
            for &(_, group, estimate) in same {
                now[group] = estimate;
            }
            let sum = |term: &dyn Fn(&Estimate) -> f64| now.iter().map(term).sum::<f64>();
            let survival = sum(&|own| own.survival) / count;
            let below = sum(&|own| (own.survival - own.interval.low).powi(2)).sqrt() / count;
            let above = sum(&|own| (own.interval.high - own.survival).powi(2)).sqrt() / count;
            let before = steps.last().map_or(Interval { low: 1.0, high: 1.0 }, |step| step.band);
            let band = Interval {
                low: (survival - below).max(0.0).min(before.low),
                high: (survival + above).min(before.high),
            };
            steps.push(MeanStep { at: same[0].0, survival, band });
        }
        Self { steps, last }
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
