use std::fmt;
use std::path::PathBuf;

use cranny_shape::ShapeError;

use crate::hindrance::Hindrance;

/// Where in a text file something stands. Shown as `file:line`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Location {
    /// The file's path, or the name that the caller gave to a text.
    pub file: String,
    /// The line, counted from 1.
    pub line: u32,
}

impl fmt::Display for Location {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}:{}", self.file, self.line)
    }
}

/// Why a robot could not be built. The message is complete in itself: file and line where there is one, the
/// name concerned and, where a name is unknown, the nearest known ones.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RobotError {
    /// A file could not be read.
    #[error("{}: cannot be read: {reason}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        reason: std::io::Error,
    },
    /// A file is written for xacro, which makes a URDF of it.
    #[error(
        "{at}: this is a xacro file, not yet a URDF (expand it first: xacro {file} > {})",
        expanded(file)
    )]
    Xacro {
        /// Where xacro is first spoken of.
        at: Location,
        /// The file.
        file: String,
    },
    /// A file holds more of something than any robot has.
    #[error("{at}: {actual} {what}, but at most {most} are read; leave out what no motion needs")]
    TooMany {
        /// Location in the file.
        at: Location,
        /// What there is too much of.
        what: &'static str,
        /// The limit.
        most: usize,
        /// How many there are.
        actual: usize,
    },
    /// A file has no content.
    #[error("{file}: the file is empty")]
    Empty {
        /// The file.
        file: String,
    },
    /// A file is not well-formed XML.
    #[error("{at}: not well-formed XML: {reason}")]
    Xml {
        /// Where reading stopped.
        at: Location,
        /// What the XML reader says.
        reason: Box<roxmltree::Error>,
    },
    /// The outermost element is not `<robot>`.
    #[error("{at}: expected <robot> as the outermost element, found <{found}>")]
    NotARobot {
        /// Location in the file.
        at: Location,
        /// The element found.
        found: String,
    },
    /// A needed element is missing.
    #[error("{at}: {owner} has no <{element}>")]
    MissingElement {
        /// Where its owner stands.
        at: Location,
        /// What lacks it, with its name.
        owner: String,
        /// The missing element.
        element: &'static str,
    },
    /// A needed attribute is missing.
    #[error("{at}: <{element}> has no attribute `{attribute}`")]
    MissingAttribute {
        /// Location of the element in the file.
        at: Location,
        /// The element.
        element: String,
        /// The missing attribute.
        attribute: &'static str,
    },
    /// An attribute does not hold the numbers it should.
    #[error("{at}: {attribute}=\"{text}\" of <{element}>: expected {expected} finite number(s)")]
    NotNumbers {
        /// Location of the element in the file.
        at: Location,
        /// The element.
        element: String,
        /// The attribute.
        attribute: &'static str,
        /// How many numbers it should hold.
        expected: usize,
        /// What it holds.
        text: String,
    },
    /// A link can be farther from the root than anything may be.
    #[error(
        "{file}: link `{link}` can be {farthest_m:.1} m from the root, but no more than {most} m are allowed: is a length in \
         millimetres, or a limit too wide?", most = cranny_spatial::FARTHEST_M
    )]
    TooFar {
        /// The file.
        file: String,
        /// The link.
        link: String,
        /// How far a point of it can be, in metres.
        farthest_m: f64,
    },
    /// Rounding would move a link by more than a proof allows for.
    #[error(
        "{file}: link `{link}` cannot be placed to better than {error_m:.1e} m in double precision, which is more than proofs \
         allow for: its own joint goes up to {greatest:e}, and those before it add to that; narrow the limits or \
         shorten the chain"
    )]
    Unsteady {
        /// The file.
        file: String,
        /// The link.
        link: String,
        /// By how much rounding could move a point of it, in metres.
        error_m: f64,
        /// The greatest value of its own joint, either way (m, rad).
        greatest: f64,
    },
    /// A file holds something that no reader here understands where it could change geometry or motion.
    #[error(
        "{at}: {what} in {owner} is not understood, and may change where things are or how they move{}",
        known_there(known)
    )]
    NotUnderstood {
        /// Location in the file.
        at: Location,
        /// The element, attribute or text.
        what: String,
        /// The element that it is in.
        owner: String,
        /// Names that are understood there.
        known: Vec<String>,
    },
    /// A quaternion is not of length 1.
    #[error("{at}: `quat_xyzw` of {element} has the length {norm}, but that of a rotation is 1")]
    NoRotation {
        /// Location of the element in the file.
        at: Location,
        /// The element.
        element: String,
        /// Its length.
        norm: f64,
    },
    /// A quantity that must be greater than zero is not.
    #[error("{at}: {attribute} of {element} must be greater than 0, but is {value}")]
    NotPositive {
        /// Location of the element in the file.
        at: Location,
        /// The element or joint.
        element: String,
        /// The attribute.
        attribute: &'static str,
        /// Its value.
        value: f64,
    },
    /// A collision geometry of a kind that is not known.
    #[error(
        "{at}: link `{link}`: unknown geometry <{geometry}> (known: box, sphere, cylinder, capsule, mesh)"
    )]
    UnknownGeometry {
        /// Location in the file.
        at: Location,
        /// The link.
        link: String,
        /// The element found.
        geometry: String,
    },
    /// A joint type that is not supported.
    #[error(
        "{at}: joint `{joint}` is of type `{kind}`; supported: fixed, revolute, continuous, prismatic, planar, floating"
    )]
    UnsupportedJoint {
        /// Location of the joint in the file.
        at: Location,
        /// The joint.
        joint: String,
        /// Its type.
        kind: String,
    },
    /// A movable joint's axis has no direction.
    #[error("{at}: joint `{joint}` can move, but its axis is zero")]
    ZeroAxis {
        /// Where the axis stands.
        at: Location,
        /// The joint.
        joint: String,
    },
    /// A joint's lower limit lies above its upper one.
    #[error("{at}: joint `{joint}`: lower limit {lower} is greater than upper limit {upper}")]
    LimitsReversed {
        /// Where the limits stand.
        at: Location,
        /// The joint.
        joint: String,
        /// The lower limit, in metres or radians.
        lower: f64,
        /// The upper limit, in metres or radians.
        upper: f64,
    },
    /// A joint and the one that it mimics cannot both keep their limits while they move.
    #[error(
        "{at}: joint `{joint}` mimics `{master}`, but there is no range in which both keep their limits (change the limits of \
         one, or multiplier and offset of <mimic>)"
    )]
    CoupledLimits {
        /// Location of the joint in the file.
        at: Location,
        /// The joint that mimics.
        joint: String,
        /// The joint of the group that moves it.
        master: String,
    },
    /// A joint of the group has no velocity limit.
    #[error(
        "{at}: joint `{joint}` is to be moved, but has no velocity limit (give it one in limits.yaml beside the URDF, \
         or let `cranny robot add` write one)"
    )]
    MissingVelocity {
        /// Location of the joint in the file.
        at: Location,
        /// The joint.
        joint: String,
    },
    /// Two links or two joints bear one name.
    #[error("{at}: {kind} `{name}` is defined twice, first in line {first_line}")]
    DefinedTwice {
        /// Where the second stands.
        at: Location,
        /// `link`, `joint` or `group`.
        kind: &'static str,
        /// The name.
        name: String,
        /// The line of the first.
        first_line: u32,
    },
    /// A link is the child of two joints.
    #[error("{at}: link `{link}` has two parents, through joints `{first}` and `{second}`")]
    TwoParents {
        /// Where the second joint stands.
        at: Location,
        /// The link.
        link: String,
        /// The first joint.
        first: String,
        /// The second joint.
        second: String,
    },
    /// The links do not form a tree: some lead back to themselves.
    #[error("{at}: the joints {} form a loop", quoted(joints))]
    Loop {
        /// Where the first joint of the loop stands.
        at: Location,
        /// The joints, in order.
        joints: Vec<String>,
    },
    /// More than one link has no parent.
    #[error("{at}: {} have no parent joint; a robot has one root link", quoted(links))]
    ManyRoots {
        /// Where the second root stands.
        at: Location,
        /// The root links.
        links: Vec<String>,
    },
    /// There is no link at all.
    #[error("{file}: the robot has no link")]
    NoLinks {
        /// The file.
        file: String,
    },
    /// A mimic joint follows itself, directly or through others.
    #[error("{at}: joint `{joint}` mimics itself")]
    MimicLoop {
        /// Location of the joint in the file.
        at: Location,
        /// The joint.
        joint: String,
    },
    /// A name that the robot does not have.
    #[error("{place}: unknown {kind} `{name}`{}", meant(nearest))]
    UnknownName {
        /// The file with its line, or the option of the caller.
        place: String,
        /// `joint`, `link`, `group`, ….
        kind: &'static str,
        /// The name.
        name: String,
        /// Known names like it, nearest first.
        nearest: Vec<String>,
    },
    /// A group of an SRDF contains itself.
    #[error("{at}: group `{group}` contains itself")]
    GroupLoop {
        /// Where the group stands.
        at: Location,
        /// The group.
        group: String,
    },
    /// A chain of an SRDF does not lead from its base to its tip.
    #[error("{at}: link `{tip}` does not descend from link `{base}`")]
    BrokenChain {
        /// Where the chain stands.
        at: Location,
        /// The base link.
        base: String,
        /// The tip link.
        tip: String,
    },
    /// The joint group has no joint.
    #[error("{file}: no joint to move: the group is empty")]
    EmptyGroup {
        /// The file.
        file: String,
    },
    /// A joint stands twice in the group.
    #[error("joint group: joint `{joint}` is named twice")]
    NamedTwice {
        /// The joint.
        joint: String,
    },
    /// A joint that is to be moved or held cannot move by itself.
    #[error("{at}: joint `{joint}` cannot be {wanted}: {hindrance}")]
    NotFree {
        /// Location of the joint in the file.
        at: Location,
        /// The joint.
        joint: String,
        /// `moved` or `held at a value`.
        wanted: &'static str,
        /// What hinders it.
        hindrance: Hindrance,
    },
    /// An SRDF holds something that is not known.
    #[error("{at}: unknown {kind} `{name}` in an SRDF (known here: {known})")]
    UnknownInSrdf {
        /// Location in the file.
        at: Location,
        /// `element`, `attribute`, …
        kind: &'static str,
        /// Its name.
        name: String,
        /// The names that are known.
        known: String,
    },
    /// A joint is to be held at a value outside its limits.
    #[error("{at}: joint `{joint}` cannot be held at {value}: its limits are {lower} to {upper}")]
    HeldOutsideLimits {
        /// Location of the joint in the file.
        at: Location,
        /// The joint.
        joint: String,
        /// The value asked for, in metres or radians.
        value: f64,
        /// The lower limit.
        lower: f64,
        /// The upper limit.
        upper: f64,
    },
    /// A mesh file is not where the robot's file says.
    #[error(
        "{at}: link `{link}`: mesh `{mesh}` not found; tried {}{}", listed(tried),
        if mesh.starts_with("package://") { " (--package FOLDER names the folder that holds the package)" } else { "" }
    )]
    MeshNotFound {
        /// Where the mesh is named.
        at: Location,
        /// The link.
        link: String,
        /// The name as written.
        mesh: String,
        /// The files that were looked for.
        tried: Vec<PathBuf>,
    },
    /// A collision geometry is not a usable solid.
    #[error("{at}: link `{link}`: {reason}")]
    Shape {
        /// Where the geometry stands.
        at: Location,
        /// The link.
        link: String,
        /// What is wrong with it.
        reason: Box<ShapeError>,
    },
    /// A figure of a `robot.yaml` or `limits.yaml` cannot be.
    #[error("{at}: {attribute} of {element} is {value}, but must be {range}")]
    HandFigure {
        /// Location in the file.
        at: Location,
        /// The hand or finger.
        element: String,
        /// Which figure.
        attribute: &'static str,
        /// Its value.
        value: f64,
        /// What would fit.
        range: String,
    },
    /// A robot of which no hand is known.
    #[error(
        "robot {robot}: nothing says which joints close its hand, so no grasp can be sampled for it (`cranny robot add \
         URDF` finds the hand and writes it to a robot.yaml)"
    )]
    NoHand {
        /// Its name.
        robot: String,
    },
    /// A folder is no robot's.
    #[error(
        "{}: a robot's folder has a robot.yaml that names its URDF (`urdf: NAME.urdf`); `cranny robot add URDF` makes \
         one", folder.display()
    )]
    NoDescription {
        /// The folder.
        folder: PathBuf,
    },
    /// A `limits.yaml` or `robot.yaml` is malformed.
    #[error("{at}: {reason}")]
    Yaml {
        /// Location in the file.
        at: Location,
        /// What is wrong with it.
        reason: cranny_file::TextFault,
    },
}

fn quoted(names: &[String]) -> String {
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

fn known_there(known: &[String]) -> String {
    if known.is_empty() { String::new() } else { format!(" (known there: {})", known.join(", ")) }
}

fn meant(nearest: &[String]) -> String {
    if nearest.is_empty() { String::new() } else { format!("; did you mean {}?", quoted(nearest)) }
}

fn listed(paths: &[PathBuf]) -> String {
    if paths.is_empty() {
        return "nothing (the robot was given as a text without a folder)".to_owned();
    }
    paths.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(", ")
}

/// What the URDF of a xacro file is called.
fn expanded(file: &str) -> String {
    match file.strip_suffix(".urdf.xacro").or_else(|| file.strip_suffix(".xacro")) {
        Some(stem) => format!("{stem}.urdf"),
        None => format!("{}.expanded.urdf", file.strip_suffix(".urdf").unwrap_or(file)),
    }
}
