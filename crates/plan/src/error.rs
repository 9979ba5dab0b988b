/// What makes a problem or a path malformed. That a problem has no solution is an outcome, not an error.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    /// A configuration has the wrong number of values.
    #[error("the {what} configuration has {actual} values, but the robot has {expected} joints")]
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
    /// There is nothing to reach for.
    #[error("the problem has no goal: neither a grasp nor a configuration to reach for")]
    NoGoal,
    /// A planner is named that does not exist.
    #[error("there is no planner '{name}' (there are: {known})")]
    UnknownPlanner {
        /// The name asked for.
        name: String,
        /// The names that there are.
        known: String,
    },
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
