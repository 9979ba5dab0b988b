use std::path::PathBuf;

use cranny_explore::ExploreError;
use cranny_path::PathError;
use cranny_record::RecordError;
use cranny_scenario::ScenarioError;
use cranny_solve::SolveError;
use cranny_task::TaskError;

/// Bad input, reported once; exit code 2.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// Invalid scenario.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// Invalid plan file or way points.
    #[error(transparent)]
    Record(RecordError),
    /// Invalid planning problem.
    #[error(transparent)]
    Plan(#[from] cranny_plan::PlanError),
    /// Error in a campaign or its results.
    #[error(transparent)]
    Bench(#[from] cranny_bench::BenchError),
    /// Error in a recipe or a set of demonstrations.
    #[error(transparent)]
    Dataset(#[from] cranny_dataset::DatasetError),
    /// Input that cannot be simulated.
    #[error(transparent)]
    Sim(#[from] cranny_sim::SimError),
    /// Robot that cannot be set up.
    #[error(transparent)]
    Setup(cranny_setup::SetupError),
    /// Error in rendering, or in the file of a picture.
    #[error(transparent)]
    View(#[from] cranny_view::ViewError),
    /// Invalid camera, depth image or point cloud.
    #[error(transparent)]
    Sense(#[from] cranny_sense::SenseError),
    /// Exploration that cannot begin.
    #[error(transparent)]
    Explore(ExploreError),
    /// Server that cannot start.
    #[error(transparent)]
    Server(#[from] cranny_local_server::ServerError),
    /// Invalid value or use of a flag.
    #[error("--{flag}: {problem}")]
    Flag {
        /// Name of the flag.
        flag: &'static str,
        /// Description of the problem and of valid values.
        problem: String,
    },
    /// Request that does not fit the problem.
    #[error("--{}: {problem}", field.replace('_', "-"))]
    Request {
        /// Field of the request, which is named like its flag.
        field: &'static str,
        /// Description of the problem and of valid values.
        problem: String,
    },
    /// Failed command of Slurm.
    #[error("{command}: {reason}; without Slurm: bench slurm --write-only, or bench run --shard")]
    Slurm {
        /// Name of the command.
        command: String,
        /// Message of the command.
        reason: String,
    },
    /// File that a command cannot process.
    #[error("{}: {problem}", path.display())]
    File {
        /// Path of the file.
        path: PathBuf,
        /// Description of the problem and of valid content.
        problem: String,
    },
    /// Output file in a folder that does not exist.
    #[error("{}: the folder does not exist, so nothing can be written there", path.display())]
    NoFolder {
        /// Requested file.
        path: PathBuf,
    },
    /// Scenario without a target to grasp.
    #[error("{id}: the scenario has no target, so there is nothing to grasp")]
    NoTarget {
        /// Id of the scenario.
        id: String,
    },
    /// Output file that would overwrite a file of another kind.
    #[error(
        "{}: exists already and is no {kind}; give another name, or --force to write over it",
        path.display()
    )]
    OtherKind {
        /// Existing file.
        path: PathBuf,
        /// Kind of file to be written.
        kind: &'static str,
    },
    /// Existing results of a campaign, or another database, in the place of an output.
    #[error("{}: it is a database, such as results of a campaign, which nothing overwrites; give another name", path.display())]
    Database {
        /// Existing file.
        path: PathBuf,
    },
    /// Standard output that cannot be written to.
    #[error("cannot write the answer: {0}")]
    Output(#[from] std::io::Error),
}

impl From<ExploreError> for Failure {
    fn from(fault: ExploreError) -> Self {
        match fault {
            ExploreError::Scenario(fault) => Self::Scenario(fault),
            ExploreError::Sense(fault) => Self::Sense(fault),
            ExploreError::Solve(fault) => fault.into(),
            ExploreError::Plan(fault) => Self::Plan(fault),
            fault => Self::Explore(fault),
        }
    }
}

impl From<SolveError> for Failure {
    fn from(fault: SolveError) -> Self {
        match fault {
            SolveError::Request { field, problem } => Self::Request { field, problem },
            SolveError::Plan(fault) => Self::Plan(fault),
        }
    }
}

impl From<RecordError> for Failure {
    fn from(fault: RecordError) -> Self {
        match fault {
            RecordError::PlanOptions { field, problem } => Self::Request { field, problem },
            RecordError::Scenario(fault) => Self::Scenario(*fault),
            fault => Self::Record(fault),
        }
    }
}

impl From<TaskError> for Failure {
    fn from(fault: TaskError) -> Self {
        Self::Plan(fault.into())
    }
}

impl From<PathError> for Failure {
    fn from(fault: PathError) -> Self {
        Self::Plan(fault.into())
    }
}
