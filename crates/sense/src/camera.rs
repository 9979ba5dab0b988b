use cranny_spatial::{FARTHEST_M, Point, Pose, Rotation, Vector};

use crate::SenseError;
use crate::error::within;

/// Maximum width and height of an image, in pixels.
pub const MOST_SIDE_PX: usize = 8192;

/// Maximum focal length and coordinate of the principal point, in pixels: larger values are in other units.
const MOST_PX: f64 = 1e6;

/// Maximum difference of a quaternion's length from 1.
const UNIT_TOLERANCE: f64 = 1e-6;

/// Pinhole camera without distortion.
///
/// Optical frame: z forward, x to the right of the image, y down. The centre of pixel (u, v) is at these integer coordinates;
/// (0, 0) is the top left pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Width of the image, in pixels.
    pub width_px: usize,
    /// Height of the image, in pixels.
    pub height_px: usize,
    /// Focal length along x, in pixels.
    pub focal_x_px: f64,
    /// Focal length along y, in pixels.
    pub focal_y_px: f64,
    /// Principal point along x, in pixels.
    pub center_x_px: f64,
    /// Principal point along y, in pixels.
    pub center_y_px: f64,
    /// Pose of the optical frame in the planning frame.
    pub world_from_camera: Pose,
}

impl Camera {
    /// Creates a camera from the size of its image (width and height, px), its focal lengths and its principal point (x and y,
    /// px), and its pose.
    ///
    /// # Errors
    /// As [`Self::check`].
    pub fn new(
        size_px: [usize; 2],
        focal_px: [f64; 2],
        center_px: [f64; 2],
        world_from_camera: Pose,
    ) -> Result<Self, SenseError> {
        let camera = Self {
            width_px: size_px[0],
            height_px: size_px[1],
            focal_x_px: focal_px[0],
            focal_y_px: focal_px[1],
            center_x_px: center_px[0],
            center_y_px: center_px[1],
            world_from_camera,
        };
        camera.check()?;
        Ok(camera)
    }

    /// Creates a camera with square pixels and the principal point in the middle, from its horizontal field of view (radians):
    /// the angle between the outer edges of the first and the last column.
    ///
    /// # Errors
    /// As [`Self::check`], and [`SenseError::Camera`] for a field of view that is not above 0 and below π.
    pub fn with_field_of_view(
        size_px: [usize; 2],
        field_of_view_rad: f64,
        world_from_camera: Pose,
    ) -> Result<Self, SenseError> {
        let focal_px = Self::focal_of_field_px(size_px[0], field_of_view_rad)?;
        Self::new(size_px, [focal_px; 2], Self::middle_px(size_px), world_from_camera)
    }

    /// Returns the focal length (px) of an image of this width with this horizontal field of view (radians).
    ///
    /// # Errors
    /// [`SenseError::Camera`] for a field of view that is not above 0 and below π.
    pub fn focal_of_field_px(width_px: usize, field_of_view_rad: f64) -> Result<f64, SenseError> {
        let fits = field_of_view_rad > 0.0 && field_of_view_rad < std::f64::consts::PI;
        if !fits {
            return Err(SenseError::Camera {
                property: "horizontal field of view, in degrees,",
                value: field_of_view_rad.to_degrees(),
                range: "above 0 and below 180",
            });
        }
        Ok(0.5 * width_px as f64 / libm::tan(0.5 * field_of_view_rad))
    }

    /// Returns the middle of an image of this size (width and height, px), as x and y in pixels.
    pub fn middle_px(size_px: [usize; 2]) -> [f64; 2] {
        size_px.map(|side| 0.5 * (side as f64 - 1.0))
    }

    /// Checks the ranges of all properties.
    ///
    /// # Errors
    /// [`SenseError::Camera`] for a side outside 1 to [`MOST_SIDE_PX`], a focal length that is not positive or too large, or a
    /// principal point that is not finite; [`SenseError::CameraPose`] for a pose that is not rigid or too far away.
    pub fn check(&self) -> Result<(), SenseError> {
        for (property, side) in [("width in pixels", self.width_px), ("height in pixels", self.height_px)] {
            if !(1..=MOST_SIDE_PX).contains(&side) {
                return Err(SenseError::Camera { property, value: side as f64, range: "1 to 8192" });
            }
        }
        for focal_px in [self.focal_x_px, self.focal_y_px] {
            if !(focal_px > 0.0 && focal_px <= MOST_PX) {
                let property = "focal length in pixels";
                return Err(SenseError::Camera { property, value: focal_px, range: "above 0, at most 1e6" });
            }
        }
        for center_px in [self.center_x_px, self.center_y_px] {
            let property = "principal point in pixels";
            within(center_px, [-MOST_PX, MOST_PX], |value| SenseError::Camera {
                property,
                value,
                range: "within ±1e6",
            })?;
        }
        let Pose { rotation, translation } = &self.world_from_camera;
        let norm = rotation.coords.norm();
        // NaN lies in no range.
        if !(1.0 - UNIT_TOLERANCE..=1.0 + UNIT_TOLERANCE).contains(&norm) {
            let problem = format!("its quaternion has length {norm} instead of 1");
            return Err(SenseError::CameraPose { problem });
        }
        let is_near = |value: &f64| (-FARTHEST_M..=FARTHEST_M).contains(value);
        if let Some(value) = translation.vector.iter().find(|value| !is_near(value)) {
            let problem = format!("its position has the coordinate {value}");
            return Err(SenseError::CameraPose { problem });
        }
        Ok(())
    }

    /// Returns the pose of a camera at `eye` that looks at `target`, with `up` upwards in the image (all in one frame);
    /// `None` if the two points coincide. If the camera looks along `up`, another upward direction is chosen.
    pub fn looking_at(eye: &Point, target: &Point, up: &Vector) -> Option<Pose> {
        /// Sine of the angle to `up` below which another direction is used.
        const LEAST_SINE: f64 = 1e-6;
        let forward = (target - eye).try_normalize(1e-9)?;
        let others = [*up, Vector::x(), Vector::y()];
        let right = others.iter().find_map(|up| forward.cross(up).try_normalize(LEAST_SINE))?;
        let down = forward.cross(&right);
        let matrix = cranny_spatial::nalgebra::Matrix3::from_columns(&[right, down, forward]);
        let rotation = Rotation::from_rotation_matrix(
            &cranny_spatial::nalgebra::Rotation3::from_matrix_unchecked(matrix),
        );
        Some(Pose::from_parts(eye.coords.into(), rotation))
    }

    /// Returns the number of pixels.
    pub fn pixel_count(&self) -> usize {
        self.width_px * self.height_px
    }

    /// Returns the ray through the image point (u, v) (px): its direction in the camera frame, with z = 1.
    pub fn ray(&self, u_px: f64, v_px: f64) -> Vector {
        Vector::new(
            (u_px - self.center_x_px) / self.focal_x_px,
            (v_px - self.center_y_px) / self.focal_y_px,
            1.0,
        )
    }

    /// Returns the image point (u, v) (px) of a point in the camera frame; `None` unless the point is in front of the camera.
    ///
    /// `project(z · ray(u, v)) = (u, v)` for z > 0 (test `projection_inverts_rays`).
    pub fn project(&self, point_in_camera: &Point) -> Option<[f64; 2]> {
        let Point { coords } = point_in_camera;
        (coords.z > 0.0).then(|| {
            [
                self.center_x_px + self.focal_x_px * coords.x / coords.z,
                self.center_y_px + self.focal_y_px * coords.y / coords.z,
            ]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(pose: Pose) -> Camera {
        Camera::new([320, 240], [300.0, 310.0], [159.5, 119.5], pose).expect("a valid camera")
    }

    #[test]
    fn projection_inverts_rays() {
        let camera = camera(Pose::identity());
        for (u, v, z) in [(0.0, 0.0, 0.3), (319.0, 239.0, 2.0), (100.25, 7.5, 4.0)] {
            let [x, y] = camera.project(&(camera.ray(u, v) * z).into()).expect("in front");
            assert!((x - u).abs() < 1e-9 && (y - v).abs() < 1e-9);
        }
        assert!(camera.project(&Point::new(0.0, 0.0, -1.0)).is_none());
    }

    #[test]
    fn a_camera_looks_where_it_is_aimed_with_its_head_up() {
        let (eye, target) = (Point::new(1.0, -2.0, 0.5), Point::new(0.2, 0.3, 0.1));
        for up in [Vector::z(), (target - eye).normalize()] {
            let pose = Camera::looking_at(&eye, &target, &up).expect("two points");
            let seen = pose.inverse() * target;
            assert!(seen.x.abs() < 1e-12 && seen.y.abs() < 1e-12 && seen.z > 2.0, "{seen}");
        }
        let pose = Camera::looking_at(&eye, &target, &Vector::z()).expect("two points");
        assert!((pose.rotation * Vector::y()).z < 0.0, "y of the image points down");
        assert!(Camera::looking_at(&eye, &eye, &Vector::z()).is_none());
    }

    #[test]
    fn a_field_of_view_spans_the_outer_edges() {
        let camera = Camera::with_field_of_view([100, 50], 1.2, Pose::identity()).expect("a valid camera");
        let edge = camera.ray(-0.5, 24.5);
        assert!((libm::atan(-edge.x) - 0.6).abs() < 1e-12 && edge.y.abs() < 1e-12);
    }

    #[test]
    fn invalid_cameras_are_refused_with_their_property() {
        let pose = Pose::identity();
        let with =
            |size, focal, center| Camera::new(size, focal, center, pose).map(|_| ()).unwrap_err().to_string();
        assert!(with([0, 5], [1.0; 2], [0.0; 2]).contains("width in pixels of a camera must be 1 to 8192"));
        assert!(with([5, 9000], [1.0; 2], [0.0; 2]).contains("height"));
        assert!(with([5, 5], [f64::NAN, 1.0], [0.0; 2]).contains("focal length"));
        assert!(with([5, 5], [1.0, -1.0], [0.0; 2]).contains("but is -1"));
        assert!(with([5, 5], [1.0; 2], [f64::INFINITY, 0.0]).contains("principal point"));
        let mut skew = camera(pose);
        skew.world_from_camera.translation.vector.x = f64::NAN;
        assert!(skew.check().unwrap_err().to_string().contains("NaN"));
        skew.world_from_camera = pose;
        skew.world_from_camera.rotation.as_mut_unchecked().w = 1.1;
        assert!(skew.check().unwrap_err().to_string().contains("length 1.1"));
        assert!(Camera::with_field_of_view([5, 5], 4.0, pose).unwrap_err().to_string().contains("229.18"));
    }
}
