use serde::{Deserialize, Serialize};

/// Trials of one planner.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tally {
    /// How many ended.
    pub ended: usize,
    /// How many of them were solved.
    pub solved: usize,
}

impl Tally {
    /// Both together.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self { ended: self.ended + other.ended, solved: self.solved + other.solved }
    }
}
