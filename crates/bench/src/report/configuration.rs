use std::collections::{BTreeMap, BTreeSet};

use cranny_file::counted;
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
                (((*id).to_owned(), (*hash).to_owned()), name)
            };
            hashes.iter().map(name).collect::<Vec<_>>()
        };
        let with_settings = |configuration: &Configuration| {
            let all = &settings[configuration.planner.as_str()];
            let difference =
                if all.len() == 1 { String::new() } else { differing(&configuration.settings, all) };
            let each_goal = if configuration.goal_wise { " (best goal)" } else { "" };
            // The suffix is also on unique names, because the problem is another one.
            let is_without = PathDemand::of_settings(&configuration.settings).without_grasp_set;
            let without = if is_without { NO_GRASP_SET } else { "" };
            format!("{}{difference}{each_goal}{without}", configuration.planner)
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

/// Returns the settings in which `own` differs from the others, as ` [key=value]`; all of them if they are no object.
fn differing(own: &str, all: &BTreeSet<&str>) -> String {
    let parsed = |text: &str| match serde_json::from_str(text) {
        Ok(Value::Object(settings)) => Some(settings),
        _ => None,
    };
    let (Some(own_settings), Some(all)) =
        (parsed(own), all.iter().map(|text| parsed(text)).collect::<Option<Vec<_>>>())
    else {
        return format!(" [{own}]");
    };
    let keys: BTreeSet<&String> = all.iter().flat_map(|settings| settings.keys()).collect();
    // Every name already shows the absence of a grasp set.
    let differs = |key: &&String| {
        *key != PathDemand::GRASPS && all.iter().any(|settings| settings.get(*key) != all[0].get(*key))
    };
    let text = |key: &String| {
        let value = own_settings.get(key).map_or("none".to_owned(), ToString::to_string);
        format!("{key}={}", value.trim_matches('"'))
    };
    let parts: Vec<String> = keys.into_iter().filter(differs).map(text).collect();
    if parts.is_empty() { String::new() } else { format!(" [{}]", parts.join(", ")) }
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
