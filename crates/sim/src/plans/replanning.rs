use cranny_collision::Margins;
use cranny_plan::{Budget, Observer};
use cranny_record::{PlanFile, PlanSource};
use cranny_scenario::Scenario;
use cranny_solve::{PoseRadius, Request, Timing, solve};
use cranny_task::{Move, Problem, Stage};
use serde_json::Map;

use crate::{ExecutedPick, ExecutedPlan, PickPath, PickRun, PlanExecution, PlanRow, SimError, StopReason};

/// Execution of a plan of several picks with measurements in between.
#[derive(Clone, Debug)]
pub struct Replanned {
    /// All picks in order of execution, including repeated ones.
    pub runs: Vec<PickRun>,
    /// Number of new plans.
    pub new_plans: usize,
    /// Reason why the remaining picks were not executed; `None` if each object ends at its planned pose.
    pub stopped: Option<StopReason>,
}

impl Replanned {
    /// Collects the result for the scenario with this id.
    pub fn executed(&self, scenario: &str) -> ExecutedPlan {
        let pick = |pick: &PickRun| ExecutedPick { object: pick.object.clone(), row: PlanRow::of(pick) };
        ExecutedPlan::Several {
            scenario: scenario.to_owned(),
            as_planned: self.stopped.is_none(),
            stopped: self.stopped,
            new_plans: Some(self.new_plans),
            steps: self.runs.iter().map(pick).collect(),
        }
    }
}

/// Maximum number of repetitions of a pick.
const MOST_REPEATS: usize = 3;

/// Remaining task.
struct Left {
    picks: Vec<PickPath>,
    /// All remaining stages; those of a pick begin with it.
    stages: Vec<Stage>,
    /// Tolerated error of the pose of an object.
    forgiven: Option<PoseRadius>,
}

impl PlanExecution<'_> {
    /// Executes a plan of a problem with these margins and measures after each pick. If the pose error of the object exceeds
    /// the tolerance of the plan, the remaining task is replanned in the measured world; if the object is not at its set-down
    /// pose, the pick is repeated in the new plan. `done` is called after each pick.
    ///
    /// # Errors
    /// Those of [`Self::run`], [`PickPath::all_of`] and [`solve`].
    pub fn run_replanning(
        &self,
        plan: &PlanFile,
        (problem, margins): (&Problem, Margins),
        observer: &mut dyn Observer,
        mut done: impl FnMut(),
    ) -> Result<Replanned, SimError> {
        let home = problem.start().to_vec();
        let mut left = Left::of(plan, problem)?;
        let mut now = self.scenario.clone();
        let mut request = Request {
            budget: Budget::default(),
            timing: Some(Timing::default()),
            robustness: true,
            // Each remaining task has another first pick.
            planner: None,
            settings: Map::new(),
            ..plan.request()
        };
        let (mut runs, mut new_plans, mut repeats) = (Vec::new(), 0, 0);
        while !left.picks.is_empty() {
            let pick = left.picks.remove(0);
            let here = PlanExecution { scenario: &now, hand: self.hand.clone(), ..*self };
            let Some(run) = here.run(std::slice::from_ref(&pick), &mut done)?.pop() else {
                return Ok(Replanned { runs, new_plans, stopped: Some(StopReason::NotReleased) });
            };
            let row = PlanRow::of(&run);
            let motion = run.run.grasp.world_from_object * run.world_from_object.inverse();
            let (is_done, body) = (row.is_as_planned(), run.body);
            let off = row.placed;
            runs.push(run);
            let stopped = match (is_done, row.released.is_none() && row.is_in_hand) {
                (false, true) => Some(StopReason::NotReleased),
                (false, false) if repeats == MOST_REPEATS => Some(StopReason::TooManyRepeats),
                _ => None,
            };
            if stopped.is_some() {
                return Ok(Replanned { runs, new_plans, stopped });
            }
            now = now.with_moved(body, &motion, &pick.end)?;
            let stages = if is_done { left.after_pick() } else { left.stages.clone() };
            repeats = if is_done { 0 } else { repeats + 1 };
            if is_done && stages.is_empty() {
                break;
            }
            let forgives = |most: PoseRadius| {
                off.is_some_and(|off| {
                    off.translation_m <= most.translation_m && off.rotation_rad <= most.rotation_rad
                })
            };
            if is_done && left.forgiven.is_some_and(forgives) {
                left.stages = stages;
                continue;
            }
            request.seed = request.seed.wrapping_add(1);
            request.stages = stages.iter().map(|stage| at_home(stage, &home)).collect();
            let next = match planned_anew(&now, margins, &request, observer) {
                Ok(next) => next,
                // An object in an unreachable location ends the execution; this is not an error.
                Err(SimError::Solve(_) | SimError::Plan(_) | SimError::Scenario(_)) => None,
                Err(fault) => return Err(fault),
            };
            let Some(next) = next else {
                return Ok(Replanned { runs, new_plans, stopped: Some(StopReason::NoPlan) });
            };
            new_plans += 1;
            left = Left { stages, ..next };
        }
        Ok(Replanned { runs, new_plans, stopped: None })
    }
}

impl Left {
    fn of(plan: &PlanFile, problem: &Problem) -> Result<Self, SimError> {
        let picks = PickPath::all_of(plan, problem)?;
        let forgiven = plan.robustness.as_ref().and_then(|robustness| robustness.object);
        Ok(Self { picks, stages: plan.stages(problem), forgiven })
    }

    /// Returns the stages from the next pick on.
    fn after_pick(&self) -> Vec<Stage> {
        let picks = self.stages.iter().enumerate().filter(|(_, stage)| matches!(stage, Stage::Pick(_)));
        picks.map(|(index, _)| index).nth(1).map_or_else(Vec::new, |next| self.stages[next..].to_vec())
    }
}

/// Replaces the home of a stage by the start of the whole task (m, rad; one per joint).
fn at_home(stage: &Stage, home: &[f64]) -> Stage {
    match stage {
        Stage::Move(Move::Home) => Stage::Move(Move::Configurations(vec![home.to_vec()])),
        other => other.clone(),
    }
}

/// Plans the remaining task in the measured world; `None` if no plan was found.
fn planned_anew(
    now: &Scenario,
    margins: Margins,
    request: &Request,
    observer: &mut dyn Observer,
) -> Result<Option<Left>, SimError> {
    let problem = now.problem(margins)?;
    let answer = solve(&problem, request, observer)?;
    if !answer.is_solved() {
        return Ok(None);
    }
    let source = PlanSource { scenario: now.id.clone(), margins, ..PlanSource::default() };
    Left::of(&PlanFile::of(&answer, &source), &problem).map(Some)
}
