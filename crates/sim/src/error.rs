use cranny_shape::ShapeError;

/// Errors of simulations.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SimError {
    /// A path has no timing.
    #[error("without limits of acceleration (a limits.yaml beside the URDF) the path has no times")]
    NoTimes,
    /// A hand has no moving fingers.
    #[error(
        "hand '{hand}' has no fingers that slide, so it cannot close: a suction cup or another tool is not simulated; for \
         fingers, a robot.yaml beside the URDF names their joints"
    )]
    NoFingers {
        /// Name of the hand.
        hand: String,
    },
    /// A finger has no stroke.
    #[error("finger {finger} of hand '{hand}' does not move: open and closed are the same place")]
    NoStroke {
        /// Name of the hand.
        hand: String,
        /// Number of the finger, from 1.
        finger: usize,
    },
    /// The closing force of a hand is not positive.
    #[error("hand '{hand}' closes with {force_n} N; the closing force must be a positive number of newtons")]
    ClosingForce {
        /// Name of the hand.
        hand: String,
        /// Closing force, in newtons.
        force_n: f64,
    },
    /// A shape cannot be converted to convex pieces.
    #[error("{of}: {reason}")]
    Shape {
        /// Name of the body.
        of: String,
        /// Error of the shape.
        reason: ShapeError,
    },
    /// A parameter of the physics or the course is out of range.
    #[error("the {figure} of a simulation must be {range}, but is {value}")]
    Figure {
        /// Name of the parameter.
        figure: &'static str,
        /// Invalid value.
        value: f64,
        /// Valid range.
        range: &'static str,
    },
    /// The data of a scenario on its target are insufficient.
    #[error(transparent)]
    Scenario(#[from] cranny_scenario::ScenarioError),
    /// No plan can be searched for.
    #[error(transparent)]
    Solve(#[from] cranny_solve::SolveError),
    /// A plan cannot be executed.
    #[error(transparent)]
    Plan(#[from] cranny_plan::PlanError),
    /// The scenario has no target.
    #[error("{id}: the scenario has no target, so there is nothing to grasp")]
    NoTarget {
        /// Id of the scenario.
        id: String,
    },
    /// An object does not have this stable pose.
    #[error("{object} has {count} stable poses, counted from 0, and none of number {index}")]
    NoPose {
        /// Name of the object.
        object: String,
        /// Requested index.
        index: usize,
        /// Number of stable poses.
        count: usize,
    },
}
