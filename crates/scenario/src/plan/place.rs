use cranny_plan::{AfterPlacing, PlaceSettings, PlanError, Problem};
use serde::{Deserialize, Serialize};

/// Where and how a plan puts its target down.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanPlace {
    /// The place, one of those of its scenario.
    pub name: String,
    /// How far the hand is from the target when it has left it, in metres.
    pub clear_m: f64,
    /// Where the robot goes then.
    pub then: AfterPlacing,
}

impl PlanPlace {
    /// What a file says of it.
    pub(crate) fn of(settings: &PlaceSettings) -> Self {
        let PlaceSettings { goal, clear_m, then } = settings;
        Self { name: goal.name.clone(), clear_m: *clear_m, then: *then }
    }

    /// How the target of a problem was to be put down.
    ///
    /// # Errors
    /// [`PlanError::UnknownPlace`] for a problem without that place.
    pub fn settings(&self, problem: &Problem) -> Result<PlaceSettings, PlanError> {
        let goal = problem.place(&self.name)?.clone();
        Ok(PlaceSettings { goal, clear_m: self.clear_m, then: self.then })
    }
}
