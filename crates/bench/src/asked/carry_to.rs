use cranny_scenario::Scenario;
use cranny_task::{AfterPlacing, CLEAR_M, Move, PlaceAt, Stage, TaskError};
use serde::{Deserialize, Serialize};
use strum::{EnumString, IntoStaticStr, VariantArray};

/// Destination of the target after the grasp, in the trials of a campaign.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, EnumString, IntoStaticStr, VariantArray,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum CarryTo {
    /// The start configuration of the robot.
    Home,
    /// A configuration where the target is clear of everything but floors by [`CLEAR_M`].
    Out,
    /// The first placement of the scenario, where the robot sets the target down; then the robot returns home.
    Place,
}

impl CarryTo {
    /// Returns the name in files and flags.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// Returns the stages; the last one ends at the destination.
    ///
    /// # Errors
    /// [`TaskError::Place`] for a scenario without a placement.
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
