use std::path::Path;

use cranny_path::{Clearances, audit_task};
use cranny_plan::{Outcome, Registry, Statistics};
use cranny_record::{PlanFile, PlanSource};
use cranny_scenario::{OpenOptions, write_whole_folder};
use cranny_solve::{Answer, Timed, Timing};
use cranny_task::{Criterion, give_clearances};

use crate::figures::{Figures, proof_settings};
use crate::folder::{Chunk, DatasetFolder};
use crate::prepared_scene::stages_of;
use crate::scene_source::{SceneSource, folder_name, target_name};
use crate::{DatasetError, DemonstrationTask};

/// Name of the plan file in the folder of an extracted row.
pub const PLAN_FILE: &str = "demonstration.plan.json";

/// Writes the scene of a row as the folder of a scenario, with the row's start, and its path as a plan file in it, which
/// `cranny verify` judges. All figures of the plan are measured anew.
///
/// # Errors
/// [`DatasetError::Row`] for a row that is not there, or that has no path; those of files.
pub fn extract(folder: &DatasetFolder, row: u64, into: &Path) -> Result<(), DatasetError> {
    let fault = |problem: String| DatasetError::Row { path: folder.path().to_owned(), row, problem };
    let count = folder.recipe().count;
    if row >= count {
        return Err(fault(format!("is not there: the data set has the rows from 0 to {}", count - 1)));
    }
    let (chunk, scene) = folder.place_of(row);
    if !folder.has(chunk)? {
        return Err(fault("is not in this folder: another shard has it, or it is not yet made".to_owned()));
    }
    let Chunk { scenes, demonstrations } = folder.read(chunk)?;
    let found = demonstrations.iter().find(|known| known.row == row);
    let (Some(found), Some(scene)) = (found, scenes.iter().find(|known| known.scene == scene)) else {
        return Err(fault("is not in its chunk".to_owned()));
    };
    let task = DemonstrationTask::of_name(&found.task).filter(|_| found.is_solved());
    let task = task.ok_or_else(|| fault(format!("has no path: its outcome is {}", found.outcome)))?;
    let source = SceneSource::new(&folder.recipe_at_home())?;
    let recipe =
        source.rebuild(scene)?.ok_or_else(|| fault("has a scene that cannot be made again".to_owned()))?;
    let recipe = cranny_scenario::Recipe {
        start: found.start.clone(),
        robot: source.robot_with_files(scene.scene, &recipe),
        ..recipe
    };
    write_whole_folder(into, |place| recipe.write_folder(place))?;
    // The plan is measured in the scenario as it stands in the files.
    let id = into.display().to_string();
    let scenario = cranny_scenario::Scenario::open(&id, &OpenOptions::default())?;
    let margins = folder.recipe().margins();
    let problem = scenario.problem(margins)?;
    let damaged = || fault("has segments that do not fit its way points".to_owned());
    let mut segments =
        found.read_segments(problem.robot().dof(), &target_name(&problem)).ok_or_else(damaged)?;
    let stages = stages_of(task);
    let cell = problem.exact_cell("dataset")?.clone();
    let figures =
        Figures::of(&problem, &stages, &segments, None, &mut cell.scratch())?.ok_or_else(damaged)?;
    let settings = cranny_path::AuditSettings { clearances: Clearances::OfEdges, ..proof_settings() };
    let audit = audit_task(&problem, &stages, &segments, settings)?;
    give_clearances(&mut segments, &audit.clearances_per_edge_m);
    let planner = Registry::default().planner_with(&folder.recipe().planner, &folder.recipe().settings)?;
    let trajectory = figures.trajectory;
    let answer = Answer {
        planner: planner.name().to_owned(),
        settings: planner.settings(),
        criterion: Criterion::Exact,
        score: cranny_solve::Request::default().score.unwrap_or_default(),
        min_score: None,
        below_min_score: None,
        goal_threshold: problem.goal_threshold(),
        budget: cranny_plan::Budget {
            iterations: folder.recipe().iterations,
            ..cranny_plan::Budget::default()
        },
        seed: found.seed,
        joint_names: problem.robot().joint_names().to_vec(),
        outcome: Outcome::Solved,
        stages: if stages.len() > 1 { stages } else { Vec::new() },
        segments,
        not_checked: audit.not_checked.clone(),
        audit: Some(audit),
        untimed: Timing::default().limits(problem.robot()).err().map(|fault| fault.to_string()),
        timed: trajectory.map(|trajectory| Timed { trajectory, time_s: 0.0 }),
        robustness: None,
        least_length: None,
        tilt: None,
        tool: Vec::new(),
        hold_demanded: None,
        hold: None,
        shortening: None,
        optimisation: None,
        statistics: Statistics::default(),
        failures: Vec::new(),
        goal_faults: Vec::new(),
        no_grasp: None,
        refused: None,
    };
    let plan = PlanSource { scenario: folder_name(into), margins, ..PlanSource::default() };
    Ok(PlanFile::of(&answer, &plan).write(&into.join(PLAN_FILE))?)
}
