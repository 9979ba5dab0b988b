use std::path::PathBuf;

use cranny_scenario::ScenarioError;
use cranny_solve::SolveError;

/// Error of a plan file or a file of way points. The message is self-contained: it has file and line if there are any.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordError {
    /// A way point of a plan has the wrong number of values.
    #[error("{}: way point {waypoint} has {actual} values instead of {expected}", path.display())]
    Waypoint {
        /// The plan file.
        path: PathBuf,
        /// Index of the way point, from 0.
        waypoint: usize,
        /// Expected number of values.
        expected: usize,
        /// Number of values found.
        actual: usize,
    },
    /// A plan without a path.
    #[error("{}: the plan has no path (stated outcome of its search: {outcome})", path.display())]
    NoPath {
        /// The plan file.
        path: PathBuf,
        /// Outcome of its search.
        outcome: &'static str,
    },
    /// A file with an unknown ending.
    #[error("{}: cannot tell what this file is (known endings: .plan.json, .csv, .try)", path.display())]
    WaypointFormat {
        /// The file.
        path: PathBuf,
    },
    /// A plan to be written has a number that JSON cannot represent: infinite, or not a number.
    #[error("{}: not written, because '{field}' holds a number that is not finite", path.display())]
    NotFinite {
        /// The file.
        path: PathBuf,
        /// Field of the plan.
        field: &'static str,
    },
    /// A file that cannot be read or written, or the scenario of a plan that cannot be opened.
    #[error(transparent)]
    Scenario(Box<ScenarioError>),
    /// The path, or the way points, are malformed.
    #[error(transparent)]
    Path(#[from] cranny_path::PathError),
    /// The task of a plan is malformed.
    #[error(transparent)]
    Task(#[from] cranny_task::TaskError),
    /// An option does not fit another one, or the problem.
    #[error("{field}: {problem}")]
    PlanOptions {
        /// Name of the option, as in flags and keywords.
        field: &'static str,
        /// The fault, with a hint.
        problem: String,
    },
    /// Error of the planner, the audit or the timing.
    #[error(transparent)]
    Plan(#[from] cranny_plan::PlanError),
}

impl From<ScenarioError> for RecordError {
    fn from(fault: ScenarioError) -> Self {
        Self::Scenario(Box::new(fault))
    }
}

impl From<SolveError> for RecordError {
    fn from(fault: SolveError) -> Self {
        match fault {
            SolveError::Request { field, problem } => Self::PlanOptions { field, problem },
            SolveError::Plan(fault) => Self::Plan(fault),
        }
    }
}
