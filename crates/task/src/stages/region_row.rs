//! Regions in the format of files.

use std::borrow::Cow;

use cranny_spatial::{Pose, PoseDifference, Rotation, Vector, rotation_from_xyzw};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::{Moved, PoseBounds, Region, RegionFrame};

/// Region of poses: one of `hand` and `object` with what is allowed around it, or `moves` with `frames`.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Region")]
pub(crate) struct RegionRow {
    /// Pose of the gripper frame.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    hand: Option<PoseRow>,
    /// Instead: pose of the object in the hand.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    object: Option<PoseRow>,
    /// Greatest distances from it along its axes, in metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    within_m: Option<[f64; 3]>,
    /// Greatest angle from its rotation, in degrees; 180: any rotation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    within_deg: Option<f64>,
    /// Frame that is in the region: `hand` or `object`. Default: `hand`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    moves: Option<Moved>,
    /// Instead of all above but `moves`: one frame, or two in series.
    #[serde(default, skip_serializing_if = "Vec::is_empty", deserialize_with = "checked_frames")]
    frames: Vec<FrameRow>,
}

/// Frame of a region, with lower and upper bounds of poses in it; [0, 0] where left out.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "RegionFrame")]
struct FrameRow {
    /// Pose of the frame: in the scene, or in the end of the frame before.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pose: Option<PoseRow>,
    #[serde(default)]
    x: [f64; 2],
    #[serde(default)]
    y: [f64; 2],
    #[serde(default)]
    z: [f64; 2],
    /// Roll, pitch and yaw about fixed axes, as in a URDF.
    #[serde(default)]
    roll_deg: [f64; 2],
    #[serde(default)]
    pitch_deg: [f64; 2],
    #[serde(default)]
    yaw_deg: [f64; 2],
    /// Pose of the hand, the object or the next frame in a pose within these bounds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    end: Option<PoseRow>,
}

/// Pose: position (m) and rotation; zero where left out.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct PoseRow {
    #[serde(default)]
    position: [f64; 3],
    #[serde(default, skip_serializing_if = "Option::is_none")]
    rotation_rpy_deg: Option<[f64; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    quaternion_xyzw: Option<[f64; 4]>,
}

impl PoseRow {
    fn pose(&self) -> Result<Pose, String> {
        let given = self.rotation_rpy_deg.iter().flatten().chain(&self.position);
        if let Some(value) = given.copied().find(|value| !value.is_finite()) {
            return Err(format!("'{value}' in a pose is not a finite number"));
        }
        let rotation = match (self.rotation_rpy_deg, self.quaternion_xyzw) {
            (None, None) => Rotation::identity(),
            (Some(rpy_deg), None) => {
                let [roll, pitch, yaw] = rpy_deg.map(f64::to_radians);
                Rotation::from_euler_angles(roll, pitch, yaw)
            }
            (None, Some(quaternion)) => rotation_from_xyzw(quaternion).map_err(|norm| {
                format!("quaternion {quaternion:?} is not a rotation: its length is {norm}, not 1")
            })?,
            (Some(_), Some(_)) => {
                return Err("a pose has either `rotation_rpy_deg` or `quaternion_xyzw`".to_owned());
            }
        };
        Ok(Pose::from_parts(Vector::from(self.position).into(), rotation))
    }

    fn of(pose: &Pose) -> Self {
        Self {
            position: pose.translation.vector.into(),
            rotation_rpy_deg: None,
            quaternion_xyzw: Some(pose.rotation.quaternion().coords.into()),
        }
    }
}

impl FrameRow {
    fn frame(&self) -> Result<RegionFrame, String> {
        let pose = |row: &Option<PoseRow>| row.as_ref().map_or(Ok(Pose::identity()), PoseRow::pose);
        let bounds = PoseBounds::Intervals {
            position_m: [self.x, self.y, self.z],
            rpy_deg: [self.roll_deg, self.pitch_deg, self.yaw_deg],
        };
        Ok(RegionFrame { pose: pose(&self.pose)?, bounds, end: pose(&self.end)? })
    }
}

/// Reads frames. A fault in one is reported at its line, not at that of the region.
fn checked_frames<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<FrameRow>, D::Error> {
    struct Checked(FrameRow);

    impl<'de> Deserialize<'de> for Checked {
        fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
            let row = FrameRow::deserialize(deserializer)?;
            let fault = row.frame().map_or_else(Some, |frame| frame.bounds.fault());
            fault.map_or(Ok(Self(row)), |fault| Err(D::Error::custom(fault)))
        }
    }
    Ok(Vec::<Checked>::deserialize(deserializer)?.into_iter().map(|Checked(row)| row).collect())
}

impl Serialize for Region {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        RegionRow::from(self.clone()).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Region {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Self::try_from(RegionRow::deserialize(deserializer)?).map_err(D::Error::custom)
    }
}

impl TryFrom<RegionRow> for Region {
    type Error = String;

    fn try_from(row: RegionRow) -> Result<Self, String> {
        let RegionRow { hand, object, within_m, within_deg, moves, frames } = row;
        let central = |moved, pose: &PoseRow| {
            let (within_m, within_deg) = (within_m.unwrap_or_default(), within_deg.unwrap_or_default());
            let bounds = PoseBounds::Within { within_m, within_deg };
            let frame = RegionFrame { pose: pose.pose()?, bounds, end: Pose::identity() };
            Ok::<Self, String>(Self { moved, frames: vec![frame] })
        };
        let is_plain = moves.is_none() && frames.is_empty();
        let region = match (&hand, &object, is_plain) {
            (Some(hand), None, true) => central(Moved::Hand, hand)?,
            (None, Some(object), true) => central(Moved::Object, object)?,
            (None, None, false) if within_m.is_none() && within_deg.is_none() => Self {
                moved: moves.unwrap_or(Moved::Hand),
                frames: frames.iter().map(FrameRow::frame).collect::<Result<_, _>>()?,
            },
            _ => {
                return Err(
                    "a region is a pose of either 'hand' or 'object', or 'moves' and 'frames'".to_owned()
                );
            }
        };
        region.fault().map_or(Ok(region), Err)
    }
}

impl From<Region> for RegionRow {
    fn from(region: Region) -> Self {
        let Region { moved, frames } = region;
        if let [RegionFrame { pose, bounds: PoseBounds::Within { within_m, within_deg }, end }] = &frames[..]
            && is_identity(end)
        {
            let pose = Some(PoseRow::of(pose));
            let row = Self { within_m: Some(*within_m), within_deg: Some(*within_deg), ..Self::default() };
            return match moved {
                Moved::Hand => Self { hand: pose, ..row },
                Moved::Object => Self { object: pose, ..row },
            };
        }
        let frames = frames.iter().map(FrameRow::from).collect();
        Self { moves: Some(moved), frames, ..Self::default() }
    }
}

impl From<&RegionFrame> for FrameRow {
    fn from(frame: &RegionFrame) -> Self {
        let ([x, y, z], [roll_deg, pitch_deg, yaw_deg]) = match &frame.bounds {
            PoseBounds::Intervals { position_m, rpy_deg } => (*position_m, *rpy_deg),
            PoseBounds::Within { within_m, .. } => (within_m.map(|side_m| [-side_m, side_m]), [[0.0; 2]; 3]),
        };
        let end = (!is_identity(&frame.end)).then(|| PoseRow::of(&frame.end));
        Self { pose: Some(PoseRow::of(&frame.pose)), x, y, z, roll_deg, pitch_deg, yaw_deg, end }
    }
}

fn is_identity(pose: &Pose) -> bool {
    let PoseDifference { translation_m, rotation_rad } = PoseDifference::between(&Pose::identity(), pose);
    translation_m <= 0.0 && rotation_rad <= 0.0
}

impl JsonSchema for Region {
    fn schema_name() -> Cow<'static, str> {
        RegionRow::schema_name()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        RegionRow::json_schema(generator)
    }
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    fn read(value: Value) -> Result<Region, String> {
        serde_json::from_value(value).map_err(|fault| fault.to_string())
    }

    #[test]
    fn a_region_that_is_written_is_read_as_the_same() {
        let cases = [
            json!({"hand": {"position": [0.1, 0.2, 0.3]}, "within_m": [0.1, 0.0, 0.2], "within_deg": 30.0}),
            json!({"object": {"rotation_rpy_deg": [10.0, 20.0, 30.0]}}),
            json!({"frames": [{"x": [-0.1, 0.3], "yaw_deg": [-33.3, 0.1], "end": {"position": [0.0, 0.0, 0.1]}}]}),
            json!({"moves": "object", "frames": [{"pose": {"rotation_rpy_deg": [1.0, 2.0, 3.0]}}, {"roll_deg": [1.0, 2.0]}]}),
        ];
        for case in cases {
            let region = read(case.clone()).expect("a region");
            let written = serde_json::to_value(&region).expect("a value");
            let again = read(written).expect("a region");
            assert!(again.is_like(&region), "{case}: {again:?}");
        }
    }

    #[test]
    fn a_region_of_neither_form_is_refused() {
        let cases = [
            (json!({}), "'moves' and 'frames'"),
            (json!({"hand": {}, "object": {}}), "'moves' and 'frames'"),
            (json!({"hand": {}, "moves": "hand"}), "'moves' and 'frames'"),
            (json!({"frames": [{}], "within_deg": 3.0}), "'moves' and 'frames'"),
            (json!({"moves": "hand"}), "1 to 2 `frames`"),
            (json!({"frames": [{"z": [0.2, 0.1]}]}), "empty"),
            (json!({"frames": [{"z": [0.0, 1e9]}]}), "lie in"),
            (json!({"hand": {}, "within_deg": 181.0}), "0 to 180"),
            (json!({"frames": [{"yaw": [0.0, 1.0]}]}), "unknown field"),
        ];
        for (case, message) in cases {
            let fault = read(case.clone()).expect_err("no region");
            assert!(fault.contains(message), "{case}: {fault}");
        }
    }
}
