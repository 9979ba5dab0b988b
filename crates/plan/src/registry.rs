use cranny_spatial::LANES;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use crate::{
    Criterion, GraspReach, GraspRrt, IkRbt, IkRrt, JPlusRbt, JPlusRrt, PlanError, Planner, Prm, Problem,
    RbtConnect, Reach, Rrt, RrtConnect, RrtStar,
};

type Made = Result<Box<dyn Planner>, PlanError>;

/// A planner as lists show it.
struct Entry {
    default: Box<dyn Planner>,
    /// The same kind with these settings, all of them.
    with: fn(&str, Map<String, Value>) -> Made,
}

impl Entry {
    fn of<T: Planner + Default + DeserializeOwned + 'static>() -> Self {
        Self {
            default: Box::new(T::default()),
            with: |name, settings| Ok(Box::new(read::<T>(name, settings)?)),
        }
    }
}

/// Every planner, in the order in which lists show them.
fn all() -> [Entry; 12] {
    [
        Entry::of::<Reach>(),
        Entry::of::<GraspReach>(),
        Entry::of::<RrtConnect>(),
        Entry::of::<RbtConnect>(),
        Entry::of::<Rrt>(),
        Entry::of::<RrtStar>(),
        Entry::of::<Prm>(),
        Entry::of::<IkRrt>(),
        Entry::of::<IkRbt>(),
        Entry::of::<JPlusRrt>(),
        Entry::of::<JPlusRbt>(),
        Entry::of::<GraspRrt>(),
    ]
}

/// The planner of that name, with its default settings.
///
/// # Errors
/// [`PlanError::UnknownPlanner`], which lists the names that there are.
pub fn planner(name: &str) -> Result<Box<dyn Planner>, PlanError> {
    entry(name).map(|entry| entry.default)
}

fn entry(name: &str) -> Result<Entry, PlanError> {
    let unknown = || PlanError::UnknownPlanner { name: name.to_owned(), known: planner_names().join(", ") };
    all().into_iter().find(|entry| entry.default.name() == name).ok_or_else(unknown)
}

/// The planner of that name, with `settings` in place of the defaults of the same names.
///
/// # Errors
/// As [`planner`]; [`PlanError::UnknownSetting`], which lists those that there are; [`PlanError::Setting`] for a
/// value that is none.
pub fn planner_with(name: &str, settings: &Map<String, Value>) -> Result<Box<dyn Planner>, PlanError> {
    let Entry { default, with } = entry(name)?;
    let defaults = default.settings();
    let mut all = defaults.as_object().cloned().unwrap_or_default();
    for (setting, value) in settings {
        let Some(place) = all.get_mut(setting) else {
            let known = all.keys().cloned().collect::<Vec<_>>().join(", ");
            return Err(PlanError::UnknownSetting {
                planner: name.to_owned(),
                setting: setting.clone(),
                known,
            });
        };
        check_kind(name, setting, place, value)?;
        check_range(name, setting, value)?;
        place.clone_from(value);
    }
    with(name, all)
}

fn read<T: DeserializeOwned>(planner: &str, settings: Map<String, Value>) -> Result<T, PlanError> {
    serde_json::from_value(Value::Object(settings))
        .map_err(|reason| PlanError::Setting { planner: planner.to_owned(), problem: reason.to_string() })
}

/// A setting is of the kind of its default.
fn check_kind(planner: &str, setting: &str, default: &Value, value: &Value) -> Result<(), PlanError> {
    let kind = |value: &Value| match value {
        Value::Number(number) if number.is_u64() => "a whole number, at least 0",
        Value::Number(_) => "a number",
        Value::Bool(_) => "true or false",
        Value::String(_) => "a name",
        Value::Null | Value::Array(_) | Value::Object(_) => "",
    };
    let expected = kind(default);
    // A number may be whole.
    if expected == kind(value) || (expected == "a number" && value.is_number()) || expected.is_empty() {
        return Ok(());
    }
    let problem = format!("'{setting}' is {value}, but must be {expected}");
    Err(PlanError::Setting { planner: planner.to_owned(), problem })
}

/// Probabilities (`p_…`) and scores (`…_score`) lie in [0, 1]; whatever else is a number is above 0, and a growth has but so many looks.
fn check_range(planner: &str, setting: &str, value: &Value) -> Result<(), PlanError> {
    let Some(number) = value.as_f64() else { return Ok(()) };
    let (is_good, range) = if setting.starts_with("p_") || setting.ends_with("_score") {
        ((0.0..=1.0).contains(&number), "in [0, 1]".to_owned())
    } else if setting == "looks" {
        (number > 0.0 && number <= LANES as f64, format!("above 0 and at most {LANES}"))
    } else {
        (number > 0.0, "above 0".to_owned())
    };
    let problem = || format!("'{setting}' is {number}, but must be {range}");
    is_good
        .then_some(())
        .ok_or_else(|| PlanError::Setting { planner: planner.to_owned(), problem: problem() })
}

/// The names of all planners.
pub fn planner_names() -> Vec<&'static str> {
    all().iter().map(|entry| entry.default.name()).collect()
}

/// The names of those that make grasps of their own ([`Planner::makes_grasps`]).
pub fn grasp_makers() -> Vec<&'static str> {
    let makers = all().into_iter().filter(|entry| entry.default.makes_grasps());
    makers.map(|entry| entry.default.name()).collect()
}

/// The planner to take where none is named: the flagship, or where no set of grasps is given the same with grasps of its
/// own, or under `paper`, which it does not take, the better of the paper's two.
pub fn default_planner(problem: &Problem) -> Box<dyn Planner> {
    match problem.criterion() {
        Criterion::Exact if problem.grasp_measure().is_some() => Box::new(GraspReach::default()),
        Criterion::Exact => Box::new(Reach::default()),
        Criterion::Paper => Box::new(IkRrt::default()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(value: &Value) -> Map<String, Value> {
        value.as_object().cloned().expect("an object")
    }

    #[test]
    fn settings_replace_the_defaults_of_their_names_alone() {
        for name in planner_names() {
            let defaults = planner(name).expect("a planner").settings();
            let again = planner_with(name, &settings(&defaults)).expect("its own settings");
            assert_eq!((again.name(), again.settings()), (name, defaults));
        }
        let changed =
            planner_with("ik-rrt", &settings(&serde_json::json!({"p_goal": 0.25}))).expect("a planner");
        assert_eq!(changed.settings(), serde_json::json!(IkRrt { p_goal: 0.25, ..IkRrt::default() }));
        let changed = planner_with("reach", &settings(&serde_json::json!({"looks": 8}))).expect("a planner");
        assert_eq!(changed.settings(), serde_json::json!(Reach { looks: 8, ..Reach::default() }));
    }

    #[test]
    fn settings_that_are_none_are_named() {
        let fault =
            |name, value: Value| planner_with(name, &settings(&value)).err().expect("a fault").to_string();
        let message = fault("reach", serde_json::json!({"stepp": 1}));
        assert!(message.contains("'stepp'") && message.contains("looks, step"), "{message}");
        let message = fault("ik-rrt", serde_json::json!({"p_goal": 1.5}));
        assert!(message.contains("'p_goal' is 1.5") && message.contains("[0, 1]"), "{message}");
        assert!(fault("reach", serde_json::json!({"looks": 17})).contains("at most 16"));
        assert!(fault("reach", serde_json::json!({"step": 0})).contains("above 0"));
        assert!(
            fault("j-plus-rrt", serde_json::json!({"step_m": "far"}))
                .contains("\"far\", but must be a number")
        );
        assert!(
            fault("reach", serde_json::json!({"looks": 2.5})).contains("2.5, but must be a whole number")
        );
        assert!(fault("j-plus-rrt", serde_json::json!({"choice": "best"})).contains("by-score"));
        assert!(fault("nobody", serde_json::json!({})).contains("nobody"));
    }
}
