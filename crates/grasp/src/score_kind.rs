use serde::{Deserialize, Serialize};
use strum::{EnumString, IntoStaticStr};

/// Kind of score that ranks grasps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, EnumString, IntoStaticStr)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum ScoreKind {
    /// Geometric score, [`Grasp::score`](crate::Grasp::score).
    #[default]
    Geometric,
    /// Robust score, [`Grasp::robust`](crate::Grasp::robust).
    Physics,
    /// Factor by which gravity may grow, [`Grasp::load`](crate::Grasp::load).
    Load,
}

impl ScoreKind {
    /// Name in files and flags.
    pub fn name(self) -> &'static str {
        self.into()
    }
}
