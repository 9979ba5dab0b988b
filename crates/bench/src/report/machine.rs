use std::collections::BTreeMap;

use serde::Serialize;

use crate::{Run, RunInformation, StoredTrial};

/// Machine and conditions of trials; runs that differ only in their times are combined.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Machine {
    /// Name of the machine.
    pub machine: String,
    /// Name of its processor.
    pub processor: String,
    /// Number of simultaneous trials; times are undisturbed only with one. 0 if unknown.
    pub workers: usize,
    /// Version of Cranny.
    pub version: String,
    /// Commit of the build, if known.
    pub commit: Option<String>,
    /// Number of runs.
    pub runs: usize,
    /// Number of their trials.
    pub trials: usize,
    /// Start of the first run: UTC, ISO 8601.
    pub first_began: String,
    /// Start of the last run: UTC, ISO 8601.
    pub last_began: String,
    /// The first distinct commands, at most 20, in the order of the runs.
    pub commands: Vec<String>,
}

/// Maximum number of commands of a machine: each shard of a campaign has one of its own.
const MOST_COMMANDS: usize = 20;

/// Returns the machines of the runs with trials, in the order of their first runs.
pub fn machines(runs: &[Run], trials: &[StoredTrial]) -> Vec<Machine> {
    let mut counts: BTreeMap<u64, usize> = BTreeMap::new();
    for trial in trials {
        *counts.entry(trial.run).or_default() += 1;
    }
    let mut machines: Vec<Machine> = Vec::new();
    let mut places = BTreeMap::new();
    for run in runs {
        let Some(&count) = counts.get(&run.id) else { continue };
        let place = *places.entry(identity(&run.information)).or_insert_with(|| {
            machines.push(Machine::of(run));
            machines.len() - 1
        });
        let machine = &mut machines[place];
        machine.runs += 1;
        machine.trials += count;
        machine.first_began = machine.first_began.clone().min(run.began.clone());
        machine.last_began = machine.last_began.clone().max(run.began.clone());
        let command = &run.information.command;
        if machine.commands.len() < MOST_COMMANDS && !machine.commands.contains(command) {
            machine.commands.push(command.clone());
        }
    }
    machines
}

/// Returns the information that runs of one [`Machine`] share.
fn identity(run: &RunInformation) -> (&str, &str, usize, &str, Option<&str>) {
    (&run.machine, &run.processor, run.workers, &run.version, run.commit.as_deref())
}

impl Machine {
    /// Returns the entry of a run, with counts of zero.
    fn of(run: &Run) -> Self {
        let information = run.information.clone();
        Self {
            machine: information.machine,
            processor: information.processor,
            workers: information.workers,
            version: information.version,
            commit: information.commit,
            runs: 0,
            trials: 0,
            first_began: run.began.clone(),
            last_began: run.began.clone(),
            commands: Vec::new(),
        }
    }
}
