//! Export and import of worlds as `MoveIt` planning scenes.

use std::fmt::Write as _;
use std::path::Path;

use cranny_collision::{Body, Part, World};
use cranny_robot::Robot;
use cranny_shape::ShapeError;
use cranny_spatial::Pose;

use crate::moveit::base::world_from_root;
use crate::moveit::form::read_scene;
use crate::moveit::message_file::MessageFile;
use crate::moveit::world::bodies;
use crate::{RecipeShape, ScenarioError, write_whole_file};

/// Length and width of the box that represents a floor, in metres, beyond the reach of any arm; its upper side is in the plane
/// of the floor. `MoveIt`'s planes have no inside.
const FLOOR_SIDE_M: f64 = 20.0;

/// Thickness of that box, in metres.
const FLOOR_DEPTH_M: f64 = 1.0;

/// Reads the collision objects of the planning scene in `path`, in the root frame of `robot`, which also defines the frames of
/// the objects. The planning frame is the robot's root, unless the scene's robot state moves it.
///
/// # Errors
/// As [`MoveItProblem::open`](crate::MoveItProblem::open) for the scene.
pub fn read_moveit_scene(path: &Path, robot: &Robot) -> Result<World, ScenarioError> {
    let file = MessageFile::read(path)?;
    let scene = read_scene(&file)?;
    let state = (&file, &scene.robot_state);
    let world_from_root = world_from_root(&[state], robot, &mut Vec::new())?;
    Ok(World::new(bodies(&file, &scene, robot, &world_from_root)?)?)
}

/// Returns the text of a `PlanningScene`: `world` as collision objects in the frame of the robot's root, `start` (m, rad; one
/// value per joint) as the robot's state. A capsule is written as a cylinder and two spheres, a hull or a mesh as triangles, a
/// floor as a box of 20 m × 20 m × 1 m below it. [`read_moveit_scene`] reads it back.
///
/// # Errors
/// [`ScenarioError::ShapeFile`] for a shape without triangles.
pub fn moveit_scene_text(
    name: &str,
    robot: &Robot,
    world: &World,
    start: &[f64],
) -> Result<String, ScenarioError> {
    let frame = quoted(&robot.links()[robot.root()].name);
    let mut text = format!("name: {}\nrobot_model_name: {}\n", quoted(name), quoted(robot.name()));
    let names: Vec<String> = robot.joint_names().iter().map(|name| quoted(name)).collect();
    let _ = writeln!(text, "robot_state:\n  joint_state:\n    name: [{}]", names.join(", "));
    let _ = writeln!(text, "    position: {}", list(start));
    text.push_str("fixed_frame_transforms: []\nworld:\n");
    let is_empty = world.bodies().is_empty();
    let _ = writeln!(text, "  collision_objects:{}", if is_empty { " []" } else { "" });
    for body in world.bodies() {
        write_body(&mut text, body, &frame)?;
    }
    Ok(text)
}

/// Writes [`moveit_scene_text`] of the robot at `start` (m, rad; one per joint) to a file, atomically.
///
/// # Errors
/// As there, and [`ScenarioError::Unwritable`].
pub fn write_moveit_scene(
    path: &Path,
    name: &str,
    robot: &Robot,
    world: &World,
    start: &[f64],
) -> Result<(), ScenarioError> {
    write_whole_file(path, moveit_scene_text(name, robot, world, start)?.as_bytes())
}

fn write_body(text: &mut String, body: &Body, frame: &str) -> Result<(), ScenarioError> {
    let _ = writeln!(text, "    - id: {}\n      header: {{frame_id: {frame}}}", quoted(&body.name));
    let (mut primitives, mut primitive_poses) = (String::new(), String::new());
    let (mut meshes, mut mesh_poses) = (String::new(), String::new());
    for part in &body.parts {
        let pose = |pose: &Pose| {
            let (position, orientation) =
                (list(pose.translation.vector.as_slice()), list(pose.rotation.coords.as_slice()));
            format!("        - {{position: {position}, orientation: {orientation}}}\n")
        };
        let known = primitives_of(part)?;
        for Primitive { kind, dimensions, shift_m } in &known {
            let _ = writeln!(primitives, "        - {{type: {kind}, dimensions: {}}}", list(dimensions));
            primitive_poses += &pose(&(part.world_from_solid * Pose::translation(0.0, 0.0, *shift_m)));
        }
        if known.is_empty() {
            let soup = part.solid.tessellation().ok_or(ShapeError::Empty)?;
            let vertices: Vec<String> = soup.vertices.iter().map(|v| list(v.coords.as_slice())).collect();
            let triangles: Vec<String> =
                soup.triangles.iter().map(|[a, b, c]| format!("[{a}, {b}, {c}]")).collect();
            let _ = writeln!(meshes, "        - vertices: [{}]", vertices.join(", "));
            let _ = writeln!(meshes, "          triangles: [{}]", triangles.join(", "));
            mesh_poses += &pose(&part.world_from_solid);
        }
    }
    for (key, entries) in [
        ("primitives", primitives),
        ("primitive_poses", primitive_poses),
        ("meshes", meshes),
        ("mesh_poses", mesh_poses),
    ] {
        if !entries.is_empty() {
            let _ = write!(text, "      {key}:\n{entries}");
        }
    }
    text.push_str("      operation: add\n");
    Ok(())
}

/// Shape that `MoveIt` supports.
struct Primitive {
    kind: &'static str,
    dimensions: Vec<f64>,
    /// Offset of its centre from that of the part along z, in metres.
    shift_m: f64,
}

/// Returns the part as such shapes; none if it must be written as triangles. A capsule is a cylinder and two spheres.
fn primitives_of(part: &Part) -> Result<Vec<Primitive>, ScenarioError> {
    let of = |kind, dimensions: &[f64], shift_m| Primitive { kind, dimensions: dimensions.to_vec(), shift_m };
    if part.solid.is_half_space() {
        return Ok(vec![of("box", &[FLOOR_SIDE_M, FLOOR_SIDE_M, FLOOR_DEPTH_M], -0.5 * FLOOR_DEPTH_M)]);
    }
    Ok(match RecipeShape::of(&part.solid)? {
        RecipeShape::Cuboid(size) => vec![of("box", size.as_slice(), 0.0)],
        RecipeShape::Sphere(radius_m) => vec![of("sphere", &[radius_m], 0.0)],
        RecipeShape::Cylinder(radius_m, length_m) => vec![of("cylinder", &[length_m, radius_m], 0.0)],
        RecipeShape::Capsule(radius_m, length_m) => vec![
            of("cylinder", &[length_m, radius_m], 0.0),
            of("sphere", &[radius_m], 0.5 * length_m),
            of("sphere", &[radius_m], -0.5 * length_m),
        ],
        _ => Vec::new(),
    })
}

/// Returns a YAML string; a JSON string is one.
fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

/// Returns a list with a decimal point in every number, which some readers of messages require.
fn list(numbers: &[f64]) -> String {
    format!("[{}]", numbers.iter().map(|number| format!("{number:?}")).collect::<Vec<_>>().join(", "))
}
