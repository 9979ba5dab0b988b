use std::f64::consts::TAU;

use crate::chain::limits::wrapped;
use crate::description::urdf_model::{UrdfJoint, UrdfJointKind};
use crate::{JointKind, JointLimits, Mover, Robot};

impl Robot {
    /// Turns joints of `q` (m, rad; one per joint) by whole turns, within their limits, to the values nearest to `reference`;
    /// all links keep their poses. Joints without a full turn keep their values. Returns true if any joint was turned.
    ///
    /// # Panics
    /// If either does not have one value per joint.
    pub fn turn_towards(&self, reference: &[f64], q: &mut [f64]) -> bool {
        assert!(
            reference.len() == self.dof() && q.len() == self.dof(),
            "one value for each joint of the group"
        );
        let mut is_turned = false;
        for (joint, value) in q.iter_mut().enumerate().filter(|(joint, _)| self.full_turns[*joint]) {
            let turned = nearest_turn(*value, reference[joint], &self.limits[joint]);
            is_turned |= (turned - *value).abs() > 0.0;
            *value = turned;
        }
        is_turned
    }

    /// Turns endless joints of `q` (m, rad; one per joint) that are outside their limits by whole turns to values within them,
    /// as near to the middle of the limits as possible. Other joints keep their values.
    ///
    /// # Panics
    /// If `q` does not have one value per joint.
    pub fn turn_into_limits(&self, q: &mut [f64]) {
        assert_eq!(q.len(), self.dof(), "one value for each joint of the group");
        for (joint, value) in q.iter_mut().enumerate() {
            let limits = &self.limits[joint];
            if self.endless[joint] && !limits.contain(*value) {
                *value = nearest_turn(*value, 0.5 * (limits.lower + limits.upper), limits);
            }
        }
    }

    /// Turns endless joints of `q` (m, rad; one per joint) by whole turns, within their limits, to the values nearest to
    /// `reference`; values that differ by whole turns are equivalent for such a joint, even if links that follow it move.
    /// Other joints, and values that no number of turns brings within the limits, stay unchanged.
    ///
    /// # Panics
    /// If either does not have one value per joint.
    pub fn wrap_towards(&self, reference: &[f64], q: &mut [f64]) {
        assert!(
            reference.len() == self.dof() && q.len() == self.dof(),
            "one value for each joint of the group"
        );
        for (joint, value) in q.iter_mut().enumerate().filter(|(joint, _)| self.endless[*joint]) {
            *value = nearest_turn(*value, reference[joint], &self.limits[joint]);
        }
    }

    /// Returns the absolute difference of two values of a joint; modulo whole turns for an endless joint.
    ///
    /// # Panics
    /// If there is no such joint.
    pub fn joint_difference(&self, joint: usize, a: f64, b: f64) -> f64 {
        let off = (a - b).abs();
        if self.endless[joint] { (off - TAU * (off / TAU).round()).abs() } else { off }
    }

    /// Returns the largest unnecessary rotation of a joint along a path of way points (m, rad; one value per joint), in
    /// radians: the distance that the joint travels, less the distance from its start to the nearest equivalent end value
    /// within its limits. Only joints with a full turn count.
    ///
    /// # Panics
    /// If a way point does not have one value per joint.
    pub fn needless_turn(&self, path: &[Vec<f64>]) -> f64 {
        let (Some(start), Some(end)) = (path.first(), path.last()) else { return 0.0 };
        let mut end = end.clone();
        self.turn_towards(start, &mut end);
        let beyond_need = |joint: usize| {
            let travelled: f64 = path.windows(2).map(|edge| (edge[1][joint] - edge[0][joint]).abs()).sum();
            travelled - (end[joint] - start[joint]).abs()
        };
        (0..self.dof()).filter(|joint| self.full_turns[*joint]).map(beyond_need).fold(0.0, f64::max)
    }
}

/// Returns, per joint of the group, true if a full turn leaves the poses of all links unchanged: it turns, its range is at
/// least 2π, and every joint that mimics it has an integer multiplier.
pub(crate) fn full_turns(limits: &[JointLimits], movers: &[Vec<Mover>]) -> Vec<bool> {
    let keeps_its_place = |joint: usize| {
        let moved = movers.iter().flatten().filter(|mover| mover.joint == joint);
        moved.fold(true, |all, mover| {
            all && mover.kind == JointKind::Revolute && mover.multiplier.fract().abs() <= 0.0
        })
    };
    let has_range = |limits: &JointLimits| limits.upper - limits.lower >= TAU;
    limits.iter().enumerate().map(|(joint, limits)| has_range(limits) && keeps_its_place(joint)).collect()
}

/// Returns, per joint of the group, true if the URDF declares it `continuous` and it has a full turn.
pub(crate) fn endless<'a>(kinds: impl Iterator<Item = &'a UrdfJoint>, full_turns: &[bool]) -> Vec<bool> {
    let is_endless = |joint: &UrdfJoint| {
        joint.motion.as_ref().is_some_and(|motion| motion.kind == UrdfJointKind::Continuous)
    };
    kinds.zip(full_turns).map(|(joint, has_turn)| *has_turn && is_endless(joint)).collect()
}

/// Returns `value` plus whole turns, within the limits and as near to `reference` as possible; `value` if none is within.
fn nearest_turn(value: f64, reference: f64, limits: &JointLimits) -> f64 {
    wrapped(value, reference, [limits.lower, limits.upper]).unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::{JointUnit, RobotOptions};

    fn limits(lower: f64, upper: f64) -> JointLimits {
        JointLimits { lower, upper, velocity: 1.0, acceleration: None, jerk: None, unit: JointUnit::Radian }
    }

    #[test]
    fn the_nearest_turn_is_within_the_limits() {
        let limits = limits(-TAU, TAU);
        for (value, reference, expected) in [
            (5.94, 0.0, 5.94 - TAU),
            (-5.0, 0.5, TAU - 5.0),
            (0.3, 0.0, 0.3),
            (3.0, -3.0, 3.0 - TAU),
            // Another turn would be nearer, but beyond the limit.
            (0.5, 6.2, 0.5),
            (0.5, -6.2, 0.5 - TAU),
        ] {
            assert!(
                (nearest_turn(value, reference, &limits) - expected).abs() < 1e-12,
                "{value} {reference}"
            );
        }
    }

    #[test]
    fn a_value_is_turned_into_its_limits_or_stays() {
        for (value, lower, upper, expected) in [
            (37.7, -3.0 * PI, 3.0 * PI, Some(37.7 - 6.0 * TAU)),
            (-15.0, -3.0 * PI, 3.0 * PI, Some(-15.0 + 2.0 * TAU)),
            (TAU + 0.5, -1.0, 1.0, Some(0.5)),
            (2.0, -1.0, 1.0, None),
            (f64::INFINITY, -1.0, 1.0, None),
        ] {
            let turned = wrapped(value, 0.5 * (lower + upper), [lower, upper]);
            let is_same = turned == expected
                || turned.zip(expected).is_some_and(|(turned, expected)| (turned - expected).abs() < 1e-12);
            assert!(is_same, "{value}: {turned:?}");
        }
    }

    #[test]
    fn a_needless_turn_is_what_a_path_travels_beyond_the_nearest_end() {
        let urdf = r#"<robot name="t"><link name="a"/><link name="b"/><link name="c"/>
<joint name="turning" type="continuous"><parent link="a"/><child link="b"/><limit velocity="1" effort="1"/></joint>
<joint name="sliding" type="prismatic"><parent link="b"/><child link="c"/><limit lower="-9" upper="9" velocity="1" effort="1"/></joint>
</robot>"#;
        let robot =
            Robot::from_urdf_text(urdf, "t.urdf", None, &RobotOptions::default()).expect("a good URDF");
        let turn = |values: &[f64]| {
            robot.needless_turn(&values.iter().map(|value| vec![*value, 2.0 * value]).collect::<Vec<_>>())
        };
        for (values, expected) in
            [(&[][..], 0.0), (&[0.5, 1.0, 2.0], 0.0), (&[0.0, -0.5, 1.0], 1.0), (&[0.0, 1.5 * PI], PI)]
        {
            assert!((turn(values) - expected).abs() < 1e-12, "{values:?}: {}", turn(values));
        }
    }

    #[test]
    fn a_joint_without_an_end_is_wrapped_wherever_it_stands() {
        let robot = |kind: &str| {
            let urdf = format!(
                r#"<robot name="r"><link name="a"/><link name="b"/>
<joint name="j" type="{kind}"><parent link="a"/><child link="b"/><limit lower="-5" upper="5" velocity="1" effort="1"/></joint></robot>"#
            );
            Robot::from_urdf_text(&urdf, "r.urdf", None, &RobotOptions::default()).expect("a good URDF")
        };
        let wrap = |kind, value: f64, reference: f64| {
            let mut q = [value];
            robot(kind).wrap_towards(&[reference], &mut q);
            q[0]
        };
        for (value, reference, expected) in [
            (-3.0, 3.0, TAU - 3.0),
            (37.7, 0.0, 37.7 - 6.0 * TAU),
            (15.0, 0.1, 15.0 - 2.0 * TAU),
            (-9.0, 9.0, 2.0 * TAU - 9.0),
            (1e4, 0.0, 1e4 - TAU * (1e4 / TAU).round()),
            (0.5, 0.0, 0.5),
        ] {
            let found = wrap("continuous", value, reference);
            assert!((found - expected).abs() < 1e-9, "{value} from {reference}: {found}");
            assert_eq!(wrap("revolute", value, reference).to_bits(), value.to_bits());
        }
        assert!(robot("continuous").joint_difference(0, 3.0, 3.0 - TAU) < 1e-12);
        assert!((robot("revolute").joint_difference(0, 3.0, 3.0 - TAU) - TAU).abs() < 1e-12);
    }

    #[test]
    fn a_joint_that_gears_another_by_a_half_has_no_full_turn() {
        let urdf = |gear: f64| {
            format!(
                r#"<robot name="g"><link name="a"/><link name="b"/><link name="c"/>
<joint name="j" type="continuous"><parent link="a"/><child link="b"/><limit velocity="1" effort="1"/></joint>
<joint name="k" type="continuous"><parent link="b"/><child link="c"/><mimic joint="j" multiplier="{gear}"/></joint>
</robot>"#
            )
        };
        let robot = |gear| {
            Robot::from_urdf_text(&urdf(gear), "g.urdf", None, &RobotOptions::default()).expect("a good URDF")
        };
        assert!(robot(-2.0).full_turns[0]);
        assert!(!robot(0.5).full_turns[0]);
    }
}
