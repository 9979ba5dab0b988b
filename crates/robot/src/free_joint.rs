use std::f64::consts::PI;

use cranny_spatial::{Pose, Rotation, Vector};

use crate::description::urdf_model::{
    Urdf, UrdfJoint, UrdfJointKind, UrdfLimits, UrdfLink, UrdfMotion, parse_limits,
};
use crate::description::xml::Element;
use crate::{FREE_JOINT_LIMIT_M, RobotError};

/// One degree of freedom of a joint that has several: suffix of the joint name, kind of motion, and its axis in the joint
/// frame.
pub(crate) type Freedom = (&'static str, UrdfJointKind, fn() -> Vector);

/// Planar joint: translations along two axes of the plane, then a rotation about its normal, named as in `MoveIt`.
pub(crate) const PLANAR: [Freedom; 3] = [
    ("x", UrdfJointKind::Prismatic, Vector::x),
    ("y", UrdfJointKind::Prismatic, Vector::y),
    ("theta", UrdfJointKind::Continuous, Vector::z),
];

/// Floating joint: position, then yaw, pitch and roll. The pitch is limited to ±π/2, where yaw and roll have the same axis.
pub(crate) const FLOATING: [Freedom; 6] = [
    ("x", UrdfJointKind::Prismatic, Vector::x),
    ("y", UrdfJointKind::Prismatic, Vector::y),
    ("z", UrdfJointKind::Prismatic, Vector::z),
    ("yaw", UrdfJointKind::Continuous, Vector::z),
    ("pitch", UrdfJointKind::Revolute, Vector::y),
    ("roll", UrdfJointKind::Continuous, Vector::x),
];

impl Urdf {
    /// Adds a joint of several degrees of freedom as a chain of joints with one each, `NAME/x`, …, with bare links of the same
    /// names between them. The normal of a plane is the joint's axis, or z if none is given: files without an axis do not mean
    /// the x axis, the default of the URDF specification.
    pub(crate) fn add_free_joint(
        &mut self,
        element: Element<'_>,
        freedoms: &[Freedom],
    ) -> Result<(), RobotError> {
        let name = element.text("name")?;
        let owner = format!("joint `{name}`");
        let end = |tag| Ok::<_, RobotError>(element.needed(tag, &owner)?.text("link")?.to_owned());
        let (mut parent, child) = (end("parent")?, end("child")?);
        let is_planar = freedoms.len() == PLANAR.len();
        let axis = match is_planar.then(|| element.first("axis")).flatten() {
            Some(axis) => axis.vector("xyz")?.unwrap_or_else(Vector::z),
            None => Vector::z(),
        };
        let zero_axis = || RobotError::ZeroAxis { at: element.at(), joint: name.to_owned() };
        let axis = axis.try_normalize(1e-9).ok_or_else(zero_axis)?;
        // An axis opposite to z has no unique shortest rotation; this one turns about x.
        let joint_from_plane = Rotation::rotation_between(&Vector::z(), &axis)
            .unwrap_or_else(|| Rotation::from_axis_angle(&Vector::x_axis(), PI));
        let limit = element.first("limit");
        for (index, (suffix, kind, axis)) in freedoms.iter().enumerate() {
            let joint_name = format!("{name}/{suffix}");
            let rates =
                limit.map(|limit| parse_limits(limit, UrdfJointKind::Continuous, name)).transpose()?;
            let mut limits = rates.unwrap_or_else(UrdfLimits::of_continuous);
            limits.effort = None;
            match kind {
                UrdfJointKind::Prismatic => {
                    (limits.lower, limits.upper) = (-FREE_JOINT_LIMIT_M, FREE_JOINT_LIMIT_M);
                    if let Some(limit) = limit {
                        let own = parse_limits(limit, *kind, &joint_name)?;
                        // A `limit` without a range gives only the velocity.
                        if own.lower < own.upper {
                            (limits.lower, limits.upper) = (own.lower, own.upper);
                        }
                    }
                }
                UrdfJointKind::Revolute => (limits.lower, limits.upper) = (-0.5 * PI, 0.5 * PI),
                UrdfJointKind::Continuous => {}
            }
            let is_last = index + 1 == freedoms.len();
            let below = if is_last { child.clone() } else { joint_name.clone() };
            if !is_last {
                self.links.push(UrdfLink::bare(below.clone(), element.at()));
            }
            let parent_from_joint = if index == 0 { element.origin()? } else { Pose::identity() };
            let axis_in_child = joint_from_plane * axis();
            self.joints.push(UrdfJoint {
                name: joint_name,
                at: element.at(),
                parent: std::mem::replace(&mut parent, below.clone()),
                child: below,
                parent_from_joint,
                motion: Some(UrdfMotion { kind: *kind, axis_in_child, limits, mimic: None }),
            });
        }
        Ok(())
    }
}
