use cranny_shape::{Solid, separation};
use cranny_spatial::{Point, Pose};

use crate::gripper::loose_links::LooseJoint;
use crate::{HandDescription, HandJoint, Link};

/// Distance between the pads of a hand while it closes, and the time that closing takes.
///
/// A pad is represented by the point of a finger that lies on the closing axis (y of the gripper frame) while the hand
/// is open. With `y_f(c)` the coordinate of that point of finger f on the axis, once all joints of the hand have moved
/// by the share c of their strokes, the distance is `opening + Σ_f sign_f·(y_f(c) − y_f(0))`: linear in c for fingers
/// that slide along the axis, but not for jaws that rotate.
#[derive(Clone, Debug, PartialEq)]
pub struct PadDistance {
    opening_m: f64,
    joints: Vec<LooseJoint>,
    /// One pad per finger.
    pads: Vec<Pad>,
    /// True if the distance is `opening · (1 − c)`.
    is_linear: bool,
}

/// Point fixed to a finger.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Pad {
    /// Last joint of the hand above it, as an index into the joints.
    joint: usize,
    in_link: Point,
    /// 1 if y is positive, else −1.
    side: f64,
}

/// Maximum deviation from linearity, in metres, up to which a hand counts as linear.
const LINEAR_M: f64 = 1e-9;

/// Number of bisections to find a closing: more would not change the result.
const BISECTIONS: usize = 60;

impl PadDistance {
    /// Returns the pad distance of the hand of a robot whose links have the poses `rest` while the hand is open.
    pub(crate) fn of(
        description: &HandDescription,
        (joints, fingers): (&[HandJoint], usize),
        (links, rest, tip): (&[Link], &[Pose], usize),
    ) -> Self {
        let opening_m = description.opening_m;
        let joints = LooseJoint::all(joints, rest, tip);
        let on_axis = |side: f64| Point::new(0.0, 0.5 * side * opening_m, 0.0);
        // Distance of a link of a finger from the nominal position of a pad.
        let off_m = |link: usize, side: f64| {
            let Ok(point) = Solid::sphere(POINT_M) else { return f64::INFINITY };
            let at = rest[tip] * Pose::translation(0.0, on_axis(side).y, 0.0);
            let to = |solid: &Solid, pose: Pose| separation(&point, &at, solid, &pose, f64::INFINITY).upper_m;
            let shapes = links[link].collisions.iter();
            shapes
                .map(|shape| to(&shape.solid, rest[link] * shape.link_from_shape))
                .fold(f64::INFINITY, f64::min)
        };
        let moved_by = |link: usize| {
            let mut above = std::iter::successors(Some(link), |&link| links[link].parent);
            above.find_map(|link| joints.iter().position(|joint| joint.joint.link == link))
        };
        let pad_of = |finger: usize| {
            let own = (0..links.len()).filter_map(|link| Some((link, moved_by(link)?)));
            let own = own.filter(|(_, joint)| joints[*joint].joint.finger == finger);
            let places =
                own.flat_map(|(link, joint)| [1.0, -1.0].map(|side| (off_m(link, side), joint, side)));
            let (_, joint, side) = places.min_by(|a, b| a.0.total_cmp(&b.0))?;
            let in_link = rest[joints[joint].joint.link].inverse() * (rest[tip] * on_axis(side));
            Some(Pad { joint, in_link, side })
        };
        let pads = (0..fingers).filter_map(pad_of).collect();
        let mut known = Self { opening_m, joints, pads, is_linear: false };
        // The hand is linear if three samples, the last of them at zero distance, lie on a line.
        let off_line_m = |closing: f64| (known.by_pads_m(closing) - opening_m * (1.0 - closing)).abs();
        known.is_linear = [0.25, 0.5, 1.0].into_iter().all(|closing| off_line_m(closing) < LINEAR_M);
        known
    }

    /// Distance between the pads, in metres, when the hand has closed by the share `closing` (0: open, 1: closed).
    pub fn opening_m(&self, closing: f64) -> f64 {
        if self.is_linear { self.opening_m * (1.0 - closing) } else { self.by_pads_m(closing).max(0.0) }
    }

    /// Returns true if a pad is on the link below a joint of the hand, or rigidly connected with it; joints as in
    /// [`RobotHand::joints`](crate::RobotHand).
    pub(crate) fn is_below(&self, joint: usize) -> bool {
        self.pads.iter().any(|pad| pad.joint == joint)
    }

    /// Travel of the pad of a finger along the closing axis, in metres, while the hand closes from one share to another.
    pub fn travel_m(&self, finger: usize, closings: [f64; 2]) -> f64 {
        let [from, to] = closings.map(|closing| LooseJoint::poses(&self.joints, closing));
        let y_m = |poses: &[Pose], pad: &Pad| (poses[pad.joint] * pad.in_link).y;
        self.pads.get(finger).map_or(0.0, |pad| (y_m(&to, pad) - y_m(&from, pad)).abs())
    }

    /// Share of its travel (0: open, 1: closed) by which the hand has closed at the distance `opening_m` (m) of its pads.
    pub fn closing(&self, opening_m: f64) -> f64 {
        if self.is_linear {
            return (1.0 - opening_m / self.opening_m).clamp(0.0, 1.0);
        }
        let (mut wider, mut narrower) = (0.0, 1.0);
        if self.opening_m(wider) <= opening_m {
            return wider;
        }
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (wider + narrower);
            if self.opening_m(middle) > opening_m { wider = middle } else { narrower = middle }
        }
        narrower
    }

    /// Interpolates between two pad distances at the time `share`, in metres, with every joint at constant speed.
    pub fn between_m(&self, [before_m, after_m]: [f64; 2], share: f64) -> f64 {
        if self.is_linear {
            // This form is exact at both ends.
            return (1.0 - share) * before_m + share * after_m;
        }
        let [before, after] = [before_m, after_m].map(|opening_m| self.closing(opening_m));
        self.opening_m(before + share * (after - before))
    }

    /// Minimum time, in seconds, in which the pad distance can change from the first value to the second (m), from rest to
    /// rest, within the velocity and acceleration limits of each joint that has them; 0 if no joint of the hand has a limit.
    pub fn least_time_s(&self, openings_m: [f64; 2]) -> f64 {
        let [before, after] = openings_m.map(|opening_m| self.closing(opening_m));
        let of_joint = |joint: &LooseJoint| {
            let way = joint.joint.stroke.abs() * (after - before).abs();
            match (joint.joint.velocity, joint.joint.acceleration) {
                (Some(velocity), Some(acceleration)) if way > velocity * velocity / acceleration => {
                    way / velocity + velocity / acceleration
                }
                (_, Some(acceleration)) => 2.0 * (way / acceleration).sqrt(),
                (Some(velocity), None) => way / velocity,
                (None, None) => 0.0,
            }
        };
        self.joints.iter().map(of_joint).fold(0.0, f64::max)
    }

    fn by_pads_m(&self, closing: f64) -> f64 {
        let [open, closed] = [0.0, closing].map(|closing| LooseJoint::poses(&self.joints, closing));
        let nearer_m = |pad: &Pad| {
            let y_m = |poses: &[Pose]| (poses[pad.joint] * pad.in_link).y;
            pad.side * (y_m(&open) - y_m(&closed))
        };
        self.opening_m - self.pads.iter().map(nearer_m).sum::<f64>()
    }
}

/// Radius of a sphere that represents a point, in metres.
const POINT_M: f64 = 1e-6;

#[cfg(test)]
mod tests {
    use cranny_spatial::sin_cos;

    use crate::{Robot, RobotOptions, TextSource};

    /// Returns two jaws 0.1 m long that rotate about pivots 40 mm from the centre.
    fn jaws(limits: &str) -> Robot {
        let jaw = |name: &str, side: f64| {
            format!(
                r#"<link name="{name}"><collision><origin xyz="0 0 0.05"/><geometry><box size="0.02 0.002 0.1"/></geometry></collision></link>
<joint name="{name}_joint" type="revolute"><parent link="palm"/><child link="{name}"/><origin xyz="0 {y} 0"/>
  <axis xyz="{side} 0 0"/><limit lower="0" upper="0.6" velocity="0.25" effort="1"/>{mimic}</joint>"#,
                y = 0.041 * side,
                mimic = if side < 0.0 { r#"<mimic joint="left_joint"/>"# } else { "" },
            )
        };
        let urdf = format!(
            r#"<robot name="jaws"><link name="root"/><link name="palm"/><link name="tool"/>
<joint name="slide" type="prismatic"><parent link="root"/><child link="palm"/><axis xyz="1 0 0"/>
  <limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
<joint name="mount" type="fixed"><parent link="palm"/><child link="tool"/><origin xyz="0 0 0.1"/></joint>
{}{}</robot>"#,
            jaw("left", 1.0),
            jaw("right", -1.0)
        );
        let text =
            |name: &str, text: &str| Some(TextSource::Text { name: name.to_owned(), text: text.to_owned() });
        let hand = "hand: {name: jaws, tip: tool, fingers: {left_joint: {open: 0, closed: 0.4}}, opening_m: 0.08, \
             finger_depth_m: 0.1, closing_force_n: 20}";
        let options = RobotOptions {
            description: text("robot.yaml", hand),
            limits: text("limits.yaml", limits),
            ..RobotOptions::default()
        };
        Robot::from_urdf_text(&urdf, "jaws.urdf", None, &options).expect("a robot")
    }

    #[test]
    fn jaws_that_turn_are_as_far_apart_as_their_pads() {
        let robot = jaws("joints: {}");
        let pads = &robot.hand().expect("a hand").pads;
        for closing in [0.0, 0.3, 0.7, 1.0] {
            let turn: f64 = 0.4 * closing;
            // The pad is 1 mm inside the pivot and 0.1 m beyond it.
            let (sine, cosine) = sin_cos(turn);
            let nearer_m = 0.1 * sine + 0.001 * (cosine - 1.0);
            let expected_m = (0.08 - 2.0 * nearer_m).max(0.0);
            assert!((pads.opening_m(closing) - expected_m).abs() < 1e-12, "{closing}");
            if closing > 0.0 && closing < 1.0 {
                assert!((pads.closing(expected_m) - closing).abs() < 1e-9);
            }
        }
        let half_m = pads.between_m([0.08, pads.opening_m(0.8)], 0.5);
        assert!((half_m - pads.opening_m(0.4)).abs() < 1e-9);
    }

    #[test]
    fn a_hand_takes_as_long_as_the_slowest_of_its_joints() {
        let time_s = |limits: &str| {
            let robot = jaws(limits);
            let pads = &robot.hand().expect("a hand").pads;
            pads.least_time_s([0.08, pads.opening_m(0.9)])
        };
        let way: f64 = 0.36;
        for (limits, expected_s) in [
            ("joints: {}", way / 0.25),
            // A mimic joint has limits of its own.
            ("joints: {right_joint: {velocity: 0.1}}", way / 0.1),
            ("joints: {left_joint: {acceleration: 0.5}}", way / 0.25 + 0.25 / 0.5),
            ("joints: {left_joint: {acceleration: 0.1, velocity: 9}}", 2.0 * (way / 0.1).sqrt()),
        ] {
            let found_s = time_s(limits);
            assert!((found_s - expected_s).abs() < 1e-6, "{limits}: {found_s}, not {expected_s}");
        }
    }
}
