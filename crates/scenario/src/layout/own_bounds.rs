//! Start, and bounds of tool, joints and speeds, in a `scenario.yaml`.

use std::collections::HashSet;
use std::sync::Arc;

use cranny_collision::{CollisionError, ToolBound, ToolRegion, World};
use cranny_robot::{Location, Robot};
use cranny_spatial::{Point, Pose, Vector};
use cranny_task::Mode;
use serde_saphyr::Spanned;

use crate::files::yaml;
use crate::layout::own::Layout;
use crate::layout::own_file::{ScenarioFile, SpeedEntry, StartEntry, ToolBoundEntry};
use crate::stated_speed::{ALL, StatedSpeed};
use crate::{OpenOptions, ScenarioError};

impl Layout<'_> {
    /// Returns the start of a scenario (m, rad): one value per joint if the file names the joints, otherwise as many as it lists.
    /// Without one, and for another robot than the scenario's own unless its joints are named, it is that of the robot's files.
    pub fn start(
        &self,
        file: &ScenarioFile,
        robot: &Robot,
        options: &OpenOptions,
    ) -> Result<Vec<f64>, ScenarioError> {
        let own = robot.default_start().map(<[f64]>::to_vec);
        let stated = file.start.as_ref().map(|start| self.stated_start(start, robot));
        let is_named = matches!(file.start.as_ref().map(|start| &start.value), Some(StartEntry::ByJoint(_)));
        match (stated, own) {
            (Some(stated), own) if options.robot.is_some() => match (own, stated) {
                (Some(_), Ok(stated)) if is_named => Ok(stated),
                (Some(own), _) => Ok(own),
                (None, stated) => stated,
            },
            (Some(stated), _) => stated,
            (None, Some(own)) => Ok(own),
            (None, None) => Err(ScenarioError::NoStart { at: self.at(file.robot.referenced) }),
        }
    }

    fn stated_start(&self, start: &Spanned<StartEntry>, robot: &Robot) -> Result<Vec<f64>, ScenarioError> {
        let number = |value: &Spanned<f64>| yaml::finite(self.path, value.value, value.referenced);
        let by_joint = match &start.value {
            StartEntry::List(list) => return list.iter().map(number).collect(),
            StartEntry::ByJoint(by_joint) => by_joint,
        };
        let joints = robot.joint_names();
        if let Some((joint, value)) = by_joint.iter().find(|(joint, _)| !joints.contains(joint)) {
            return Err(ScenarioError::UnknownJoint {
                at: self.at(value.referenced),
                joint: joint.clone(),
                known: joints.join(", "),
            });
        }
        let value_of = |joint: &String| match by_joint.iter().find(|(name, _)| name == joint) {
            Some((_, value)) => number(value),
            None => Err(ScenarioError::MissingJoint { at: self.at(start.referenced), joint: joint.clone() }),
        };
        joints.iter().map(value_of).collect()
    }

    /// Returns the maximum tilt of a held object, in radians.
    pub fn upright(&self, entry: &Spanned<f64>) -> Result<f64, ScenarioError> {
        let degrees = yaml::positive(self.path, "upright_deg", entry.value, entry.referenced)?;
        if degrees > 180.0 {
            return Err(ScenarioError::UprightRange { at: self.at(entry.referenced), degrees });
        }
        Ok(degrees.to_radians())
    }

    /// Returns the world with the tool bounds of a file.
    pub fn with_tool_bounds(
        &self,
        (world, robot): (World, &Robot),
        file: &ScenarioFile,
        planning_from_scene: &Pose,
    ) -> Result<World, ScenarioError> {
        let mut names = HashSet::new();
        let bounds = file.tool_bounds.iter().map(|entry| {
            Ok::<_, ScenarioError>(self.tool_bound(entry, robot, &mut names)?.in_frame(planning_from_scene))
        });
        let bounds = bounds.collect::<Result<_, _>>()?;
        Ok(world.with_tool_bounds(bounds)?)
    }

    /// Returns a tool bound in the scene, with a name that is not in `taken`.
    pub fn tool_bound<'b>(
        &self,
        entry: &'b Spanned<ToolBoundEntry>,
        robot: &Robot,
        taken: &mut HashSet<&'b str>,
    ) -> Result<ToolBound, ScenarioError> {
        let name = &entry.value.name;
        if !taken.insert(&name.value) {
            let at = self.at(name.referenced);
            return Err(ScenarioError::NameTaken { at, name: name.value.clone() });
        }
        if let Some(link) = &entry.value.link {
            let problem = match robot.link_index(&link.value) {
                None => format!("the robot has no link '{}'", link.value),
                Some(index) if robot.is_of_finger(index) => {
                    format!(
                        "link '{}' is a finger, which the hand moves by itself; bound the palm",
                        link.value
                    )
                }
                Some(_) => String::new(),
            };
            if !problem.is_empty() {
                return Err(ScenarioError::Bound { at: self.at(link.referenced), problem });
            }
        }
        let link = entry.value.link.as_ref().map(|link| link.value.clone());
        let bound = ToolBound { name: name.value.clone(), link, region: self.region(entry)? };
        let refuse = |fault: CollisionError| ScenarioError::Bound {
            at: self.at(entry.referenced),
            problem: fault.to_string(),
        };
        bound.check().map_err(refuse)?;
        Ok(bound)
    }

    /// Returns the region of a bound, in the scene.
    fn region(&self, entry: &Spanned<ToolBoundEntry>) -> Result<ToolRegion, ScenarioError> {
        let ToolBoundEntry { point, pose, size, radius, axis, toward, within_deg, .. } = &entry.value;
        let refuse = |problem: &str| {
            Err(ScenarioError::Bound { at: self.at(entry.referenced), problem: problem.to_owned() })
        };
        let scene_from_middle = self.pose(pose.as_ref())?;
        let point_in_link = Point::from(point.unwrap_or_default());
        let unit = |direction: &[f64; 3]| Vector::from(*direction).try_normalize(1e-6).unwrap_or_default();
        match (size, radius, (axis, toward, within_deg)) {
            (Some(size), None, (None, None, None)) => Ok(ToolRegion::Box {
                point_in_link,
                world_from_box: scene_from_middle,
                half_m: Vector::from(*size) * 0.5,
            }),
            (None, Some(radius), (None, None, None)) => Ok(ToolRegion::Ball {
                point_in_link,
                center: scene_from_middle * Point::origin(),
                radius_m: *radius,
            }),
            (None, None, (Some(axis), Some(toward), Some(degrees))) => {
                if point.is_some() || pose.is_some() {
                    return refuse("a bound on a direction has neither `point` nor `pose`");
                }
                Ok(ToolRegion::Cone {
                    axis_in_link: unit(axis),
                    toward: unit(toward),
                    most_rad: degrees.to_radians(),
                })
            }
            _ => refuse(
                "a bound on the tool has either the `size` of a box, the `radius` of a ball, or `axis`, `toward` and \
                 `within_deg`",
            ),
        }
    }

    /// Returns the speeds of a file; the entry for all motions comes first.
    pub fn speeds(&self, file: &ScenarioFile) -> Result<Vec<StatedSpeed>, ScenarioError> {
        let speed = |(key, entry): (&String, &Spanned<SpeedEntry>)| {
            let refuse = |problem| ScenarioError::Bound { at: self.at(entry.referenced), problem };
            let mode = if key == ALL { None } else { Some(Mode::of_name(key).map_err(refuse)?) };
            let SpeedEntry { speed, acceleration, tool_speed_m_s, turn_speed_deg_s } = entry.value;
            let (tool_m_s, turn_deg_s) = (tool_speed_m_s, turn_speed_deg_s);
            let stated = StatedSpeed { mode, velocity: speed, acceleration, tool_m_s, turn_deg_s };
            match stated.fault() {
                Some((value, values)) => {
                    Err(refuse(format!("'{value}' is not a valid limit: expected a number {values}")))
                }
                None => Ok(stated),
            }
        };
        let mut speeds = file.speeds.iter().map(speed).collect::<Result<Vec<_>, _>>()?;
        speeds.sort_by_key(|speed| speed.mode.is_some());
        Ok(speeds)
    }

    /// Returns the robot with the joint bounds of a file.
    pub fn with_bounded_joints(
        &self,
        robot: Arc<Robot>,
        file: &ScenarioFile,
    ) -> Result<Arc<Robot>, ScenarioError> {
        let mut places = Vec::new();
        for between in file.joint_bounds.values() {
            for value in between.value {
                yaml::finite(self.path, value, between.referenced)?;
            }
            places.push(self.at(between.referenced));
        }
        let bounds = file.joint_bounds.iter().zip(&places);
        bounded(robot, bounds.map(|((joint, between), at)| (joint, between.value, at)))
    }
}

/// Returns the robot with joints that stay between two values (m, rad) each, in addition to their limits; errors report the
/// location of a bound.
pub(crate) fn bounded<'a>(
    robot: Arc<Robot>,
    bounds: impl Iterator<Item = (&'a String, [f64; 2], &'a Location)>,
) -> Result<Arc<Robot>, ScenarioError> {
    bounds.into_iter().try_fold(robot, |robot, (joint, [lower, upper], at)| {
        let Some(index) = robot.joint_names().iter().position(|name| name == joint) else {
            let known = robot.joint_names().join(", ");
            return Err(ScenarioError::UnknownJoint { at: at.clone(), joint: joint.clone(), known });
        };
        let limits = robot.limits()[index];
        if lower > upper || lower > limits.upper || upper < limits.lower {
            let problem = format!(
                "no value of {joint} lies in [{lower}, {upper}] and within its limits [{}, {}]; give the lower value first",
                limits.lower, limits.upper
            );
            return Err(ScenarioError::Bound { at: at.clone(), problem });
        }
        Ok(Arc::new(Arc::unwrap_or_clone(robot).with_joint_between(index, lower, upper)))
    })
}
