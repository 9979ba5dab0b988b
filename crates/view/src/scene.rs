use std::collections::HashMap;

use cranny_spatial::{Point, Pose};

use crate::{Colour, Mesh, ShownMode};

/// Self-contained scene of a task for pictures, glTF files and pages.
///
/// Poses are target-from-source in metres, z up; the root frame is the planning frame. The node of a link of a robot is below
/// that of its parent link, so that one moving joint is one moving node.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Id of the scenario.
    pub name: String,
    /// Meshes of the nodes; several nodes may share one.
    pub meshes: Vec<Mesh>,
    /// Materials of the meshes.
    pub materials: Vec<Material>,
    /// Nodes, parents before children.
    pub nodes: Vec<Node>,
    /// Frame whose plane z = 0 is the floor.
    pub world_from_floor: Option<Pose>,
    /// Motion of the robot; `None` if it stands at its start.
    pub motion: Option<SceneMotion>,
    /// Index of each of the materials that were added.
    pub(crate) known_materials: HashMap<MaterialKey, usize>,
}

/// Values of a material: its name, and the bits of colour, opacity, metalness and roughness.
pub(crate) type MaterialKey = (String, [u32; 6]);

/// Appearance of a surface: the metallic-roughness model of glTF 2.0, §3.9.2.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name of the material.
    pub name: String,
    /// Base colour.
    pub colour: Colour,
    /// Opacity, from 0 to 1 (opaque).
    pub opacity: f32,
    /// Metalness: 1 for bare metal, 0 for anything else.
    pub metallic: f32,
    /// Roughness, from 0 (mirror) to 1 (chalk).
    pub roughness: f32,
}

/// Frame in the scene, with or without a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Name; for a link or a body its own name.
    pub name: String,
    /// Index of the parent node; `None` for the planning frame.
    pub parent: Option<usize>,
    /// Pose in the frame of the parent, at the start of the motion.
    pub parent_from_node: Pose,
    /// Index of the mesh, if it has one.
    pub mesh: Option<usize>,
    /// Role of the node in the task.
    pub role: Role,
}

/// Role of a node in the task.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Role {
    /// Link of the robot, by index.
    Link(usize),
    /// Obstacle, by index; one node for each of its components.
    Obstacle(usize),
    /// Component of the target object.
    Target,
    /// Grasp as a small gripper; the frame of the node is the gripper frame.
    Grasp {
        /// Index of the grasp in the scenario.
        index: usize,
        /// Score of the grasp, if it has one.
        score: Option<f64>,
        /// True if the plan ends at this grasp.
        is_chosen: bool,
    },
    /// Path of the gripper frame.
    GripperPath,
}

/// Motion of the links and of the objects they carry, at a sequence of instants.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneMotion {
    /// Instants in seconds, ascending from 0.
    pub times_s: Vec<f64>,
    /// Moving nodes.
    pub tracks: Vec<Track>,
    /// Time at each way point of the plan, in seconds.
    pub waypoint_times_s: Vec<f64>,
    /// Configuration at each instant (m, rad).
    pub configurations: Vec<Vec<f64>>,
    /// Origin of the gripper frame at each instant, in the planning frame.
    pub gripper_path: Vec<Point>,
    /// Modes of the robot in order of time; empty for a motion of a single mode.
    pub modes: Vec<ShownMode>,
}

/// Motion of one node.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// Index of the node.
    pub node: usize,
    /// Pose at each instant, `parent_from_node`.
    pub poses: Vec<Pose>,
}

impl Scene {
    /// Returns the scene with a motion that is faster by a factor greater than 0: each of its times is divided by it.
    #[must_use]
    pub fn at_speed(mut self, factor: f64) -> Self {
        if let Some(motion) = &mut self.motion {
            let times_s = motion.times_s.iter_mut().chain(&mut motion.waypoint_times_s);
            times_s.for_each(|time_s| *time_s /= factor);
            for shown in &mut motion.modes {
                shown.from_s /= factor;
                shown.until_s /= factor;
            }
        }
        self
    }

    /// Returns the pose of every node in the planning frame, at the instant `frame` of the motion or at the start.
    ///
    /// # Panics
    /// If the motion has no such instant.
    pub fn world_from_nodes(&self, frame: Option<usize>) -> Vec<Pose> {
        let mut local: Vec<Pose> = self.nodes.iter().map(|node| node.parent_from_node).collect();
        if let (Some(frame), Some(motion)) = (frame, &self.motion) {
            for track in &motion.tracks {
                local[track.node] = track.poses[frame];
            }
        }
        let mut world: Vec<Pose> = Vec::with_capacity(local.len());
        for (node, parent_from_node) in self.nodes.iter().zip(local) {
            world.push(node.parent.map_or(parent_from_node, |parent| world[parent] * parent_from_node));
        }
        world
    }

    /// Returns the index of the last instant of the motion, if there is one.
    pub fn last_frame(&self) -> Option<usize> {
        self.motion.as_ref().and_then(|motion| motion.times_s.len().checked_sub(1))
    }

    /// Returns the number of triangles of all nodes.
    pub fn triangle_count(&self) -> usize {
        let of_mesh = |mesh: usize| self.meshes[mesh].pieces.iter().map(|p| p.triangles.len()).sum::<usize>();
        self.nodes.iter().filter_map(|node| node.mesh).map(of_mesh).sum()
    }

    /// Returns the index of a material, which is added unless an equal one exists.
    pub(crate) fn material(&mut self, material: Material) -> usize {
        let key = material.key();
        if let Some(&known) = self.known_materials.get(&key)
            // The materials are public, and may have been changed.
            && self.materials.get(known) == Some(&material)
        {
            return known;
        }
        let index = self.materials.len();
        self.known_materials.insert(key, index);
        self.materials.push(material);
        index
    }

    /// Adds a mesh and returns its index.
    pub(crate) fn mesh(&mut self, name: impl Into<String>, pieces: Vec<crate::MeshPiece>) -> usize {
        self.meshes.push(Mesh { name: name.into(), pieces });
        self.meshes.len() - 1
    }
}

impl Material {
    /// Creates an opaque matt material, such as painted metal or plastic.
    pub fn matt(name: impl Into<String>, colour: Colour) -> Self {
        Self { name: name.into(), colour, opacity: 1.0, metallic: 0.0, roughness: 0.6 }
    }

    fn key(&self) -> MaterialKey {
        let Colour([red, green, blue]) = self.colour;
        let values = [red, green, blue, self.opacity, self.metallic, self.roughness];
        (self.name.clone(), values.map(f32::to_bits))
    }
}
