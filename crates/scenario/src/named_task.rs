use cranny_spatial::Pose;
use cranny_task::Stage;

/// Name of the task that the `steps` of a scenario form.
pub const STEPS: &str = "steps";

/// Named task of a scenario.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NamedTask {
    /// Name of the task.
    pub name: String,
    /// Stages of the task.
    pub stages: Vec<Stage>,
}

impl NamedTask {
    /// Returns the task in a new frame, in which the present frame has the pose `new_from_old`.
    #[must_use]
    pub fn in_frame(&self, new_from_old: &Pose) -> Self {
        let stages = self.stages.iter().map(|stage| stage.in_frame(new_from_old)).collect();
        Self { name: self.name.clone(), stages }
    }
}
