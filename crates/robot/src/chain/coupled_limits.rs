use crate::chain::joint_group::{Resolved, range};
use crate::chain::limits::CONTINUOUS_LIMIT_RAD;
use crate::description::urdf_model::{Urdf, UrdfJoint, UrdfJointKind};
use crate::error::RobotError;
use crate::{JointLimits, JointUnit, RateScales};

/// Returns, for each joint of the group, the limits within which it and all joints that mimic it keep their own.
///
/// A joint with `value = multiplier · q + offset` keeps [lower, upper] where q is between `(lower − offset) / multiplier` and
/// `(upper − offset) / multiplier`, and a rate (velocity, acceleration, jerk) where that of q is at most the rate divided by
/// |multiplier|. A continuous joint has no range of its own unless `limits.yaml` gives it one.
///
/// # Errors
/// Errors in the limits of a joint; [`RobotError::CoupledLimits`] if two coupled joints cannot both stay within their limits.
pub(crate) fn coupled_limits(
    urdf: &Urdf,
    resolved: &Resolved,
    scales: RateScales,
) -> Result<Vec<JointLimits>, RobotError> {
    let mut limits = Vec::with_capacity(resolved.group.len());
    for (index, &member) in resolved.group.iter().enumerate() {
        let master = &urdf.joints[member];
        let mut own = joint_limits(master, scales)?;
        for (joint, value) in urdf.joints.iter().zip(&resolved.values) {
            let Some((_, multiplier)) = value.follows.filter(|(followed, _)| *followed == index) else {
                continue;
            };
            if joint.name == master.name {
                continue;
            }
            narrow(&mut own, joint, (multiplier, value.offset), scales);
            if own.lower > own.upper || (own.lower >= own.upper && is_movable(master)) {
                return Err(RobotError::CoupledLimits {
                    at: joint.at.clone(),
                    joint: joint.name.clone(),
                    master: master.name.clone(),
                });
            }
        }
        limits.push(own);
    }
    Ok(limits)
}

fn is_movable(joint: &UrdfJoint) -> bool {
    joint.motion.as_ref().map(range).is_some_and(|(lower, upper)| lower < upper)
}

/// Narrows the limits of a joint to those that a joint mimicking it with `(multiplier, offset)` allows.
fn narrow(limits: &mut JointLimits, mimic: &UrdfJoint, (multiplier, offset): (f64, f64), scales: RateScales) {
    let Some(motion) = &mimic.motion else { return };
    let (lower, upper) = range(motion);
    let is_endless = motion.kind == UrdfJointKind::Continuous
        && (lower, upper) == (-CONTINUOUS_LIMIT_RAD, CONTINUOUS_LIMIT_RAD);
    if !is_endless {
        let ends = [lower, upper].map(|end| (end - offset) / multiplier);
        limits.lower = limits.lower.max(ends[0].min(ends[1]));
        limits.upper = limits.upper.min(ends[0].max(ends[1]));
    }
    let slower = |known: Option<f64>, own: Option<f64>| {
        known.into_iter().chain(own.map(|rate| rate / multiplier.abs())).reduce(f64::min)
    };
    // A velocity limit of 0 is a placeholder for an unknown one in many files; it is ignored.
    let own_velocity = motion.limits.velocity.filter(|velocity| *velocity > 0.0);
    let own_velocity = scaled(own_velocity, scales.velocity);
    limits.velocity = slower(Some(limits.velocity), own_velocity).unwrap_or(limits.velocity);
    limits.acceleration =
        slower(limits.acceleration, scaled(motion.limits.acceleration, scales.acceleration));
    limits.jerk = slower(limits.jerk, motion.limits.jerk);
}

fn scaled(rate: Option<f64>, share: Option<f64>) -> Option<f64> {
    rate.map(|rate| rate * share.unwrap_or(1.0))
}

fn joint_limits(joint: &UrdfJoint, scales: RateScales) -> Result<JointLimits, RobotError> {
    let missing = || RobotError::MissingVelocity { at: joint.at.clone(), joint: joint.name.clone() };
    let motion = joint.motion.as_ref().ok_or_else(missing)?;
    let velocity = motion.limits.velocity.ok_or_else(missing)?;
    if velocity <= 0.0 {
        return Err(RobotError::NotPositive {
            at: joint.at.clone(),
            element: format!("joint `{}`", joint.name),
            attribute: "velocity",
            value: velocity,
        });
    }
    let (lower, upper) = range(motion);
    let unit = match motion.kind {
        UrdfJointKind::Prismatic => JointUnit::Metre,
        UrdfJointKind::Revolute | UrdfJointKind::Continuous => JointUnit::Radian,
    };
    let velocity = velocity * scales.velocity.unwrap_or(1.0);
    let acceleration = scaled(motion.limits.acceleration, scales.acceleration);
    let jerk = motion.limits.jerk;
    Ok(JointLimits { lower, upper, velocity, acceleration, jerk, unit })
}

#[cfg(test)]
mod tests {
    use crate::{JointLimits, Robot, RobotError, RobotOptions, TextSource};

    /// Returns the limits of a two-stage lift, the lower stage driven by the upper, with own limits 0 to 0.25 m and 0.1 m/s.
    fn lift(mimic: &str, kind: &str) -> Result<JointLimits, RobotError> {
        let urdf = format!(
            r#"<robot name="lift"><link name="a"/><link name="b"/><link name="c"/>
<joint name="upper" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
  <limit lower="-0.4" upper="0.4" velocity="0.2" effort="1"/></joint>
<joint name="lower" type="{kind}"><parent link="b"/><child link="c"/><axis xyz="0 0 1"/>
  <limit lower="0" upper="0.25" velocity="0.1" effort="1"/><mimic joint="upper" {mimic}/></joint></robot>"#
        );
        let limits = "joints: {upper: {acceleration: 0.6, jerk: 50}, lower: {acceleration: 0.5}}";
        let limits = Some(TextSource::Text { name: "limits.yaml".to_owned(), text: limits.to_owned() });
        let options = RobotOptions { limits, ..RobotOptions::default() };
        Robot::from_urdf_text(&urdf, "lift.urdf", None, &options).map(|robot| robot.limits()[0])
    }

    #[test]
    fn a_joint_keeps_the_limits_of_those_that_mimic_it() {
        for (mimic, [lower, upper], rate) in [
            (r#"multiplier="1.5""#, [0.0, 0.25 / 1.5], 1.5),
            (r#"multiplier="-1""#, [-0.25, 0.0], 1.0),
            (r#"multiplier="0.5" offset="0.1""#, [-0.2, 0.3], 0.5),
            (r#"multiplier="-2" offset="0.2""#, [-0.025, 0.1], 2.0),
            (r#"multiplier="0""#, [-0.4, 0.4], 0.0),
        ] {
            let found = lift(mimic, "prismatic").expect("limits");
            assert!((found.lower - lower).abs() < 1e-15 && (found.upper - upper).abs() < 1e-15, "{found:?}");
            assert!((found.velocity - 0.2_f64.min(0.1 / rate)).abs() < 1e-15, "{found:?}");
            assert!((found.acceleration.unwrap() - 0.6_f64.min(0.5 / rate)).abs() < 1e-15, "{found:?}");
            assert_eq!(found.jerk, Some(50.0));
        }
        // An endless joint has no range to keep, but a velocity limit.
        let endless = lift(r#"multiplier="3""#, "continuous").expect("limits");
        assert_eq!((endless.lower, endless.upper), (-0.4, 0.4));
        assert!((endless.velocity - 0.1 / 3.0).abs() < 1e-15);
    }

    #[test]
    fn two_joints_that_cannot_both_keep_their_limits_are_refused_by_name() {
        for offset in ["3", "0.65"] {
            let fault = lift(&format!(r#"multiplier="1" offset="{offset}""#), "prismatic").expect_err("none");
            let fault = fault.to_string();
            assert!(fault.contains("`lower`") && fault.contains("`upper`"), "{fault}");
        }
    }
}
