use cranny_robot::{LimitViolation, Robot};

use crate::{Camera, DepthImage, SenseError, SensorModel};

/// Depth image with its camera, at the stated pose, and the bounds of its errors.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// Name in reports and files.
    pub name: String,
    /// Camera at its stated pose.
    pub camera: Camera,
    /// Measured depths.
    pub depth: DepthImage,
    /// Bounds of all errors.
    pub sensor: SensorModel,
    /// Configuration of the robot in the image (m, rad; one value per joint); `None`: that at the start of the motion.
    pub configuration: Option<Vec<f64>>,
}

impl View {
    /// Creates a view of the robot at its start.
    ///
    /// # Errors
    /// Those of [`Camera::check`] and [`SensorModel::check`]; [`SenseError::ViewSize`] if the image has another size than the
    /// camera.
    pub fn new(
        name: impl Into<String>,
        camera: Camera,
        depth: DepthImage,
        sensor: SensorModel,
    ) -> Result<Self, SenseError> {
        camera.check()?;
        sensor.check()?;
        let (of_image, of_camera) = ([depth.width(), depth.height()], [camera.width_px, camera.height_px]);
        if of_image != of_camera {
            return Err(SenseError::ViewSize { image: of_image, camera: of_camera });
        }
        Ok(Self { name: name.into(), camera, depth, sensor, configuration: None })
    }

    /// Number of pixels with a depth within the range of the sensor.
    pub fn usable_pixels(&self) -> usize {
        let range = self.sensor.nearest_m..=self.sensor.farthest_m;
        self.depth.depths_m().iter().filter(|depth_m| range.contains(&f64::from(**depth_m))).count()
    }

    /// Returns the view as one of the robot at this configuration (m, rad; one value per joint).
    #[must_use]
    pub fn at_configuration(self, configuration: Option<Vec<f64>>) -> Self {
        Self { configuration, ..self }
    }
}

/// Maximum amount by which a measured joint value may exceed its limit (m, rad).
const BEYOND_LIMIT: f64 = 0.02;

/// Checks that the configuration of a view (m, rad; one value per joint) is one of a robot, within its limits but for errors of
/// measurement.
///
/// # Errors
/// [`SenseError::Configuration`] for another number of values, [`SenseError::ConfigurationLimit`].
pub fn check_configuration(robot: &Robot, view: &str, q: &[f64]) -> Result<(), SenseError> {
    let view = || view.to_owned();
    if q.len() != robot.dof() {
        return Err(SenseError::Configuration { view: view(), actual: q.len(), expected: robot.dof() });
    }
    let is_beyond = |v: &LimitViolation| v.value < v.lower - BEYOND_LIMIT || v.value > v.upper + BEYOND_LIMIT;
    let beyond = robot.limit_violations(q).find(is_beyond);
    beyond.map_or(Ok(()), |LimitViolation { joint, value, lower, upper }| {
        let joint = robot.joint_names()[joint].clone();
        Err(SenseError::ConfigurationLimit { view: view(), joint, value, lower, upper })
    })
}
