use std::path::PathBuf;

use cranny_path::PathError;
use cranny_record::RecordError;
use cranny_scenario::ScenarioError;
use cranny_solve::SolveError;
use cranny_task::TaskError;

/// Bad input: said once, exit 2.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// The scenario.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// A plan file or way points.
    #[error(transparent)]
    Record(RecordError),
    /// The problem.
    #[error(transparent)]
    Plan(#[from] cranny_plan::PlanError),
    /// A campaign or its results.
    #[error(transparent)]
    Bench(#[from] cranny_bench::BenchError),
    /// What cannot be simulated.
    #[error(transparent)]
    Sim(#[from] cranny_sim::SimError),
    /// A robot that cannot be set up.
    #[error(transparent)]
    Setup(cranny_setup::SetupError),
    /// What is drawn, or the file of a picture.
    #[error(transparent)]
    View(#[from] cranny_view::ViewError),
    /// A flag that does not fit.
    #[error("--{flag}: {problem}")]
    Flag {
        /// Which flag.
        flag: &'static str,
        /// What is wrong with it, and what would fit.
        problem: String,
    },
    /// What is asked does not go with the problem.
    #[error("--{}: {problem}", field.replace('_', "-"))]
    Request {
        /// The field of the request, which is named like its flag.
        field: &'static str,
        /// What is wrong with it, and what would fit.
        problem: String,
    },
    /// A command of Slurm does not do what it is asked.
    #[error("{command}: {reason}; without Slurm: bench slurm --write-only, or bench run --shard")]
    Slurm {
        /// The command.
        command: String,
        /// What it says.
        reason: String,
    },
    /// A file that a command cannot work with.
    #[error("{}: {problem}", path.display())]
    File {
        /// Which file.
        path: PathBuf,
        /// What is wrong with it, and what would fit.
        problem: String,
    },
    /// A file would be written where it cannot be.
    #[error("{}: the folder does not exist, so nothing can be written there", path.display())]
    NoFolder {
        /// The file that was asked for.
        path: PathBuf,
    },
    /// Grasps of nothing.
    #[error("{id}: the scenario has no target, so there is nothing to grasp")]
    NoTarget {
        /// The scenario.
        id: String,
    },
    /// What somebody else wrote, or another command, would be lost.
    #[error(
        "{}: exists already and is no {kind}; give another name, or --force to write over it",
        path.display()
    )]
    OtherKind {
        /// The file that is there.
        path: PathBuf,
        /// What would be written.
        kind: &'static str,
    },
    /// Standard output is gone.
    #[error("cannot write the answer: {0}")]
    Output(#[from] std::io::Error),
    /// Ctrl-C cannot be listened to.
    #[error("cannot listen for Ctrl-C: {0}")]
    Signal(#[from] ctrlc::Error),
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
            RecordError::Ask { field, problem } => Self::Request { field, problem },
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
