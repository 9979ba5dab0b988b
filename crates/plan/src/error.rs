use cranny_file::did_you_mean;
use cranny_path::PathError;

/// A search that cannot begin. That it finds no path is an outcome, not an error.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    /// A planner is named that does not exist.
    #[error("there is no planner '{name}' (there are: {known}){}", did_you_mean(name, known.split(", ")))]
    UnknownPlanner {
        /// The name asked for.
        name: String,
        /// The names that there are.
        known: String,
    },
    /// A registry knows a planner of that name already.
    #[error("there is a planner '{name}' already")]
    TwicePlanner {
        /// The name.
        name: &'static str,
    },
    /// A planner has no such setting.
    #[error("planner '{planner}' has no setting '{setting}' (there are: {known}){}", did_you_mean(setting, known.split(", ")))]
    UnknownSetting {
        /// Which planner.
        planner: String,
        /// The setting asked for.
        setting: String,
        /// The settings that there are.
        known: String,
    },
    /// A setting of a planner has a value that is none.
    #[error("a setting of planner '{planner}': {problem}")]
    Setting {
        /// Which planner.
        planner: String,
        /// Which setting, what is wrong with it, and what would fit.
        problem: String,
    },
    /// The file of a roadmap is none of this robot.
    #[error("{}: no roadmap that can be used: {problem}", path.display())]
    Roadmap {
        /// The file.
        path: std::path::PathBuf,
        /// What is wrong with it.
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
    /// A malformed task is one, wherever it was found.
    fn from(fault: PathError) -> Self {
        match fault {
            PathError::Task(fault) => Self::Task(fault),
            fault => Self::Path(fault),
        }
    }
}
