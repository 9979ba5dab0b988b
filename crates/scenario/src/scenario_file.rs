//! What a `scenario.yaml` may say. See `own_layout` for what becomes of it.

use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;

use cranny_plan::Criterion;
use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use serde_saphyr::Spanned;

/// The whole file. Poses and heights are in the scene frame; metres, and degrees where the key says so.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ScenarioFile {
    /// `panda_mobile`, or the path of a URDF.
    pub robot: String,
    pub srdf: Option<PathBuf>,
    pub tip: Option<String>,
    /// Joints outside the group, and where they stand.
    #[serde(default)]
    pub fixed: BTreeMap<String, f64>,
    /// Pose of the robot's root in the scene.
    pub frame: Option<Spanned<PoseEntry>>,
    pub start: Spanned<StartEntry>,
    /// Height of the floor; `null`: there is none. Must be said.
    #[serde(deserialize_with = "Option::deserialize")]
    pub floor: Option<Spanned<f64>>,
    #[serde(default)]
    pub obstacles: Vec<BodyEntry>,
    pub target: Option<BodyEntry>,
    pub criterion: Option<CriterionEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct BodyEntry {
    pub name: Spanned<String>,
    pub pose: Option<Spanned<PoseEntry>>,
    pub shapes: Vec<Spanned<ShapeEntry>>,
}

/// A pose; what is left out is zero.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PoseEntry {
    #[serde(default)]
    pub position: [f64; 3],
    /// Roll, pitch, yaw about fixed axes, as in a URDF.
    pub rotation_rpy_deg: Option<[f64; 3]>,
    pub quaternion_xyzw: Option<[f64; 4]>,
}

/// One shape, under its kind, with its pose in the body.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ShapeEntry {
    pub pose: Option<Spanned<PoseEntry>>,
    #[serde(rename = "box")]
    pub cuboid: Option<CuboidEntry>,
    pub sphere: Option<SphereEntry>,
    pub cylinder: Option<RoundEntry>,
    pub capsule: Option<RoundEntry>,
    pub mesh: Option<MeshEntry>,
    pub hull: Option<MeshEntry>,
}

/// Full lengths along x, y, z.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CuboidEntry {
    pub size: [f64; 3],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SphereEntry {
    pub radius: f64,
}

/// Along z; the length of a capsule is that of its cylindrical part.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RoundEntry {
    pub radius: f64,
    pub length: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MeshEntry {
    pub file: PathBuf,
    pub scale: Option<f64>,
}

/// How files spell a criterion.
#[derive(Serialize, Deserialize)]
#[serde(remote = "Criterion", rename_all = "kebab-case")]
pub(crate) enum CriterionName {
    Exact,
    Paper,
}

/// A criterion as the value of a key.
#[derive(Deserialize)]
#[serde(transparent)]
pub(crate) struct CriterionEntry(#[serde(with = "CriterionName")] pub Criterion);

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
