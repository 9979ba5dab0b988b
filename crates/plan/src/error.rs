use cranny_file::{counted, did_you_mean};

/// What makes a problem or a path malformed. That a problem has no solution is an outcome, not an error.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
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
    /// A planner is named that does not exist.
    #[error("there is no planner '{name}' (there are: {known}){}", did_you_mean(name, known.split(", ")))]
    UnknownPlanner {
        /// The name asked for.
        name: String,
        /// The names that there are.
        known: String,
    },
    /// A registry knows a planner of that name already.
    #[error("there is a planner '{name}' already")]
    TwicePlanner {
        /// The name.
        name: &'static str,
    },
    /// A planner has no such setting.
    #[error("planner '{planner}' has no setting '{setting}' (there are: {known}){}", did_you_mean(setting, known.split(", ")))]
    UnknownSetting {
        /// Which planner.
        planner: String,
        /// The setting asked for.
        setting: String,
        /// The settings that there are.
        known: String,
    },
    /// A setting of a planner has a value that is none.
    #[error("a setting of planner '{planner}': {problem}")]
    Setting {
        /// Which planner.
        planner: String,
        /// Which setting, what is wrong with it, and what would fit.
        problem: String,
    },
    /// Only grasps can be annotated, and only exactly.
    #[error("inverse kinematics is looked for at grasps, and under the exact criterion only")]
    Annotation,
    /// The weight of a grasp's score is none.
    #[error("{weight} is no weight of a score; it must be finite and at least 0")]
    ScoreWeight {
        /// The weight.
        weight: f64,
    },
    /// A path has no way point.
    #[error("the path has no way points")]
    EmptyPath,
    /// A joint has no limit that a trajectory needs.
    #[error(
        "joint '{joint}' has no {quantity} limit, which a trajectory needs; give it one in the limits.yaml of \
         the robot"
    )]
    MissingLimit {
        /// Which joint.
        joint: String,
        /// Of what: `acceleration` or `jerk`.
        quantity: &'static str,
    },
    /// A joint has a limit that no motion can keep to.
    #[error("joint '{joint}' has a {quantity} limit of {value}, but it must be positive and finite")]
    Limit {
        /// Which joint.
        joint: String,
        /// Of what.
        quantity: &'static str,
        /// The limit.
        value: f64,
    },
    /// Corners are cut under limits of acceleration only.
    #[error("corners cannot be cut where jerk is limited: a parabola begins with a jump of the acceleration")]
    BlendedJerk,
    /// Corners are cut on the way to a grasp only.
    #[error("corners cannot be cut where an object is carried: what is in the hand was not compared there")]
    BlendedTask,
    /// A trajectory cannot be sampled at this rate.
    #[error("a trajectory is sampled at more than 0 and at most {greatest_hz} Hz, not at {rate_hz}")]
    SampleRate {
        /// The rate asked for.
        rate_hz: f64,
        /// The greatest that there is.
        greatest_hz: f64,
    },
    /// The planner needs another kind of goal.
    #[error("planner '{planner}' reaches for {needs}, which this problem does not give")]
    Goal {
        /// Which planner.
        planner: &'static str,
        /// What it needs.
        needs: &'static str,
    },
    /// The file of a roadmap is none of this robot.
    #[error("{}: no roadmap that can be used: {problem}", path.display())]
    Roadmap {
        /// The file.
        path: std::path::PathBuf,
        /// What is wrong with it.
        problem: String,
    },
    /// The world or the margins are malformed.
    #[error(transparent)]
    Collision(#[from] cranny_collision::CollisionError),
}
