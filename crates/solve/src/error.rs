use cranny_plan::PlanError;

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
