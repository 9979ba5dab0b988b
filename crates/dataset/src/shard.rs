use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// One of several shards of a data set, each made by itself on any machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DatasetShard {
    /// Index of the shard, from 1.
    pub index: u64,
    /// Number of shards.
    pub of: u64,
}

/// Maximum number of shards of a data set.
const MOST_SHARDS: u64 = 100_000;

impl DatasetShard {
    /// The only shard of a data set that is made as a whole.
    pub const WHOLE: Self = Self { index: 1, of: 1 };

    /// Returns true if there is such a shard.
    pub(crate) fn is_valid(self) -> bool {
        (1..=MOST_SHARDS).contains(&self.of) && (1..=self.of).contains(&self.index)
    }

    /// Returns true if a chunk of this index belongs to this shard: chunks are dealt out in turn.
    pub fn has(self, chunk: u64) -> bool {
        chunk % self.of == self.index - 1
    }
}

impl FromStr for DatasetShard {
    type Err = String;

    /// Parses a text such as `3/8`.
    fn from_str(text: &str) -> Result<Self, String> {
        let parts =
            text.split_once('/').and_then(|(index, of)| Some((index.parse().ok()?, of.parse().ok()?)));
        parts.map(|(index, of)| Self { index, of }).filter(|shard| shard.is_valid()).ok_or_else(|| {
            format!("expected a shard and the number of shards, from 1/1 to {MOST_SHARDS}/{MOST_SHARDS}, such as 3/8")
        })
    }
}

impl fmt::Display for DatasetShard {
    fn fmt(&self, text: &mut fmt::Formatter) -> fmt::Result {
        write!(text, "{}/{}", self.index, self.of)
    }
}
