use std::path::{Path, PathBuf};
use std::sync::Arc;

use cranny_robot::{Hindrance, JointGroup, Robot, RobotError, RobotOptions, TextSource, UrdfFile};

use crate::MoveItError;
use crate::moveit::request::{Files, State, joints_of};
use crate::{MoveItDeviation, MoveItOptions, ScenarioError};

impl Files<'_> {
    /// The robot of the request's group, in the given state. What the state says of joints of the group, of
    /// fixed and of following ones is left out, and what is beyond a limit is put right, one at a time: each
    /// is noticed before any mesh is read, so this costs next to nothing.
    pub fn robot(
        &self,
        options: &MoveItOptions,
        state: &State,
        deviations: &mut Vec<MoveItDeviation>,
    ) -> Result<Arc<Robot>, ScenarioError> {
        let urdf = self.urdf(options)?;
        let group = &self.request.group_name;
        let goal_joints: Vec<&str> =
            self.goal_constraints()?.iter().flat_map(|g| joints_of(&g.value)).collect();
        let outside = state.iter().filter(|(joint, _)| !goal_joints.contains(&joint.as_str()));
        let mut wished = RobotOptions {
            srdf: self.srdf(options, &urdf).map(TextSource::Path),
            group: JointGroup::Srdf(group.value.clone()),
            fixed: outside.map(|(joint, (value, _))| (joint.clone(), *value)).collect(),
            ..RobotOptions::default()
        };
        let urdf = UrdfFile::read(&urdf)?;
        loop {
            match urdf.robot(&wished) {
                Err(RobotError::NotFree {
                    joint,
                    hindrance:
                        Hindrance::Fixed
                        | Hindrance::Mimic { .. }
                        | Hindrance::MimicValue { .. }
                        | Hindrance::InGroup,
                    ..
                }) if wished.fixed.remove(&joint).is_some() => {}
                Err(RobotError::HeldOutsideLimits { joint, value: requested, lower, upper, .. })
                    if wished.fixed.contains_key(&joint) =>
                {
                    let held = requested.clamp(lower, upper);
                    wished.fixed.insert(joint.clone(), held);
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
                result => return Ok(Arc::new(result?)),
            }
        }
    }

    fn urdf(&self, options: &MoveItOptions) -> Result<PathBuf, ScenarioError> {
        if let Some(urdf) = &options.robot {
            return Ok(urdf.clone());
        }
        let model = &self.scene.robot_model_name;
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

    /// Where a file of that name may be: in the folder of the scene, and in the one above it.
    fn near_scene(&self, name: &str) -> [PathBuf; 2] {
        let folder = self.scene_file.path.parent().unwrap_or(Path::new(""));
        [folder.join(name), folder.join("..").join(name)]
    }
}
