//! Interface to Slurm through its command-line tools.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::Path;
use std::process::{Command, Output};

use crate::failure::Failure;

/// State in Slurm of an array task that has not ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TaskState {
    Running,
    Waiting,
}

/// Returns true if the commands of Slurm are installed on this machine.
pub fn is_there() -> bool {
    Command::new("sbatch").arg("--version").output().is_ok_and(|output| output.status.success())
}

/// Submits a script and returns its job number.
pub fn submit(options: &[String], script: &Path) -> Result<String, Failure> {
    let mut command = Command::new("sbatch");
    command.arg("--parsable").args(options).arg(script);
    let said = done(&mut command)?;
    // The name of the cluster follows after a semicolon.
    Ok(said.trim().split(';').next().unwrap_or_default().to_owned())
}

/// Returns the waiting and running array tasks, by their number.
pub fn active_tasks(jobs: &[String]) -> Result<BTreeMap<u64, TaskState>, Failure> {
    if jobs.is_empty() {
        return Ok(BTreeMap::new());
    }
    let mut command = Command::new("squeue");
    command.args(["--noheader", "--array", "--format=%K|%T"]).arg(format!("--jobs={}", jobs.join(",")));
    let listing = match done(&mut command) {
        // Slurm forgets jobs that ended a while ago.
        Err(Failure::Slurm { reason, .. }) if reason.contains("Invalid job id") => String::new(),
        listing => listing?,
    };
    let task = |line: &str| {
        let (task, state) = line.trim().split_once('|')?;
        let is_waiting =
            matches!(state, "PENDING" | "REQUEUED" | "REQUEUE_HOLD" | "SUSPENDED" | "CONFIGURING");
        let is_over = matches!(
            state,
            "COMPLETED"
                | "CANCELLED"
                | "FAILED"
                | "TIMEOUT"
                | "NODE_FAIL"
                | "PREEMPTED"
                | "OUT_OF_MEMORY"
                | "BOOT_FAIL"
                | "DEADLINE"
        );
        let state = if is_waiting { TaskState::Waiting } else { TaskState::Running };
        (!is_over).then_some((task.parse().ok()?, state))
    };
    Ok(listing.lines().filter_map(task).collect())
}

fn done(command: &mut Command) -> Result<String, Failure> {
    let name = command.get_program().to_string_lossy().into_owned();
    let fault = |reason: String| Failure::Slurm { command: name.clone(), reason };
    let Output { status, stdout, stderr } = command.output().map_err(|reason| {
        fault(match reason.kind() {
            ErrorKind::NotFound => "not found in PATH".to_owned(),
            _ => reason.to_string(),
        })
    })?;
    if status.success() {
        return Ok(String::from_utf8_lossy(&stdout).into_owned());
    }
    let said = String::from_utf8_lossy(&stderr);
    let said: Vec<&str> = said.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    Err(fault(said.join("; ")))
}
