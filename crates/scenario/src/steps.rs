use cranny_plan::AfterPlacing;

use crate::TargetPhysics;

/// A step of a task: something is picked, and put down elsewhere.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// What is picked: the target, or an obstacle.
    pub pick: String,
    /// Where it is put down: a place of the scenario.
    pub place: String,
    /// Where the robot goes then.
    pub then: AfterPlacing,
    /// How an obstacle that is picked weighs and slides; the target has its own.
    pub physics: TargetPhysics,
}
