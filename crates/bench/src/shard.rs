use std::fmt;
use std::str::FromStr;

use crate::Schedule;

/// One of several parts of a campaign, each run by itself, on whatever machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    index: u64,
    count: u64,
}

/// A campaign has no more parts.
pub const MOST_SHARDS: u64 = 100_000;

impl Shard {
    /// The part `index`, from 1, of `count`; nothing where there is none.
    pub fn new(index: u64, count: u64) -> Option<Self> {
        (1..=count.min(MOST_SHARDS)).contains(&index).then_some(Self { index, count })
    }

    /// Of the trials of a campaign those of this part. The parts of any `count` are the whole, each trial in one of them;
    /// which trials are in the results already does not matter.
    ///
    /// Neighbours go to different parts, another one each seed: a part has every scenario and every planner, as far as it has
    /// that many trials.
    #[must_use]
    pub fn of(self, schedule: Schedule) -> Schedule {
        let questions = schedule.questions.into_iter().zip(0_u64..);
        let is_ours = |seed: u64, place: u64| place.wrapping_add(seed) % self.count == self.index - 1;
        let ours = questions.filter(|(question, place)| is_ours(question.trial.seed, *place));
        Schedule { questions: ours.map(|(question, _)| question).collect(), ..schedule }
    }
}

impl FromStr for Shard {
    type Err = String;

    /// From `3/8`.
    fn from_str(text: &str) -> Result<Self, String> {
        let parts =
            text.split_once('/').and_then(|(index, count)| Some((index.parse().ok()?, count.parse().ok()?)));
        let shard = parts.and_then(|(index, count)| Self::new(index, count));
        shard.ok_or_else(|| {
            format!("give a part and how many there are, from 1/1 to {MOST_SHARDS}/{MOST_SHARDS}, as 3/8")
        })
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, text: &mut fmt::Formatter) -> fmt::Result {
        write!(text, "{}/{}", self.index, self.count)
    }
}
