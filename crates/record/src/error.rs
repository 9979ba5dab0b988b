use std::path::PathBuf;

use cranny_scenario::ScenarioError;
use cranny_solve::SolveError;

/// What can be wrong with a plan file or a file of way points. The message is complete in itself: file and line where there is one.
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
        /// How many values there should be.
        expected: usize,
        /// How many there are.
        actual: usize,
    },
    /// A plan of a search that found nothing.
    #[error("{}: the plan has no path; as stated, its search ended as {outcome}", path.display())]
    NoPath {
        /// The plan file.
        path: PathBuf,
        /// How its search ended.
        outcome: &'static str,
    },
    /// A file's ending says nothing about how to read it.
    #[error("{}: cannot tell what this file is (known endings: .plan.json, .csv, .try)", path.display())]
    WaypointFormat {
        /// The file.
        path: PathBuf,
    },
    /// A plan to be written holds a number that JSON cannot: infinite, or not a number.
    #[error("{}: not written, because '{field}' holds a number that is not finite", path.display())]
    NotFinite {
        /// The file.
        path: PathBuf,
        /// Which field of the plan.
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
    /// A word of what is asked does not go with another, or with the problem.
    #[error("{field}: {problem}")]
    Ask {
        /// The word; flags and keywords have the same name.
        field: &'static str,
        /// What is wrong, with a hint.
        problem: String,
    },
    /// The planner, the judge or the timing refuses.
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
            SolveError::Request { field, problem } => Self::Ask { field, problem },
            SolveError::Plan(fault) => Self::Plan(fault),
        }
    }
}
