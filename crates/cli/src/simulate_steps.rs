use std::fmt::Write as _;
use std::path::PathBuf;

use cranny_scenario::{OpenOptions, PlanFile, SequencePlan};
use cranny_sim::PlanRow;
use serde::Serialize;

use crate::arguments::Output;
use crate::failure::Failure;
use crate::plan_task::check_steps;
use crate::progress;
use crate::recording::{self, RecordedStep};
use crate::simulate_plan::{SimulatePlanArguments, execute, is_as_planned, page_of};
use crate::task::open_scenario;
use crate::{Answer, text};

/// What `simulate plan --json` prints of several steps; the keys stay.
#[derive(Serialize)]
struct ExecutedSteps {
    scenario: String,
    /// Whether all objects stand where they were to be put down.
    as_planned: bool,
    /// As far as they were executed: up to the first whose object is not in the hand as it was when it is to be put down.
    steps: Vec<ExecutedStep>,
}

/// What came of a step.
#[derive(Serialize)]
struct ExecutedStep {
    /// What was picked.
    object: String,
    #[serde(flatten)]
    row: PlanRow,
}

impl ExecutedStep {
    fn is_as_planned(&self) -> bool {
        self.row.placed.is_some() && is_as_planned(&self.row)
    }
}

/// Executes the plans of a scenario's steps, each where the one before has left things.
pub fn run(
    plans: &SequencePlan,
    arguments: &SimulatePlanArguments,
    output: Output,
) -> Result<Answer, Failure> {
    let recorded = arguments.recorded(output)?;
    let file = &arguments.plan;
    let of_plan = plans.steps.first().and_then(|plan| plan.robot.clone()).map(PathBuf::from);
    let options = OpenOptions {
        criterion: plans.steps.first().map(|plan| plan.criterion),
        robot: arguments.robot.clone().or(of_plan),
        geometry: plans.steps.first().and_then(PlanFile::given_geometry),
        grasps: plans.given_grasps(),
    };
    let scenario = open_scenario(&arguments.id, &options, output)?;
    check_steps(file, plans, &scenario, "executed in")?;
    let refused = |problem: String| Failure::File { path: file.clone(), problem };
    let (count, planned) = (scenario.steps.len(), plans.steps.len());
    if planned != count || plans.steps.iter().any(|plan| plan.waypoints.is_empty()) {
        let problem =
            format!("the plan does not have a path for each of the {count} steps of '{}'", scenario.id);
        return Err(refused(problem));
    }
    // Before the first of them, which takes its time.
    let instead = arguments.instead.of_target();
    for step in &scenario.steps {
        let physics = instead.or(scenario.at_step(step)?.target_physics());
        if physics.mass_kg.is_none() {
            let problem = format!(
                "nobody says what '{}' weighs (write mass_kg in its step of scenario.yaml, or give --mass)",
                step.pick
            );
            return Err(refused(problem));
        }
    }
    let bar = progress::bar(count as u64, output.quiet);
    bar.set_message("steps");
    let (mut now, mut steps, mut recordings) = (scenario.clone(), Vec::new(), Vec::new());
    for (step, plan) in scenario.steps.iter().zip(&plans.steps) {
        if plan.waypoints.first() != Some(&now.start) {
            return Err(refused(format!("step {} does not begin where the robot then is", steps.len() + 1)));
        }
        let of_step = now.at_step(step)?;
        let problem = of_step.problem(plan.margins)?;
        let timed = plan.trajectory(&of_step.robot, problem.cell().map(AsRef::as_ref))?.ok_or_else(|| {
            refused(
                "without limits of acceleration (a limits.yaml beside the URDF) the path has no times"
                    .to_owned(),
            )
        })?;
        let (mut run, _) = execute(arguments, &of_step, &timed, recorded.is_some())?;
        bar.inc(1);
        let (Some(body), Some(stood)) = (of_step.target, of_step.target_object(&instead)?) else {
            return Err(refused(format!("'{}' is not to be picked", step.pick)));
        };
        let motion = run.grasp.world_from_object * stood.world_from_object.inverse();
        if let Some(moved) = run.grasp.recording.take() {
            recordings.push(RecordedStep { body, world_from_object: stood.world_from_object, run: moved });
        }
        let executed = ExecutedStep { object: step.pick.clone(), row: PlanRow::of(&run) };
        let is_put_down = executed.row.released.is_some();
        steps.push(executed);
        // Else the hand does not open.
        if !is_put_down {
            break;
        }
        let end = plan.waypoints.last().unwrap_or(&now.start);
        now = now.with_moved(body, &motion, end)?;
    }
    bar.finish_and_clear();
    if let Some((file, kind)) = recorded {
        recording::write(&recording::of_steps(&scenario, &recordings), file, kind, output)?;
    }
    let as_planned = steps.len() == count && steps.iter().all(ExecutedStep::is_as_planned);
    let executed = ExecutedSteps { scenario: scenario.id, as_planned, steps };
    text::answer(&executed, || executed.page(count), output)?;
    Ok(if as_planned { Answer::Done } else { Answer::No })
}

impl ExecutedSteps {
    fn page(&self, count: usize) -> String {
        let there = self.steps.iter().filter(|step| step.is_as_planned()).count();
        let mut page = format!("{}: {there} of {count} steps as planned\n", self.scenario);
        for (index, step) in self.steps.iter().enumerate() {
            let _ = write!(page, "step {}, {}", index + 1, page_of(&step.object, &step.row));
        }
        if self.steps.len() < count {
            let _ = writeln!(page, "what follows was not executed: the object is not in the hand as it was");
        }
        page
    }
}
