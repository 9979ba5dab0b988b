use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use cranny_robot::{JointConstraint, JointGroup, Robot, RobotError, RobotOptions, Srdf, VirtualJointKind};

use crate::moveit::matrix::Matrix;
use crate::moveit::request::{Files, ROUNDING, State};
use crate::moveit::robot_model::MoveItRobot;
use crate::{MoveItDeviation, MoveItError, MoveItOptions, ScenarioError};

impl Files {
    /// Builds the robot of the request's group, in the given state. State values of joints of the group, of fixed and of
    /// following joints are dropped, and values beyond a limit are corrected, one at a time: each costs little, because it is
    /// detected before any mesh is read.
    pub fn robot(
        &self,
        model: &mut MoveItRobot,
        state: &State,
        deviations: &mut Vec<MoveItDeviation>,
    ) -> Result<Arc<Robot>, ScenarioError> {
        let srdf = model.srdf().clone();
        let group = &self.request.group_name;
        deviations
            .extend(model.joint_limits().map(|path| MoveItDeviation::JointLimits { path: path.to_owned() }));
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
            group: JointGroup::Srdf(group.value.clone()),
            fixed: outside.map(|(joint, (value, _))| (joint.clone(), *value)).collect(),
            rate_scales: self.rate_scales()?,
            ..RobotOptions::default()
        };
        let matrix = Matrix::new(&self.scene_file, &self.scene.allowed_collision_matrix)?;
        // Joints of the group, and those that do not move freely.
        let mut left_out: HashSet<String> = HashSet::new();
        let mut clamped: HashSet<String> = HashSet::new();
        loop {
            match model.build(&wished) {
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
                        return Ok(robot);
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

    /// Reads the files of the robot: those of the options, or else those near the scene.
    pub fn robot_files(&self, options: &MoveItOptions) -> Result<MoveItRobot, ScenarioError> {
        let urdf = self.urdf(options)?;
        let name = format!("{}.srdf", self.scene.robot_model_name);
        let beside = urdf.with_file_name(&name);
        let other = std::iter::once(beside).chain(self.near_scene(&name)).find(|file| file.is_file());
        let scene = Some(self.scene_file.path.as_path());
        MoveItRobot::of_files(&urdf, options.srdf.as_deref(), [other.as_deref(), scene])
    }

    fn urdf(&self, options: &MoveItOptions) -> Result<PathBuf, ScenarioError> {
        if let Some(urdf) = &options.robot {
            return Ok(urdf.clone());
        }
        let model = &self.scene.robot_model_name;
        if model.is_empty() {
            return Err(MoveItError::NoRobotName { path: self.scene_file.path.clone() }.into());
        }
        let tried: Vec<PathBuf> = [format!("{model}_spherized.urdf"), format!("{model}.urdf")]
            .iter()
            .flat_map(|name| self.near_scene(name))
            .collect();
        let found = tried.iter().find(|file| file.is_file()).cloned();
        found.ok_or_else(|| MoveItError::NoRobot { path: self.scene_file.path.clone(), tried }.into())
    }

    /// Returns the possible paths of a file of that name: in the folder of the scene, and in the one above it.
    fn near_scene(&self, name: &str) -> [PathBuf; 2] {
        let folder = self.scene_file.path.parent().unwrap_or(Path::new(""));
        [folder.join(name), folder.join("..").join(name)]
    }
}
