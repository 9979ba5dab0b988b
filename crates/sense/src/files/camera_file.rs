use std::path::Path;

use cranny_file::did_you_mean;
use cranny_robot::Robot;
use serde::Deserialize;
use serde_saphyr::Spanned;

use crate::files::camera_entry::{CameraEntry, SensorEntry, Source};
use crate::files::camera_frame::CameraFrame;
use crate::{Camera, SenseError, SensorModel, check_configuration};

/// Cameras of a file, fixed or on links of the robot.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraFile {
    /// Cameras in the order of the file; at least one.
    pub cameras: Vec<PlacedCamera>,
}

/// Camera with the frame in which its pose is given.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedCamera {
    /// Name; begins the names of its files.
    pub name: String,
    /// Frame of its pose.
    pub frame: CameraFrame,
    /// Camera; its pose is that of the optical frame in `frame`.
    pub camera: Camera,
    /// Bounds of all errors.
    pub sensor: SensorModel,
    /// Configuration of the robot in its images (m, rad; one value per joint); `None`: its start.
    pub configuration: Option<Vec<f64>>,
}

/// Content of a camera file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    /// Bounds of the sensors of all cameras that state none of their own.
    sensor: Option<SensorEntry>,
    cameras: Vec<Spanned<CameraEntry>>,
}

impl CameraFile {
    /// Reads a camera file (`cameras.yaml`).
    ///
    /// # Errors
    /// [`SenseError::Unreadable`], [`SenseError::Yaml`], [`SenseError::Entry`] with the line of the camera,
    /// [`SenseError::Content`] for a file without cameras.
    pub fn read(path: &Path) -> Result<Self, SenseError> {
        let source = Source { path };
        let file: File = source.read()?;
        source.check_names(&file.cameras)?;
        let of_file = file.sensor.unwrap_or_default().or(SensorModel::default());
        let camera = |entry: &Spanned<CameraEntry>| {
            let own = &entry.value;
            if let Some(depth) = own.depth.as_ref().or(own.segments.as_ref()) {
                let problem =
                    "a camera to be rendered has no files; a file of views lists them under `views`";
                return Err(source.fault(depth, problem));
            }
            let (camera, frame, sensor) = CameraEntry::camera(entry, &source, of_file)?;
            let configuration = own.configuration(&source)?;
            Ok(PlacedCamera { name: own.name.value.clone(), frame, camera, sensor, configuration })
        };
        let cameras = file.cameras.iter().map(camera).collect::<Result<Vec<_>, _>>()?;
        if cameras.is_empty() {
            return Err(SenseError::content(path, "the list of cameras is empty"));
        }
        Ok(Self { cameras })
    }
}

impl PlacedCamera {
    /// Returns the camera with its pose in the planning frame, for the robot at its own configuration, or at `q` (m, rad; one per
    /// joint) if it has none.
    ///
    /// # Errors
    /// [`SenseError::UnknownLink`] for a link that the robot does not have, and those of
    /// [`check_configuration`].
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn at(&self, robot: &Robot, q: &[f64]) -> Result<Camera, SenseError> {
        let q = self.configuration.as_deref().unwrap_or(q);
        if let Some(own) = &self.configuration {
            check_configuration(robot, &self.name, own)?;
        }
        let CameraFrame::Link(name) = &self.frame else { return Ok(self.camera.clone()) };
        let links = || robot.links().iter().map(|link| link.name.as_str());
        let link = robot.link_index(name).ok_or_else(|| SenseError::UnknownLink {
            camera: self.name.clone(),
            link: name.clone(),
            known: links().collect::<Vec<_>>().join(", "),
            meant: did_you_mean(name, links()),
        })?;
        let world_from_camera = robot.frames_at(q).link(link) * self.camera.world_from_camera;
        Ok(Camera { world_from_camera, ..self.camera.clone() })
    }
}
