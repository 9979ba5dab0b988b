use std::f64::consts::TAU;

use crate::{JointKind, JointLimits, Mover, Robot};

impl Robot {
    /// Turns joints of `q` by whole turns, within their limits, to where they are nearest to `reference`: all links
    /// stay where they are. Whether any was turned. Joints without a full turn stay as they are.
    ///
    /// # Panics
    /// If either has not one value per joint.
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

    /// Turns continuous joints of `q` that are outside their limits by whole turns into them: all links stay where they
    /// are. A joint with limits of its own stays as it is, and so does one that gears another by a fraction.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn turn_into_limits(&self, q: &mut [f64]) {
        assert_eq!(q.len(), self.dof(), "one value for each joint of the group");
        for (joint, value) in q.iter_mut().enumerate() {
            if self.full_turns[joint] && self.joints[joint].is_continuous {
                *value = turned_within(*value, self.limits[joint].lower, self.limits[joint].upper);
            }
        }
    }

    /// How far beyond need a path turns the joint that it turns farthest so, in radians: what the joint travels, less
    /// the way from where it starts to the nearest of the whole turns, within its limits, at which the path could end.
    /// Only joints that have a full turn count.
    ///
    /// # Panics
    /// If a way point has not one value per joint.
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

/// Per joint of the group whether it can stand a full turn from where it stands with all links in the same place: it
/// turns, by more than 2π from limit to limit, and whatever follows it turns a whole number of times as far.
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

/// `value` if it lies within the limits, else that number of whole turns from it which is nearest to their middle;
/// `value` if none of them lies within.
pub(crate) fn turned_within(value: f64, lower: f64, upper: f64) -> f64 {
    let limits = lower..=upper;
    let turned = value - ((value - 0.5 * (lower + upper)) / TAU).round() * TAU;
    if limits.contains(&turned) && !limits.contains(&value) { turned } else { value }
}

/// `value` and whole turns, within the limits as near to `reference` as can be.
fn nearest_turn(value: f64, reference: f64, limits: &JointLimits) -> f64 {
    let most = ((limits.upper - value) / TAU).floor();
    let least = ((limits.lower - value) / TAU).ceil();
    let turns = ((reference - value) / TAU).round().clamp(least.min(0.0), most.max(0.0));
    let turned = value + turns * TAU;
    if limits.contain(turned) { turned } else { value }
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
            // A turn farther would be nearer, but beyond the limit.
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
            (37.7, -3.0 * PI, 3.0 * PI, 37.7 - 6.0 * TAU),
            (-15.0, -3.0 * PI, 3.0 * PI, -15.0 + 2.0 * TAU),
            (9.0, -3.0 * PI, 3.0 * PI, 9.0),
            (TAU + 0.5, -1.0, 1.0, 0.5),
            (2.0, -1.0, 1.0, 2.0),
            (f64::INFINITY, -1.0, 1.0, f64::INFINITY),
        ] {
            let turned = turned_within(value, lower, upper);
            let is_same = turned.total_cmp(&expected).is_eq() || (turned - expected).abs() < 1e-12;
            assert!(is_same, "{value}: {turned}");
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
