/// Performance profile of one solver among several on a set of problems, relative to the best of them on each.
#[derive(Clone, Debug, PartialEq)]
pub struct PerformanceProfile {
    /// Ratio of its cost to the least cost of all solvers on each problem; `None` if it did not solve the problem.
    pub ratios: Vec<Option<f64>>,
    /// Distinct ratios in rising order, at which the profile rises.
    pub at: Vec<f64>,
    /// Share of all problems with a ratio no greater.
    pub share: Vec<f64>,
}

/// Computes the profiles of solvers. The rows of `costs` are their costs on the same problems, in the same order; `None` is an
/// unsolved problem, of infinite cost. Costs below `tick`, the resolution, count as `tick`.
///
/// `r(p, s) = t(p, s) / min over s of t(p, s)`, `ρ(τ) = |{p : r(p, s) ≤ τ}| / |P|`. `ρ(1)` is the share of problems on
/// which a solver is the best, or as good; the last share is that of the problems that it solves. A problem that none
/// solves stays in `P`.
///
/// # Panics
/// If the rows differ in length, or a cost is NaN.
///
/// Source: Dolan & Moré 2002, "Benchmarking optimization software with performance profiles", §2.
pub fn performance_profiles(costs: &[Vec<Option<f64>>], tick: f64) -> Vec<PerformanceProfile> {
    let problems = costs.first().map_or(0, Vec::len);
    assert!(costs.iter().all(|row| row.len() == problems), "every solver has a cost on every problem");
    assert!(costs.iter().flatten().flatten().all(|cost| !cost.is_nan()), "costs are numbers");
    let cost = |row: &[Option<f64>], problem: usize| row[problem].map(|cost| cost.max(tick));
    let least = |problem| costs.iter().filter_map(|row| cost(row, problem)).min_by(f64::total_cmp);
    let profile = |row: &Vec<Option<f64>>| {
        let ratio = |problem| Some(cost(row, problem)? / least(problem)?);
        let ratios: Vec<Option<f64>> = (0..problems).map(ratio).collect();
        let mut at: Vec<f64> = ratios.iter().flatten().copied().collect();
        at.sort_by(f64::total_cmp);
        at.dedup();
        let within = |&bound: &f64| share_within(&ratios, bound);
        PerformanceProfile { share: at.iter().map(within).collect(), ratios, at }
    };
    costs.iter().map(profile).collect()
}

impl PerformanceProfile {
    /// Returns `ρ(bound)`; 0 without problems.
    pub fn share_within(&self, bound: f64) -> f64 {
        share_within(&self.ratios, bound)
    }
}

fn share_within(ratios: &[Option<f64>], bound: f64) -> f64 {
    let within = ratios.iter().flatten().filter(|ratio| **ratio <= bound).count();
    if ratios.is_empty() { 0.0 } else { within as f64 / ratios.len() as f64 }
}
