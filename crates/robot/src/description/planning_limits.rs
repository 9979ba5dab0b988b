use std::collections::BTreeMap;

use serde::Deserialize;
use serde_saphyr::Spanned;

use crate::description::rate_limits::{RateLimits, parse_yaml};
use crate::{Location, RateScales, RobotError};

/// Content of `MoveIt`'s `joint_limits.yaml`, which replaces the limits of the URDF.
#[derive(Default)]
pub(crate) struct PlanningLimits {
    pub(crate) joints: BTreeMap<String, RateLimits>,
    defaults: RateScales,
}

impl PlanningLimits {
    /// Parses the text of a `joint_limits.yaml`; `file` is its name in errors.
    ///
    /// A given limit applies unless its `has_…_limits` is false, as in `MoveIt`; otherwise that of the URDF stays. A
    /// deceleration limit below that of acceleration is used for both.
    ///
    /// # Errors
    /// [`RobotError::Yaml`] for an unknown key; [`RobotError::NotPositive`] and [`RobotError::HandFigure`] for invalid values.
    pub(crate) fn parse(text: &str, file: &str) -> Result<Self, RobotError> {
        let parsed: PlanningFile = parse_yaml(text, file)?;
        let mut limits = Self::default();
        for (joint, entry) in parsed.joint_limits {
            let line = u32::try_from(entry.referenced.line()).unwrap_or(u32::MAX).max(1);
            let at = Location { file: file.to_owned(), line };
            let PlanningEntry { min_position, max_position, max_velocity, max_jerk, .. } = entry.value;
            let counts = |has: Option<bool>, limit: Option<f64>| limit.filter(|_| has != Some(false));
            let entry = &entry.value;
            let deceleration = counts(entry.has_deceleration_limits, entry.max_deceleration).map(f64::abs);
            let acceleration = counts(entry.has_acceleration_limits, entry.max_acceleration);
            let limit = RateLimits {
                at,
                joint: joint.clone(),
                range: [min_position, max_position].map(|limit| counts(entry.has_position_limits, limit)),
                replaces: true,
                velocity: counts(entry.has_velocity_limits, max_velocity),
                acceleration: acceleration.into_iter().chain(deceleration).reduce(f64::min),
                jerk: counts(entry.has_jerk_limits, max_jerk),
            };
            limit.check_rates()?;
            limits.joints.insert(joint, limit);
        }
        let scales = [
            ("default_velocity_scaling_factor", parsed.default_velocity_scaling_factor),
            ("default_acceleration_scaling_factor", parsed.default_acceleration_scaling_factor),
        ];
        for (attribute, value) in scales {
            if let Some(value) = value.filter(|value| !(*value > 0.0 && *value <= 1.0)) {
                let (at, element) = (Location { file: file.to_owned(), line: 1 }, "the file".to_owned());
                let range = "above 0 and at most 1".to_owned();
                return Err(RobotError::HandFigure { at, element, attribute, value, range });
            }
        }
        let [(_, velocity), (_, acceleration)] = scales;
        limits.defaults = RateScales { velocity, acceleration };
        Ok(limits)
    }

    /// Returns the requested scaling factors, or the defaults of the file for those not given.
    pub(crate) fn scales(&self, asked: RateScales) -> RateScales {
        RateScales {
            velocity: asked.velocity.or(self.defaults.velocity),
            acceleration: asked.acceleration.or(self.defaults.acceleration),
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PlanningFile {
    default_velocity_scaling_factor: Option<f64>,
    default_acceleration_scaling_factor: Option<f64>,
    #[serde(default)]
    joint_limits: BTreeMap<String, Spanned<PlanningEntry>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PlanningEntry {
    has_position_limits: Option<bool>,
    min_position: Option<f64>,
    max_position: Option<f64>,
    has_velocity_limits: Option<bool>,
    max_velocity: Option<f64>,
    has_acceleration_limits: Option<bool>,
    max_acceleration: Option<f64>,
    has_deceleration_limits: Option<bool>,
    /// Maximum deceleration; negative in some files.
    max_deceleration: Option<f64>,
    has_jerk_limits: Option<bool>,
    max_jerk: Option<f64>,
    // These limit the drives, not the motion.
    #[serde(rename = "has_effort_limits")]
    _has_effort_limits: Option<bool>,
    #[serde(rename = "max_effort")]
    _max_effort: Option<f64>,
    #[serde(rename = "angle_wraparound")]
    _angle_wraparound: Option<bool>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_counts_unless_it_is_switched_off() {
        let text = "default_velocity_scaling_factor: 0.1
joint_limits:
  a: {has_velocity_limits: false, max_velocity: 0, max_acceleration: 3, max_deceleration: -2}
  b: {min_position: -1, max_velocity: 2, has_jerk_limits: true, max_jerk: 50}
";
        let limits = PlanningLimits::parse(text, "joint_limits.yaml").expect("a good file");
        let (a, b) = (&limits.joints["a"], &limits.joints["b"]);
        assert_eq!((a.velocity, a.acceleration, a.range), (None, Some(2.0), [None, None]));
        assert_eq!((b.velocity, b.jerk, b.range), (Some(2.0), Some(50.0), [Some(-1.0), None]));
        assert_eq!(limits.scales(RateScales::default()).velocity, Some(0.1));
        let asked = RateScales { velocity: Some(0.5), ..RateScales::default() };
        assert_eq!(limits.scales(asked).velocity, Some(0.5));
        for (from, to) in [("max_jerk", "max_jrek"), ("0.1", "1.5"), ("max_velocity: 2", "max_velocity: -2")]
        {
            assert!(PlanningLimits::parse(&text.replace(from, to), "joint_limits.yaml").is_err(), "{to}");
        }
    }
}
