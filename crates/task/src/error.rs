use cranny_file::{counted, did_you_mean};

/// A malformed task. A task without a solution is an outcome, not an error.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TaskError {
    /// A configuration has the wrong number of values.
    #[error("the {what} configuration has {}, but the robot has {}", counted(*actual, "value"), counted(*expected, "joint"))]
    JointCount {
        /// Name of the configuration.
        what: &'static str,
        /// Number of joints of the robot.
        expected: usize,
        /// Number of values given.
        actual: usize,
    },
    /// A configuration has a value that is infinite or not a number.
    #[error("the {what} configuration has a value for joint '{joint}' that is not a finite number")]
    NotFinite {
        /// Name of the configuration.
        what: &'static str,
        /// Name of the joint.
        joint: String,
    },
    /// A problem has no object that can be carried.
    #[error("to carry the target away, the problem needs {needs}")]
    NothingToCarry {
        /// The missing item.
        needs: &'static str,
    },
    /// A task names a placement goal that the problem does not have.
    #[error(
        "unknown place '{name}' to put the target down (known: {known}; see `places` in scenario.yaml){}",
        did_you_mean(name, known.split(", ").map(|known| known.trim_matches('\'')))
    )]
    UnknownPlace {
        /// The name that was requested.
        name: String,
        /// The available names.
        known: String,
    },
    /// A task names a region that the problem does not have.
    #[error(
        "unknown region '{name}' (known: {known}; see `regions` in scenario.yaml){}",
        did_you_mean(name, known.split(", ").map(|known| known.trim_matches('\'')))
    )]
    UnknownRegion {
        /// The name that was requested.
        name: String,
        /// The available names.
        known: String,
    },
    /// A region cannot be the goal of a problem.
    #[error("{problem}")]
    Region {
        /// The fault.
        problem: String,
    },
    /// An object cannot be put down at the requested goal.
    #[error("{problem}")]
    Place {
        /// The fault.
        problem: String,
    },
    /// A problem lacks the data for measuring grasps.
    #[error("planning without a set of grasps needs {needs}")]
    NoGraspMeasure {
        /// The missing item.
        needs: &'static str,
    },
    /// A planner needs a set of grasps.
    #[error(
        "a set of grasps is required, but the problem has none (planners that generate their own grasps: \
         grasp-reach, grasp-rrt)"
    )]
    NoGraspSet,
    /// A planner generates its own grasps and accepts no set of them.
    #[error(
        "planner '{planner}' generates its own grasps and accepts no set of grasps; leave the set out \
         (`--grasps none`)"
    )]
    GraspSet {
        /// Name of the planner.
        planner: &'static str,
    },
    /// The segments of a path do not match the stages of a task.
    #[error("{problem}")]
    Segments {
        /// The segment and its fault.
        problem: String,
    },
    /// A stage is impossible.
    #[error("stage {}: {problem}", stage + 1)]
    Stage {
        /// Index of the stage, from 0.
        stage: usize,
        /// The fault.
        problem: String,
    },
    /// The problem has no goal.
    #[error(
        "the problem has no goal: neither a grasp nor a configuration nor a region; of the `regions` of a scenario, `cranny plan --goal-region` (`goal_region` in Python) takes one; a campaign has no key for it"
    )]
    NoGoal,
    /// IK annotation needs a set of grasps and the exact criterion.
    #[error("the inverse kinematics of grasps needs a set of grasps and the exact criterion")]
    Annotation,
    /// The planner needs another kind of goal.
    #[error("planner '{planner}' needs {needs}, which this problem does not have")]
    Goal {
        /// Name of the planner.
        planner: &'static str,
        /// The kind of goal that the planner needs.
        needs: &'static str,
    },
    /// The world or the margins are malformed.
    #[error(transparent)]
    Collision(#[from] cranny_collision::CollisionError),
}
