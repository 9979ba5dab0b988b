//! What a campaign and its workers say to each other: one JSON document a line.

use std::path::PathBuf;

use cranny_plan::Statistics;
use serde::{Deserialize, Serialize};

use crate::{Question, TrialOutcome};

/// What a worker is asked.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Request {
    pub question: Question,
    /// Where scenarios are exported to for the programs of others.
    pub exports: PathBuf,
    /// What the program of others may take, in bytes.
    pub memory_limit_bytes: u64,
}

/// What a worker answers, in this order; [`Message::Refused`] in place of any of them.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Message {
    /// The problem is there, and the search begins.
    Opened,
    /// The search has ended, and the path is judged.
    Planned,
    /// How the trial went.
    Answered(Box<TrialAnswer>),
    /// The trial cannot be run at all: what is wrong with the question.
    Refused(String),
}

/// How a trial went, with the planner's own path.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrialAnswer {
    pub outcome: TrialOutcome,
    pub detail: Option<String>,
    pub statistics: Statistics,
    pub path_length: Option<f64>,
    pub clearance_m: Option<f64>,
    pub grasp: Option<usize>,
    pub grasp_score: Option<f64>,
    pub also_solved: Option<bool>,
    pub path: Vec<Vec<f64>>,
}

impl TrialAnswer {
    /// Of a trial that ended without a path.
    pub fn without_path(outcome: TrialOutcome, detail: Option<String>, statistics: Statistics) -> Self {
        Self {
            outcome,
            detail,
            statistics,
            path_length: None,
            clearance_m: None,
            grasp: None,
            grasp_score: None,
            also_solved: None,
            path: Vec::new(),
        }
    }
}
