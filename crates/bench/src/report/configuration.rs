use std::collections::{BTreeMap, BTreeSet};

use cranny_file::{counted, visible_line};
use serde_json::Value;

use crate::{PathDemand, Trial};

/// Properties that all runs of a group share: everything but the seed and the goal.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Configuration {
    pub criterion: &'static str,
    pub scenario: String,
    pub scenario_hash: String,
    pub planner: String,
    pub settings: String,
    /// Bits of the time limit, which order positive numbers correctly.
    time_limit_bits: u64,
    pub iteration_limit: Option<u64>,
    /// True if each trial aims at one goal.
    pub goal_wise: bool,
}

impl Configuration {
    pub fn of(trial: &Trial) -> Self {
        Self {
            criterion: trial.criterion.name(),
            scenario: trial.scenario.clone(),
            scenario_hash: trial.scenario_hash.clone(),
            planner: trial.planner.clone(),
            settings: trial.settings.clone(),
            time_limit_bits: trial.time_limit_s.to_bits(),
            iteration_limit: trial.iteration_limit,
            goal_wise: trial.goal.is_some(),
        }
    }

    pub fn time_limit_s(&self) -> f64 {
        f64::from_bits(self.time_limit_bits)
    }
}

/// Suffix of the name of a planner whose trials had no grasp set.
pub const NO_GRASP_SET: &str = " (no grasp set)";

/// Names of configurations, unique for different ones.
pub struct Names {
    scenario: BTreeMap<(String, String), String>,
    planner: BTreeMap<Configuration, String>,
}

impl Names {
    /// Creates the shortest unique names: the planner alone; with the differing settings, if it has several; with the limits,
    /// if one scenario has several.
    pub fn of<'a>(configurations: impl Iterator<Item = &'a Configuration> + Clone) -> Self {
        let mut hashes: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
        let mut settings: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
        for configuration in configurations.clone() {
            hashes.entry(&configuration.scenario).or_default().insert(&configuration.scenario_hash);
            settings.entry(&configuration.planner).or_default().insert(&configuration.settings);
        }
        let scenario = |(id, hashes): (&&str, &BTreeSet<&str>)| {
            let name = |hash: &&str| {
                let short: String = hash.chars().take(8).collect();
                let name = if hashes.len() == 1 { (*id).to_owned() } else { format!("{id} ({short})") };
                (((*id).to_owned(), (*hash).to_owned()), visible_line(&name))
            };
            hashes.iter().map(name).collect::<Vec<_>>()
        };
        let differences: BTreeMap<&str, BTreeMap<&str, String>> =
            settings.iter().map(|(planner, all)| (*planner, differences(all))).collect();
        let with_settings = |configuration: &Configuration| {
            let difference = &differences[configuration.planner.as_str()][configuration.settings.as_str()];
            let each_goal = if configuration.goal_wise { " (best goal)" } else { "" };
            // The suffix is also on unique names, because the problem is another one.
            let is_without = PathDemand::of_settings(&configuration.settings).without_grasp_set;
            let without = if is_without { NO_GRASP_SET } else { "" };
            visible_line(&format!("{}{difference}{each_goal}{without}", configuration.planner))
        };
        // The limits distinguish configurations of one scenario that still have the same name.
        let mut taken: BTreeMap<(&str, &str, String), usize> = BTreeMap::new();
        let place = |configuration: &'a Configuration| {
            let name = with_settings(configuration);
            (configuration.criterion, configuration.scenario_hash.as_str(), name)
        };
        for configuration in configurations.clone() {
            *taken.entry(place(configuration)).or_default() += 1;
        }
        let planner = |configuration: &'a Configuration| {
            let place = place(configuration);
            let name =
                if taken[&place] == 1 { place.2 } else { format!("{}{}", place.2, limits(configuration)) };
            (configuration.clone(), name)
        };
        Self {
            scenario: hashes.iter().flat_map(scenario).collect(),
            planner: configurations.map(planner).collect(),
        }
    }

    pub fn scenario(&self, configuration: &Configuration) -> &str {
        &self.scenario[&(configuration.scenario.clone(), configuration.scenario_hash.clone())]
    }

    pub fn planner(&self, configuration: &Configuration) -> &str {
        &self.planner[configuration]
    }
}

/// Returns for each of the settings of a planner where it differs from the others, as ` [key=value]`; all of it if any is no
/// object.
fn differences<'a>(all: &BTreeSet<&'a str>) -> BTreeMap<&'a str, String> {
    if all.len() == 1 {
        return all.iter().map(|own| (*own, String::new())).collect();
    }
    let parsed = |text: &&'a str| match serde_json::from_str(text) {
        Ok(Value::Object(settings)) => Some((*text, settings)),
        _ => None,
    };
    let Some(parsed) = all.iter().map(parsed).collect::<Option<Vec<_>>>() else {
        return all.iter().map(|own| (*own, format!(" [{own}]"))).collect();
    };
    // The number of settings in which each value of a key occurs: a key differs if no value occurs in all of them.
    let mut counts: BTreeMap<&String, BTreeMap<String, usize>> = BTreeMap::new();
    for (key, value) in parsed.iter().flat_map(|(_, settings)| settings) {
        *counts.entry(key).or_default().entry(value.to_string()).or_default() += 1;
    }
    // Every name already shows the absence of a grasp set.
    counts.retain(|key, values| {
        *key != PathDemand::GRASPS && values.values().all(|count| *count < parsed.len())
    });
    let text = |own: &serde_json::Map<String, Value>| {
        let value = |key: &String| own.get(key).map_or("none".to_owned(), ToString::to_string);
        let pairs = counts.keys().map(|key| format!("{key}={}", value(key).trim_matches('"')));
        pairs.collect::<Vec<_>>().join(", ")
    };
    let bracketed = |text: String| if text.is_empty() { text } else { format!(" [{text}]") };
    parsed.iter().map(|(own, settings)| (*own, bracketed(text(settings)))).collect()
}

fn limits(configuration: &Configuration) -> String {
    let iterations = configuration
        .iteration_limit
        .map_or(String::new(), |iterations| format!(", {}", counted(iterations, "iteration")));
    format!(" (limit {} s{iterations})", configuration.time_limit_s())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn configuration(planner: &str, settings: &str, time_limit_s: f64) -> Configuration {
        Configuration {
            criterion: "exact",
            scenario: "021".to_owned(),
            scenario_hash: "a".to_owned(),
            planner: planner.to_owned(),
            settings: settings.to_owned(),
            time_limit_bits: time_limit_s.to_bits(),
            iteration_limit: None,
            goal_wise: false,
        }
    }

    #[test]
    fn a_name_says_what_differs_and_no_more() {
        let all = [
            configuration("reach", "{}", 1.0),
            configuration("rrt", r#"{"bias":0.1,"step":2}"#, 1.0),
            configuration("rrt", r#"{"bias":0.2,"step":2}"#, 1.0),
            configuration("slow", "{}", 1.0),
            configuration("slow", "{}", 2.5),
        ];
        let names = Names::of(all.iter());
        let planners: Vec<&str> = all.iter().map(|configuration| names.planner(configuration)).collect();
        let expected =
            ["reach", "rrt [bias=0.1]", "rrt [bias=0.2]", "slow (limit 1 s)", "slow (limit 2.5 s)"];
        assert_eq!(planners, expected);
    }

    #[test]
    fn what_had_no_set_of_grasps_says_so_and_is_nobody_elses_namesake() {
        let all = [
            configuration("mine", r#"{"step":1}"#, 1.0),
            configuration("mine", r#"{"grasps":"none","step":1}"#, 1.0),
            configuration("grasp-reach", r#"{"grasps":"none"}"#, 1.0),
        ];
        let names = Names::of(all.iter());
        let planners: Vec<&str> = all.iter().map(|configuration| names.planner(configuration)).collect();
        assert_eq!(planners, ["mine", "mine (no grasp set)", "grasp-reach (no grasp set)"]);
    }

    #[test]
    fn a_scenario_that_changed_under_its_name_is_two_scenarios() {
        let mut all = [configuration("reach", "{}", 1.0), configuration("reach", "{}", 1.0)];
        all[1].scenario_hash = "0123456789".to_owned();
        let names = Names::of(all.iter());
        assert_eq!(names.scenario(&all[0]), "021 (a)");
        assert_eq!(names.scenario(&all[1]), "021 (01234567)");
        assert_eq!(names.planner(&all[0]), "reach");
    }
}
