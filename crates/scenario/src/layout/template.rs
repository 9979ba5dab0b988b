use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use cranny_robot::{JointGroup, Robot, RobotOptions, TextSource};

use crate::layout::own;
use crate::robot::file;
use crate::robot::in_folder::RobotInFolder;
use crate::{BUILTIN_ROBOTS, RobotSource, ScenarioError, write_whole_folder};

/// Robot of a new scenario, if it is not the built-in one.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TemplateRobot {
    /// URDF, folder with a `robot.yaml`, or name of a built-in robot.
    pub robot: PathBuf,
    /// SRDF. Default: the one beside the URDF, if there is one.
    pub srdf: Option<PathBuf>,
    /// Group of the SRDF whose joints move. Default: all joints from the root to the tip.
    pub group: Option<String>,
    /// Link that reaches the grasps. Default: see [`RobotOptions::tip`].
    pub tip: Option<String>,
    /// Folders in which `package://` names of the URDF are resolved.
    pub packages: Vec<PathBuf>,
}

/// Creates a new scenario: a folder with a commented `scenario.yaml` and a `grasps.csv`, which opens. With the built-in robot
/// it can be planned unchanged. The files of another robot are copied to `robot/`, and the poses of the bodies must then be
/// adapted to it.
///
/// # Errors
/// [`ScenarioError::Exists`] if the path exists already, [`ScenarioError::Unwritable`], and any fault of the robot, before
/// anything is written.
pub fn write_template(folder: &Path, robot: Option<&TemplateRobot>) -> Result<(), ScenarioError> {
    let mut files = vec![(own::GRASPS_FILE.to_owned(), GRASPS.as_bytes().to_vec())];
    let mut text = SCENARIO.to_owned();
    if let Some(robot) = robot {
        let options = robot.options();
        let model = file::load(&robot.robot, &options)?;
        if let RobotSource::Builtin(name) = RobotSource::of(&robot.robot) {
            text = text.replace(&format!("robot: {}", BUILTIN_ROBOTS[0].name), &format!("robot: {name}"));
        } else {
            let gathered = RobotInFolder::gather(&robot.robot, robot.srdf.as_deref(), &robot.packages)?;
            files.extend(gathered.contents().map(|(name, content)| (name, content.to_vec())));
            text = gathered.named_in(&text);
        }
        text = robot.named_in(&text, &model);
    }
    files.push((own::FILE.to_owned(), text.into_bytes()));
    write_whole_folder(folder, |folder| {
        for (name, content) in files {
            let path = folder.join(name);
            let write = || -> std::io::Result<()> {
                fs::create_dir_all(path.parent().unwrap_or(folder))?;
                fs::write(&path, content)
            };
            write().map_err(|reason| ScenarioError::Unwritable { path: path.clone(), reason })?;
        }
        Ok(())
    })
}

impl TemplateRobot {
    fn options(&self) -> RobotOptions {
        RobotOptions {
            srdf: self.srdf.clone().map(TextSource::Path),
            group: self.group.clone().map_or(JointGroup::RootToTip, JointGroup::Srdf),
            tip: self.tip.clone(),
            packages: self.packages.clone(),
            ..RobotOptions::default()
        }
    }

    /// Returns the template with this robot's group, tip, ground and joints, at the values of its files or else nearest to 0.
    fn named_in(&self, template: &str, model: &Robot) -> String {
        let mut text = String::new();
        let mut is_start = false;
        // Values of the robot's own files are not repeated.
        let says_tip = self.tip.is_none() && (model.hand().is_some() || model.tool().is_some());
        for line in template.lines() {
            is_start &= line.starts_with(' ');
            if is_start {
                continue;
            }
            text += line;
            text.push('\n');
            if let Some(ground_m) = model.floor_m().filter(|_| line.starts_with("frame:")) {
                let line_end = text.trim_end().rfind('\n').map_or(0, |end| end + 1);
                text.truncate(line_end);
                let _ = writeln!(text, "frame: {{position: [0, 0, {}]}}", -ground_m);
            }
            if line.starts_with("robot:") {
                for (key, value) in [
                    ("group", self.group.as_deref()),
                    ("tip", Some(model.links()[model.tip()].name.as_str()).filter(|_| !says_tip)),
                ] {
                    if let Some(value) = value {
                        let _ = writeln!(text, "{key}: {value:?}");
                    }
                }
            }
            is_start = line == "start:";
            if is_start {
                let near_zero: Vec<f64> = model.limits().iter().map(|limits| limits.clamp(0.0)).collect();
                let start = model.default_start().unwrap_or(&near_zero);
                for (joint, value) in model.joint_names().iter().zip(start) {
                    let _ = writeln!(text, "  {joint:?}: {value}");
                }
            }
        }
        text
    }
}

const SCENARIO: &str = include_str!("template/scenario.yaml");

const GRASPS: &str = include_str!("template/grasps.csv");
