//! Default limits of speed, acceleration and jerk for robots without them.

use std::fmt::Write as _;

use cranny_robot::{DEFAULT_SPEED_M_S, DEFAULT_SPEED_RAD_S, JointFacts, JointKind, JointMotion};

use crate::choice::Choice;

/// Default acceleration of `MoveIt` for robots without such limits, 1 rad/s² and 1 m/s², and ten times that for the jerk.
const ACCELERATION: f64 = 1.0;
const JERK: f64 = 10.0;

/// Ranges narrower than those of the URDF, by joint name (m, rad).
pub(crate) type Ranges = Vec<(String, [f64; 2])>;

/// Returns a `limits.yaml` with only the values that a robot cannot be built without.
pub(crate) fn needed_text(joints: &[JointFacts]) -> String {
    text_of(joints, |text, name, speed, _| {
        if let Some(speed) = speed {
            let _ = writeln!(text, "  {name}: {{velocity: {speed}}}");
        }
    })
}

/// Returns a complete `limits.yaml`, which marks its defaults as such.
pub(crate) fn text(joints: &[JointFacts], ranges: &Ranges) -> String {
    let header = format!(
        "# Greatest velocities, accelerations and jerks of the joints (m, rad, s), where the URDF has none.\n\
         # EVERY FIGURE IN THIS FILE IS A DEFAULT, not the maker's: accelerations {ACCELERATION} rad/s^2 and m/s^2, as\n\
         # MoveIt assumes without others, jerks {JERK} rad/s^3 and m/s^3. Replace them by the maker's figures:\n\
         # they limit the speed of every trajectory. `lower` and `upper` narrow a joint's range, `velocity` its speed.\n"
    );
    let body = text_of(joints, |text, name, speed, motion| {
        let range = ranges.iter().find(|(joint, _)| yaml_key(joint) == name);
        let [lower, upper] = range.map_or([None; 2], |(_, range)| range.map(Some));
        let acceleration = motion.acceleration.is_none().then_some(ACCELERATION);
        let jerk = motion.jerk.is_none().then_some(JERK);
        let figures = [
            ("lower", lower),
            ("upper", upper),
            ("velocity", speed),
            ("acceleration", acceleration),
            ("jerk", jerk),
        ];
        let figures: Vec<String> =
            figures.iter().filter_map(|(key, value)| value.map(|value| format!("{key}: {value}"))).collect();
        if !figures.is_empty() {
            let _ = writeln!(text, "  {name}: {{{}}}", figures.join(", "));
        }
    });
    header + &body
}

/// Returns the choice of default limits.
pub(crate) fn choice(joints: &[JointFacts]) -> Choice {
    let moving = joints.iter().filter_map(|joint| Some((joint, joint.motion.as_ref()?)));
    let slow = moving.filter(|(_, motion)| {
        motion.mimics.is_none() && motion.velocity.is_none_or(|velocity| velocity <= 0.0)
    });
    let slow: Vec<&str> = slow.map(|(joint, _)| joint.name.as_str()).collect();
    let mut chosen = format!("accelerations {ACCELERATION} rad/s² or m/s², jerks {JERK}");
    if !slow.is_empty() {
        let _ = write!(
            chosen,
            "; velocities {DEFAULT_SPEED_RAD_S} rad/s or {DEFAULT_SPEED_M_S} m/s of {}, which have none",
            slow.join(", ")
        );
    }
    Choice::new("limits", chosen, "defaults, where the URDF has none", "the maker's figures in limits.yaml")
}

/// Calls `line` for each joint that does not mimic, with a default speed if it has none, and with its motion in the URDF.
fn text_of(joints: &[JointFacts], line: impl Fn(&mut String, &str, Option<f64>, &JointMotion)) -> String {
    let mut text = String::from("joints:\n");
    let mut is_empty = true;
    for joint in joints {
        let Some(motion) = joint.motion.as_ref().filter(|motion| motion.mimics.is_none()) else { continue };
        let needed = match motion.kind {
            JointKind::Revolute => DEFAULT_SPEED_RAD_S,
            JointKind::Prismatic => DEFAULT_SPEED_M_S,
        };
        let speed = motion.velocity.is_none_or(|speed| speed <= 0.0).then_some(needed);
        let before = text.len();
        line(&mut text, &yaml_key(&joint.name), speed, motion);
        is_empty &= text.len() == before;
    }
    if is_empty { "joints: {}\n".to_owned() } else { text }
}

/// Formats a name as a YAML key.
pub(crate) fn yaml_key(name: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-./".contains(c);
    if !name.is_empty() && name.chars().all(is_plain) && name.starts_with(|c: char| c.is_ascii_alphabetic()) {
        return name.to_owned();
    }
    format!("\"{}\"", name.replace('\\', "\\\\").replace('"', "\\\""))
}
