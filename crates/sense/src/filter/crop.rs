use cranny_shape::Aabb;
use cranny_spatial::Pose;

use crate::PointCloud;
use crate::cloud::point_cloud::wide;

impl PointCloud {
    /// Returns the points within a box, its faces included, in the order of the cloud; `box_from_cloud` is the pose of the cloud
    /// in the frame of the box.
    #[must_use]
    pub fn cropped(&self, aabb: &Aabb, box_from_cloud: &Pose) -> Self {
        let is_inside = |point: &&[f32; 3]| aabb.contains(&(box_from_cloud * wide(point)));
        Self { points: self.points.iter().filter(is_inside).copied().collect(), viewpoint: self.viewpoint }
    }
}
