use std::path::Path;

use cranny_collision::Margins;
use cranny_plan::{Audit, AuditSettings, CarryEnd, Observer, PlaceSettings, PlanError, Problem};
use cranny_solve::{Carry, Request, SolveError, solve};
use serde::{Deserialize, Serialize};

use crate::plan::reading::Head;
use crate::{
    GivenGrasps, PlanFile, PlanPlace, PlanSource, Scenario, ScenarioError, Step, TargetPhysics,
    write_whole_file,
};

impl Scenario {
    /// The scenario in which what a step picks is the target.
    ///
    /// # Errors
    /// As [`Self::with_target`].
    pub fn at_step(&self, step: &Step) -> Result<Self, ScenarioError> {
        self.with_target(&step.pick, step.physics)
    }

    /// The scenario in which a body of this name is the target. Its own target has its own grasps, mass and friction; of
    /// anything else no grasps are given, and whoever plans makes one.
    ///
    /// # Errors
    /// [`ScenarioError::Plan`] for the name of nothing.
    pub fn with_target(&self, name: &str, given_physics: TargetPhysics) -> Result<Self, ScenarioError> {
        let target = self.world.body_index(name).map_err(PlanError::from)?;
        if self.target == Some(target) {
            return Ok(self.clone());
        }
        Ok(Self { target: Some(target), target_source: None, given_physics, ..self.without_grasps() })
    }

    /// The scenario as it is once a plan has been carried out that put the target of its problem down: this has moved, and
    /// the robot stands where the plan ends. The scenario's own grasps move with its target.
    ///
    /// # Errors
    /// [`ScenarioError::Plan`] for a plan that puts nothing down.
    pub fn after(&self, plan: &PlanFile, problem: &Problem) -> Result<Self, ScenarioError> {
        let placed = plan.task_cells(problem)?.and_then(|cells| cells.placed().copied());
        let carried =
            problem.cell().zip(problem.target()).map(|(cell, target)| &cell.world().bodies()[target]);
        let (Some(carried), Some(placed), Some(end)) = (carried, placed, plan.waypoints.last()) else {
            return Err(PlanError::Segments.into());
        };
        // By its name: the problem may be of another scenario.
        let target = self.world.body_index(&carried.name).map_err(PlanError::from)?;
        let first = self.world.bodies()[target].parts.first().map(|part| part.world_from_solid);
        self.with_moved(target, &(placed * first.unwrap_or_default().inverse()), end)
    }
}

/// The plans of a scenario's steps, each in the world that the one before it leaves: what the plan file of several steps
/// holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SequencePlan {
    /// [`Self::FORMAT`].
    pub format: String,
    /// Id of the scenario.
    pub scenario: String,
    /// The plan of each step, in order: all of them, or up to the first that has none.
    pub steps: Vec<PlanFile>,
    /// From the first way point to the last, in seconds; `None` where a step has no path, or no time.
    pub duration_s: Option<f64>,
}

impl SequencePlan {
    /// The format that this version writes.
    pub const FORMAT: &str = "cranny-sequence/1";

    /// Plans the steps of a scenario one after the other, until one has no path that holds; and whether all have. What a
    /// request says of where things are carried is not asked: the steps say that.
    ///
    /// # Errors
    /// [`SequenceError`]: of the scenario, or of a search.
    pub fn solve(
        scenario: &Scenario,
        source: &PlanSource,
        request: &Request,
        observer: &mut dyn Observer,
    ) -> Result<(Self, bool), SequenceError> {
        let mut now = scenario.clone();
        let (mut steps, mut solved) = (Vec::new(), 0);
        for step in &scenario.steps {
            let problem = now.at_step(step)?.problem(source.margins)?;
            let goal = problem.place(&step.place).map_err(ScenarioError::from)?.clone();
            let place = PlaceSettings { goal, clear_m: PlaceSettings::CLEAR_M, then: step.then };
            let carry = Some(Carry { end: CarryEnd::Place(place), ..Carry::default() });
            let answer = solve(&problem, &Request { carry, ..request.clone() }, observer)?;
            let plan = PlanFile::of(&answer, source);
            let is_solved = answer.is_solved();
            if is_solved {
                now = now.after(&plan, &problem)?;
                solved += 1;
            }
            steps.push(plan);
            if !is_solved {
                break;
            }
        }
        Ok((Self::of(scenario, steps), solved == scenario.steps.len()))
    }

    /// Plans of a scenario's steps, whoever made them.
    pub fn of(scenario: &Scenario, steps: Vec<PlanFile>) -> Self {
        let is_whole = steps.len() == scenario.steps.len();
        let durations = steps.iter().map(|plan| plan.timing.as_ref().map(|timing| timing.duration_s));
        let duration_s = durations.sum::<Option<f64>>().filter(|_| is_whole);
        Self { format: Self::FORMAT.to_owned(), scenario: scenario.id.clone(), steps, duration_s }
    }

    /// Shows `visit` each plan in the world that those before it leave, as long as it says to go on.
    ///
    /// # Errors
    /// Those of `visit`, and [`ScenarioError::Plan`] for what is no plan of the scenario's steps, or puts nothing down where
    /// it is to go on.
    pub fn walk<E: From<ScenarioError>>(
        &self,
        scenario: &Scenario,
        margins: Margins,
        mut visit: impl FnMut(StepTask<'_>) -> Result<bool, E>,
    ) -> Result<(), E> {
        let mut now = scenario.clone();
        for (step, plan) in scenario.steps.iter().zip(&self.steps) {
            let of_step = now.at_step(step)?;
            let problem = of_step.problem(margins)?;
            // Whatever the file says: the steps say what is picked and where it goes.
            step.check(plan).map_err(ScenarioError::from)?;
            if !visit(StepTask { plan, scenario: &of_step, problem: &problem })? {
                break;
            }
            now = now.after(plan, &problem)?;
        }
        Ok(())
    }

    /// What the judge says of each plan, in the world that those before it leave; nothing of what follows one that does not
    /// hold.
    ///
    /// # Errors
    /// [`ScenarioError::Plan`] for what is no plan of the scenario's steps.
    pub fn audit(
        &self,
        scenario: &Scenario,
        margins: Margins,
        settings: AuditSettings,
    ) -> Result<Vec<Audit>, ScenarioError> {
        let mut audits = Vec::new();
        self.walk(scenario, margins, |StepTask { plan, problem, .. }| -> Result<bool, ScenarioError> {
            let audit = plan.audit(problem, settings)?;
            let is_valid = audit.as_ref().is_some_and(|audit| audit.valid);
            audits.extend(audit);
            Ok(is_valid)
        })?;
        Ok(audits)
    }

    /// The grasps that were given for the scenario's own target: for what else is picked none are, whatever a plan says of it.
    pub fn given_grasps(&self) -> GivenGrasps {
        let mut all = self.steps.iter().map(PlanFile::given_grasps);
        let first = all.next().unwrap_or_default();
        if first == GivenGrasps::None { all.find(|given| *given != first).unwrap_or(first) } else { first }
    }

    /// Whether the scenario has steps, each has its path and no path is without one, and all hold by these verdicts.
    pub fn is_solved(&self, scenario: &Scenario, audits: &[Audit]) -> bool {
        let count = scenario.steps.len();
        let is_whole = count > 0 && self.steps.len() == count && audits.len() == count;
        is_whole && audits.iter().all(|audit| audit.valid)
    }

    /// Reads a file of this format; `None` for any other, also one that can be read once only.
    ///
    /// # Errors
    /// [`ScenarioError`] with file and line if it cannot be read, or holds a plan that is none.
    pub fn read(path: &Path) -> Result<Option<Self>, ScenarioError> {
        if !path.is_file() || path.extension().is_none_or(|extension| extension != "json") {
            return Ok(None);
        }
        let text = cranny_file::TABLE
            .bytes(path)
            .map_err(|reason| ScenarioError::Unreadable { path: path.to_owned(), reason })?;
        let head: Result<Head, _> = cranny_file::json(&text);
        if !head.is_ok_and(|head| head.format.as_deref() == Some(Self::FORMAT)) {
            return Ok(None);
        }
        let malformed = |reason| ScenarioError::Json { path: path.to_owned(), reason };
        let plans: Self = cranny_file::json(&text).map_err(malformed)?;
        for (step, plan) in plans.steps.iter().enumerate() {
            if plan.format.as_deref() != Some(PlanFile::FORMAT) {
                let problem =
                    format!("the plan of step {} is not of format '{}'", step + 1, PlanFile::FORMAT);
                return Err(ScenarioError::Content { path: path.to_owned(), problem });
            }
            plan.check(path)?;
        }
        Ok(Some(plans))
    }

    /// Writes the plans, as a whole or not at all.
    ///
    /// # Errors
    /// As [`PlanFile::write`].
    pub fn write(&self, path: &Path) -> Result<(), ScenarioError> {
        for plan in &self.steps {
            plan.check_finite(path)?;
        }
        let unwritable = |reason: serde_json::Error| ScenarioError::Unwritable {
            path: path.to_owned(),
            reason: reason.into(),
        };
        let text = serde_json::to_string_pretty(self).map_err(unwritable)? + "\n";
        write_whole_file(path, text.as_bytes())
    }
}

impl Step {
    /// That a plan says that it puts down what the step picks where the step has it.
    ///
    /// # Errors
    /// [`PlanError::Place`] for one that does not.
    pub fn check(&self, plan: &PlanFile) -> Result<(), PlanError> {
        let (name, then) = (self.place.clone(), self.then);
        let asked = PlanPlace { name, clear_m: PlaceSettings::CLEAR_M, then };
        let lift_off = plan.segments.get(1);
        let is_it = lift_off.is_none_or(|lift_off| lift_off.attached.as_deref() == Some(&self.pick));
        if plan.place == Some(asked) && is_it {
            return Ok(());
        }
        let problem = format!("the plan of the step does not put '{}' down in '{}'", self.pick, self.place);
        Err(PlanError::Place { problem })
    }
}

/// The plan of a step, and what it is a plan for.
#[derive(Clone, Copy, Debug)]
pub struct StepTask<'a> {
    /// The plan.
    pub plan: &'a PlanFile,
    /// The scenario as the plans before it leave it, with what the step picks as target.
    pub scenario: &'a Scenario,
    /// Its problem.
    pub problem: &'a Problem,
}

/// Why the steps of a scenario were not planned.
#[derive(Debug, thiserror::Error)]
pub enum SequenceError {
    /// What the scenario says.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// What the search says.
    #[error(transparent)]
    Solve(#[from] SolveError),
}
