use std::path::PathBuf;

use cranny_file::TextFault;
use cranny_robot::Location;

use crate::error_words::{length, listed, meant};

/// What can be wrong with a scenario, a plan file or a file of way points. The message is complete in
/// itself: file and line where there is one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ScenarioError {
    /// The name is neither that of a built-in scenario nor that of a folder.
    #[error(
        "no built-in scenario '{what}' (there are {known}) and no folder of that name ({})",
        meant(near, "give an id, or a folder that holds scenario.yaml or scene.yaml")
    )]
    Unknown {
        /// What was asked for.
        what: String,
        /// The built-in ids.
        known: String,
        /// Those of them that may be meant.
        near: Vec<&'static str>,
    },
    /// A file stands where the folder of a scenario is meant.
    #[error(
        "{}: this is a file, not a scenario (give the folder that it is in, or a packed scenario that ends in \
         .zip)",
        path.display()
    )]
    FileForFolder {
        /// The file.
        path: PathBuf,
    },
    /// A folder describes no scenario.
    #[error(
        "{}: the folder holds neither scenario.yaml (Cranny's layout) nor scene.yaml (the released layout)",
        folder.display()
    )]
    NoScenarioFile {
        /// The folder.
        folder: PathBuf,
    },
    /// A file cannot be read.
    #[error("{}: cannot be read: {reason}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        reason: std::io::Error,
    },
    /// A file cannot be written; what stood there before is untouched.
    #[error("{}: cannot be written: {reason}", path.display())]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        reason: std::io::Error,
    },
    /// A file that should say something is empty.
    #[error("{}: the file is empty", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// A YAML file is malformed, or says what it should not.
    #[error("{at}: {reason}")]
    Yaml {
        /// Where.
        at: Location,
        /// What is wrong with it.
        reason: TextFault,
    },
    /// A JSON file is malformed, or says what it should not.
    #[error("{}:{}: {reason}", path.display(), reason.line)]
    Json {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: TextFault,
    },
    /// A line of a file of configurations has the wrong number of values.
    #[error("{at}: {actual} numbers instead of {expected} (one for each joint)")]
    NumberCount {
        /// Where.
        at: Location,
        /// How many there should be.
        expected: usize,
        /// How many there are.
        actual: usize,
    },
    /// What should be a number is none, or none that is finite.
    #[error("{at}: '{text}' is not a finite number")]
    NotANumber {
        /// Where.
        at: Location,
        /// What stands there.
        text: String,
    },
    /// A way point of a plan has the wrong number of values.
    #[error("{}: way point {waypoint} has {actual} values instead of {expected}", path.display())]
    Waypoint {
        /// The plan file.
        path: PathBuf,
        /// Index of the way point, from 0.
        waypoint: usize,
        /// How many values there should be.
        expected: usize,
        /// How many there are.
        actual: usize,
    },
    /// A file's ending says nothing about how to read it.
    #[error("{}: cannot tell what this file is (known endings: .plan.json, .csv, .try)", path.display())]
    WaypointFormat {
        /// The file.
        path: PathBuf,
    },
    /// A plan to be written holds a number that JSON cannot: infinite, or not a number.
    #[error("{}: not written, because '{field}' holds a number that is not finite", path.display())]
    NotFinite {
        /// The file.
        path: PathBuf,
        /// Which field of the plan.
        field: &'static str,
    },
    /// The start configuration does not fit the robot.
    #[error("{file}: the start has {actual} values, but the robot has {expected} joints ({joints})")]
    StartCount {
        /// The file (with line where there is one).
        file: String,
        /// How many joints the robot has.
        expected: usize,
        /// How many values there are.
        actual: usize,
        /// The names of the joints.
        joints: String,
    },
    /// A joint is named that the robot does not have.
    #[error("{at}: unknown joint '{joint}' (the robot has: {known})")]
    UnknownJoint {
        /// Where.
        at: Location,
        /// The name.
        joint: String,
        /// The names that there are.
        known: String,
    },
    /// The start leaves a joint out.
    #[error("{at}: the start gives no value for joint '{joint}'")]
    MissingJoint {
        /// Where the start stands.
        at: Location,
        /// The joint.
        joint: String,
    },
    /// A scene names an object that its library does not have.
    #[error("{at}: the object library has no '{name}' (it has: {known})")]
    UnknownObject {
        /// Where.
        at: Location,
        /// The name.
        name: String,
        /// The names that there are.
        known: String,
    },
    /// A scene has no object to grasp, or several.
    #[error("{}: 'objects' must hold exactly one object, the one to grasp, but holds {actual}", path.display())]
    TargetCount {
        /// The scene file.
        path: PathBuf,
        /// How many objects there are.
        actual: usize,
    },
    /// Two things have one name.
    #[error("{at}: the name '{name}' is taken already (names are unique, and 'floor' is the floor's)")]
    NameTaken {
        /// Where the second one stands.
        at: Location,
        /// The name.
        name: String,
    },
    /// A body is added under the name of another.
    #[error("there is a body '{name}' already (names are unique)")]
    BodyName {
        /// The name.
        name: String,
    },
    /// There is no object to be grasped.
    #[error("scenario '{id}' has no target")]
    NoTarget {
        /// The scenario.
        id: String,
    },
    /// Nothing says what the target weighs.
    #[error(
        "scenario '{id}' does not say what its target '{target}' weighs (write mass_kg beneath target in scenario.yaml)"
    )]
    NoMass {
        /// The scenario.
        id: String,
        /// The body to be grasped.
        target: String,
    },
    /// The floor is not where a scenario's files have it.
    #[error("only one floor, at {height_m} m in the planning frame, can be written: there the robot stands")]
    OtherFloor {
        /// Where it would have to be.
        height_m: f64,
    },
    /// A shape entry is not exactly one shape.
    #[error(
        "{at}: a shape is exactly one of box, sphere, cylinder, capsule, mesh, hull, but {actual} of them are \
         given"
    )]
    ShapeCount {
        /// Where.
        at: Location,
        /// How many are given.
        actual: usize,
    },
    /// A pose gives its rotation twice.
    #[error("{at}: a pose has either rotation_rpy_deg or quaternion_xyzw, not both")]
    TwoRotations {
        /// Where.
        at: Location,
    },
    /// A quaternion is not of unit length.
    #[error("{at}: the quaternion has length {norm} instead of 1")]
    Quaternion {
        /// Where.
        at: Location,
        /// Its length.
        norm: f64,
    },
    /// A matrix is not the pose of anything.
    #[error("{at}: {reason}")]
    Pose {
        /// Where.
        at: Location,
        /// What is wrong with it.
        reason: cranny_grasp::GraspError,
    },
    /// A body's shape cannot be built.
    #[error("{at}: '{body}': {reason}")]
    Shape {
        /// Where the shape is asked for.
        at: Location,
        /// Of which body.
        body: String,
        /// What is wrong with it.
        reason: cranny_shape::ShapeError,
    },
    /// A safety margin is demanded where there is no proof to hold it.
    #[error("a margin needs the criterion 'exact': the criterion 'paper' measures no distances")]
    MarginUnderPaper,
    /// A file says something that would change the problem but is not read.
    #[error("{at}: {what} is not supported ({hint})")]
    Unsupported {
        /// Where.
        at: Location,
        /// What it is.
        what: &'static str,
        /// What would fit.
        hint: &'static str,
    },
    /// A `MoveIt` file names a joint or a group that the robot does not have.
    #[error("{at}: {reason}")]
    NotOfRobot {
        /// Where.
        at: Location,
        /// What the robot says.
        reason: Box<cranny_robot::RobotError>,
    },
    /// A `MoveIt` scene comes without a robot.
    #[error("{}: no URDF of the robot is given or found; looked for {}", path.display(), listed(tried))]
    NoRobot {
        /// The scene file.
        path: PathBuf,
        /// The files that were looked for.
        tried: Vec<PathBuf>,
    },
    /// A `MoveIt` joint state does not give each joint one position.
    #[error("{at}: the joint state has {names} names, but {values} positions")]
    JointState {
        /// Where.
        at: Location,
        /// How many joints are named.
        names: usize,
        /// How many positions there are.
        values: usize,
    },
    /// A joint has two values.
    #[error("{at}: joint '{joint}' has a value already")]
    JointTwice {
        /// Where the second one stands.
        at: Location,
        /// The joint.
        joint: String,
    },
    /// A `MoveIt` request has no goal.
    #[error("{}: no goal: 'goal_constraints' must hold joint constraints", path.display())]
    NoGoal {
        /// The request file.
        path: PathBuf,
    },
    /// The goal leaves a joint out.
    #[error("{at}: the goal gives no value for joint '{joint}'")]
    GoalWithoutJoint {
        /// Where the goal stands.
        at: Location,
        /// The joint.
        joint: String,
    },
    /// A `MoveIt` object has no shape.
    #[error("{at}: object '{object}' has neither primitives nor meshes")]
    NoShape {
        /// Where.
        at: Location,
        /// The object.
        object: String,
    },
    /// The shapes of a `MoveIt` object do not have one pose each.
    #[error("{at}: object '{object}' has {actual} poses for {expected} shapes of kind {kind}")]
    PoseCount {
        /// Where.
        at: Location,
        /// The object.
        object: String,
        /// `primitive` or `mesh`.
        kind: &'static str,
        /// How many shapes there are.
        expected: usize,
        /// How many poses.
        actual: usize,
    },
    /// A `MoveIt` primitive is of a kind that is not known.
    #[error("{at}: object '{object}': unknown primitive '{kind}' (known: box, sphere, cylinder)")]
    UnknownPrimitive {
        /// Where.
        at: Location,
        /// The object.
        object: String,
        /// The kind.
        kind: String,
    },
    /// A `MoveIt` primitive has the wrong number of dimensions.
    #[error("{at}: object '{object}': {actual} dimensions, but those of a {kind} are [{expected}]")]
    Dimensions {
        /// Where.
        at: Location,
        /// The object.
        object: String,
        /// The kind of primitive.
        kind: String,
        /// What its dimensions are.
        expected: &'static str,
        /// How many there are.
        actual: usize,
    },
    /// A pose is given in a frame that is not known to stand still.
    #[error("{at}: unknown frame '{frame}' (known: {known})")]
    UnknownFrame {
        /// Where.
        at: Location,
        /// The frame.
        frame: String,
        /// The frames that there are.
        known: String,
    },
    /// A mesh is too large or too small for an object that a hand grasps.
    #[error(
        "{file}the object is {} long, so its mesh is hardly in metres (if it is in {unit}, scale it by {scale}: \
         --scale {scale})",
        length(*size_m)
    )]
    ObjectSize {
        /// The mesh file and a colon, if it is from a file.
        file: String,
        /// Its greatest extent as read, in metres.
        size_m: f64,
        /// The unit that the mesh may be in.
        unit: &'static str,
        /// The scale that would then be right.
        scale: f64,
    },
    /// A number that describes an object is none.
    #[error("the {what} of an object must be a positive number, but is {value}")]
    ObjectNumber {
        /// Which number.
        what: &'static str,
        /// The offending value.
        value: f64,
    },
    /// A gripper has a figure that cannot be.
    #[error("{}: {reason}", path.display())]
    GripperFigure {
        /// The gripper's file.
        path: PathBuf,
        /// Which figure.
        reason: cranny_grasp::GraspError,
    },
    /// A scenario's robot is nowhere.
    #[error("{at}: there is no robot '{name}': it is neither built in ({known}) nor a file or folder ({})", path.display())]
    UnknownRobot {
        /// Where.
        at: Location,
        /// The name.
        name: String,
        /// What was looked for.
        path: PathBuf,
        /// The built-in robots.
        known: String,
    },
    /// What a line of a file leads to is wrong.
    #[error("{at}: {fault}")]
    At {
        /// Where.
        at: Location,
        /// What is wrong.
        fault: Box<ScenarioError>,
    },
    /// No built-in object has that name.
    #[error(
        "there is no built-in object '{name}' (there are: {known}) and no folder of that name with object.yaml"
    )]
    UnknownBuiltinObject {
        /// The name.
        name: String,
        /// The names that there are.
        known: String,
    },
    /// Only scenarios whose robot can be named can be written.
    #[error(
        "a scenario that says more of its robot than the robot's own files cannot be written (joints {joints})"
    )]
    OtherRobot {
        /// The robot's joints.
        joints: String,
    },
    /// A scenario would be written where something is.
    #[error("{}: exists already (give another folder, or remove it)", path.display())]
    Exists {
        /// The folder or file.
        path: PathBuf,
    },
    /// A file of `NumPy` holds something else than poses.
    #[error("{}: {problem} (expected: floats of shape (n, 4, 4))", path.display())]
    Npy {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        problem: String,
    },
    /// An archive cannot be read; or a plan file says what this version does not know, or two different things.
    #[error("{}: {problem}", path.display())]
    Content {
        /// The archive or the plan file.
        path: PathBuf,
        /// What is wrong with it.
        problem: String,
    },
    /// A family is asked for that there is not.
    #[error("no family '{name}' (there are {known})")]
    UnknownFamily {
        /// What was asked for.
        name: String,
        /// The families.
        known: String,
    },
    /// The parameter of a family is out of its range.
    #[error("{family}: the {parameter} must be from {low} to {high} m, but is {value}")]
    Parameter {
        /// The family.
        family: &'static str,
        /// What its parameter is.
        parameter: &'static str,
        /// The least value.
        low: f64,
        /// The greatest.
        high: f64,
        /// What was given.
        value: f64,
    },
    /// The robot cannot be built.
    #[error(transparent)]
    Robot(#[from] cranny_robot::RobotError),
    /// The grasps cannot be read or written.
    #[error(transparent)]
    Grasp(#[from] cranny_grasp::GraspError),
    /// A mesh cannot be read.
    #[error(transparent)]
    ShapeFile(#[from] cranny_shape::ShapeError),
    /// The world is malformed.
    #[error(transparent)]
    Collision(#[from] cranny_collision::CollisionError),
    /// The problem is malformed.
    #[error(transparent)]
    Plan(#[from] cranny_plan::PlanError),
}
