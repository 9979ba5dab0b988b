use std::cell::{OnceCell, RefCell};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::atomic::AtomicBool;

use cranny_collision::Margins;
use cranny_file::system;
use cranny_scenario::{Identity, OpenOptions, Scenario, ScenarioError};
use cranny_task::{Criterion, IkAnnotationSettings, IkMethod, Problem, annotate_ik};

use crate::store::exports::ExportFolder;
use crate::{BenchError, PathDemand, Trial};

/// Scenario opened under a criterion, with its problem. Opening may take longer than a trial.
pub struct OpenedScenario {
    pub scenario: Scenario,
    pub problem: Problem,
    source: String,
    goals: OnceCell<Vec<Vec<f64>>>,
    /// Folder of its files for external programs, which is removed with it.
    export: RefCell<Option<ExportFolder>>,
}

impl OpenedScenario {
    pub fn open(source: &str, criterion: Criterion, demand: &PathDemand) -> Result<Self, ScenarioError> {
        let grasps = demand.given_grasps();
        let options = OpenOptions { criterion: Some(criterion), grasps, ..OpenOptions::default() };
        let scenario = Scenario::open(source, &options)?;
        let problem =
            scenario.problem(cranny_record::margins_forgiving(&scenario, demand.margins, demand.robust)?)?;
        Ok(Self {
            scenario,
            problem,
            source: source.to_owned(),
            goals: OnceCell::new(),
            export: RefCell::default(),
        })
    }

    /// Returns its goal configurations (m, rad; one value per joint), as [`goals_of`].
    pub fn goals(&self) -> Result<&[Vec<f64>], ScenarioError> {
        if let Some(goals) = self.goals.get() {
            return Ok(goals);
        }
        let goals = goals_of(&self.source, &self.scenario)?;
        Ok(self.goals.get_or_init(|| goals))
    }

    /// Returns the folder of its files for external programs, which is created within `exports` if there is none.
    pub fn export_folder(&self, exports: &Path) -> Result<PathBuf, ScenarioError> {
        let mut export = self.export.borrow_mut();
        if let Some(export) = &*export {
            return Ok(export.path().to_owned());
        }
        let new = ExportFolder::new_in(exports, "scenario-")
            .map_err(|reason| ScenarioError::Unwritable { path: exports.to_owned(), reason })?;
        Ok(export.insert(new).path().to_owned())
    }

    /// Removes the folder of its files for external programs; the next trial gets another one.
    pub fn discard_export(&self) {
        self.export.take();
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

/// Maximum number of scenarios that a worker keeps: a campaign takes the scenarios in turn, and 20 are built in.
const MOST_OPENED: usize = 24;

/// Maximum memory of these scenarios, in bytes, except for the one in use.
const MOST_OPENED_BYTES: u64 = 256 << 20;

/// Memory of an opened scenario per byte of its files, at least: the growth of the process is less after an eviction, whose
/// memory is used again.
const BYTES_PER_FILE_BYTE: u64 = 16;

/// Source, criterion and demand of an opened scenario.
type Key = (String, &'static str, String);

/// Cache of the scenarios that a worker used last.
#[derive(Default)]
pub struct OpenedScenarios {
    /// Scenarios with their memory in bytes, as estimated; the one used last is the last.
    opened: Vec<(Key, Rc<OpenedScenario>, u64)>,
}

impl OpenedScenarios {
    /// Returns the scenario with this content, opened unless it is in the cache.
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
        let identity = Identity::of(source)?;
        if identity.sha256 != trial.scenario_hash {
            let (scenario, source_name) = (trial.scenario.clone(), source.to_owned());
            return Err(BenchError::ChangedScenario { scenario, source_name });
        }
        // Destination, grip and physics do not affect the opened scenario.
        let (carry, task, hold, try_in_physics) = (None, None, None, None);
        let demand =
            PathDemand { carry, task, hold, try_in_physics, ..PathDemand::of_settings(&trial.settings) };
        let key = (source.to_owned(), criterion.name(), format!("{demand:?}"));
        let known = self.opened.iter().position(|(known, ..)| *known == key);
        let entry = if let Some(known) = known {
            self.opened.remove(known)
        } else {
            let resident_bytes = || system::own_memory().map_or(0, |memory| memory.resident_bytes);
            let before_bytes = resident_bytes();
            let opened = Rc::new(OpenedScenario::open(source, criterion, &demand)?);
            let growth_bytes = resident_bytes().saturating_sub(before_bytes);
            (key, opened, growth_bytes.max(BYTES_PER_FILE_BYTE * identity.bytes))
        };
        let opened = entry.1.clone();
        self.keep(entry);
        Ok(opened)
    }

    /// Adds a scenario, and removes those that were not used for longest, beyond the limits.
    fn keep(&mut self, entry: (Key, Rc<OpenedScenario>, u64)) {
        self.opened.push(entry);
        let total =
            |opened: &[(Key, Rc<OpenedScenario>, u64)]| opened.iter().map(|entry| entry.2).sum::<u64>();
        while self.opened.len() > MOST_OPENED
            || self.opened.len() > 1 && total(&self.opened) > MOST_OPENED_BYTES
        {
            self.opened.remove(0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_worker_keeps_few_scenarios_and_their_files() {
        let (mut scenarios, exports) = (OpenedScenarios::default(), tempfile::tempdir().unwrap());
        let trial = Trial {
            scenario: "021".into(),
            scenario_hash: Identity::of("021").unwrap().sha256,
            planner: "x".into(),
            settings: "{}".into(),
            criterion: Criterion::Exact,
            seed: 0,
            time_limit_s: 1.0,
            iteration_limit: None,
            goal: None,
        };
        let used = scenarios.get(&trial, "021", Criterion::Exact).unwrap();
        let folders = || std::fs::read_dir(exports.path()).unwrap().count();
        let other = || {
            let (scenario, problem) = (used.scenario.clone(), used.problem.clone());
            let (goals, export) = (OnceCell::new(), RefCell::default());
            let opened = OpenedScenario { scenario, problem, source: "021".into(), goals, export };
            opened.export_folder(exports.path()).unwrap();
            Rc::new(opened)
        };
        for number in 0..500 {
            let key = (number.to_string(), "exact", String::new());
            scenarios.keep((key, other(), 0));
            let again = scenarios.get(&trial, "021", Criterion::Exact).unwrap();
            assert!(Rc::ptr_eq(&again, &used), "the scenario in use stays");
            assert!(scenarios.opened.len() <= MOST_OPENED && folders() < MOST_OPENED);
        }
        assert_eq!((scenarios.opened.len(), folders()), (MOST_OPENED, MOST_OPENED - 1));
        let key = |name: &str| (name.to_owned(), "exact", String::new());
        for name in ["a", "b", "c", "d", "e", "f"] {
            scenarios.keep((key(name), other(), MOST_OPENED_BYTES / 4));
        }
        assert_eq!(scenarios.opened.len(), 4);
        scenarios.keep((key("large"), other(), 2 * MOST_OPENED_BYTES));
        assert_eq!(
            (scenarios.opened.len(), folders()),
            (1, 1),
            "the scenario in use stays, however large it is"
        );
    }
}
