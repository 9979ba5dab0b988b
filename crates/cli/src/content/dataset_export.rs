use std::path::PathBuf;

use clap::{Args, ValueEnum};
use cranny_dataset::{DatasetFolder, LeRobotReport, PLAN_FILE, export_lerobot};
use serde::Serialize;

use crate::arguments::Output;
use crate::failure::Failure;
use crate::number_argument::{positive, whole};
use crate::progress::spinner;
use crate::{Answer, text};

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny dataset extract demonstrations 17 -o row_17
  cranny verify row_17 row_17/demonstration.plan.json")]
pub struct ExtractArguments {
    /// Folder of a set
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
    /// Index of the row
    #[arg(value_name = "ROW", value_parser = whole(0..=u64::MAX))]
    row: u64,
    /// Folder to create
    #[arg(long, short, value_name = "FOLDER")]
    output: PathBuf,
}

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny dataset export demonstrations --format lerobot -o lerobot
  cranny dataset export demonstrations --format lerobot --rate 50 -o lerobot

Each solved row becomes an episode: joints and distance of the fingers as state, those of the next frame as action, the pose
of the object as state of the environment. `cranny.dataset.to_robomimic` of the Python package writes HDF5 for robomimic.")]
pub struct ExportArguments {
    /// Folder of a set
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
    /// Layout to write
    #[arg(long, value_enum)]
    format: FormatArgument,
    /// Rate of the frames, in Hz [default: that of the recipe]
    #[arg(long, value_name = "HZ", value_parser = positive)]
    rate: Option<f64>,
    /// Folder to create
    #[arg(long, short, value_name = "FOLDER")]
    output: PathBuf,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum FormatArgument {
    /// LeRobot, version 3
    Lerobot,
}

pub fn extract(arguments: &ExtractArguments, output: Output) -> Result<Answer, Failure> {
    let ExtractArguments { folder, row, output: into } = arguments;
    cranny_dataset::extract(&DatasetFolder::open(folder)?, *row, into)?;
    let plan = into.join(PLAN_FILE);
    let page = || {
        format!(
            "written to {}; judge it with: cranny verify {} {}\n",
            into.display(),
            into.display(),
            plan.display()
        )
    };
    text::answer(&serde_json::json!({"folder": into, "plan": plan}), page, output)?;
    Ok(Answer::Done)
}

/// Output of `dataset export --json`.
#[derive(Serialize)]
struct Exported {
    folder: PathBuf,
    episodes: u64,
    frames: u64,
}

pub fn run(arguments: &ExportArguments, output: Output) -> Result<Answer, Failure> {
    let ExportArguments { folder, format: FormatArgument::Lerobot, rate, output: into } = arguments;
    let folder = DatasetFolder::open(folder)?;
    let rate_hz = rate.unwrap_or(folder.recipe().rate_hz);
    let spinner = spinner("writing", output.quiet);
    let report = export_lerobot(&folder, rate_hz, into, &mut || spinner.inc(1));
    spinner.finish_and_clear();
    let LeRobotReport { episodes, frames } = report?;
    let exported = Exported { folder: into.clone(), episodes, frames };
    let page = || format!("{}: {episodes} episodes, {frames} frames\n", into.display());
    text::answer(&exported, page, output)?;
    Ok(Answer::Done)
}
