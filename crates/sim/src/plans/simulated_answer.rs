use cranny_plan::{Observer, Statistics};
use cranny_record::{LeftOut, PlanAttempt, PlanFile, PlanSource};
use cranny_scenario::{ObjectError, Scenario, ScenarioError, TargetPhysics};
use cranny_solve::{Answer, Request, solve};
use cranny_task::{Mode, Pick, Problem, Stage, robot_hand};

use crate::{Disturbance, ExecutedPlan, PickPath, PickRun, PlanExecution, PlanRow, SimError};

/// Answer whose plans were executed in physics.
#[derive(Clone, Debug)]
pub struct SimulatedAnswer {
    /// Answer of the last attempt.
    pub answer: Answer,
    /// Attempts in order; empty if no path was found.
    pub tries: Vec<PlanAttempt>,
    /// Sum over all searches, without the time of their simulations.
    pub statistics: Statistics,
}

/// Distance of the lift of a plan that ends at its grasp, in metres.
const LIFT_M: f64 = 0.03;

/// Solves the problem of a scenario and executes the plan in physics. If an object does not stay in the hand or at its set-down
/// pose, plans again with the next seed and without the failed grasp, in at most `most` attempts. The result is deterministic
/// for equal arguments. `tried` is called after each attempt.
///
/// # Errors
/// Those of [`solve`], [`PickPath::all_of`] and [`PlanExecution::run`].
pub fn solve_in_physics(
    (scenario, problem): (&Scenario, &Problem),
    (request, source): (&Request, &PlanSource),
    most: usize,
    observer: &mut dyn Observer,
    mut tried: impl FnMut(&PlanAttempt),
) -> Result<SimulatedAnswer, SimError> {
    check_masses(scenario, &request.stages)?;
    let mut request = request.clone();
    let answer = solve(problem, &request, observer)?;
    let mut last = SimulatedAnswer { statistics: answer.statistics, answer, tries: Vec::new() };
    while last.answer.is_solved() && last.tries.len() < most {
        let result = try_once(scenario, problem, &last.answer, source)?;
        tried(&result);
        let is_over = result.as_planned || last.tries.len() + 1 == most || observer.should_stop();
        request.left_out.extend(result.left_out.as_ref().and_then(|out| Some((out.stage, out.pose()?))));
        last.tries.push(result);
        if is_over {
            break;
        }
        request.seed = request.seed.wrapping_add(1);
        let answer = solve(problem, &request, observer)?;
        last.statistics = last.statistics.with(&answer.statistics);
        if !answer.is_solved() {
            break;
        }
        last.answer = answer;
    }
    Ok(last)
}

/// Checks that the mass of each picked object is known, before an expensive search begins.
fn check_masses(scenario: &Scenario, stages: &[Stage]) -> Result<(), SimError> {
    let own = [Stage::pick()];
    for stage in if stages.is_empty() { &own[..] } else { stages } {
        let Stage::Pick(Pick { object, .. }) = stage else { continue };
        let picked =
            object.as_ref().map_or_else(|| Ok(scenario.clone()), |name| scenario.with_target(name))?;
        let target = picked.target.map(|target| picked.world.bodies()[target].name.clone());
        if let Some(target) = target.filter(|_| picked.target_physics().mass_kg.is_none()) {
            return Err(ScenarioError::from(ObjectError::NoMass { id: scenario.id.clone(), target }).into());
        }
    }
    Ok(())
}

/// Executes the plan of an answer.
fn try_once(
    scenario: &Scenario,
    problem: &Problem,
    answer: &Answer,
    source: &PlanSource,
) -> Result<PlanAttempt, SimError> {
    let plan = PlanFile::of(answer, source);
    let picks = PickPath::all_of(&plan, problem)?;
    let execution = PlanExecution {
        scenario,
        hand: robot_hand(problem.robot()),
        instead: TargetPhysics::default(),
        lift_m: LIFT_M,
        disturbance: Disturbance::default(),
        is_recorded: false,
    };
    let runs = execution.run(&picks, || {})?;
    let rows: Vec<PlanRow> = runs.iter().map(|run: &PickRun| PlanRow::of(run)).collect();
    let executed = ExecutedPlan::of(&scenario.id, picks.len(), &runs);
    let kept = rows.len() == picks.len() && rows.iter().all(|row| row.is_kept);
    let failed = rows.iter().position(|row| !row.is_as_planned());
    let shown = failed.or(rows.len().checked_sub(1));
    // The failed grasp is the last configuration before the hand closes.
    let dropped = rows.iter().position(|row| !row.is_kept);
    let reaches = plan.segments.iter().enumerate().filter(|(index, segment)| {
        let next = plan.segments.get(index + 1);
        let Mode { holds, leaves, .. } = segment.mode;
        !holds && !leaves && next.is_none_or(|next| next.mode.holds)
    });
    let reach = dropped.and_then(|dropped| reaches.map(|(_, segment)| segment).nth(dropped));
    let left_out = reach.and_then(|reach| {
        let robot = problem.robot();
        let tip = *robot.frames_at(reach.waypoints.last()?).link(robot.tip());
        Some(LeftOut::new(reach.stage, &tip))
    });
    Ok(PlanAttempt {
        seed: answer.seed,
        outcome: shown.map_or("never-closed", |row| rows[row].outcome.name()).to_owned(),
        kept,
        as_planned: executed.is_some_and(|executed| executed.is_as_planned()),
        left_out,
    })
}
