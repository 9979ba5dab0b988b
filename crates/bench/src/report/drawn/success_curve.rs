use std::collections::BTreeMap;

use serde::Serialize;

use crate::report::overall::Pool;
use crate::report::row::{Group, Row};
use crate::statistics::{Followed, KaplanMeier, MeanStep, MeanSurvival};

/// Measure of search effort.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// Seconds.
    Time,
    /// Iterations, as the planner counts them.
    Iterations,
}

/// Share of solved runs at each time or iteration: one minus the Kaplan–Meier estimate, with its Greenwood band. The curve is 0
/// up to the first jump, and constant from each jump to the next. A curve of several scenarios is the mean of theirs, in which
/// each counts the same. Of more than 200 jumps, the curve has 200, evenly chosen, with the last one; its values there are
/// exact.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SuccessCurve {
    /// Environment of the scenarios; `None` if the curve covers all scenarios that the planners share.
    pub environment: Option<String>,
    /// The scenario, as in [`Row::scenario_name`](crate::report::Row); `None` if the curve covers several together.
    pub scenario_name: Option<String>,
    /// The planner, as in [`Row::planner_name`](crate::report::Row).
    pub planner_name: String,
    /// Criterion for a solved trial.
    pub criterion: String,
    /// Measure of `at` and `until`.
    pub over: Measure,
    /// Number of runs.
    pub runs: usize,
    /// End of the follow-up of the longest run.
    pub until: f64,
    /// Times or iterations of the jumps.
    pub at: Vec<f64>,
    /// Share of solved runs from each jump on.
    pub success: Vec<f64>,
    /// Lower end of its band.
    pub low: Vec<f64>,
    /// Upper end of its band.
    pub high: Vec<f64>,
}

/// Maximum number of distinguishable curves in one plot; a larger environment is shown as one curve for each planner.
pub const MOST_CURVES: usize = 8;

/// Returns the curves of all groups, by criterion and environment, then those of the pools.
pub fn success_curves(groups: &[Group], pools: &[Pool]) -> Vec<SuccessCurve> {
    let mut environments: BTreeMap<(&str, &str), Vec<&Group>> = BTreeMap::new();
    for group in groups {
        environments.entry((&group.row.criterion, &group.row.environment)).or_default().push(group);
    }
    let of_pool = |pool: &Pool| {
        let subject = Subject { environment: None, scenario: None, row: &pool.groups.first()?.row };
        mean_curve(subject, Measure::Time, pool.runs(), &pool.over_time())
    };
    let overall = pools.iter().filter_map(of_pool);
    environments.into_values().flat_map(|groups| of_environment(&groups)).chain(overall).collect()
}

#[derive(Clone, Copy)]
struct Subject<'a> {
    environment: Option<&'a str>,
    scenario: Option<&'a str>,
    row: &'a Row,
}

fn of_environment(groups: &[&Group]) -> Vec<SuccessCurve> {
    if scenario_count(groups.iter().map(|group| group.row.scenario_name.as_str())) <= MOST_CURVES {
        let of_group = |group: &&Group| {
            let row = &group.row;
            let subject =
                Subject { environment: Some(&row.environment), scenario: Some(&row.scenario_name), row };
            [
                curve(subject, Measure::Time, &group.over_time()),
                curve(subject, Measure::Iterations, &group.over_iterations()),
            ]
        };
        return groups.iter().flat_map(of_group).flatten().collect();
    }
    // Beyond the shortest limit the curve would depend only on the runs with longer ones.
    let limit_s = groups.iter().map(|group| group.row.time_limit_s).fold(f64::INFINITY, f64::min);
    let mut planners: BTreeMap<&str, Vec<&Group>> = BTreeMap::new();
    for group in groups {
        planners.entry(&group.row.planner_name).or_default().push(group);
    }
    let pooled = |groups: Vec<&Group>| {
        let row = &groups[0].row;
        let subject = Subject { environment: Some(&row.environment), scenario: None, row };
        let mean = |over: Measure, followed: &dyn Fn(&Group) -> Vec<Followed>| {
            let followed: Vec<Vec<Followed>> =
                groups.iter().map(|group| followed(group)).filter(|runs| !runs.is_empty()).collect();
            let curves: Vec<KaplanMeier> = followed.iter().map(|runs| KaplanMeier::of(runs)).collect();
            mean_curve(subject, over, followed.iter().map(Vec::len).sum(), &MeanSurvival::of(&curves))
        };
        [
            mean(Measure::Time, &|group| {
                group.over_time().into_iter().map(|run| run.up_to(limit_s)).collect()
            }),
            mean(Measure::Iterations, &|group| group.over_iterations()),
        ]
    };
    planners.into_values().flat_map(pooled).flatten().collect()
}

/// Returns the number of distinct scenarios.
pub fn scenario_count<'a>(names: impl Iterator<Item = &'a str>) -> usize {
    names.collect::<std::collections::BTreeSet<_>>().len()
}

fn curve(subject: Subject, over: Measure, followed: &[Followed]) -> Option<SuccessCurve> {
    let estimate = KaplanMeier::of(followed);
    let step = |step: &crate::statistics::SurvivalStep| MeanStep {
        at: step.at,
        survival: step.survival,
        band: step.band,
    };
    let steps: Vec<MeanStep> = estimate.steps().iter().map(step).collect();
    of_steps(subject, over, followed.len(), estimate.last(), &steps)
}

fn mean_curve(subject: Subject, over: Measure, runs: usize, mean: &MeanSurvival) -> Option<SuccessCurve> {
    of_steps(subject, over, runs, mean.last(), mean.steps())
}

/// Maximum number of jumps of a curve: a plot has hardly as many visible ones, and all take as much memory as the trials.
const MOST_JUMPS: usize = 200;

/// Returns the curve with these jumps; `None` without runs.
fn of_steps(
    subject: Subject,
    over: Measure,
    runs: usize,
    until: f64,
    steps: &[MeanStep],
) -> Option<SuccessCurve> {
    if runs == 0 {
        return None;
    }
    let most = steps.len().min(MOST_JUMPS);
    let kept: Vec<MeanStep> = (1..=most).map(|jump| steps[jump * steps.len() / most - 1]).collect();
    Some(SuccessCurve {
        environment: subject.environment.map(str::to_owned),
        scenario_name: subject.scenario.map(str::to_owned),
        planner_name: subject.row.planner_name.clone(),
        criterion: subject.row.criterion.clone(),
        over,
        runs,
        until,
        at: kept.iter().map(|step| step.at).collect(),
        success: kept.iter().map(|step| 1.0 - step.survival).collect(),
        low: kept.iter().map(|step| 1.0 - step.band.high).collect(),
        high: kept.iter().map(|step| 1.0 - step.band.low).collect(),
    })
}
