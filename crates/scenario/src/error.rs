use std::path::{Path, PathBuf};

use cranny_file::{TextFault, counted, did_you_mean, nearest_files, nearest_names, suggested};
use cranny_robot::Location;

use crate::family::error::FamilyError;
use crate::moveit::error::MoveItError;
use crate::object::error::ObjectError;

/// Errors of scenarios, plan files and way point files. Each message is self-contained and names file and line, if any.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ScenarioError {
    /// The name matches neither a built-in scenario nor a folder.
    #[error(
        "no built-in scenario '{what}' (there are {known}) and no folder of that name ({})",
        meant(near, "give an id, or a folder that holds scenario.yaml or scene.yaml")
    )]
    Unknown {
        /// Requested name.
        what: String,
        /// Built-in ids.
        known: String,
        /// Built-in ids that are likely meant.
        near: Vec<String>,
    },
    /// A file exists where a scenario folder is expected.
    #[error(
        "{}: this is a file, not a scenario (give the folder that it is in, or a packed scenario that ends in \
         .zip)",
        path.display()
    )]
    FileForFolder {
        /// The file.
        path: PathBuf,
    },
    /// A folder contains no scenario.
    #[error(
        "{}: the folder holds neither scenario.yaml (Cranny's layout) nor scene.yaml (the released layout)",
        folder.display()
    )]
    NoScenarioFile {
        /// The folder.
        folder: PathBuf,
    },
    /// A world has no body of that name.
    #[error("{}: no body '{name}' (known: {known}){meant}", path.display())]
    UnknownBody {
        /// The file.
        path: PathBuf,
        /// Requested name.
        name: String,
        /// Known names.
        known: String,
        /// Similar names.
        meant: String,
    },
    /// A file cannot be read.
    #[error("{}: cannot be read: {reason}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        reason: std::io::Error,
    },
    /// A file cannot be written; its previous content is unchanged.
    #[error("{}: cannot be written: {reason}", path.display())]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        reason: std::io::Error,
    },
    /// A file that must have content is empty.
    #[error("{}: the file is empty", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// A YAML file is malformed or has invalid content.
    #[error("{at}: {reason}")]
    Yaml {
        /// Location in the file.
        at: Location,
        /// Reason of the failure.
        reason: TextFault,
    },
    /// A JSON file is malformed or has invalid content.
    #[error("{}:{}: {reason}", path.display(), reason.line)]
    Json {
        /// The file.
        path: PathBuf,
        /// Reason of the failure.
        reason: TextFault,
    },
    /// A line of a file of configurations has the wrong number of values.
    #[error("{at}: {actual} numbers instead of {expected} (one for each joint)")]
    NumberCount {
        /// Location in the file.
        at: Location,
        /// Expected number of values.
        expected: usize,
        /// Actual number of values.
        actual: usize,
    },
    /// A text that must be a number is none, or is not finite.
    #[error("{at}: '{text}' is not a finite number")]
    NotANumber {
        /// Location in the file.
        at: Location,
        /// Text at that location.
        text: String,
    },
    /// The start configuration does not fit the robot.
    #[error("{file}: the start has {}, but the robot has {} ({joints})", counted(*actual, "value"), counted(*expected, "joint"))]
    StartCount {
        /// The file (with line where there is one).
        file: String,
        /// Number of joints of the robot.
        expected: usize,
        /// Number of values.
        actual: usize,
        /// Names of the joints.
        joints: String,
    },
    /// A joint starts outside its limits.
    #[error("{at}: the start is not free: {joint} is {value}, outside its limits [{lower}, {upper}]")]
    StartBeyond {
        /// Location in the file.
        at: Location,
        /// The joint.
        joint: String,
        /// Its value (m, rad).
        value: f64,
        /// Its lower limit (m, rad).
        lower: f64,
        /// Its upper limit (m, rad).
        upper: f64,
    },
    /// A joint is named that the robot does not have.
    #[error("{at}: unknown joint '{joint}' (the robot has: {known}){}", did_you_mean(joint, known.split(", ")))]
    UnknownJoint {
        /// Location in the file.
        at: Location,
        /// Name of the joint.
        joint: String,
        /// Names of the robot's joints.
        known: String,
    },
    /// A place entry of a file is invalid.
    #[error("{at}: {problem}")]
    Place {
        /// Location in the file.
        at: Location,
        /// Description of the fault, with a hint.
        problem: String,
    },
    /// An octomap of a message is invalid.
    #[error("{at}: the octomap cannot be read: {problem}")]
    Octomap {
        /// Location in the file.
        at: Location,
        /// Description of the fault.
        problem: String,
    },
    /// A colour in a file is invalid.
    #[error("{at}: a colour is red, green and blue, each from 0 to 1, not {colour:?}")]
    Colour {
        /// Location in the file.
        at: Location,
        /// Stated colour.
        colour: [f64; 3],
    },
    /// A bound in a file is invalid.
    #[error("{at}: {problem}")]
    Bound {
        /// Location in the file.
        at: Location,
        /// Description of the fault, with a hint.
        problem: String,
    },
    /// Neither the scenario nor the robot's files give a start.
    #[error("{at}: no start: add `start` here or to the robot's `robot.yaml`")]
    NoStart {
        /// Location of the robot in the file.
        at: Location,
    },
    /// The start leaves a joint out.
    #[error("{at}: the start gives no value for joint '{joint}'")]
    MissingJoint {
        /// Location of the start in the file.
        at: Location,
        /// The joint.
        joint: String,
    },
    /// A scene names an object that its library does not have.
    #[error("{at}: the object library has no '{name}' (it has: {known}){}", did_you_mean(name, known.split(", ")))]
    UnknownObject {
        /// Location in the file.
        at: Location,
        /// Name of the object.
        name: String,
        /// Names of the objects in the library.
        known: String,
    },
    /// A scene has no object to grasp, or several.
    #[error("{}: 'objects' must hold exactly one object, the one to grasp, but holds {actual}", path.display())]
    TargetCount {
        /// The scene file.
        path: PathBuf,
        /// Number of objects.
        actual: usize,
    },
    /// A name is empty, or has a line break.
    #[error("{at}: {name:?} is not a name (give one or more visible characters in one line)")]
    UnreadableName {
        /// Location of the name.
        at: Location,
        /// Name.
        name: String,
    },
    /// A tilt is out of its range.
    #[error("{at}: 'upright_deg' must be at most 180, but is {degrees}")]
    UprightRange {
        /// Location of the number.
        at: Location,
        /// Number.
        degrees: f64,
    },
    /// Two items have the same name.
    #[error("{at}: the name '{name}' is taken already (names are unique, and 'floor' is the floor's)")]
    NameTaken {
        /// Location of the second one.
        at: Location,
        /// Name.
        name: String,
    },
    /// A body is added under the name of another.
    #[error("there is a body '{name}' already (names are unique)")]
    BodyName {
        /// Name.
        name: String,
    },
    /// The reachability search for a randomly generated scenario cannot start.
    #[error("cannot search for a path to a grasp: {problem}")]
    Search {
        /// Reason of the failure.
        problem: String,
    },
    /// A scenario has no task of that name.
    #[error(
        "scenario '{id}' has no task '{name}' (known: {known}; see `tasks` in its scenario.yaml){}",
        cranny_file::did_you_mean(name, known.split(", ").map(|known| known.trim_matches('\'')))
    )]
    UnknownTask {
        /// Id of the scenario.
        id: String,
        /// Requested name.
        name: String,
        /// Names of the scenario's tasks.
        known: String,
    },
    /// The scenario has no object to grasp.
    #[error("scenario '{id}' has no target")]
    NoTarget {
        /// Id of the scenario.
        id: String,
    },
    /// The floor is at another height than the one that scenario files can express.
    #[error("only a floor at {height_m} m in the planning frame can be written, where the robot stands")]
    OtherFloor {
        /// Required height of the floor in the planning frame, in metres.
        height_m: f64,
    },
    /// A shape entry is not exactly one shape.
    #[error(
        "{at}: a shape is exactly one of box, sphere, cylinder, capsule, mesh, hull, cloud, but {actual} of them are \
         given"
    )]
    ShapeCount {
        /// Location in the file.
        at: Location,
        /// Number of shapes that are given.
        actual: usize,
    },
    /// A pose gives its rotation twice.
    #[error("{at}: a pose has either rotation_rpy_deg or quaternion_xyzw, not both")]
    TwoRotations {
        /// Location in the file.
        at: Location,
    },
    /// A quaternion is not of unit length.
    #[error("{at}: the quaternion has length {norm} instead of 1")]
    Quaternion {
        /// Location in the file.
        at: Location,
        /// Its norm.
        norm: f64,
    },
    /// A matrix is not a rigid transform.
    #[error("{at}: {reason}")]
    Pose {
        /// Location in the file.
        at: Location,
        /// Reason of the failure.
        reason: cranny_grasp::GraspError,
    },
    /// A body's shape cannot be built.
    #[error("{at}: '{body}': {reason}")]
    Shape {
        /// Location of the shape in the file.
        at: Location,
        /// Name of the body.
        body: String,
        /// Reason of the failure.
        reason: cranny_shape::ShapeError,
    },
    /// A safety margin or a tool bound is required under a criterion that proves nothing.
    #[error(
        "a margin or a bound of the tool needs the criterion 'exact': the criterion 'paper' proves nothing"
    )]
    MarginUnderPaper,
    /// A file contains something that would change the problem but is not supported.
    #[error("{at}: {what} is not supported ({hint})")]
    Unsupported {
        /// Location in the file.
        at: Location,
        /// Unsupported item.
        what: &'static str,
        /// Supported alternative.
        hint: &'static str,
    },
    /// A gripper file contains an invalid figure.
    #[error("{}: {reason}", path.display())]
    GripperFigure {
        /// Gripper file.
        path: PathBuf,
        /// Invalid figure.
        reason: cranny_grasp::GraspError,
    },
    /// The robot of a scenario is not found.
    #[error(
        "{at}: unknown robot '{name}': it is neither built in ({known}) nor a file or folder ({}){}",
        path.display(),
        did_you_mean_robot(name, known)
    )]
    UnknownRobot {
        /// Location in the file.
        at: Location,
        /// Name of the robot.
        name: String,
        /// Path that was searched.
        path: PathBuf,
        /// Names of the built-in robots.
        known: String,
    },
    /// A requested robot is not found.
    #[error(
        "unknown robot '{}': it is neither built in ({known}) nor a file or folder{}",
        what.display(),
        did_you_mean_robot(&what.display().to_string(), known)
    )]
    NoRobot {
        /// Its name or path.
        what: PathBuf,
        /// Names of the built-in robots.
        known: String,
    },
    /// An error that a line of a file causes.
    #[error("{at}: {fault}")]
    At {
        /// Location in the file.
        at: Location,
        /// Error at that location.
        fault: Box<ScenarioError>,
    },
    /// The scenario's robot cannot be referenced by name, so the scenario cannot be written.
    #[error(
        "the scenario cannot be written: no file names its robot as it is, since it was read by itself or changed by `srdf`, \
         `group`, `tip`, `fixed` or `packages` (make a robot of its own, by `cranny robot add`, and name that)"
    )]
    OtherRobot,
    /// The output path of a scenario exists already.
    #[error("{}: exists already (give another folder, or remove it)", path.display())]
    Exists {
        /// Folder or file.
        path: PathBuf,
    },
    /// A `NumPy` file contains something other than poses.
    #[error("{}: {problem} (expected: floats of shape (n, 4, 4))", path.display())]
    Npy {
        /// The file.
        path: PathBuf,
        /// Description of the fault.
        problem: String,
    },
    /// An archive cannot be read, or a plan file has unknown or contradictory content.
    #[error("{}: {problem}", path.display())]
    Content {
        /// Archive or plan file.
        path: PathBuf,
        /// Description of the fault.
        problem: String,
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
    /// The world is invalid.
    #[error(transparent)]
    Collision(#[from] cranny_collision::CollisionError),
    /// The problem is invalid.
    #[error(transparent)]
    Task(#[from] cranny_task::TaskError),
    /// A camera or a depth image is invalid.
    #[error(transparent)]
    Sense(#[from] cranny_sense::SenseError),
    /// An option of a map of seen space is out of its range.
    #[error("{property} of a map of seen space must be 0 to 0.2 m, but is {value} m")]
    SeenOption {
        /// Name of the option.
        property: &'static str,
        /// The invalid value, in metres.
        value: f64,
    },
    /// A `MoveIt` scene, a request, or the robot that they name is invalid.
    #[error(transparent)]
    MoveIt(#[from] MoveItError),
    /// An object to be grasped is invalid.
    #[error(transparent)]
    Object(#[from] ObjectError),
    /// The fine cells of a map of seen space are wider than the others.
    #[error(
        "fine_m is {fine_m} m, but the cells beside the target cannot be wider than the others, cell_m of {cell_m} m"
    )]
    SeenFine {
        /// Width of the fine cells, in metres.
        fine_m: f64,
        /// Width of the others, in metres.
        cell_m: f64,
    },
    /// The parameters of a scenario family are invalid.
    #[error(transparent)]
    Family(#[from] FamilyError),
}

/// Returns suggested names, or else `hint`.
fn meant(near: &[String], hint: &str) -> String {
    if near.is_empty() { hint.to_owned() } else { format!("did you mean {}?", near.join(" or ")) }
}

/// Returns the end of a message about an unknown robot: built-in robots, and files and folders, with similar names.
fn did_you_mean_robot(name: &str, known: &str) -> String {
    let files = nearest_files(Path::new(name)).into_iter();
    let is_scenario = |file: &String| Path::new(file).join("scenario.yaml").exists();
    let mut near = nearest_names(name, known.split(", "));
    near.extend(files.filter(|file| !is_scenario(file)));
    suggested(&near)
}
