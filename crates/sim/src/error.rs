use cranny_shape::ShapeError;

/// Why something cannot be simulated.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SimError {
    /// A path has no times.
    #[error("without limits of acceleration (a limits.yaml beside the URDF) the path has no times")]
    NoTimes,
    /// A hand has nothing that closes.
    #[error(
        "hand '{hand}' has no fingers that slide, so it cannot close (is there a robot.yaml beside the URDF that names \
         their joints?)"
    )]
    NoFingers {
        /// What it is called.
        hand: String,
    },
    /// A finger does not move.
    #[error("finger {finger} of hand '{hand}' does not move: open and closed are the same place")]
    NoStroke {
        /// What the hand is called.
        hand: String,
        /// The finger, from 1.
        finger: usize,
    },
    /// A hand presses with no force.
    #[error("hand '{hand}' closes with {force_n} N; the closing force must be a positive number of newtons")]
    ClosingForce {
        /// What it is called.
        hand: String,
        /// The force, in newtons.
        force_n: f64,
    },
    /// A shape cannot be made of convex pieces.
    #[error("{of}: {reason}")]
    Shape {
        /// Of what.
        of: String,
        /// What is wrong with it.
        reason: ShapeError,
    },
    /// A figure of the physics or the course is out of its range.
    #[error("the {figure} of a simulation must be {range}, but is {value}")]
    Figure {
        /// Which figure.
        figure: &'static str,
        /// The offending value.
        value: f64,
        /// What would fit.
        range: &'static str,
    },
    /// What a scenario says of its target is not enough.
    #[error(transparent)]
    Scenario(#[from] cranny_scenario::ScenarioError),
    /// No plan can be looked for.
    #[error(transparent)]
    Solve(#[from] cranny_solve::SolveError),
    /// A plan cannot be carried out.
    #[error(transparent)]
    Plan(#[from] cranny_plan::PlanError),
    /// There is nothing to grasp.
    #[error("{id}: the scenario has no target, so there is nothing to grasp")]
    NoTarget {
        /// The scenario.
        id: String,
    },
    /// An object has fewer stable poses.
    #[error("{object} has {count} stable poses, counted from 0, and none of number {index}")]
    NoPose {
        /// The object.
        object: String,
        /// The one that was asked for.
        index: usize,
        /// How many there are.
        count: usize,
    },
}
