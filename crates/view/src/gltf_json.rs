//! JSON of a glTF file (glTF 2.0, §5): the properties that Cranny writes, by the names of the specification.

use serde::Serialize;

/// Index of an object in its array of [`Root`].
pub(crate) type Index = usize;

/// `ARRAY_BUFFER`: data of vertices (glTF 2.0, §5.11.5).
pub(crate) const ARRAY_BUFFER: u32 = 34962;
/// `ELEMENT_ARRAY_BUFFER`: indices of vertices.
pub(crate) const ELEMENT_ARRAY_BUFFER: u32 = 34963;
/// `UNSIGNED_SHORT` (glTF 2.0, §3.6.2.2).
pub(crate) const UNSIGNED_SHORT: u32 = 5123;
/// `UNSIGNED_INT`.
pub(crate) const UNSIGNED_INT: u32 = 5125;
/// `FLOAT`.
pub(crate) const FLOAT: u32 = 5126;

/// Whole of the JSON. Empty arrays are omitted, as the specification demands.
#[derive(Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Root {
    pub asset: Asset,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub accessors: Vec<Accessor>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub animations: Vec<Animation>,
    pub buffers: Vec<Buffer>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub buffer_views: Vec<BufferView>,
    pub scene: Index,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub materials: Vec<GltfMaterial>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub meshes: Vec<GltfMesh>,
    pub nodes: Vec<GltfNode>,
    pub scenes: Vec<GltfScene>,
}

#[derive(Default, Serialize)]
pub(crate) struct Asset {
    pub generator: String,
    pub version: &'static str,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Buffer {
    pub byte_length: usize,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct BufferView {
    pub buffer: Index,
    pub byte_length: usize,
    pub byte_offset: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<u32>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Accessor {
    pub buffer_view: Index,
    pub component_type: u32,
    pub count: usize,
    #[serde(rename = "type")]
    pub shape: &'static str,
    /// Exact values of the single-precision data.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min: Option<Vec<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max: Option<Vec<f64>>,
}

#[derive(Serialize)]
pub(crate) struct GltfMesh {
    pub name: String,
    pub primitives: Vec<Primitive>,
}

/// Triangles, which are the default mode.
#[derive(Serialize)]
pub(crate) struct Primitive {
    pub attributes: Attributes,
    pub indices: Index,
    pub material: Index,
}

#[derive(Serialize)]
#[serde(rename_all = "UPPERCASE")]
pub(crate) struct Attributes {
    pub position: Index,
    pub normal: Index,
    #[serde(rename = "COLOR_0", skip_serializing_if = "Option::is_none")]
    pub color: Option<Index>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct GltfMaterial {
    pub name: String,
    pub alpha_mode: &'static str,
    pub pbr_metallic_roughness: PbrMetallicRoughness,
}

#[derive(Serialize)]
pub(crate) struct PbrMetallicRoughness {
    #[serde(rename = "baseColorFactor")]
    pub base_color: [f32; 4],
    #[serde(rename = "metallicFactor")]
    pub metallic: f32,
    #[serde(rename = "roughnessFactor")]
    pub roughness: f32,
}

#[derive(Serialize)]
pub(crate) struct GltfNode {
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub children: Vec<Index>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<Index>,
    pub name: String,
    /// Unit quaternion x, y, z, w.
    pub rotation: [f32; 4],
    pub translation: [f32; 3],
}

#[derive(Serialize)]
pub(crate) struct GltfScene {
    pub name: String,
    pub nodes: Vec<Index>,
}

#[derive(Serialize)]
pub(crate) struct Animation {
    pub name: &'static str,
    pub channels: Vec<Channel>,
    pub samplers: Vec<Sampler>,
}

#[derive(Serialize)]
pub(crate) struct Channel {
    pub sampler: Index,
    pub target: Target,
}

#[derive(Serialize)]
pub(crate) struct Target {
    pub node: Index,
    pub path: &'static str,
}

#[derive(Serialize)]
pub(crate) struct Sampler {
    pub input: Index,
    pub interpolation: &'static str,
    pub output: Index,
}

/// Adds an object to its array and returns its index.
pub(crate) fn push<T>(array: &mut Vec<T>, object: T) -> Index {
    array.push(object);
    array.len() - 1
}
