//! Conversions between the types of `parry` and those of this project.

use cranny_spatial::{Point, Pose, Vector};
use parry3d_f64::math::{Pose as ParryPose, Rotation as ParryRotation, Vector as ParryVector};

pub(crate) fn vector(v: &Vector) -> ParryVector {
    ParryVector::new(v.x, v.y, v.z)
}

pub(crate) fn point(p: &Point) -> ParryVector {
    ParryVector::new(p.x, p.y, p.z)
}

pub(crate) fn to_vector(v: ParryVector) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

pub(crate) fn pose(pose: &Pose) -> ParryPose {
    let q = pose.rotation.coords;
    ParryPose {
        rotation: ParryRotation::from_xyzw(q.x, q.y, q.z, q.w),
        translation: vector(&pose.translation.vector),
    }
}
