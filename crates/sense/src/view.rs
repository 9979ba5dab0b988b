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

    /// Returns the view as one of the robot at this configuration (m, rad; one value per joint).
    #[must_use]
    pub fn at_configuration(self, configuration: Option<Vec<f64>>) -> Self {
        Self { configuration, ..self }
    }
}
