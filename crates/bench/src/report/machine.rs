use std::collections::BTreeMap;

use serde::Serialize;

use crate::{Run, StoredTrial};

/// On what trials ran: runs that only their times tell apart are one.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Machine {
    /// Name of the machine.
    pub machine: String,
    /// Its processor.
    pub processor: String,
    /// How many trials ran at a time; times are true where it is one.
    pub workers: usize,
    /// Version of Cranny.
    pub version: String,
    /// The commit that it was built from, if known.
    pub commit: Option<String>,
    /// How many runs there were.
    pub runs: usize,
    /// How many trials they gave.
    pub trials: usize,
    /// When the first began: UTC, ISO 8601.
    pub first_began: String,
    /// When the last began.
    pub last_began: String,
    /// The commands, each once, in the order of the runs.
    pub commands: Vec<String>,
}

/// The machines of the runs that gave trials, in the order of their first runs.
pub fn machines(runs: &[Run], trials: &[StoredTrial]) -> Vec<Machine> {
    let mut counts: BTreeMap<u64, usize> = BTreeMap::new();
    for trial in trials {
        *counts.entry(trial.run).or_default() += 1;
    }
    let mut machines: Vec<Machine> = Vec::new();
    for run in runs {
        let Some(&count) = counts.get(&run.id) else { continue };
        let own = Machine::of(run);
        let known = machines.iter().position(|machine| machine.identity() == own.identity());
        let place = known.unwrap_or(machines.len());
        if known.is_none() {
            machines.push(own);
        }
        let machine = &mut machines[place];
        machine.runs += 1;
        machine.trials += count;
        machine.first_began = machine.first_began.clone().min(run.began.clone());
        machine.last_began = machine.last_began.clone().max(run.began.clone());
        if !machine.commands.contains(&run.information.command) {
            machine.commands.push(run.information.command.clone());
        }
    }
    machines
}

impl Machine {
    /// That of a run, which is not counted yet.
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

    fn identity(&self) -> (&str, &str, usize, &str, Option<&str>) {
        (&self.machine, &self.processor, self.workers, &self.version, self.commit.as_deref())
    }
}
