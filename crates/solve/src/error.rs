use cranny_path::PathError;
use cranny_plan::PlanError;
use cranny_task::TaskError;

/// Reason why there is no answer.
#[derive(Debug, thiserror::Error)]
pub enum SolveError {
    /// A field of the request is out of range or does not fit the problem.
    #[error("{field}: {problem}")]
    Request {
        /// Name of the field of [`Request`](crate::Request), as in flags and keywords.
        field: &'static str,
        /// The fault, with a hint.
        problem: String,
    },
    /// Error of the planner, the audit or the timing.
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
