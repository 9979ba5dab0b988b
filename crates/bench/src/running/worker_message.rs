//! What a campaign and its workers say to each other: one JSON document a line.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::foreign::sandbox::Walls;
use crate::{Question, TrialRecord};

/// What a worker is asked.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Request {
    pub question: Question,
    /// Folder that scenarios are exported to for external planners; no other worker uses it.
    pub exports: PathBuf,
    /// Memory limit of the external planner, in bytes.
    pub memory_limit_bytes: u64,
    /// What stands around the worker and around that program.
    pub walls: Walls,
}

/// How a trial went, and the path that its planner gave.
pub type TrialRun = (TrialRecord, Vec<Vec<f64>>);

/// What a worker answers, in this order; [`Message::Refused`] in place of any of them.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Message {
    /// The problem is there, and the search begins.
    Opened,
    /// The search has ended, and the path is judged.
    Planned,
    /// How the trial went, and the planner's own path.
    Answered(Box<TrialRecord>, Vec<Vec<f64>>),
    /// The trial cannot be run at all: what is wrong with the question.
    Refused(String),
}
