//! `CrannyRobot`: links, joints and limits.

use std::collections::BTreeMap;
use std::ffi::{CString, c_char};
use std::mem::MaybeUninit;
use std::path::{Path, PathBuf};
use std::ptr::null;
use std::sync::Arc;

use cranny::Robot;
use cranny::robot::{JointGroup, JointLimits, MeshUse, RobotOptions, TextSource};
use cranny::scenario::{BUILTIN_ROBOTS, BuiltinRobot};
use serde::Deserialize;

use crate::boundary::{NumberBuffer, Text, answered, given, guarded, put};
use crate::error::{CrannyStatus, Fault};
use crate::options::{parsed, refused};
use crate::text::{c_text, c_texts};

/// Robot: links, and the group of joints that moves them. It never changes.
///
/// A configuration q has one value for each joint of the group, in the order of cranny_robot_joint_name: metres for a prismatic
/// joint, radians for a revolute one. The robot's root frame is the planning frame, in which all poses are given.
#[derive(Debug)]
pub struct CrannyRobot {
    pub robot: Arc<Robot>,
    name: CString,
    joints: Vec<CString>,
    links: Vec<CString>,
}

impl CrannyRobot {
    /// Wraps a robot.
    pub fn of(robot: Arc<Robot>) -> Box<Self> {
        let name = c_text(robot.name());
        let joints = c_texts(robot.joint_names().iter().map(String::as_str));
        let links = c_texts(robot.links().iter().map(|link| link.name.as_str()));
        Box::new(Self { robot, name, joints, links })
    }

    /// Returns the index of the link of that name, or of the tip for NULL.
    pub fn link(&self, name: Text<'_>) -> Result<usize, Fault> {
        let Some(name) = name.optional("link")? else { return Ok(self.robot.tip()) };
        self.robot.link_index(name).ok_or_else(|| {
            let known = self.robot.links().iter().map(|link| link.name.as_str()).collect::<Vec<_>>();
            Fault::Unknown { what: "link", name: name.to_owned(), known: known.join(", ") }
        })
    }

    /// Checks that `dof` is the number of joints.
    pub fn check_dof(&self, dof: usize) -> Result<(), Fault> {
        check_dof(&self.robot, dof)
    }
}

/// Checks that `dof` is the number of joints of a robot.
pub fn check_dof(robot: &Robot, dof: usize) -> Result<(), Fault> {
    let expected = robot.dof();
    let reason = "the number of joints of the robot";
    if dof == expected { Ok(()) } else { Err(Fault::Length { what: "dof", expected, actual: dof, reason }) }
}

/// Options of a robot, in the words of Python's `Robot.from_urdf`.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Options {
    srdf: Option<PathBuf>,
    tip: Option<String>,
    joints: Option<Vec<String>>,
    group: Option<String>,
    fixed: BTreeMap<String, f64>,
    packages: Vec<PathBuf>,
    meshes: Option<String>,
    unchecked_pairs: Vec<[String; 2]>,
}

impl Options {
    fn robot_options(self) -> Result<RobotOptions, Fault> {
        let group = match (self.joints, self.group) {
            (Some(_), Some(_)) => return Err(refused("give `joints` or `group`, not both")),
            (Some(joints), None) => JointGroup::Joints(joints),
            (None, Some(group)) => JointGroup::Srdf(group),
            (None, None) => JointGroup::RootToTip,
        };
        let meshes = match self.meshes.as_deref() {
            None | Some("hull") => MeshUse::Hull,
            Some("solid") => MeshUse::Solid,
            Some(other) => {
                return Err(refused(format!("`meshes` is '{other}', but 'hull' or 'solid' is expected")));
            }
        };
        Ok(RobotOptions {
            srdf: self.srdf.map(TextSource::Path),
            group,
            tip: self.tip,
            fixed: self.fixed,
            packages: self.packages,
            meshes,
            unchecked_pairs: self.unchecked_pairs,
            ..RobotOptions::default()
        })
    }
}

/// Returns a built-in robot: "panda_mobile", "ur5e", "ur5e_mobile", "fr3" or "fetch_like". The caller frees it with
/// cranny_robot_free.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_robot_builtin(
    name: Text<'_>,
    robot: Option<&mut MaybeUninit<Option<Box<CrannyRobot>>>>,
) -> CrannyStatus {
    guarded(|| {
        let name = name.read("name")?;
        let found = BuiltinRobot::of_name(name).ok_or_else(|| {
            let known = BUILTIN_ROBOTS.iter().map(|robot| robot.name).collect::<Vec<_>>().join(", ");
            Fault::Unknown { what: "built-in robot", name: name.to_owned(), known }
        })?;
        put(robot, "robot", Some(CrannyRobot::of(found.robot(&RobotOptions::default())?)))
    })
}

/// Reads the URDF file or the robot folder at `path`, with the SRDF, the limits.yaml and the robot.yaml beside the URDF. The
/// caller frees the robot with cranny_robot_free.
///
/// `options`: NULL, or a JSON object with any of "srdf" (another file), "tip" (the link whose frame reaches the grasps),
/// "joints" (names of the joints of q, in order) or "group" (a group of the SRDF), "fixed" (values of other joints by name, m or
/// rad), "packages" (folders to search for package:// names), "meshes" ("hull" or "solid"), "unchecked_pairs" (pairs of links
/// that may touch).
#[unsafe(no_mangle)]
pub extern "C" fn cranny_robot_from_urdf(
    path: Text<'_>,
    options: Text<'_>,
    robot: Option<&mut MaybeUninit<Option<Box<CrannyRobot>>>>,
) -> CrannyStatus {
    guarded(|| {
        let path = path.read("path")?;
        let options = parsed::<Options>(options)?.robot_options()?;
        put(robot, "robot", Some(CrannyRobot::of(Arc::new(Robot::load(Path::new(path), &options)?))))
    })
}

/// Reads a robot from the text of a URDF without meshes. Options and ownership as in cranny_robot_from_urdf.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_robot_from_urdf_text(
    text: Text<'_>,
    options: Text<'_>,
    robot: Option<&mut MaybeUninit<Option<Box<CrannyRobot>>>>,
) -> CrannyStatus {
    guarded(|| {
        let text = text.read("text")?;
        let options = parsed::<Options>(options)?.robot_options()?;
        let read = Robot::from_urdf_text(text, "<text>", None, &options)?;
        put(robot, "robot", Some(CrannyRobot::of(Arc::new(read))))
    })
}

/// Frees a robot. NULL is ignored. Cells and scenarios of the robot stay valid.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_robot_free(robot: Option<Box<CrannyRobot>>) {
    drop(robot);
}

/// Returns the robot's name in the URDF, valid as long as the robot; NULL for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_robot_name(robot: Option<&CrannyRobot>) -> *const c_char {
    answered(null(), || Ok(given(robot, "robot")?.name.as_ptr()))
}

/// Returns the number of joints, the length of each configuration; 0 for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_robot_dof(robot: Option<&CrannyRobot>) -> usize {
    answered(0, || Ok(given(robot, "robot")?.robot.dof()))
}

/// Returns the name of a joint, 0 <= `joint` < dof, valid as long as the robot; NULL for another.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_robot_joint_name(robot: Option<&CrannyRobot>, joint: usize) -> *const c_char {
    answered(null(), || named(&given(robot, "robot")?.joints, "joint", joint))
}

/// Returns the number of links; 0 for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_robot_link_count(robot: Option<&CrannyRobot>) -> usize {
    answered(0, || Ok(given(robot, "robot")?.links.len()))
}

/// Returns the name of a link, the root first, valid as long as the robot; NULL for an index that is too large.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_robot_link_name(robot: Option<&CrannyRobot>, link: usize) -> *const c_char {
    answered(null(), || named(&given(robot, "robot")?.links, "link", link))
}

/// Returns the name of the link whose frame is the gripper frame, which reaches the grasps, valid as long as the robot.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_robot_tip(robot: Option<&CrannyRobot>) -> *const c_char {
    answered(null(), || {
        let robot = given(robot, "robot")?;
        named(&robot.links, "link", robot.robot.tip())
    })
}

/// Writes the limits of the joints, `dof` values each, in m or rad, m/s or rad/s, m/s² or rad/s². Any of the arrays may be
/// NULL. An acceleration that the robot's files do not state is NaN.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_robot_limits(
    robot: Option<&CrannyRobot>,
    dof: usize,
    mut lower: NumberBuffer<'_>,
    mut upper: NumberBuffer<'_>,
    mut velocity: NumberBuffer<'_>,
    mut acceleration: NumberBuffer<'_>,
) -> CrannyStatus {
    guarded(|| {
        let robot = given(robot, "robot")?;
        robot.check_dof(dof)?;
        let each =
            |value: fn(&JointLimits) -> f64| robot.robot.limits().iter().map(value).collect::<Vec<f64>>();
        lower.write_if_asked("lower", &each(|limits| limits.lower))?;
        upper.write_if_asked("upper", &each(|limits| limits.upper))?;
        velocity.write_if_asked("velocity", &each(|limits| limits.velocity))?;
        acceleration.write_if_asked("acceleration", &each(|limits| limits.acceleration.unwrap_or(f64::NAN)))
    })
}

/// Writes the start configuration of the robot's files, `dof` values. A robot without one is an error.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_robot_start(
    robot: Option<&CrannyRobot>,
    mut q: NumberBuffer<'_>,
    dof: usize,
) -> CrannyStatus {
    guarded(|| {
        let robot = given(robot, "robot")?;
        robot.check_dof(dof)?;
        let problem = "it has no default start (a robot.yaml beside its URDF gives one)";
        q.write("q", robot.robot.default_start().ok_or(Fault::Lacking { what: "robot", problem })?)
    })
}

/// Returns the name at an index.
pub fn named(names: &[CString], what: &'static str, index: usize) -> Result<*const c_char, Fault> {
    let found = names.get(index).map(|name| name.as_ptr());
    found.ok_or(Fault::Index { what, index, count: names.len() })
}
