use std::collections::BTreeMap;

use cranny_robot::{Location, Robot};
use cranny_spatial::Pose;
use serde_saphyr::Spanned;

use crate::MoveItError;
use crate::ScenarioError;
use crate::files::yaml;
use crate::moveit::file::{ConstraintsEntry, JointStateEntry, RequestFile, SceneFile, StateEntry};
use crate::moveit::world::MessageFile;

/// Both files, and what errors call them.
pub(crate) struct Files<'a> {
    pub scene_file: MessageFile<'a>,
    pub scene: SceneFile,
    pub request_file: MessageFile<'a>,
    pub request: RequestFile,
}

/// Values of joints (m, rad) by name, with the place each stands at.
pub(crate) type State = BTreeMap<String, (f64, Location)>;

impl Files<'_> {
    /// What the request says of the start, and where it says nothing, the scene.
    pub fn state(&self) -> Result<State, ScenarioError> {
        let mut state = State::new();
        let request = (&self.request_file, &self.request.start_state);
        for (file, StateEntry { joint_state, .. }) in [request, (&self.scene_file, &self.scene.robot_state)] {
            let Some(Spanned { value: JointStateEntry { name, position }, referenced, .. }) = joint_state
            else {
                continue;
            };
            if name.len() != position.len() {
                let (at, names, values) = (file.at(*referenced), name.len(), position.len());
                return Err(MoveItError::JointState { at, names, values }.into());
            }
            let mut said = State::new();
            for (name, position) in name.iter().zip(position) {
                let at = file.at(position.referenced);
                let value = file.finite(position)?;
                if said.insert(name.value.clone(), (value, at)).is_some() {
                    let at = file.at(name.referenced);
                    return Err(MoveItError::JointTwice { at, joint: name.value.clone() }.into());
                }
            }
            for (joint, value) in said {
                state.entry(joint).or_insert(value);
            }
        }
        if let Some(attached) = &self.request.start_state.attached_collision_objects
            && !attached.value.is_empty()
        {
            let hint = "add it to the URDF";
            return Err(self.request_file.unsupported(attached.referenced, "an attached object", hint));
        }
        Ok(state)
    }

    pub fn world_from_root(&self) -> Result<Pose, ScenarioError> {
        let Some(floating) = &self.request.start_state.multi_dof_joint_state else {
            return Ok(Pose::identity());
        };
        match &floating.value.transforms[..] {
            [] => Ok(Pose::identity()),
            [transform] => self.request_file.pose(transform),
            _ => {
                let hint = "only the one between world and robot is read";
                Err(self.request_file.unsupported(floating.referenced, "more than one floating joint", hint))
            }
        }
    }

    pub fn start(&self, robot: &Robot, state: &State) -> Result<Vec<f64>, ScenarioError> {
        let start = &self.request.start_state.joint_state;
        let value = |joint: &String| match state.get(joint) {
            Some((value, _)) => Ok(*value),
            None => Err(ScenarioError::MissingJoint {
                at: start.as_ref().map_or_else(
                    || yaml::line(self.request_file.path, 1),
                    |start| self.request_file.at(start.referenced),
                ),
                joint: joint.clone(),
            }),
        };
        robot.joint_names().iter().map(value).collect()
    }

    pub fn goal_constraints(&self) -> Result<&[Spanned<ConstraintsEntry>], ScenarioError> {
        match &self.request.goal_constraints {
            Some(goals) if !goals.value.is_empty() => Ok(&goals.value),
            _ => Err(MoveItError::NoGoal { path: self.request_file.path.to_owned() }.into()),
        }
    }

    pub fn goals(&self, robot: &Robot) -> Result<Vec<Vec<f64>>, ScenarioError> {
        let file = &self.request_file;
        if let Some(path) = &self.request.path_constraints
            && (has_other_constraints(&path.value) || !path.value.joints.is_empty())
        {
            return Err(file.unsupported(path.referenced, "a path constraint", "leave it out"));
        }
        let goal = |entry: &Spanned<ConstraintsEntry>| {
            if has_other_constraints(&entry.value) {
                let hint = "give the goal as joint constraints";
                return Err(file.unsupported(entry.referenced, "a goal that is no configuration", hint));
            }
            let mut q: Vec<Option<f64>> = vec![None; robot.dof()];
            for constraint in &entry.value.joints {
                let (at, joint) = (file.at(constraint.joint_name.referenced), &constraint.joint_name.value);
                let index = robot.joint_names().iter().position(|name| name == joint);
                let Some(index) = index else {
                    let known = robot.joint_names().join(", ");
                    return Err(ScenarioError::UnknownJoint { at, joint: joint.clone(), known });
                };
                if q[index].replace(file.finite(&constraint.position)?).is_some() {
                    return Err(MoveItError::JointTwice { at, joint: joint.clone() }.into());
                }
            }
            let missing = |(value, joint): (Option<f64>, &String)| {
                value.ok_or_else(|| {
                    MoveItError::GoalWithoutJoint { at: file.at(entry.referenced), joint: joint.clone() }
                        .into()
                })
            };
            q.into_iter().zip(robot.joint_names()).map(missing).collect()
        };
        self.goal_constraints()?.iter().map(goal).collect()
    }
}

pub(crate) fn joints_of(goal: &ConstraintsEntry) -> impl Iterator<Item = &str> {
    goal.joints.iter().map(|constraint| constraint.joint_name.value.as_str())
}

fn has_other_constraints(entry: &ConstraintsEntry) -> bool {
    !(entry.positions.is_empty() && entry.orientations.is_empty() && entry.visibilities.is_empty())
}
