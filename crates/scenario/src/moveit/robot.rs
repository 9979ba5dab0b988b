use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use cranny_robot::{
    JointConstraint, JointGroup, Robot, RobotError, RobotOptions, Srdf, TextSource, UrdfFile,
    VirtualJointKind,
};

use crate::files::yaml;
use crate::moveit::matrix::Matrix;
use crate::moveit::request::{Files, ROUNDING, State};
use crate::{MoveItDeviation, MoveItError, MoveItOptions, ScenarioError};

impl Files<'_> {
    /// Builds the robot of the request's group, in the given state. State values of joints of the group, of fixed and of
    /// following joints are dropped, and values beyond a limit are corrected, one at a time: each costs little, because it is
    /// detected before any mesh is read.
    pub fn robot(
        &self,
        options: &MoveItOptions,
        state: &State,
        deviations: &mut Vec<MoveItDeviation>,
    ) -> Result<Arc<Robot>, ScenarioError> {
        let urdf_path = self.urdf(options)?;
        let srdf_path = self.srdf(options, &urdf_path);
        let (srdf, srdf_text) = srdf_path.as_deref().map(read_srdf).transpose()?.unzip();
        let srdf = srdf.unwrap_or_default();
        let group = &self.request.group_name;
        let limits = self.joint_limits([Some(urdf_path.as_path()), srdf_path.as_deref()]);
        deviations.extend(limits.iter().map(|path| MoveItDeviation::JointLimits { path: path.clone() }));
        let goals = self.goal_values()?;
        // A passive joint that no goal moves keeps its value.
        let is_moved = |joint: &str, value: f64| {
            goals.get(joint).is_some_and(|goals| {
                let stays = goals.iter().all(|goal| (goal - value).abs() <= ROUNDING);
                !(stays && srdf.passive_joints.iter().any(|passive| passive == joint))
            })
        };
        let outside = state.iter().filter(|(joint, (value, _))| !is_moved(joint, *value));
        let mut wished = RobotOptions {
            srdf: srdf_text,
            group: JointGroup::Srdf(group.value.clone()),
            fixed: outside.map(|(joint, (value, _))| (joint.clone(), *value)).collect(),
            joint_limits: limits.map(TextSource::Path),
            rate_scales: self.rate_scales()?,
            ..RobotOptions::default()
        };
        let urdf = UrdfFile::read(&urdf_path)?;
        let matrix = Matrix::new(&self.scene_file, &self.scene.allowed_collision_matrix)?;
        // Joints of the group, and those that do not move freely.
        let mut left_out: HashSet<String> = HashSet::new();
        let mut clamped: HashSet<String> = HashSet::new();
        loop {
            match urdf.robot(&wished) {
                Err(RobotError::NotFree {
                    joint,
                    constraint:
                        JointConstraint::Fixed
                        | JointConstraint::Mimic { .. }
                        | JointConstraint::MimicValue { .. }
                        | JointConstraint::InGroup,
                    ..
                }) if wished.fixed.remove(&joint).is_some() => {
                    left_out.insert(joint);
                }
                Err(RobotError::HeldOutsideLimits { joint, value: requested, lower, upper, .. })
                    if wished.fixed.contains_key(&joint) =>
                {
                    let held = requested.clamp(lower, upper);
                    wished.fixed.insert(joint.clone(), held);
                    clamped.insert(joint.clone());
                    deviations.push(MoveItDeviation::HeldAtLimit { joint, requested, held });
                }
                Err(reason @ RobotError::UnknownName { .. }) => {
                    let RobotError::UnknownName { name, .. } = &reason else { return Err(reason.into()) };
                    let at = if *name == group.value {
                        self.request_file.at(group.referenced)
                    } else if let Some((_, at)) = state.get(name).filter(|_| wished.fixed.contains_key(name))
                    {
                        at.clone()
                    } else {
                        return Err(reason.into());
                    };
                    return Err(MoveItError::NotOfRobot { at, reason: Box::new(reason) }.into());
                }
                Err(reason) => return Err(reason.into()),
                Ok(robot) => {
                    // A goal may name joints outside the group, which have the values of the state.
                    let is_missing = |joint: &&String| {
                        !wished.fixed.contains_key(*joint)
                            && !left_out.contains(*joint)
                            && !robot.joint_names().contains(joint)
                    };
                    let missing: Vec<String> = state.keys().filter(is_missing).cloned().collect();
                    let forbidden = matrix.forbidden(&robot);
                    if missing.is_empty() && forbidden.is_empty() {
                        self.note_robot(&robot, &srdf, state, &clamped, deviations);
                        return Ok(Arc::new(robot));
                    }
                    wished.fixed.extend(missing.into_iter().map(|joint| (joint.clone(), state[&joint].0)));
                    wished.checked_pairs.extend(forbidden);
                }
            }
        }
    }

    /// Records each difference between the robot and the files.
    fn note_robot(
        &self,
        robot: &Robot,
        srdf: &Srdf,
        state: &State,
        clamped: &HashSet<String>,
        deviations: &mut Vec<MoveItDeviation>,
    ) {
        let start: Vec<f64> = robot
            .joint_names()
            .iter()
            .map(|joint| state.get(joint).map_or(0.0, |(value, _)| *value))
            .collect();
        let outside = |joint: &String| !robot.joint_names().contains(joint) && !clamped.contains(joint);
        for (joint, (requested, _)) in state.iter().filter(|(joint, _)| outside(joint)) {
            let held = robot.joint_value(joint, &start).unwrap_or(*requested);
            if (held - requested).abs() > ROUNDING {
                let (joint, requested) = (joint.clone(), *requested);
                deviations.push(MoveItDeviation::NotFree { joint, requested, held });
            }
        }
        for (joint, held) in robot.standing_joints() {
            if !state.contains_key(joint) {
                deviations.push(MoveItDeviation::NotGiven { joint: joint.to_owned(), held });
            }
        }
        let passive = robot.joint_names().iter().filter(|joint| robot.passive_joints().contains(joint));
        deviations.extend(passive.map(|joint| MoveItDeviation::PassiveMoves { joint: joint.clone() }));
        let moves_base = srdf.virtual_joints.iter().filter(|joint| {
            joint.kind != VirtualJointKind::Fixed
                && (srdf.has_joint(&self.request.group_name.value, &joint.name)
                    || srdf.has_chain_from(&self.request.group_name.value, &joint.parent_frame))
        });
        deviations.extend(moves_base.map(|joint| MoveItDeviation::BaseStands { joint: joint.name.clone() }));
        let known = srdf.untested_links.iter().filter(|link| robot.link_index(link).is_some());
        deviations.extend(known.map(|link| MoveItDeviation::AllowedLinkChecked { name: link.clone() }));
        let model = &self.scene.robot_model_name;
        if !model.is_empty() && model != robot.name() {
            let (scene, robot) = (model.clone(), robot.name().to_owned());
            deviations.push(MoveItDeviation::OtherRobot { scene, robot });
        }
    }

    fn urdf(&self, options: &MoveItOptions) -> Result<PathBuf, ScenarioError> {
        if let Some(urdf) = &options.robot {
            return Ok(urdf.clone());
        }
        let model = &self.scene.robot_model_name;
        if model.is_empty() {
            return Err(MoveItError::NoRobotName { path: self.scene_file.path.to_owned() }.into());
        }
        let tried: Vec<PathBuf> = [format!("{model}_spherized.urdf"), format!("{model}.urdf")]
            .iter()
            .flat_map(|name| self.near_scene(name))
            .collect();
        let found = tried.iter().find(|file| file.is_file()).cloned();
        found.ok_or_else(|| MoveItError::NoRobot { path: self.scene_file.path.to_owned(), tried }.into())
    }

    fn srdf(&self, options: &MoveItOptions, urdf: &Path) -> Option<PathBuf> {
        let name = format!("{}.srdf", self.scene.robot_model_name);
        let beside = [urdf.with_extension("srdf"), urdf.with_file_name(&name)];
        let default = || beside.into_iter().chain(self.near_scene(&name)).find(|file| file.is_file());
        options.srdf.clone().or_else(default)
    }

    /// Returns the path of `MoveIt`'s joint limits: beside a file of robot or scene, or in `config` beside it or its folder.
    fn joint_limits(&self, of_robot: [Option<&Path>; 2]) -> Option<PathBuf> {
        let files = of_robot.into_iter().flatten().chain([self.scene_file.path]);
        let folders = files.map(|file| file.parent().unwrap_or(Path::new("")));
        let mut tried = folders.flat_map(|folder| {
            ["", "config", "../config"].map(|between| folder.join(between).join("joint_limits.yaml"))
        });
        tried.find(|file| file.is_file())
    }

    /// Returns the possible paths of a file of that name: in the folder of the scene, and in the one above it.
    fn near_scene(&self, name: &str) -> [PathBuf; 2] {
        let folder = self.scene_file.path.parent().unwrap_or(Path::new(""));
        [folder.join(name), folder.join("..").join(name)]
    }
}

/// Reads an SRDF; returns it parsed, and as the text from which the robot is built.
fn read_srdf(path: &Path) -> Result<(Srdf, TextSource), ScenarioError> {
    let (name, text) = (path.display().to_string(), yaml::text(cranny_file::TEXT, path)?);
    Ok((Srdf::parse(&text, &name)?, TextSource::Text { name, text }))
}
