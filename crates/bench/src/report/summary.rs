use std::collections::BTreeMap;

use serde::Serialize;

use crate::report::comparison::{Comparison, Comparisons, comparisons};
use crate::report::configuration::{Configuration, Names};
use crate::report::drawn::success_curve::{SuccessCurve, success_curves};
use crate::report::machine::{Machine, machines};
use crate::report::overall::{Overall, overall, pools};
use crate::report::row::{GoalRow, Group, Row};
use crate::report::split_row::{SplitRow, split_rows};
use crate::report::warning::{few_runs, warnings};
use crate::report::worst_trial::{WorstTrial, worst_trials};
use crate::store::stored_paths;
use crate::{BenchError, Results, Run, ScenarioSource, Shard, StoredTrial};

/// All figures of a report, regardless of the order of the trials. Pages, tables and plots derive from it alone and thus agree.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Name of the results in replay commands.
    pub results: String,
    /// Version of Cranny that created the summary.
    pub version: &'static str,
    /// Number of trials.
    pub trials: usize,
    /// Warnings about the validity of the figures.
    pub warnings: Vec<String>,
    /// Machines on which the trials ran.
    pub machines: Vec<Machine>,
    /// Rows that pool several kinds of machine or versions, split.
    pub split_rows: Vec<SplitRow>,
    /// Results of each planner over all scenarios that the planners share, by criterion.
    pub overall: Vec<Overall>,
    /// One row for each planner on each scenario, by criterion.
    pub rows: Vec<Row>,
    /// One row for each goal, of planners that aim at one.
    pub goals: Vec<GoalRow>,
    /// Number of known goals for each scenario (`|G_IK|`), by its name, if determined.
    pub known_goals: BTreeMap<String, usize>,
    /// Comparisons of planners.
    pub comparisons: Vec<Comparison>,
    /// Curves of the share of solved runs.
    pub curves: Vec<SuccessCurve>,
    /// Trials to inspect first.
    pub worst: Vec<WorstTrial>,
}

/// Source of a summary.
#[derive(Clone, Copy, Debug)]
pub struct SummarySource<'a> {
    /// Name of the results in replay commands.
    pub results: &'a str,
    /// All trials, in any order.
    pub trials: &'a [StoredTrial],
    /// The runs of the trials, as far as known.
    pub runs: &'a [Run],
    /// Information on the scenarios.
    pub scenarios: &'a [ScenarioSource],
}

impl Summary {
    /// Computes the summary of all trials in `results`.
    ///
    /// # Errors
    /// Those of reading the results, and those of [`Self::of`]; [`BenchError::Row`] if a trial is solved without a path, or its
    /// path is cut.
    pub fn of_results(results: &Results) -> Result<Self, BenchError> {
        stored_paths::check_paths(results)?;
        Self::of(&SummarySource {
            results: &results.path().display().to_string(),
            trials: &results.trials()?,
            runs: &results.runs()?,
            scenarios: &results.scenarios()?,
        })
    }

    /// Computes the summary of `source`.
    ///
    /// # Errors
    /// [`BenchError::NoTrials`]; [`BenchError::Figure`] if a time, a length or a score is negative or not finite, or a time limit
    /// is 0; [`BenchError::Late`] if a trial is solved after its time limit.
    pub fn of(source: &SummarySource) -> Result<Self, BenchError> {
        if source.trials.is_empty() {
            return Err(BenchError::NoTrials { results: source.results.to_owned() });
        }
        source.trials.iter().try_for_each(StoredTrial::check)?;
        let mut configurations: BTreeMap<Configuration, Vec<&StoredTrial>> = BTreeMap::new();
        for trial in source.trials {
            configurations.entry(Configuration::of(&trial.record.trial)).or_default().push(trial);
        }
        // Sorting makes sums independent of the order of the trials.
        for runs in configurations.values_mut() {
            runs.sort_by_key(|run| run.id);
        }
        let names = Names::of(configurations.keys());
        let groups: Vec<Group> = configurations
            .iter()
            .map(|(configuration, runs)| Group::of(configuration, &names, runs.clone()))
            .collect();
        let pools = pools(&groups);
        let Comparisons { compared: comparisons, note } = comparisons(&groups);
        // A page with too many warnings contains the first ones.
        let commands = source.runs.iter().map(|run| run.information.command.as_str());
        let general =
            Shard::missing_among(commands).into_iter().chain(note).chain(few_runs(&groups, &comparisons));
        let warnings = general.chain(warnings(&groups, source.runs)).collect();
        Ok(Self {
            results: source.results.to_owned(),
            version: env!("CARGO_PKG_VERSION"),
            trials: source.trials.len(),
            warnings,
            machines: machines(source.runs, source.trials),
            split_rows: split_rows(&groups, source.runs),
            overall: overall(&pools),
            known_goals: known_goals(configurations.keys(), &names, source.scenarios),
            comparisons,
            curves: success_curves(&groups, &pools),
            worst: worst_trials(&groups, source.results),
            goals: groups.iter().flat_map(|group| group.goals.clone()).collect(),
            rows: groups.into_iter().map(|group| group.row).collect(),
        })
    }

    /// Returns the criteria of the trials, in order.
    pub fn criteria(&self) -> Vec<&str> {
        let mut criteria: Vec<&str> = self.rows.iter().map(|row| row.criterion.as_str()).collect();
        criteria.dedup();
        criteria
    }

    /// Returns the environments of the scenarios judged under a criterion, in order.
    pub fn environments(&self, criterion: &str) -> Vec<&str> {
        let rows = self.rows.iter().filter(|row| row.criterion == criterion);
        let mut environments: Vec<&str> = rows.map(|row| row.environment.as_str()).collect();
        environments.sort_unstable();
        environments.dedup();
        environments
    }

    /// Returns the names of all planners in the rows, in order.
    pub fn planner_names(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.rows.iter().map(|row| row.planner_name.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        names
    }
}

fn known_goals<'a>(
    configurations: impl Iterator<Item = &'a Configuration>,
    names: &Names,
    scenarios: &'a [ScenarioSource],
) -> BTreeMap<String, usize> {
    let known =
        |source: &'a ScenarioSource| Some(((&*source.scenario, &*source.scenario_hash), source.goals?));
    let known: BTreeMap<(&str, &str), usize> = scenarios.iter().filter_map(known).collect();
    let goals = |configuration: &Configuration| {
        let goals = known.get(&(&*configuration.scenario, &*configuration.scenario_hash))?;
        Some((names.scenario(configuration).to_owned(), *goals))
    };
    configurations.filter_map(goals).collect()
}
