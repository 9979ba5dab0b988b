use std::path::PathBuf;

use clap::Args;
use cranny_file::counted;
use cranny_spatial::Pose;
use serde::Serialize;

use crate::arguments::Output;
use crate::failure::Failure;
use crate::file_kind::FileKind;
use crate::physics::simulate_subject::{Subject, SubjectArguments};
use crate::{Answer, output_file, text};

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny simulate export 031 --support-only -o box.json
  cranny simulate export 021 --mjcf -o ball.xml

The document holds the model as MJCF, what the hand does, what counts as held, and all grasps; in Python,
cranny.mujoco_grasps runs it in MuJoCo and answers by the same rules.")]
pub struct SimulateExportArguments {
    #[command(flatten)]
    pub subject: SubjectArguments,
    /// Write only the model, as MuJoCo's XML
    #[arg(long)]
    pub mjcf: bool,
    /// File to write
    #[arg(long, short, value_name = "FILE", default_value = "experiment.json")]
    pub output: PathBuf,
}

/// Output of `simulate export --json`.
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
    let page = || {
        format!("{}: {}, {}\n", exported.subject, counted(exported.grasps, "grasp"), exported.file.display())
    };
    text::answer(&exported, page, output)?;
    Ok(Answer::Done)
}
