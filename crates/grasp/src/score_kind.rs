use crate::Grasp;
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

    /// The score of this kind of a grasp: in [0, 1], but a load is any number from 0.
    pub fn of(self, grasp: &Grasp) -> Option<f64> {
        match self {
            Self::Geometric => grasp.score,
            Self::Physics => grasp.robust.map(|robust| robust.score()),
            Self::Load => grasp.load,
        }
    }
}
