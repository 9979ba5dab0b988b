use cranny_spatial::Point;

use crate::cloud::point_cloud::narrow;
use crate::{PointCloud, View};

impl View {
    /// Returns the measured points in the planning frame, row by row, from the stated pose of the camera. Pixels without a valid
    /// depth give none.
    pub fn cloud(&self) -> PointCloud {
        let world_from_camera = &self.camera.world_from_camera;
        let mut points = Vec::with_capacity(self.depth.valid_count());
        for (index, depth_m) in
            self.depth.depths_m().iter().enumerate().filter(|(_, depth_m)| !depth_m.is_nan())
        {
            let (u, v) = (index % self.depth.width(), index / self.depth.width());
            let in_camera = Point::from(self.camera.ray(u as f64, v as f64) * f64::from(*depth_m));
            points.push(narrow(&(world_from_camera * in_camera)));
        }
        PointCloud { points, viewpoint: Some(*world_from_camera) }
    }
}
