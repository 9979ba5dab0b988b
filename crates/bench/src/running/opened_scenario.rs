use std::cell::OnceCell;
use std::collections::HashMap;
use std::path::Path;
use std::rc::Rc;
use std::sync::atomic::AtomicBool;

use cranny_collision::Margins;
use cranny_scenario::{Identity, OpenOptions, Scenario, ScenarioError};
use cranny_task::{Criterion, IkAnnotationSettings, IkMethod, Problem, annotate_ik};

use crate::{BenchError, PathDemand, Trial};

/// Scenario opened under a criterion, with its problem. Opening may take longer than a trial.
pub struct OpenedScenario {
    pub scenario: Scenario,
    pub problem: Problem,
    source: String,
    goals: OnceCell<Vec<Vec<f64>>>,
}

impl OpenedScenario {
    pub fn open(source: &str, criterion: Criterion, demand: &PathDemand) -> Result<Self, ScenarioError> {
        let grasps = demand.given_grasps();
        let options = OpenOptions { criterion: Some(criterion), grasps, ..OpenOptions::default() };
        let scenario = Scenario::open(source, &options)?;
        let problem =
            scenario.problem(cranny_record::margins_forgiving(&scenario, demand.margins, demand.robust)?)?;
        Ok(Self { scenario, problem, source: source.to_owned(), goals: OnceCell::new() })
    }

    /// Returns its goal configurations (m, rad; one value per joint), as [`goals_of`].
    pub fn goals(&self) -> Result<&[Vec<f64>], ScenarioError> {
        if let Some(goals) = self.goals.get() {
            return Ok(goals);
        }
        let goals = goals_of(&self.source, &self.scenario)?;
        Ok(self.goals.get_or_init(|| goals))
    }
}

/// Returns the goal configurations of a scenario (`G_IK` in the paper; m, rad; one value per joint), one for each grasp
/// that has any, from its files. A scenario in Cranny's layout without them gets the solutions of the paper's single shot
/// from its start under the exact criterion, identical on every machine.
pub fn goals_of(source: &str, scenario: &Scenario) -> Result<Vec<Vec<f64>>, ScenarioError> {
    // An empty file of a released scenario is a result: no grasp has a solution.
    if !scenario.ik.is_empty() || Path::new(source).join("scene.yaml").is_file() {
        return Ok(scenario.ik.clone());
    }
    let exact = OpenOptions { criterion: Some(Criterion::Exact), ..OpenOptions::default() };
    let problem = Scenario::open(source, &exact)?.problem(Margins::default())?;
    let settings = IkAnnotationSettings { method: IkMethod::SingleShot, ..IkAnnotationSettings::default() };
    let annotations = annotate_ik(&problem, &settings, &|| {}, &AtomicBool::new(false))?;
    Ok(annotations.into_iter().flat_map(|grasp| grasp.solutions).map(|solution| solution.q).collect())
}

/// Cache of the scenarios that a worker has opened.
#[derive(Default)]
pub struct OpenedScenarios {
    opened: HashMap<(String, &'static str, String), Rc<OpenedScenario>>,
}

impl OpenedScenarios {
    /// Returns the scenario with this content and opens it at the first call.
    ///
    /// # Errors
    /// [`BenchError::ChangedScenario`] if the files differ from those of the campaign; errors of opening it.
    pub fn get(
        &mut self,
        trial: &Trial,
        source: &str,
        criterion: Criterion,
    ) -> Result<Rc<OpenedScenario>, BenchError> {
        // The check precedes each trial: files may be edited during a campaign, and some are read only later.
        if Identity::of(source)?.sha256 != trial.scenario_hash {
            let (scenario, source_name) = (trial.scenario.clone(), source.to_owned());
            return Err(BenchError::ChangedScenario { scenario, source_name });
        }
        // The destination and the grip do not affect the opened scenario.
        let demand =
            PathDemand { carry: None, task: None, hold: None, ..PathDemand::of_settings(&trial.settings) };
        let key = (source.to_owned(), criterion.name(), format!("{demand:?}"));
        if let Some(opened) = self.opened.get(&key) {
            return Ok(opened.clone());
        }
        let opened = Rc::new(OpenedScenario::open(source, criterion, &demand)?);
        self.opened.insert(key, opened.clone());
        Ok(opened)
    }
}
