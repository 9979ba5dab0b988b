//! `cranny scenario from`: a scenario from the model of a world.

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::Args;
use cranny_scenario::{Recipe, WorldConversion, check_free_folder, write_whole_folder};
use serde::Serialize;

use crate::arguments::Output;
use crate::failure::Failure;
use crate::number_argument::finite;
use crate::planning::task::note_all;
use crate::{Answer, text};

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny scenario from kitchen.xml --robot ur5e --target mug -o kitchen
  cranny scenario from lab.sdf --robot arm --target can --world-joint drawer=0.3
  cranny scenario from lab.xml --robot fr3 --at 0.5,0,0.9,180 --target cube

The world is an MJCF, SDF or URDF file. Each link becomes an obstacle, and each body that moves freely one body; shapes
that collide with nothing in the model are left out, and meshes become their convex hulls, as in MuJoCo. The grasps are
sampled when you plan:
  cranny scenario check kitchen
  cranny plan kitchen")]
pub struct FromArguments {
    /// MJCF, SDF or URDF of the world
    #[arg(value_name = "WORLD")]
    pub world: PathBuf,
    /// Robot: a built-in one (see `cranny robot list`), a folder made by `cranny robot add`, or a URDF, MJCF or SDF
    #[arg(long, value_name = "ROBOT")]
    pub robot: PathBuf,
    /// Body to grasp
    #[arg(long, value_name = "BODY")]
    pub target: String,
    /// Value of a joint of the world, in metres or radians, such as drawer=0.3; repeatable [default: as in the file]
    #[arg(long = "world-joint", value_name = "NAME=VALUE", value_parser = joint_value)]
    pub world_joints: Vec<(String, f64)>,
    /// Position of the robot's root in the world, in metres, and its heading in degrees [default: at the origin, its own ground
    /// on the floor]
    #[arg(long, value_name = "X,Y,Z[,DEG]", allow_hyphen_values = true, value_parser = place)]
    pub at: Option<([f64; 3], f64)>,
    /// Body of the world to leave out with all that is below it, such as its robot; repeatable
    #[arg(long, value_name = "BODY")]
    pub leave_out: Vec<String>,
    /// Folder to search for model:// and package:// names, before `GZ_SIM_RESOURCE_PATH`, `GAZEBO_MODEL_PATH` and the folders above
    /// the file; repeatable
    #[arg(long = "model-path", value_name = "FOLDER")]
    pub model_path: Vec<PathBuf>,
    /// Folder to create [default: the name of the world, in this folder]
    #[arg(long, short, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
}

/// Output of `scenario from --json`.
#[derive(Serialize)]
struct Converted {
    folder: PathBuf,
    target: String,
    obstacles: Vec<String>,
    notes: Vec<String>,
}

pub fn convert(arguments: &FromArguments, output: Output) -> Result<Answer, Failure> {
    let stem = || arguments.world.file_stem().unwrap_or_default().into();
    let folder: PathBuf = arguments.output.clone().unwrap_or_else(stem);
    check_free_folder(&folder)?;
    let mut joints = BTreeMap::new();
    for (joint, value) in &arguments.world_joints {
        if joints.insert(joint.clone(), *value).is_some() {
            let problem = format!("the value of joint '{joint}' is given twice");
            return Err(Failure::Flag { flag: "world-joint", problem });
        }
    }
    let conversion = WorldConversion {
        robot: arguments.robot.clone(),
        target: arguments.target.clone(),
        joints,
        left_out: arguments.leave_out.clone(),
        robot_at: arguments.at,
        folders: arguments.model_path.clone(),
    };
    let (recipe, notes) = Recipe::of_world(&arguments.world, &conversion)?;
    write_whole_folder(&folder, |folder| recipe.write_folder(folder))?;
    let obstacles = recipe.obstacles.iter().map(|body| body.name.clone()).collect();
    let converted = Converted { folder, target: arguments.target.clone(), obstacles, notes };
    let page = || {
        let folder = converted.folder.display();
        format!(
            "written to {folder}: target {}, obstacles: {}\n",
            converted.target,
            if converted.obstacles.is_empty() { "none".to_owned() } else { converted.obstacles.join(", ") }
        )
    };
    text::answer(&converted, page, output)?;
    note_all(&converted.notes, output)?;
    Ok(Answer::Done)
}

fn joint_value(text: &str) -> Result<(String, f64), String> {
    let (name, value) =
        text.rsplit_once('=').ok_or_else(|| format!("'{text}' is not of the form NAME=VALUE"))?;
    Ok((name.to_owned(), finite(value)?))
}

fn place(text: &str) -> Result<([f64; 3], f64), String> {
    let numbers = text.split(',').map(|number| finite(number.trim())).collect::<Result<Vec<f64>, _>>()?;
    match numbers[..] {
        [x, y, z] => Ok(([x, y, z], 0.0)),
        [x, y, z, degrees] => Ok(([x, y, z], degrees.to_radians())),
        _ => Err(format!("'{text}' is not of the form X,Y,Z or X,Y,Z,DEG")),
    }
}
