use cranny_spatial::Pose;
use cranny_task::Stage;

/// Name of the task that the steps of a scenario are.
pub const STEPS: &str = "steps";

/// A task of a scenario that has a name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NamedTask {
    /// The name.
    pub name: String,
    /// The stages.
    pub stages: Vec<Stage>,
}

impl NamedTask {
    /// The same in a frame in which the one that it is in has this pose.
    #[must_use]
    pub fn seen_from(&self, new_from_old: &Pose) -> Self {
        let stages = self.stages.iter().map(|stage| stage.seen_from(new_from_old)).collect();
        Self { name: self.name.clone(), stages }
    }
}
