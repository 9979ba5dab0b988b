use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::RobotError;
use crate::location::Location;

/// Description of a hand with parallel pads beyond its URDF: `hand` in the `robot.yaml` of a robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HandDescription {
    /// Name of the hand.
    pub name: String,
    /// Gripper frame: between the pads, y along the closing direction, z along the approach direction. Default: the tip that
    /// the robot has without this file.
    #[serde(default)]
    pub tip: Option<String>,
    /// Joints that close the hand, by name; joints that mimic them close with them. If empty, the hand cannot close.
    #[serde(default)]
    pub fingers: BTreeMap<String, FingerRange>,
    /// Distance between the pads when the fingers are open, in metres.
    pub opening_m: f64,
    /// Distance from the origin of the gripper frame back to the palm, in metres.
    pub finger_depth_m: f64,
    /// Force of the pads on a held object, in newtons.
    pub closing_force_n: f64,
    /// Flat pads. Default: those of the fingers' collision geometry.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pads: Option<PadDescription>,
}

/// Flat pads of a hand, one on each finger, for hands whose collision geometry does not show them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PadDescription {
    /// Lengths along x and z of the gripper frame, in metres.
    pub size_m: [f64; 2],
    /// Centre along x and z of the gripper frame, in metres.
    #[serde(default)]
    pub middle_m: [f64; 2],
}

/// Maximum length of any hand, in metres: a larger value is in other units.
const LONGEST_M: f64 = 1.0;

impl HandDescription {
    /// Checks that the values are possible; `text` is the text of `file`.
    pub(crate) fn check(&self, text: &str, file: &str) -> Result<(), RobotError> {
        let of_hand = || format!("hand `{}`", self.name);
        for (attribute, value, most) in [
            ("opening_m", self.opening_m, LONGEST_M),
            ("finger_depth_m", self.finger_depth_m, LONGEST_M),
            ("closing_force_n", self.closing_force_n, f64::MAX),
        ] {
            if !(value > 0.0 && value <= most) {
                let range = match most {
                    f64::MAX => "a number greater than 0".to_owned(),
                    _ => format!("greater than 0 and at most {most}, in metres"),
                };
                let at = line_of(text, file, attribute);
                return Err(RobotError::HandFigure { at, element: of_hand(), attribute, value, range });
            }
        }
        if let Some(pads) = &self.pads {
            let range = |from: &str| format!("{from} and at most {LONGEST_M}, in metres");
            for (attribute, numbers, least, from) in [
                ("size_m", pads.size_m, f64::MIN_POSITIVE, "greater than 0"),
                ("middle_m", pads.middle_m, -LONGEST_M, "at least -1"),
            ] {
                if let Some(value) = numbers.into_iter().find(|value| !(least..=LONGEST_M).contains(value)) {
                    let (at, element) = (line_of(text, file, "pads"), "`pads`".to_owned());
                    return Err(RobotError::HandFigure { at, element, attribute, value, range: range(from) });
                }
            }
        }
        self.check_fingers(text, file, |_| (f64::MIN, f64::MAX))
    }

    /// Checks that the joint of each finger can take its open and closed values; `limits` returns limits by joint name.
    pub(crate) fn check_fingers(
        &self,
        text: &str,
        file: &str,
        limits: impl Fn(&str) -> (f64, f64),
    ) -> Result<(), RobotError> {
        for (finger, places) in &self.fingers {
            if (places.open - places.closed).abs() < 1e-9 {
                let (at, element) = (line_of(text, file, finger), format!("finger `{finger}`"));
                let (value, range) = (places.closed, "other than `open`".to_owned());
                return Err(RobotError::HandFigure { at, element, attribute: "closed", value, range });
            }
            for (attribute, value) in [("open", places.open), ("closed", places.closed)] {
                let (lower, upper) = limits(finger);
                if !(lower..=upper).contains(&value) {
                    let (at, element) = (line_of(text, file, finger), format!("finger `{finger}`"));
                    let range = match lower {
                        f64::MIN => "a number".to_owned(),
                        _ => format!("between {lower} and {upper}, the limits of the joint"),
                    };
                    return Err(RobotError::HandFigure { at, element, attribute, value, range });
                }
            }
        }
        Ok(())
    }
}

/// Range of the joint of a finger (m, rad).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FingerRange {
    /// Joint value with the hand open.
    pub open: f64,
    /// Joint value with the hand fully closed, without an object.
    pub closed: f64,
}

/// Returns the location of the first line that begins with a key; line 1 if there is none.
pub(crate) fn line_of(text: &str, file: &str, key: &str) -> Location {
    let line = text.lines().position(|line| line.trim_start().starts_with(key));
    let line = u32::try_from(line.map_or(1, |line| line + 1)).unwrap_or(u32::MAX);
    Location { file: file.to_owned(), line }
}
