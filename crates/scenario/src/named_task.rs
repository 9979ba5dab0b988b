use cranny_plan::Stage;

/// A task of a scenario that has a name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NamedTask {
    /// The name.
    pub name: String,
    /// The stages.
    pub stages: Vec<Stage>,
}
