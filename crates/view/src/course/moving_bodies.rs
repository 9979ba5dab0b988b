use std::collections::HashMap;

use cranny_collision::Body;
use cranny_shape::TriangleSoup;
use cranny_spatial::Pose;

use crate::look::paint::painted;
use crate::scene::{Node, Role, SceneMotion, Track};
use crate::{Colour, Material, MeshPiece, Scene};

/// Self-contained recording of rigid bodies and their motions.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodyRecording {
    /// Name of the recording.
    pub name: String,
    /// Instants in seconds, ascending from 0.
    pub times_s: Vec<f64>,
    /// Frame whose plane z = 0 is the floor.
    pub world_from_floor: Option<Pose>,
    /// All visible bodies; names may repeat.
    pub bodies: Vec<MovingBody>,
}

/// Rigid body with its motion.
#[derive(Clone, Debug, PartialEq)]
pub struct MovingBody {
    /// Name of the body.
    pub name: String,
    /// Surface in the frame of the body.
    pub surface: TriangleSoup,
    /// True if this is the grasped object.
    pub is_grasped: bool,
    /// Pose in the planning frame at each instant, or a single pose for a static body.
    pub world_from_body: Vec<Pose>,
}

impl BodyRecording {
    /// Adds static bodies, one per component. The last unbounded one becomes the floor.
    pub fn add_still(&mut self, bodies: &[Body]) {
        for (body, part) in bodies.iter().flat_map(|body| body.parts.iter().map(move |part| (body, part))) {
            match part.solid.tessellation() {
                Some(surface) => self.bodies.push(MovingBody {
                    name: body.name.clone(),
                    surface,
                    is_grasped: false,
                    world_from_body: vec![part.world_from_solid],
                }),
                None => self.world_from_floor = Some(part.world_from_solid),
            }
        }
    }

    /// Returns the recording reduced to at most `rate_hz` instants per second, beginning with the first.
    #[must_use]
    pub fn thinned(&self, rate_hz: f64) -> Self {
        /// Tolerance for rounding: times are sums of intervals.
        const ROUNDED_S: f64 = 1e-9;
        let mut kept: Vec<usize> = Vec::new();
        for (instant, time_s) in self.times_s.iter().enumerate() {
            if time_s - self.times_s[0] + ROUNDED_S >= kept.len() as f64 / rate_hz {
                kept.push(instant);
            }
        }
        let bodies = self.bodies.iter().map(|body| {
            let poses = &body.world_from_body;
            let is_still = poses.len() == 1;
            let world_from_body =
                if is_still { poses.clone() } else { kept.iter().map(|&instant| poses[instant]).collect() };
            MovingBody { world_from_body, ..body.clone() }
        });
        Self {
            name: self.name.clone(),
            times_s: kept.iter().map(|&instant| self.times_s[instant]).collect(),
            world_from_floor: self.world_from_floor,
            bodies: bodies.collect(),
        }
    }
}

impl Scene {
    /// Creates a scene of moving and static bodies; each moving body has a pose for every instant. The first moving body that
    /// is not grasped counts as the gripper.
    pub fn of_moving_bodies(recording: &BodyRecording) -> Self {
        let BodyRecording { name, times_s, world_from_floor, bodies } = recording;
        let mut scene = Self { name: name.clone(), world_from_floor: *world_from_floor, ..Self::default() };
        let is_obstacle = |body: &&MovingBody| body.world_from_body.len() == 1 && !body.is_grasped;
        let mut kinds = HashMap::new();
        for (index, body) in bodies.iter().filter(is_obstacle).enumerate() {
            let pieces = scene.obstacle(&body.name, &body.surface, &mut kinds);
            scene.add_body(body, pieces, Role::Obstacle(index));
        }
        let mut tracks = Vec::new();
        let moving = || bodies.iter().filter(|body| !is_obstacle(body));
        for (index, body) in moving().enumerate() {
            let (pieces, role) = if body.is_grasped {
                (painted(&body.name, &body.surface, &mut scene), Role::Target)
            } else {
                let colour = Colour::hex(HAND[index % HAND.len()]);
                let material = scene.material(Material::matt(&body.name, colour));
                (vec![MeshPiece::of_soup(&body.surface, material)], Role::Link(index))
            };
            if body.world_from_body.len() == times_s.len() {
                tracks.push(Track { node: scene.nodes.len(), poses: body.world_from_body.clone() });
            }
            scene.add_body(body, pieces, role);
        }
        let gripper = moving().find(|body| !body.is_grasped);
        let path = gripper.map_or(&[][..], |body| &body.world_from_body);
        scene.motion = Some(SceneMotion {
            times_s: times_s.clone(),
            tracks,
            waypoint_times_s: Vec::new(),
            configurations: Vec::new(),
            gripper_path: path.iter().map(|pose| pose.translation.vector.into()).collect(),
            modes: Vec::new(),
        });
        scene
    }

    fn add_body(&mut self, body: &MovingBody, pieces: Vec<MeshPiece>, role: Role) {
        let mesh = Some(self.mesh(body.name.clone(), pieces));
        let parent_from_node = body.world_from_body.first().copied().unwrap_or_default();
        self.nodes.push(Node { name: body.name.clone(), parent: None, parent_from_node, mesh, role });
    }
}

/// Alternating colours of the components of a hand: white and dark grey, as is common for hands.
const HAND: [u32; 2] = [0x00e6_e8ea, 0x0050_565c];
