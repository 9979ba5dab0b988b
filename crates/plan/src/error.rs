use cranny_file::did_you_mean;
use cranny_path::PathError;

/// Error of a search that cannot begin. Finding no path is an outcome, not an error.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    /// The requested planner does not exist.
    #[error("unknown planner '{name}' (known: {known}){}", did_you_mean(name, known.split(", ")))]
    UnknownPlanner {
        /// Requested name.
        name: String,
        /// Names of the existing planners.
        known: String,
    },
    /// The registry has a planner of that name already.
    #[error("there is a planner '{name}' already")]
    DuplicatePlanner {
        /// Name of the planner.
        name: &'static str,
    },
    /// A planner has no such setting.
    #[error("planner '{planner}' has no setting '{setting}' (known: {known}){}", did_you_mean(setting, known.split(", ")))]
    UnknownSetting {
        /// Name of the planner.
        planner: String,
        /// Requested setting.
        setting: String,
        /// Names of the existing settings.
        known: String,
    },
    /// A setting of a planner has an invalid value.
    #[error("a setting of planner '{planner}': {problem}")]
    Setting {
        /// Name of the planner.
        planner: String,
        /// Name of the setting, its fault, and its valid range.
        problem: String,
    },
    /// The roadmap file cannot be used for this robot.
    #[error("{}: no roadmap that can be used: {problem}", path.display())]
    Roadmap {
        /// Path of the file.
        path: std::path::PathBuf,
        /// Description of the fault.
        problem: String,
    },
    /// The task is malformed.
    #[error(transparent)]
    Task(#[from] cranny_task::TaskError),
    /// The path is malformed.
    #[error(transparent)]
    Path(PathError),
}

impl From<PathError> for PlanError {
    /// Keeps a malformed task as [`Self::Task`], regardless of its origin.
    fn from(fault: PathError) -> Self {
        match fault {
            PathError::Task(fault) => Self::Task(fault),
            fault => Self::Path(fault),
        }
    }
}
