use serde::{Deserialize, Serialize};
use strum::{EnumString, IntoStaticStr};

/// Which of its scores says how good a grasp is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, EnumString, IntoStaticStr)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum ScoreKind {
    /// The geometric one, [`Grasp::score`](crate::Grasp::score).
    #[default]
    Geometric,
    /// The robust one, [`Grasp::robust`](crate::Grasp::robust).
    Physics,
    /// The factor by which gravity may grow, [`Grasp::load`](crate::Grasp::load).
    Load,
}

impl ScoreKind {
    /// What files and flags call it.
    pub fn name(self) -> &'static str {
        self.into()
    }
}
