use std::cell::OnceCell;
use std::collections::HashMap;
use std::path::Path;
use std::rc::Rc;
use std::sync::atomic::AtomicBool;

use cranny_collision::Margins;
use cranny_scenario::{Identity, OpenOptions, Scenario, ScenarioError};
use cranny_task::{Criterion, IkAnnotationSettings, IkMethod, Problem, annotate_ik};

use crate::{BenchError, PathDemand, Trial};

/// A scenario, opened under a criterion, with its problem: what takes longer than many a trial.
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

    /// Its goal configurations (m, rad; one value per joint), as [`goals_of`].
    pub fn goals(&self) -> Result<&[Vec<f64>], ScenarioError> {
        if let Some(goals) = self.goals.get() {
            return Ok(goals);
        }
        let goals = goals_of(&self.source, &self.scenario)?;
        Ok(self.goals.get_or_init(|| goals))
    }
}

/// The goal configurations of a scenario (`G_IK` in the paper; m, rad; one value per joint), one for each grasp that
/// has any: those of its files; a scenario in Cranny's layout that has none gets what the paper's single shot finds
/// from its start under the exact criterion, the same on every machine.
pub fn goals_of(source: &str, scenario: &Scenario) -> Result<Vec<Vec<f64>>, ScenarioError> {
    // Of a released scenario an empty file is an answer: no grasp has a solution.
    if !scenario.ik.is_empty() || Path::new(source).join("scene.yaml").is_file() {
        return Ok(scenario.ik.clone());
    }
    let exact = OpenOptions { criterion: Some(Criterion::Exact), ..OpenOptions::default() };
    let problem = Scenario::open(source, &exact)?.problem(Margins::default())?;
    let settings = IkAnnotationSettings { method: IkMethod::SingleShot, ..IkAnnotationSettings::default() };
    let annotations = annotate_ik(&problem, &settings, &|| {}, &AtomicBool::new(false))?;
    Ok(annotations.into_iter().flat_map(|grasp| grasp.solutions).map(|solution| solution.q).collect())
}

/// The scenarios that a worker has opened so far.
#[derive(Default)]
pub struct OpenedScenarios {
    opened: HashMap<(String, &'static str, String), Rc<OpenedScenario>>,
}

impl OpenedScenarios {
    /// The scenario of this content, opened now if it has not been before.
    ///
    /// # Errors
    /// [`BenchError::ChangedScenario`] where the files are others than those of the campaign; those of opening it.
    pub fn get(
        &mut self,
        trial: &Trial,
        source: &str,
        criterion: Criterion,
    ) -> Result<Rc<OpenedScenario>, BenchError> {
        // Before each trial: files may be edited while a campaign runs, and some are read only now.
        if Identity::of(source)?.sha256 != trial.scenario_hash {
            let (scenario, source_name) = (trial.scenario.clone(), source.to_owned());
            return Err(BenchError::ChangedScenario { scenario, source_name });
        }
        // Where an object is carried to, and how firmly it is held, plays no part.
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
