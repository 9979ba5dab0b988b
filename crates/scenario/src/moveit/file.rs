//! Messages of `MoveIt` scenes and requests, key by key. See `moveit` for their interpretation.
//!
//! Every message lists all keys that it has in any version of `MoveIt` and refuses all others, so a key that is misspelt or
//! misplaced cannot count as missing. Keys of type [`Passed`] have no effect on the problem. All other keys are supported, or
//! refused if their value is not supported.
#![expect(dead_code, reason = "what has no bearing on the problem is listed, and not read")]

use std::fmt;
use std::marker::PhantomData;

use cranny_collision::Body;
use serde::de::{Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use serde_saphyr::Spanned;

/// Value without effect on the problem.
type Passed = IgnoredAny;

/// List that is refused unless it is empty.
pub(crate) type Refused = Option<Spanned<Vec<IgnoredAny>>>;

/// A `PlanningScene`.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct SceneFile {
    pub name: Option<String>,
    pub robot_model_name: String,
    pub robot_state: StateEntry,
    pub fixed_frame_transforms: Vec<TransformEntry>,
    pub allowed_collision_matrix: MatrixEntry,
    pub link_padding: Vec<PaddingEntry>,
    pub link_scale: Vec<ScaleEntry>,
    object_colors: Passed,
    pub world: Option<WorldEntry>,
    pub is_diff: Option<Spanned<bool>>,
}

impl SceneFile {
    /// Returns a scene that consists of a world only.
    pub fn of(world: WorldEntry) -> Self {
        Self { world: Some(world), ..Self::default() }
    }
}

/// A `PlanningSceneWorld`.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct WorldEntry {
    pub collision_objects: Vec<ObjectEntry>,
    pub octomap: Option<Spanned<OctomapEntry>>,
    /// Bodies of a `.scene` text, in the planning frame.
    #[serde(skip)]
    pub text_bodies: Vec<Body>,
}

/// An `OctomapWithPose`.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct OctomapEntry {
    pub header: Option<HeaderEntry>,
    /// Pose of the tree in that frame.
    pub origin: Option<Spanned<PoseEntry>>,
    pub octomap: Option<OctreeEntry>,
}

/// An `Octomap`.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct OctreeEntry {
    header: Passed,
    pub binary: Option<bool>,
    /// Class of the tree.
    pub id: Option<String>,
    pub resolution: Option<Spanned<f64>>,
    pub data: Option<OctreeData>,
}

/// Bytes, as a list or as a text.
#[derive(Deserialize)]
#[serde(untagged, expecting = "expected a list of numbers, or a text")]
pub(crate) enum OctreeData {
    List(Vec<i64>),
    Text(String),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PaddingEntry {
    #[serde(default)]
    link_name: Passed,
    pub padding: Spanned<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ScaleEntry {
    #[serde(default)]
    link_name: Passed,
    pub scale: Spanned<f64>,
}

/// A `TransformStamped`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TransformEntry {
    #[serde(default)]
    pub header: HeaderEntry,
    pub child_frame_id: Spanned<String>,
    pub transform: Spanned<PoseEntry>,
}

/// An `AllowedCollisionMatrix`: rows and columns in the order of the names.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct MatrixEntry {
    pub entry_names: Option<Spanned<Vec<String>>>,
    pub entry_values: Vec<RowEntry>,
    pub default_entry_names: Vec<String>,
    pub default_entry_values: Vec<bool>,
}

/// Row of the matrix: a list, or a list under the key `enabled`.
#[derive(Deserialize)]
#[serde(untagged, expecting = "expected a list of true and false")]
pub(crate) enum RowEntry {
    List(Vec<bool>),
    Message(RowMessage),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RowMessage {
    enabled: Vec<bool>,
}

impl RowEntry {
    pub fn values(&self) -> &[bool] {
        match self {
            Self::List(values) | Self::Message(RowMessage { enabled: values }) => values,
        }
    }
}

/// A `CollisionObject`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ObjectEntry {
    pub id: Spanned<String>,
    #[serde(default)]
    pub header: HeaderEntry,
    pub pose: Option<Spanned<PoseEntry>>,
    #[serde(default, rename = "type")]
    kind: Passed,
    #[serde(default)]
    pub primitives: Vec<Spanned<PrimitiveEntry>>,
    #[serde(default)]
    pub primitive_poses: Vec<Spanned<PoseEntry>>,
    #[serde(default)]
    pub meshes: Vec<Spanned<MeshEntry>>,
    #[serde(default)]
    pub mesh_poses: Vec<Spanned<PoseEntry>>,
    pub planes: Refused,
    pub plane_poses: Refused,
    // Frames on the object; no supported key refers to them.
    #[serde(default)]
    subframe_names: Passed,
    #[serde(default)]
    subframe_poses: Passed,
    pub operation: Option<Spanned<NameOrNumber>>,
}

/// Frame of a message; empty: the planning frame.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct HeaderEntry {
    seq: Passed,
    stamp: Passed,
    pub frame_id: Option<Spanned<String>>,
}

/// A `SolidPrimitive`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PrimitiveEntry {
    #[serde(rename = "type")]
    pub kind: NameOrNumber,
    pub dimensions: Vec<Spanned<f64>>,
    // Only for a prism, which is refused.
    #[serde(default)]
    polygon: Passed,
}

/// Value that the message definitions number and files may write as a name.
#[derive(Deserialize)]
#[serde(untagged, expecting = "expected a name, or the number that stands for it")]
pub(crate) enum NameOrNumber {
    Number(u8),
    Name(String),
}

impl NameOrNumber {
    /// Returns its lower-case name in `names`, the first of which has the number `first`. A byte may be a text, as in Python.
    pub fn name(&self, names: &[&str], first: u8) -> String {
        let number = match self {
            Self::Number(number) => *number,
            Self::Name(name) => match name.as_bytes() {
                &[byte] if byte.is_ascii_control() => byte,
                _ => return name.to_lowercase(),
            },
        };
        let name = number.checked_sub(first).and_then(|index| names.get(usize::from(index)));
        name.map_or_else(|| number.to_string(), |name| (*name).to_owned())
    }
}

/// Mesh in the file itself, or name of a mesh file.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct MeshEntry {
    pub vertices: Vec<Spanned<Components<3>>>,
    pub triangles: Vec<TriangleEntry>,
    pub resource: Option<String>,
    /// Scale of `resource` along each axis.
    pub dimensions: Option<Components<3>>,
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "expected the three corners of a triangle, by their numbers")]
pub(crate) enum TriangleEntry {
    List([u32; 3]),
    Message(TriangleMessage),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TriangleMessage {
    vertex_indices: [u32; 3],
}

impl TriangleEntry {
    pub fn corners(&self) -> [u32; 3] {
        match self {
            Self::List(corners) | Self::Message(TriangleMessage { vertex_indices: corners }) => *corners,
        }
    }
}

/// Pose, or a transform, which has other key names; missing values are zero.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct PoseEntry {
    #[serde(alias = "translation")]
    pub position: Option<Components<3>>,
    /// x, y, z, w.
    #[serde(alias = "rotation")]
    pub orientation: Option<Components<4>>,
}

/// A `MotionPlanRequest`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RequestFile {
    pub group_name: Spanned<String>,
    #[serde(default)]
    pub start_state: StateEntry,
    pub goal_constraints: Option<Spanned<Vec<Spanned<ConstraintsEntry>>>>,
    pub path_constraints: Option<Spanned<ConstraintsEntry>>,
    pub trajectory_constraints: Option<Spanned<TrajectoryConstraintsEntry>>,
    /// Share of the velocity limits, from 0 to 1; 0 if it is not given.
    #[serde(default)]
    pub max_velocity_scaling_factor: Option<Spanned<f64>>,
    #[serde(default)]
    pub max_acceleration_scaling_factor: Option<Spanned<f64>>,
    pub max_cartesian_speed: Option<Spanned<f64>>,
    /// Time for planning, in seconds; 0 if it is not given.
    pub allowed_planning_time: Option<Spanned<f64>>,
    // Workspace, planner and attempts of a search by `MoveIt`.
    #[serde(default)]
    workspace_parameters: Passed,
    #[serde(default)]
    planner_id: Passed,
    #[serde(default)]
    pipeline_id: Passed,
    #[serde(default)]
    num_planning_attempts: Passed,
    // Hint for planners that start from a trajectory.
    #[serde(default)]
    reference_trajectories: Passed,
    /// Link whose speed `max_cartesian_speed` limits; empty: the tip of the group.
    pub cartesian_speed_limited_link: Option<Spanned<String>>,
    /// Earlier name of that key.
    pub cartesian_speed_end_effector_link: Option<Spanned<String>>,
}

/// A `RobotState`.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct StateEntry {
    pub joint_state: Option<Spanned<JointStateEntry>>,
    pub multi_dof_joint_state: Option<Spanned<FloatingStateEntry>>,
    pub attached_collision_objects: Refused,
    // Without effect: joints missing in the request always have their value in the scene.
    is_diff: Passed,
}

/// A `JointState`.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct JointStateEntry {
    // Positions of joints have no frame.
    header: Passed,
    pub name: Vec<Spanned<String>>,
    pub position: Vec<Spanned<f64>>,
    pub velocity: Vec<Spanned<f64>>,
    effort: Passed,
}

/// A `MultiDOFJointState`.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct FloatingStateEntry {
    pub header: HeaderEntry,
    pub joint_names: Vec<String>,
    pub transforms: Vec<Spanned<PoseEntry>>,
    twist: Passed,
    wrench: Passed,
}

/// `Constraints`.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct ConstraintsEntry {
    name: Passed,
    #[serde(rename = "joint_constraints")]
    pub joints: Vec<JointConstraintEntry>,
    #[serde(rename = "position_constraints")]
    pub positions: Vec<Spanned<PositionConstraintEntry>>,
    #[serde(rename = "orientation_constraints")]
    pub orientations: Vec<Spanned<OrientationConstraintEntry>>,
    #[serde(rename = "visibility_constraints")]
    pub visibilities: Vec<IgnoredAny>,
}

impl ConstraintsEntry {
    /// Returns true if it has constraints other than joint values.
    pub fn has_others(&self) -> bool {
        !(self.positions.is_empty() && self.orientations.is_empty() && self.visibilities.is_empty())
    }
}

/// `TrajectoryConstraints`.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct TrajectoryConstraintsEntry {
    pub constraints: Vec<IgnoredAny>,
}

/// A `JointConstraint`; a goal must be reached exactly, without its tolerances.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct JointConstraintEntry {
    pub joint_name: Spanned<String>,
    pub position: Spanned<f64>,
    #[serde(default)]
    pub tolerance_above: Option<Spanned<f64>>,
    #[serde(default)]
    pub tolerance_below: Option<Spanned<f64>>,
    #[serde(default)]
    weight: Passed,
}

/// A `PositionConstraint`: a point of a link stays in a region.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PositionConstraintEntry {
    #[serde(default)]
    pub header: HeaderEntry,
    pub link_name: Spanned<String>,
    #[serde(default)]
    pub target_point_offset: Option<Components<3>>,
    pub constraint_region: RegionEntry,
    #[serde(default)]
    weight: Passed,
}

/// A `BoundingVolume`.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct RegionEntry {
    pub primitives: Vec<Spanned<PrimitiveEntry>>,
    pub primitive_poses: Vec<Spanned<PoseEntry>>,
    pub meshes: Vec<IgnoredAny>,
    mesh_poses: Passed,
}

/// An `OrientationConstraint`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct OrientationConstraintEntry {
    #[serde(default)]
    pub header: HeaderEntry,
    #[serde(default)]
    pub orientation: Option<Components<4>>,
    pub link_name: Spanned<String>,
    pub absolute_x_axis_tolerance: Spanned<f64>,
    pub absolute_y_axis_tolerance: Spanned<f64>,
    pub absolute_z_axis_tolerance: Spanned<f64>,
    #[serde(default)]
    pub parameterization: Option<NameOrNumber>,
    #[serde(default)]
    weight: Passed,
}

/// Components x, y, z and so on: a list, or a number per letter.
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
