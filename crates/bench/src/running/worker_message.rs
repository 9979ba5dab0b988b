//! Messages between a campaign and its workers: one JSON document a line.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::foreign::sandbox::Isolation;
use crate::{Question, TrialRecord, WorkerProgram};

/// Request to a worker.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Request {
    pub question: Question,
    /// Folder that scenarios are exported to for external planners; no other worker uses it.
    pub exports: PathBuf,
    /// Results of the campaign, which no external planner sees.
    pub results: PathBuf,
    /// Memory limit of the external planner, in bytes.
    pub memory_limit_bytes: u64,
    /// Isolation of the worker and of that program.
    pub isolation: Isolation,
    /// Program of the process that encloses it.
    pub worker: WorkerProgram,
}

/// Record of a trial and path of its planner.
pub type TrialRun = (TrialRecord, Vec<Vec<f64>>);

/// Answers of a worker, in this order; [`Message::Refused`] may replace any of them, [`Message::NotStarted`] the first one.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Message {
    /// The problem and the enclosure of an external program are ready, and the search begins.
    Opened,
    /// The search has ended, and the path is judged.
    Planned,
    /// Record of the trial and path of its planner.
    Answered(Box<TrialRecord>, Vec<Vec<f64>>),
    /// The trial cannot be run at all; with the reason.
    Refused(String),
    /// The trial cannot be started now, for lack of processes, memory or disk space; with the reason.
    NotStarted(String),
}
