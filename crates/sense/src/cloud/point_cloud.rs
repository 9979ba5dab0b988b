use cranny_spatial::{Point, Pose};

/// Points in one frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointCloud {
    /// Points, in metres; all finite.
    pub points: Vec<[f32; 3]>,
    /// Pose of the sensor as its file states it, if it does; it is not applied to the points.
    pub viewpoint: Option<Pose>,
}

impl PointCloud {
    /// Returns a cloud of these points (m), without a viewpoint.
    pub fn of(points: Vec<[f32; 3]>) -> Self {
        Self { points, viewpoint: None }
    }

    /// Returns the cloud in a target frame, rounded to single precision; the viewpoint too.
    #[must_use]
    pub fn transformed(&self, target_from_cloud: &Pose) -> Self {
        let points = self.points.iter().map(|point| narrow(&(target_from_cloud * wide(point)))).collect();
        Self { points, viewpoint: self.viewpoint.map(|viewpoint| target_from_cloud * viewpoint) }
    }

    /// Returns the bytes of a PCD file of version 0.7, binary.
    pub fn pcd_bytes(&self) -> Vec<u8> {
        let count = self.points.len();
        let pose = self.viewpoint.unwrap_or_else(Pose::identity);
        let (t, r) = (pose.translation.vector, pose.rotation.coords);
        let header = format!(
            "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\n\
             COUNT 1 1 1\nWIDTH {count}\nHEIGHT 1\nVIEWPOINT {} {} {} {} {} {} {}\nPOINTS {count}\nDATA binary\n",
            t.x, t.y, t.z, r.w, r.x, r.y, r.z
        );
        let mut bytes = header.into_bytes();
        bytes.extend(self.points.iter().flatten().flat_map(|number| number.to_le_bytes()));
        bytes
    }
}

pub(crate) fn wide(point: &[f32; 3]) -> Point {
    Point::from(point.map(f64::from))
}

#[allow(clippy::cast_possible_truncation, reason = "points are stored as f32")]
pub(crate) fn narrow(point: &Point) -> [f32; 3] {
    [point.x as f32, point.y as f32, point.z as f32]
}
