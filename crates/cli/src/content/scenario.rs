//! `cranny scenario`: create, check, convert and generate scenarios.

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use clap::{Args, Subcommand};
use cranny_file::counted;
use cranny_scenario::{
    BUILTIN_ROBOTS, Credits, Family, OpenOptions, Recipe, RecipeRobot, Rejections, Scenario, ScenarioError,
    SchemaFile, SetMaker, SetProgress, SetReport, SetSettings, TemplateRobot, check_free_folder, pack,
    unpack, write_set, write_sweep, write_template, write_whole_folder,
};
use serde::Serialize;
use strum::VariantArray as _;

use crate::arguments::Output;
use crate::content::scenario_check;
use crate::content::scenario_from::{self, FromArguments};
use crate::failure::Failure;
use crate::file_kind::FileKind;
use crate::number_argument::{share, whole};
use crate::progress::{bar, spinner, stop_on_interrupt};
use crate::{Answer, output_file, text};

#[derive(Clone, Debug, Args)]
pub struct ScenarioArguments {
    #[command(subcommand)]
    pub command: ScenarioCommand,
}

#[derive(Clone, Debug, Subcommand)]
pub enum ScenarioCommand {
    /// Create a scenario of your own from a commented template
    New(NewArguments),
    /// Check a scenario and report all errors, with line numbers
    Check(CheckArguments),
    /// Print the JSON Schema of scenario.yaml or of another file, for completion and checks in editors
    Schema(SchemaArguments),
    /// Pack a scenario into one .zip, with checksums, author, licence and citation
    Pack(PackArguments),
    /// Unpack an archive of `pack` and verify its checksums
    Unpack(UnpackArguments),
    /// Convert a scenario in the paper's released layout to Cranny's own
    Import(ImportArguments),
    /// Convert the model of a world (MJCF, SDF or URDF), with a robot and a body to grasp
    From(FromArguments),
    /// Write a scenario in the paper's released layout, for its programs
    Export(ExportArguments),
    /// Write scenarios of one family from easy to hard
    Sweep(SweepArguments),
    /// Write many random scenarios of one family, each checked to be sound
    Generate(GenerateArguments),
}

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny scenario new my_shelf
  cranny scenario check my_shelf
  cranny plan my_shelf
  cranny scenario new my_cell --robot my_arm          (a folder that `cranny robot add` made)
  cranny scenario new my_cell --robot ur5.urdf --group manipulator \\
      --tip tool0 --package ~/ros/share

The files of a robot that is not built in (URDF, SRDF, limits.yaml, robot.yaml, meshes) are copied to FOLDER/robot. What stands around it
and the grasps are then to be adapted to it.")]
pub struct NewArguments {
    /// Folder to create
    #[arg(value_name = "FOLDER")]
    pub folder: PathBuf,
    /// Robot to use instead of `panda_mobile`: a built-in one (see `cranny robot list`), a folder made by `cranny robot add`,
    /// or a URDF
    #[arg(long, value_name = "ROBOT")]
    pub robot: Option<PathBuf>,
    /// SRDF of the robot [default: the file beside the URDF with its name, if any]
    #[arg(long, value_name = "FILE", requires = "robot")]
    pub srdf: Option<PathBuf>,
    /// Group of the SRDF whose joints move [default: all joints from the root to the tip]
    #[arg(long, value_name = "NAME", requires = "robot")]
    pub group: Option<String>,
    /// Link whose frame reaches the grasps [default: from the SRDF, else the farthest link]
    #[arg(long, value_name = "LINK", requires = "robot")]
    pub tip: Option<String>,
    /// Folder to search for package:// names of the URDF; repeatable
    #[arg(long = "package", value_name = "FOLDER", requires = "robot")]
    pub packages: Vec<PathBuf>,
}

#[derive(Clone, Debug, Args)]
pub struct SchemaArguments {
    /// scenario, robot, limits or gripper
    #[arg(value_name = "FILE", default_value = "scenario",
          value_parser = SchemaFile::VARIANTS.iter().map(|file| file.name()).collect::<Vec<_>>())]
    pub file: String,
}

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny scenario check my_shelf
  cranny scenario check my_shelf.zip --json")]
pub struct CheckArguments {
    /// Built-in scenario, the folder of one, or a packed one
    #[arg(value_name = "ID")]
    pub id: String,
}

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny scenario pack my_shelf
  cranny scenario pack my_shelf -o shelf.zip \\
      --author 'Jane Doe' --licence CC-BY-4.0

What flags do not say is taken from `about` in scenario.yaml. Hidden files and plans are left out.")]
pub struct PackArguments {
    /// Folder of the scenario
    #[arg(value_name = "FOLDER")]
    pub folder: PathBuf,
    /// Archive to write [default: the folder's name with .zip, in this folder]
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Author of the scenario
    #[arg(long)]
    pub author: Option<String>,
    /// Licence of the scenario: an SPDX expression
    #[arg(long)]
    pub licence: Option<String>,
    /// Citation of the scenario
    #[arg(long)]
    pub citation: Option<String>,
}

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny scenario unpack my_shelf.zip
  cranny plan my_shelf.zip             a packed scenario needs no unpacking")]
pub struct UnpackArguments {
    /// Archive to read
    #[arg(value_name = "FILE")]
    pub archive: PathBuf,
    /// Folder to create [default: the archive's name without .zip, in this folder]
    #[arg(long, short, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
}

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny scenario import path/to/scenarios/011 -o shelf_11

Obstacles, target, start, grasps and IK solutions are kept; the robot is the built-in one.")]
pub struct ImportArguments {
    /// Folder with scene.yaml
    #[arg(value_name = "FOLDER")]
    pub folder: PathBuf,
    /// Folder to create
    #[arg(long, short, value_name = "FOLDER")]
    pub output: PathBuf,
}

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny scenario export 034 -o jogramop-framework/scenarios/134
  cranny scenario export my_shelf.zip -o released/201

The folder has an object library of its own. Scores and widths of grasps have no place in that layout.")]
pub struct ExportArguments {
    /// Built-in scenario, the folder of one, or a packed one
    #[arg(value_name = "ID")]
    pub id: String,
    /// Folder to create
    #[arg(long, short, value_name = "FOLDER")]
    pub output: PathBuf,
}

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny scenario sweep gap --from 0.64 --to 0.30 --steps 18
  cranny scenario sweep gate --from 0.86 --to 0.5 --steps 10 -o gates

Families and their dials, in metres:
  shelf  how far behind the front edge of the shelf the screwdriver lies
  table  how far behind the front edge of the table the ball lies
  gap    how wide the gap between the walls is
  gate   how wide and high the gate's opening is")]
pub struct SweepArguments {
    /// shelf, table, gap or gate
    #[arg(value_name = "FAMILY")]
    pub family: String,
    /// First value, in metres
    #[arg(long, value_name = "M")]
    pub from: f64,
    /// Last value, in metres
    #[arg(long, value_name = "M")]
    pub to: f64,
    /// Number of scenarios, including both ends
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=100_000))]
    pub steps: u32,
    /// Seed of the grasps
    #[arg(long, value_name = "N", default_value = "0", value_parser = whole(0..=u64::MAX))]
    pub seed: u64,
    #[command(flatten)]
    pub stage: StageArguments,
    /// Folder to create [default: FAMILY-sweep, in this folder]
    #[arg(long, short, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
}

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny scenario generate --family shelf --count 1000 --seed 7
  cranny scenario generate --family gap --count 50 --from 0.3 --to 0.4 -o narrow
  cranny scenario generate --family table --count 20 --robot my_robot

The object lies anywhere it may, turned at random, and boxes and cylinders stand about. A draw where the robot
touches something at the start, things overlap or the hand can take no grasp is drawn again. The same seed
gives the same files on any number of threads.")]
pub struct GenerateArguments {
    /// shelf, table, gap or gate
    #[arg(long)]
    pub family: String,
    /// Number of scenarios
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=1_000_000))]
    pub count: u32,
    /// Seed of all random numbers
    #[arg(long, value_name = "N", default_value = "0", value_parser = whole(0..=u64::MAX))]
    pub seed: u64,
    /// Minimum value of the family's parameter, in metres [default: slightly beyond the paper's]
    #[arg(long, value_name = "M")]
    pub from: Option<f64>,
    /// Maximum value, in metres
    #[arg(long, value_name = "M")]
    pub to: Option<f64>,
    /// Maximum number of clutter objects
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = whole::<u8>(0..=50))]
    pub clutter: u8,
    #[command(flatten)]
    pub stage: StageArguments,
    /// Folder to create [default: FAMILY-SEED, in this folder]
    #[arg(long, short, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
}

/// Robot and scale of the scenes of a set.
#[derive(Clone, Debug, Args)]
pub struct StageArguments {
    /// Robot: a built-in one (see `cranny robot list`), a folder made by `cranny robot add`, or a URDF
    #[arg(long, value_name = "ROBOT", default_value = BUILTIN_ROBOTS[0].name)]
    pub robot: PathBuf,
    /// Scale of the scenes relative to the paper's [default: from the robot's reach]
    #[arg(long, value_name = "FACTOR", value_parser = share)]
    pub scale: Option<f64>,
}

impl StageArguments {
    /// Returns the robot, and its settings for a set of `family`.
    fn settings(&self, family: Family, seed: u64) -> Result<(RecipeRobot, SetSettings), Failure> {
        let robot = RecipeRobot::load(&self.robot)?;
        let mut settings = SetSettings::new(family, &robot, seed);
        if let Some(scale) = self.scale {
            settings = settings.scaled(family, scale);
        }
        Ok((robot, settings))
    }
}

pub fn run(arguments: &ScenarioArguments, output: Output) -> Result<Answer, Failure> {
    match &arguments.command {
        ScenarioCommand::New(arguments) => {
            let NewArguments { folder, robot, srdf, group, tip, packages } = arguments.clone();
            let robot = robot.map(|robot| TemplateRobot { robot, srdf, group, tip, packages });
            write_template(&folder, robot.as_ref())?;
            written("folder", &arguments.folder, output)
        }
        ScenarioCommand::Check(arguments) => scenario_check::checked(&arguments.id, output),
        ScenarioCommand::Schema(arguments) => {
            let file: SchemaFile = arguments.file.parse().unwrap_or(SchemaFile::Scenario);
            text::print(&file.schema())?;
            Ok(Answer::Done)
        }
        ScenarioCommand::Pack(arguments) => packed(arguments, output),
        ScenarioCommand::Unpack(arguments) => {
            let stem = || arguments.archive.file_stem().unwrap_or_default().into();
            let folder: PathBuf = arguments.output.clone().unwrap_or_else(stem);
            unpack(&arguments.archive, &folder)?;
            written("folder", &folder, output)
        }
        ScenarioCommand::Import(arguments) => {
            let recipe = Recipe::import_released(&arguments.folder)?;
            write_whole_folder(&arguments.output, |folder| recipe.write_folder(folder))?;
            written("folder", &arguments.output, output)
        }
        ScenarioCommand::From(arguments) => scenario_from::convert(arguments, output),
        ScenarioCommand::Export(arguments) => {
            let recipe = Recipe::of_scenario(&Scenario::open(&arguments.id, &OpenOptions::default())?)?;
            if recipe.target.is_none() {
                return Err(Failure::NoTarget { id: arguments.id.clone() });
            }
            write_whole_folder(&arguments.output, |folder| recipe.write_released(folder))?;
            let losses = recipe.released_losses();
            let page = || {
                let written = format!("written to {}", arguments.output.display());
                losses.iter().fold(written, |page, loss| page + "\n  " + loss) + "\n"
            };
            text::answer(&serde_json::json!({ "folder": arguments.output, "losses": losses }), page, output)?;
            Ok(Answer::Done)
        }
        ScenarioCommand::Sweep(arguments) => sweep(arguments, output),
        ScenarioCommand::Generate(arguments) => generate(arguments, output),
    }
}

fn written(what: &str, path: &Path, output: Output) -> Result<Answer, Failure> {
    let page = || format!("written to {}\n", path.display());
    text::answer(&serde_json::json!({ what: path }), page, output)?;
    Ok(Answer::Done)
}

fn packed(arguments: &PackArguments, output: Output) -> Result<Answer, Failure> {
    let default_name = || {
        let whole = arguments.folder.canonicalize().unwrap_or_else(|_| arguments.folder.clone());
        format!("{}.zip", whole.file_name().unwrap_or_default().to_string_lossy()).into()
    };
    let archive: PathBuf = arguments.output.clone().unwrap_or_else(default_name);
    output_file::check(&archive, FileKind::Archive, output)?;
    let credits = Credits {
        author: arguments.author.clone(),
        licence: arguments.licence.clone(),
        citation: arguments.citation.clone(),
    };
    pack(&arguments.folder, &archive, &credits)?;
    written("archive", &archive, output)
}

fn sweep(arguments: &SweepArguments, output: Output) -> Result<Answer, Failure> {
    let family = Family::of_name(&arguments.family)?;
    let default_name = || format!("{}-sweep", family.name()).into();
    let folder = arguments.output.clone().unwrap_or_else(default_name);
    check_free_folder(&folder)?;
    let (robot, settings) = arguments.stage.settings(family, arguments.seed)?;
    let maker = maker(family, robot, settings, output)?;
    let values = [arguments.from, arguments.to];
    let steps = arguments.steps;
    watched(&folder, steps, output, |progress| write_sweep(&maker, &folder, values, steps as usize, progress))
}

fn generate(arguments: &GenerateArguments, output: Output) -> Result<Answer, Failure> {
    let family = Family::of_name(&arguments.family)?;
    let default_name = || format!("{}-{}", family.name(), arguments.seed).into();
    let folder = arguments.output.clone().unwrap_or_else(default_name);
    check_free_folder(&folder)?;
    let (robot, mut settings) = arguments.stage.settings(family, arguments.seed)?;
    settings.parameter_m[0] = arguments.from.unwrap_or(settings.parameter_m[0]);
    settings.parameter_m[1] = arguments.to.unwrap_or(settings.parameter_m[1]);
    settings.most_clutter = arguments.clutter.into();
    let maker = maker(family, robot, settings, output)?;
    let count = arguments.count;
    watched(&folder, count, output, |progress| write_set(&maker, &folder, count.into(), progress))
}

/// Returns the generator of the scenarios of a set; the hand tests the object first.
fn maker(
    family: Family,
    robot: RecipeRobot,
    settings: SetSettings,
    output: Output,
) -> Result<SetMaker, Failure> {
    let spinner = spinner("sampling grasps", output.quiet);
    let maker = SetMaker::new(family, robot, settings, |problem| {
        cranny_plan::is_reached(problem).map_err(|fault| fault.to_string())
    });
    spinner.finish_and_clear();
    Ok(maker?)
}

/// Output of `scenario sweep` and `scenario generate` with `--json`.
#[derive(Serialize)]
struct Set<'a> {
    folder: &'a Path,
    written: usize,
    rejected: Rejections,
    missing: usize,
    /// True if Ctrl-C stopped the command before all scenarios were generated.
    stopped: bool,
    /// Folder of the scenarios that were generated before; the same command resumes there.
    unfinished: Option<PathBuf>,
}

fn watched(
    folder: &Path,
    count: u32,
    output: Output,
    write: impl FnOnce(&SetProgress) -> Result<SetReport, ScenarioError>,
) -> Result<Answer, Failure> {
    let stop = stop_on_interrupt();
    let progress = bar(count.into(), output.quiet);
    let report = write(&SetProgress { done: &|| progress.inc(1), stop: &stop });
    progress.finish_and_clear();
    let SetReport { written, rejected, missing, unfinished } = report?;
    let stopped = stop.load(Ordering::Relaxed);
    let set = Set { folder, written: written.len(), rejected, missing, stopped, unfinished };
    let page = || {
        let made = match set.written {
            0 if set.stopped => "no scenario was generated, and nothing is written".to_owned(),
            0 => "no scenario was generated, and nothing is written; another --scale, or another `start` in \
                  the robot's robot.yaml, may help"
                .to_owned(),
            count => {
                let scenarios = counted(count, "scenario");
                match &set.unfinished {
                    Some(unfinished) => format!("{scenarios} in {}", unfinished.display()),
                    None => format!("{scenarios} in {}, listed in index.csv", folder.display()),
                }
            }
        };
        format!(
            "{made}\nrejected draws: {} where things overlap, {} where the robot touches something at the \
             start, {} without a free grasp, {} where the arm reaches none\n{}",
            rejected.things_overlap,
            rejected.start_collides,
            rejected.no_free_grasp,
            rejected.out_of_reach,
            match (set.missing, set.stopped) {
                (0, _) => String::new(),
                (missing, true) if set.unfinished.is_some() => {
                    format!("stopped: {missing} were not made; the same command makes them\n")
                }
                (missing, true) => format!("stopped: {missing} were not made\n"),
                (missing, false) => format!("{missing} were not made\n"),
            },
        )
    };
    text::answer(&set, page, output)?;
    Ok(if set.missing == 0 { Answer::Done } else { Answer::No })
}
