use std::collections::HashMap;

use cranny_collision::Body;
use cranny_path::MAX_SAMPLE_RATE_HZ;
use cranny_shape::TriangleSoup;
use cranny_spatial::nalgebra::Quaternion;
use cranny_spatial::{Pose, Rotation};

use crate::course::shown_path::within;
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
        let times_s = kept.iter().map(|&instant| self.times_s[instant]).collect();
        self.with_instants(times_s, |poses| kept.iter().map(|&instant| poses[instant]).collect())
    }

    /// Returns the recording with `rate_hz` instants per second, a number greater than 0, from the first to the last, or fewer if
    /// they were too many. Poses between two recorded instants are interpolated, so that a film of them moves evenly.
    #[must_use]
    pub fn sampled(&self, rate_hz: f64) -> Self {
        /// Tolerance for rounding, as a share of the interval between two recorded instants.
        const ROUNDED: f64 = 1e-6;
        /// More instants than [`within`] leaves.
        const MOST_SAMPLES: u32 = 200_000;
        let (Some(first), Some(last)) = (self.times_s.first(), self.times_s.last()) else {
            return self.clone();
        };
        let rate_hz = within(rate_hz.min(MAX_SAMPLE_RATE_HZ), last - first);
        let times_s: Vec<f64> = (0..=MOST_SAMPLES)
            .map(|index| first + f64::from(index) / rate_hz)
            .take_while(|time_s| *time_s <= last + ROUNDED / rate_hz)
            .collect();
        let instants: Vec<(usize, f64)> = times_s
            .iter()
            .map(|time_s| {
                let later = self.times_s.partition_point(|recorded| recorded <= time_s);
                let Some(&next_s) = self.times_s.get(later) else { return (later - 1, 0.0) };
                let before_s = self.times_s[later - 1];
                let share = (time_s - before_s) / (next_s - before_s);
                if share > 1.0 - ROUNDED { (later, 0.0) } else { (later - 1, share) }
            })
            .collect();
        self.with_instants(times_s, |poses| {
            let pose = |&(instant, share): &(usize, f64)| {
                if share <= ROUNDED {
                    poses[instant]
                } else {
                    between(&poses[instant], &poses[instant + 1], share)
                }
            };
            instants.iter().map(pose).collect()
        })
    }

    /// Returns the recording with other instants; `choose` makes the poses of each moving body of those that it has.
    fn with_instants(&self, times_s: Vec<f64>, choose: impl Fn(&[Pose]) -> Vec<Pose>) -> Self {
        let bodies = self.bodies.iter().map(|body| {
            let poses = &body.world_from_body;
            let world_from_body = if poses.len() == 1 { poses.clone() } else { choose(poses) };
            MovingBody { world_from_body, ..body.clone() }
        });
        Self {
            name: self.name.clone(),
            times_s,
            world_from_floor: self.world_from_floor,
            bodies: bodies.collect(),
        }
    }
}

/// Returns the pose at a share of the motion between two others, by the shorter turn.
fn between(from: &Pose, to: &Pose, share: f64) -> Pose {
    let translation = from.translation.vector.lerp(&to.translation.vector, share);
    let is_near = from.rotation.coords.dot(&to.rotation.coords) >= 0.0;
    let end = if is_near { to.rotation.coords } else { -to.rotation.coords };
    let turned = Quaternion::from(from.rotation.coords.lerp(&end, share));
    Pose::from_parts(translation.into(), Rotation::new_normalize(turned))
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
