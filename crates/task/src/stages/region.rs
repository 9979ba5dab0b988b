use std::fmt;

use cranny_spatial::{
    EXACT_ROTATION_RAD, EXACT_TRANSLATION_M, Pose, Rotation, Stream, Vector, rotation_from_xyzw,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Goal region for the poses of the hand, or of the object in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// The frame that is moved into the region.
    pub moved: Moved,
    /// Central pose, in the planning frame.
    pub pose: Pose,
    /// Greatest distances from the centre along the axes of its pose, in metres.
    pub within_m: [f64; 3],
    /// Greatest angle from the rotation of the centre, in degrees.
    pub within_deg: f64,
}

/// Frame that a motion brings to a pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moved {
    /// The gripper frame.
    Hand,
    /// The first solid of the object in the hand.
    Object,
}

impl Region {
    /// Returns true if another region contains the same poses, up to rounding.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        let [a, b] = [self, other].map(|region| (region.moved, region.within_m, region.within_deg.to_bits()));
        let between = self.pose.inverse() * other.pose;
        a == b && between.translation.vector.norm() < 1e-9 && between.rotation.angle() < 1e-9
    }

    /// Returns this region in a new frame; `new_from_old` is the pose of the present frame in it.
    #[must_use]
    pub fn in_frame(&self, new_from_old: &Pose) -> Self {
        Self { pose: new_from_old * self.pose, ..self.clone() }
    }

    /// Returns the deviation from the region, in words, of a pose in the planning frame more than 1 mm or 1° outside it.
    pub fn fault_at(&self, pose: &Pose) -> Option<String> {
        let off = self.pose.inverse() * pose;
        let beyond = std::iter::zip(&off.translation.vector, self.within_m);
        let beyond_m = beyond.map(|(off_m, within_m)| (off_m.abs() - within_m).max(0.0));
        let off_m = beyond_m.map(|beyond_m| beyond_m.powi(2)).sum::<f64>().sqrt();
        let off_rad = (off.rotation.angle() - self.within_deg.to_radians()).max(0.0);
        if off_m <= EXACT_TRANSLATION_M && off_rad <= EXACT_ROTATION_RAD {
            return None;
        }
        let (moved, mm, degrees) = (self.moved, off_m * 1e3, off_rad.to_degrees());
        Some(format!("{moved} is {mm:.2} mm and {degrees:.2}° from its goal region"))
    }

    /// Returns the centre first, then random poses of the moved frame in the planning frame: positions are uniform, rotations
    /// have uniform axes and uniform angles.
    pub fn draws(&self, mut random: Stream) -> impl Iterator<Item = Pose> {
        let drawn = std::iter::repeat_with(move || {
            let place = Vector::from_fn(|axis, _| self.within_m[axis] * random.uniform_between(-1.0, 1.0));
            let turn = random.rotation() * Vector::z() * (random.uniform() * self.within_deg.to_radians());
            self.pose * Pose::from_parts(place.into(), Rotation::from_scaled_axis(turn))
        });
        std::iter::once(self.pose).chain(drawn)
    }

    /// Returns the fault, in words, of an invalid region.
    pub(crate) fn fault(&self) -> Option<&'static str> {
        let has_sides = self.within_m.iter().all(|side_m| side_m.is_finite() && *side_m >= 0.0);
        if !has_sides {
            return Some("`within_m` has to be three distances of 0 m or more");
        }
        let is_angle = (0.0..=180.0).contains(&self.within_deg);
        (!is_angle).then_some("`within_deg` has to be 0 to 180")
    }
}

impl fmt::Display for Moved {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Hand => "the hand",
            Self::Object => "the object in the hand",
        })
    }
}

impl fmt::Display for Region {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.pose.translation.vector.into();
        write!(f, "{} to ({x:.3}, {y:.3}, {z:.3}) m", self.moved)?;
        if self.within_m.iter().any(|side_m| *side_m > 0.0) || self.within_deg > 0.0 {
            let [x, y, z] = self.within_m;
            write!(f, " within ({x:.3}, {y:.3}, {z:.3}) m, {:.1}°", self.within_deg)?;
        }
        Ok(())
    }
}

/// A region in the format of files.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct RegionRow {
    /// Pose of the gripper frame.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    hand: Option<PoseRow>,
    /// Instead: pose of the object in the hand.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    object: Option<PoseRow>,
    /// Greatest distances from it along its axes, in metres.
    #[serde(default)]
    within_m: [f64; 3],
    /// Greatest angle from its rotation, in degrees; 180: any rotation.
    #[serde(default)]
    within_deg: f64,
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
}

impl TryFrom<RegionRow> for Region {
    type Error = String;

    fn try_from(row: RegionRow) -> Result<Self, String> {
        let RegionRow { hand, object, within_m, within_deg } = row;
        let (moved, pose) = match (hand, object) {
            (Some(hand), None) => (Moved::Hand, hand),
            (None, Some(object)) => (Moved::Object, object),
            _ => return Err("'move' goes to a pose of either 'hand' or 'object'".to_owned()),
        };
        let region = Self { moved, pose: pose.pose()?, within_m, within_deg };
        region.fault().map_or(Ok(region), |fault| Err(fault.to_owned()))
    }
}

impl From<Region> for RegionRow {
    fn from(region: Region) -> Self {
        let Region { moved, pose, within_m, within_deg } = region;
        let quaternion = pose.rotation.quaternion();
        let pose = Some(PoseRow {
            position: pose.translation.vector.into(),
            rotation_rpy_deg: None,
            quaternion_xyzw: Some(quaternion.coords.into()),
        });
        let row = Self { within_m, within_deg, ..Self::default() };
        match moved {
            Moved::Hand => Self { hand: pose, ..row },
            Moved::Object => Self { object: pose, ..row },
        }
    }
}
