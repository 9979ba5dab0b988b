use std::collections::BTreeMap;

use crate::report::Row;

/// Returns the names of the planners in the order of their results over all rows: by the mean success rate, in which each
/// scenario counts the same, then by the mean share of its limit that the restricted mean time takes, then by name. A scenario
/// on which a planner has no runs counts as unsolved.
///
/// The order selects only what is drawn and listed first; no test depends on it.
pub fn ranked_planners(rows: &[Row]) -> Vec<&str> {
    let mut planners: BTreeMap<&str, (f64, f64)> = BTreeMap::new();
    for row in rows {
        let (rates, shares) = planners.entry(&row.planner_name).or_default();
        *rates += row.success_rate;
        *shares += 1.0 - row.restricted_mean_s.map_or(1.0, |mean_s| mean_s / row.time_limit_s);
    }
    let mut ranked: Vec<(&str, (f64, f64))> = planners.into_iter().collect();
    // The sort is stable: equal planners stay in the order of their names.
    ranked.sort_by(|(_, a), (_, b)| b.0.total_cmp(&a.0).then(b.1.total_cmp(&a.1)));
    ranked.into_iter().map(|(name, _)| name).collect()
}
