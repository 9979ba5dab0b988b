use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fmt;
use std::path::Path;
use std::str::FromStr;

use cranny_file::counted;
use serde::{Deserialize, Serialize};

use crate::store::results_file;
use crate::{BenchError, Question, Results, Schedule};

/// One of several shards of a campaign; each runs separately, on any machine. Its text is that of the flag, such as `3/8`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Shard {
    count: u64,
    index: u64,
}

/// Maximum number of shards of a campaign.
pub const MOST_SHARDS: u64 = 100_000;

impl Shard {
    /// Creates the shard `index`, from 1, of `count`; `None` if out of range.
    pub fn new(index: u64, count: u64) -> Option<Self> {
        (1..=count.min(MOST_SHARDS)).contains(&index).then_some(Self { count, index })
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

/// Returns the shards whose runs are stored, by the commands of the runs; none if a run was of a whole campaign, or its
/// command does not state its shard.
pub fn shards_of<'a>(commands: impl IntoIterator<Item = &'a str>) -> Vec<Shard> {
    let shards: Option<BTreeSet<Shard>> = commands.into_iter().map(shard_of_command).collect();
    shards.into_iter().flatten().collect()
}

/// Returns the last shard that the flag of a command requests.
fn shard_of_command(command: &str) -> Option<Shard> {
    const FLAG: &str = "--shard";
    let words = command.split_whitespace();
    let values = words.clone().zip(words.skip(1)).filter_map(|(word, next)| {
        let value = word.strip_prefix(FLAG)?;
        if value.is_empty() { Some(next) } else { value.strip_prefix('=') }
    });
    // The last word has no next one.
    let last = command.split_whitespace().last().and_then(|word| word.strip_prefix(FLAG)?.strip_prefix('='));
    values.chain(last).last()?.parse().ok()
}

/// Returns the shards of the runs in the results at `path`, as [`shards_of`], without checking the integrity of the file.
pub fn shards_at(path: &Path) -> Result<Vec<Shard>, BenchError> {
    let fault = |reason| BenchError::Database { path: path.to_owned(), reason };
    let connection = results_file::open_unseen(path)?;
    let mut statement = connection.prepare("SELECT command FROM runs").map_err(fault)?;
    let commands = statement.query_map([], |row| row.get(0)).and_then(Iterator::collect);
    let commands: Vec<String> = commands.map_err(fault)?;
    Ok(shards_of(commands.iter().map(String::as_str)))
}

impl Shard {
    /// Returns the shards that are not among these, of the same numbers of shards.
    pub fn missing(among: &[Self]) -> Vec<Self> {
        let there: BTreeSet<Self> = among.iter().copied().collect();
        let counts: BTreeSet<u64> = among.iter().map(|shard| shard.count).collect();
        let all = counts.into_iter().flat_map(|count| (1..=count).map(move |index| Self { count, index }));
        all.filter(|shard| !there.contains(shard)).collect()
    }

    /// Returns a sentence about the shards of which no run is among those with these commands; `None` if there are none.
    pub fn missing_among<'a>(commands: impl IntoIterator<Item = &'a str>) -> Option<String> {
        /// Maximum number of shards that are named.
        const MOST: usize = 8;
        let missing = Self::missing(&shards_of(commands));
        let mut named: Vec<String> = missing.iter().take(MOST).map(Self::to_string).collect();
        if missing.len() > MOST {
            named.push(counted(missing.len() - MOST, "other"));
        }
        (!missing.is_empty()).then(|| {
            format!(
                "No run of shard {} is among these results: the campaign is not complete, unless the shard has no trials.",
                named.join(", ")
            )
        })
    }
}

impl TryFrom<String> for Shard {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<Shard> for String {
    fn from(shard: Shard) -> Self {
        shard.to_string()
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shards_of_runs_are_those_of_their_commands_and_others_are_missing() {
        let names = |shards: &[Shard]| shards.iter().map(Shard::to_string).collect::<Vec<_>>();
        let of = |commands: &[&str]| names(&Shard::missing(&shards_of(commands.iter().copied())));
        let first = "cranny bench run a.yaml --shard 1/3 -o a.db";
        assert_eq!(of(&[first, first, "cranny bench run a.yaml --shard=2/3"]), ["3/3"]);
        assert_eq!(of(&["cranny bench run --shard=3/3 a.yaml"]), ["1/3", "2/3"]);
        assert_eq!(of(&[first, "x --shard 2/3", "x --shard 3/3"]), [""; 0]);
        // A run of the whole campaign, or one whose command is unknown.
        for other in ["cranny bench run a.yaml", "unknown", "x --shard", "x --shard 4/3", "x --shards 2/3"] {
            assert_eq!(of(&[first, other]), [""; 0], "{other}");
        }
        let note = Shard::missing_among(["x --shard 2/100000"]).unwrap();
        assert!(note.contains("shard 1/100000, 3/100000, ") && note.contains(", 99991 others is"), "{note}");
        let text = serde_json::to_string(&shards_of([first])).unwrap();
        assert_eq!(
            (text.as_str(), serde_json::from_str(&text).ok()),
            (r#"["1/3"]"#, Some(shards_of([first])))
        );
        assert!(serde_json::from_str::<Shard>(r#""0/3""#).is_err());
    }
}
