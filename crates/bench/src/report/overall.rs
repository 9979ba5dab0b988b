use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use crate::report::row::Group;
use crate::statistics::{
    Interval, KaplanMeier, LEAST_FOR_MEDIAN, MeanSurvival, mean_rate, performance_profiles,
};

/// Figures of one planner over the scenarios on which every planner of the criterion has runs. Each scenario counts the same,
/// however many runs it has: more runs on the scenarios that suit a planner do not improve its figures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Overall {
    /// Criterion for a solved trial.
    pub criterion: String,
    /// The planner, as in [`Row::planner_name`](crate::report::Row).
    pub planner_name: String,
    /// Number of scenarios on which all planners have runs.
    pub scenarios: usize,
    /// Number of all scenarios.
    pub scenarios_in_all: usize,
    /// Number of runs.
    pub runs: usize,
    /// Number of solved runs.
    pub solved: usize,
    /// Number of runs whose planner claimed a path that the proof refused.
    pub claimed: usize,
    /// Mean of the success rates of the scenarios ([`mean_rate`]).
    pub success_rate: f64,
    /// Lower end of its interval.
    pub success_low: f64,
    /// Upper end of its interval.
    pub success_high: f64,
    /// End of the follow-up of all runs, in seconds: the shortest of their limits.
    pub followed_to_s: f64,
    /// Median time of the mean of the curves of the scenarios ([`MeanSurvival`]), in seconds; `None` if it stays above one half.
    pub median_s: Option<f64>,
    /// Lower end of its interval, in seconds; `None` for fewer than six runs.
    pub median_low_s: Option<f64>,
    /// Upper end of its interval, in seconds; also `None` if it is past the limit.
    pub median_high_s: Option<f64>,
    /// Ratio of its median time to the least median time of all planners, by scenario; `None` if there is no median.
    pub ratios: BTreeMap<String, Option<f64>>,
    /// Share of the scenarios on which it has the least median time, or the same.
    pub best: f64,
    /// Share of the scenarios on which its median time is at most twice the least.
    pub within_2: f64,
    /// Share of the scenarios on which its median time is at most ten times the least.
    pub within_10: f64,
    /// Ratios at which the performance profile rises.
    pub profile_at: Vec<f64>,
    /// Share of scenarios with a ratio no greater.
    pub profile_share: Vec<f64>,
}

/// Resolution of the clock, in seconds.
const TICK_S: f64 = 1e-6;

/// Groups of one planner on the scenarios that it shares with all others, by scenario.
pub struct Pool<'a> {
    pub criterion: &'a str,
    pub planner_name: &'a str,
    pub groups: Vec<&'a Group<'a>>,
    /// Number of all scenarios, shared or not.
    scenarios_in_all: usize,
    /// Shortest limit of the runs of all planners, in seconds: later estimates would depend only on runs with longer limits.
    pub followed_to_s: f64,
}

/// Returns the pools of each criterion, by planner; none if fewer than two scenarios are shared.
pub fn pools<'a>(groups: &'a [Group<'a>]) -> Vec<Pool<'a>> {
    let mut criteria: BTreeMap<&str, BTreeMap<&str, BTreeMap<&str, &Group>>> = BTreeMap::new();
    for group in groups {
        let row = &group.row;
        let planners = criteria.entry(&row.criterion).or_default();
        planners.entry(&row.planner_name).or_default().insert(&row.scenario_name, group);
    }
    let of_criterion =
        |(criterion, planners): (&'a str, BTreeMap<&'a str, BTreeMap<&'a str, &'a Group<'a>>>)| {
            let all: BTreeSet<&str> = planners.values().flat_map(|groups| groups.keys().copied()).collect();
            let is_shared = |name: &&str| planners.values().all(|groups| groups.contains_key(*name));
            let shared: Vec<&str> = all.iter().copied().filter(is_shared).collect();
            if shared.len() < 2 {
                return Vec::new();
            }
            let kept = |groups: &BTreeMap<&'a str, &'a Group<'a>>| -> Vec<&'a Group<'a>> {
                shared.iter().map(|name| groups[name]).collect()
            };
            let limits_s = planners.values().flat_map(&kept).map(|group| group.row.time_limit_s);
            let followed_to_s = limits_s.fold(f64::INFINITY, f64::min);
            let pool = |(planner_name, groups): (&&'a str, &BTreeMap<&'a str, &'a Group<'a>>)| Pool {
                criterion,
                planner_name,
                groups: kept(groups),
                scenarios_in_all: all.len(),
                followed_to_s,
            };
            planners.iter().map(pool).collect()
        };
    criteria.into_iter().flat_map(of_criterion).collect()
}

/// Computes the results over all scenarios.
pub fn overall(pools: &[Pool]) -> Vec<Overall> {
    let of_criterion = |pools: &[Pool]| -> Vec<Overall> {
        let medians = |pool: &Pool| pool.groups.iter().map(|group| group.row.median_s).collect();
        let profiles = performance_profiles(&pools.iter().map(medians).collect::<Vec<_>>(), TICK_S);
        let one = |(pool, profile): (&Pool, crate::statistics::PerformanceProfile)| {
            let runs = pool.runs();
            let counts: Vec<(usize, usize)> =
                pool.groups.iter().map(|group| (group.row.solved, group.row.runs)).collect();
            let (success_rate, interval) =
                mean_rate(&counts).unwrap_or((0.0, Interval { low: 0.0, high: 1.0 }));
            let curve = pool.over_time();
            let (median_low_s, median_high_s) =
                if runs < LEAST_FOR_MEDIAN { (None, None) } else { curve.median_interval() };
            let names = pool.groups.iter().map(|group| group.row.scenario_name.clone());
            Overall {
                criterion: pool.criterion.to_owned(),
                planner_name: pool.planner_name.to_owned(),
                scenarios: pool.groups.len(),
                scenarios_in_all: pool.scenarios_in_all,
                runs,
                solved: counts.iter().map(|(solved, _)| solved).sum(),
                claimed: pool.groups.iter().map(|group| group.row.claimed).sum(),
                success_rate,
                success_low: interval.low,
                success_high: interval.high,
                followed_to_s: pool.followed_to_s,
                median_s: curve.median(),
                median_low_s,
                median_high_s,
                best: profile.share_within(1.0),
                within_2: profile.share_within(2.0),
                within_10: profile.share_within(10.0),
                ratios: names.zip(profile.ratios).collect(),
                profile_at: profile.at,
                profile_share: profile.share,
            }
        };
        pools.iter().zip(profiles).map(one).collect()
    };
    pools.chunk_by(|a, b| a.criterion == b.criterion).flat_map(of_criterion).collect()
}

impl Pool<'_> {
    /// Returns the number of its runs.
    pub fn runs(&self) -> usize {
        self.groups.iter().map(|group| group.row.runs).sum()
    }

    /// Returns the mean curve of its scenarios, followed up to the shortest limit.
    pub fn over_time(&self) -> MeanSurvival {
        let of_group = |group: &&Group| {
            let runs: Vec<_> =
                group.over_time().into_iter().map(|run| run.up_to(self.followed_to_s)).collect();
            KaplanMeier::of(&runs)
        };
        MeanSurvival::of(&self.groups.iter().map(of_group).collect::<Vec<_>>())
    }
}
