use cranny_robot::{JointKind, Robot};
use cranny_spatial::{FARTHEST_M, Point, Pose, Vector};

use crate::CollisionError;

/// Bound on the pose of a link, by default the tip of the robot, that every motion keeps.
#[derive(Clone, Debug, PartialEq)]
pub struct ToolBound {
    /// Name in reports.
    pub name: String,
    /// Name of the bounded link; `None` for the robot's tip.
    pub link: Option<String>,
    /// Allowed poses of the link.
    pub region: ToolRegion,
}

/// Set of poses of a link in the planning frame.
#[derive(Clone, Debug, PartialEq)]
pub enum ToolRegion {
    /// A direction of the link stays within an angle of a direction in the planning frame.
    Cone {
        /// The direction in the frame of the link, of length 1.
        axis_in_link: Vector,
        /// The direction in the planning frame, of length 1.
        toward: Vector,
        /// Maximum angle, in radians, above 0 and at most π.
        most_rad: f64,
    },
    /// A point of the link stays in a box.
    Box {
        /// The point in the frame of the link, in metres.
        point_in_link: Point,
        /// Pose of the centre of the box in the planning frame.
        world_from_box: Pose,
        /// Half extents of the box, in metres.
        half_m: Vector,
    },
    /// A point of the link stays in a ball.
    Ball {
        /// The point in the frame of the link, in metres.
        point_in_link: Point,
        /// Centre of the ball in the planning frame, in metres.
        center: Point,
        /// Radius of the ball, in metres.
        radius_m: f64,
    },
}

impl ToolRegion {
    /// Returns true for a bound on an angle (rad); other bounds limit a distance (m).
    pub fn is_of_angle(&self) -> bool {
        matches!(self, Self::Cone { .. })
    }

    /// Returns the excess over the bound at this pose of the link in the planning frame (rad or m); negative within it.
    pub fn excess(&self, world_from_link: &Pose) -> f64 {
        match self {
            Self::Cone { axis_in_link, toward, most_rad } => {
                angle_rad(toward, &(world_from_link.rotation * axis_in_link)) - most_rad
            }
            Self::Box { point_in_link, world_from_box, half_m } => {
                let in_box = world_from_box.inverse_transform_point(&(world_from_link * point_in_link));
                (in_box.coords.abs() - half_m).max()
            }
            Self::Ball { point_in_link, center, radius_m } => {
                (world_from_link * point_in_link - center).norm() - radius_m
            }
        }
    }

    /// Returns this region in a new frame, in which its present frame has the pose `new_from_old`.
    #[must_use]
    pub fn in_frame(&self, new_from_old: &Pose) -> Self {
        match self.clone() {
            Self::Cone { axis_in_link, toward, most_rad } => {
                Self::Cone { axis_in_link, toward: new_from_old.rotation * toward, most_rad }
            }
            Self::Box { point_in_link, world_from_box, half_m } => {
                Self::Box { point_in_link, world_from_box: new_from_old * world_from_box, half_m }
            }
            Self::Ball { point_in_link, center, radius_m } => {
                Self::Ball { point_in_link, center: new_from_old * center, radius_m }
            }
        }
    }

    /// Returns the bounded point of the link, in metres; the origin of its frame for a bound on a direction.
    pub(crate) fn point_in_link(&self) -> Point {
        match self {
            Self::Cone { .. } => Point::origin(),
            Self::Box { point_in_link, .. } | Self::Ball { point_in_link, .. } => *point_in_link,
        }
    }
}

impl ToolBound {
    /// Returns this bound in a new frame, as [`ToolRegion::in_frame`].
    #[must_use]
    pub fn in_frame(&self, new_from_old: &Pose) -> Self {
        Self { region: self.region.in_frame(new_from_old), ..self.clone() }
    }

    /// Checks that the bounded link exists and is not a finger, which the hand moves by itself.
    ///
    /// # Errors
    /// [`CollisionError::UnknownLink`] and [`CollisionError::FingerBound`].
    pub(crate) fn check_link(&self, robot: &Robot) -> Result<(), CollisionError> {
        let Some(name) = &self.link else { return Ok(()) };
        match robot.link_index(name) {
            None => Err(CollisionError::UnknownLink { name: name.clone() }),
            Some(link) if robot.finger_of(link).is_some() => {
                Err(CollisionError::FingerBound { name: name.clone() })
            }
            Some(_) => Ok(()),
        }
    }

    /// Checks that the bound is within the allowed ranges.
    ///
    /// # Errors
    /// [`CollisionError::ToolBound`] for directions that are not of length 1, an angle outside (0, π], a size that is not
    /// positive, or lengths beyond [`FARTHEST_M`].
    pub fn check(&self) -> Result<(), CollisionError> {
        let is_unit = |v: &Vector| (v.norm() - 1.0).abs() < 1e-6;
        let is_near = |v: &Vector| v.iter().all(|x| x.abs() <= FARTHEST_M);
        let is_usable = match &self.region {
            ToolRegion::Cone { axis_in_link, toward, most_rad } => {
                is_unit(axis_in_link) && is_unit(toward) && crate::margins::is_tilt(*most_rad)
            }
            ToolRegion::Box { point_in_link, world_from_box, half_m } => {
                let is_pose = is_near(&world_from_box.translation.vector)
                    && world_from_box.rotation.coords.iter().all(|x| x.is_finite());
                is_near(&point_in_link.coords)
                    && is_pose
                    && is_near(half_m)
                    && half_m.iter().all(|x| *x > 0.0)
            }
            ToolRegion::Ball { point_in_link, center, radius_m } => {
                is_near(&point_in_link.coords)
                    && is_near(&center.coords)
                    && *radius_m > 0.0
                    && *radius_m <= FARTHEST_M
            }
        };
        if is_usable { Ok(()) } else { Err(CollisionError::ToolBound { name: self.name.clone() }) }
    }
}

/// Returns the angle between two directions of length 1, in radians.
pub(crate) fn angle_rad(a: &Vector, b: &Vector) -> f64 {
    libm::atan2(a.cross(b).norm(), a.dot(b))
}

/// A bound in the form in which a cell proves it.
#[derive(Clone, Debug)]
pub(crate) struct CellBound {
    pub bound: ToolBound,
    /// Index of the link.
    pub link: usize,
    /// Values of [`Robot::link_arms_m`] of the bounded point, in metres.
    pub arms_m: Vec<f64>,
    /// Bound on the change of the excess per unit of each joint.
    per_joint: Vec<f64>,
}

impl CellBound {
    /// Creates a bound of a link that the robot has.
    pub fn new(mut bound: ToolBound, robot: &Robot) -> Self {
        if let ToolRegion::Cone { axis_in_link, toward, .. } = &mut bound.region {
            *axis_in_link = axis_in_link.normalize();
            *toward = toward.normalize();
        }
        let link = bound.link.as_deref().and_then(|link| robot.link_index(link)).unwrap_or(robot.tip());
        let arms_m = robot.link_arms_m(&robot.frames(), link, &bound.region.point_in_link());
        let mut per_joint = vec![0.0; robot.dof()];
        for (mover, arm_m) in robot.ancestors(link).iter().zip(&arms_m) {
            per_joint[mover.joint] += mover.multiplier.abs()
                * match (bound.region.is_of_angle(), mover.kind) {
                    (true, JointKind::Revolute) => 1.0,
                    (true, JointKind::Prismatic) => 0.0,
                    (false, _) => *arm_m,
                };
        }
        Self { bound, link, arms_m, per_joint }
    }

    /// Returns a bound on the change of the excess where each joint deviates by these amounts (m, rad; one value per joint).
    pub fn stray(&self, joints: &[f64]) -> f64 {
        self.per_joint.iter().zip(joints).map(|(unit, stray)| unit * stray.abs()).sum()
    }
}
