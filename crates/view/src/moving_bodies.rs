use cranny_collision::Body;
use cranny_shape::TriangleSoup;
use cranny_spatial::Pose;

use crate::paint::painted;
use crate::scene::{Node, Role, SceneMotion, Track};
use crate::{Colour, Material, MeshPiece, Scene};

/// A rigid body and where it goes.
#[derive(Clone, Debug)]
pub struct MovingBody {
    /// What it is called.
    pub name: String,
    /// Its surface in its own frame.
    pub surface: TriangleSoup,
    /// Whether it is what is grasped, or part of the hand.
    pub is_grasped: bool,
    /// Its pose in the planning frame at each instant.
    pub world_from_body: Vec<Pose>,
}

impl Scene {
    /// Bodies that move among others that stand still, at instants in seconds, ascending from 0; each of `moving` has a
    /// pose for every instant. The first that is not grasped counts as the gripper.
    pub fn of_moving_bodies(name: &str, still: &[Body], moving: &[MovingBody], times_s: Vec<f64>) -> Self {
        let mut scene = Self { name: name.to_owned(), ..Self::default() };
        scene.add_bodies(still, None);
        let mut tracks = Vec::new();
        for (index, body) in moving.iter().enumerate() {
            let (pieces, role) = if body.is_grasped {
                (painted(&body.name, &body.surface, &mut scene), Role::Target)
            } else {
                let colour = Colour::hex(HAND[index % HAND.len()]);
                let material = scene.material(Material::matt(&body.name, colour));
                (vec![MeshPiece::of_soup(&body.surface, material)], Role::Link(index))
            };
            let mesh = Some(scene.mesh(body.name.clone(), pieces));
            let parent_from_node = body.world_from_body.first().copied().unwrap_or_default();
            tracks.push(Track { node: scene.nodes.len(), poses: body.world_from_body.clone() });
            scene.nodes.push(Node { name: body.name.clone(), parent: None, parent_from_node, mesh, role });
        }
        let gripper = moving.iter().find(|body| !body.is_grasped);
        let path = gripper.map_or(&[][..], |body| &body.world_from_body);
        scene.motion = Some(SceneMotion {
            times_s,
            tracks,
            waypoint_times_s: Vec::new(),
            configurations: Vec::new(),
            gripper_path: path.iter().map(|pose| pose.translation.vector.into()).collect(),
        });
        scene
    }
}

/// The parts of a hand, in turns: white and dark grey, as hands are.
const HAND: [u32; 2] = [0x00e6_e8ea, 0x0050_565c];
