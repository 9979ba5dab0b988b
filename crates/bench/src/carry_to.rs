use cranny_plan::CarryEnd;
use cranny_solve::Carry;
use serde::{Deserialize, Serialize};
use strum::{EnumString, IntoStaticStr, VariantArray};

/// Where the target is carried to in the trials of a campaign, once it is grasped.
///
/// Trials that carry it are others than those that end at the grasp: it stands among the settings of a trial.
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

/// What it is called among settings.
const KEY: &str = "carry";

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

    /// The settings of a planner, as canonical JSON, with what the trial asks of it.
    pub(crate) fn among(carry: Option<Self>, settings: String) -> String {
        let Some(carry) = carry else { return settings };
        let parsed = serde_json::from_str(&settings);
        // Sorted by their keys, as they were.
        let mut all: std::collections::BTreeMap<String, serde_json::Value> = parsed.unwrap_or_default();
        all.insert(KEY.to_owned(), carry.name().into());
        serde_json::json!(all).to_string()
    }

    /// What the settings of a trial ask.
    pub(crate) fn of_settings(settings: &str) -> Option<Self> {
        let all: serde_json::Value = serde_json::from_str(settings).ok()?;
        all.get(KEY)?.as_str()?.parse().ok()
    }
}
