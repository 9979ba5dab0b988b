use std::collections::BTreeMap;

use cranny_collision::Margins;
use cranny_scenario::{GivenGrasps, Scenario, ScenarioError};
use cranny_solve::{DEFAULT_HOLD, PoseRadius};
use cranny_task::Stage;
use serde_json::Value;

use crate::CarryTo;

/// What the trials of a campaign ask of a path beyond its criterion.
///
/// It stands among the settings of a trial, as far as it is not the usual: trials that ask for more are others, and those
/// that do not are the same as before there was more to ask for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PathDemand {
    /// Where the target is carried to, once it is grasped. Default: the path ends at the grasp.
    pub carry: Option<CarryTo>,
    /// Name of the task of each scenario that is done instead. Default: none.
    pub task: Option<String>,
    /// How much clearance it keeps. Default: contact alone counts.
    pub margins: Margins,
    /// How far the target may be from where it is thought to be. Default: it is there.
    pub robust: Option<PoseRadius>,
    /// Factor by which the hand holds at least what a built-in planner carries, from 0 (nothing demanded). Default:
    /// [`DEFAULT_HOLD`].
    pub hold: Option<f64>,
    /// Whether no set of grasps is given, so that a path ends at a grasp that its planner made. Default: one is.
    pub without_grasp_set: bool,
}

/// What it is called among settings.
const CARRY: &str = "carry";
const TASK: &str = "task";
const MARGIN: &str = "margin_m";
const GRASP_MARGIN: &str = "grasp_margin_m";
const ROBUST_M: &str = "robust_m";
const ROBUST_RAD: &str = "robust_rad";
const HOLD: &str = "hold";
/// The only word for grasps that there is.
const NONE: &str = "none";

impl PathDemand {
    /// Under what whether a set of grasps is given stands among settings.
    pub(crate) const GRASPS: &str = "grasps";

    /// The stages of a trial in a scenario; empty where the path ends at the goal of its problem.
    ///
    /// # Errors
    /// [`ScenarioError::UnknownTask`], [`TaskError::Place`](cranny_task::TaskError::Place) for a scenario without a place to put anything down.
    pub(crate) fn stages_in(&self, scenario: &Scenario) -> Result<Vec<Stage>, ScenarioError> {
        let stages = match (&self.task, self.carry) {
            (Some(name), _) => scenario.task(name)?.stages.clone(),
            (None, Some(carry)) => carry.stages(scenario)?,
            (None, None) => Vec::new(),
        };
        Ok(match self.robust {
            Some(error) => scenario.forgiving(&stages, error.translation_m, error.rotation_rad),
            None => stages,
        })
    }

    /// The settings of a planner, as canonical JSON, with what the trial asks of it.
    pub(crate) fn among(&self, settings: String) -> String {
        if *self == Self::default() {
            return settings;
        }
        let parsed = serde_json::from_str(&settings);
        // Sorted by their keys, as they were.
        let mut all: BTreeMap<&str, Value> = parsed.unwrap_or_default();
        if let Some(carry) = self.carry {
            all.insert(CARRY, carry.name().into());
        }
        if let Some(task) = &self.task {
            all.insert(TASK, task.as_str().into());
        }
        if let Some(hold) = self.hold.filter(|hold| *hold != DEFAULT_HOLD) {
            all.insert(HOLD, hold.into());
        }
        if self.without_grasp_set {
            all.insert(Self::GRASPS, NONE.into());
        }
        let Margins { margin_m, grasp_margin_m, .. } = self.margins;
        let (robust_m, robust_rad) =
            self.robust.map(|error| (error.translation_m, error.rotation_rad)).unzip();
        for (key, value) in [
            (MARGIN, margin_m),
            (GRASP_MARGIN, grasp_margin_m),
            (ROBUST_M, robust_m.unwrap_or_default()),
            (ROBUST_RAD, robust_rad.unwrap_or_default()),
        ] {
            if value != 0.0 {
                all.insert(key, value.into());
            }
        }
        serde_json::json!(all).to_string()
    }

    /// What the settings of a trial ask.
    pub fn of_settings(settings: &str) -> Self {
        let all: BTreeMap<String, Value> = serde_json::from_str(settings).unwrap_or_default();
        let number = |key| all.get(key).and_then(Value::as_f64);
        let metres = |key| number(key).unwrap_or_default();
        Self {
            carry: all.get(CARRY).and_then(Value::as_str).and_then(|name| name.parse().ok()),
            task: all.get(TASK).and_then(Value::as_str).map(str::to_owned),
            margins: Margins {
                margin_m: metres(MARGIN),
                grasp_margin_m: metres(GRASP_MARGIN),
                ..Margins::default()
            },
            robust: number(ROBUST_M)
                .or_else(|| number(ROBUST_RAD))
                .map(|_| PoseRadius { translation_m: metres(ROBUST_M), rotation_rad: metres(ROBUST_RAD) }),
            hold: number(HOLD),
            without_grasp_set: all.get(Self::GRASPS).and_then(Value::as_str) == Some(NONE),
        }
    }

    /// Which grasps a path may end at.
    pub fn given_grasps(&self) -> GivenGrasps {
        if self.without_grasp_set { GivenGrasps::None } else { GivenGrasps::Own }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_asked_is_read_back_from_settings_and_the_usual_leaves_them_as_they_are() {
        let settings = r#"{"planner":"reach","step":0.25}"#.to_owned();
        assert_eq!(PathDemand::default().among(settings.clone()), settings);
        assert_eq!(PathDemand::of_settings(&settings), PathDemand::default());
        let margins = Margins { margin_m: 0.005, grasp_margin_m: 0.001, ..Margins::default() };
        for demand in [
            PathDemand { carry: Some(CarryTo::Home), ..PathDemand::default() },
            PathDemand { task: Some("tidy".to_owned()), ..PathDemand::default() },
            PathDemand { margins, ..PathDemand::default() },
            PathDemand { carry: Some(CarryTo::Out), margins, ..PathDemand::default() },
            PathDemand { without_grasp_set: true, ..PathDemand::default() },
            PathDemand { hold: Some(0.0), ..PathDemand::default() },
            PathDemand {
                carry: Some(CarryTo::Home),
                task: None,
                margins,
                robust: Some(PoseRadius { translation_m: 0.0, rotation_rad: 0.1 }),
                hold: Some(2.5),
                without_grasp_set: true,
            },
        ] {
            assert_eq!(PathDemand::of_settings(&demand.among(settings.clone())), demand);
        }
    }
}
