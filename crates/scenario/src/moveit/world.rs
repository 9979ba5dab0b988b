use std::collections::{BTreeMap, HashSet};
use std::path::Path;

use cranny_collision::{Body, Part};
use cranny_robot::{Location, Robot};
use cranny_shape::{ShapeError, Solid, TriangleSoup};
use cranny_spatial::{Point, Pose, Rotation, Vector};
use serde_saphyr::Spanned;

use crate::MoveItError;
use crate::ScenarioError;
use crate::files::sizes;
use crate::files::yaml;
use crate::moveit::file::{
    HeaderEntry, MeshEntry, NameOrNumber, ObjectEntry, PoseEntry, PrimitiveEntry, SceneFile, TriangleEntry,
};

/// The bodies of a scene, in the planning frame; `world_from_root` is where the robot stands.
pub(crate) fn bodies(
    path: &Path,
    scene: &SceneFile,
    robot: &Robot,
    world_from_root: &Pose,
) -> Result<Vec<Body>, ScenarioError> {
    let file = MessageFile { path };
    file.refuse_what_is_not_read(scene)?;
    let frames = Frames::new(&file, scene, robot, world_from_root)?;
    let mut bodies: Vec<Body> = Vec::new();
    let mut names = HashSet::new();
    for object in &scene.world.collision_objects {
        let name = &object.id.value;
        if !names.insert(name) {
            return Err(ScenarioError::NameTaken { at: file.at(object.id.referenced), name: name.clone() });
        }
        let root_from_object =
            frames.find(&file, &object.header)? * file.optional_pose(object.pose.as_ref())?;
        bodies.push(file.body(object, &root_from_object)?);
    }
    Ok(bodies)
}

/// A file of messages: what errors name, and what its entries mean.
pub(crate) struct MessageFile<'a> {
    pub path: &'a Path,
}

impl MessageFile<'_> {
    pub fn at(&self, location: serde_saphyr::Location) -> Location {
        yaml::at(self.path, location)
    }

    pub fn finite(&self, number: &Spanned<f64>) -> Result<f64, ScenarioError> {
        yaml::finite(self.path, number.value, number.referenced)
    }

    /// A quaternion of four zeros, which is what a message holds that nobody filled in, turns nothing.
    pub fn pose(&self, entry: &Spanned<PoseEntry>) -> Result<Pose, ScenarioError> {
        let position = entry.value.position.map_or([0.0; 3], |position| position.0);
        let orientation = entry.value.orientation.map_or([0.0; 4], |orientation| orientation.0);
        for number in position.into_iter().chain(orientation) {
            yaml::finite(self.path, number, entry.referenced)?;
        }
        let rotation = if orientation.iter().all(|value| *value == 0.0) {
            Rotation::identity()
        } else {
            yaml::rotation(self.path, orientation, entry.referenced)?
        };
        Ok(Pose::from_parts(Vector::from(position).into(), rotation))
    }

    fn optional_pose(&self, entry: Option<&Spanned<PoseEntry>>) -> Result<Pose, ScenarioError> {
        entry.map_or_else(|| Ok(Pose::identity()), |entry| self.pose(entry))
    }

    pub fn unsupported(
        &self,
        location: serde_saphyr::Location,
        what: &'static str,
        hint: &'static str,
    ) -> ScenarioError {
        ScenarioError::Unsupported { at: self.at(location), what, hint }
    }

    /// What would make the world another one than is read.
    fn refuse_what_is_not_read(&self, scene: &SceneFile) -> Result<(), ScenarioError> {
        if let Some(octomap) = &scene.world.octomap {
            return Err(self.unsupported(octomap.referenced, "an octomap", "give its obstacles as objects"));
        }
        if let Some(attached) = &scene.robot_state.attached_collision_objects
            && !attached.value.is_empty()
        {
            return Err(self.unsupported(attached.referenced, "an attached object", "add it to the URDF"));
        }
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
        if let Some(operation) = &object.operation {
            let is_addition = match &operation.value {
                NameOrNumber::Number(number) => *number == 0,
                NameOrNumber::Name(name) => name.eq_ignore_ascii_case("add"),
            };
            if !is_addition {
                let hint = "give the scene as it is, each object added once";
                return Err(self.unsupported(operation.referenced, "a change to an object", hint));
            }
        }
        if let Some(plane) = object.planes.first() {
            return Err(self.unsupported(plane.referenced, "a plane", "give a box"));
        }
        let mut parts = Vec::new();
        for (kind, poses, count) in [
            ("primitive", &object.primitive_poses, object.primitives.len()),
            ("mesh", &object.mesh_poses, object.meshes.len()),
        ] {
            // Newer messages leave out the pose of a shape that is its object's.
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
        Ok(Body { name: name.clone(), parts })
    }

    fn primitive(&self, object: &str, entry: &Spanned<PrimitiveEntry>) -> Result<Solid, ScenarioError> {
        let kind = match &entry.value.kind {
            // Of `shape_msgs/SolidPrimitive`.
            NameOrNumber::Number(number) => {
                let names = ["box", "sphere", "cylinder", "cone"];
                let index = usize::from(*number).checked_sub(1);
                index
                    .and_then(|index| names.get(index))
                    .map_or_else(|| number.to_string(), |&name| name.into())
            }
            NameOrNumber::Name(name) => name.to_lowercase(),
        };
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
            let name = resource.strip_prefix("file://").unwrap_or(resource);
            if name.contains("://") {
                let hint = "name the mesh file relative to the scene, or in full";
                return Err(self.unsupported(entry.referenced, "a mesh under another address", hint));
            }
            let path = self.path.parent().unwrap_or(Path::new("")).join(name);
            let scale = dimensions.map_or(Vector::repeat(1.0), |scale| Vector::from(scale.0));
            let soup = TriangleSoup::load(&path, scale).map_err(fault)?;
            return Solid::mesh(&soup).map_err(|reason| fault(reason.in_file(&path)));
        }
        let mut soup = TriangleSoup { vertices: Vec::new(), triangles: Vec::new() };
        for vertex in vertices {
            for number in vertex.value.0 {
                yaml::finite(self.path, number, vertex.referenced)?;
            }
            soup.vertices.push(Point::from(vertex.value.0));
        }
        soup.triangles.extend(triangles.iter().map(|triangle| match triangle {
            TriangleEntry::List(corners) | TriangleEntry::Message { vertex_indices: corners } => *corners,
        }));
        Solid::mesh(&soup).map_err(fault)
    }
}

/// The frames that poses can be given in: the world, links that stand still, and what the scene fixes.
struct Frames(BTreeMap<String, Pose>);

impl Frames {
    fn new(
        file: &MessageFile<'_>,
        scene: &SceneFile,
        robot: &Robot,
        world_from_root: &Pose,
    ) -> Result<Self, ScenarioError> {
        let rest = robot.frames();
        let still = (0..robot.links().len()).filter(|&link| robot.ancestors(link).is_empty());
        let mut root_from: BTreeMap<String, Pose> =
            still.map(|link| (robot.links()[link].name.clone(), *rest.link(link))).collect();
        root_from.insert(WORLD.to_owned(), world_from_root.inverse());
        let mut frames = Self(root_from);
        for entry in &scene.fixed_frame_transforms {
            let root_from_frame = frames.find(file, &entry.header)? * file.pose(&entry.transform)?;
            frames.0.entry(entry.child_frame_id.clone()).or_insert(root_from_frame);
        }
        Ok(frames)
    }

    /// `root_from_frame`.
    fn find(&self, file: &MessageFile<'_>, header: &HeaderEntry) -> Result<Pose, ScenarioError> {
        let Some(frame) = &header.frame_id else { return Ok(self.0[WORLD]) };
        let name = frame.value.trim_start_matches('/');
        let name = if name.is_empty() { WORLD } else { name };
        self.0.get(name).copied().ok_or_else(|| {
            MoveItError::UnknownFrame {
                at: file.at(frame.referenced),
                frame: name.to_owned(),
                known: self.0.keys().cloned().collect::<Vec<_>>().join(", "),
            }
            .into()
        })
    }
}

const WORLD: &str = "world";
