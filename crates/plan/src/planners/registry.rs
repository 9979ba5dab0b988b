use std::fmt;
use std::sync::Arc;
use std::time::Duration;

use cranny_task::{Criterion, Problem};
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use crate::{
    ApproachRrt, Budget, Cbirrt2, Chomp, Est, Gomp, GraspReach, GraspRrt, IkRbt, IkRrt, JPlusRbt, JPlusRrt,
    Kpiece, LazyPrm, Omg, Outcome, PlanError, Planner, Prm, RbtConnect, Reach, Rrt, RrtConnect, RrtStar,
    Stomp, Unobserved,
};

/// Planners by name. [`Registry::default`] has the built-in ones, and [`Registry::with`] adds others.
#[derive(Clone)]
pub struct Registry {
    entries: Vec<Entry>,
}

type Made = Result<Box<dyn Planner>, PlanError>;

#[derive(Clone)]
struct Entry {
    default: Arc<dyn Planner>,
    /// Constructor with these settings, which must be complete.
    with: fn(&str, Map<String, Value>) -> Made,
}

impl Entry {
    fn of<T: Planner + Default + DeserializeOwned + 'static>() -> Self {
        Self {
            default: Arc::new(T::default()),
            with: |name, settings| {
                let planner: T = serde_json::from_value(Value::Object(settings)).map_err(|reason| {
                    PlanError::Setting { planner: name.to_owned(), problem: reason.to_string() }
                })?;
                planner.check()?;
                Ok(Box::new(planner))
            },
        }
    }
}

impl Default for Registry {
    /// Returns all built-in planners, in the order in which lists show them.
    fn default() -> Self {
        let entries = vec![
            Entry::of::<Reach>(),
            Entry::of::<GraspReach>(),
            Entry::of::<RrtConnect>(),
            Entry::of::<RbtConnect>(),
            Entry::of::<Rrt>(),
            Entry::of::<RrtStar>(),
            Entry::of::<Prm>(),
            Entry::of::<LazyPrm>(),
            Entry::of::<Est>(),
            Entry::of::<Kpiece>(),
            Entry::of::<IkRrt>(),
            Entry::of::<IkRbt>(),
            Entry::of::<JPlusRrt>(),
            Entry::of::<JPlusRbt>(),
            Entry::of::<GraspRrt>(),
            Entry::of::<ApproachRrt>(),
            Entry::of::<Cbirrt2>(),
            Entry::of::<Chomp>(),
            Entry::of::<Stomp>(),
            Entry::of::<Omg>(),
            Entry::of::<Gomp>(),
        ];
        Self { entries }
    }
}

impl fmt::Debug for Registry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Registry").field(&self.names()).finish()
    }
}

/// Compares the names of the planners.
impl PartialEq for Registry {
    fn eq(&self, other: &Self) -> bool {
        self.names() == other.names()
    }
}

impl Registry {
    /// Returns this registry with an additional planner. Its settings are the fields of `T`, by their serde names.
    ///
    /// # Errors
    /// [`PlanError::DuplicatePlanner`] for a name that is taken.
    pub fn with<T: Planner + Default + DeserializeOwned + 'static>(mut self) -> Result<Self, PlanError> {
        let entry = Entry::of::<T>();
        let name = entry.default.name();
        if self.names().contains(&name) {
            return Err(PlanError::DuplicatePlanner { name });
        }
        self.entries.push(entry);
        Ok(self)
    }

    /// Returns the names of all planners.
    pub fn names(&self) -> Vec<&'static str> {
        self.entries.iter().map(|entry| entry.default.name()).collect()
    }

    /// Returns the names of the planners that generate grasps ([`Planner::makes_grasps`]).
    pub fn grasp_makers(&self) -> Vec<&'static str> {
        let makers = self.entries.iter().filter(|entry| entry.default.makes_grasps());
        makers.map(|entry| entry.default.name()).collect()
    }

    /// Returns the planner of that name, with its default settings.
    ///
    /// # Errors
    /// [`PlanError::UnknownPlanner`], which lists the existing names.
    pub fn planner(&self, name: &str) -> Result<Arc<dyn Planner>, PlanError> {
        self.entry(name).map(|entry| entry.default.clone())
    }

    /// Creates the planner of that name, with `settings` instead of the defaults of the same names.
    ///
    /// # Errors
    /// As [`Self::planner`]; [`PlanError::UnknownSetting`], which lists the existing ones; [`PlanError::Setting`] for a value
    /// of another type, or out of its range ([`Planner::check`]).
    pub fn planner_with(
        &self,
        name: &str,
        settings: &Map<String, Value>,
    ) -> Result<Box<dyn Planner>, PlanError> {
        let Entry { default, with } = self.entry(name)?;
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
            place.clone_from(value);
        }
        with(name, all)
    }

    fn entry(&self, name: &str) -> Result<&Entry, PlanError> {
        let unknown = || PlanError::UnknownPlanner { name: name.to_owned(), known: self.names().join(", ") };
        self.entries.iter().find(|entry| entry.default.name() == name).ok_or_else(unknown)
    }
}

/// Returns the default planner of a problem: [`Reach`], or [`GraspReach`] without a set of grasps, or under `paper` [`IkRrt`],
/// the better of the two in the paper.
pub fn default_planner(problem: &Problem) -> Box<dyn Planner> {
    match problem.criterion() {
        Criterion::Exact if problem.grasp_measure().is_some() => Box::new(GraspReach::default()),
        Criterion::Exact => Box::new(Reach::default()),
        Criterion::Paper => Box::new(IkRrt::default()),
    }
}

/// Returns true if a short search by the default planner finds a path to a grasp of a problem, or to its goal configurations.
///
/// # Errors
/// Those of the planner.
pub fn is_reached(problem: &Problem) -> Result<bool, PlanError> {
    const BUDGET: Budget = Budget { iterations: 5000, time: Duration::MAX };
    let report = default_planner(problem).plan(problem, &BUDGET, 0, &mut Unobserved)?;
    Ok(report.outcome == Outcome::Solved)
}

/// Checks that a setting has the type of its default.
fn check_kind(planner: &str, setting: &str, default: &Value, value: &Value) -> Result<(), PlanError> {
    let kind = |value: &Value| match value {
        Value::Number(number) if number.is_u64() => "a whole number, at least 0",
        Value::Number(_) => "a number",
        Value::Bool(_) => "true or false",
        Value::String(_) => "a name",
        Value::Null | Value::Array(_) | Value::Object(_) => "",
    };
    let expected = kind(default);
    // A setting with a real default also accepts whole numbers.
    if expected == kind(value) || (expected == "a number" && value.is_number()) || expected.is_empty() {
        return Ok(());
    }
    let problem = format!("'{setting}' is {value}, but must be {expected}");
    Err(PlanError::Setting { planner: planner.to_owned(), problem })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn known() -> Registry {
        Registry::default()
    }

    fn settings(value: &Value) -> Map<String, Value> {
        value.as_object().cloned().expect("an object")
    }

    #[test]
    fn settings_replace_the_defaults_of_their_names_alone() {
        for name in known().names() {
            let defaults = known().planner(name).expect("a planner").settings();
            let again = known().planner_with(name, &settings(&defaults)).expect("its own settings");
            assert_eq!((again.name(), again.settings()), (name, defaults));
        }
        let changed = known()
            .planner_with("ik-rrt", &settings(&serde_json::json!({"p_goal": 0.25})))
            .expect("a planner");
        assert_eq!(changed.settings(), serde_json::json!(IkRrt { p_goal: 0.25, ..IkRrt::default() }));
        let changed =
            known().planner_with("reach", &settings(&serde_json::json!({"looks": 8}))).expect("a planner");
        assert_eq!(changed.settings(), serde_json::json!(Reach { looks: 8, ..Reach::default() }));
    }

    #[test]
    fn settings_that_are_none_are_named() {
        let fault = |name, value: Value| {
            known().planner_with(name, &settings(&value)).err().expect("a fault").to_string()
        };
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

    #[test]
    fn who_makes_grasps_is_named_where_a_set_of_them_is_missing() {
        let message = cranny_task::TaskError::NoGraspSet.to_string();
        assert!(known().grasp_makers().into_iter().all(|name| message.contains(name)), "{message}");
    }

    #[test]
    fn a_name_is_given_once() {
        assert!(matches!(known().with::<Reach>(), Err(PlanError::DuplicatePlanner { name: "reach" })));
    }
}
