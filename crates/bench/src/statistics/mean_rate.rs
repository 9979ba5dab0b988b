use crate::statistics::{Interval, wilson};

/// Computes the mean of the success rates of several groups of trials, each given by its numbers of solved and of all trials,
/// with its interval. Each group counts the same, however many trials it has. `None` without groups, or if one is empty.
///
/// `p̄ = Σ pⱼ/k`, from `p̄ − √Σ(pⱼ − lⱼ)²/k` to `p̄ + √Σ(uⱼ − pⱼ)²/k`, with the Wilson interval `[lⱼ, uⱼ]` of each rate. Of one
/// group it is that interval.
///
/// Source: Zou, Huang & Zhang 2009, "A note on confidence interval estimation for a linear function of binomial proportions",
/// whole.
pub fn mean_rate(groups: &[(usize, usize)]) -> Option<(f64, Interval)> {
    let count = groups.len() as f64;
    let (mut sum, mut below, mut above) = (0.0, 0.0, 0.0);
    for &(solved, trials) in groups {
        let interval = wilson(solved, trials)?;
        let rate = solved as f64 / trials as f64;
        sum += rate;
        below += (rate - interval.low) * (rate - interval.low);
        above += (interval.high - rate) * (interval.high - rate);
    }
    let mean = sum / count;
    let interval = Interval {
        low: (mean - below.sqrt() / count).max(0.0),
        high: (mean + above.sqrt() / count).min(1.0),
    };
    (!groups.is_empty()).then_some((mean, interval))
}
