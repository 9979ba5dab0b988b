use cranny_spatial::{Pose, Vector};

use crate::chain::limits::CONTINUOUS_LIMIT_RAD;
use crate::description::inertial::Inertial;
use crate::description::visual::{LinkForm, LinkVisual};
use crate::description::xml::Element;
use crate::error::RobotError;
use crate::location::Location;

/// Content of a URDF, checked element by element; `tree` checks that its links form a tree.
pub(crate) struct Urdf {
    pub(crate) name: String,
    pub(crate) file: String,
    pub(crate) links: Vec<UrdfLink>,
    pub(crate) joints: Vec<UrdfJoint>,
    /// Notes on content that was not read and affects neither geometry nor motion, one line for each kind.
    pub(crate) notes: Vec<String>,
}

pub(crate) struct UrdfLink {
    pub(crate) name: String,
    pub(crate) at: Location,
    pub(crate) collisions: Vec<UrdfCollision>,
    /// Visuals of the link; their mesh files are not resolved yet.
    pub(crate) visuals: Vec<LinkVisual>,
    pub(crate) inertial: Option<Inertial>,
}

pub(crate) struct UrdfCollision {
    pub(crate) at: Location,
    pub(crate) link_from_shape: Pose,
    pub(crate) form: LinkForm,
}

pub(crate) struct UrdfJoint {
    pub(crate) name: String,
    pub(crate) at: Location,
    pub(crate) parent: String,
    pub(crate) child: String,
    pub(crate) parent_from_joint: Pose,
    /// Motion of the joint; `None` for a fixed one.
    pub(crate) motion: Option<UrdfMotion>,
}

pub(crate) struct UrdfMotion {
    pub(crate) kind: UrdfJointKind,
    /// Axis of the joint, a unit vector.
    pub(crate) axis_in_child: Vector,
    pub(crate) limits: UrdfLimits,
    pub(crate) mimic: Option<UrdfMimic>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum UrdfJointKind {
    Revolute,
    Continuous,
    Prismatic,
}

pub(crate) struct UrdfLimits {
    pub(crate) lower: f64,
    pub(crate) upper: f64,
    pub(crate) velocity: Option<f64>,
    pub(crate) effort: Option<f64>,
    pub(crate) acceleration: Option<f64>,
    pub(crate) jerk: Option<f64>,
}

impl UrdfLimits {
    /// Returns the limits of a continuous joint without further data.
    pub(crate) fn of_continuous() -> Self {
        Self {
            lower: -CONTINUOUS_LIMIT_RAD,
            upper: CONTINUOUS_LIMIT_RAD,
            velocity: None,
            effort: None,
            acceleration: None,
            jerk: None,
        }
    }
}

/// Mimicry: joint value `multiplier · value of the master + offset`.
pub(crate) struct UrdfMimic {
    pub(crate) master: String,
    pub(crate) multiplier: f64,
    pub(crate) offset: f64,
}

pub(crate) fn parse_limits(
    element: Element<'_>,
    kind: UrdfJointKind,
    joint: &str,
) -> Result<UrdfLimits, RobotError> {
    let optional =
        |attribute| element.optional_text(attribute).map(|_| element.positive(attribute)).transpose();
    let velocity = element.optional_text("velocity").map(|_| element.number("velocity")).transpose()?;
    // Many files have a zero for an unknown effort.
    let effort = element.positive("effort").ok();
    let (faster, slower) = (optional("acceleration")?, optional("deceleration")?);
    let (foreign, jerk) = (optional("drake:acceleration")?, optional("jerk")?);
    // One value applies to both directions: the smallest.
    let acceleration = [faster, slower, foreign].into_iter().flatten().reduce(f64::min);
    let limits = UrdfLimits { velocity, effort, acceleration, jerk, ..UrdfLimits::of_continuous() };
    if kind == UrdfJointKind::Continuous {
        return Ok(limits);
    }
    // Both limits default to zero (URDF specification).
    let (lower, upper) = (element.number_or("lower", 0.0)?, element.number_or("upper", 0.0)?);
    if lower > upper {
        let (at, joint) = (element.at(), joint.to_owned());
        return Err(RobotError::LimitsReversed { at, joint, lower, upper });
    }
    Ok(UrdfLimits { lower, upper, ..limits })
}
