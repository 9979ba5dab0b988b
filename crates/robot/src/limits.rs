use std::collections::BTreeMap;

use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_saphyr::Spanned;

use crate::{Location, RobotError};

/// The limits of a continuous joint are minus and plus this, in radians: one and a half turns either way, so that from
/// any start within a full turn the nearest way to every other angle stays inside, and cables are not wound up for ever.
pub const CONTINUOUS_LIMIT_RAD: f64 = 3.0 * std::f64::consts::PI;

/// What a joint of the group may do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLimits {
    /// Least value, in `unit`.
    pub lower: f64,
    /// Greatest value, in `unit`.
    pub upper: f64,
    /// Greatest speed, in `unit`/s, greater than zero.
    pub velocity: f64,
    /// Greatest acceleration, in `unit`/s², if known.
    pub acceleration: Option<f64>,
    /// Greatest jerk, in `unit`/s³, if known.
    pub jerk: Option<f64>,
    /// What its value is measured in.
    pub unit: JointUnit,
}

impl JointLimits {
    /// Whether `value` lies in [`lower`, `upper`]. A NaN does not.
    pub fn contain(&self, value: f64) -> bool {
        self.lower <= value && value <= self.upper
    }

    /// The value within the limits that is nearest to `value`.
    pub fn clamp(&self, value: f64) -> f64 {
        value.clamp(self.lower, self.upper)
    }
}

/// What the value of a joint is measured in; shown as its symbol.
#[derive(Clone, Copy, Debug, PartialEq, Eq, strum::Display, strum::IntoStaticStr)]
pub enum JointUnit {
    /// A prismatic joint.
    #[strum(to_string = "m")]
    Metre,
    /// A revolute joint.
    #[strum(to_string = "rad")]
    Radian,
}

impl JointUnit {
    /// Its symbol: "m" or "rad".
    pub fn symbol(self) -> &'static str {
        self.into()
    }
}

/// A joint value outside its limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitViolation {
    /// Index of the joint in `q`.
    pub joint: usize,
    /// Its value.
    pub value: f64,
    /// Its lower limit.
    pub lower: f64,
    /// Its upper limit.
    pub upper: f64,
}

/// The figures of a `limits.yaml` for one joint, and where they stand.
pub(crate) struct RateLimits {
    pub(crate) at: Location,
    pub(crate) acceleration: Option<f64>,
    pub(crate) jerk: Option<f64>,
}

/// Reads a `limits.yaml`; `file` is the name for it in errors.
pub(crate) fn parse_rate_limits(text: &str, file: &str) -> Result<BTreeMap<String, RateLimits>, RobotError> {
    let at = |location: serde_saphyr::Location| Location {
        file: file.to_owned(),
        line: u32::try_from(location.line()).unwrap_or(u32::MAX).max(1),
    };
    let parsed: LimitsFile = parse_yaml(text, file)?;
    let mut limits = BTreeMap::new();
    for (joint, entry) in parsed.joints {
        let at = at(entry.referenced);
        for (attribute, value) in [("acceleration", entry.value.acceleration), ("jerk", entry.value.jerk)] {
            match value {
                Some(value) if value.is_nan() || value <= 0.0 || value.is_infinite() => {
                    let element = format!("joint `{joint}`");
                    return Err(RobotError::NotPositive { at, element, attribute, value });
                }
                _ => {}
            }
        }
        let Entry { acceleration, jerk } = entry.value;
        limits.insert(joint, RateLimits { at, acceleration, jerk });
    }
    Ok(limits)
}

/// What stands in a YAML file beside a URDF; `file` is the name for it in errors.
pub(crate) fn parse_yaml<T: DeserializeOwned>(text: &str, file: &str) -> Result<T, RobotError> {
    if text.trim().is_empty() {
        return Err(RobotError::Empty { file: file.to_owned() });
    }
    cranny_file::yaml(text).map_err(|reason| RobotError::Yaml {
        at: Location { file: file.to_owned(), line: u32::try_from(reason.line).unwrap_or(u32::MAX) },
        reason,
    })
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LimitsFile {
    joints: BTreeMap<String, Spanned<Entry>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    acceleration: Option<f64>,
    jerk: Option<f64>,
}
