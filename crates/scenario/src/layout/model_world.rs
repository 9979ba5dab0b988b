use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};

use cranny_collision::{Body, Part};
use cranny_file::did_you_mean;
use cranny_grasp::GraspSet;
use cranny_robot::{ModelText, ModelUse, WorldLink};
use cranny_shape::Solid;
use cranny_spatial::{Pose, Rotation, Vector};

use crate::layout::own::FLOOR;
use crate::layout::recipe::{Recipe, RecipeBody};
use crate::{BodyColours, RecipeRobot, ScenarioError, TargetPhysics};

/// Half the side of the box that represents a plane other than the floor, in metres, beyond the reach of any arm.
const PLANE_HALF_SIDE_M: f64 = 10.0;

/// Half the thickness of that box, in metres.
const PLANE_HALF_DEPTH_M: f64 = 0.5;

/// Conversion of a model of a world (URDF, MJCF, SDF), with a robot, into a scenario.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WorldConversion {
    /// Robot: a built-in one, a robot folder, a URDF, MJCF or SDF.
    pub robot: PathBuf,
    /// Body to grasp.
    pub target: String,
    /// Values (m, rad) of joints of the world; others have the values of the file.
    pub joints: BTreeMap<String, f64>,
    /// Bodies to be omitted, with all that is below them, such as a robot that the world contains.
    pub left_out: Vec<String>,
    /// Position (m) and heading (rad) of the robot's root in the world. Default: at the origin, its ground on the floor.
    pub robot_at: Option<([f64; 3], f64)>,
    /// Folders searched for models and packages.
    pub folders: Vec<PathBuf>,
}

impl Recipe {
    /// Returns the scenario of the world at `path`, and notes on content that was not read.
    ///
    /// A link, or a body that moves freely with all that is below it, becomes a body of the scenario. Meshes are convex hulls,
    /// as `MuJoCo` collides them; shapes that collide with nothing in the model are omitted. The highest level plane becomes
    /// the floor; without one the floor is below all bodies. Another plane becomes a box of 20 m × 20 m × 1 m.
    ///
    /// # Errors
    /// [`ScenarioError::Robot`] for a fault of the model; [`ScenarioError::UnknownBody`] for an unknown target or omitted body.
    pub fn of_world(path: &Path, conversion: &WorldConversion) -> Result<(Self, Vec<String>), ScenarioError> {
        let model = ModelText::read(path, ModelUse::World, &conversion.folders)?;
        let mut notes = model.notes.clone();
        let links = model.world_links(path, &conversion.folders, &conversion.joints)?;
        let (mut bodies, colours) = bodies(path, &model, &links, &conversion.left_out)?;
        let floor_m = floor_m(&model);
        let is_floor = |plane: &&cranny_robot::Plane| {
            height_of(&plane.world_from_plane).zip(floor_m).is_some_and(|(height, floor)| height >= floor)
        };
        for plane in model.planes.iter().filter(|plane| !is_floor(plane)) {
            bodies.push(plane_body(plane)?);
        }
        let floor_m = floor_m.unwrap_or_else(|| {
            let lowest = lowest_m(&bodies);
            notes.push(format!("{}: no level plane; the floor is put at {lowest:.3} m", path.display()));
            lowest
        });
        let mut robot = RecipeRobot::load(&conversion.robot)?;
        let scene_from_world = Pose::translation(0.0, 0.0, -floor_m);
        robot.scene_from_root = match conversion.robot_at {
            Some(([x, y, z], heading)) => {
                let turn = Rotation::from_axis_angle(&Vector::z_axis(), heading);
                scene_from_world * Pose::from_parts(Vector::new(x, y, z).into(), turn)
            }
            None => Pose::translation(0.0, 0.0, -robot.robot.floor_m().unwrap_or(0.0)),
        };
        let known: Vec<String> = bodies.iter().map(|body| body.name.clone()).collect();
        let position = known.iter().position(|name| *name == conversion.target);
        let position = position.ok_or_else(|| unknown_body(path, &conversion.target, &known))?;
        let target = bodies.remove(position);
        let masses = masses(&model, &links, &conversion.left_out);
        if let Some(mass_kg) = masses.get(&target.name) {
            notes.push(format!(
                "{}: '{}' has the stated mass, {mass_kg} kg, spread evenly over its volume, and the default friction",
                path.display(),
                target.name
            ));
        }
        // A URDF does not state which bodies move freely.
        let is_known = model.srdf.is_some();
        if is_known && !model.movable.iter().flatten().any(|link| *link == target.name) {
            notes.push(format!(
                "{}: '{}' does not move freely in the model (a joint, or the world, holds it); as the target it does",
                path.display(),
                target.name
            ));
        }
        let recipe = |body: &Body| RecipeBody::of(body, &scene_from_world, None);
        let recipe = Self {
            title: format!("from {}", path.file_name().unwrap_or_default().to_string_lossy()),
            start: robot.start(),
            robot,
            obstacles: bodies.iter().map(recipe).collect::<Result<_, _>>()?,
            target: Some(recipe(&target)?),
            given_physics: of_mass(masses.get(&target.name)),
            grasps: GraspSet::default(),
            ik: Vec::new(),
            places: Vec::new(),
            regions: BTreeMap::new(),
            tasks: Vec::new(),
            physics: bodies
                .iter()
                .filter_map(|body| Some((body.name.clone(), of_mass(Some(masses.get(&body.name)?)))))
                .collect(),
            colours,
            tool_bounds: Vec::new(),
            joint_bounds: BTreeMap::new(),
            speeds: Vec::new(),
        };
        Ok((recipe, notes))
    }
}

fn of_mass(mass_kg: Option<&f64>) -> TargetPhysics {
    TargetPhysics { mass_kg: mass_kg.copied(), ..TargetPhysics::default() }
}

/// Returns the mass (kg) of each body that moves freely, or, as in a URDF, may do so, by name: the sum over its links, if each
/// with a shape has one.
fn masses(model: &ModelText, links: &[WorldLink], left_out: &[String]) -> HashMap<String, f64> {
    let name_of = names_of_links(model);
    let mut sums: HashMap<String, Option<f64>> = HashMap::new();
    for link in links.iter().filter(|link| !is_left_out(link, left_out)) {
        let name = name_of.get(link.name.as_str()).copied();
        let Some(name) = name.or(model.srdf.is_none().then_some(link.name.as_str())) else { continue };
        let mass_kg = match &link.inertial {
            Some(inertial) => Some(inertial.mass_kg),
            None if link.solids.is_empty() => Some(0.0),
            None => None,
        };
        let sum = sums.entry(body_name(name)).or_insert(Some(0.0));
        *sum = sum.zip(mass_kg).map(|(sum, mass_kg)| sum + mass_kg);
    }
    let known = sums.into_iter().filter_map(|(name, sum)| Some((name, sum?)));
    known.filter(|(_, mass_kg)| *mass_kg > 0.0).collect()
}

/// Returns the first link of the free body of each link that belongs to one.
fn names_of_links(model: &ModelText) -> HashMap<&str, &str> {
    let groups = model.movable.iter();
    groups.flat_map(|group| group.iter().map(|link| (link.as_str(), group[0].as_str()))).collect()
}

fn is_left_out(link: &WorldLink, left_out: &[String]) -> bool {
    link.ancestors.iter().chain([&link.name]).any(|name| left_out.contains(name))
}

/// Returns the name of a body in the scenario.
fn body_name(name: &str) -> String {
    if name == FLOOR { format!("{name}_body") } else { name.to_owned() }
}

/// Returns the bodies of a world, in its frame, and their colours.
fn bodies(
    path: &Path,
    model: &ModelText,
    links: &[WorldLink],
    left_out: &[String],
) -> Result<(Vec<Body>, BodyColours), ScenarioError> {
    let known: BTreeSet<&String> =
        links.iter().flat_map(|link| link.ancestors.iter().chain([&link.name])).collect();
    if let Some(unknown) = left_out.iter().find(|name| !known.contains(name)) {
        let known: Vec<String> = known.into_iter().cloned().collect();
        return Err(unknown_body(path, unknown, &known));
    }
    // Links of one free body are one body, named after its first link.
    let name_of = names_of_links(model);
    let (mut bodies, mut colours) = (Vec::<Body>::new(), BodyColours::new());
    for link in links.iter().filter(|link| !link.solids.is_empty() && !is_left_out(link, left_out)) {
        let WorldLink { name, solids, colours: of_solids, .. } = link;
        let name = body_name(name_of.get(name.as_str()).copied().unwrap_or(name));
        let parts = solids.iter().map(|(world_from_solid, solid)| Part {
            world_from_solid: *world_from_solid,
            solid: solid.clone(),
        });
        colours.entry(name.clone()).or_default().extend(of_solids);
        match bodies.iter_mut().find(|body| body.name == name) {
            Some(body) => body.parts.extend(parts),
            None => bodies.push(Body { name, parts: parts.collect(), tilt_rad: None, center_of_mass: None }),
        }
    }
    colours.retain(|_, colours| colours.iter().any(Option::is_some));
    Ok((bodies, colours))
}

fn unknown_body(path: &Path, name: &str, known: &[String]) -> ScenarioError {
    ScenarioError::UnknownBody {
        path: path.to_owned(),
        name: name.to_owned(),
        known: if known.is_empty() { "none".to_owned() } else { cranny_file::excerpt(&known.join(", ")) },
        meant: did_you_mean(name, known.iter().map(String::as_str)),
    }
}

/// Returns the height of a plane that is level and faces up.
fn height_of(world_from_plane: &Pose) -> Option<f64> {
    const LEVEL: f64 = 1.0 - 1e-12;
    let normal = world_from_plane.rotation * Vector::z();
    (normal.z >= LEVEL).then_some(world_from_plane.translation.z)
}

/// Returns the height of the highest level plane.
fn floor_m(model: &ModelText) -> Option<f64> {
    model.planes.iter().filter_map(|plane| height_of(&plane.world_from_plane)).reduce(f64::max)
}

fn lowest_m(bodies: &[Body]) -> f64 {
    let parts = bodies.iter().flat_map(|body| &body.parts);
    let lowest = parts.map(|part| part.solid.lowest_z(&part.world_from_solid)).fold(f64::INFINITY, f64::min);
    if lowest.is_finite() { lowest } else { 0.0 }
}

/// Returns the box below a plane.
fn plane_body(plane: &cranny_robot::Plane) -> Result<Body, ScenarioError> {
    let half = Vector::new(PLANE_HALF_SIDE_M, PLANE_HALF_SIDE_M, PLANE_HALF_DEPTH_M);
    let world_from_box = plane.world_from_plane * Pose::translation(0.0, 0.0, -PLANE_HALF_DEPTH_M);
    Ok(Body::new(plane.name.clone(), world_from_box, Solid::cuboid(half)?))
}
