//! What a `scenario.yaml` may say. See `own_layout` for what becomes of it.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;

use cranny_task::{AfterPlacing, Criterion, Stage};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use serde_saphyr::Spanned;

/// The whole file. Poses and heights are in the scene frame; metres, and degrees where the key says so.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ScenarioFile {
    /// A built-in robot such as `panda_mobile`, or the path of a robot's folder or a URDF, from the folder of this file.
    #[schemars(with = "String")]
    pub robot: Spanned<String>,
    /// What it is about, who made it and how it may be used.
    pub about: Option<AboutEntry>,
    /// The robot's SRDF: pairs of links that may touch. What stands beside the URDF needs no mention.
    pub srdf: Option<PathBuf>,
    /// The group of the SRDF whose joints move; without it all from the root to the tip.
    pub group: Option<String>,
    /// Folders in which the `package://` names of the URDF are looked for.
    #[serde(default)]
    pub packages: Vec<PathBuf>,
    /// The link whose frame is the gripper frame.
    pub tip: Option<String>,
    /// Joints outside the group, and where they stand (m, rad).
    #[serde(default)]
    pub fixed: BTreeMap<String, f64>,
    /// Pairs of links that may touch and are not checked against each other, beside those of the SRDF.
    #[serde(default)]
    pub unchecked_pairs: Vec<[String; 2]>,
    /// Pose of the robot's root in the scene.
    #[schemars(with = "Option<PoseEntry>")]
    pub frame: Option<Spanned<PoseEntry>>,
    #[schemars(with = "StartEntry")]
    pub start: Spanned<StartEntry>,
    /// Height of the floor; `null`: there is none. Must be said.
    #[serde(deserialize_with = "Option::deserialize")]
    #[schemars(with = "Height")]
    pub floor: Option<Spanned<f64>>,
    #[serde(default)]
    pub obstacles: Vec<BodyEntry>,
    pub target: Option<BodyEntry>,
    /// Where the target can be put down.
    #[serde(default)]
    #[schemars(with = "Vec<PlaceEntry>")]
    pub places: Vec<Spanned<PlaceEntry>>,
    /// What is to be picked and put down, in order (`cranny plan --steps`).
    #[serde(default)]
    #[schemars(with = "Vec<StepEntry>")]
    pub steps: Vec<Spanned<StepEntry>>,
    /// Tasks of several stages (`cranny plan --task NAME`).
    #[serde(default)]
    pub tasks: Vec<TaskEntry>,
    /// Bounds that the tool keeps along every motion.
    #[serde(default)]
    #[schemars(with = "Vec<ToolBoundEntry>")]
    pub tool_bounds: Vec<Spanned<ToolBoundEntry>>,
    /// Values (m, rad) between which a joint stays along every motion, besides its limits.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, [f64; 2]>")]
    pub joint_bounds: BTreeMap<String, Spanned<[f64; 2]>>,
    /// Speeds of motions unless a plan is asked for others: under `all` or a mode (`reach`, `approach`, `lift-off`, `carry`,
    /// `set-down`, `retreat`, `return`).
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, SpeedEntry>")]
    pub speeds: BTreeMap<String, Spanned<SpeedEntry>>,
    #[schemars(with = "Option<CriterionName>")]
    pub criterion: Option<Criterion>,
}

/// A height that must be said, `null` for none.
struct Height;

impl JsonSchema for Height {
    fn schema_name() -> Cow<'static, str> {
        "Height".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": ["number", "null"] })
    }
}

/// What others need to know before they use a scenario.
#[derive(Clone, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct AboutEntry {
    pub title: Option<String>,
    pub author: Option<String>,
    /// An SPDX expression, such as `CC-BY-4.0`.
    pub licence: Option<String>,
    /// How it wants to be cited.
    pub citation: Option<String>,
}

/// An obstacle or the target.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct BodyEntry {
    #[schemars(with = "String")]
    pub name: Spanned<String>,
    #[schemars(with = "Option<PoseEntry>")]
    pub pose: Option<Spanned<PoseEntry>>,
    #[schemars(with = "Vec<ShapeEntry>")]
    pub shapes: Vec<Spanned<ShapeEntry>>,
    /// Mass (kg), before that of its object; positive.
    #[schemars(with = "Option<f64>")]
    pub mass_kg: Option<Spanned<f64>>,
    /// Coefficient of friction between it and the pads of a gripper, before that of its object; positive.
    #[schemars(with = "Option<f64>")]
    pub friction: Option<Spanned<f64>>,
    /// Resistance to rolling on what it stands on (m): the arm on which the normal force stops a turn; at least 0.
    #[schemars(with = "Option<f64>")]
    pub rolling_m: Option<Spanned<f64>>,
    /// Greatest tilt of it in the hand against how it stood when it was grasped, in degrees; above 0, at most 180.
    #[schemars(with = "Option<f64>")]
    pub upright_deg: Option<Spanned<f64>>,
}

/// A place where the target can be put down: a rectangle that lies on something, or a pose of the target.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct PlaceEntry {
    #[schemars(with = "String")]
    pub name: Spanned<String>,
    /// The obstacle that a rectangle lies on, or `floor`.
    pub on: Option<String>,
    /// The middle of the rectangle, z upwards.
    #[schemars(with = "Option<PoseEntry>")]
    pub pose: Option<Spanned<PoseEntry>>,
    /// How long the rectangle is along its x and y.
    pub size: Option<[f64; 2]>,
    /// Instead of a rectangle: the pose that the target is to have.
    #[schemars(with = "Option<PoseEntry>")]
    pub target_pose: Option<Spanned<PoseEntry>>,
}

/// Speeds of motions. What a mode leaves out is that of `all`, and what `all` leaves out that of the robot.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SpeedEntry {
    /// Share of the limits of velocity, above 0 and at most 1.
    pub speed: Option<f64>,
    /// Share of the limits of acceleration, above 0 and at most 1.
    pub acceleration: Option<f64>,
    /// Greatest speed of the gripper frame (m/s).
    pub tool_speed_m_s: Option<f64>,
    /// Greatest speed with which the hand, and what it holds, turns (°/s).
    pub turn_speed_deg_s: Option<f64>,
}

/// A bound on the tool: a box (`size`) or a ball (`radius`) in which a point of it stays, or a cone (`axis`, `toward`,
/// `within_deg`) in which a direction of it does.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ToolBoundEntry {
    #[schemars(with = "String")]
    pub name: Spanned<String>,
    /// The link that is bounded; without it the gripper frame, whose z points out of the palm and y along the closing.
    #[schemars(with = "Option<String>")]
    pub link: Option<Spanned<String>>,
    /// The point (m), in the frame of the link; without it its origin.
    pub point: Option<[f64; 3]>,
    /// Pose of the middle of the box or the ball in the scene; without it the scene's origin.
    #[schemars(with = "Option<PoseEntry>")]
    pub pose: Option<Spanned<PoseEntry>>,
    /// Full lengths of the box along x, y, z (m).
    pub size: Option<[f64; 3]>,
    /// Radius of the ball (m).
    pub radius: Option<f64>,
    /// The direction, in the frame of the link.
    pub axis: Option<[f64; 3]>,
    /// The direction from which it differs by at most `within_deg`.
    pub toward: Option<[f64; 3]>,
    /// Greatest angle between both, in degrees; above 0, at most 180.
    pub within_deg: Option<f64>,
}

/// A task: stages in order.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct TaskEntry {
    #[schemars(with = "String")]
    pub name: Spanned<String>,
    #[schemars(with = "Vec<Stage>")]
    pub stages: Vec<Spanned<Stage>>,
}

/// A step: a pick and a place.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct StepEntry {
    /// The target, or an obstacle.
    pub pick: String,
    /// A place of this file.
    pub place: String,
    /// Where the robot goes then: `home`, or nowhere, `stay`.
    #[serde(default)]
    #[schemars(with = "Option<ThenName>")]
    pub then: AfterPlacing,
    /// Mass (kg) of an obstacle that is picked, before that of its own entry (`cranny simulate plan`).
    #[schemars(with = "Option<f64>")]
    pub mass_kg: Option<Spanned<f64>>,
    /// The coefficient of friction between it and the pads of a gripper.
    #[schemars(with = "Option<f64>")]
    pub friction: Option<Spanned<f64>>,
}

/// How files spell where a robot goes once it has put something down.
#[derive(JsonSchema)]
#[schemars(rename = "Then", rename_all = "kebab-case")]
#[allow(dead_code, reason = "nobody makes one: its names are read as those of the other")]
pub(crate) enum ThenName {
    Home,
    Stay,
}

/// A pose; what is left out is zero.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct PoseEntry {
    #[serde(default)]
    pub position: [f64; 3],
    /// Roll, pitch, yaw about fixed axes, as in a URDF.
    pub rotation_rpy_deg: Option<[f64; 3]>,
    pub quaternion_xyzw: Option<[f64; 4]>,
}

/// One shape, under its kind, with its pose in the body.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ShapeEntry {
    #[schemars(with = "Option<PoseEntry>")]
    pub pose: Option<Spanned<PoseEntry>>,
    #[serde(rename = "box")]
    pub cuboid: Option<CuboidEntry>,
    pub sphere: Option<SphereEntry>,
    pub cylinder: Option<RoundEntry>,
    pub capsule: Option<RoundEntry>,
    pub mesh: Option<MeshEntry>,
    pub hull: Option<MeshEntry>,
    /// A built-in object (see `cranny object list`), or the folder of one.
    pub object: Option<String>,
}

/// Full lengths along x, y, z.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct CuboidEntry {
    pub size: [f64; 3],
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SphereEntry {
    pub radius: f64,
}

/// Along z; the length of a capsule is that of its cylindrical part.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct RoundEntry {
    pub radius: f64,
    pub length: f64,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct MeshEntry {
    pub file: PathBuf,
    pub scale: Option<f64>,
}

/// How files spell a criterion.
#[derive(JsonSchema)]
#[schemars(rename = "Criterion", rename_all = "kebab-case")]
#[allow(dead_code, reason = "nobody makes one: its names are read as those of the other")]
pub(crate) enum CriterionName {
    Exact,
    Paper,
}

/// The start: a list in the order of the joints, or a value for each joint by name.
pub(crate) enum StartEntry {
    List(Vec<Spanned<f64>>),
    ByJoint(Vec<(String, Spanned<f64>)>),
}

impl<'de> Deserialize<'de> for StartEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(StartVisitor)
    }
}

impl JsonSchema for StartEntry {
    fn schema_name() -> Cow<'static, str> {
        "Start".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A number (m, rad) for each joint: a list in the order of the joints, or by name.",
            "anyOf": [
                { "type": "array", "items": { "type": "number" } },
                { "type": "object", "additionalProperties": { "type": "number" } },
            ],
        })
    }
}

/// Written out, because an untagged enum would lose the lines of the values.
struct StartVisitor;

impl<'de> Visitor<'de> for StartVisitor {
    type Value = StartEntry;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("a list of numbers, or a number for each joint by its name")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut values: A) -> Result<StartEntry, A::Error> {
        let mut list = Vec::new();
        while let Some(value) = values.next_element()? {
            list.push(value);
        }
        Ok(StartEntry::List(list))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut values: A) -> Result<StartEntry, A::Error> {
        let mut by_joint = Vec::new();
        while let Some(entry) = values.next_entry()? {
            by_joint.push(entry);
        }
        Ok(StartEntry::ByJoint(by_joint))
    }
}
