use std::collections::BTreeMap;

use serde::Serialize;

use crate::report::row::{Group, horizon_s};
use crate::statistics::{KaplanMeier, holm, log_rank};

/// Two planners on one scenario under one criterion. The p-values of all scenarios of one pair are one
/// family, which Holm's method adjusts; the interval stands for itself.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// As in [`Row::scenario_name`](crate::report::Row).
    pub scenario_name: String,
    /// What counts as solved.
    pub criterion: String,
    /// As in [`Row::planner_name`](crate::report::Row).
    pub first: String,
    /// The other planner.
    pub second: String,
    /// How many scenarios the family has.
    pub family: usize,
    /// Statistic of the log-rank test; none where nothing was solved, which leaves nothing to compare.
    pub log_rank_chi_square: Option<f64>,
    /// Its p-value.
    pub log_rank_p: Option<f64>,
    /// The same, adjusted for the family.
    pub log_rank_p_holm: Option<f64>,
    /// What the means are restricted to, in seconds: the shorter of the two limits.
    pub restricted_to_s: f64,
    /// Restricted mean of the first minus that of the second, in seconds: negative where the first is faster.
    pub difference_s: Option<f64>,
    /// Lower end of its interval.
    pub difference_low_s: Option<f64>,
    /// Upper end of its interval.
    pub difference_high_s: Option<f64>,
    /// p-value of no difference; none where no time varies.
    pub difference_p: Option<f64>,
    /// The same, adjusted for the family.
    pub difference_p_holm: Option<f64>,
}

impl Comparison {
    /// Which planner the adjusted tests find faster at level 5 %: the log-rank test decides whether, the
    /// means which.
    pub fn faster(&self) -> Option<&str> {
        let significant = self.log_rank_p_holm? < 0.05;
        let difference_s = self.difference_s?;
        if !significant || difference_s == 0.0 {
            return None;
        }
        Some(if difference_s < 0.0 { &self.first } else { &self.second })
    }
}

/// Every pair of planners on every scenario that both have runs of. Goal-wise runs are left out: the best
/// goal was chosen by the very runs that would be tested.
pub fn comparisons(groups: &[Group]) -> Vec<Comparison> {
    let mut scenarios: BTreeMap<(&str, &str, &str), Vec<&Group>> = BTreeMap::new();
    for group in groups.iter().filter(|group| group.row.goals.is_none()) {
        let row = &group.row;
        scenarios.entry((&row.criterion, &row.scenario_name, &row.scenario_hash)).or_default().push(group);
    }
    let mut families: BTreeMap<(String, String, String), Vec<Comparison>> = BTreeMap::new();
    for groups in scenarios.values() {
        for (index, first) in groups.iter().enumerate() {
            for second in &groups[index + 1..] {
                let comparison = compare(first, second);
                let family =
                    (comparison.criterion.clone(), comparison.first.clone(), comparison.second.clone());
                families.entry(family).or_default().push(comparison);
            }
        }
    }
    for family in families.values_mut() {
        let size = family.len();
        for comparison in family.iter_mut() {
            comparison.family = size;
        }
        adjust(family, |comparison| (comparison.log_rank_p, &mut comparison.log_rank_p_holm));
        adjust(family, |comparison| (comparison.difference_p, &mut comparison.difference_p_holm));
    }
    families.into_values().flatten().collect()
}

/// Adjusts one kind of p-value over a family. A test that could not be made counts as one that found nothing.
fn adjust(family: &mut [Comparison], of: impl Fn(&mut Comparison) -> (Option<f64>, &mut Option<f64>)) {
    let p_values: Vec<f64> = family.iter_mut().map(|comparison| of(comparison).0.unwrap_or(1.0)).collect();
    for (comparison, adjusted) in family.iter_mut().zip(holm(&p_values)) {
        let (p, place) = of(comparison);
        *place = p.map(|_| adjusted);
    }
}

fn compare(first: &Group, second: &Group) -> Comparison {
    let (first_runs, second_runs) = (first.over_time(), second.over_time());
    let (first_curve, second_curve) = (KaplanMeier::of(&first_runs), KaplanMeier::of(&second_runs));
    let limit_s = first.row.time_limit_s.min(second.row.time_limit_s);
    let restricted_to_s = horizon_s(&first_curve, limit_s).min(horizon_s(&second_curve, limit_s));
    let means =
        first_curve.restricted_mean(restricted_to_s).zip(second_curve.restricted_mean(restricted_to_s));
    let difference = means.map(|(first, second)| first.minus(&second));
    let test = log_rank(&first_runs, &second_runs);
    Comparison {
        scenario_name: first.row.scenario_name.clone(),
        criterion: first.row.criterion.clone(),
        first: first.row.planner_name.clone(),
        second: second.row.planner_name.clone(),
        family: 0,
        log_rank_chi_square: test.map(|test| test.chi_square),
        log_rank_p: test.map(|test| test.p),
        log_rank_p_holm: None,
        restricted_to_s,
        difference_s: difference.map(|difference| difference.difference),
        difference_low_s: difference.map(|difference| difference.interval.low),
        difference_high_s: difference.map(|difference| difference.interval.high),
        difference_p: difference.and_then(|difference| difference.p),
        difference_p_holm: None,
    }
}
