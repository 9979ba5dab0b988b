use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::chain::joint_group::{MIMIC_SLACK, admits, range, unknown_joint, unknown_link};
use crate::description::rate_limits::parse_yaml;
use crate::description::urdf_model::Urdf;
use crate::gripper::hand_description::line_of;
use crate::tree::Tree;
use crate::{
    HandDescription, JointConstraint, JointGroup, JointLimits, Location, RobotError, RobotOptions,
    ToolDescription,
};

/// Names of the files beside a URDF that [`Robot::load`](crate::Robot::load) reads.
pub(crate) const LIMITS: &str = "limits.yaml";
pub(crate) const DESCRIPTION: &str = "robot.yaml";

/// Description of a robot beyond its URDF, in a `robot.yaml` beside it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RobotDescription {
    /// Path of the URDF, relative to the folder of this file; it is opened if a path names the folder.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub urdf: Option<PathBuf>,
    /// Group of the SRDF whose joints move. Default: as of [`RobotOptions::group`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub group: Option<String>,
    /// Link for which grasp poses are planned. Default: that of the hand or tool, else as of [`RobotOptions::tip`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tip: Option<String>,
    /// Joints outside the group, and the values at which they are fixed (m, rad).
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub fixed: BTreeMap<String, f64>,
    /// Links whose meshes represent the solid they enclose instead of their convex hull: those that an object reaches into,
    /// such as a palm that is one link with a jaw. Planning is faster for the others.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub solid_meshes: Vec<String>,
    /// Start configuration if a scenario gives none (m, rad), by joint name; other joints are as near to 0 as possible.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub start: BTreeMap<String, f64>,
    /// Height of the ground below the robot in its root frame, in metres: a scene's floor is placed there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub floor_m: Option<f64>,
    /// Hand of the robot, if it has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hand: Option<HandDescription>,
    /// Tool of the robot, if it has one instead of a hand.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tool: Option<ToolDescription>,
    /// Location of `start`.
    #[serde(skip)]
    #[schemars(skip)]
    pub(crate) start_at: Option<Location>,
}

impl RobotDescription {
    /// Parses the text of a `robot.yaml`; `file` is its name in errors.
    ///
    /// # Errors
    /// [`RobotError::Yaml`] or [`RobotError::Empty`] for a malformed or empty text, [`RobotError::HandFigure`] for an
    /// invalid value, [`RobotError::HandAndTool`] for both.
    pub fn parse(text: &str, file: &str) -> Result<Self, RobotError> {
        let mut description: Self = parse_yaml(text, file)?;
        if !description.start.is_empty() {
            description.start_at = Some(line_of(text, file, "start"));
        }
        if let Some(hand) = &description.hand {
            hand.check(text, file)?;
        }
        if description.hand.is_some() && description.tool.is_some() {
            return Err(RobotError::HandAndTool { at: line_of(text, file, "tool") });
        }
        let numbers = description.start.iter().chain(&description.fixed);
        let mut numbers = numbers.map(|(joint, value)| (joint.as_str(), *value)).collect::<Vec<_>>();
        numbers.extend(description.floor_m.map(|height_m| ("floor_m", height_m)));
        if let Some(&(key, value)) = numbers.iter().find(|(_, value)| !value.is_finite()) {
            let (at, range) = (line_of(text, file, key), "a number".to_owned());
            let element = format!("`{key}`");
            return Err(RobotError::HandFigure { at, element, attribute: "the value", value, range });
        }
        Ok(description)
    }

    /// Returns the path of the URDF at `path`, or of the URDF named in the `robot.yaml` of the folder at `path`.
    ///
    /// # Errors
    /// [`RobotError::NoDescription`] for a folder without a `robot.yaml` that names a URDF; those of [`Self::parse`].
    pub(crate) fn urdf_at(path: &Path) -> Result<PathBuf, RobotError> {
        if !path.is_dir() {
            return Ok(path.to_owned());
        }
        let file = path.join(DESCRIPTION);
        let missing = || RobotError::NoDescription { folder: path.to_owned() };
        if !file.is_file() {
            return Err(missing());
        }
        let text = cranny_file::TEXT
            .text(&file)
            .map_err(|reason| RobotError::Unreadable { path: file.clone(), reason })?;
        let description = Self::parse(&text, &file.display().to_string())?;
        Ok(path.join(description.urdf.ok_or_else(missing)?))
    }

    /// Fills in the options that are not given.
    pub(crate) fn complete(&self, options: &mut RobotOptions) {
        if let (JointGroup::RootToTip, Some(group)) = (&options.group, &self.group) {
            options.group = JointGroup::Srdf(group.clone());
        }
        options.tip = options.tip.take().or_else(|| self.tip.clone());
        options.solid_meshes.extend_from_slice(&self.solid_meshes);
        for (joint, value) in &self.fixed {
            options.fixed.entry(joint.clone()).or_insert(*value);
        }
    }

    /// Checks that the robot has every joint and link named here, and that the values in `fixed` are admissible; `text` is the
    /// text of `file`.
    ///
    /// # Errors
    /// [`RobotError::UnknownName`], [`RobotError::NotFree`], [`RobotError::HeldOutsideLimits`], each with its line in `file`.
    pub(crate) fn check_names(
        &self,
        (text, file): (&str, &str),
        urdf: &Urdf,
        tree: &Tree,
    ) -> Result<(), RobotError> {
        let at = |section: &str, name: &str| line_within(text, file, section, name);
        let hand = self.hand.as_ref();
        let fingers = hand.into_iter().flat_map(|hand| hand.fingers.keys()).map(|name| ("fingers", name));
        let held = self.fixed.keys().map(|name| ("fixed", name));
        let started = self.start.keys().map(|name| ("start", name));
        for (section, name) in fingers.chain(held).chain(started) {
            if tree.joint(name).is_none() {
                let place = format!("{}: {section}", at(section, name));
                return Err(unknown_joint(urdf, place, name));
            }
        }
        let of_hand = hand.and_then(|hand| hand.tip.as_ref());
        let of_tool = self.tool.as_ref().and_then(|tool| tool.tip.as_ref());
        let tips = self.tip.iter().chain(of_hand).chain(of_tool).map(|name| ("tip", name));
        for (section, name) in tips.chain(self.solid_meshes.iter().map(|name| ("solid_meshes", name))) {
            if tree.node(name).is_none() {
                let place = format!("{}: {section}", at(section, name));
                return Err(unknown_link(urdf, place, name));
            }
        }
        for (finger, range) in hand.into_iter().flat_map(|hand| &hand.fingers) {
            let mimic =
                tree.joint(finger).and_then(|joint| urdf.joints[joint].motion.as_ref()?.mimic.as_ref());
            let Some(mimic) = mimic else { continue };
            let not_free = |constraint| {
                let (at, joint) = (at("fingers", finger), finger.clone());
                Err(RobotError::NotFree { at, joint, wanted: "moved as a finger", constraint })
            };
            let master = mimic.master.clone();
            let Some(of_master) = hand.and_then(|hand| hand.fingers.get(&master)) else {
                return not_free(JointConstraint::Mimic { master });
            };
            for (own, of_master) in [(range.open, of_master.open), (range.closed, of_master.closed)] {
                let value = of_master * mimic.multiplier + mimic.offset;
                if (own - value).abs() > MIMIC_SLACK {
                    return not_free(JointConstraint::MimicValue { master, value });
                }
            }
        }
        for (name, &value) in &self.fixed {
            let Some(index) = tree.joint(name) else { continue };
            // The search for the line passes the whole text.
            let located = || (at("fixed", name), name.clone());
            let finger = hand.and_then(|hand| hand.fingers.get(name));
            if let Some(open) =
                finger.map(|range| range.open).filter(|&open| (open - value).abs() > MIMIC_SLACK)
            {
                let ((at, joint), constraint) = (located(), JointConstraint::Finger { open });
                return Err(RobotError::NotFree { at, joint, wanted: "held at another value", constraint });
            }
            let Some(motion) = &urdf.joints[index].motion else {
                let ((at, joint), constraint) = (located(), JointConstraint::Fixed);
                return Err(RobotError::NotFree { at, joint, wanted: "held at a value", constraint });
            };
            let (lower, upper) = range(motion);
            if motion.mimic.is_none() && !admits(motion, value) {
                let (at, joint) = located();
                return Err(RobotError::HeldOutsideLimits { at, joint, value, lower, upper });
            }
        }
        Ok(())
    }

    /// Returns the start configuration for joints of these names and limits, with unnamed joints as near to 0 as possible;
    /// `None` if none of them has a start value.
    ///
    /// # Errors
    /// [`RobotError::NotFree`] for a joint outside the group, if `is_own_group`: a caller may choose other joints.
    pub(crate) fn start_of(
        &self,
        joints: &[String],
        limits: &[JointLimits],
        is_own_group: bool,
    ) -> Result<Option<Vec<f64>>, RobotError> {
        let other = self.start.keys().find(|name| !joints.contains(name)).filter(|_| is_own_group);
        if let Some((joint, at)) = other.zip(self.start_at.as_ref()) {
            let (at, joint) = (at.clone(), joint.clone());
            let (wanted, constraint) = ("in the start", JointConstraint::NotInGroup);
            return Err(RobotError::NotFree { at, joint, wanted, constraint });
        }
        let stated: Vec<_> = joints.iter().map(|joint| self.start.get(joint).copied()).collect();
        let at = |(stated, limits): (&Option<f64>, &JointLimits)| stated.unwrap_or_else(|| limits.clamp(0.0));
        Ok(stated.iter().any(Option::is_some).then(|| stated.iter().zip(limits).map(at).collect()))
    }
}

/// Returns the first line that contains `name`, from one on that begins with `section:`; line 1 if there is none.
fn line_within(text: &str, file: &str, section: &str, name: &str) -> Location {
    let lines: Vec<&str> = text.lines().collect();
    let depth = |line: &str| line.len() - line.trim_start().len();
    let begins =
        |line: &str| line.trim_start().strip_prefix(section).is_some_and(|rest| rest.starts_with(':'));
    // A section ends at a line with at most its own indentation, except for list items.
    let is_within = |first: usize, line: &str| {
        line.trim().is_empty() || depth(line) > depth(lines[first]) || line.trim_start().starts_with('-')
    };
    let named = |first: usize| {
        let end = (first + 1..lines.len()).find(|&next| !is_within(first, lines[next]));
        (first..end.unwrap_or(lines.len())).find(|&line| lines[line].contains(name))
    };
    let line = (0..lines.len()).filter(|&line| begins(lines[line])).find_map(named).unwrap_or(0);
    Location { file: file.to_owned(), line: u32::try_from(line + 1).unwrap_or(u32::MAX) }
}
