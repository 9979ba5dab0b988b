use std::collections::HashSet;

use cranny_collision::{Body, Part};
use cranny_robot::Robot;
use cranny_shape::{ShapeError, Solid, TriangleSoup};
use cranny_spatial::{Point, Pose, Vector};
use serde_saphyr::Spanned;

use crate::MoveItError;
use crate::ScenarioError;
use crate::files::sizes;
use crate::moveit::file::{MeshEntry, ObjectEntry, PrimitiveEntry, SceneFile, TriangleEntry};
use crate::moveit::frames::Frames;
use crate::moveit::message_file::MessageFile;
use crate::moveit::octomap::octomap_body;

/// Returns the bodies of a scene, in the root frame of the robot; `world_from_root` is the pose of the robot.
pub(crate) fn bodies(
    file: &MessageFile,
    scene: &SceneFile,
    robot: &Robot,
    world_from_root: &Pose,
) -> Result<Vec<Body>, ScenarioError> {
    file.refuse_what_is_not_read(scene)?;
    let frames = Frames::new(file, scene, robot, world_from_root)?;
    let mut bodies: Vec<Body> = Vec::new();
    let mut names = HashSet::new();
    let Some(world) = &scene.world else { return Ok(bodies) };
    for object in &world.collision_objects {
        let name = &object.id.value;
        if !names.insert(name) {
            return Err(ScenarioError::NameTaken { at: file.at(object.id.referenced), name: name.clone() });
        }
        let root_from_object =
            frames.find(file, &object.header)? * file.optional_pose(object.pose.as_ref())?;
        bodies.push(file.body(object, &root_from_object)?);
    }
    if let Some(octomap) = &world.octomap {
        bodies.extend(octomap_body(file, &frames, octomap)?);
    }
    for Body { name, parts, tilt_rad, center_of_mass } in &world.text_bodies {
        let placed = |part: &Part| Part {
            world_from_solid: frames.planning() * part.world_from_solid,
            solid: part.solid.clone(),
        };
        bodies.push(Body {
            name: name.clone(),
            parts: parts.iter().map(placed).collect(),
            tilt_rad: *tilt_rad,
            center_of_mass: *center_of_mass,
        });
    }
    Ok(bodies)
}

impl MessageFile {
    /// Refuses content that would change the world but is not supported.
    fn refuse_what_is_not_read(&self, scene: &SceneFile) -> Result<(), ScenarioError> {
        if let Some(is_diff) = scene.is_diff.as_ref().filter(|is_diff| is_diff.value) {
            let hint = "give the whole scene, with is_diff: false";
            return Err(self.unsupported(is_diff.referenced, "a change to another scene", hint));
        }
        let attached = &scene.robot_state.attached_collision_objects;
        self.refuse(attached, "an attached object", "add it to the URDF")?;
        let grown = scene.link_padding.iter().map(|entry| (&entry.padding, 0.0));
        for (number, neutral) in grown.chain(scene.link_scale.iter().map(|entry| (&entry.scale, 1.0))) {
            if (number.value - neutral).abs() > 0.0 || number.value.is_nan() {
                let hint = "demand a margin instead";
                return Err(self.unsupported(number.referenced, "padding or scaling of links", hint));
            }
        }
        Ok(())
    }

    fn body(&self, object: &ObjectEntry, root_from_object: &Pose) -> Result<Body, ScenarioError> {
        let (name, location) = (&object.id.value, object.id.referenced);
        if let Some(operation) = &object.operation
            && operation.value.name(&["add", "remove", "append", "move"], 0) != "add"
        {
            let hint = "give the scene as it is, each object added once";
            return Err(self.unsupported(operation.referenced, "a change to an object", hint));
        }
        for planes in [&object.planes, &object.plane_poses] {
            self.refuse(planes, "a plane", "give a box")?;
        }
        let mut parts = Vec::new();
        for (kind, poses, count) in [
            ("primitive", &object.primitive_poses, object.primitives.len()),
            ("mesh", &object.mesh_poses, object.meshes.len()),
        ] {
            // Newer messages omit the pose of a shape that coincides with that of its object.
            if poses.len() != count && !(poses.is_empty() && object.pose.is_some()) {
                let (at, object) = (self.at(location), name.clone());
                return Err(MoveItError::PoseCount {
                    at,
                    object,
                    kind,
                    expected: count,
                    actual: poses.len(),
                }
                .into());
            }
            for index in 0..count {
                let solid = match kind {
                    "mesh" => self.mesh(name, &object.meshes[index])?,
                    _ => self.primitive(name, &object.primitives[index])?,
                };
                let world_from_solid = root_from_object * self.optional_pose(poses.get(index))?;
                parts.push(Part { world_from_solid, solid });
            }
        }
        if parts.is_empty() {
            return Err(MoveItError::NoShape { at: self.at(location), object: name.clone() }.into());
        }
        Ok(Body { name: name.clone(), parts, tilt_rad: None, center_of_mass: None })
    }

    fn primitive(&self, object: &str, entry: &Spanned<PrimitiveEntry>) -> Result<Solid, ScenarioError> {
        // Names of the kinds of `shape_msgs/SolidPrimitive`.
        let kind = entry.value.kind.name(&["box", "sphere", "cylinder", "cone", "prism"], 1);
        let mut numbers = Vec::new();
        for number in &entry.value.dimensions {
            numbers.push(self.finite(number)?);
        }
        let at = self.at(entry.referenced);
        let (solid, dimensions) = match (kind.as_str(), &numbers[..]) {
            ("box", &[x, y, z]) => (sizes::cuboid([x, y, z]), ""),
            ("sphere", &[radius_m]) => (Solid::sphere(radius_m), ""),
            ("cylinder", &[height_m, radius_m]) => (sizes::cylinder(height_m, radius_m), ""),
            ("box", _) => (Err(ShapeError::Empty), "x, y, z"),
            ("sphere", _) => (Err(ShapeError::Empty), "radius"),
            ("cylinder", _) => (Err(ShapeError::Empty), "height, radius"),
            ("cone", _) => {
                let hint = "a cone has no exact solid here; give a mesh";
                return Err(self.unsupported(entry.referenced, "a cone", hint));
            }
            _ => return Err(MoveItError::UnknownPrimitive { at, object: object.to_owned(), kind }.into()),
        };
        if !dimensions.is_empty() {
            let (object, actual) = (object.to_owned(), numbers.len());
            return Err(MoveItError::Dimensions { at, object, kind, expected: dimensions, actual }.into());
        }
        solid.map_err(|reason| ScenarioError::Shape { at, body: object.to_owned(), reason })
    }

    fn mesh(&self, object: &str, entry: &Spanned<MeshEntry>) -> Result<Solid, ScenarioError> {
        let MeshEntry { vertices, triangles, resource, dimensions } = &entry.value;
        let fault = |reason| {
            let at = self.at(entry.referenced);
            ScenarioError::Shape { at, body: object.to_owned(), reason }
        };
        if let Some(resource) = resource {
            let tried = cranny_robot::mesh_candidates(resource, self.folder(), &[]);
            let Some(path) = tried.iter().find(|path| path.is_file()).or(tried.first()) else {
                let hint = "give the path of the mesh file, relative to the scene or in full";
                return Err(self.unsupported(entry.referenced, "a mesh URL of this kind", hint));
            };
            let scale = dimensions.map_or(Vector::repeat(1.0), |scale| Vector::from(scale.0));
            let soup = TriangleSoup::load(path, scale).map_err(fault)?;
            if !vertices.is_empty() || !triangles.is_empty() {
                let hint = "give a file or triangles, not both";
                return Err(self.unsupported(entry.referenced, "a mesh that is given twice", hint));
            }
            return Solid::mesh_with_small_holes(&soup).map_err(|reason| fault(reason.in_file(path)));
        }
        if dimensions.is_some() {
            let hint = "only a mesh file is scaled; give the vertices in metres, and leave `dimensions` out";
            return Err(self.unsupported(entry.referenced, "a scale of vertices", hint));
        }
        let mut soup = TriangleSoup { vertices: Vec::new(), triangles: Vec::new() };
        for vertex in vertices {
            for number in vertex.value.0 {
                self.finite_at(number, vertex.referenced)?;
            }
            soup.vertices.push(Point::from(vertex.value.0));
        }
        soup.triangles.extend(triangles.iter().map(TriangleEntry::corners));
        Solid::mesh_with_small_holes(&soup).map_err(fault)
    }
}
