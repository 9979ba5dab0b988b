use std::path::Path;

use cranny_scenario::{BuiltInTask, CatalogueEntry, Identity, built_in};

use crate::BenchError;

/// A scenario of a campaign.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChosenScenario {
    /// Identity of the scenario.
    pub identity: Identity,
    /// Source of the scenario: a built-in id or an absolute path.
    pub source: String,
}

const ALL: &str = "all";

/// Returns the scenarios named by words: `all`, built-in ids in which `x` stands for any digit (`01x`), folders and
/// archives. Duplicates are removed; the order is that of the words.
///
/// # Errors
/// [`BenchError::Pattern`], [`BenchError::Scenario`], [`BenchError::Empty`].
pub fn choose_scenarios(words: &[String]) -> Result<Vec<ChosenScenario>, BenchError> {
    let mut chosen: Vec<ChosenScenario> = Vec::new();
    for word in words {
        // `all` stands for the twenty scenarios of the paper; scenarios with other tasks are named by their ids.
        let is_named = |entry: &&CatalogueEntry| {
            matches(word, entry.id) && (word != ALL || entry.task == BuiltInTask::Pick)
        };
        let built_in: Vec<&str> = built_in().filter(is_named).map(|entry| entry.id).collect();
        let sources = if built_in.is_empty() {
            vec![path_of(word)?]
        } else {
            built_in.into_iter().map(str::to_owned).collect()
        };
        for source in sources {
            let scenario = ChosenScenario { identity: Identity::of(&source)?, source };
            if !chosen.iter().any(|known| known.identity == scenario.identity) {
                chosen.push(scenario);
            }
        }
    }
    if chosen.is_empty() { Err(BenchError::Empty { what: "scenarios" }) } else { Ok(chosen) }
}

/// Returns true if a word matches a built-in id.
pub fn matches(word: &str, id: &str) -> bool {
    let fits =
        |(pattern, digit): (char, char)| pattern == digit || (pattern == 'x' && digit.is_ascii_digit());
    word == ALL || (word.len() == id.len() && word.chars().zip(id.chars()).all(fits))
}

fn path_of(word: &str) -> Result<String, BenchError> {
    let path =
        Path::new(word).canonicalize().map_err(|_| BenchError::Pattern { pattern: word.to_owned() })?;
    Ok(path.display().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ids(words: &[&str]) -> Vec<String> {
        let words: Vec<String> = words.iter().map(|word| (*word).to_owned()).collect();
        choose_scenarios(&words).unwrap().into_iter().map(|scenario| scenario.identity.id).collect()
    }

    #[test]
    fn patterns_stand_for_ids() {
        assert_eq!(ids(&["01x", "045", "012"]), ["011", "012", "013", "014", "015", "045"]);
        assert_eq!(ids(&["0x3"]), ["013", "023", "033", "043"]);
        assert_eq!(ids(&["all"]).len(), 20);
        assert!(matches!(choose_scenarios(&["05x".into()]), Err(BenchError::Pattern { .. })));
        assert!(matches!(choose_scenarios(&[]), Err(BenchError::Empty { .. })));
    }
}
