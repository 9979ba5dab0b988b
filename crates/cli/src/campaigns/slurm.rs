//! Talking to Slurm by its own commands.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::Path;
use std::process::{Command, Output};

use crate::failure::Failure;

/// What Slurm says of a task that has not ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TaskState {
    Running,
    Waiting,
}

/// Whether its commands are on this machine.
pub fn is_there() -> bool {
    Command::new("sbatch").arg("--version").output().is_ok_and(|output| output.status.success())
}

/// Hands a script over, and returns the number of its job.
pub fn submit(options: &[String], script: &Path) -> Result<String, Failure> {
    let mut command = Command::new("sbatch");
    command.arg("--parsable").args(options).arg(script);
    let said = done(&mut command)?;
    // After a semicolon the name of the cluster follows.
    Ok(said.trim().split(';').next().unwrap_or_default().to_owned())
}

/// The tasks of arrays that wait or run, by their number.
pub fn active_tasks(jobs: &[String]) -> Result<BTreeMap<u64, TaskState>, Failure> {
    if jobs.is_empty() {
        return Ok(BTreeMap::new());
    }
    let mut command = Command::new("squeue");
    command.args(["--noheader", "--array", "--format=%K|%T"]).arg(format!("--jobs={}", jobs.join(",")));
    let listing = match done(&mut command) {
        // Jobs that ended a while ago are forgotten.
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

/// What a command of Slurm prints.
fn done(command: &mut Command) -> Result<String, Failure> {
    let name = command.get_program().to_string_lossy().into_owned();
    let fault = |reason: String| Failure::Slurm { command: name.clone(), reason };
    let Output { status, stdout, stderr } = command.output().map_err(|reason| {
        fault(match reason.kind() {
            ErrorKind::NotFound => "it is not on the PATH of this machine".to_owned(),
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
