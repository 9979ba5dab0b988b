use cranny_plan::{AfterPlacing, CarryEnd, PlaceSettings, PlanError, Problem};
use cranny_solve::Carry;
use serde::{Deserialize, Serialize};
use strum::{EnumString, IntoStaticStr, VariantArray};

/// Where the target is carried to in the trials of a campaign, once it is grasped.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, EnumString, IntoStaticStr, VariantArray,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum CarryTo {
    /// To where the robot started.
    Home,
    /// To where it is clear of everything but floors, by [`CarryEnd::CLEAR_M`].
    Out,
    /// To the first place of its scenario, where it is put down, and the robot goes home.
    Place,
}

impl CarryTo {
    /// What files and flags call it.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// What a planner is asked for.
    ///
    /// # Errors
    /// [`PlanError::Place`] for a scenario without a place to put anything down.
    pub(crate) fn carry(self, problem: &Problem) -> Result<Carry, PlanError> {
        let end = match self {
            Self::Home => CarryEnd::Home,
            Self::Out => CarryEnd::Out { clear_m: CarryEnd::CLEAR_M },
            Self::Place => {
                let none = || PlanError::Place {
                    problem: "the scenario has no place to put its target down (`places` in scenario.yaml)"
                        .to_owned(),
                };
                let goal = problem.places().first().ok_or_else(none)?.clone();
                let (clear_m, then) = (PlaceSettings::CLEAR_M, AfterPlacing::Home);
                CarryEnd::Place(PlaceSettings { goal, clear_m, then })
            }
        };
        Ok(Carry { end, ..Carry::default() })
    }
}
