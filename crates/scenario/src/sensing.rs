use cranny_sense::{
    Camera, CameraFrame, DefaultCameras, PlacedCamera, SensedScene, SensorModel, default_cameras,
};

use cranny_shape::Ball;

use crate::{Scenario, ScenarioError};

impl Scenario {
    /// Returns what cameras see of the scenario: its bodies as segments, and the robot at its start as the last one.
    ///
    /// # Errors
    /// [`ScenarioError::Sense`] for a body that cannot be rendered.
    pub fn sensed(&self) -> Result<SensedScene, ScenarioError> {
        self.sensed_at(&self.start)
    }

    /// Returns the same with the robot at `q` (m, rad; one value per joint).
    ///
    /// # Errors
    /// [`ScenarioError::Sense`] for a body that cannot be rendered.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn sensed_at(&self, q: &[f64]) -> Result<SensedScene, ScenarioError> {
        Ok(SensedScene::of_world(&self.world)?.with_robot(&self.robot, q)?)
    }

    /// Returns the number of the target in segment images of [`Self::sensed`]; `None` without a target.
    pub fn target_segment(&self) -> Option<u16> {
        self.target.and_then(|target| u16::try_from(target + 1).ok())
    }

    /// Returns cameras around the target, named `camera1`, `camera2`, …, with the default sensor
    /// ([`cranny_sense::default_cameras`]). The first ones do not depend on `count`.
    ///
    /// # Errors
    /// [`ScenarioError::NoTarget`] without a target of finite size; [`ScenarioError::Sense`] if too few positions are free.
    pub fn default_cameras(
        &self,
        scene: &SensedScene,
        count: usize,
    ) -> Result<Vec<PlacedCamera>, ScenarioError> {
        let ball = self.target.and_then(|target| self.world.bodies()[target].ball());
        let Some((ball, number)) = ball.zip(self.target_segment()) else {
            return Err(ScenarioError::NoTarget { id: self.id.clone() });
        };
        let tool = self.robot.frames_at(&self.start).link(self.robot.tip()).translation.vector.into();
        let frames = self.robot.frames_at(&self.start);
        let links = self.robot.links().iter().enumerate().flat_map(|(index, link)| {
            let world_from_link = *frames.link(index);
            link.collisions.iter().map(move |shape| {
                let ball = shape.solid.ball();
                Ball { center: world_from_link * shape.link_from_shape * ball.center, ..*ball }
            })
        });
        let request =
            DefaultCameras::new(count, number, [ball.center, tool], links.collect(), self.world.up());
        let placed = |(index, camera): (usize, Camera)| PlacedCamera {
            name: format!("camera{}", index + 1),
            frame: CameraFrame::World,
            camera,
            sensor: SensorModel::default(),
            configuration: None,
        };
        Ok(default_cameras(scene, &request)?.into_iter().enumerate().map(placed).collect())
    }
}
