use cranny_path::PathError;
use cranny_plan::PlanError;
use cranny_scenario::ScenarioError;
use cranny_sense::SenseError;
use cranny_solve::SolveError;
use cranny_task::TaskError;

/// Errors of an exploration.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExploreError {
    /// The scenario is a map of views already.
    #[error("{id}: the scenario has `seen` space already; explore the true scenario, which is rendered")]
    HasSeen {
        /// Id of the scenario.
        id: String,
    },
    /// The criterion proves nothing.
    #[error("{id}: seen space is explored under the criterion 'exact' alone")]
    Criterion {
        /// Id of the scenario.
        id: String,
    },
    /// No camera is on a link of the robot.
    #[error("no camera is on a link of the robot; a file of cameras names it by `frame: link NAME`")]
    NoHandCamera,
    /// A camera is on a link that moves relative to the hand.
    #[error(
        "camera '{camera}' moves relative to the hand; a camera in hand is on a link that is fixed to the hand"
    )]
    LooseCamera {
        /// Name of the camera.
        camera: String,
    },
    /// The scenario is invalid.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// A camera is invalid, or cannot be placed.
    #[error(transparent)]
    Sense(#[from] SenseError),
    /// The problem cannot be solved as requested.
    #[error(transparent)]
    Solve(#[from] SolveError),
    /// A search is invalid.
    #[error(transparent)]
    Plan(#[from] PlanError),
}

impl From<TaskError> for ExploreError {
    fn from(fault: TaskError) -> Self {
        Self::Plan(fault.into())
    }
}

impl From<PathError> for ExploreError {
    fn from(fault: PathError) -> Self {
        Self::Plan(fault.into())
    }
}
