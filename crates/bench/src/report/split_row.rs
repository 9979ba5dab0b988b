use std::collections::BTreeMap;

use serde::Serialize;

use crate::report::follow_up;
use crate::report::row::Group;
use crate::statistics::{Followed, KaplanMeier};
use crate::{Run, StoredTrial};

/// Trials of one kind of machine, or one version, in a row that pools several.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SplitRow {
    /// Criterion for a solved trial.
    pub criterion: String,
    /// Name of the scenario, as in the row.
    pub scenario_name: String,
    /// Name of the planner, as in the row.
    pub planner_name: String,
    /// Processor, workers, version and commit.
    pub on: String,
    /// Number of trials.
    pub trials: usize,
    /// Number of solved trials.
    pub solved: usize,
    /// Median time, as in rows, in seconds.
    pub median_s: Option<f64>,
}

/// Splits the rows whose times are no sample of one distribution.
pub fn split_rows(groups: &[Group], runs: &[Run]) -> Vec<SplitRow> {
    let on: BTreeMap<u64, String> = runs.iter().map(|run| (run.id, described(run))).collect();
    let mut rows = Vec::new();
    for group in groups {
        let mut parts: BTreeMap<&str, Vec<&StoredTrial>> = BTreeMap::new();
        for trial in &group.runs {
            parts.entry(on.get(&trial.run).map_or("", String::as_str)).or_default().push(trial);
        }
        if parts.len() < 2 {
            continue;
        }
        rows.extend(parts.into_iter().map(|(on, trials)| {
            let followed: Vec<Followed> =
                trials.iter().map(|trial| follow_up::over_time(&trial.record)).collect();
            SplitRow {
                criterion: group.row.criterion.clone(),
                scenario_name: group.row.scenario_name.clone(),
                planner_name: group.row.planner_name.clone(),
                on: on.to_owned(),
                trials: trials.len(),
                solved: trials.iter().filter(|trial| trial.record.is_solved()).count(),
                median_s: KaplanMeier::of(&followed).median(),
            }
        }));
    }
    rows
}

fn described(run: &Run) -> String {
    let information = &run.information;
    let commit: String = information.commit.iter().flat_map(|commit| commit.chars().take(10)).collect();
    let built = format!("Cranny {} {commit}", information.version);
    let workers = match information.workers {
        0 => ", unknown number of workers".to_owned(),
        1 => String::new(),
        workers => format!(", {workers} workers"),
    };
    format!("{}{workers}, {}", information.processor, built.trim())
}
