use std::path::Path;

use cranny_shape::TriangleSoup;
use cranny_spatial::{Point, Pose, Rotation, Vector};

use crate::drawing::picture_file::write_whole;
use crate::gltf_buffer::GltfBuffer;
use crate::gltf_json::{
    ARRAY_BUFFER, Animation, Asset, Attributes, Buffer, Channel, GltfMaterial, GltfMesh, GltfNode, GltfScene,
    Index, PbrMetallicRoughness, Primitive, Root, Sampler, Target, push,
};
use crate::{Colour, Material, MeshPiece, Scene, ViewError};

/// Half the side of the floor in a glTF file, in metres: wider than any built-in scenario.
const FLOOR_M: f64 = 3.0;

const FLOOR: u32 = 0x00e4_e8ec;

impl Scene {
    /// Writes the scene as a self-contained binary glTF 2.0 file: nodes, meshes, materials, and the motion as an animation of
    /// the moving links, linear between instants. The root node rotates the planning frame to glTF's, with y up.
    ///
    /// # Errors
    /// [`ViewError::Encoding`], [`ViewError::Unwritable`].
    pub fn write_glb(&self, path: &Path) -> Result<(), ViewError> {
        let bytes = self
            .glb()
            .map_err(|reason| ViewError::Encoding { path: path.to_owned(), reason: reason.to_string() })?;
        write_whole(path, &bytes)
    }

    /// Encodes the scene as a binary glTF file.
    ///
    /// # Errors
    /// Returns the error of the JSON encoder for a number that is not finite.
    pub fn glb(&self) -> serde_json::Result<Vec<u8>> {
        let mut buffer = GltfBuffer::default();
        let generator = format!("Cranny {}", env!("CARGO_PKG_VERSION"));
        let mut root = Root {
            asset: Asset { generator, version: "2.0" },
            materials: self.materials.iter().map(gltf_material).collect(),
            ..Root::default()
        };
        for mesh in &self.meshes {
            let primitives =
                mesh.pieces.iter().map(|piece| primitive(piece, &mut buffer, &mut root)).collect();
            root.meshes.push(gltf_mesh(&mesh.name, primitives));
        }
        self.push_nodes(&mut root);
        self.push_floor(&mut buffer, &mut root);
        root.scenes.push(GltfScene { name: self.name.clone(), nodes: vec![0] });
        self.push_animation(&mut buffer, &mut root);
        root.buffers.push(Buffer { byte_length: buffer.bytes.len() });
        let mut json = serde_json::to_vec(&root)?;
        // Chunks are padded to whole words, text with blanks.
        json.resize(json.len().next_multiple_of(4), b' ');
        Ok(chunks(&json, &buffer.bytes))
    }

    /// Adds the planning frame first, so each node has one more than its index in the scene.
    fn push_nodes(&self, root: &mut Root) {
        let quarter = std::f64::consts::FRAC_1_SQRT_2;
        let y_up =
            Rotation::new_unchecked(cranny_spatial::nalgebra::Quaternion::new(quarter, -quarter, 0.0, 0.0));
        let y_up_from_planning = Pose::from_parts(Vector::zeros().into(), y_up);
        root.nodes.push(node("planning_frame", &y_up_from_planning, None));
        for scene_node in &self.nodes {
            root.nodes.push(node(&scene_node.name, &scene_node.parent_from_node, scene_node.mesh));
        }
        for (index, scene_node) in self.nodes.iter().enumerate() {
            let parent = scene_node.parent.map_or(0, |parent| parent + 1);
            root.nodes[parent].children.push(index + 1);
        }
    }

    fn push_floor(&self, buffer: &mut GltfBuffer, root: &mut Root) {
        let Some(world_from_floor) = &self.world_from_floor else { return };
        let corner = |x: f64, y: f64| Point::new(x * FLOOR_M, y * FLOOR_M, 0.0);
        let vertices = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        let soup = TriangleSoup { vertices, triangles: vec![[0, 1, 2], [0, 2, 3]] };
        let material = Material { roughness: 1.0, ..Material::matt("floor", Colour::hex(FLOOR)) };
        root.materials.push(gltf_material(&material));
        let piece = MeshPiece::of_soup(&soup, root.materials.len() - 1);
        let primitive = primitive(&piece, buffer, root);
        let mesh = push(&mut root.meshes, gltf_mesh("floor", vec![primitive]));
        let index = push(&mut root.nodes, node("floor", world_from_floor, Some(mesh)));
        root.nodes[0].children.push(index);
    }

    fn push_animation(&self, buffer: &mut GltfBuffer, root: &mut Root) {
        let Some(motion) = self.motion.as_ref().filter(|motion| motion.times_s.len() > 1) else { return };
        #[allow(clippy::cast_possible_truncation, reason = "single precision is what is meant")]
        let times: Vec<[f32; 1]> = motion.times_s.iter().map(|time| [*time as f32]).collect();
        let input = buffer.numbers(root, &times, None);
        let mut animation = Animation { name: "motion", channels: Vec::new(), samplers: Vec::new() };
        for track in &motion.tracks {
            let node = track.node + 1;
            let places: Vec<[f32; 3]> = track.poses.iter().map(translation).collect();
            let mut turns: Vec<[f32; 4]> = track.poses.iter().map(rotation).collect();
            // A rotation and its negative are equal; interpolation takes the shorter arc between two instants.
            for index in 1..turns.len() {
                let dot: f32 = (0..4).map(|i| turns[index - 1][i] * turns[index][i]).sum();
                if dot < 0.0 {
                    turns[index] = turns[index].map(|x| -x);
                }
            }
            // Constant values are stored in the node only.
            if varies(&places) {
                let output = buffer.numbers(root, &places, None);
                add_channel(&mut animation, input, output, node, "translation");
            }
            if varies(&turns) {
                let output = buffer.numbers(root, &turns, None);
                add_channel(&mut animation, input, output, node, "rotation");
            }
        }
        if !animation.channels.is_empty() {
            root.animations.push(animation);
        }
    }
}

/// Returns true if the rows differ by more than rounding.
fn varies<const N: usize>(rows: &[[f32; N]]) -> bool {
    const ROUNDING: f32 = 3e-7;
    rows.iter().any(|row| (0..N).any(|i| (row[i] - rows[0][i]).abs() > ROUNDING))
}

fn add_channel(animation: &mut Animation, input: Index, output: Index, node: Index, path: &'static str) {
    let sampler = push(&mut animation.samplers, Sampler { input, interpolation: "LINEAR", output });
    animation.channels.push(Channel { sampler, target: Target { node, path } });
}

fn gltf_mesh(name: &str, primitives: Vec<Primitive>) -> GltfMesh {
    GltfMesh { name: name.to_owned(), primitives }
}

fn primitive(piece: &MeshPiece, buffer: &mut GltfBuffer, root: &mut Root) -> Primitive {
    let target = Some(ARRAY_BUFFER);
    let position = buffer.numbers(root, &piece.positions, target);
    let normal = buffer.numbers(root, &piece.normals, target);
    let colours: Vec<[f32; 3]> = piece.colours.iter().map(|colour| colour.0).collect();
    let color = (!colours.is_empty()).then(|| buffer.numbers(root, &colours, target));
    let indices = buffer.indices(root, &piece.triangles);
    Primitive { attributes: Attributes { position, normal, color }, indices, material: piece.material }
}

fn gltf_material(material: &Material) -> GltfMaterial {
    let Colour([red, green, blue]) = material.colour;
    GltfMaterial {
        name: material.name.clone(),
        alpha_mode: if material.opacity < 1.0 { "BLEND" } else { "OPAQUE" },
        pbr_metallic_roughness: PbrMetallicRoughness {
            base_color: [red, green, blue, material.opacity],
            metallic: material.metallic,
            roughness: material.roughness,
        },
    }
}

fn node(name: &str, pose: &Pose, mesh: Option<Index>) -> GltfNode {
    let (rotation, translation) = (rotation(pose), translation(pose));
    GltfNode { children: Vec::new(), mesh, name: name.to_owned(), rotation, translation }
}

#[allow(clippy::cast_possible_truncation, reason = "single precision is what is meant")]
fn translation(pose: &Pose) -> [f32; 3] {
    [0, 1, 2].map(|axis| pose.translation.vector[axis] as f32)
}

/// Returns the rotation as x, y, z, w.
#[allow(clippy::cast_possible_truncation, reason = "single precision is what is meant")]
fn rotation(pose: &Pose) -> [f32; 4] {
    [0, 1, 2, 3].map(|axis| pose.rotation.coords[axis] as f32)
}

/// Assembles a binary glTF file from its two chunks, both padded to whole words (glTF 2.0, §4.4).
fn chunks(json: &[u8], binary: &[u8]) -> Vec<u8> {
    let word = |number: usize| u32::try_from(number).unwrap_or(u32::MAX).to_le_bytes();
    let length = 12 + 8 + json.len() + 8 + binary.len();
    let mut bytes = Vec::with_capacity(length);
    for part in [&b"glTF"[..], &word(2), &word(length)] {
        bytes.extend_from_slice(part);
    }
    for (kind, chunk) in [(b"JSON", json), (b"BIN\0", binary)] {
        bytes.extend_from_slice(&word(chunk.len()));
        bytes.extend_from_slice(kind);
        bytes.extend_from_slice(chunk);
    }
    bytes
}
