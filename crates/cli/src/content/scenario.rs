//! `cranny scenario`: scenarios of one's own, and those of others.

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use clap::{Args, Subcommand};
use cranny_scenario::{
    BUILTIN_ROBOTS, Credits, Family, OpenOptions, Recipe, RecipeRobot, Rejections, Scenario, ScenarioError,
    SchemaFile, SetMaker, SetProgress, SetReport, SetSettings, TemplateRobot, check_free_folder, pack,
    unpack, write_set, write_sweep, write_template, write_whole_folder,
};
use serde::Serialize;
use strum::VariantArray as _;

use crate::arguments::Output;
use crate::content::scenario_check;
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
    /// Begin a scenario of your own from a commented template
    New(NewArguments),
    /// Say everything that is wrong with a scenario, with lines
    Check(CheckArguments),
    /// Print the JSON Schema of scenario.yaml, or of another file, with which editors complete and check it
    Schema(SchemaArguments),
    /// Pack a scenario into one .zip, with checksums, author, licence and citation
    Pack(PackArguments),
    /// Unpack what `pack` made, checksums verified
    Unpack(UnpackArguments),
    /// Make a scenario of the paper's released layout one of Cranny's own
    Import(ImportArguments),
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
    /// Folder to make
    #[arg(value_name = "FOLDER")]
    pub folder: PathBuf,
    /// Another robot than `panda_mobile`: a built-in one (see `cranny robot list`), a folder that `cranny robot add` made,
    /// or a URDF
    #[arg(long, value_name = "ROBOT")]
    pub robot: Option<PathBuf>,
    /// Its SRDF [default: the file beside the URDF with its name, if there is one]
    #[arg(long, value_name = "FILE", requires = "robot")]
    pub srdf: Option<PathBuf>,
    /// The group of the SRDF whose joints move [default: all from the root to the tip]
    #[arg(long, value_name = "NAME", requires = "robot")]
    pub group: Option<String>,
    /// The link that grasps are reached with [default: what the SRDF says, else the farthest one]
    #[arg(long, value_name = "LINK", requires = "robot")]
    pub tip: Option<String>,
    /// Folder in which package:// names of the URDF are looked for; may be given more than once
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
    /// Who made it
    #[arg(long)]
    pub author: Option<String>,
    /// How it may be used: an SPDX expression
    #[arg(long)]
    pub licence: Option<String>,
    /// How it wants to be cited
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
    /// Folder to make [default: the archive's name without .zip, in this folder]
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
    /// Folder to make
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
    /// Folder to make
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
    /// The first value, in metres
    #[arg(long, value_name = "M")]
    pub from: f64,
    /// The last value, in metres
    #[arg(long, value_name = "M")]
    pub to: f64,
    /// How many scenarios, ends included
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=100_000))]
    pub steps: u32,
    /// Seed of the grasps
    #[arg(long, value_name = "N", default_value = "0", value_parser = whole(0..=u64::MAX))]
    pub seed: u64,
    #[command(flatten)]
    pub stage: StageArguments,
    /// Folder to make [default: FAMILY-sweep, in this folder]
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
    /// How many scenarios
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=1_000_000))]
    pub count: u32,
    /// Seed of all randomness
    #[arg(long, value_name = "N", default_value = "0", value_parser = whole(0..=u64::MAX))]
    pub seed: u64,
    /// The least value of the family's dial, in metres [default: a little beyond the paper's]
    #[arg(long, value_name = "M")]
    pub from: Option<f64>,
    /// The greatest value, in metres
    #[arg(long, value_name = "M")]
    pub to: Option<f64>,
    /// At most so many things stand about
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = whole::<u8>(0..=50))]
    pub clutter: u8,
    #[command(flatten)]
    pub stage: StageArguments,
    /// Folder to make [default: FAMILY-SEED, in this folder]
    #[arg(long, short, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
}

/// For whom the scenes of a set are, and how large they are.
#[derive(Clone, Debug, Args)]
pub struct StageArguments {
    /// The robot: a built-in one (see `cranny robot list`), a folder that `cranny robot add` made, or a URDF
    #[arg(long, value_name = "ROBOT", default_value = BUILTIN_ROBOTS[0].name)]
    pub robot: PathBuf,
    /// How much smaller than the paper's the scenes are [default: as it suits the robot's reach]
    #[arg(long, value_name = "FACTOR", value_parser = share)]
    pub scale: Option<f64>,
}

impl StageArguments {
    /// The robot, and the settings of sets of a family for it.
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
        ScenarioCommand::Export(arguments) => {
            let recipe = Recipe::of_scenario(&Scenario::open(&arguments.id, &OpenOptions::default())?)?;
            write_whole_folder(&arguments.output, |folder| recipe.write_released(folder))?;
            written("folder", &arguments.output, output)
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

/// Who draws the scenarios of a set: has the hand try the object first.
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

/// What `scenario sweep` and `scenario generate` print with `--json`.
#[derive(Serialize)]
struct Set<'a> {
    folder: &'a Path,
    written: usize,
    rejected: Rejections,
    missing: usize,
    /// Whether Ctrl-C ended it before all were drawn.
    stopped: bool,
}

fn watched(
    folder: &Path,
    count: u32,
    output: Output,
    write: impl FnOnce(&SetProgress) -> Result<SetReport, ScenarioError>,
) -> Result<Answer, Failure> {
    let stop = stop_on_interrupt()?;
    let progress = bar(count.into(), output.quiet);
    let report = write(&SetProgress { done: &|| progress.inc(1), stop: &stop });
    progress.finish_and_clear();
    let SetReport { written, rejected, missing } = report?;
    let stopped = stop.load(Ordering::Relaxed);
    if written.is_empty() {
        // It holds an empty list, and would be in the way of the next try.
        std::fs::remove_dir_all(folder)?;
    }
    let set = Set { folder, written: written.len(), rejected, missing, stopped };
    let page = || {
        let made = match set.written {
            0 => "no scenario, and nothing is written; another --scale, or another `start` in the robot's robot.yaml, may \
                  help"
                .to_owned(),
            1 => format!("1 scenario in {}, listed in index.csv", folder.display()),
            count => format!("{count} scenarios in {}, listed in index.csv", folder.display()),
        };
        format!(
            "{made}\nrejected draws: {} where things overlap, {} where the robot \
             touches something at the start, {} without a free grasp, {} where the arm comes to none\n{}",
            rejected.things_overlap,
            rejected.start_collides,
            rejected.no_free_grasp,
            rejected.out_of_reach,
            match (set.missing, set.stopped) {
                (0, _) => String::new(),
                (missing, true) => format!("stopped: {missing} were not made\n"),
                (missing, false) => format!("{missing} were not made\n"),
            },
        )
    };
    text::answer(&set, page, output)?;
    Ok(if set.missing == 0 { Answer::Done } else { Answer::No })
}
