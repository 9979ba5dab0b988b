use std::fmt::Write;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand, ValueEnum};
use cranny_collision::World;
use cranny_file::counted;
use cranny_robot::Robot;
use cranny_scenario::{
    BUILTIN_ROBOTS, RecipeRobot, ScenarioError, brief_model_notes, check_free_folder, write_whole_folder,
};
use cranny_setup::{Base, Choice, RobotFindings, RobotSetup, SetupOptions};
use serde::Serialize;

use crate::arguments::Output;
use crate::failure::Failure;
use crate::file_kind::FileKind;
use crate::pictures::robot_picture;
use crate::planning::task::note_all;
use crate::{Answer, output_file, progress, text};

#[derive(Clone, Debug, Args)]
pub struct RobotArguments {
    #[command(subcommand)]
    pub command: RobotCommand,
}

#[derive(Clone, Debug, Subcommand)]
pub enum RobotCommand {
    /// List the built-in robots, and those in subfolders of the current folder
    List,
    /// Create a robot's folder from its URDF, MJCF or SDF: determine its hand, gripper frame, base, limits, link pairs that touch by design,
    /// and a free start configuration
    Add(AddArguments),
    /// Write a built-in robot as a folder, to change it or use it elsewhere
    Export(ExportArguments),
    /// Report the settings of a robot and their consequences, and render it
    Check(CheckArguments),
}

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny robot add ur5.urdf
  cranny robot add panda.xml                                          (MJCF; SDF alike)
  cranny robot add arm.urdf.xacro --package ~/ros/share -o my_arm     (expanded by Python's xacro)
  cranny robot add arm.urdf.xacro --xacro side=left --xacro reach=0.4
  cranny robot add rover.urdf --base planar                           let it drive
  cranny robot add arm.urdf --palm tool0 --tip gripper_frame
  cranny robot add arm.urdf --tool suction_cup                        for grasps from files

It asks nothing: it prints each choice with its reason and the flag that changes it. The folder contains the URDF with its meshes,
robot.yaml (hand or tool, start), limits.yaml and an SRDF; each can be changed. Then:
  cranny robot check my_arm --picture my_arm.png
  cranny scenario generate --family table --count 1 --robot my_arm -o cell
  cranny plan cell/table-00000")]
pub struct AddArguments {
    /// URDF, MJCF, SDF or a xacro file
    #[arg(value_name = "URDF")]
    pub urdf: PathBuf,
    /// Folder to create [default: the name of the URDF, in this folder]
    #[arg(long, short, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
    /// SRDF of the robot [default: the file beside the URDF with its name, else the matching entries of the one in ../srdf, if
    /// any]
    #[arg(long, value_name = "FILE")]
    pub srdf: Option<PathBuf>,
    /// Folder to search for package:// and model:// names, and $(find …) of xacro, before the folders above the URDF; repeatable
    #[arg(long = "package", value_name = "FOLDER")]
    pub packages: Vec<PathBuf>,
    /// Argument of a xacro file; repeatable
    #[arg(long, value_name = "NAME=VALUE")]
    pub xacro: Vec<String>,
    /// Gripper frame: between the pads, y the axis on which they close, z the approach direction; of a tool, z alone [default: determined
    /// automatically]
    #[arg(long, value_name = "LINK")]
    pub tip: Option<String>,
    /// Link that carries the fingers [default: determined automatically]
    #[arg(long, value_name = "LINK")]
    pub palm: Option<String>,
    /// Link that grasps without pads that close along an axis: a suction cup, or the palm of a hand with more than two fingers.
    /// Grasps for it come from files
    #[arg(long, value_name = "LINK", conflicts_with_all = ["palm", "bare"])]
    pub tool: Option<String>,
    /// Motion of the root link [default: as in the URDF; a hand without an arm flies]
    #[arg(long, value_name = "HOW")]
    pub base: Option<BaseName>,
    /// Leave an arm without a hand as it is, instead of attaching the built-in gripper
    #[arg(long)]
    pub bare: bool,
}

/// Motion of the root link of a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BaseName {
    /// As in the URDF
    Own,
    /// Drives on the floor: x, y and heading
    Planar,
    /// Flies: x, y, z, yaw, pitch, roll
    Floating,
}

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny robot check ur5e
  cranny robot check my_arm --picture my_arm.png
  cranny robot check robot.urdf --json")]
pub struct CheckArguments {
    /// Built-in robot, a robot's folder, or a URDF, MJCF or SDF
    #[arg(value_name = "ROBOT")]
    pub robot: PathBuf,
    /// Also render it: at its start, and its hand open and closed with the gripper frame (x red, y green, z blue)
    #[arg(long, value_name = "FILE")]
    pub picture: Option<PathBuf>,
}

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny robot export ur5e -o my_ur5e
  cranny robot export fetch_like")]
pub struct ExportArguments {
    /// Built-in robot
    #[arg(value_name = "ROBOT")]
    pub robot: PathBuf,
    /// Folder to create [default: the robot's name, in this folder]
    #[arg(long, short, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
}

pub fn run(arguments: &RobotArguments, output: Output) -> Result<Answer, Failure> {
    match &arguments.command {
        RobotCommand::List => list(output),
        RobotCommand::Add(arguments) => add(arguments, output),
        RobotCommand::Check(arguments) => check(arguments, output),
        RobotCommand::Export(arguments) => export(arguments, output),
    }
}

fn export(arguments: &ExportArguments, output: Output) -> Result<Answer, Failure> {
    let folder = arguments.output.clone().unwrap_or_else(|| arguments.robot.clone());
    check_free_folder(&folder)?;
    let robot = RecipeRobot::load(&arguments.robot)?;
    write_whole_folder(&folder, |folder| robot.write(folder).map(|_| ()))?;
    let page = || format!("written to {}\n", folder.display());
    text::answer(&serde_json::json!({ "folder": folder }), page, output)?;
    Ok(Answer::Done)
}

#[derive(Serialize)]
struct Listed {
    robot: String,
    about: String,
    joints: usize,
}

fn list(output: Output) -> Result<Answer, Failure> {
    let mut robots = Vec::new();
    for builtin in BUILTIN_ROBOTS {
        let RecipeRobot { robot, .. } = RecipeRobot::load(Path::new(builtin.name))?;
        robots.push(Listed {
            robot: builtin.name.to_owned(),
            about: builtin.about.to_owned(),
            joints: robot.dof(),
        });
    }
    let mut folders: Vec<PathBuf> = std::fs::read_dir(".")
        .map(|entries| entries.filter_map(|entry| Some(entry.ok()?.path())).collect())
        .unwrap_or_default();
    folders.retain(|folder| folder.join("robot.yaml").is_file());
    folders.sort();
    for folder in folders {
        let name = folder.strip_prefix(".").unwrap_or(&folder).display().to_string();
        robots.push(match RecipeRobot::load(&folder) {
            Ok(RecipeRobot { robot, .. }) => Listed {
                robot: name,
                about: format!("{}, in this folder", robot.name()),
                joints: robot.dof(),
            },
            Err(fault) => Listed { robot: name, about: fault.to_string(), joints: 0 },
        });
    }
    let page = || {
        let mut page = String::new();
        for Listed { robot, about, .. } in &robots {
            let _ = writeln!(page, "  {robot:<14} {about}");
        }
        page + "\nTry: cranny plan 021 --robot ur5e_mobile, or cranny robot add URDF\n"
    };
    text::answer(&robots, page, output)?;
    Ok(Answer::Done)
}

/// Output of `robot add --json`.
#[derive(Serialize)]
struct Added<'a> {
    folder: &'a Path,
    choices: &'a [Choice],
    joints: &'a [String],
}

fn add(arguments: &AddArguments, output: Output) -> Result<Answer, Failure> {
    let default_name = || cranny_setup::robot_name(&arguments.urdf).into();
    let folder: PathBuf = arguments.output.clone().unwrap_or_else(default_name);
    check_free_folder(&folder)?;
    let options = SetupOptions {
        srdf: arguments.srdf.clone(),
        packages: arguments.packages.clone(),
        xacro: arguments.xacro.clone(),
        tip: arguments.tip.clone(),
        palm: arguments.palm.clone(),
        tool: arguments.tool.clone(),
        base: arguments.base.map(|base| match base {
            BaseName::Own => Base::Own,
            BaseName::Planar => Base::Planar,
            BaseName::Floating => Base::Floating,
        }),
        is_bare: arguments.bare,
    };
    let spinner = progress::spinner("finding out about the robot", output.quiet);
    let setup = RobotSetup::of(&arguments.urdf, &options);
    spinner.finish_and_clear();
    let setup = setup?;
    setup.write(&folder)?;
    let added = Added { folder: &folder, choices: &setup.choices, joints: setup.robot.joint_names() };
    let page = || {
        let mut page = format!("{}: {}\n", setup.name, moving(&setup.robot));
        for choice in &setup.choices {
            let _ = writeln!(page, "  {:<16}{}", choice.what, choice.chosen);
            let _ = writeln!(page, "  {:<16}because {}; otherwise: {}", "", choice.why, choice.otherwise);
        }
        let folder = folder.display();
        let _ = writeln!(
            page,
            "written to {folder}; look at it: cranny robot check {folder} --picture {folder}.png"
        );
        page
    };
    text::answer(&added, page, output)?;
    note_all(&brief_model_notes(&setup.robot, &World::default()), output)?;
    Ok(Answer::Done)
}

fn check(arguments: &CheckArguments, output: Output) -> Result<Answer, Failure> {
    if let Some(picture) = &arguments.picture {
        output_file::check(picture, FileKind::Png, output)?;
    }
    let recipe = RecipeRobot::load(&arguments.robot)?;
    let spinner = progress::spinner("drawing configurations", output.quiet);
    let findings = RobotFindings::of(&recipe.robot);
    spinner.finish_and_clear();
    let findings = findings?;
    if let Some(picture) = &arguments.picture {
        robot_picture::write(&arguments.robot, &recipe, picture)?;
    }
    let page = || page(&recipe.robot, &findings, arguments.picture.as_deref());
    text::answer(&findings, page, if findings.is_sound() { output } else { output.aloud() })?;
    Ok(if findings.is_sound() { Answer::Done } else { Answer::No })
}

/// Formats the number of moving joints.
fn moving(robot: &Robot) -> String {
    let verb = if robot.dof() == 1 { "moves" } else { "move" };
    format!("{} {verb}", counted(robot.dof(), "joint"))
}

fn page(robot: &Robot, findings: &RobotFindings, picture: Option<&Path>) -> String {
    let mut page = format!("{}: {}\n", robot.name(), moving(robot));
    for joint in &findings.joints {
        let _ = writeln!(page, "  {joint}");
    }
    for finding in &findings.findings {
        let mark = if finding.is_fault { "!" } else { " " };
        let _ = writeln!(page, "{mark} {:<16}{}", finding.what, finding.found);
        let _ = writeln!(page, "  {:<16}{}", "", finding.consequence);
    }
    if let Some(picture) = picture {
        let _ = writeln!(page, "  {:<16}{}", "picture", picture.display());
    }
    page
}

impl From<cranny_setup::SetupError> for Failure {
    fn from(error: cranny_setup::SetupError) -> Self {
        match error {
            cranny_setup::SetupError::Scenario(error) => Self::Scenario(error),
            cranny_setup::SetupError::Robot(error) => Self::Scenario(ScenarioError::from(error)),
            other => Self::Setup(other),
        }
    }
}
