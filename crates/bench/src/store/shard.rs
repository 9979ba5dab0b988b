use std::collections::{BTreeMap, HashMap};
use std::fmt;
use std::str::FromStr;

use crate::{BenchError, Question, Results, Schedule};

/// One of several shards of a campaign; each runs separately, on any machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    index: u64,
    count: u64,
}

/// Maximum number of shards of a campaign.
pub const MOST_SHARDS: u64 = 100_000;

impl Shard {
    /// Creates the shard `index`, from 1, of `count`; `None` if out of range.
    pub fn new(index: u64, count: u64) -> Option<Self> {
        (1..=count.min(MOST_SHARDS)).contains(&index).then_some(Self { index, count })
    }

    /// Returns the trials of a campaign, stored or not, that belong to this shard. The shards of any `count` partition the
    /// campaign, with sizes that differ by at most one: in all, for each planner, and for each planner on each scenario.
    #[must_use]
    pub fn of(self, schedule: Schedule) -> Schedule {
        let parts = dealt(&schedule.questions, self.count);
        let ours = schedule.questions.into_iter().zip(parts).filter(|(_, part)| *part == self.index - 1);
        Schedule { questions: ours.map(|(question, _)| question).collect(), ..schedule }
    }

    /// Checks that the results contain no trials of other shards of the campaign: these would be run twice.
    ///
    /// # Errors
    /// [`BenchError::OtherShard`].
    pub fn check(self, schedule: &Schedule, results: &Results) -> Result<(), BenchError> {
        let parts = dealt(&schedule.questions, self.count).into_iter();
        let part_of: HashMap<String, u64> =
            schedule.questions.iter().map(|question| question.trial.key()).zip(parts).collect();
        let of_others = |key: String| part_of.get(&key).filter(|part| **part != self.index - 1);
        let trials =
            results.records()?.iter().filter(|record| of_others(record.trial.key()).is_some()).count();
        if trials == 0 {
            return Ok(());
        }
        Err(BenchError::OtherShard { results: results.path().to_owned(), part: self.to_string(), trials })
    }
}

/// Returns the shard of each trial, from 0.
///
/// 1. Sort the trials by planner, then scenario, and deal them out one by one, which spreads neighbours evenly.
/// 2. Start the deal of each planner at the scenario, among the first ones, with the fewest trials of one scenario in one
///    shard.
fn dealt(questions: &[Question], count: u64) -> Vec<u64> {
    /// Number of first scenarios to compare.
    const MOST_BEGINNINGS: usize = 32;
    // 1.
    let mut planners: BTreeMap<&str, BTreeMap<(&str, &str), Vec<usize>>> = BTreeMap::new();
    for (index, Question { trial, .. }) in questions.iter().enumerate() {
        let scenarios = planners.entry(&trial.planner).or_default();
        scenarios.entry((&trial.scenario, &trial.scenario_hash)).or_default().push(index);
    }
    let mut parts = vec![0; questions.len()];
    let mut met: HashMap<((&str, &str), u64), usize> = HashMap::new();
    let mut next = 0;
    for scenarios in planners.values_mut() {
        let mut scenarios: Vec<_> = scenarios.iter_mut().collect();
        for (_, trials) in &mut scenarios {
            // This order keeps the trials of one goal under one criterion together, by seed.
            trials.sort_by_key(|&index| {
                let trial = &questions[index].trial;
                (trial.goal, trial.criterion.name(), trial.seed)
            });
        }
        // 2.
        let mut best = (usize::MAX, 0);
        for beginning in 0..scenarios.len().min(MOST_BEGINNINGS) {
            let order = scenarios[beginning..].iter().chain(&scenarios[..beginning]);
            let trials = order.flat_map(|(scenario, trials)| trials.iter().map(|_| **scenario));
            let meetings = trials.zip(next..).map(|(scenario, place)| met.get(&(scenario, place % count)));
            best = best.min((meetings.flatten().sum(), beginning));
        }
        scenarios.rotate_left(best.1);
        for (scenario, trials) in scenarios {
            for &index in trials.iter() {
                parts[index] = next % count;
                *met.entry((*scenario, parts[index])).or_default() += 1;
                next += 1;
            }
        }
    }
    parts
}

impl FromStr for Shard {
    type Err = String;

    /// Parses a text such as `3/8`.
    fn from_str(text: &str) -> Result<Self, String> {
        let parts =
            text.split_once('/').and_then(|(index, count)| Some((index.parse().ok()?, count.parse().ok()?)));
        let shard = parts.and_then(|(index, count)| Self::new(index, count));
        shard.ok_or_else(|| {
            format!(
                "expected a shard and the number of shards, from 1/1 to {MOST_SHARDS}/{MOST_SHARDS}, such as \
                 3/8"
            )
        })
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, text: &mut fmt::Formatter) -> fmt::Result {
        write!(text, "{}/{}", self.index, self.count)
    }
}
