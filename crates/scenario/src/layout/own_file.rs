//! Schema of a `scenario.yaml`. See `own_layout` for its interpretation.

use std::borrow::Cow;
use std::collections::{BTreeMap, HashSet};
use std::fmt;
use std::path::PathBuf;

use cranny_task::{AfterPlacing, Criterion, Region, Stage};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use serde_saphyr::Spanned;

use crate::Friction;
use crate::seen::seen_entry::SeenEntry;

/// Scenario file. Poses and heights are in the scene frame; metres, and degrees where the key contains `deg`.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ScenarioFile {
    /// Built-in robot such as `panda_mobile`, or path of a robot folder or a URDF, relative to the folder of this file.
    #[schemars(with = "String")]
    pub robot: Spanned<String>,
    /// Title, author, licence and citation.
    pub about: Option<AboutEntry>,
    /// SRDF of the robot, with pairs of links that may touch. An SRDF beside the URDF is found without this key.
    pub srdf: Option<PathBuf>,
    /// Group of the SRDF whose joints move. Default: all joints from the root to the tip.
    pub group: Option<String>,
    /// Folders in which the `package://` names of the URDF are resolved.
    #[serde(default)]
    pub packages: Vec<PathBuf>,
    /// Link whose frame is the gripper frame.
    pub tip: Option<String>,
    /// Positions (m, rad) of joints outside the group, by name.
    #[serde(default)]
    pub fixed: BTreeMap<String, f64>,
    /// Pairs of links that may touch and are not checked against each other, in addition to those of the SRDF.
    #[serde(default)]
    pub unchecked_pairs: Vec<[String; 2]>,
    /// Pose of the robot's root in the scene.
    #[schemars(with = "Option<PoseEntry>")]
    pub frame: Option<Spanned<PoseEntry>>,
    /// Start configuration. Default: that of the robot's own files.
    #[schemars(with = "Option<StartEntry>")]
    pub start: Option<Spanned<StartEntry>>,
    /// Height of the floor; `null`: no floor. Required.
    #[serde(deserialize_with = "Option::deserialize")]
    #[schemars(with = "Height")]
    pub floor: Option<Spanned<f64>>,
    #[serde(default)]
    pub obstacles: Vec<BodyEntry>,
    pub target: Option<BodyEntry>,
    /// Places where the target can be put down.
    #[serde(default)]
    #[schemars(with = "Vec<PlaceEntry>")]
    pub places: Vec<Spanned<PlaceEntry>>,
    /// Goal regions by name (`cranny plan --goal-region NAME`, and stages with `move`).
    #[serde(default)]
    pub regions: BTreeMap<String, Region>,
    /// Pick and place steps, in order (`cranny plan --steps`).
    #[serde(default)]
    #[schemars(with = "Vec<StepEntry>")]
    pub steps: Vec<Spanned<StepEntry>>,
    /// Tasks of several stages (`cranny plan --task NAME`).
    #[serde(default)]
    pub tasks: Vec<TaskEntry>,
    /// Bounds on the tool along every motion.
    #[serde(default)]
    #[schemars(with = "Vec<ToolBoundEntry>")]
    pub tool_bounds: Vec<Spanned<ToolBoundEntry>>,
    /// Bounds (m, rad) of a joint along every motion, in addition to its limits.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, [f64; 2]>")]
    pub joint_bounds: BTreeMap<String, Spanned<[f64; 2]>>,
    /// Default speeds of motions, which a plan can override: under `all` or a mode (`reach`, `approach`, `lift-off`, `carry`,
    /// `set-down`, `retreat`, `return`).
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, SpeedEntry>")]
    pub speeds: BTreeMap<String, Spanned<SpeedEntry>>,
    /// Views of depth cameras: obstacles, in addition to those above, are all surfaces that they show and, unless `unseen` is `free`,
    /// all space that none of them has seen.
    #[schemars(with = "Option<SeenEntry>")]
    pub seen: Option<Spanned<SeenEntry>>,
    #[schemars(with = "Option<CriterionName>")]
    pub criterion: Option<Criterion>,
}

impl ScenarioFile {
    /// Location of the start, or of the robot whose own start it is.
    pub fn start_place(&self) -> serde_saphyr::Location {
        self.start.as_ref().map_or(self.robot.referenced, |start| start.referenced)
    }

    /// Returns the names of the obstacles.
    pub fn obstacle_names(&self) -> HashSet<&str> {
        self.obstacles.iter().map(|obstacle| obstacle.name.value.as_str()).collect()
    }
}

/// Required height; `null` for none.
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

/// Title, author, licence and citation of a scenario.
#[derive(Clone, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct AboutEntry {
    pub title: Option<String>,
    pub author: Option<String>,
    /// SPDX expression, such as `CC-BY-4.0`.
    pub licence: Option<String>,
    /// Requested citation.
    pub citation: Option<String>,
}

/// Obstacle or target: its shapes, or the file of a cloud alone.
pub(crate) struct BodyEntry {
    pub name: Spanned<String>,
    pub pose: Option<Spanned<PoseEntry>>,
    pub shapes: Vec<Spanned<ShapeEntry>>,
    pub mass_kg: Option<Spanned<f64>>,
    pub friction: Option<Spanned<Friction>>,
    pub rolling_m: Option<Spanned<f64>>,
    pub upright_deg: Option<Spanned<f64>>,
}

/// Keys of an obstacle or the target: `name` and `shapes`, or `cloud` and `radius_m`.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("anyOf" = [{ "required": ["name", "shapes"] }, { "required": ["cloud", "radius_m"] }]))]
struct BodyKeys {
    /// Name. Default for a cloud: the name of its file, without its ending.
    #[schemars(with = "Option<String>")]
    name: Option<Spanned<String>>,
    #[schemars(with = "Option<PoseEntry>")]
    pose: Option<Spanned<PoseEntry>>,
    #[schemars(with = "Option<Vec<ShapeEntry>>")]
    shapes: Option<Vec<Spanned<ShapeEntry>>>,
    /// Point cloud of a file (PLY, PCD or `NumPy` array), instead of shapes; for obstacles only.
    #[schemars(with = "Option<PathBuf>")]
    cloud: Option<Spanned<PathBuf>>,
    /// Radius of the ball around each point of the cloud.
    radius_m: Option<f64>,
    /// Side of voxels of which one point of the cloud each is kept; their diagonal is added to the radius.
    voxel_m: Option<f64>,
    /// Colour of the cloud in pictures: red, green and blue, 0 to 1 (sRGB).
    colour: Option<[f64; 3]>,
    /// Mass (kg), which takes precedence over that of its object; positive.
    #[schemars(with = "Option<f64>")]
    mass_kg: Option<Spanned<f64>>,
    /// Coefficient of friction between it and the pads of a gripper, which takes precedence over that of its object.
    #[schemars(with = "Option<Friction>")]
    friction: Option<Spanned<Friction>>,
    /// Rolling resistance on its support (m): the lever arm on which the normal force stops a rotation; at least 0.
    #[schemars(with = "Option<f64>")]
    rolling_m: Option<Spanned<f64>>,
    /// Maximum tilt in the hand relative to its orientation when grasped, in degrees; above 0, at most 180.
    #[schemars(with = "Option<f64>")]
    upright_deg: Option<Spanned<f64>>,
}

impl BodyEntry {
    fn of<E: Error>(keys: BodyKeys) -> Result<Self, E> {
        let BodyKeys {
            name,
            pose,
            shapes,
            cloud,
            radius_m,
            voxel_m,
            colour,
            mass_kg,
            friction,
            rolling_m,
            upright_deg,
        } = keys;
        let (name, shapes) = match (cloud, shapes) {
            (None, shapes) if radius_m.or(voxel_m).is_none() && colour.is_none() => {
                let name = name.ok_or_else(|| E::missing_field("name"))?;
                (name, shapes.ok_or_else(|| E::missing_field("shapes"))?)
            }
            (None, _) => {
                return Err(E::custom(
                    "`radius_m`, `voxel_m` and `colour` of a body need `cloud: FILE` (each of its `shapes` has a `colour`)",
                ));
            }
            (Some(_), Some(_)) => return Err(E::custom("a body has either `shapes` or a `cloud`")),
            (Some(file), None) => {
                let Spanned { value: file, referenced, defined } = file;
                let radius_m = radius_m.ok_or_else(|| E::missing_field("radius_m"))?;
                let stem = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
                let cloud = Some(CloudEntry { file, radius_m, voxel_m });
                let shape = ShapeEntry { cloud, colour, ..ShapeEntry::default() };
                let name = name.unwrap_or_else(|| Spanned::new(stem, referenced, defined));
                (name, vec![Spanned::new(shape, referenced, defined)])
            }
        };
        Ok(Self { name, pose, shapes, mass_kg, friction, rolling_m, upright_deg })
    }
}

impl<'de> Deserialize<'de> for BodyEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(BodyVisitor)
    }
}

impl JsonSchema for BodyEntry {
    fn schema_name() -> Cow<'static, str> {
        "BodyEntry".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        BodyKeys::json_schema(generator)
    }
}

/// Visitor of a body: errors of all its keys have their lines.
struct BodyVisitor;

impl<'de> Visitor<'de> for BodyVisitor {
    type Value = BodyEntry;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("an obstacle or a target, with its keys")
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<BodyEntry, A::Error> {
        BodyEntry::of(BodyKeys::deserialize(MapAccessDeserializer::new(map))?)
    }
}

/// Place where the target can be put down: a rectangle on a support, or a pose of the target.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct PlaceEntry {
    #[schemars(with = "String")]
    pub name: Spanned<String>,
    /// Obstacle on which the rectangle lies, or `floor`.
    pub on: Option<String>,
    /// Pose of the centre of the rectangle, z upwards.
    #[schemars(with = "Option<PoseEntry>")]
    pub pose: Option<Spanned<PoseEntry>>,
    /// Lengths of the rectangle along its x and y.
    pub size: Option<[f64; 2]>,
    /// Target pose; alternative to a rectangle.
    #[schemars(with = "Option<PoseEntry>")]
    pub target_pose: Option<Spanned<PoseEntry>>,
}

/// Speeds of motions. Missing values of a mode are those of `all`, and missing values of `all` those of the robot.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SpeedEntry {
    /// Share of the velocity limits, above 0 and at most 1.
    pub speed: Option<f64>,
    /// Share of the acceleration limits, above 0 and at most 1.
    pub acceleration: Option<f64>,
    /// Maximum speed of the gripper frame (m/s).
    pub tool_speed_m_s: Option<f64>,
    /// Maximum angular speed of the hand and the held object (°/s).
    pub turn_speed_deg_s: Option<f64>,
}

/// Bound on the tool: a box (`size`) or a ball (`radius`) for a point, or a cone (`axis`, `toward`, `within_deg`) for a
/// direction.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ToolBoundEntry {
    #[schemars(with = "String")]
    pub name: Spanned<String>,
    /// Bounded link. Default: the gripper frame, whose z axis points out of the palm and y axis along the closing direction.
    #[schemars(with = "Option<String>")]
    pub link: Option<Spanned<String>>,
    /// Bounded point (m), in the frame of the link. Default: its origin.
    pub point: Option<[f64; 3]>,
    /// Pose of the centre of the box or the ball in the scene. Default: the origin of the scene.
    #[schemars(with = "Option<PoseEntry>")]
    pub pose: Option<Spanned<PoseEntry>>,
    /// Full lengths of the box along x, y, z (m).
    pub size: Option<[f64; 3]>,
    /// Radius of the ball (m).
    pub radius: Option<f64>,
    /// Bounded direction, in the frame of the link.
    pub axis: Option<[f64; 3]>,
    /// Axis of the cone, in the scene; the bounded direction differs from it by at most `within_deg`.
    pub toward: Option<[f64; 3]>,
    /// Maximum angle between both directions, in degrees; above 0, at most 180.
    pub within_deg: Option<f64>,
}

/// Task: stages in order.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct TaskEntry {
    #[schemars(with = "String")]
    pub name: Spanned<String>,
    #[schemars(with = "Vec<Stage>")]
    pub stages: Vec<Spanned<Stage>>,
}

/// Step: a pick and a place.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct StepEntry {
    /// Object to pick: the target or an obstacle.
    pub pick: String,
    /// Name of a place of this file.
    pub place: String,
    /// Motion after placing: `home`, or none with `stay`.
    #[serde(default)]
    #[schemars(with = "Option<ThenName>")]
    pub then: AfterPlacing,
    /// Mass (kg) of a picked obstacle, which takes precedence over that of its own entry (`cranny simulate plan`).
    #[schemars(with = "Option<f64>")]
    pub mass_kg: Option<Spanned<f64>>,
    /// Coefficient of friction between it and the pads of a gripper.
    #[schemars(with = "Option<Friction>")]
    pub friction: Option<Spanned<Friction>>,
}

/// Spelling of the motion after placing in files.
#[derive(JsonSchema)]
#[schemars(rename = "Then", rename_all = "kebab-case")]
#[allow(dead_code, reason = "nobody makes one: its names are read as those of the other")]
pub(crate) enum ThenName {
    Home,
    Stay,
}

/// Pose; missing values are zero.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct PoseEntry {
    #[serde(default)]
    pub position: [f64; 3],
    /// Roll, pitch, yaw about fixed axes, as in a URDF.
    pub rotation_rpy_deg: Option<[f64; 3]>,
    pub quaternion_xyzw: Option<[f64; 4]>,
}

/// Shape under the key of its kind, with its pose in the frame of the body.
#[derive(Default, Deserialize, JsonSchema)]
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
    /// Points of a cloud, each a ball; for obstacles only.
    pub cloud: Option<CloudEntry>,
    /// Built-in object (see `cranny object list`), or folder of an object.
    pub object: Option<String>,
    /// Colour in pictures: red, green and blue, 0 to 1 (sRGB). Default: that of the mesh file or the object, if it has one.
    pub colour: Option<[f64; 3]>,
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

/// Dimensions along z; the length of a capsule is that of its cylindrical section.
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

/// Cloud of a file: PLY, PCD or `NumPy` array.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct CloudEntry {
    pub file: PathBuf,
    /// Radius of the ball around each point: the noise, and half of the distance between points.
    pub radius_m: f64,
    /// Side of voxels of which one point each is kept; their diagonal is added to the radius.
    pub voxel_m: Option<f64>,
}

/// Spelling of a criterion in files.
#[derive(JsonSchema)]
#[schemars(rename = "Criterion", rename_all = "kebab-case")]
#[allow(dead_code, reason = "nobody makes one: its names are read as those of the other")]
pub(crate) enum CriterionName {
    Exact,
    Paper,
}

/// Start: a list in joint order, or a value per joint name.
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

/// Visitor of a start; an untagged enum would lose the lines of the values.
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
