use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use crate::asked::planner_call::{computed_checksum, hexadecimal};
use crate::{BenchError, Schedule};

/// Content of a campaign that each machine running a shard of it must match.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// Version of Cranny, and SHA-256 of the program.
    pub cranny: (String, String),
    /// SHA-256 of each scenario, by its id.
    pub scenarios: BTreeMap<String, String>,
    /// Settings of each planner, by its name, with the SHA-256 of the files of its command and the demands on paths.
    pub planners: BTreeMap<String, String>,
    /// Number of trials of all shards together.
    pub trials: usize,
    /// SHA-256 of the trials, with their seeds and limits.
    pub trials_sha256: String,
}

impl Manifest {
    /// Returns the manifest of a whole campaign that the program in this file runs.
    pub fn of(schedule: &Schedule, program: &Path) -> Self {
        let mut sum = Sha256::new();
        let mut planners = BTreeMap::new();
        for question in &schedule.questions {
            let trial = &question.trial;
            sum.update(trial.key());
            sum.update("\n");
            planners.entry(trial.planner.clone()).or_insert_with(|| trial.settings.clone());
        }
        let scenarios = schedule.scenarios.iter();
        Self {
            cranny: (env!("CARGO_PKG_VERSION").to_owned(), computed_checksum(program)),
            scenarios: scenarios
                .map(|source| (source.scenario.clone(), source.scenario_hash.clone()))
                .collect(),
            planners,
            trials: schedule.questions.len(),
            trials_sha256: hexadecimal(&sum.finalize()),
        }
    }

    /// Checks that this manifest, computed here, equals the distributed one.
    ///
    /// # Errors
    /// [`BenchError::OtherCampaign`], which names the first difference.
    pub fn check(&self, handed_out: &Self) -> Result<(), BenchError> {
        let other = |(name, content): (&String, &String), all: &BTreeMap<String, String>| {
            (all.get(name) != Some(content)).then(|| name.clone())
        };
        let scenario = handed_out.scenarios.iter().find_map(|one| other(one, &self.scenarios));
        let planner = handed_out.planners.iter().find_map(|one| other(one, &self.planners));
        let what = if self.cranny != handed_out.cranny {
            format!("the program (version {} submitted, version {} here)", handed_out.cranny.0, self.cranny.0)
        } else if let Some(scenario) = scenario {
            format!("the scenario {scenario}")
        } else if let Some(planner) = planner {
            format!("the planner {planner}, its settings or the files of its command")
        } else if self.trials_sha256 != handed_out.trials_sha256 {
            "the list of trials (scenarios, planners, seeds, limits)".to_owned()
        } else {
            return Ok(());
        };
        Err(BenchError::OtherCampaign { what })
    }
}
