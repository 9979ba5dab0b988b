use std::path::Path;

use cranny_scenario::{Scenario, ScenarioError};
use cranny_sense::{Camera, CameraFile, CameraFrame, PlacedCamera, SenseError, SensedScene, SensorModel};
use cranny_spatial::nalgebra::Quaternion;
use cranny_spatial::{Pose, Rotation, Vector};
use serde::{Deserialize, Serialize};

use crate::recipe::limits::MOST_CAMERAS;
use crate::scene_row::pose_numbers;

/// Cameras of the pictures of a data set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DatasetCameras {
    /// This number of cameras around the target of each scene, as by `cranny sense --default-cameras`; fewer where there is no free
    /// position for one.
    Default(usize),
    /// The same cameras in each scene.
    Placed(Vec<DatasetCamera>),
}

/// Camera of a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DatasetCamera {
    /// Name.
    pub name: String,
    /// Link of the robot on which it is mounted; `None`: it stands in the planning frame.
    pub link: Option<String>,
    /// Width and height of its pictures, in pixels.
    pub size_px: [usize; 2],
    /// Focal lengths along x and y, then the principal point, in pixels.
    pub intrinsics_px: [f64; 4],
    /// Least and greatest depth that its sensor returns, in metres.
    pub range_m: [f64; 2],
    /// Pose of the optical frame in the planning frame or in that of the link: position (m), unit quaternion (w, x, y, z).
    pub pose: [f64; 7],
}

impl DatasetCameras {
    /// Reads the cameras of a file, as of `cranny sense --cameras`.
    ///
    /// # Errors
    /// As [`CameraFile::read`].
    pub(crate) fn read(path: &Path) -> Result<Self, SenseError> {
        let of = |placed: &PlacedCamera| {
            let PlacedCamera { name, frame, camera, sensor, .. } = placed;
            DatasetCamera {
                name: name.clone(),
                link: match frame {
                    CameraFrame::World => None,
                    CameraFrame::Link(link) => Some(link.clone()),
                },
                size_px: [camera.width_px, camera.height_px],
                intrinsics_px: [camera.focal_x_px, camera.focal_y_px, camera.center_x_px, camera.center_y_px],
                range_m: [sensor.nearest_m, sensor.farthest_m],
                pose: pose_numbers(&camera.world_from_camera),
            }
        };
        let cameras = CameraFile::read(path)?.cameras;
        if let Some(moved) = cameras.iter().find(|camera| camera.configuration.is_some()) {
            let problem = format!(
                "camera '{}': data sets show the robot at its start, without `configuration`",
                moved.name
            );
            return Err(SenseError::Content { path: path.to_owned(), problem });
        }
        Ok(Self::Placed(cameras.iter().map(of).collect()))
    }

    /// Returns a sentence on the first camera that no file of cameras may state.
    pub(crate) fn fault(&self) -> Option<String> {
        match self {
            Self::Default(count) => {
                let is_valid = (1..=MOST_CAMERAS).contains(&(*count as u64));
                (!is_valid).then(|| format!("the number of cameras must be from 1 to {MOST_CAMERAS}"))
            }
            Self::Placed(cameras) => cameras.iter().find_map(|own| {
                let PlacedCamera { name, camera, sensor, .. } = own.placed();
                let fault = camera.check().and_then(|()| sensor.check()).err()?;
                Some(format!("camera '{name}': {fault}"))
            }),
        }
    }

    /// Returns the cameras in a scenario.
    pub(crate) fn of_scenario(
        &self,
        scenario: &Scenario,
        scene: &SensedScene,
    ) -> Result<Vec<PlacedCamera>, ScenarioError> {
        match self {
            Self::Placed(cameras) => Ok(cameras.iter().map(DatasetCamera::placed).collect()),
            Self::Default(count) => {
                for count in (1..=*count).rev() {
                    match scenario.default_cameras(scene, count) {
                        Err(ScenarioError::Sense(SenseError::NoCameraPosition)) => {}
                        found => return found,
                    }
                }
                Ok(Vec::new())
            }
        }
    }
}

impl DatasetCamera {
    fn placed(&self) -> PlacedCamera {
        let [x, y, z, qw, qx, qy, qz] = self.pose;
        let [focal_x_px, focal_y_px, center_x_px, center_y_px] = self.intrinsics_px;
        let [nearest_m, farthest_m] = self.range_m;
        // The components are those that were written, so that the pictures are the same to the bit.
        let rotation = Rotation::new_unchecked(Quaternion::new(qw, qx, qy, qz));
        PlacedCamera {
            name: self.name.clone(),
            frame: self.link.clone().map_or(CameraFrame::World, CameraFrame::Link),
            camera: Camera {
                width_px: self.size_px[0],
                height_px: self.size_px[1],
                focal_x_px,
                focal_y_px,
                center_x_px,
                center_y_px,
                world_from_camera: Pose::from_parts(Vector::new(x, y, z).into(), rotation),
            },
            // Pictures have no errors.
            sensor: SensorModel { nearest_m, farthest_m, ..SensorModel::default() },
            configuration: None,
        }
    }
}
