use cranny_scenario::Scenario;
use cranny_task::{AfterPlacing, CLEAR_M, Move, PlaceAt, Stage, TaskError};
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
    /// To where it is clear of everything but floors, by [`CLEAR_M`].
    Out,
    /// To the first place of its scenario, where it is put down, and the robot goes home.
    Place,
}

impl CarryTo {
    /// Name in files and flags.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// The stages, of which the last ends there.
    ///
    /// # Errors
    /// [`TaskError::Place`] for a scenario without a place to put anything down.
    pub(crate) fn stages(self, scenario: &Scenario) -> Result<Vec<Stage>, TaskError> {
        let none = || TaskError::Place {
            problem: "the scenario has no place to put its target down (`places` in scenario.yaml)"
                .to_owned(),
        };
        Ok(match self {
            Self::Home => vec![Stage::pick(), Stage::home()],
            Self::Out => vec![Stage::pick(), Stage::Move(Move::Clear { clear_m: CLEAR_M })],
            Self::Place => {
                let place = scenario.places.first().ok_or_else(none)?.name.clone();
                Stage::put_down(PlaceAt::named(&place), AfterPlacing::Home)
            }
        })
    }
}
