//! What `MoveIt` scene and request files may say, as far as it is read. See `moveit` for what becomes of it.
//!
//! Keys that do not change the problem (colours, scaling factors, planner names, …) are passed over; those
//! that would, and are not read, are looked at so that they can be refused.

use std::fmt;
use std::marker::PhantomData;

use serde::de::{Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use serde_saphyr::Spanned;

/// A `PlanningScene`.
#[derive(Deserialize)]
pub(crate) struct SceneFile {
    #[serde(default)]
    pub robot_model_name: String,
    #[serde(default)]
    pub robot_state: StateEntry,
    #[serde(default)]
    pub fixed_frame_transforms: Vec<TransformEntry>,
    #[serde(default)]
    pub allowed_collision_matrix: MatrixEntry,
    #[serde(default)]
    pub link_padding: Vec<PaddingEntry>,
    #[serde(default)]
    pub link_scale: Vec<ScaleEntry>,
    #[serde(default)]
    pub world: WorldEntry,
}

#[derive(Default, Deserialize)]
pub(crate) struct WorldEntry {
    #[serde(default)]
    pub collision_objects: Vec<ObjectEntry>,
    pub octomap: Option<Spanned<IgnoredAny>>,
}

#[derive(Deserialize)]
pub(crate) struct PaddingEntry {
    pub padding: Spanned<f64>,
}

#[derive(Deserialize)]
pub(crate) struct ScaleEntry {
    pub scale: Spanned<f64>,
}

#[derive(Deserialize)]
pub(crate) struct TransformEntry {
    #[serde(default)]
    pub header: HeaderEntry,
    pub child_frame_id: String,
    pub transform: Spanned<PoseEntry>,
}

/// Which pairs of links and objects may touch: rows and columns in the order of the names.
#[derive(Default, Deserialize)]
pub(crate) struct MatrixEntry {
    #[serde(default)]
    pub entry_names: Vec<String>,
    #[serde(default)]
    pub entry_values: Vec<RowEntry>,
}

/// A row of the matrix: a list, or a list under the key `enabled`.
#[derive(Deserialize)]
#[serde(untagged, expecting = "expected a list of true and false")]
pub(crate) enum RowEntry {
    List(Vec<bool>),
    Message { enabled: Vec<bool> },
}

#[derive(Deserialize)]
pub(crate) struct ObjectEntry {
    pub id: Spanned<String>,
    #[serde(default)]
    pub header: HeaderEntry,
    pub pose: Option<Spanned<PoseEntry>>,
    #[serde(default)]
    pub primitives: Vec<Spanned<PrimitiveEntry>>,
    #[serde(default)]
    pub primitive_poses: Vec<Spanned<PoseEntry>>,
    #[serde(default)]
    pub meshes: Vec<Spanned<MeshEntry>>,
    #[serde(default)]
    pub mesh_poses: Vec<Spanned<PoseEntry>>,
    #[serde(default)]
    pub planes: Vec<Spanned<IgnoredAny>>,
    pub operation: Option<Spanned<NameOrNumber>>,
}

/// The frame that a message is in; empty: the world.
#[derive(Default, Deserialize)]
pub(crate) struct HeaderEntry {
    pub frame_id: Option<Spanned<String>>,
}

#[derive(Deserialize)]
pub(crate) struct PrimitiveEntry {
    #[serde(rename = "type")]
    pub kind: NameOrNumber,
    pub dimensions: Vec<Spanned<f64>>,
}

/// What the message definitions number, and files spell out.
#[derive(Deserialize)]
#[serde(untagged, expecting = "expected a name, or the number that stands for it")]
pub(crate) enum NameOrNumber {
    Number(u8),
    Name(String),
}

/// A mesh in the file itself, or the name of a mesh file.
#[derive(Deserialize)]
pub(crate) struct MeshEntry {
    #[serde(default)]
    pub vertices: Vec<Spanned<Components<3>>>,
    #[serde(default)]
    pub triangles: Vec<TriangleEntry>,
    pub resource: Option<String>,
    /// Scale of `resource` along each axis.
    pub dimensions: Option<Components<3>>,
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "expected the three corners of a triangle, by their numbers")]
pub(crate) enum TriangleEntry {
    List([u32; 3]),
    Message { vertex_indices: [u32; 3] },
}

/// A pose, or a transform, whose parts go by other names; what is left out is zero.
#[derive(Deserialize)]
pub(crate) struct PoseEntry {
    #[serde(alias = "translation")]
    pub position: Option<Components<3>>,
    /// x, y, z, w.
    #[serde(alias = "rotation")]
    pub orientation: Option<Components<4>>,
}

/// A `MotionPlanRequest`.
#[derive(Deserialize)]
pub(crate) struct RequestFile {
    pub group_name: Spanned<String>,
    #[serde(default)]
    pub start_state: StateEntry,
    pub goal_constraints: Option<Spanned<Vec<Spanned<ConstraintsEntry>>>>,
    pub path_constraints: Option<Spanned<ConstraintsEntry>>,
}

#[derive(Default, Deserialize)]
pub(crate) struct StateEntry {
    pub joint_state: Option<Spanned<JointStateEntry>>,
    pub multi_dof_joint_state: Option<Spanned<FloatingStateEntry>>,
    pub attached_collision_objects: Option<Spanned<Vec<IgnoredAny>>>,
}

#[derive(Deserialize)]
pub(crate) struct JointStateEntry {
    #[serde(default)]
    pub name: Vec<Spanned<String>>,
    #[serde(default)]
    pub position: Vec<Spanned<f64>>,
}

#[derive(Deserialize)]
pub(crate) struct FloatingStateEntry {
    #[serde(default)]
    pub transforms: Vec<Spanned<PoseEntry>>,
}

#[derive(Deserialize)]
pub(crate) struct ConstraintsEntry {
    #[serde(default, rename = "joint_constraints")]
    pub joints: Vec<JointConstraintEntry>,
    #[serde(default, rename = "position_constraints")]
    pub positions: Vec<IgnoredAny>,
    #[serde(default, rename = "orientation_constraints")]
    pub orientations: Vec<IgnoredAny>,
    #[serde(default, rename = "visibility_constraints")]
    pub visibilities: Vec<IgnoredAny>,
}

#[derive(Deserialize)]
pub(crate) struct JointConstraintEntry {
    pub joint_name: Spanned<String>,
    pub position: Spanned<f64>,
}

/// x, y, z and so on: a list, or a number under each letter.
#[derive(Clone, Copy)]
pub(crate) struct Components<const N: usize>(pub [f64; N]);

impl<'de, const N: usize> Deserialize<'de> for Components<N> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ComponentsVisitor(PhantomData)).map(Self)
    }
}

const LETTERS: [&str; 4] = ["x", "y", "z", "w"];

struct ComponentsVisitor<const N: usize>(PhantomData<[f64; N]>);

impl<'de, const N: usize> Visitor<'de> for ComponentsVisitor<N> {
    type Value = [f64; N];

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "a list of {N} numbers, or one under each of {}", LETTERS[..N].join(", "))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut values: A) -> Result<[f64; N], A::Error> {
        let mut found = Vec::with_capacity(N);
        while let Some(value) = values.next_element()? {
            found.push(value);
        }
        found.try_into().map_err(|found: Vec<f64>| Error::invalid_length(found.len(), &self))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut values: A) -> Result<[f64; N], A::Error> {
        let mut found = [None; N];
        while let Some(key) = values.next_key::<String>()? {
            let position = LETTERS[..N].iter().position(|letter| *letter == key);
            let position = position.ok_or_else(|| Error::unknown_field(&key, &LETTERS[..N]))?;
            found[position] = Some(values.next_value()?);
        }
        let mut numbers = [0.0; N];
        for ((number, found), letter) in numbers.iter_mut().zip(found).zip(LETTERS) {
            *number = found.ok_or_else(|| Error::missing_field(letter))?;
        }
        Ok(numbers)
    }
}
