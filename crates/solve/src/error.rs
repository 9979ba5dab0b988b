use cranny_path::PathError;
use cranny_plan::PlanError;
use cranny_task::TaskError;

/// Why there is no answer.
#[derive(Debug, thiserror::Error)]
pub enum SolveError {
    /// A field of the request does not go with the problem, or is out of its range.
    #[error("{field}: {problem}")]
    Request {
        /// The field of [`Request`](crate::Request); flags and keywords have the same name.
        field: &'static str,
        /// What is wrong, with a hint.
        problem: String,
    },
    /// What the planner, the judge or the timing says.
    #[error(transparent)]
    Plan(#[from] PlanError),
}

impl From<TaskError> for SolveError {
    fn from(fault: TaskError) -> Self {
        Self::Plan(fault.into())
    }
}

impl From<PathError> for SolveError {
    fn from(fault: PathError) -> Self {
        Self::Plan(fault.into())
    }
}
