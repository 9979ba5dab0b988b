use crate::statistics::division::{division_count, draws_for, for_each_division};
use crate::statistics::{Followed, Interval, KaplanMeier, LEVEL, SurvivalStep};

/// Permutation tests for a difference between two groups of trials; their p-values are valid for every number of trials.
///
/// If the groups are of one planner, each division of all trials into groups of these sizes is equally probable. A p-value
/// is twice the share of divisions whose statistic is at least as extreme, to the same side, as the observed one: over all
/// divisions of small groups, or random ones of larger groups.
///
/// Source: Lehmann & Romano 2005, "Testing Statistical Hypotheses", §15.2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoSampleTest {
    /// p-value of `O − E`, the numerator of the log-rank test.
    pub log_rank_p: f64,
    /// Excess `O − E`: positive if the first group is solved at the faster pace.
    pub log_rank_excess: f64,
    /// Restricted mean of the first group minus that of the second.
    pub difference: f64,
    /// Interval of that difference: the values that the studentised test does not reject at the given level. `None` if the
    /// trials do not vary, or not enough to bound it.
    pub interval: Option<Interval>,
    /// p-value of the studentised difference for the hypothesis of no difference.
    pub difference_p: f64,
}

/// Returns the least possible p-value of a test of groups of these sizes: `2/C(n, n₁)`. At least 1 if a group has fewer
/// than two trials, because one time has no spread.
pub fn least_p(first: usize, second: usize) -> f64 {
    if first.min(second) < 2 { 1.0 } else { 2.0 / division_count(first, second) }
}

impl TwoSampleTest {
    /// Tests two groups up to `horizon`, in a family of `tests`. The interval is of level `0.05/tests`, so that all intervals
    /// of the family are valid together.
    ///
    /// The log-rank scores are `cᵢ = δᵢ − Λ(tᵢ)` with the Nelson–Aalen estimate `Λ` of all trials: `O − E = Σ cᵢ` over the
    /// first group. The studentised difference is Welch's `t` of restricted times (their pseudo-values), for which the
    /// permutation test stays valid asymptotically if the spreads differ.
    ///
    /// # Panics
    /// If a group is empty, or a time is negative or not finite.
    ///
    /// Groups of more than 1000 trials exchange blocks of successive trials. These permutations form a group as well, so the
    /// p-values stay valid.
    ///
    /// Source: Peto & Peto 1972, "Asymptotically efficient rank invariant test procedures", §5; Janssen 1997, "Studentized
    /// permutation tests for non-i.i.d. hypotheses and the generalized Behrens–Fisher problem", whole.
    pub fn of(first: &[Followed], second: &[Followed], horizon: f64, tests: usize) -> Self {
        let all: Vec<Followed> = first.iter().chain(second).copied().collect();
        let scores = log_rank_scores(&all);
        let times = restricted_times(&all, horizon);
        let welch = Welch::of(&times);
        let blocks = Blocks::of(&scores, &welch.sums_of(&times), first.len());
        let (mut excesses, mut differences) = (Vec::new(), Vec::new());
        let [drawn, others] = blocks.counts;
        for_each_division(drawn, others, draws_for(tests), |members| {
            let group = blocks.group(members);
            excesses.push(group.score);
            differences.push(welch.difference(&group));
        });
        let observed = differences[0];
        let ratios: Vec<f64> = differences.iter().map(Difference::ratio).collect();
        Self {
            log_rank_p: p_of_first(&excesses),
            log_rank_excess: excesses[0],
            difference: observed.difference,
            difference_p: p_of_first(&ratios),
            interval: observed.interval(ratios, LEVEL / tests as f64),
        }
    }
}

/// Relative tolerance within which two values count as equal: sums in another order differ by rounding.
const ROUNDED: f64 = 1e-9;

/// Returns the two-sided p-value of the first of the values of a statistic over all divisions.
fn p_of_first(values: &[f64]) -> f64 {
    let slack = ROUNDED * values[0].abs().clamp(1.0, f64::MAX);
    let above = values.iter().filter(|&&value| value >= values[0] - slack).count();
    let below = values.iter().filter(|&&value| value <= values[0] + slack).count();
    (2.0 * above.min(below) as f64 / values.len() as f64).min(1.0)
}

fn log_rank_scores(all: &[Followed]) -> Vec<f64> {
    let curve = KaplanMeier::of(all);
    // The hazard up to each jump, summed once for all trials.
    let hazards: Vec<f64> = curve
        .steps()
        .iter()
        .scan(0.0, |sum, step| {
            *sum += step.solved as f64 / step.at_risk as f64;
            Some(*sum)
        })
        .collect();
    let hazard = |until: f64| match curve.steps().partition_point(|step| step.at <= until) {
        0 => 0.0,
        steps => hazards[steps - 1],
    };
    all.iter().map(|trial| f64::from(u8::from(trial.solved)) - hazard(trial.until)).collect()
}

/// Returns `min(T, horizon)` of each trial; for trials censored before the horizon the pseudo-values `n μ − (n − 1) μ₍₋ᵢ₎`,
/// with the restricted mean `μ` of all and of all but one.
///
/// Source: Andersen, Hansen & Klein 2004, "Regression analysis of restricted mean survival time based on
/// pseudo-observations", §2.
fn restricted_times(all: &[Followed], horizon: f64) -> Vec<f64> {
    if all.iter().all(|trial| trial.solved || trial.until >= horizon) {
        return all.iter().map(|trial| trial.until.min(horizon)).collect();
    }
    let (n, curve) = (all.len() as f64, KaplanMeier::of(all));
    let (mean, without) = (curve.area(horizon), AreaWithout::of(&curve, horizon));
    all.iter().map(|trial| n * mean - (n - 1.0) * without.trial(*trial)).collect()
}

/// Areas under the Kaplan–Meier curves of all trials but one, up to a horizon, each in logarithmic time.
///
/// Without a trial followed to `u`, one trial fewer is at risk up to `u`; the factors `1 − dᵢ/nᵢ` after `u` are the same.
struct AreaWithout<'a> {
    steps: &'a [SurvivalStep],
    horizon: f64,
    /// For each number of jumps, the last of them, the survival after it, and the area up to it, of all trials.
    of_all: Vec<[f64; 3]>,
    /// The same with one trial fewer at risk.
    of_fewer: Vec<[f64; 3]>,
    /// Area up to the horizon, of all trials.
    area: f64,
}

impl<'a> AreaWithout<'a> {
    fn of(curve: &'a KaplanMeier, horizon: f64) -> Self {
        let steps = curve.steps();
        let summed = |factor: &dyn Fn(&SurvivalStep) -> f64| {
            let mut sums = vec![[0.0, 1.0, 0.0]];
            for (before, step) in steps.iter().enumerate() {
                let [at, survival, area] = sums[before];
                sums.push([step.at, survival * factor(step), area + survival * (step.at - at)]);
            }
            sums
        };
        let of_all = summed(&|step| 1.0 - step.solved as f64 / step.at_risk as f64);
        // Where a single trial was at risk, no trial comes later that would need the value.
        let of_fewer = summed(&|step| 1.0 - step.solved as f64 / (step.at_risk - 1).max(1) as f64);
        Self { steps, horizon, of_all, of_fewer, area: curve.area(horizon) }
    }

    /// Returns the area without one of the trials.
    fn trial(&self, trial: Followed) -> f64 {
        let until = trial.until.min(self.horizon);
        let before = self.steps.partition_point(|step| step.at < until);
        let [at, fewer, area] = self.of_fewer[before];
        let area_before = area + fewer * (until - at);
        if trial.until >= self.horizon {
            return area_before;
        }
        let [at, mut survival, area] = self.of_all[before];
        let area_after = self.area - (area + survival * (until - at));
        let mut factor = 1.0;
        if let Some(step) = self.steps.get(before).filter(|step| step.at <= until) {
            survival = self.of_all[before + 1][1];
            let (others, solved) = (step.at_risk - 1, step.solved - usize::from(trial.solved));
            factor = if others == 0 { 1.0 } else { 1.0 - solved as f64 / others as f64 };
        }
        // After a curve has reached zero it has no jumps.
        let scale = if survival > 0.0 { area_after / survival } else { self.horizon - until };
        area_before + fewer * factor * scale
    }
}

/// Maximum number of blocks of the smaller group.
const MOST_BLOCKS: usize = 1000;

/// Blocks of successive trials of one group, all of the same size, which change groups together. A rest of fewer trials than a
/// block stays in its group.
struct Blocks {
    /// Blocks of the group that is drawn, then those of the other one.
    sums: Vec<Sums>,
    counts: [usize; 2],
    /// Rest of the group that is drawn.
    rest: Sums,
    /// Sums over all trials, if the second group is drawn: the smaller one of large groups.
    whole: Option<Sums>,
}

/// Sums over trials: their log-rank scores, their times relative to the first time of all, and the squares of these.
#[derive(Clone, Copy, Default)]
struct Sums {
    count: usize,
    score: f64,
    time: f64,
    square: f64,
}

impl Sums {
    fn with(self, other: &Self) -> Self {
        Self {
            count: self.count + other.count,
            score: self.score + other.score,
            time: self.time + other.time,
            square: self.square + other.square,
        }
    }

    fn without(self, other: &Self) -> Self {
        Self {
            count: self.count - other.count,
            score: self.score - other.score,
            time: self.time - other.time,
            square: self.square - other.square,
        }
    }
}

impl Blocks {
    /// Divides trials, of which the first `first` are the first group.
    fn of(scores: &[f64], times: &[[f64; 2]], first: usize) -> Self {
        let trials: Vec<Sums> = scores
            .iter()
            .zip(times)
            .map(|(&score, &[time, square])| Sums { count: 1, score, time, square })
            .collect();
        let (first, second) = trials.split_at(first);
        let size = first.len().min(second.len()).div_ceil(MOST_BLOCKS).max(1);
        let total = |trials: &[Sums]| trials.iter().fold(Sums::default(), Sums::with);
        let whole = (size > 1 && first.len() > second.len()).then(|| total(&trials));
        let groups = if whole.is_some() { [second, first] } else { [first, second] };
        let blocks = groups.map(|group| group.chunks_exact(size));
        let counts = blocks.each_ref().map(ExactSizeIterator::len);
        let rest = total(blocks[0].remainder());
        Self { sums: blocks.into_iter().flatten().map(total).collect(), counts, rest, whole }
    }

    /// Sums of the first group if the drawn one consists of these blocks.
    fn group(&self, members: &[usize]) -> Sums {
        let drawn = members.iter().map(|&block| &self.sums[block]).fold(self.rest, Sums::with);
        self.whole.map_or(drawn, |whole| whole.without(&drawn))
    }
}

/// Sums over all times for Welch's `t` of any division, relative to the first time, so that equal times have no variance.
struct Welch {
    about: f64,
    sum: f64,
    squares: f64,
    count: usize,
}

/// Difference of means with its standard error.
#[derive(Clone, Copy)]
struct Difference {
    difference: f64,
    error: f64,
}

impl Welch {
    /// Computes the sums; `times` must not be empty.
    fn of(times: &[f64]) -> Self {
        let about = times[0];
        let sum = times.iter().map(|time| time - about).sum();
        let squares = times.iter().map(|time| (time - about) * (time - about)).sum();
        Self { about, sum, squares, count: times.len() }
    }

    /// Returns each time relative to the first, and its square.
    fn sums_of(&self, times: &[f64]) -> Vec<[f64; 2]> {
        times.iter().map(|time| time - self.about).map(|time| [time, time * time]).collect()
    }

    /// Returns the difference between a group and the others.
    fn difference(&self, group: &Sums) -> Difference {
        let Sums { count, time, square, .. } = *group;
        let (first, second) = (count as f64, (self.count - count) as f64);
        let variance = self.variance_of_mean(time, square, first)
            + self.variance_of_mean(self.sum - time, self.squares - square, second);
        Difference { difference: time / first - (self.sum - time) / second, error: variance.sqrt() }
    }

    fn variance_of_mean(&self, sum: f64, squares: f64, count: f64) -> f64 {
        let about_mean = squares - sum * sum / count;
        // Equal values get a variance of exactly zero, without rounding errors.
        if about_mean <= ROUNDED * self.squares { 0.0 } else { about_mean / (count * (count - 1.0)) }
    }
}

impl Difference {
    /// Returns difference over error; infinite if nothing varies but the groups differ.
    fn ratio(&self) -> f64 {
        match self.error {
            0.0 if self.difference.abs() <= f64::MIN_POSITIVE => 0.0,
            error => self.difference / error,
        }
    }

    /// Returns the differences that are not rejected at `level` on either side, by the `ratios` of all divisions.
    fn interval(&self, mut ratios: Vec<f64>, level: f64) -> Option<Interval> {
        ratios.sort_by(f64::total_cmp);
        // This number of ratios may lie beyond each end.
        let beyond = (level / 2.0 * ratios.len() as f64).ceil() - 1.0;
        if beyond < 1.0 || self.error == 0.0 {
            return None;
        }
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a small count, at least 1"
        )]
        let beyond = beyond as usize;
        let (least, greatest) = (ratios[beyond], ratios[ratios.len() - 1 - beyond]);
        let (low, high) = (self.difference - greatest * self.error, self.difference - least * self.error);
        (low.is_finite() && high.is_finite()).then_some(Interval { low, high })
    }
}

#[cfg(test)]
mod tests {
    use cranny_spatial::Stream;

    use super::*;

    #[test]
    fn the_area_without_a_trial_is_that_of_the_others() {
        let mut random = Stream::new(3, 0);
        for count in 2..40 {
            // Times in whole seconds have ties, also of solved and censored trials, and with the horizon.
            let draw = |random: &mut Stream| Followed {
                until: random.index(12) as f64,
                solved: random.index(3) > 0,
            };
            let all: Vec<Followed> = (0..count).map(|_| draw(&mut random)).collect();
            let curve = KaplanMeier::of(&all);
            for horizon in [0.0, 5.0, 9.0, 20.0] {
                let without = AreaWithout::of(&curve, horizon);
                for (index, trial) in all.iter().enumerate() {
                    let others = KaplanMeier::of(&[&all[..index], &all[index + 1..]].concat());
                    let (area, expected) = (without.trial(*trial), others.area(horizon));
                    assert!(
                        (area - expected).abs() < 1e-9,
                        "{all:?}, without {index}: {area}, not {expected}"
                    );
                }
            }
        }
    }

    /// Whole groups of 100 000 trials are compared by sums over blocks; equal planners differ no more often than by chance.
    #[test]
    fn large_groups_exchange_blocks_and_keep_their_level() {
        let mut random = Stream::new(5, 0);
        let mut draw = |count: usize, mean: f64| -> Vec<Followed> {
            let trial = |_| Followed { until: mean * random.uniform(), solved: true };
            (0..count).map(trial).collect()
        };
        let mut small_p = 0;
        for _ in 0..8 {
            let test = TwoSampleTest::of(&draw(1100, 1.0), &draw(1333, 1.0), 1.0, 1);
            small_p += u32::from(test.difference_p < 0.05);
        }
        assert!(small_p <= 3, "{small_p} of 8 below 5 %");
        let test = TwoSampleTest::of(&draw(100_000, 1.0), &draw(100_001, 1.02), 2.0, 1);
        let interval = test.interval.unwrap();
        assert!(interval.low < -0.01 && -0.01 < interval.high && interval.high < 0.0, "{interval:?}");
        assert!((test.log_rank_p - 2e-4).abs() < 1e-9, "{}", test.log_rank_p);
    }

    /// Each score and each time of these trials once took a pass over all of them.
    #[test]
    fn censored_trials_are_tested_in_nearly_linear_time() {
        let trials = |mean: f64| -> Vec<Followed> {
            let time = |index: usize| mean * (1.0 + index as f64 / 1e4);
            (0..30_000).map(|index| Followed { until: time(index), solved: index % 3 > 0 }).collect()
        };
        let all = [trials(1.0), trials(2.0)].concat();
        assert_eq!(log_rank_scores(&all).len(), 60_000);
        assert!(restricted_times(&all, 10.0).iter().all(|time| time.is_finite()));
    }
}
