use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

use cranny_robot::{Location, RateScales, Robot};
use serde_saphyr::Spanned;

use crate::MoveItDeviation;
use crate::MoveItError;
use crate::ScenarioError;
use crate::moveit::file::{ConstraintsEntry, JointStateEntry, RequestFile, SceneFile, StateEntry};
use crate::moveit::form::{read_request, read_scene};
use crate::moveit::message_file::MessageFile;

/// Scene and request, with their files for error messages.
pub(crate) struct Files {
    pub scene_file: MessageFile,
    pub scene: SceneFile,
    pub request_file: MessageFile,
    pub request: RequestFile,
}

/// Values of joints (m, rad) by name, each with its location in a file.
pub(crate) type State = BTreeMap<String, (f64, Location)>;

/// Maximum difference that counts as rounding, in metres or radians: that of values printed with four decimals.
pub(crate) const ROUNDING: f64 = 1e-4;

/// Speed below which a joint counts as at rest, in m/s or rad/s: noise of an encoder.
const AT_REST: f64 = 1e-3;

impl Files {
    /// Reads a scene and a request.
    pub fn new(scene_file: MessageFile, request_file: MessageFile) -> Result<Self, ScenarioError> {
        let (scene, request) = (read_scene(&scene_file)?, read_request(&request_file)?);
        Ok(Self { scene_file, scene, request_file, request })
    }

    /// Returns the states of both files, that of the request first.
    pub fn states(&self) -> [(&MessageFile, &StateEntry); 2] {
        [(&self.request_file, &self.request.start_state), (&self.scene_file, &self.scene.robot_state)]
    }

    /// Returns the start state of the request, and for joints missing there that of the scene.
    pub fn state(&self, deviations: &mut Vec<MoveItDeviation>) -> Result<State, ScenarioError> {
        let mut state = State::new();
        for (file, StateEntry { joint_state, .. }) in self.states() {
            let Some(Spanned { value: JointStateEntry { name, position, velocity, .. }, referenced, .. }) =
                joint_state
            else {
                continue;
            };
            for (kind, values) in [("positions", position), ("velocities", velocity)] {
                if name.len() != values.len() && !(kind == "velocities" && values.is_empty()) {
                    let (at, names, values) = (file.at(*referenced), name.len(), values.len());
                    return Err(MoveItError::JointState { at, names, kind, values }.into());
                }
            }
            let mut given = State::new();
            for (index, (name, position)) in name.iter().zip(position).enumerate() {
                let at = file.at(position.referenced);
                let value = file.finite(position)?;
                if given.insert(name.value.clone(), (value, at)).is_some() {
                    let at = file.at(name.referenced);
                    return Err(MoveItError::JointTwice { at, joint: name.value.clone() }.into());
                }
                let velocity = velocity.get(index).map_or(Ok(0.0), |velocity| file.finite(velocity))?;
                if velocity.abs() > AT_REST && !state.contains_key(&name.value) {
                    deviations.push(MoveItDeviation::Moves { joint: name.value.clone(), velocity });
                }
            }
            for (joint, value) in given {
                state.entry(joint).or_insert(value);
            }
        }
        Ok(state)
    }

    /// Refuses content of the request other than a start and goal configurations.
    pub fn refuse_what_is_not_asked(&self) -> Result<(), ScenarioError> {
        let (file, request) = (&self.request_file, &self.request);
        let attached = &request.start_state.attached_collision_objects;
        file.refuse(attached, "an attached object", "add it to the URDF")?;
        if let Some(constraints) = &request.trajectory_constraints
            && !constraints.value.constraints.is_empty()
        {
            return Err(file.unsupported(constraints.referenced, "a trajectory constraint", "leave it out"));
        }
        Ok(())
    }

    /// Returns the maximum speed of the gripper frame, in m/s, that the request specifies; 0 counts as not given.
    pub fn tool_speed_m_s(&self, robot: &Robot) -> Result<Option<f64>, ScenarioError> {
        let (file, request) = (&self.request_file, &self.request);
        let Some(speed) = request.max_cartesian_speed.as_ref().filter(|speed| speed.value != 0.0) else {
            return Ok(None);
        };
        if !(speed.value > 0.0 && speed.value.is_finite()) {
            let hint = "give a positive one, in m/s";
            return Err(file.unsupported(speed.referenced, "an invalid limit of Cartesian speed", hint));
        }
        let links = [&request.cartesian_speed_limited_link, &request.cartesian_speed_end_effector_link];
        let named = links.into_iter().flatten().find(|link| !link.value.is_empty());
        let tip = &robot.links()[robot.tip()].name;
        match named.filter(|link| link.value != *tip) {
            Some(link) => Err(file.unsupported(
                link.referenced,
                "a limit of the speed of a link that is not the tip of the group",
                "name the tip",
            )),
            None => Ok(Some(speed.value)),
        }
    }

    /// Returns the time that the request allows for planning; 0 counts as not given.
    pub fn allowed_time(&self) -> Result<Option<Duration>, ScenarioError> {
        let Some(time) = self.request.allowed_planning_time.as_ref().filter(|time| time.value != 0.0) else {
            return Ok(None);
        };
        Duration::try_from_secs_f64(time.value).map(Some).map_err(|_| {
            let hint = "give a positive number of seconds";
            self.request_file.unsupported(time.referenced, "an invalid planning time", hint)
        })
    }

    /// Returns the robot with the joint bounds of the path constraints, whose tolerances joints of the group keep at all times.
    pub fn with_held_joints(&self, robot: Arc<Robot>) -> Result<Arc<Robot>, ScenarioError> {
        let file = &self.request_file;
        let Some(path) = self.request.path_constraints.as_ref().filter(|path| !path.value.joints.is_empty())
        else {
            return Ok(robot);
        };
        let mut held = Arc::unwrap_or_clone(robot);
        for constraint in &path.value.joints {
            let (at, joint) = (file.at(constraint.joint_name.referenced), &constraint.joint_name.value);
            let Some(index) = held.joint_names().iter().position(|name| name == joint) else {
                let known = held.joint_names().join(", ");
                return Err(ScenarioError::UnknownJoint { at, joint: joint.clone(), known });
            };
            let tolerance = |given: Option<&Spanned<f64>>| match given {
                Some(given) if !(given.value >= 0.0 && given.value.is_finite()) => Err(file.unsupported(
                    given.referenced,
                    "a tolerance that is no finite number of at least 0",
                    "give one",
                )),
                given => Ok(given.map_or(0.0, |given| given.value)),
            };
            let mut turned: Vec<f64> = held.limits().iter().map(|limits| limits.clamp(0.0)).collect();
            turned[index] = file.finite(&constraint.position)?;
            held.turn_into_limits(&mut turned);
            let value = turned[index];
            let lower = value - tolerance(constraint.tolerance_below.as_ref())?;
            let upper = value + tolerance(constraint.tolerance_above.as_ref())?;
            held = held.with_joint_between(index, lower, upper);
            let limits = &held.limits()[index];
            if limits.lower > limits.upper {
                let what = "a path constraint that no value within the joint's limits keeps";
                return Err(file.unsupported(constraint.position.referenced, what, "widen its tolerances"));
            }
        }
        Ok(Arc::new(held))
    }

    /// Returns the shares of the velocity and acceleration limits that the request specifies; a factor of 0 means none.
    pub fn rate_scales(&self) -> Result<RateScales, ScenarioError> {
        let scale = |factor: Option<&Spanned<f64>>| match factor {
            Some(factor) if !(0.0..=1.0).contains(&factor.value) => {
                let hint = "give one from 0 to 1";
                let what = "a scaling factor outside 0 to 1";
                Err(self.request_file.unsupported(factor.referenced, what, hint))
            }
            Some(factor) => Ok(Some(factor.value).filter(|value| *value > 0.0)),
            None => Ok(None),
        };
        Ok(RateScales {
            velocity: scale(self.request.max_velocity_scaling_factor.as_ref())?,
            acceleration: scale(self.request.max_acceleration_scaling_factor.as_ref())?,
        })
    }

    /// Returns the start configuration (m, rad; one per joint).
    pub fn start(
        &self,
        robot: &Robot,
        state: &State,
        deviations: &mut Vec<MoveItDeviation>,
    ) -> Result<Vec<f64>, ScenarioError> {
        let start = &self.request.start_state.joint_state;
        let value = |joint: &String| match state.get(joint) {
            Some((value, _)) => Ok(*value),
            None => Err(ScenarioError::MissingJoint {
                at: start.as_ref().map_or_else(
                    || self.request_file.line(1),
                    |start| self.request_file.at(start.referenced),
                ),
                joint: joint.clone(),
            }),
        };
        let mut q: Vec<f64> = robot.joint_names().iter().map(value).collect::<Result<_, _>>()?;
        take_into_limits(robot, &mut q, None, deviations);
        Ok(q)
    }

    pub fn goal_constraints(&self) -> Result<&[Spanned<ConstraintsEntry>], ScenarioError> {
        match &self.request.goal_constraints {
            Some(goals) if !goals.value.is_empty() => Ok(&goals.value),
            _ => Err(MoveItError::NoGoal { path: self.request_file.path.clone() }.into()),
        }
    }

    /// Returns the joints that goals name, with their goal values (m, rad), one per constraint on the joint.
    pub fn goal_values(&self) -> Result<BTreeMap<&str, Vec<f64>>, ScenarioError> {
        let mut values: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
        for constraint in self.goal_constraints()?.iter().flat_map(|goal| &goal.value.joints) {
            values.entry(&constraint.joint_name.value).or_default().push(constraint.position.value);
        }
        Ok(values)
    }

    /// Returns the goal configurations (m, rad; one value per joint); continuous joints are turned towards the start. A goal may name joints that do not move freely if they
    /// have the given value.
    pub fn goals(
        &self,
        robot: &Robot,
        start: &[f64],
        deviations: &mut Vec<MoveItDeviation>,
    ) -> Result<Vec<Vec<f64>>, ScenarioError> {
        let file = &self.request_file;
        let mut goal = |entry: &Spanned<ConstraintsEntry>| {
            if entry.value.has_others() {
                let hint = "give the goal as joint constraints";
                return Err(file.unsupported(entry.referenced, "a goal that is no configuration", hint));
            }
            let mut q: Vec<Option<f64>> = vec![None; robot.dof()];
            let mut named = BTreeSet::new();
            let mut others = Vec::new();
            for constraint in &entry.value.joints {
                let (at, joint) = (file.at(constraint.joint_name.referenced), &constraint.joint_name.value);
                let value = file.finite(&constraint.position)?;
                if !named.insert(joint) {
                    return Err(MoveItError::JointTwice { at, joint: joint.clone() }.into());
                }
                if let Some(index) = robot.joint_names().iter().position(|name| name == joint) {
                    q[index] = Some(value);
                } else if robot.has_joint(joint) {
                    others.push((at, joint, value));
                } else {
                    let known = robot.joint_names().join(", ");
                    return Err(ScenarioError::UnknownJoint { at, joint: joint.clone(), known });
                }
            }
            let missing = |(value, joint): (Option<f64>, &String)| {
                let fault =
                    || MoveItError::GoalWithoutJoint { at: file.at(entry.referenced), joint: joint.clone() };
                value.ok_or_else(fault)
            };
            let mut q: Vec<f64> =
                q.into_iter().zip(robot.joint_names()).map(missing).collect::<Result<_, MoveItError>>()?;
            for (at, joint, asked) in others {
                let actual = robot.joint_value(joint, &q).unwrap_or(f64::NAN);
                if (asked - actual).abs() > ROUNDING {
                    return Err(MoveItError::GoalElsewhere { at, joint: joint.clone(), asked, actual }.into());
                }
            }
            take_into_limits(robot, &mut q, Some(start), deviations);
            Ok(q)
        };
        self.goal_constraints()?.iter().map(&mut goal).collect()
    }
}

/// Shifts continuous joints into their limits, and rounds values close to a limit to it.
fn take_into_limits(
    robot: &Robot,
    q: &mut [f64],
    start: Option<&[f64]>,
    deviations: &mut Vec<MoveItDeviation>,
) {
    let what = if start.is_some() { "goal" } else { "start" };
    let given = q.to_vec();
    robot.turn_into_limits(q);
    if let Some(start) = start {
        robot.wrap_towards(start, q);
    }
    for (index, joint) in robot.joint_names().iter().enumerate() {
        let (joint, requested) = (joint.clone(), given[index]);
        if (q[index] - requested).abs() > 0.0 {
            deviations.push(MoveItDeviation::Turned { what, joint, requested, taken: q[index] });
            continue;
        }
        let limit = robot.limits()[index].clamp(requested);
        let beyond = (limit - requested).abs();
        if beyond > 0.0 && beyond <= ROUNDING {
            q[index] = limit;
            deviations.push(MoveItDeviation::Rounded { what, joint, requested, limit });
        }
    }
}
