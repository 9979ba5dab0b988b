use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_saphyr::Spanned;

use crate::description::urdf_model::{UrdfJoint, UrdfJointKind, UrdfLimits};
use crate::error::RobotError;
use crate::joint_constraint::JointConstraint;
use crate::location::Location;

/// Limits of one joint from a `limits.yaml`, and their location in the file.
pub(crate) struct RateLimits {
    pub(crate) at: Location,
    pub(crate) joint: String,
    pub(crate) range: [Option<f64>; 2],
    /// True if the range may exceed that of the URDF.
    pub(crate) replaces: bool,
    pub(crate) velocity: Option<f64>,
    pub(crate) acceleration: Option<f64>,
    pub(crate) jerk: Option<f64>,
}

impl RateLimits {
    pub(crate) fn at(&self) -> &Location {
        &self.at
    }

    /// Checks that the velocity, acceleration and jerk limits are positive and finite.
    pub(crate) fn check_rates(&self) -> Result<(), RobotError> {
        for (attribute, value) in
            [("velocity", self.velocity), ("acceleration", self.acceleration), ("jerk", self.jerk)]
        {
            if let Some(value) = value.filter(|value| !(*value > 0.0 && value.is_finite())) {
                let (at, element) = (self.at.clone(), format!("joint `{}`", self.joint));
                return Err(RobotError::NotPositive { at, element, attribute, value });
            }
        }
        Ok(())
    }

    /// Applies the range and the rates to `joint`. A continuous joint accepts any range; the range of another joint can only
    /// become narrower, unless this one [replaces](Self::replaces) it.
    pub(crate) fn narrow(&self, joint: &mut UrdfJoint) -> Result<(), RobotError> {
        let given = self.range.iter().chain([&self.velocity]).flatten().next();
        let Some(motion) = &mut joint.motion else {
            let Some(_) = given else { return Ok(()) };
            let (at, joint) = (self.at.clone(), self.joint.clone());
            return Err(RobotError::NotFree {
                at,
                joint,
                wanted: "limited",
                constraint: JointConstraint::Fixed,
            });
        };
        let limits = &mut motion.limits;
        let widest = match motion.kind {
            _ if self.replaces => (f64::MIN, f64::MAX),
            UrdfJointKind::Continuous => (f64::MIN, f64::MAX),
            _ => (limits.lower, limits.upper),
        };
        for (attribute, value) in [("lower", self.range[0]), ("upper", self.range[1])] {
            if let Some(value) = value.filter(|value| !(widest.0..=widest.1).contains(value)) {
                let (at, element) = (self.at.clone(), format!("joint `{}`", self.joint));
                let range = match motion.kind {
                    _ if self.replaces => "a number".to_owned(),
                    UrdfJointKind::Continuous => "a number".to_owned(),
                    _ => format!("between {} and {}, the limits in the URDF", widest.0, widest.1),
                };
                return Err(RobotError::HandFigure { at, element, attribute, value, range });
            }
        }
        limits.lower = self.range[0].unwrap_or(limits.lower);
        limits.upper = self.range[1].unwrap_or(limits.upper);
        if limits.lower > limits.upper {
            let (at, joint) = (self.at.clone(), self.joint.clone());
            let (lower, upper) = (limits.lower, limits.upper);
            return Err(RobotError::LimitsReversed { at, joint, lower, upper });
        }
        self.set_rates(limits);
        Ok(())
    }

    /// Sets the limits of velocity, acceleration and jerk that are given.
    pub(crate) fn set_rates(&self, limits: &mut UrdfLimits) {
        limits.velocity = self.velocity.or(limits.velocity);
        limits.acceleration = self.acceleration.or(limits.acceleration);
        limits.jerk = self.jerk.or(limits.jerk);
    }
}

/// Parses a `limits.yaml`; `file` is its name in errors.
pub(crate) fn parse_rate_limits(text: &str, file: &str) -> Result<BTreeMap<String, RateLimits>, RobotError> {
    let at = |location: serde_saphyr::Location| Location {
        file: file.to_owned(),
        line: u32::try_from(location.line()).unwrap_or(u32::MAX).max(1),
    };
    let parsed: LimitsFile = parse_yaml(text, file)?;
    let mut limits = BTreeMap::new();
    for (joint, entry) in parsed.joints {
        let at = at(entry.referenced);
        let Entry { lower, upper, velocity, acceleration, jerk } = entry.value;
        let limit = RateLimits {
            at,
            joint: joint.clone(),
            range: [lower, upper],
            replaces: false,
            velocity,
            acceleration,
            jerk,
        };
        limit.check_rates()?;
        limits.insert(joint, limit);
    }
    Ok(limits)
}

/// Parses the text of a YAML file beside a URDF; `file` is its name in errors.
pub(crate) fn parse_yaml<T: DeserializeOwned>(text: &str, file: &str) -> Result<T, RobotError> {
    if text.trim().is_empty() {
        return Err(RobotError::Empty { file: file.to_owned() });
    }
    cranny_file::yaml(text).map_err(|reason| RobotError::Yaml {
        at: Location { file: file.to_owned(), line: u32::try_from(reason.line).unwrap_or(u32::MAX) },
        reason,
    })
}

/// Content of a `limits.yaml`.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LimitsFile {
    /// Limits by joint name, in metres, radians and seconds.
    #[schemars(with = "BTreeMap<String, Entry>")]
    joints: BTreeMap<String, Spanned<Entry>>,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Entry {
    /// Minimum value, within the range of the URDF.
    lower: Option<f64>,
    /// Maximum value, within the range of the URDF.
    upper: Option<f64>,
    /// Maximum speed, which replaces that of the URDF; positive.
    velocity: Option<f64>,
    /// Maximum acceleration; positive.
    acceleration: Option<f64>,
    /// Maximum jerk; positive.
    jerk: Option<f64>,
}
