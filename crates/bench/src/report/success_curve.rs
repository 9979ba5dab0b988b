use std::collections::BTreeMap;

use serde::Serialize;

use crate::report::row::Group;
use crate::statistics::{Followed, KaplanMeier};

/// What a search is measured in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// Seconds.
    Time,
    /// Iterations, as the planner counts them.
    Iterations,
}

/// Which share of runs is solved at each time or iteration: one minus the Kaplan–Meier estimate, with its
/// Greenwood band. A step function: each share holds from its place on, before the first it is 0.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SuccessCurve {
    /// Environment of the scenarios.
    pub environment: String,
    /// The scenario, as in [`Row::scenario_name`](crate::report::Row); none where the curve is about all
    /// those of the environment together.
    pub scenario_name: Option<String>,
    /// The planner, as in [`Row::planner_name`](crate::report::Row).
    pub planner_name: String,
    /// What counts as solved.
    pub criterion: String,
    /// What `at` and `until` count.
    pub over: Measure,
    /// How many runs.
    pub runs: usize,
    /// How far the longest run was followed.
    pub until: f64,
    /// Where the share rises.
    pub at: Vec<f64>,
    /// The share from there on.
    pub success: Vec<f64>,
    /// Lower end of its band.
    pub low: Vec<f64>,
    /// Upper end of its band.
    pub high: Vec<f64>,
}

/// More curves than these in one plot cannot be told apart; a larger environment is shown as one curve a
/// planner.
pub const MOST_CURVES: usize = 8;

/// The curves of all groups, by criterion and environment.
pub fn success_curves(groups: &[Group]) -> Vec<SuccessCurve> {
    let mut environments: BTreeMap<(&str, &str), Vec<&Group>> = BTreeMap::new();
    for group in groups {
        environments.entry((&group.row.criterion, &group.row.environment)).or_default().push(group);
    }
    environments.into_values().flat_map(|groups| of_environment(&groups)).collect()
}

fn of_environment(groups: &[&Group]) -> Vec<SuccessCurve> {
    if scenario_count(groups.iter().map(|group| group.row.scenario_name.as_str())) <= MOST_CURVES {
        let of_group = |group: &&Group| {
            let of =
                |over, followed: &[Followed]| curve(group, Some(&group.row.scenario_name), over, followed);
            [of(Measure::Time, &group.over_time()), of(Measure::Iterations, &group.over_iterations())]
        };
        return groups.iter().flat_map(of_group).flatten().collect();
    }
    let mut planners: BTreeMap<&str, Vec<&Group>> = BTreeMap::new();
    for group in groups {
        planners.entry(&group.row.planner_name).or_default().push(group);
    }
    let pooled = |groups: Vec<&Group>| {
        let all = |followed: &dyn Fn(&Group) -> Vec<Followed>| -> Vec<Followed> {
            groups.iter().flat_map(|group| followed(group)).collect()
        };
        [
            curve(groups[0], None, Measure::Time, &all(&|group| group.over_time())),
            curve(groups[0], None, Measure::Iterations, &all(&|group| group.over_iterations())),
        ]
    };
    planners.into_values().flat_map(pooled).flatten().collect()
}

/// How many distinct scenarios.
pub fn scenario_count<'a>(names: impl Iterator<Item = &'a str>) -> usize {
    names.collect::<std::collections::BTreeSet<_>>().len()
}

fn curve(
    group: &Group,
    scenario_name: Option<&str>,
    over: Measure,
    followed: &[Followed],
) -> Option<SuccessCurve> {
    if followed.is_empty() {
        return None;
    }
    let estimate = KaplanMeier::of(followed);
    let steps = estimate.steps();
    Some(SuccessCurve {
        environment: group.row.environment.clone(),
        scenario_name: scenario_name.map(str::to_owned),
        planner_name: group.row.planner_name.clone(),
        criterion: group.row.criterion.clone(),
        over,
        runs: followed.len(),
        until: estimate.last(),
        at: steps.iter().map(|step| step.at).collect(),
        success: steps.iter().map(|step| 1.0 - step.survival).collect(),
        low: steps.iter().map(|step| 1.0 - step.band.high).collect(),
        high: steps.iter().map(|step| 1.0 - step.band.low).collect(),
    })
}
