use cranny_robot::Robot;
use cranny_shape::{Solid, separation};
use cranny_spatial::{Point, Pose, Rotation};

use crate::cloud::point_cloud::wide;
use crate::error::within;
use crate::{PointCloud, SenseError};

/// Radius of the ball that stands for a point in the distance to a solid, in metres: below the rounding of a point.
const POINT_M: f64 = 1e-9;

/// Greatest margin around a solid, in metres.
const MOST_MARGIN_M: f64 = 10.0;

/// Cloud without the points near solids.
#[derive(Clone, Debug, PartialEq)]
pub struct Cleared {
    /// Remaining points, in the order of the cloud.
    pub cloud: PointCloud,
    /// Number of points that were removed.
    pub removed: usize,
}

/// Returns the collision solids of a robot at `q` (m, rad; one per joint), with their poses in the planning frame.
///
/// # Panics
/// If `q` has not one value per joint.
pub fn robot_solids(robot: &Robot, q: &[f64]) -> Vec<(Pose, Solid)> {
    let frames = robot.frames_at(q);
    let of_link = |(index, link): (usize, &cranny_robot::Link)| {
        let world_from_link = *frames.link(index);
        let placed =
            |shape: &cranny_robot::LinkShape| (world_from_link * shape.link_from_shape, shape.solid.clone());
        link.collisions.iter().map(placed).collect::<Vec<_>>()
    };
    robot.links().iter().enumerate().flat_map(of_link).collect()
}

/// Solid that removes points.
struct Clearing<'a> {
    pose: Pose,
    cloud_to_solid: Pose,
    solid: &'a Solid,
}

impl PointCloud {
    /// Returns the cloud without the points within `margin_m` (m) of solids, by their exact distance, or inside them; the solids
    /// have poses in the frame of the cloud. Removes a robot's own points ([`robot_solids`]) or those of an object at a known pose.
    ///
    /// A point is removed unless its distance is certified to exceed the margin.
    ///
    /// # Errors
    /// [`SenseError::Filter`] for a margin outside 0 to 10 m.
    pub fn without_near(&self, solids: &[(Pose, Solid)], margin_m: f64) -> Result<Cleared, SenseError> {
        within(margin_m, [0.0, MOST_MARGIN_M], |value| SenseError::Filter {
            property: "margin, in metres,",
            value,
            range: "0 to 10",
        })?;
        let probe = Solid::sphere(POINT_M)?;
        let solids: Vec<Clearing> = solids
            .iter()
            .map(|(pose, solid)| Clearing { pose: *pose, cloud_to_solid: pose.inverse(), solid })
            .collect();
        let is_kept = |point: &[f32; 3]| {
            let point = wide(point);
            !solids.iter().any(|solid| solid.is_near(&point, margin_m, &probe))
        };
        let points: Vec<[f32; 3]> = self.points.iter().filter(|point| is_kept(point)).copied().collect();
        let removed = self.points.len() - points.len();
        Ok(Cleared { cloud: Self { points, viewpoint: self.viewpoint }, removed })
    }
}

impl Clearing<'_> {
    fn is_near(&self, point: &Point, margin_m: f64, probe: &Solid) -> bool {
        let Self { pose, cloud_to_solid, solid } = self;
        let ball = solid.ball();
        let is_far = (pose * ball.center - point).norm() > ball.radius_m + margin_m
            || solid.aabb().distance_to(&(cloud_to_solid * point)) > margin_m;
        if is_far && !solid.is_half_space() {
            return false;
        }
        let at = Pose::from_parts(point.coords.into(), Rotation::identity());
        separation(solid, pose, probe, &at, margin_m + 2.0 * POINT_M).lower_m <= margin_m
    }
}
