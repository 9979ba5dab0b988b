use std::collections::HashMap;

use cranny_scenario::{ObjectType, Scenario};
use cranny_sense::SeenMap;
use cranny_shape::TriangleSoup;
use cranny_spatial::{Point, Pose, Vector};
use cranny_task::Mode;

use crate::course::stance::{Placed, Stance};
use crate::look::colour::of_score;
use crate::look::paint::painted;
use crate::look::seen_look;
use crate::look::stroke::{small_gripper, tube};
use crate::scene::{Node, Role, SceneMotion, Track};
use crate::{Colour, Material, MeshPiece, SampledPath, Scene, ShownMode, ViewError, look::robot_look};

/// Settings of the scene of a task besides robot and bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SceneSettings {
    /// Number of grasps shown in addition to the grasp of the plan, evenly spread over the scores from the highest down.
    /// Default 14: as many as are distinguishable on a small object.
    pub grasps: usize,
}

impl Default for SceneSettings {
    fn default() -> Self {
        Self { grasps: 14 }
    }
}

/// Colours of obstacles: greyish tones that neither robot nor objects have. They alternate, so that adjacent kinds differ.
const OBSTACLES: [u32; 4] = [0x0094_aac0, 0x00c9_b79c, 0x00b3_c2ac, 0x00c2_b0bd];

/// Colour of the grasp of the plan, and of the path of the gripper to it.
const CHOSEN: u32 = 0x00e8_3f6f;

/// Colour that darkens the path where it carries the object.
const DEEP: u32 = 0x0020_1838;

/// Colours of cells with a measured surface and of cells that no camera has seen into, and opacity of the latter.
const OCCUPIED: u32 = 0x00c9_8f4e;
const UNSEEN: u32 = 0x0058_6f9c;
const UNSEEN_OPACITY: f32 = 0.16;

/// Radius of path lines, in metres.
const PATH_RADIUS_M: f64 = 0.0045;
/// Radius of carrying paths: larger, so that they stay visible where the robot returns on its own path.
const CARRY_RADIUS_M: f64 = 1.2 * PATH_RADIUS_M;
const GRASP_RADIUS_M: f64 = 0.0014;
const CHOSEN_RADIUS_M: f64 = 0.0024;

/// Opening of the small grippers, in metres: half the real opening, so that they do not hide the object.
const GRASP_OPENING_M: f64 = 0.044;

impl Scene {
    /// Creates the scene of a scenario, and of a path through it.
    ///
    /// Nodes: each link of the robot below its parent, each component of each obstacle, the target, grasps, the gripper path.
    ///
    /// # Errors
    /// [`ViewError::VisualNotFound`] and [`ViewError::Shape`] for the visual meshes of the robot's URDF.
    pub fn of_task(
        scenario: &Scenario,
        path: Option<&SampledPath>,
        settings: &SceneSettings,
    ) -> Result<Self, ViewError> {
        let mut scene = Self { name: scenario.id.clone(), ..Self::default() };
        let carried = scene.add_robot(scenario, path)?;
        let objects: Vec<&str> =
            path.iter().flat_map(|path| &path.carries).map(|carry| carry.object.as_str()).collect();
        scene.add_bodies(scenario);
        scene.add_seen_space(scenario);
        scene.carry(scenario, &objects, &carried);
        scene.add_grasps(scenario, path.and_then(|path| path.grasp), settings.grasps);
        scene.add_gripper_path();
        Ok(scene)
    }

    /// Returns the scene with only these links of the robot.
    #[must_use]
    pub fn with_links(mut self, links: &[usize]) -> Self {
        for node in &mut self.nodes {
            if matches!(node.role, Role::Link(link) if !links.contains(&link)) {
                node.mesh = None;
            }
        }
        self
    }

    /// Adds the axes of `frame`, a pose in the planning frame, `length_m` metres long: x red, y green, z blue.
    #[must_use]
    pub fn with_axes(mut self, frame: &Pose, length_m: f64) -> Self {
        let axes = [(Vector::x(), 0x00d0_2020), (Vector::y(), 0x0020_a040), (Vector::z(), 0x0020_50d0)];
        let pieces = axes.map(|(axis, colour)| {
            let material = self.material(Material::matt("axis", Colour::hex(colour)));
            tube(&[Point::origin(), Point::from(axis * length_m)], 0.03 * length_m, material)
        });
        let mesh = self.mesh("axes", pieces.to_vec());
        let role = Role::GripperPath;
        let (name, parent_from_node) = ("axes".to_owned(), *frame);
        self.nodes.push(Node { name, parent: None, parent_from_node, mesh: Some(mesh), role });
        self
    }

    /// Creates the scene of an object on the ground, in its most probable stable pose.
    pub fn of_object(object: &ObjectType) -> Self {
        let mut scene = Self { name: object.name.clone(), ..Self::default() };
        let pieces = match object.colour {
            Some(colour) => vec![scene.coloured(&object.name, &object.mesh, colour)],
            None => painted(&object.name, &object.mesh, &mut scene),
        };
        let mesh = scene.mesh(object.name.clone(), pieces);
        let stable = object.stable_poses.first().map_or_else(Pose::identity, |pose| pose.ground_from_body);
        scene.nodes.push(Node {
            name: object.name.clone(),
            parent: None,
            parent_from_node: stable,
            mesh: Some(mesh),
            role: Role::Target,
        });
        scene.world_from_floor = Some(Pose::identity());
        scene
    }

    /// Adds the robot, and returns the displacement of each carried object at each instant of the path, in the planning frame.
    fn add_robot(
        &mut self,
        scenario: &Scenario,
        path: Option<&SampledPath>,
    ) -> Result<Vec<Vec<Pose>>, ViewError> {
        let robot = &scenario.robot;
        let meshes = robot_look::link_meshes(robot, self)?;
        let mut stance = Stance::of(robot, path.map_or(&[], |path| &path.carries));
        let start = stance.at(path.map_or(&scenario.start, |path| &path.configurations[0]), 0.0).local;
        // Links are the first nodes, so node and link have the same index.
        for (index, (link, mesh)) in robot.links().iter().zip(meshes).enumerate() {
            self.nodes.push(Node {
                name: link.name.clone(),
                parent: link.parent,
                parent_from_node: start[index],
                mesh,
                role: Role::Link(index),
            });
        }
        let Some(path) = path else { return Ok(Vec::new()) };
        let instants = path.configurations.iter().zip(&path.times_s);
        let rows: Vec<Placed> = instants.map(|(q, &time_s)| stance.at(q, time_s)).collect();
        let has_joint = |&link: &usize| robot.ancestors(link).last().is_some_and(|m| m.child_link == link);
        let moved = (0..robot.links().len()).filter(has_joint).chain(stance.fingers());
        let track = |node: usize| Track { node, poses: rows.iter().map(|row| row.local[node]).collect() };
        self.motion = Some(SceneMotion {
            times_s: path.times_s.clone(),
            tracks: moved.map(track).collect(),
            waypoint_times_s: path.waypoint_times_s.clone(),
            configurations: path.configurations.clone(),
            gripper_path: rows.iter().map(|row| row.tip).collect(),
            modes: path.carries.iter().flat_map(|carry| carry.modes.clone()).collect(),
        });
        let of_one = |index: usize| rows.iter().map(|row| row.carried[index]).collect();
        Ok((0..path.carries.len()).map(of_one).collect())
    }

    /// Moves bodies with the hand; `carried` contains the displacement of each of the objects at each instant. An object without
    /// a body of its name is the target.
    fn carry(&mut self, scenario: &Scenario, objects: &[&str], carried: &[Vec<Pose>]) {
        let Some(motion) = self.motion.as_mut().filter(|_| !objects.is_empty()) else { return };
        // Of several bodies of one name, the first is carried.
        let named = scenario.world.bodies().iter().enumerate().rev();
        let bodies: HashMap<&str, usize> = named.map(|(index, body)| (body.name.as_str(), index)).collect();
        let mut nodes: HashMap<usize, Vec<usize>> = HashMap::new();
        for (index, node) in self.nodes.iter().enumerate() {
            let body = match node.role {
                Role::Target => scenario.target,
                Role::Obstacle(body) => Some(body),
                _ => None,
            };
            if let Some(body) = body {
                nodes.entry(body).or_default().push(index);
            }
        }
        let last: HashMap<&str, usize> =
            objects.iter().enumerate().map(|(index, object)| (*object, index)).collect();
        for (index, (object, moved)) in objects.iter().zip(carried).enumerate() {
            let body = bodies.get(object).copied().or(scenario.target);
            // The last motion of an object includes the earlier ones.
            let Some(nodes) = body.filter(|_| last[object] == index).and_then(|body| nodes.get(&body)) else {
                continue;
            };
            motion.tracks.extend(nodes.iter().map(|&node| Track {
                node,
                poses: moved.iter().map(|moved| moved * self.nodes[node].parent_from_node).collect(),
            }));
        }
    }

    /// Adds the bodies of a world, `target` among them, in their own colours, or else in those of their kinds.
    fn add_bodies(&mut self, scenario: &Scenario) {
        let mut kinds = HashMap::new();
        for (index, body) in scenario.world.bodies().iter().enumerate() {
            if scenario.seen.is_some() && SeenMap::is_name_of_map(&body.name) {
                continue;
            }
            let is_target = scenario.target == Some(index);
            let own = scenario.colours.get(&body.name).map_or(&[][..], Vec::as_slice);
            for (place, part) in body.parts.iter().enumerate() {
                let Some(soup) = part.solid.tessellation() else {
                    self.world_from_floor = Some(part.world_from_solid);
                    continue;
                };
                let role = if is_target { Role::Target } else { Role::Obstacle(index) };
                let pieces = match own.get(place) {
                    Some(Some(colour)) => vec![self.coloured(&body.name, &soup, *colour)],
                    _ if is_target => painted(&body.name, &soup, self),
                    _ => self.obstacle(&body.name, &soup, &mut kinds),
                };
                let mesh = Some(self.mesh(body.name.clone(), pieces));
                let parent_from_node = part.world_from_solid;
                self.nodes.push(Node { name: body.name.clone(), parent: None, parent_from_node, mesh, role });
            }
        }
    }

    /// Draws the cells of a map of seen space, instead of the bodies that stand for them: measured surfaces, and the borders of unseen space,
    /// translucent.
    fn add_seen_space(&mut self, scenario: &Scenario) {
        let Some(space) = &scenario.seen else { return };
        let looks = [(SeenMap::OCCUPIED, OCCUPIED, 1.0), (SeenMap::UNSEEN, UNSEEN, UNSEEN_OPACITY)];
        for ((name, colour, opacity), soup) in looks.into_iter().zip(seen_look::surfaces(&space.map)) {
            let bodies = scenario.world.bodies().iter().map(|body| body.name.as_str());
            let Some(body) = bodies.into_iter().position(|body| body == name) else { continue };
            let matt = Material::matt(name, Colour::hex(colour));
            let material = self.material(Material { opacity, roughness: 0.9, ..matt });
            let mesh = Some(self.mesh(name, vec![MeshPiece::of_soup(&soup, material)]));
            let (name, parent_from_node) = (name.to_owned(), Pose::identity());
            self.nodes.push(Node { name, parent: None, parent_from_node, mesh, role: Role::Obstacle(body) });
        }
    }

    /// Creates a piece in a colour of a file: red, green and blue, 0 to 1, sRGB.
    pub(crate) fn coloured(&mut self, name: &str, soup: &TriangleSoup, colour: [f64; 3]) -> MeshPiece {
        let matt = Material::matt(name, Colour::srgb(colour));
        let material = self.material(Material { roughness: 0.6, ..matt });
        MeshPiece::of_soup(soup, material)
    }

    /// Creates the pieces of an obstacle. Obstacles of one kind share a colour; `kinds` numbers the kinds seen before.
    pub(crate) fn obstacle<'a>(
        &mut self,
        name: &'a str,
        soup: &TriangleSoup,
        kinds: &mut HashMap<&'a str, usize>,
    ) -> Vec<MeshPiece> {
        let next = kinds.len();
        let turn = *kinds.entry(kind_of(name)).or_insert(next);
        let colour = Colour::hex(OBSTACLES[turn % OBSTACLES.len()]);
        let material = self.material(Material { roughness: 0.75, ..Material::matt(name, colour) });
        vec![MeshPiece::of_soup(soup, material)]
    }

    fn add_grasps(&mut self, scenario: &Scenario, chosen: Option<usize>, shown: usize) {
        let order = scenario.grasps.by_score();
        let stride = order.len().div_ceil(shown.max(1)).max(1);
        let some = order.iter().copied().step_by(stride).take(shown).filter(|&index| Some(index) != chosen);
        let mut meshes: HashMap<usize, usize> = HashMap::new();
        for index in some.chain(chosen) {
            let Some(grasp) = scenario.grasps.grasps().get(index) else { continue };
            let is_chosen = Some(index) == chosen;
            let (colour, radius_m, opening_m) = if is_chosen {
                (Colour::hex(CHOSEN), CHOSEN_RADIUS_M, GRASP_OPENING_M * 1.25)
            } else {
                (of_score(grasp.score), GRASP_RADIUS_M, GRASP_OPENING_M)
            };
            let name = if is_chosen { "grasp, taken".to_owned() } else { score_name(grasp.score) };
            let material = self.material(Material::matt(name, colour));
            let mesh = *meshes
                .entry(material)
                .or_insert_with(|| self.mesh("grasp", vec![small_gripper(opening_m, radius_m, material)]));
            self.nodes.push(Node {
                name: format!("grasp {index}"),
                parent: None,
                parent_from_node: grasp.world_from_gripper,
                mesh: Some(mesh),
                role: Role::Grasp { index, score: grasp.score, is_chosen },
            });
        }
    }

    fn add_gripper_path(&mut self) {
        let Some(motion) = &self.motion else { return };
        let mut pieces = Vec::new();
        for ShownMode { mode, from_s, until_s, .. } in &motion.modes {
            let first = motion.times_s.partition_point(|time_s| time_s < from_s);
            let end = motion.times_s.partition_point(|time_s| time_s <= until_s);
            let name = format!("gripper path, {}", mode.name);
            let (colour, radius_m) = way_look(*mode);
            pieces.push((name, colour, radius_m, motion.gripper_path[first..end].to_vec()));
        }
        if pieces.is_empty() {
            let (colour, radius_m) = way_look(Mode::REACH);
            pieces.push(("gripper path".to_owned(), colour, radius_m, motion.gripper_path.clone()));
        }
        for (name, colour, radius_m, points) in pieces {
            let material = self.material(Material::matt(name.clone(), colour));
            let piece = tube(&points, radius_m, material);
            if piece.triangles.is_empty() {
                continue;
            }
            let mesh = Some(self.mesh(name.clone(), vec![piece]));
            let parent_from_node = Pose::identity();
            self.nodes.push(Node { name, parent: None, parent_from_node, mesh, role: Role::GripperPath });
        }
    }
}

/// Returns colour and radius, in metres, of the gripper path: lighter in the lift-off, darker while the object is in the hand.
fn way_look(mode: Mode) -> (Colour, f64) {
    let chosen = Colour::hex(CHOSEN);
    match mode {
        Mode { holds: true, rests_at: Some(_), .. } => (chosen.mix(Colour::WHITE, 0.6), CARRY_RADIUS_M),
        Mode { holds: true, .. } => (chosen.mix(Colour::hex(DEEP), 0.7), CARRY_RADIUS_M),
        Mode { leaves: true, .. } => (chosen.mix(Colour::hex(DEEP), 0.35), PATH_RADIUS_M),
        _ => (chosen, PATH_RADIUS_M),
    }
}

/// Returns the kind of a body from its name: the longest word of "left wall", "wall 2", `wall_b`.
fn kind_of(name: &str) -> &str {
    const SIDES: [&str; 8] = ["left", "right", "front", "back", "upper", "lower", "top", "bottom"];
    let words = name.split(|c: char| !c.is_alphabetic()).filter(|word| !SIDES.contains(word));
    words.max_by_key(|word| word.len()).unwrap_or(name)
}

/// Returns the name of the material of a score, which grasps of nearly equal score share.
fn score_name(score: Option<f64>) -> String {
    score.map_or_else(|| "grasp without score".to_owned(), |score| format!("grasp of score {score:.2}"))
}
