//! Interface to Slurm through its command-line tools.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::Path;
use std::process::{Command, Output};

use cranny_file::system::installed_command;

use crate::failure::Failure;

/// State in Slurm of an array task that has not ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TaskState {
    Running,
    Waiting,
}

/// Returns true if the commands of Slurm are installed on this machine.
pub fn is_there() -> bool {
    installed_command("sbatch")
        .and_then(|mut sbatch| sbatch.arg("--version").output())
        .is_ok_and(|output| output.status.success())
}

/// Submits a script and returns its job number.
pub fn submit(options: &[String], script: &Path) -> Result<String, Failure> {
    let said = output_of("sbatch", |sbatch| sbatch.arg("--parsable").args(options).arg(script))?;
    // The name of the cluster follows after a semicolon.
    Ok(said.trim().split(';').next().unwrap_or_default().to_owned())
}

/// Returns the waiting and running array tasks, by their number.
pub fn active_tasks(jobs: &[String]) -> Result<BTreeMap<u64, TaskState>, Failure> {
    if jobs.is_empty() {
        return Ok(BTreeMap::new());
    }
    let jobs = format!("--jobs={}", jobs.join(","));
    let asked = ["--noheader", "--array", "--format=%K|%T", &jobs];
    let listing = match output_of("squeue", |squeue| squeue.args(asked)) {
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

/// Runs a command of Slurm, to which `fill` adds its arguments, and returns what it prints.
fn output_of(name: &str, fill: impl FnOnce(&mut Command) -> &mut Command) -> Result<String, Failure> {
    let fault = |reason: String| Failure::Slurm { command: name.to_owned(), reason };
    let run = installed_command(name).and_then(|mut command| fill(&mut command).output());
    let Output { status, stdout, stderr } = run.map_err(|reason| {
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
