use std::path::Path;

use cranny_collision::Margins;
use cranny_plan::{AuditSettings, CarryEnd, Observer, PlaceSettings, PlanError, Problem, Violation};
use cranny_solve::{Carry, PoseRadius, Request, SolveError, solve};
use serde::{Deserialize, Serialize};

use crate::plan::reading::Head;
use crate::plan::statement::differences;
use crate::{
    GivenGrasps, Judgement, PlanFile, PlanPlace, PlanSource, Scenario, ScenarioError, Statement, Step,
    TargetPhysics, write_whole_file,
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
#[serde(deny_unknown_fields)]
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
        (source, demand): (&PlanSource, StepDemand),
        request: &Request,
        observer: &mut dyn Observer,
    ) -> Result<(Self, bool), SequenceError> {
        let mut now = scenario.clone();
        let (mut steps, mut solved) = (Vec::new(), 0);
        for step in &scenario.steps {
            let of_step = now.at_step(step)?;
            let source = PlanSource { margins: demand.margins(&of_step, source.margins), ..source.clone() };
            let problem = demand.checked(of_step.problem(source.margins)?);
            let goal = problem.place(&step.place).map_err(ScenarioError::from)?.clone();
            let place = PlaceSettings { goal, clear_m: PlaceSettings::CLEAR_M, then: step.then };
            let carry = Some(Carry { end: CarryEnd::Place(place), ..Carry::default() });
            let answer = solve(&problem, &Request { carry, ..request.clone() }, observer)?;
            let plan = PlanFile::of(&answer, &source);
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

    /// Calls `visit` with each plan in the world that those before it leave, in the problem that `problem_of` makes of
    /// the step's scenario and its plan ([`Self::own_problem`]), until it returns `false`.
    ///
    /// # Errors
    /// Those of `visit`, and [`ScenarioError::Plan`] for what is no plan of the scenario's steps, or puts nothing down where
    /// it is to go on.
    pub fn walk<E: From<ScenarioError>>(
        &self,
        scenario: &Scenario,
        problem_of: impl Fn(&Scenario, &PlanFile) -> Result<Problem, ScenarioError>,
        mut visit: impl FnMut(StepTask<'_>) -> Result<bool, E>,
    ) -> Result<(), E> {
        let mut now = scenario.clone();
        for (step, plan) in scenario.steps.iter().zip(&self.steps) {
            let of_step = now.at_step(step)?;
            let problem = problem_of(&of_step, plan)?;
            // The steps define what is picked and where it goes, whatever the file states.
            step.check(plan).map_err(ScenarioError::from)?;
            if !visit(StepTask { plan, scenario: &of_step, problem: &problem })? {
                break;
            }
            now = now.after(plan, &problem)?;
        }
        Ok(())
    }

    /// The problem of a step with the margins that its own plan states.
    ///
    /// # Errors
    /// As [`Scenario::problem`].
    pub fn own_problem(of_step: &Scenario, plan: &PlanFile) -> Result<Problem, ScenarioError> {
        of_step.problem(plan.margins)
    }

    /// Judges each plan ([`PlanFile::judge`]) in the world that those before it leave, up to the first that does not hold.
    /// `task` is what the scenario was opened with; each step has the margins of its own problem.
    ///
    /// # Errors
    /// [`ScenarioError::Plan`] for what is no plan of the scenario's steps.
    pub fn judge(
        &self,
        (scenario, task): (&Scenario, &PlanSource),
        problem_of: impl Fn(&Scenario, &PlanFile) -> Result<Problem, ScenarioError>,
        settings: AuditSettings,
    ) -> Result<SequenceJudgement, ScenarioError> {
        let mut steps: Vec<Judgement> = Vec::new();
        self.walk(scenario, problem_of, |step| -> Result<bool, ScenarioError> {
            let judgement = step.plan.judge(&step.task(task), step.problem, settings)?;
            let is_valid = judgement.as_ref().is_some_and(|judgement| judgement.audit.valid);
            steps.extend(judgement);
            Ok(is_valid)
        })?;
        let count = scenario.steps.len();
        let is_whole = count > 0 && self.steps.len() == count && steps.len() == count;
        let holds = is_whole && steps.iter().all(|judgement| judgement.audit.valid);
        let measured = steps.iter().map(|judgement| judgement.measured.clone()).collect();
        let measured = Self::of(scenario, measured);
        // Each step has compared its own time.
        let durations = [self, &measured].map(|plans| serde_json::json!({"duration_s": plans.duration_s}));
        let keys = if holds { &["duration_s"][..] } else { &[] };
        let differs = differences(keys, &durations[0], &durations[1]);
        let is_own_task = steps.iter().all(|judgement| judgement.is_own_task);
        let (lies, differs): (Vec<_>, Vec<_>) =
            differs.into_iter().partition(|statement| is_own_task && statement.is_false);
        let violations: Vec<_> = lies.into_iter().map(Statement::violation).collect();
        Ok(SequenceJudgement { valid: holds && violations.is_empty(), violations, steps, differs })
    }

    /// The grasps that were given for the scenario's own target: for what else is picked none are, whatever a plan says of it.
    pub fn given_grasps(&self) -> GivenGrasps {
        let mut all = self.steps.iter().map(PlanFile::given_grasps);
        let first = all.next().unwrap_or_default();
        if first == GivenGrasps::None { all.find(|given| *given != first).unwrap_or(first) } else { first }
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
        plans.check_agreement(path)?;
        Ok(Some(plans))
    }

    /// Checks that all steps are of one task: they follow each other in one world.
    fn check_agreement(&self, path: &Path) -> Result<(), ScenarioError> {
        let Some(first) = self.steps.first() else { return Ok(()) };
        let of_task = |plan: &PlanFile| {
            let PlanFile { scenario, robot, geometry, criterion, joint_names, .. } = plan.clone();
            [
                ("scenario", Some(scenario)),
                ("robot", robot),
                ("geometry", geometry),
                ("criterion", Some(criterion.name().to_owned())),
                ("joint_names", Some(joint_names.join(", "))),
            ]
        };
        let stated = |value: &Option<String>| value.clone().unwrap_or_else(|| "nothing".to_owned());
        let expected = PlanFile { scenario: self.scenario.clone(), ..first.clone() };
        for (step, plan) in self.steps.iter().enumerate() {
            let mut pairs = of_task(plan).into_iter().zip(of_task(&expected));
            if let Some(((key, found), (_, expected))) = pairs.find(|(found, expected)| found != expected) {
                let (found, expected) = (stated(&found), stated(&expected));
                let problem = format!(
                    "step {} states '{found}' as its {key}, but the plan is for '{expected}'",
                    step + 1
                );
                return Err(ScenarioError::Content { path: path.to_owned(), problem });
            }
        }
        Ok(())
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

/// A demand on every step, besides those of the request.
#[derive(Clone, Copy, Debug, Default)]
pub struct StepDemand {
    /// Greatest error of the pose of the object that is picked.
    pub robust: Option<PoseRadius>,
    /// True if pairs of links that touch in every sample are checked too.
    pub all_pairs: bool,
}

impl StepDemand {
    /// The margins of a step in whose scenario the target is what it picks.
    fn margins(self, of_step: &Scenario, margins: Margins) -> Margins {
        let of_object =
            |radius: PoseRadius| of_step.object_margin_m(radius.translation_m, radius.rotation_rad);
        let object_margin_m = self.robust.and_then(of_object).unwrap_or(margins.object_margin_m);
        Margins { object_margin_m, ..margins }
    }

    /// The problem with the pairs that are to be checked.
    pub fn checked(self, problem: Problem) -> Problem {
        if self.all_pairs { problem.checking_all_pairs() } else { problem }
    }
}

/// A verdict on plans of several steps.
#[derive(Clone, Debug, Serialize)]
pub struct SequenceJudgement {
    /// True if the scenario has steps, each has its path, all paths hold, and no statement of the file is false.
    pub valid: bool,
    /// False statements of the file about all steps together.
    pub violations: Vec<Violation>,
    /// The verdicts, up to the first that does not hold.
    pub steps: Vec<Judgement>,
    /// Statements of the file about all steps together that differ from what was measured.
    pub differs: Vec<Statement>,
}

impl Step {
    /// Checks that a plan is for the object that the step picks and for the place where the step puts it down.
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

impl StepTask<'_> {
    /// Source of the step's problem, if the scenario of all steps was opened with `task`. Grasps are given for the
    /// scenario's own target alone: for another object none are, and its plan states that, or what all steps were opened
    /// with.
    pub fn task(&self, task: &PlanSource) -> PlanSource {
        let margins = self.problem.cell().map_or(self.plan.margins, |cell| cell.margins());
        let is_without = !self.scenario.has_grasp_set && self.plan.given_grasps() == GivenGrasps::None;
        let grasps = if is_without { GivenGrasps::None } else { task.grasps.clone() };
        PlanSource { grasps, margins, ..task.clone() }
    }
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
