use std::path::{Path, PathBuf};

use cranny_file::TextFault;
use cranny_robot::Location;

/// Errors of cameras, depth images, point clouds and their files. Each message names the file, if there is one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SenseError {
    /// The configuration of the robot in a view does not fit the robot.
    #[error("view '{view}': the configuration has {actual} values, but the robot has {expected} joints")]
    Configuration {
        /// Name of the view.
        view: String,
        /// Number of values.
        actual: usize,
        /// Number of joints.
        expected: usize,
    },
    /// The configuration of the robot in a view is beyond a limit.
    #[error(
        "view '{view}': the configuration has {joint} at {value}, beyond its limits {lower} to {upper} (rad, m)"
    )]
    ConfigurationLimit {
        /// Name of the view.
        view: String,
        /// Name of the joint.
        joint: String,
        /// Its value.
        value: f64,
        /// Its lower limit.
        lower: f64,
        /// Its upper limit.
        upper: f64,
    },
    /// A property of a camera is out of its range.
    #[error("the {property} of a camera must be {range}, but is {value}")]
    Camera {
        /// Name of the property, with its unit.
        property: &'static str,
        /// The invalid value.
        value: f64,
        /// Valid range.
        range: &'static str,
    },
    /// The pose of a camera is not a rigid transform within the largest coordinates.
    #[error(
        "the pose of a camera must be a rotation and a position of at most 1000 m from the origin; {problem}"
    )]
    CameraPose {
        /// Description of the fault.
        problem: String,
    },
    /// A property of a sensor is out of its range.
    #[error("the {property} of a sensor must be {range}, but is {value}")]
    Sensor {
        /// Name of the property.
        property: &'static str,
        /// The invalid value.
        value: f64,
        /// Valid range.
        range: &'static str,
    },
    /// The number of depths does not match the size of the image.
    #[error("a depth image of {width} × {height} pixels has {} depths, but {actual} are given", width * height)]
    DepthCount {
        /// Width, in pixels.
        width: usize,
        /// Height, in pixels.
        height: usize,
        /// Number of given depths.
        actual: usize,
    },
    /// The size of a depth image differs from that of its camera.
    #[error(
        "the depth image has {} × {} pixels, but its camera {} × {}",
        image[0], image[1], camera[0], camera[1]
    )]
    ViewSize {
        /// Width and height of the image, in pixels.
        image: [usize; 2],
        /// Width and height of the camera, in pixels.
        camera: [usize; 2],
    },
    /// A map of seen space has no views.
    #[error("a map of seen space needs at least one view")]
    NoViews,
    /// A map of seen space is out of range.
    #[error("a map of seen space cannot be made: {problem}")]
    Map {
        /// Description of the fault.
        problem: String,
    },
    /// A shape is out of range.
    #[error(transparent)]
    Shape(#[from] cranny_shape::ShapeError),
    /// A solid has no surface that can be rendered.
    #[error("'{name}' has a solid without a surface that can be rendered")]
    NoSurface {
        /// Name of the body.
        name: String,
    },
    /// There is no surface to sample.
    #[error("there is no surface of finite area to sample points on")]
    NoArea,
    /// A setting of a filter is out of its range.
    #[error("the {property} of a filter must be {range}, but is {value}")]
    Filter {
        /// Name of the property, with its unit.
        property: &'static str,
        /// The invalid value.
        value: f64,
        /// Valid range.
        range: &'static str,
    },
    /// A scene has more bodies than a segment image can number.
    #[error("a rendered scene has at most {most} bodies, but this one has {actual}")]
    TooManyBodies {
        /// Maximum number.
        most: usize,
        /// Actual number.
        actual: usize,
    },
    /// A camera is on a link that the robot does not have.
    #[error("camera '{camera}': the robot has no link '{link}' (it has: {known}){meant}")]
    UnknownLink {
        /// Name of the camera.
        camera: String,
        /// The unknown link.
        link: String,
        /// Names of the links.
        known: String,
        /// Similar names.
        meant: String,
    },
    /// No camera position around the target is free.
    #[error("no position around the target is free for a camera: give cameras in a file (--cameras FILE)")]
    NoCameraPosition,
    /// A noise setting is out of its range.
    #[error("the {property} of a noise must be {range}, but is {value}")]
    Noise {
        /// Name of the property.
        property: &'static str,
        /// The invalid value.
        value: f64,
        /// Valid range.
        range: &'static str,
    },
    /// A file cannot be read.
    #[error("{}: cannot be read: {reason}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        reason: std::io::Error,
    },
    /// A YAML file is malformed or has invalid content.
    #[error("{at}: {reason}")]
    Yaml {
        /// Location in the file.
        at: Location,
        /// Reason of the failure.
        reason: TextFault,
    },
    /// An entry of a file is invalid.
    #[error("{at}: {problem}")]
    Entry {
        /// Location in the file.
        at: Location,
        /// Description of the fault and of valid content.
        problem: String,
    },
    /// A file has invalid content.
    #[error("{}: {problem}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// Description of the fault and of valid content.
        problem: String,
    },
    /// An image cannot be encoded.
    #[error("{name}: cannot be encoded: {reason}")]
    Encoding {
        /// Name of the file.
        name: String,
        /// Message of the encoder.
        reason: String,
    },
}

impl SenseError {
    pub(crate) fn content(path: &Path, problem: impl Into<String>) -> Self {
        Self::Content { path: path.to_owned(), problem: problem.into() }
    }
}

/// Returns the value if it lies within a closed range; `fault` gets any other value, NaN included.
pub(crate) fn within(
    value: f64,
    [least, greatest]: [f64; 2],
    fault: impl FnOnce(f64) -> SenseError,
) -> Result<(), SenseError> {
    if (least..=greatest).contains(&value) { Ok(()) } else { Err(fault(value)) }
}
