use cranny_spatial::{Point, Pose};

use crate::{Colour, Mesh, ShownMode};

/// Everything that a picture, a glTF file or a page shows of a task: plain data, complete in itself.
///
/// Poses are target-from-source in metres, z up; the root frame is the planning frame. Of a robot each link is
/// a node, below the link that it hangs on, so that one moving joint is one moving node.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// The id of the scenario.
    pub name: String,
    /// What nodes are drawn as; several may share one.
    pub meshes: Vec<Mesh>,
    /// What meshes are made of.
    pub materials: Vec<Material>,
    /// Parents before children.
    pub nodes: Vec<Node>,
    /// The floor: the plane z = 0 of this frame.
    pub world_from_floor: Option<Pose>,
    /// How the robot moves; None if it stands at its start.
    pub motion: Option<SceneMotion>,
}

/// How a surface looks: the metallic-roughness model of glTF 2.0, §3.9.2.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// What it is called.
    pub name: String,
    /// Its colour.
    pub colour: Colour,
    /// 1 for what cannot be seen through.
    pub opacity: f32,
    /// 1 for bare metal, 0 for anything else.
    pub metallic: f32,
    /// 0 for a mirror, 1 for chalk.
    pub roughness: f32,
}

/// A place in the scene, with or without something to see.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Of a link or a body its own name.
    pub name: String,
    /// The node whose frame its pose is given in; None for the planning frame.
    pub parent: Option<usize>,
    /// Its pose, at the start of the motion.
    pub parent_from_node: Pose,
    /// What is seen there, by index.
    pub mesh: Option<usize>,
    /// What it stands for.
    pub role: Role,
}

/// What a node stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Role {
    /// A link of the robot, by index.
    Link(usize),
    /// A body that stands in the way, by index; one node for each of its parts.
    Obstacle(usize),
    /// A part of the body that is to be grasped.
    Target,
    /// A grasp as a small gripper; the node's frame is the gripper frame.
    Grasp {
        /// Which grasp of the scenario.
        index: usize,
        /// Its score, if it has one.
        score: Option<f64>,
        /// Whether it is the one that the plan ends at.
        is_chosen: bool,
    },
    /// The way of the gripper frame.
    GripperPath,
}

/// Where links, and what they take along, are at each of a row of instants.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneMotion {
    /// The instants, in seconds, ascending from 0.
    pub times_s: Vec<f64>,
    /// The nodes that move.
    pub tracks: Vec<Track>,
    /// When each way point of the plan is passed, in seconds.
    pub waypoint_times_s: Vec<f64>,
    /// The configuration at each instant (m, rad).
    pub configurations: Vec<Vec<f64>>,
    /// Where the gripper frame's origin is at each instant, in the planning frame.
    pub gripper_path: Vec<Point>,
    /// What the robot does, one after the other; empty where it does one thing.
    pub modes: Vec<ShownMode>,
}

/// One moving node.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// Which.
    pub node: usize,
    /// Its pose at each instant, `parent_from_node`.
    pub poses: Vec<Pose>,
}

impl Scene {
    /// The pose of every node in the planning frame: at the instant `frame` of the motion, or before it.
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

    /// The last instant of the motion, if there is one.
    pub fn last_frame(&self) -> Option<usize> {
        self.motion.as_ref().and_then(|motion| motion.times_s.len().checked_sub(1))
    }

    /// How many triangles all nodes together show.
    pub fn triangle_count(&self) -> usize {
        let of_mesh = |mesh: usize| self.meshes[mesh].pieces.iter().map(|p| p.triangles.len()).sum::<usize>();
        self.nodes.iter().filter_map(|node| node.mesh).map(of_mesh).sum()
    }

    /// The index of a material, which is added unless there is an equal one.
    pub(crate) fn material(&mut self, material: Material) -> usize {
        if let Some(known) = self.materials.iter().position(|other| *other == material) {
            return known;
        }
        self.materials.push(material);
        self.materials.len() - 1
    }

    /// Adds a mesh and returns its index.
    pub(crate) fn mesh(&mut self, name: impl Into<String>, pieces: Vec<crate::MeshPiece>) -> usize {
        self.meshes.push(Mesh { name: name.into(), pieces });
        self.meshes.len() - 1
    }
}

impl Material {
    /// Something dull that cannot be seen through, such as painted metal or plastic.
    pub fn matt(name: impl Into<String>, colour: Colour) -> Self {
        Self { name: name.into(), colour, opacity: 1.0, metallic: 0.0, roughness: 0.6 }
    }
}
