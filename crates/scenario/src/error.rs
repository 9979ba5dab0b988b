use std::path::{Path, PathBuf};

use cranny_file::{TextFault, counted, did_you_mean, nearest_files, nearest_names, suggested};
use cranny_robot::Location;

use crate::family::error::FamilyError;
use crate::moveit::error::MoveItError;
use crate::object::error::ObjectError;

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
        near: Vec<String>,
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
    /// The start configuration does not fit the robot.
    #[error("{file}: the start has {}, but the robot has {} ({joints})", counted(*actual, "value"), counted(*expected, "joint"))]
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
    #[error("{at}: unknown joint '{joint}' (the robot has: {known}){}", did_you_mean(joint, known.split(", ")))]
    UnknownJoint {
        /// Where.
        at: Location,
        /// The name.
        joint: String,
        /// The names that there are.
        known: String,
    },
    /// What a file says of a place is none.
    #[error("{at}: {problem}")]
    Place {
        /// Where.
        at: Location,
        /// What is wrong, with a hint.
        problem: String,
    },
    /// A bound that a file states is none.
    #[error("{at}: {problem}")]
    Bound {
        /// Place in the file.
        at: Location,
        /// Fault, with a hint.
        problem: String,
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
    #[error("{at}: the object library has no '{name}' (it has: {known}){}", did_you_mean(name, known.split(", ")))]
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
    /// The search that a drawn scenario must pass cannot begin.
    #[error("no search for a way to a grasp: {problem}")]
    Search {
        /// Why not.
        problem: String,
    },
    /// A scenario has no task of that name.
    #[error(
        "scenario '{id}' has no task '{name}' (there are: {known}; `tasks` of its scenario.yaml){}",
        cranny_file::did_you_mean(name, known.split(", ").map(|known| known.trim_matches('\'')))
    )]
    UnknownTask {
        /// The scenario.
        id: String,
        /// The name asked for.
        name: String,
        /// The names that there are.
        known: String,
    },
    /// There is no object to be grasped.
    #[error("scenario '{id}' has no target")]
    NoTarget {
        /// The scenario.
        id: String,
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
    /// A safety margin or a bound of the tool is demanded where there is no proof to hold it.
    #[error(
        "a margin or a bound of the tool needs the criterion 'exact': the criterion 'paper' proves nothing"
    )]
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
    /// A gripper has a figure that cannot be.
    #[error("{}: {reason}", path.display())]
    GripperFigure {
        /// The gripper's file.
        path: PathBuf,
        /// Which figure.
        reason: cranny_grasp::GraspError,
    },
    /// A scenario's robot is nowhere.
    #[error(
        "{at}: there is no robot '{name}': it is neither built in ({known}) nor a file or folder ({}){}",
        path.display(),
        did_you_mean_robot(name, known)
    )]
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
    /// A robot is named that is nowhere.
    #[error(
        "there is no robot '{}': it is neither built in ({known}) nor a file or folder{}",
        what.display(),
        did_you_mean_robot(&what.display().to_string(), known)
    )]
    NoRobot {
        /// Its name, or its path.
        what: PathBuf,
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
    Task(#[from] cranny_task::TaskError),
    /// What can be wrong with a `MoveIt` scene, a request, or the robot that they name.
    #[error(transparent)]
    MoveIt(#[from] MoveItError),
    /// What can be wrong with an object to be grasped.
    #[error(transparent)]
    Object(#[from] ObjectError),
    /// What can be wrong with a family of scenarios.
    #[error(transparent)]
    Family(#[from] FamilyError),
}

/// The names that may be meant, or else a hint.
fn meant(near: &[String], hint: &str) -> String {
    if near.is_empty() { hint.to_owned() } else { format!("did you mean {}?", near.join(" or ")) }
}

/// The end of a message about a robot that is nowhere: the built-in ones, and files and folders without a scenario, whose
/// names are near.
fn did_you_mean_robot(name: &str, known: &str) -> String {
    let files = nearest_files(Path::new(name)).into_iter();
    let is_scenario = |file: &String| Path::new(file).join("scenario.yaml").exists();
    let mut near = nearest_names(name, known.split(", "));
    near.extend(files.filter(|file| !is_scenario(file)));
    suggested(&near)
}
