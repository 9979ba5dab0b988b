use cranny_robot::{JointLimits, Robot};
use serde::{Deserialize, Serialize};
use strum::IntoStaticStr;

use crate::PathError;

/// Method of timing a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, IntoStaticStr)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
#[non_exhaustive]
pub enum TimingMethod {
    /// Fastest motion along the path within the limits of velocity and acceleration (TOPP-RA).
    #[default]
    TimeOptimal,
    /// Motion within the limits of jerk too: S-curves along the lines, constant speed in rounded corners.
    JerkLimited,
}

impl TimingMethod {
    /// Returns the name used in files and `--json`.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// Limits of the joints that a [`crate::Trajectory`] keeps. All come from the robot; there are no defaults.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionLimits {
    pub(crate) method: TimingMethod,
    pub(crate) joint_names: Vec<String>,
    /// Velocity limit of each joint, in its unit/s.
    pub(crate) velocity: Vec<f64>,
    /// Acceleration limit of each joint, in its unit/s².
    pub(crate) acceleration: Vec<f64>,
    /// Jerk limit of each joint, in its unit/s³; empty if jerk is not limited.
    pub(crate) jerk: Vec<f64>,
}

/// Share of every limit that trajectories use. The rest, a millionth, covers rounding in finite differences of sampled
/// positions: at 1 kHz the third difference of values around 3 errs by 3e-6.
const LIMIT_USE: f64 = 1.0 - 1e-6;

impl MotionLimits {
    /// Returns the limits of `robot` that `method` needs.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn of(robot: &Robot, method: TimingMethod) -> Result<Self, PathError> {
        Self::new(robot.joint_names(), robot.limits(), method)
    }

    /// Returns the limits of `robot` including jerk if it states them for all joints, else those of velocity and acceleration.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn smoothest(robot: &Robot) -> Result<Self, PathError> {
        Self::of(robot, TimingMethod::JerkLimited).or_else(|_| Self::of(robot, TimingMethod::TimeOptimal))
    }

    /// Creates the limits of the named joints, one entry for each.
    ///
    /// # Errors
    /// [`PathError::MissingLimit`] for a joint without a limit that `method` needs, [`PathError::Limit`] for one that is not
    /// positive and finite, [`TaskError::JointCount`](cranny_task::TaskError::JointCount) if the counts differ.
    pub fn new(
        joint_names: &[String],
        limits: &[JointLimits],
        method: TimingMethod,
    ) -> Result<Self, PathError> {
        if joint_names.len() != limits.len() {
            let (expected, actual) = (joint_names.len(), limits.len());
            return Err(cranny_task::TaskError::JointCount { what: "limit", expected, actual }.into());
        }
        let each = |quantity: &'static str, limit: &dyn Fn(&JointLimits) -> Option<f64>| {
            let of_joint = |(limits, joint): (&JointLimits, &String)| match limit(limits) {
                None => Err(PathError::MissingLimit { joint: joint.clone(), quantity }),
                Some(value) if value > 0.0 && value.is_finite() => Ok(value * LIMIT_USE),
                Some(value) => Err(PathError::Limit { joint: joint.clone(), quantity, value }),
            };
            limits.iter().zip(joint_names).map(of_joint).collect::<Result<Vec<f64>, PathError>>()
        };
        Ok(Self {
            method,
            joint_names: joint_names.to_vec(),
            velocity: each("velocity", &|l| Some(l.velocity))?,
            acceleration: each("acceleration", &|l| l.acceleration)?,
            jerk: match method {
                TimingMethod::TimeOptimal => Vec::new(),
                TimingMethod::JerkLimited => each("jerk", &|l| l.jerk)?,
            },
        })
    }

    /// Returns the method of timing a path.
    pub fn method(&self) -> TimingMethod {
        self.method
    }
}

#[cfg(test)]
mod tests {
    use cranny_robot::JointUnit;

    use super::*;

    fn joint(velocity: f64, acceleration: Option<f64>, jerk: Option<f64>) -> JointLimits {
        JointLimits { lower: -1.0, upper: 1.0, velocity, acceleration, jerk, unit: JointUnit::Radian }
    }

    #[test]
    fn a_missing_limit_is_refused_by_joint_and_file() {
        let names = ["shoulder".to_owned(), "elbow".to_owned()];
        let refusal = |limits: &[JointLimits], method| {
            MotionLimits::new(&names, limits, method).expect_err("refused").to_string()
        };
        let whole = joint(1.0, Some(1.0), Some(1.0));
        let without_acceleration = refusal(&[whole, joint(1.0, None, None)], TimingMethod::TimeOptimal);
        for word in ["'elbow'", "acceleration", "limits.yaml"] {
            assert!(without_acceleration.contains(word), "{without_acceleration}");
        }
        let smooth = [whole, joint(1.0, Some(1.0), None)];
        assert!(MotionLimits::new(&names, &smooth, TimingMethod::TimeOptimal).is_ok());
        assert!(refusal(&smooth, TimingMethod::JerkLimited).contains("no jerk limit"));
        assert!(refusal(&[whole], TimingMethod::TimeOptimal).contains("1 value,"));
        for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let text = refusal(&[joint(value, Some(1.0), None), whole], TimingMethod::TimeOptimal);
            assert!(text.contains("'shoulder'") && text.contains("velocity"), "{text}");
        }
    }
}
