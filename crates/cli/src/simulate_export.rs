use std::path::PathBuf;

use cranny_spatial::Pose;
use serde::Serialize;

use crate::Answer;
use crate::arguments::Output;
use crate::failure::Failure;
use crate::file_kind::FileKind;
use crate::simulate::SimulateExportArguments;
use crate::simulate_subject::Subject;
use crate::{output_file, text};

/// What `simulate export --json` prints.
#[derive(Serialize)]
struct Exported {
    subject: String,
    grasps: usize,
    file: PathBuf,
}

pub fn run(arguments: &SimulateExportArguments, output: Output) -> Result<Answer, Failure> {
    let kind = if arguments.mjcf { FileKind::Mjcf } else { FileKind::Experiment };
    output_file::check(&arguments.output, kind, output)?;
    let Subject { name, test, grasps, .. } = Subject::open(&arguments.subject, output)?;
    let poses: Vec<Pose> = grasps.grasps().iter().map(|grasp| grasp.world_from_gripper).collect();
    let content = if arguments.mjcf { test.mjcf() } else { text::json(&test.experiment(&poses))? };
    output_file::write(&arguments.output, kind, content.as_bytes(), output)?;
    let exported = Exported { subject: name, grasps: poses.len(), file: arguments.output.clone() };
    let page = || format!("{}: {} grasps, {}\n", exported.subject, exported.grasps, exported.file.display());
    text::answer(&exported, page, output)?;
    Ok(Answer::Done)
}
