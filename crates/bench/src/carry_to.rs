use cranny_plan::CarryEnd;
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
}

impl CarryTo {
    /// What files and flags call it.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// What a planner is asked for.
    pub(crate) fn carry(self) -> Carry {
        let end = match self {
            Self::Home => CarryEnd::Home,
            Self::Out => CarryEnd::Out { clear_m: CarryEnd::CLEAR_M },
        };
        Carry { end, ..Carry::default() }
    }
}
