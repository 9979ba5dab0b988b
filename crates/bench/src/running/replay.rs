use std::sync::atomic::AtomicBool;

use cranny_scenario::Identity;

use crate::running::campaign_run::ask_once;
use crate::{BenchError, CampaignSettings, PlannerCall, Question, Results, StoredTrial, Trial, TrialRecord};

/// Result of a replayed trial.
#[derive(Clone, Debug, PartialEq)]
pub struct Replay {
    /// The trial stored in the results.
    pub stored: StoredTrial,
    /// Record of the replay.
    pub record: TrialRecord,
    /// Path of the replay (m, rad; one value per joint).
    pub path: Vec<Vec<f64>>,
    /// True if the path equals the stored one bit by bit, or if both are empty.
    pub is_same_path: bool,
    /// True if the numbers of iterations and nodes of the search equal the stored ones.
    pub is_same_search: bool,
}

impl Replay {
    /// Returns true if the replay reproduced the trial.
    pub fn is_same(&self) -> bool {
        self.is_same_path && self.is_same_search
    }
}

/// Factor on the time limit of a replay: its iterations are its budget, and this machine may be slower.
const TIME_FACTOR: f64 = 20.0;

/// Replays a trial. For a built-in planner the stored number of iterations is the budget, so that a trial cut short by time
/// ends at the same node; an external program gets its original request. `source` overrides the source of the scenario.
/// Returns `None` if `stop` ended the replay.
///
/// # Errors
/// [`BenchError::NoTrial`]; [`BenchError::OtherScenario`] if the scenario has changed; [`BenchError::UnknownCall`];
/// [`BenchError::ForeignCommand`] unless `allow_exec`, because untrusted results may name any command; and as
/// [`run_campaign`](crate::run_campaign), which refuses a program that is not the trial's.
pub fn replay(
    results: &Results,
    id: u64,
    source: Option<&str>,
    allow_exec: bool,
    settings: &CampaignSettings,
    stop: &AtomicBool,
) -> Result<Option<Replay>, BenchError> {
    let stored = results.trial(id)?;
    let stored_path = results.path_of(id)?;
    let trial = &stored.record.trial;
    let source = source_of(results, &trial.scenario, &trial.scenario_hash, source)?;
    let unknown = || BenchError::UnknownCall { planner: trial.planner.clone() };
    let call = results.planner_source(&trial.planner, &trial.settings)?.ok_or_else(unknown)?;
    let call: PlannerCall = serde_json::from_str(&call).map_err(|_| unknown())?;
    let is_built_in = matches!(call, PlannerCall::BuiltIn { .. });
    if !is_built_in && !allow_exec {
        return Err(BenchError::ForeignCommand { id, command: call.command() });
    }
    let iterations = stored.record.statistics.iterations;
    let asked = if is_built_in && !is_lost(&stored) {
        let time_limit_s = trial.time_limit_s * TIME_FACTOR;
        Trial { iteration_limit: Some(iterations), time_limit_s, ..trial.clone() }
    } else {
        trial.clone()
    };
    let question = Question { trial: asked, source, call, judge_both: false, measure_clearance: false };
    let Some((mut record, path)) = ask_once(&question, settings, results.path(), stop)? else {
        return Ok(None);
    };
    record.trial = trial.clone();
    let bits = |path: &[Vec<f64>]| -> Vec<Vec<u64>> {
        path.iter().map(|q| q.iter().map(|value| value.to_bits()).collect()).collect()
    };
    let is_same_path = bits(&path) == bits(&stored_path);
    let work = |record: &TrialRecord| (record.statistics.iterations, record.statistics.nodes);
    let is_same_search = work(&record) == work(&stored.record);
    Ok(Some(Replay { stored, record, path, is_same_path, is_same_search }))
}

/// Returns true if the worker was lost with the trial, so that its iterations are unknown.
fn is_lost(stored: &StoredTrial) -> bool {
    use crate::TrialOutcome::{Crashed, Hung, Killed, OutOfMemory, Undecided};
    matches!(stored.record.outcome, Crashed | Hung | OutOfMemory | Killed | Undecided)
}

/// Returns the source of a scenario of the results, identified by its id and hash, after checking its content: `given`,
/// otherwise the source in the results, otherwise its id.
///
/// # Errors
/// [`BenchError::OtherScenario`] if the scenario has changed; [`BenchError::Database`].
pub fn source_of(
    results: &Results,
    scenario: &str,
    scenario_hash: &str,
    given: Option<&str>,
) -> Result<String, BenchError> {
    let is_it = |source: &str| Identity::of(source).is_ok_and(|identity| identity.sha256 == scenario_hash);
    let noted = results
        .scenarios()?
        .into_iter()
        .find(|known| known.scenario == scenario && known.scenario_hash == scenario_hash);
    let source = given.map(str::to_owned).or(noted.map(|known| known.source));
    let source = source.unwrap_or_else(|| scenario.to_owned());
    if is_it(&source) {
        return Ok(source);
    }
    Err(BenchError::OtherScenario { scenario: scenario.to_owned(), source_name: source })
}
