use cranny_file::{counted, did_you_mean};

/// A malformed task. That a task has no solution is an outcome, not an error.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TaskError {
    /// A configuration has the wrong number of values.
    #[error("the {what} configuration has {}, but the robot has {}", counted(*actual, "value"), counted(*expected, "joint"))]
    JointCount {
        /// Which configuration.
        what: &'static str,
        /// How many joints the robot has.
        expected: usize,
        /// How many values were given.
        actual: usize,
    },
    /// A configuration has a value that is infinite or not a number.
    #[error("the {what} configuration has a value for joint '{joint}' that is not a finite number")]
    NotFinite {
        /// Which configuration.
        what: &'static str,
        /// Which joint.
        joint: String,
    },
    /// A problem has nothing that can be carried.
    #[error("to carry the target away, the problem needs {needs}")]
    NothingToCarry {
        /// What it lacks.
        needs: &'static str,
    },
    /// A place is named that the problem does not have.
    #[error(
        "there is no place '{name}' to put the target down (there are: {known}; `places` of a scenario.yaml){}",
        did_you_mean(name, known.split(", ").map(|known| known.trim_matches('\'')))
    )]
    UnknownPlace {
        /// The name asked for.
        name: String,
        /// The names that there are.
        known: String,
    },
    /// An object cannot be asked to be put down there.
    #[error("{problem}")]
    Place {
        /// What is wrong.
        problem: String,
    },
    /// A problem lacks what a grasp is measured by.
    #[error("without a set of grasps, the problem needs {needs}")]
    NoGraspMeasure {
        /// What it lacks.
        needs: &'static str,
    },
    /// A planner needs a set of grasps.
    #[error(
        "a set of grasps is needed, and the problem has none (planners that make grasps of their own: grasp-reach, \
         grasp-rrt)"
    )]
    NoGraspSet,
    /// A planner makes grasps of its own alone.
    #[error(
        "planner '{planner}' makes grasps of its own, for a problem without a set of grasps; leave the set out \
         (`--grasps none`)"
    )]
    GraspSet {
        /// Which planner.
        planner: &'static str,
    },
    /// The segments of a path are not of the stages of a task.
    #[error("{problem}")]
    Segments {
        /// Which segment, and what is wrong with it.
        problem: String,
    },
    /// A stage cannot be asked for.
    #[error("stage {}: {problem}", stage + 1)]
    Stage {
        /// Which stage, from 0.
        stage: usize,
        /// What is wrong with it.
        problem: String,
    },
    /// There is nothing to reach for.
    #[error("the problem has no goal: neither a grasp nor a configuration to reach for")]
    NoGoal,
    /// Only grasps can be annotated, and only exactly.
    #[error("inverse kinematics is looked for at grasps, and under the exact criterion only")]
    Annotation,
    /// The planner needs another kind of goal.
    #[error("planner '{planner}' reaches for {needs}, which this problem does not give")]
    Goal {
        /// Which planner.
        planner: &'static str,
        /// What it needs.
        needs: &'static str,
    },
    /// The world or the margins are malformed.
    #[error(transparent)]
    Collision(#[from] cranny_collision::CollisionError),
}
