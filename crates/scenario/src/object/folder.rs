//! Objects on disk: a folder with `object.yaml`, the mesh and a mesh for each convex part.

use std::path::{Path, PathBuf};

use cranny_shape::{ConvexParts, StablePose, TriangleSoup, VolumeError};
use cranny_spatial::nalgebra::{Matrix3, Quaternion};
use cranny_spatial::{Point, Pose, Rotation, Vector};
use serde::{Deserialize, Serialize};

use crate::files::atomic_file::write_into;
use crate::files::yaml;
use crate::object::object_type::check_numbers;
use crate::{ObjectType, ScenarioError, write_whole_file};

/// The file that makes a folder an object.
pub const OBJECT_FILE: &str = "object.yaml";

const MESH_FILE: &str = "mesh.obj";
const PARTS_FOLDER: &str = "parts";

/// What an `object.yaml` says: metres, kilograms; matrices row by row.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ObjectFile {
    name: String,
    mesh: PathBuf,
    convex_parts: Vec<PathBuf>,
    /// Shares of the volume.
    convex_parts_error: VolumeError,
    mass_kg: f64,
    friction: f64,
    volume_m3: f64,
    center_of_mass: [f64; 3],
    /// About the centre of mass: xx, yy, zz, xy, xz, yz.
    inertia_kg_m2: [f64; 6],
    stable_poses: Vec<RestingPose>,
}

/// Pose of the object above the ground z = 0.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RestingPose {
    /// How likely it is.
    pub probability: f64,
    /// Where the object's origin is above the ground, in metres.
    pub position: [f64; 3],
    /// How it is turned there.
    pub quaternion_xyzw: [f64; 4],
}

impl ObjectType {
    /// Writes the files of the object into a folder: `object.yaml`, `mesh.obj` and `parts/NN.obj`.
    ///
    /// # Errors
    /// [`ScenarioError::Unwritable`], [`ScenarioError::ShapeFile`].
    pub fn write_folder(&self, folder: &Path) -> Result<(), ScenarioError> {
        write_into(folder, MESH_FILE, self.mesh.obj_text(1))?;
        let mut convex_parts = Vec::new();
        for (index, part) in self.parts.parts.iter().enumerate() {
            let name = format!("{PARTS_FOLDER}/{index:02}.obj");
            write_into(folder, &name, part.obj_text(1))?;
            convex_parts.push(PathBuf::from(name));
        }
        let i = &self.inertia_kg_m2;
        let file = ObjectFile {
            name: self.name.clone(),
            mesh: MESH_FILE.into(),
            convex_parts,
            convex_parts_error: self.parts.error,
            mass_kg: self.mass_kg,
            friction: self.friction,
            volume_m3: self.volume_m3,
            center_of_mass: self.center_of_mass.into(),
            inertia_kg_m2: [i.m11, i.m22, i.m33, i.m12, i.m13, i.m23],
            stable_poses: self.stable_poses.iter().map(RestingPose::of).collect(),
        };
        let path = folder.join(OBJECT_FILE);
        let text = serde_saphyr::to_string(&file).map_err(|reason| ScenarioError::Unwritable {
            path: path.clone(),
            reason: std::io::Error::other(reason.to_string()),
        })?;
        write_whole_file(&path, text.as_bytes())
    }

    /// Reads what [`Self::write_folder`] writes.
    ///
    /// # Errors
    /// [`ScenarioError`] with file and line for what is no object, [`ScenarioError::ShapeFile`] for a mesh
    /// that cannot be read or encloses no volume.
    pub fn read_folder(folder: &Path) -> Result<Self, ScenarioError> {
        let path = folder.join(OBJECT_FILE);
        let file: ObjectFile = yaml::read(&path)?;
        let load = |name: &PathBuf| TriangleSoup::load(&folder.join(name), Vector::repeat(1.0));
        let [xx, yy, zz, xy, xz, yz] = file.inertia_kg_m2;
        check_numbers(file.mass_kg, file.friction)?;
        let object = Self {
            name: file.name,
            mesh: load(&file.mesh)?,
            parts: ConvexParts {
                parts: file.convex_parts.iter().map(load).collect::<Result<_, _>>()?,
                error: file.convex_parts_error,
            },
            mass_kg: file.mass_kg,
            friction: file.friction,
            volume_m3: file.volume_m3,
            center_of_mass: Point::from(file.center_of_mass),
            inertia_kg_m2: Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz),
            stable_poses: file.stable_poses.iter().map(RestingPose::pose).collect(),
        };
        object.solid().map_err(|fault| fault.in_file(&folder.join(file.mesh)))?;
        Ok(object)
    }
}

impl RestingPose {
    /// What is written of a stable pose.
    pub fn of(stable: &StablePose) -> Self {
        let pose = &stable.ground_from_body;
        Self {
            probability: stable.probability,
            position: pose.translation.vector.into(),
            quaternion_xyzw: pose.rotation.coords.into(),
        }
    }

    fn pose(&self) -> StablePose {
        let [x, y, z, w] = self.quaternion_xyzw;
        let rotation = Rotation::from_quaternion(Quaternion::new(w, x, y, z));
        let ground_from_body = Pose::from_parts(Vector::from(self.position).into(), rotation);
        StablePose { ground_from_body, probability: self.probability }
    }
}
