use crate::statistics::Followed;

/// Log-rank test for equal solution rates of two groups of trials. [`TwoSampleTest`](crate::statistics::TwoSampleTest) has
/// the p-value of its numerator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogRank {
    /// Number of solved trials in the first group.
    pub observed: f64,
    /// Expected number of solved trials in the first group under equal rates.
    pub expected: f64,
    /// Chi-square statistic, of one degree of freedom if both groups are large.
    pub chi_square: f64,
}
/// Computes the log-rank test of two groups; `None` if their times allow no test (nothing was solved while both had trials
/// at risk).
///
/// With `d` of `n` solved at a time, `n₁` of the first group at risk: `E = Σ d n₁/n`,
/// `V = Σ d (n₁/n)(1 − n₁/n)(n − d)/(n − 1)`, `χ² = (O − E)²/V`. Exchanging the groups changes nothing.
///
/// # Panics
/// If a time is NaN.
///
/// Source: Mantel 1966, "Evaluation of survival data and two new rank order statistics", whole; Klein & Moeschberger 2003,
/// eqs. (7.3.1) to (7.3.4) with weight 1.
pub fn log_rank(first: &[Followed], second: &[Followed]) -> Option<LogRank> {
    let mut all: Vec<(Followed, bool)> = first.iter().map(|&trial| (trial, true)).collect();
    all.extend(second.iter().map(|&trial| (trial, false)));
    assert!(all.iter().all(|(trial, _)| !trial.until.is_nan()), "times are numbers");
    all.sort_by(|a, b| a.0.until.total_cmp(&b.0.until));

    let (mut at_risk, mut at_risk_first) = (all.len() as f64, first.len() as f64);
    let (mut observed, mut expected, mut variance) = (0.0, 0.0, 0.0);
    for same in all.chunk_by(|a, b| a.0.until.total_cmp(&b.0.until).is_eq()) {
        let solved = same.iter().filter(|(trial, _)| trial.solved).count() as f64;
        let solved_first = same.iter().filter(|(trial, is_first)| trial.solved && *is_first).count() as f64;
        let share = at_risk_first / at_risk;
        observed += solved_first;
        expected += solved * share;
        if at_risk > 1.0 {
            variance += solved * share * (1.0 - share) * (at_risk - solved) / (at_risk - 1.0);
        }
        at_risk -= same.len() as f64;
        at_risk_first -= same.iter().filter(|(_, is_first)| *is_first).count() as f64;
    }
    (variance > 0.0).then(|| {
        let chi_square = (observed - expected) * (observed - expected) / variance;
        LogRank { observed, expected, chi_square }
    })
}
