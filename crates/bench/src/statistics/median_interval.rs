use crate::statistics::{Followed, LEVEL};

/// Minimum number of trials for which an interval of the median has both ends: five values all lie on one side of it with
/// probability `2/2⁵ > 5 %`.
pub const LEAST_FOR_MEDIAN: usize = 6;

/// Computes the interval of the median time: the `r`-th least and the `r`-th greatest time, with the greatest `r` for which
/// `2 P(B(n, ½) < r) ≤ 5 %`. It is valid for every number of trials and every distribution of times. A censored trial counts
/// with its censoring time for the lower end, and as infinite for the upper end, which is `None` if not observed. Returns
/// `None` for fewer than [`LEAST_FOR_MEDIAN`] trials.
///
/// # Panics
/// If a time is NaN.
///
/// Source: Thompson 1936, "On confidence ranges for the median and other expectation distributions for populations of
/// unknown distribution form", whole; David & Nagaraja 2003, "Order Statistics", §7.1.
pub fn median_interval(trials: &[Followed]) -> Option<(f64, Option<f64>)> {
    assert!(trials.iter().all(|trial| !trial.until.is_nan()), "times are numbers");
    let rank = rank(trials.len());
    if rank == 0 {
        return None;
    }
    let sorted = |trials: &mut dyn Iterator<Item = &Followed>| {
        let mut times: Vec<f64> = trials.map(|trial| trial.until).collect();
        times.sort_by(f64::total_cmp);
        times
    };
    let (all, solved) = (sorted(&mut trials.iter()), sorted(&mut trials.iter().filter(|trial| trial.solved)));
    Some((all[rank - 1], solved.get(trials.len() - rank).copied()))
}

/// Returns the greatest `r` with `2 P(B(n, ½) < r) ≤ 5 %`; 0 if there is none.
fn rank(count: usize) -> usize {
    let n = count as f64;
    let probability = |k: f64| {
        let ways = libm::lgamma(n + 1.0) - libm::lgamma(k + 1.0) - libm::lgamma(n - k + 1.0);
        libm::exp(ways - n * std::f64::consts::LN_2)
    };
    let (mut rank, mut below) = (0, 0.0);
    loop {
        below += probability(rank as f64);
        if 2.0 * below > LEVEL || rank == count {
            return rank;
        }
        rank += 1;
    }
}
