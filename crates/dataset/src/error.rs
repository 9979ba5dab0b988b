use std::path::PathBuf;

use cranny_plan::PlanError;
use cranny_record::RecordError;
use cranny_scenario::ScenarioError;
use cranny_solve::SolveError;

/// Errors of recipes and data sets. A query without a path is no such error: it is a row with an outcome.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DatasetError {
    /// A file cannot be read.
    #[error("{}: {reason}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Message of the operating system.
        reason: std::io::Error,
    },
    /// A recipe has a fault.
    #[error("{}:{line}: {problem}", path.display())]
    Recipe {
        /// The file.
        path: PathBuf,
        /// Line of the fault, from 1.
        line: u64,
        /// The fault, with a hint.
        problem: String,
    },
    /// A folder is no data set, or a file of it is damaged.
    #[error("{}: {problem}", path.display())]
    Content {
        /// The file or folder.
        path: PathBuf,
        /// The fault, with a hint.
        problem: String,
    },
    /// A folder holds a data set of another recipe, version or shard.
    #[error(
        "{}: holds {found}, but this run would write {expected}; name another folder",
        path.display()
    )]
    OtherDataset {
        /// The folder.
        path: PathBuf,
        /// Description of its data set.
        found: String,
        /// Description of the requested one.
        expected: String,
    },
    /// Shards that do not belong together, or not all of them.
    #[error("{}: {problem}", path.display())]
    Shards {
        /// Folder of a shard.
        path: PathBuf,
        /// The fault, with a hint.
        problem: String,
    },
    /// A row that the data set does not have, or that has no path.
    #[error("{}: row {row} {problem}", path.display())]
    Row {
        /// The folder.
        path: PathBuf,
        /// Index of the row.
        row: u64,
        /// The fault, with a hint.
        problem: String,
    },
    /// An export that cannot be made of this data set.
    #[error("{}: {problem}", path.display())]
    Export {
        /// The folder.
        path: PathBuf,
        /// The fault, with a hint.
        problem: String,
    },
    /// Invalid robot or scene, or a file that cannot be written.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// Cameras that do not fit, or a picture that cannot be written.
    #[error(transparent)]
    Sense(#[from] cranny_sense::SenseError),
    /// Files of a robot that cannot be read.
    #[error(transparent)]
    Robot(#[from] cranny_robot::RobotError),
    /// Invalid planner or setting.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// Invalid request.
    #[error(transparent)]
    Solve(#[from] SolveError),
    /// A plan file that cannot be written.
    #[error(transparent)]
    Record(#[from] RecordError),
}

impl From<cranny_task::TaskError> for DatasetError {
    fn from(fault: cranny_task::TaskError) -> Self {
        Self::Plan(fault.into())
    }
}

impl From<cranny_path::PathError> for DatasetError {
    fn from(fault: cranny_path::PathError) -> Self {
        Self::Plan(fault.into())
    }
}
