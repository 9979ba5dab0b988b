use serde::{Deserialize, Serialize};

/// Numbers of trials of one planner.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tally {
    /// Number of trials that ended.
    pub ended: usize,
    /// Number of solved trials.
    pub solved: usize,
}

impl Tally {
    /// Returns the sum of both tallies.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self { ended: self.ended + other.ended, solved: self.solved + other.solved }
    }
}
