use std::path::{Path, PathBuf};

use cranny_scenario::{ScenarioError, StagingFolder, check_free_folder, put_in_place};

use crate::foreign::foreign_planner::{ForeignFiles, ForeignTask, mark_of_the_whole};
use crate::foreign::sandbox::Isolation;
use crate::running::opened_scenario::OpenedScenario;
use crate::running::worker_message::Request;
use crate::{BenchError, PathDemand, Question, WorkerProgram};

/// Writes the files of a trial for an external program into a new folder: `problem.json`, the document for its standard
/// input, and the files named in it, or nothing. Returns the path of the document.
///
/// # Errors
/// [`ScenarioError::Exists`] for a folder that is not empty, errors of opening the scenario, and of writing.
pub fn write_problem(question: &Question, folder: &Path) -> Result<PathBuf, BenchError> {
    check_free_folder(folder)?;
    let unwritable = |reason| ScenarioError::Unwritable { path: folder.to_owned(), reason };
    // Absolute paths in the document are valid for any working folder of the program.
    let folder = std::path::absolute(folder).map_err(unwritable)?;
    let trial = &question.trial;
    let demand = PathDemand::of_settings(&trial.settings);
    let opened = OpenedScenario::open(&question.source, trial.criterion, &demand)?;
    let stages = demand.stages_in(&opened.scenario)?;
    let above = folder.parent().unwrap_or(&folder);
    std::fs::create_dir_all(above).map_err(unwritable)?;
    let staging = StagingFolder::beside(&folder).map_err(unwritable)?;
    let partial = staging.path().join("problem");
    let files = ForeignFiles::write(&partial, &question.source, &opened)?.moved(&partial, &folder);
    // The mark lets a worker reuse its files; it has no purpose here.
    let _ = std::fs::remove_file(mark_of_the_whole(&partial, opened.problem.criterion()));
    let request = Request {
        question: question.clone(),
        exports: folder.clone(),
        results: PathBuf::new(),
        memory_limit_bytes: 0,
        isolation: Isolation::default(),
        worker: WorkerProgram { program: PathBuf::new(), arguments: Vec::new() },
    };
    let task =
        ForeignTask { request: &request, opened: &opened, goal: None, carry: demand.carry, stages: &stages };
    let problem = files.problem(&task, &folder.join("scratch"));
    let text = serde_json::to_string_pretty(&problem).map_err(|reason| BenchError::message(&reason))? + "\n";
    let document = "problem.json";
    std::fs::write(partial.join(document), text).map_err(unwritable)?;
    put_in_place(&partial, &folder).map_err(unwritable)?;
    Ok(folder.join(document))
}
