use std::collections::BTreeSet;
use std::fmt::Write;

use cranny_collision::Margins;
use cranny_scenario::{OpenOptions, Scenario, check, model_notes};
use cranny_sim::Rest;
use cranny_solve::Request;
use cranny_task::Stage;
use serde::Serialize;

use crate::arguments::Output;
use crate::failure::Failure;
use crate::{Answer, text};

/// Output of `scenario check --json`.
#[derive(Serialize)]
struct Checked {
    scenario: String,
    sound: bool,
    problems: Vec<String>,
    /// Properties that do not make the scenario unsound.
    notes: Vec<String>,
}

/// Checks a scenario and prints its problems.
pub fn checked(id: &str, output: Output) -> Result<Answer, Failure> {
    let mut problems: Vec<String> = check(id)?.iter().map(ToString::to_string).collect();
    let mut notes = Vec::new();
    if problems.is_empty() {
        let scenario = Scenario::open(id, &OpenOptions::default())?;
        notes = model_notes(&scenario.robot, &scenario.world);
        let problem = scenario.problem(Margins::default())?;
        let faults = crate::start::faults(&problem);
        problems.extend(faults.into_iter().map(|fault| format!("the start is not free: {fault}")));
        problems.extend(scenario.misplaced_grasps());
        problems.extend(scenario.hovering_places());
        for task in &scenario.tasks {
            let request = Request { stages: task.stages.clone(), ..Request::default() };
            problems
                .extend(request.check(&problem).err().map(|fault| format!("task '{}': {fault}", task.name)));
        }
        notes.extend(scenario.blind_views());
        match scenario.mismatched_loads() {
            Ok(fault) => problems.extend(fault),
            Err(note) => notes.push(note),
        }
        for target in targets(&scenario)? {
            match Rest::of_target(&target) {
                Ok(rest) => problems.extend(rest.and_then(|rest| restless_target(&target, &rest))),
                Err(fault) => {
                    notes.push(format!("could not simulate whether {} rests: {fault}", target_name(&target)));
                }
            }
        }
        notes.extend(scenario.implausible_target_poses());
        notes.extend(scenario.too_wide_target());
        if let Some(cell) = problem.cell() {
            let mut scratch = cell.scratch();
            let is_free = |grasp: &cranny_grasp::Grasp| {
                [grasp.world_from_gripper, grasp.twin().world_from_gripper]
                    .iter()
                    .any(|pose| cell.hand_is_free(pose, &mut scratch))
            };
            let count = scenario.grasps.len();
            if scenario.has_grasp_set && count > 0 && !scenario.grasps.grasps().iter().any(is_free) {
                problems.push(format!("the hand collides at every one of the {count} grasps"));
            }
        }
    }
    let checked = Checked { scenario: id.to_owned(), sound: problems.is_empty(), problems, notes };
    text::answer(&checked, || checked.page(), if checked.sound { output } else { output.aloud() })?;
    Ok(if checked.sound { Answer::Done } else { Answer::No })
}

/// Returns the scenario with each body that it or one of its tasks picks as its target.
fn targets(scenario: &Scenario) -> Result<Vec<Scenario>, Failure> {
    let stages = scenario.tasks.iter().flat_map(|task| &task.stages);
    let picked = stages.filter_map(|stage| match stage {
        Stage::Pick(pick) => pick.object.as_deref(),
        _ => None,
    });
    let own = scenario.target.map(|target| scenario.world.bodies()[target].name.as_str());
    let names: BTreeSet<&str> = picked.filter(|name| Some(*name) != own).collect();
    let others = names.into_iter().map(|name| Ok(scenario.with_target(name)?));
    std::iter::once(Ok(scenario.clone())).chain(others).collect()
}

fn target_name(scenario: &Scenario) -> String {
    let name = scenario.target.map(|target| &scenario.world.bodies()[target].name);
    name.map_or_else(|| "the target".to_owned(), |name| format!("'{name}'"))
}

/// Describes the motion of a target that does not stay at its initial pose; `None` if it stays.
fn restless_target(scenario: &Scenario, rest: &Rest) -> Option<String> {
    if rest.is_at_rest() {
        return None;
    }
    let name = target_name(scenario);
    let place = rest.world_from_object.translation.vector;
    let turn = rest.world_from_object.rotation.coords;
    /// Turn above which an object may have rolled, in radians.
    const ROLLED_RAD: f64 = 0.02;
    let rolls = if rest.turned_rad > ROLLED_RAD {
        " (for an object that rolls, set `rolling_m` beside its mass)"
    } else {
        ""
    };
    Some(format!(
        "{name} does not rest at its pose: in 2 s it moves by {} and turns by {}, to position \
         [{:.4}, {:.4}, {:.4}], quaternion_xyzw [{:.4}, {:.4}, {:.4}, {:.4}] in the planning frame{rolls}",
        text::millimetres(rest.moved_m),
        text::degrees(rest.turned_rad),
        place.x,
        place.y,
        place.z,
        turn.x,
        turn.y,
        turn.z,
        turn.w,
    ))
}

impl Checked {
    fn page(&self) -> String {
        let mut page = String::new();
        for problem in &self.problems {
            let _ = writeln!(page, "{problem}");
        }
        for note in &self.notes {
            let _ = writeln!(page, "note: {note}");
        }
        let id = &self.scenario;
        let _ = match self.problems.len() {
            0 => writeln!(page, "{id}: sound"),
            1 => writeln!(page, "{id}: 1 problem"),
            count => writeln!(page, "{id}: {count} problems"),
        };
        page
    }
}
