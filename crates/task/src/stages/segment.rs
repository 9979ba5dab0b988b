use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};

use crate::stages::corner::RoundedCorner;
use crate::stages::payload::Payload;
use crate::stages::speed_limits::SpeedLimits;

/// Properties of a motion during which the fingers do not move (a mode: Hauser & Latombe 2010, §3).
///
/// Code depends on these properties alone; the name is for files and messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(into = "String")]
pub struct Mode {
    /// Name in files.
    pub name: &'static str,
    /// True if an object is in the closed hand.
    pub holds: bool,
    /// End of the motion at which the held object may touch its support.
    pub rests_at: Option<MotionEnd>,
    /// True if the hand has released an object before.
    pub leaves: bool,
}

/// An end of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionEnd {
    /// The first way point.
    First,
    /// The last way point.
    Last,
}

impl Mode {
    /// Path to a grasp or another goal, the hand open and empty.
    pub const REACH: Self = Self { name: "reach", holds: false, rests_at: None, leaves: false };
    /// Straight approach to a grasp along the z axis of the gripper frame, the hand open and empty.
    pub const APPROACH: Self = Self { name: "approach", holds: false, rests_at: None, leaves: false };
    /// Lift-off of the object, in the closed hand, from its support.
    pub const LIFT_OFF: Self =
        Self { name: "lift-off", holds: true, rests_at: Some(MotionEnd::First), leaves: false };
    /// Transfer of the object from the lift-off on.
    pub const CARRY: Self = Self { name: "carry", holds: true, rests_at: None, leaves: false };
    /// Set-down of the object on its new support.
    pub const SET_DOWN: Self =
        Self { name: "set-down", holds: true, rests_at: Some(MotionEnd::Last), leaves: false };
    /// Retreat of the open hand from the object.
    pub const RETREAT: Self = Self { name: "retreat", holds: false, rests_at: None, leaves: true };
    /// Path of the empty hand after the retreat.
    pub const RETURN: Self = Self { name: "return", holds: false, rests_at: None, leaves: true };

    /// All modes.
    pub const ALL: [Self; 7] = [
        Self::REACH,
        Self::APPROACH,
        Self::LIFT_OFF,
        Self::CARRY,
        Self::SET_DOWN,
        Self::RETREAT,
        Self::RETURN,
    ];

    /// Returns the mode with this name.
    ///
    /// # Errors
    /// A sentence that lists the names.
    pub fn of_name(name: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|mode| mode.name == name).ok_or_else(|| {
            let known = Self::ALL.map(|mode| mode.name).join(", ");
            format!("'{name}' is not a motion mode (known: {known})")
        })
    }
}

impl<'de> Deserialize<'de> for Mode {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        Self::ALL.into_iter().find(|mode| mode.name == name).ok_or_else(|| {
            let known = Self::ALL.map(|mode| mode.name).join(", ");
            D::Error::custom(format!(
                "a segment is of mode '{name}', which this version does not know ({known})"
            ))
        })
    }
}

impl From<Mode> for String {
    fn from(mode: Mode) -> Self {
        mode.name.to_owned()
    }
}

/// A segment of a path, without finger motion: straight lines between way points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Segment {
    /// Kind of curve between the way points.
    #[serde(default)]
    pub kind: SegmentKind,
    /// Index of its stage in the task.
    #[serde(default)]
    pub stage: usize,
    /// Its mode.
    pub mode: Mode,
    /// Name of the object in the hand, if there is one.
    pub attached: Option<String>,
    /// Distance between the fingers, in metres; `None`: fully open.
    pub opening_m: Option<f64>,
    /// Travel of the last finger after the first one touches, in metres, which pushes object or hand; `None` for an empty hand.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub uneven_m: Option<f64>,
    /// Mass and inertia of the object in the hand, if torque limits include it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub payload: Option<Payload>,
    /// Share of the velocity limits for this segment, above 0 and below 1, that keeps the hold firm; accelerations scale with
    /// its square, jerks with its cube. `None`: the full limits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed: Option<f64>,
    /// Requested limits, besides those of the robot.
    #[serde(default, skip_serializing_if = "SpeedLimits::is_full")]
    pub pace: SpeedLimits,
    /// Way points: one value per joint each (m, rad).
    #[serde(default)]
    pub waypoints: Vec<Vec<f64>>,
    /// Corners that the motion rounds instead of stopping, in the order of their way points.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub corners: Vec<RoundedCorner>,
    /// Proven lower bound of the clearance along each edge, in metres; `None` if nothing is near, empty without a proof. If a
    /// corner between two edges is rounded, the clearance of its curve counts for both.
    #[serde(default)]
    pub clearances_m: Vec<Option<f64>>,
}

/// Kind of curve that joins the way points of a segment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum SegmentKind {
    /// Straight lines.
    #[default]
    Polyline,
}

impl TryFrom<String> for SegmentKind {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        let unknown =
            || format!("a segment is of kind '{name}', which this version does not know (polyline)");
        (name == "polyline").then_some(Self::Polyline).ok_or_else(unknown)
    }
}

impl From<SegmentKind> for String {
    fn from(_: SegmentKind) -> Self {
        "polyline".to_owned()
    }
}

impl Segment {
    /// Creates a segment of a stage through way points (m, rad; one value per joint) with the hand open and empty.
    pub fn empty(stage: usize, mode: Mode, waypoints: Vec<Vec<f64>>) -> Self {
        Self {
            kind: SegmentKind::Polyline,
            stage,
            mode,
            attached: None,
            opening_m: None,
            uneven_m: None,
            payload: None,
            speed: None,
            pace: SpeedLimits::default(),
            waypoints,
            corners: Vec::new(),
            clearances_m: Vec::new(),
        }
    }

    /// Creates the path of way points (m, rad; one value per joint) to a goal as the only segment of its task.
    pub fn reach(waypoints: Vec<Vec<f64>>, clearances_m: Vec<Option<f64>>) -> Self {
        Self { clearances_m, ..Self::empty(0, Mode::REACH, waypoints) }
    }

    /// Number of edges, 1 for a single way point.
    pub fn edges(&self) -> usize {
        self.waypoints.len().max(2) - 1
    }
}

/// Joins the way points (m, rad; one value per joint) of consecutive segments; shared way points appear once.
pub fn joined(segments: &[Segment]) -> Vec<Vec<f64>> {
    let mut joined: Vec<Vec<f64>> = Vec::new();
    for segment in segments {
        joined.pop();
        joined.extend_from_slice(&segment.waypoints);
    }
    joined
}

/// Returns the rounded corners of consecutive segments, indexed by the way points of [`joined`].
pub fn joined_corners(segments: &[Segment]) -> Vec<RoundedCorner> {
    let mut corners = Vec::new();
    let mut before = 0;
    for segment in segments {
        let of_segment = segment.corners.iter();
        corners.extend(
            of_segment.map(|corner| RoundedCorner { waypoint: before + corner.waypoint, ..corner.clone() }),
        );
        before += segment.waypoints.len().saturating_sub(1);
    }
    corners
}

/// Sets the clearances of each segment from those of all edges, in metres.
pub fn give_clearances(segments: &mut [Segment], clearances_per_edge_m: &[Option<f64>]) {
    let mut clearances_m = clearances_per_edge_m.iter();
    for segment in segments {
        segment.clearances_m = clearances_m.by_ref().take(segment.edges()).copied().collect();
    }
}

/// Splits segments into legs, between which the hand closes or opens.
pub fn legs(segments: &[Segment]) -> impl Iterator<Item = &[Segment]> {
    segments.chunk_by(|a, b| a.mode.holds == b.mode.holds)
}
