use std::collections::BTreeMap;

use rayon::prelude::*;
use serde::Serialize;

use crate::report::row::{Group, horizon_s};
use crate::statistics::{Followed, KaplanMeier, LEVEL, TwoSampleTest, holm, least_p, log_rank};

/// Comparison of two planners on one scenario under one criterion. All comparisons of a report with enough runs are one
/// family: with probability 95 % none of their adjusted p-values is below 0.05, and no interval misses, by chance alone.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Scenario, as in [`Row::scenario_name`](crate::report::Row).
    pub scenario_name: String,
    /// Criterion for a solved trial.
    pub criterion: String,
    /// The first planner, as in [`Row::planner_name`](crate::report::Row).
    pub first: String,
    /// The second planner.
    pub second: String,
    /// Number of runs of the first.
    pub first_runs: usize,
    /// Number of runs of the second.
    pub second_runs: usize,
    /// Finding of the tests.
    pub finding: Finding,
    /// Number of comparisons in the family, each with two tests.
    pub family: usize,
    /// Statistic of the log-rank test; `None` if nothing was solved.
    pub log_rank_chi_square: Option<f64>,
    /// p-value of its permutation test; `None` for too few runs.
    pub log_rank_p: Option<f64>,
    /// This p-value adjusted for the family.
    pub log_rank_p_holm: Option<f64>,
    /// Horizon of the restricted means, in seconds: the shorter of the two limits.
    pub restricted_to_s: f64,
    /// Restricted mean of the first minus that of the second, in seconds: negative if the first is faster.
    pub difference_s: f64,
    /// Lower end of its interval, in seconds; `None` for too few runs, and if no time varies.
    pub difference_low_s: Option<f64>,
    /// Upper end of its interval, in seconds.
    pub difference_high_s: Option<f64>,
    /// p-value of the studentised permutation test for no difference; `None` for too few runs.
    pub difference_p: Option<f64>,
    /// This p-value adjusted for the family.
    pub difference_p_holm: Option<f64>,
}

/// Finding of the tests of a comparison, at a significance level of 5 % over the whole report.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Finding {
    /// No outcome with these numbers of runs would be significant.
    TooFewRuns,
    /// No test is significant.
    NoDifference,
    /// The first planner is faster: a test is significant, and pace and mean are both better.
    FirstIsFaster,
    /// The second planner is faster.
    SecondIsFaster,
    /// A test is significant, but one planner has the better pace and the other the better mean.
    Differ,
}

impl Comparison {
    /// Returns the planner found to be faster.
    pub fn faster(&self) -> Option<&str> {
        match self.finding {
            Finding::FirstIsFaster => Some(&self.first),
            Finding::SecondIsFaster => Some(&self.second),
            Finding::TooFewRuns | Finding::NoDifference | Finding::Differ => None,
        }
    }
}

/// Maximum number of comparisons of a report. Each has permutation tests, whose number of draws grows with that of all
/// comparisons.
pub const MOST_COMPARISONS: usize = 500;

/// Selected comparisons, and the reason for a selection.
pub struct Comparisons {
    pub compared: Vec<Comparison>,
    /// Sentence about the selection; `None` if every pair is compared.
    pub note: Option<String>,
}

/// Compares every pair of planners on every scenario on which both have runs. If there are more than [`MOST_COMPARISONS`] pairs,
/// compares each planner with the first one by name, in the order of names up to that number: a choice by results, such as
/// the best planner, would make differences by chance more frequent than the tests promise. Goal-wise runs are excluded: these
/// already select the best goal.
pub fn comparisons(groups: &[Group]) -> Comparisons {
    let mut scenarios: BTreeMap<(&str, &str, &str), Vec<&Group>> = BTreeMap::new();
    for group in groups.iter().filter(|group| group.row.goals.is_none()) {
        let row = &group.row;
        scenarios.entry((&row.criterion, &row.scenario_name, &row.scenario_hash)).or_default().push(group);
    }
    let all: usize = scenarios.values().map(|groups| groups.len() * (groups.len() - 1) / 2).sum();
    let mut pairs: Vec<(&Group, &Group)> = Vec::new();
    if all <= MOST_COMPARISONS {
        for groups in scenarios.values() {
            for (index, first) in groups.iter().enumerate() {
                pairs.extend(groups[index + 1..].iter().map(|second| (*first, *second)));
            }
        }
    } else {
        let mut references: BTreeMap<&str, &str> = BTreeMap::new();
        for row in scenarios.values().flatten().map(|group| &group.row) {
            let first = references.entry(&row.criterion).or_insert(&row.planner_name);
            *first = (*first).min(&row.planner_name);
        }
        for groups in scenarios.values() {
            let is_reference = |group: &&&Group| group.row.planner_name == references[&*group.row.criterion];
            let Some(reference) = groups.iter().find(is_reference) else { continue };
            let others = groups.iter().filter(|group| !is_reference(group));
            pairs.extend(others.map(|other| (*reference, *other)));
        }
    }
    let names = |(first, second): &(&Group, &Group)| {
        (first.row.criterion.clone(), first.row.planner_name.clone(), second.row.planner_name.clone())
    };
    pairs.sort_by_cached_key(names);
    pairs.truncate(MOST_COMPARISONS);
    let least: Vec<f64> =
        pairs.iter().map(|(first, second)| least_p(first.runs.len(), second.runs.len())).collect();
    let family = family(&least);
    let is_tested = |least: f64| family > 0 && least * tests_of(family) < LEVEL;
    let compared = pairs.par_iter().zip(&least);
    let (mut comparisons, excesses): (Vec<Comparison>, Vec<f64>) =
        compared.map(|((first, second), least)| compare(first, second, family, is_tested(*least))).unzip();
    adjust(&mut comparisons);
    for (comparison, excess) in comparisons.iter_mut().zip(excesses) {
        comparison.finding = finding(comparison, excess);
    }
    let count = comparisons.len();
    let note = (count < all).then(|| {
        format!(
            "{count} of {all} pairs of planners on a scenario are compared, the most that a report compares: each \
             planner with the first one by name, a choice that no result influences."
        )
    });
    Comparisons { compared: comparisons, note }
}

/// Returns the number of tests: two for each comparison.
fn tests_of(family: usize) -> f64 {
    2.0 * family as f64
}

/// Returns the size of the largest family in which each comparison can be significant, by the least p-values that their numbers
/// of runs allow. The other comparisons can never be significant and are not counted.
///
/// Source: Tarone 1990, "A modified Bonferroni method for discrete data", whole.
fn family(least: &[f64]) -> usize {
    let mut sorted = least.to_vec();
    sorted.sort_by(f64::total_cmp);
    (1..=sorted.len()).rev().find(|&size| sorted[size - 1] * tests_of(size) < LEVEL).unwrap_or(0)
}

/// Adjusts all p-values of a report by Holm's method.
fn adjust(comparisons: &mut [Comparison]) {
    let of = |comparison: &Comparison| [comparison.log_rank_p, comparison.difference_p];
    let p_values: Vec<f64> = comparisons.iter().flat_map(of).flatten().collect();
    let mut adjusted = holm(&p_values).into_iter();
    for comparison in comparisons {
        comparison.log_rank_p_holm = comparison.log_rank_p.and_then(|_| adjusted.next());
        comparison.difference_p_holm = comparison.difference_p.and_then(|_| adjusted.next());
    }
}

/// Derives the finding; `excess` is that of the first planner in the log-rank test.
fn finding(comparison: &Comparison, excess: f64) -> Finding {
    let Some((pace_p, mean_p)) = comparison.log_rank_p_holm.zip(comparison.difference_p_holm) else {
        return Finding::TooFewRuns;
    };
    if pace_p.min(mean_p) >= LEVEL {
        return Finding::NoDifference;
    }
    match (excess > 0.0, comparison.difference_s < 0.0) {
        (true, true) => Finding::FirstIsFaster,
        (false, false) => Finding::SecondIsFaster,
        (true, false) | (false, true) => Finding::Differ,
    }
}

/// Returns the comparison, not adjusted yet, and the log-rank excess of the first planner.
fn compare(first: &Group, second: &Group, family: usize, is_tested: bool) -> (Comparison, f64) {
    // Both groups are cut off at the same limit, so that runs of one planner are exchangeable between them.
    let limit_s = first.row.time_limit_s.min(second.row.time_limit_s);
    let up_to_limit = |group: &Group| -> Vec<Followed> {
        group.over_time().into_iter().map(|run| run.up_to(limit_s)).collect()
    };
    let (first_runs, second_runs) = (up_to_limit(first), up_to_limit(second));
    let restricted_to_s = horizon_s(&KaplanMeier::of(&[&first_runs[..], &second_runs[..]].concat()), limit_s);
    let test = TwoSampleTest::of(&first_runs, &second_runs, restricted_to_s, 2 * family.max(1));
    let interval = test.interval.filter(|_| is_tested);
    let comparison = Comparison {
        scenario_name: first.row.scenario_name.clone(),
        criterion: first.row.criterion.clone(),
        first: first.row.planner_name.clone(),
        second: second.row.planner_name.clone(),
        first_runs: first_runs.len(),
        second_runs: second_runs.len(),
        finding: Finding::TooFewRuns,
        family,
        log_rank_chi_square: log_rank(&first_runs, &second_runs).map(|test| test.chi_square),
        log_rank_p: is_tested.then_some(test.log_rank_p),
        log_rank_p_holm: None,
        restricted_to_s,
        difference_s: test.difference,
        difference_low_s: interval.map(|interval| interval.low),
        difference_high_s: interval.map(|interval| interval.high),
        difference_p: is_tested.then_some(test.difference_p),
        difference_p_holm: None,
    };
    (comparison, test.log_rank_excess)
}
