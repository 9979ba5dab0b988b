use std::fmt::Write;
use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use clap::{Args, builder::TypedValueParser as _};
use cranny_file::counted;
use cranny_grasp::{ClosingAxis, GraspFormat, ImportSettings, Imported, csv_text, import_grasps};
use cranny_scenario::{OpenOptions, ScenarioError};
use serde::Serialize;
use strum::VariantNames as _;

use crate::arguments::Output;
use crate::failure::Failure;
use crate::file_kind::FileKind;
use crate::planning::task::open_scenario;
use crate::{Answer, output_file, text};

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny grasps import Mug_10f6.h5 -o mug.csv                           ACRONYM
  cranny grasps import Mug.h5 --scenario my_shelf --min-score 1 -o mug.csv
  cranny grasps import 000_labels.npz --min-score 0.8 -o drill.csv      object labels of GraspNet
  cranny grasps import grasps.npy --object 5 -o scene.csv               a GraspGroup of GraspNet, or poses (N, 4, 4)
  cranny grasps import mug.json -o mug.csv                              GraspGen
  cranny grasps import mug.yaml --closing y --offset 105 -o mug.csv     isaac_grasp 1.0 of Isaac Sim

The format is recognized by the content. Poses become those of the gripper frame here: z the approach, y the axis along which the
fingers close, the origin between the pads. ACRONYM and GraspGen close along x and count from the base of the Franka
hand, 105 mm behind; of another gripper they need --closing and --offset. GraspNet approaches along x, and its depth is that
of the fingertips, 7.2 mm ahead. Without --scenario the poses stay in the frame of the file, mostly that of the object's mesh.")]
pub struct ImportArguments {
    #[arg(
        value_name = "FILE",
        help = "HDF5 of ACRONYM, .npz or .npy of GraspNet or with poses, JSON of GraspGen, YAML of Isaac"
    )]
    file: PathBuf,
    /// File to write the grasps to
    #[arg(long, short, value_name = "FILE")]
    output: PathBuf,
    /// Expected format [default: detected from the content]
    #[arg(long, value_parser = PossibleValuesParser::new(GraspFormat::VARIANTS).try_map(|word| word.parse::<GraspFormat>()))]
    format: Option<GraspFormat>,
    /// Scenario whose target is the object: the poses are then in its planning frame
    #[arg(long, value_name = "ID")]
    scenario: Option<String>,
    /// Axis of the file's gripper frame along which the fingers close [default: that of the format]
    #[arg(long, value_parser = PossibleValuesParser::new(["x", "y"]).try_map(|word| word.parse::<ClosingAxis>()))]
    closing: Option<ClosingAxis>,
    /// Offset along the approach from the origin of the file's gripper frame to the point between the pads, in
    /// millimetres; from the fingertips if the file has their depth [default: that of the format for the Franka hand]
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    offset: Option<f64>,
    /// Keep the grasps of at least this score, from 0 to 1
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    min_score: Option<f64>,
    /// Id of the object whose grasps are read from a `GraspGroup`
    #[arg(long, value_name = "ID", allow_negative_numbers = true)]
    object: Option<i64>,
}

/// Output of `grasps import --json`; its keys are stable.
#[derive(Serialize)]
struct Answered<'a> {
    format: GraspFormat,
    in_file: usize,
    masked: usize,
    below_min_score: usize,
    grasps: usize,
    closing: ClosingAxis,
    offset_m: f64,
    object_scale: Option<f64>,
    scenario: Option<&'a str>,
    notes: &'a [String],
    file: &'a PathBuf,
}

pub fn run(arguments: &ImportArguments, output: Output) -> Result<Answer, Failure> {
    output_file::check(&arguments.output, FileKind::Grasps, output)?;
    if let Some(least) = arguments.min_score.filter(|least| !(0.0..=1.0).contains(least)) {
        let problem = format!("'{least}' is not a valid score: expected a number from 0 to 1");
        return Err(Failure::Flag { flag: "min-score", problem });
    }
    let settings = ImportSettings {
        format: arguments.format,
        closing: arguments.closing,
        offset_m: arguments.offset.map(|offset_mm| offset_mm / 1e3),
        min_score: arguments.min_score,
        object: arguments.object,
    };
    let imported = import_grasps(&arguments.file, &settings).map_err(ScenarioError::from)?;
    let Imported { format, grasps, in_file, masked, below, closing, offset_m, object_scale, notes } =
        imported;
    let grasps = match &arguments.scenario {
        None => grasps,
        Some(id) => {
            let scenario = open_scenario(id, &OpenOptions::default(), output)?;
            let Some(world_from_object) = scenario.world_from_object() else {
                let problem = format!(
                    "the target of {id} is not a single object with its own frame, so grasps cannot be \
                     converted to the scenario; without the flag they stay in the frame of the file"
                );
                return Err(Failure::Flag { flag: "scenario", problem });
            };
            grasps.moved(&world_from_object)
        }
    };
    output_file::write(&arguments.output, FileKind::Grasps, csv_text(&grasps).as_bytes(), output)?;
    let answered = Answered {
        format,
        in_file,
        masked,
        below_min_score: below,
        grasps: grasps.len(),
        closing,
        offset_m,
        object_scale,
        scenario: arguments.scenario.as_deref(),
        notes: &notes,
        file: &arguments.output,
    };
    text::answer(&answered, || answered.page(), output)?;
    Ok(Answer::Done)
}

impl Answered<'_> {
    fn page(&self) -> String {
        let Self { in_file, masked, below_min_score, grasps, closing, offset_m, notes, file, .. } = self;
        let format: &str = self.format.into();
        let closing: &str = closing.into();
        let mut page = format!("{}: {} of {in_file} ({format})\n", file.display(), counted(*grasps, "grasp"));
        let _ = writeln!(
            page,
            "  left out      {masked} masked, invalid or of another object, {below_min_score} below the least score"
        );
        let _ = writeln!(
            page,
            "  turned from   closing axis {closing}, origin {:.1} mm before ours",
            1e3 * offset_m
        );
        if let Some(scale) = self.object_scale {
            let _ = writeln!(page, "  object scale  {scale}: the mesh of the object must have it too");
        }
        for note in *notes {
            let _ = writeln!(page, "  note          {note}");
        }
        page
    }
}
