use std::path::PathBuf;

use cranny_shape::ShapeError;

use crate::joint_constraint::JointConstraint;
use crate::location::Location;

/// Reason why a robot could not be built. The message contains file and line if there is one, the name concerned and, for an
/// unknown name, the nearest known ones.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RobotError {
    /// A file could not be read.
    #[error("{}: cannot be read: {reason}", path.display())]
    Unreadable {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        reason: std::io::Error,
    },
    /// A file is in the xacro language and must be expanded to a URDF first.
    #[error(
        "{at}: this is a xacro file, not yet a URDF (expand it first: xacro {file} > {})",
        expanded(file)
    )]
    Xacro {
        /// Location of the first mention of xacro.
        at: Location,
        /// The file.
        file: String,
    },
    /// A file contains more of something than any robot has.
    #[error("{at}: {actual} {what}, but at most {most} are read; leave out what no motion needs")]
    TooMany {
        /// Location in the file.
        at: Location,
        /// Kind of content that exceeds the limit.
        what: &'static str,
        /// Maximum number.
        most: usize,
        /// Actual number.
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
        /// Location at which parsing stopped.
        at: Location,
        /// Error of the XML parser.
        reason: Box<roxmltree::Error>,
    },
    /// Content of a model is known, but not supported.
    #[error("{at}: {what} is not supported: {hint}")]
    NotSupported {
        /// Location in the file.
        at: Location,
        /// The content.
        what: String,
        /// Advice.
        hint: &'static str,
    },
    /// The outermost element is not `<robot>`.
    #[error("{at}: expected <robot> as the outermost element, found <{found}>")]
    NotARobot {
        /// Location in the file.
        at: Location,
        /// The element found.
        found: String,
    },
    /// A required element is missing.
    #[error("{at}: {owner} has no <{element}>")]
    MissingElement {
        /// Location of the owner in the file.
        at: Location,
        /// Element that lacks it, with its name.
        owner: String,
        /// The missing element.
        element: &'static str,
    },
    /// A required attribute is missing.
    #[error("{at}: <{element}> has no attribute `{attribute}`")]
    MissingAttribute {
        /// Location of the element in the file.
        at: Location,
        /// The element.
        element: String,
        /// The missing attribute.
        attribute: &'static str,
    },
    /// An attribute does not contain the expected numbers.
    #[error("{at}: {attribute}=\"{text}\" of <{element}>: expected {expected} finite number(s)")]
    NotNumbers {
        /// Location of the element in the file.
        at: Location,
        /// The element.
        element: String,
        /// The attribute.
        attribute: &'static str,
        /// Expected count of numbers.
        expected: usize,
        /// Actual content.
        text: String,
    },
    /// A link can be farther from the root than allowed.
    #[error(
        "{file}: link `{link}` can be {farthest_m:.1} m from the root, but no more than {most} m are allowed: is a length in \
         millimetres, or a limit too wide?", most = cranny_spatial::FARTHEST_M
    )]
    TooFar {
        /// The file.
        file: String,
        /// The link.
        link: String,
        /// Maximum distance of a point of it from the root, in metres.
        farthest_m: f64,
    },
    /// Rounding displaces a link by more than proofs allow for.
    #[error(
        "{file}: the position of link `{link}` is uncertain by {error_m:.1e} m in double precision, more \
         than proofs allow: its own joint goes up to {greatest:e}, and the joints before it add to that; \
         narrow the limits or shorten the chain"
    )]
    Unsteady {
        /// The file.
        file: String,
        /// The link.
        link: String,
        /// Bound on the displacement of a point of it by rounding, in metres.
        error_m: f64,
        /// Maximum absolute value of its own joint (m, rad).
        greatest: f64,
    },
    /// A file contains something that is not understood and could affect geometry or motion.
    #[error(
        "{at}: {what} in {owner} is not understood, and may change where things are or how they move{}",
        known_there(known)
    )]
    NotUnderstood {
        /// Location in the file.
        at: Location,
        /// The element, attribute or text.
        what: String,
        /// Element that contains it.
        owner: String,
        /// Names that are understood there.
        known: Vec<String>,
    },
    /// The norm of a quaternion is not 1.
    #[error("{at}: `quat_xyzw` of {element} has the length {norm}, but that of a rotation is 1")]
    NoRotation {
        /// Location of the element in the file.
        at: Location,
        /// The element.
        element: String,
        /// Norm of the quaternion.
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
        /// Value of the attribute.
        value: f64,
    },
    /// A collision geometry is of an unknown kind.
    #[error(
        "{at}: link `{link}`: unknown geometry <{geometry}> (known: box, sphere, cylinder, capsule, mesh, hull)"
    )]
    UnknownGeometry {
        /// Location in the file.
        at: Location,
        /// The link.
        link: String,
        /// The element found.
        geometry: String,
    },
    /// A joint type is not supported.
    #[error(
        "{at}: joint `{joint}` is of type `{kind}`; supported: fixed, revolute, continuous, prismatic, planar, floating"
    )]
    UnsupportedJoint {
        /// Location of the joint in the file.
        at: Location,
        /// The joint.
        joint: String,
        /// Type of the joint.
        kind: String,
    },
    /// The axis of a movable joint has no direction.
    #[error("{at}: joint `{joint}` can move, but its axis is zero")]
    ZeroAxis {
        /// Location of the axis in the file.
        at: Location,
        /// The joint.
        joint: String,
    },
    /// The lower limit of a joint is greater than its upper one.
    #[error("{at}: joint `{joint}`: lower limit {lower} is greater than upper limit {upper}")]
    LimitsReversed {
        /// Location of the limits in the file.
        at: Location,
        /// The joint.
        joint: String,
        /// The lower limit, in metres or radians.
        lower: f64,
        /// The upper limit, in metres or radians.
        upper: f64,
    },
    /// A joint and the one that it mimics cannot both stay within their limits while they move.
    #[error(
        "{at}: joint `{joint}` mimics `{master}`, but there is no range in which both keep their limits (change the limits of \
         one, or multiplier and offset of <mimic>)"
    )]
    CoupledLimits {
        /// Location of the joint in the file.
        at: Location,
        /// The joint that mimics.
        joint: String,
        /// Joint of the group that moves it.
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
    /// Two links, joints or groups have the same name.
    #[error("{at}: {kind} `{name}` is defined twice, first in line {first_line}")]
    DefinedTwice {
        /// Location of the second definition.
        at: Location,
        /// `link`, `joint` or `group`.
        kind: &'static str,
        /// The name.
        name: String,
        /// Line of the first definition.
        first_line: u32,
    },
    /// A link is the child of two joints.
    #[error("{at}: link `{link}` has two parents, through joints `{first}` and `{second}`")]
    TwoParents {
        /// Location of the second joint in the file.
        at: Location,
        /// The link.
        link: String,
        /// The first joint.
        first: String,
        /// The second joint.
        second: String,
    },
    /// The links do not form a tree, as some joints form a loop.
    #[error("{at}: the joints {} form a loop", quoted(joints))]
    Loop {
        /// Location of the first joint of the loop.
        at: Location,
        /// Joints of the loop, in order.
        joints: Vec<String>,
    },
    /// More than one link has no parent.
    #[error("{at}: {} have no parent joint; a robot has one root link", quoted(links))]
    ManyRoots {
        /// Location of the second root in the file.
        at: Location,
        /// The root links.
        links: Vec<String>,
    },
    /// The robot has no link.
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
    /// A name is unknown.
    #[error("{place}: unknown {kind} `{name}`{}", meant(nearest))]
    UnknownName {
        /// File and line, or the option of the caller.
        place: String,
        /// `joint`, `link`, `group`, ….
        kind: &'static str,
        /// Unknown name.
        name: String,
        /// Similar known names, nearest first.
        nearest: Vec<String>,
    },
    /// A group of an SRDF contains itself.
    #[error("{at}: group `{group}` contains itself")]
    GroupLoop {
        /// Location of the group in the file.
        at: Location,
        /// The group.
        group: String,
    },
    /// A chain of an SRDF does not lead from its base to its tip.
    #[error("{at}: link `{tip}` does not descend from link `{base}`")]
    BrokenChain {
        /// Location of the chain in the file.
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
    /// The group contains a joint twice.
    #[error("joint group: joint `{joint}` is named twice")]
    NamedTwice {
        /// The joint.
        joint: String,
    },
    /// A joint to be moved or fixed at a value cannot move independently.
    #[error("{at}: joint `{joint}` cannot be {wanted}: {constraint}")]
    NotFree {
        /// Location of the joint in the file.
        at: Location,
        /// The joint.
        joint: String,
        /// `moved` or `held at a value`.
        wanted: &'static str,
        /// Reason why it cannot.
        constraint: JointConstraint,
    },
    /// An SRDF contains unknown content.
    #[error("{at}: unknown {kind} `{name}` in an SRDF (known here: {known})")]
    UnknownInSrdf {
        /// Location in the file.
        at: Location,
        /// `element`, `attribute`, …
        kind: &'static str,
        /// Unknown name.
        name: String,
        /// Names that are known there.
        known: String,
    },
    /// A joint should be fixed at a value outside its limits.
    #[error("{at}: joint `{joint}` cannot be held at {value}: its limits are {lower} to {upper}")]
    HeldOutsideLimits {
        /// Location of the joint in the file.
        at: Location,
        /// The joint.
        joint: String,
        /// Requested value, in metres or radians.
        value: f64,
        /// Lower limit, in metres or radians.
        lower: f64,
        /// Upper limit, in metres or radians.
        upper: f64,
    },
    /// A mesh file does not exist.
    #[error(
        "{at}: link `{link}`: mesh `{mesh}` not found; tried {}{}", listed(tried),
        if mesh.starts_with("package://") { " (--package FOLDER names the folder that holds the package)" } else { "" }
    )]
    MeshNotFound {
        /// Location of the mesh name in the file.
        at: Location,
        /// The link.
        link: String,
        /// Mesh name as written.
        mesh: String,
        /// Files that were tried.
        tried: Vec<PathBuf>,
    },
    /// A model that an SDF includes does not exist.
    #[error(
        "{at}: the model `{uri}` that is included was not found; tried {} (GZ_SIM_RESOURCE_PATH lists folders of models)",
        listed(tried)
    )]
    ModelNotFound {
        /// Location of the inclusion.
        at: Location,
        /// Its URI as written.
        uri: String,
        /// Files that were tried.
        tried: Vec<PathBuf>,
    },
    /// A collision geometry is not a usable solid.
    #[error("{at}: link `{link}`: {reason}")]
    Shape {
        /// Location of the geometry in the file.
        at: Location,
        /// The link.
        link: String,
        /// Fault of the geometry.
        reason: Box<ShapeError>,
    },
    /// A value in a `robot.yaml` or `limits.yaml` is invalid.
    #[error("{at}: {attribute} of {element} is {value}, but must be {range}")]
    HandFigure {
        /// Location in the file.
        at: Location,
        /// The hand or finger.
        element: String,
        /// Attribute with the value.
        attribute: &'static str,
        /// Actual value.
        value: f64,
        /// Valid values.
        range: String,
    },
    /// The hand of a robot is unknown.
    #[error(
        "robot {robot}: the joints that close its hand are not known, so grasps cannot be sampled for it \
         (`cranny robot add URDF` finds the hand and writes it to a robot.yaml)"
    )]
    NoHand {
        /// Name of the robot.
        robot: String,
    },
    /// The grasps of a tool cannot be sampled.
    #[error("tool '{tool}' has no pads that close: grasps come from a file (grasps.csv), none are sampled")]
    ToolGrasps {
        /// Name of the tool.
        tool: String,
    },
    /// A `robot.yaml` describes a hand and a tool.
    #[error("{at}: a robot has a `hand`, whose pads close, or a `tool`, whose grasps are in files, not both")]
    HandAndTool {
        /// Location in the file.
        at: Location,
    },
    /// A folder does not describe a robot.
    #[error(
        "{}: the folder has no robot.yaml that names the URDF (`urdf: NAME.urdf`); `cranny robot add URDF` \
         writes one", folder.display()
    )]
    NoDescription {
        /// Path of the folder.
        folder: PathBuf,
    },
    /// A `limits.yaml` or `robot.yaml` is malformed.
    #[error("{at}: {reason}")]
    Yaml {
        /// Location in the file.
        at: Location,
        /// Fault in the file.
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

/// Returns the name of the URDF that a xacro file expands to.
fn expanded(file: &str) -> String {
    match file.strip_suffix(".urdf.xacro").or_else(|| file.strip_suffix(".xacro")) {
        Some(stem) => format!("{stem}.urdf"),
        None => format!("{}.expanded.urdf", file.strip_suffix(".urdf").unwrap_or(file)),
    }
}
