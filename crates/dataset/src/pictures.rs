//! Pictures of scenes: exact depths and segments, rendered with the robot at its own start.

use std::collections::BTreeMap;

use cranny_scenario::{OpenOptions, Recipe};
use cranny_sense::{DepthFormat, Noise, StoredView, Views};

use crate::DatasetError;
use crate::recipe::cameras::DatasetCameras;
use crate::scene_row::pose_numbers;

/// Row of a picture: what a camera sees of a scene, and from where.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// Index of the scene.
    pub scene: u64,
    /// Name of the camera.
    pub camera: String,
    /// Width, in pixels.
    pub width: u64,
    /// Height, in pixels.
    pub height: u64,
    /// Focal lengths along x and y, then the principal point, in pixels.
    pub intrinsics_px: Vec<f64>,
    /// Pose of the optical frame (z forward, x right, y down) in the planning frame: position (m), unit quaternion (w, x, y, z).
    pub pose: Vec<f64>,
    /// PNG of one channel of 16 bits: depths in millimetres, 0 for none.
    pub depth_png: Vec<u8>,
    /// PNG of one channel of 16 bits: number of the segment of each pixel, 0 for none.
    pub segments_png: Vec<u8>,
    /// Names of the segments, from number 1: the bodies of the scene, then the robot.
    pub segments: Vec<String>,
}

/// Renders the pictures of a scene.
pub(crate) fn pictures(
    cameras: &DatasetCameras,
    scene: u64,
    recipe: &Recipe,
) -> Result<Vec<Picture>, DatasetError> {
    let scenario = recipe.scenario("scene", &OpenOptions::default())?;
    let sensed = scenario.sensed()?;
    let (mut views, mut pictures) = (Vec::new(), Vec::new());
    for placed in cameras.of_scenario(&scenario, &sensed)? {
        let camera = placed.at(&scenario.robot, &scenario.start)?;
        let segments = sensed.render(&camera).segments;
        pictures.push(Picture {
            scene,
            camera: placed.name.clone(),
            width: camera.width_px as u64,
            height: camera.height_px as u64,
            intrinsics_px: vec![camera.focal_x_px, camera.focal_y_px, camera.center_x_px, camera.center_y_px],
            pose: pose_numbers(&camera.world_from_camera).to_vec(),
            segments: sensed.segments().iter().map(|segment| segment.name.clone()).collect(),
            ..Picture::default()
        });
        // Without errors, and without depths beyond the range of the sensor.
        let exact = Noise { factor: 0.0, ..Noise::default() };
        let view = sensed.view(placed.name, &camera, &placed.sensor, &exact)?;
        views.push(StoredView { view, segments: Some(segments) });
    }
    let files = Views { views, segments: sensed.segments().to_vec() }.files(DepthFormat::Png)?;
    let mut files: BTreeMap<String, Vec<u8>> =
        files.into_iter().map(|file| (file.name, file.content)).collect();
    for picture in &mut pictures {
        let mut file =
            |part: &str| files.remove(&format!("{}.{part}.png", picture.camera)).unwrap_or_default();
        (picture.depth_png, picture.segments_png) = (file("depth"), file("segments"));
    }
    Ok(pictures)
}
