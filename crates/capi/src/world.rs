//! `CrannyWorld`: the bodies around a robot, added one by one.

use std::collections::HashSet;
use std::mem::MaybeUninit;
use std::path::Path;

use cranny::collision::{Body, World};
use cranny::scenario::read_moveit_scene;
use cranny::shape::{Solid, TriangleSoup};
use cranny::spatial::{Point, Vector};

use crate::boundary::{Indices, Numbers, Text, answered, given, guarded, put};
use crate::error::{CrannyStatus, Fault};
use crate::options::pose_or_identity;
use crate::robot::CrannyRobot;

/// Bodies, to which functions add. A cell or a scenario takes a copy of the bodies that there are when it is made.
///
/// A pose is world_from_body in the planning frame: 16 values of a homogeneous matrix, row by row, in metres; NULL is the
/// identity. Names are unique.
#[derive(Debug, Default)]
pub struct CrannyWorld {
    bodies: Vec<Body>,
    names: HashSet<String>,
}

impl CrannyWorld {
    /// Returns the world as it is now.
    pub fn now(&self) -> Result<World, Fault> {
        Ok(World::new(self.bodies.clone())?)
    }

    fn add(&mut self, body: Body) -> Result<(), Fault> {
        // Refuses a pose that no world may have.
        World::new(vec![body.clone()])?;
        if !self.names.insert(body.name.clone()) {
            return Err(Fault::NamedTwice { name: body.name });
        }
        self.bodies.push(body);
        Ok(())
    }
}

/// Adds a body of one solid, which `shape` makes.
fn add_solid(
    world: Option<&mut CrannyWorld>,
    name: Text<'_>,
    pose: Numbers<'_>,
    shape: impl FnOnce() -> Result<Solid, Fault>,
) -> CrannyStatus {
    guarded(|| {
        let world = given(world, "world")?;
        let name = name.read("name")?;
        world.add(Body::new(name, pose_or_identity(pose, "pose")?, shape()?))
    })
}

/// Makes a world without a body. The caller frees it with cranny_world_free.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_world_new(
    world: Option<&mut MaybeUninit<Option<Box<CrannyWorld>>>>,
) -> CrannyStatus {
    guarded(|| put(world, "world", Some(Box::default())))
}

/// Reads the collision objects of a MoveIt planning scene (YAML or JSON) in the frame of the robot's root. The caller frees the
/// world with cranny_world_free.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_world_from_moveit_scene(
    path: Text<'_>,
    robot: Option<&CrannyRobot>,
    world: Option<&mut MaybeUninit<Option<Box<CrannyWorld>>>>,
) -> CrannyStatus {
    guarded(|| {
        let robot = given(robot, "robot")?;
        let read = read_moveit_scene(Path::new(path.read("path")?), &robot.robot)?;
        let mut made = Box::<CrannyWorld>::default();
        read.bodies().iter().try_for_each(|body| made.add(body.clone()))?;
        put(world, "world", Some(made))
    })
}

/// Frees a world. NULL is ignored.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_world_free(world: Option<Box<CrannyWorld>>) {
    drop(world);
}

/// Returns the number of bodies; 0 for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_world_body_count(world: Option<&CrannyWorld>) -> usize {
    answered(0, || Ok(given(world, "world")?.bodies.len()))
}

/// Adds a box of full lengths `size`, 3 values in metres, centred at `pose`.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_world_add_box(
    world: Option<&mut CrannyWorld>,
    name: Text<'_>,
    size: Numbers<'_>,
    pose: Numbers<'_>,
) -> CrannyStatus {
    add_solid(world, name, pose, || {
        let size = size.finite("size", 1, 3)?;
        Ok(Solid::cuboid(Vector::from_column_slice(size) * 0.5)?)
    })
}

/// Adds a sphere, centred at `pose`.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_world_add_sphere(
    world: Option<&mut CrannyWorld>,
    name: Text<'_>,
    radius_m: f64,
    pose: Numbers<'_>,
) -> CrannyStatus {
    add_solid(world, name, pose, || Ok(Solid::sphere(radius_m)?))
}

/// Adds a cylinder of full `length_m` along the z axis of `pose`, centred there.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_world_add_cylinder(
    world: Option<&mut CrannyWorld>,
    name: Text<'_>,
    radius_m: f64,
    length_m: f64,
    pose: Numbers<'_>,
) -> CrannyStatus {
    add_solid(world, name, pose, || Ok(Solid::cylinder(0.5 * length_m, radius_m)?))
}

/// Adds a capsule along the z axis of `pose`, centred there; `length_m` is that of its cylindrical section.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_world_add_capsule(
    world: Option<&mut CrannyWorld>,
    name: Text<'_>,
    radius_m: f64,
    length_m: f64,
    pose: Numbers<'_>,
) -> CrannyStatus {
    add_solid(world, name, pose, || Ok(Solid::capsule(0.5 * length_m, radius_m)?))
}

/// Adds the solid that a closed mesh bounds: `vertices`, `vertex_count` × 3 in metres, and `triangles`, `triangle_count` × 3
/// indices of vertices. With `hull` it is the convex hull of the vertices, and the mesh need not be closed.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments, reason = "arrays of C come with their lengths")]
pub extern "C" fn cranny_world_add_mesh(
    world: Option<&mut CrannyWorld>,
    name: Text<'_>,
    vertices: Numbers<'_>,
    vertex_count: usize,
    triangles: Indices<'_>,
    triangle_count: usize,
    hull: bool,
    pose: Numbers<'_>,
) -> CrannyStatus {
    add_solid(world, name, pose, || {
        let soup = soup(vertices, vertex_count, triangles, triangle_count)?;
        Ok(if hull { Solid::hull(&soup.vertices)? } else { Solid::mesh(&soup)? })
    })
}

/// Adds a floor: everything below `height_m` in the planning frame. Its name is "floor".
#[unsafe(no_mangle)]
pub extern "C" fn cranny_world_add_floor(world: Option<&mut CrannyWorld>, height_m: f64) -> CrannyStatus {
    guarded(|| {
        let world = given(world, "world")?;
        if !height_m.is_finite() {
            let expected = "must be finite";
            return Err(Fault::Range { what: "height_m", value: height_m, expected });
        }
        world.add(Body::floor(height_m))
    })
}

/// Reads a mesh.
pub fn soup(
    vertices: Numbers<'_>,
    vertex_count: usize,
    triangles: Indices<'_>,
    triangle_count: usize,
) -> Result<TriangleSoup, Fault> {
    let vertices = vertices.finite("vertices", vertex_count, 3)?;
    let triangles = triangles.values("triangles", triangle_count, 3)?;
    let is_beyond = |corner: &&u32| usize::try_from(**corner).map_or(true, |corner| corner >= vertex_count);
    if let Some(corner) = triangles.iter().find(is_beyond) {
        let index = usize::try_from(*corner).unwrap_or(usize::MAX);
        return Err(Fault::Index { what: "a corner of a triangle", index, count: vertex_count });
    }
    Ok(TriangleSoup {
        vertices: vertices.as_chunks::<3>().0.iter().map(|vertex| Point::from(*vertex)).collect(),
        triangles: triangles.as_chunks::<3>().0.to_vec(),
    })
}
