use std::collections::HashMap;
use std::path::{Path, PathBuf};

use cranny_shape::{ShapeError, Solid, TriangleSoup, cuboid_of_faces};
use cranny_spatial::{Pose, Vector};
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_saphyr::Spanned;

use crate::files::yaml;
use crate::{Friction, ScenarioError, TargetPhysics};

/// Released object library: meshes of each object type.
pub(crate) struct ObjectLibrary {
    path: PathBuf,
    folder: PathBuf,
    objects: Vec<ObjectEntry>,
    /// Index of the first object of each identifier.
    by_identifier: HashMap<String, usize>,
}

/// Library entry of an object type; stable poses are not read.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ObjectEntry {
    identifier: String,
    mesh_fn: PathBuf,
    vhacd_fn: Option<PathBuf>,
    #[serde(default = "unscaled")]
    scale: f64,
    mass: Option<Spanned<f64>>,
    friction_coeff: Option<Spanned<f64>>,
    #[serde(rename = "name")]
    _name: Option<IgnoredAny>,
    #[serde(rename = "stable_poses")]
    _stable_poses: Option<IgnoredAny>,
    #[serde(rename = "thumbnail_fn")]
    _thumbnail: Option<IgnoredAny>,
    // The URDF is generated from the mesh and the convex parts, for simulators.
    #[serde(rename = "urdf_fn")]
    _urdf: Option<IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LibraryFile {
    objects: Vec<ObjectEntry>,
    #[serde(rename = "name")]
    _name: Option<IgnoredAny>,
    #[serde(rename = "description")]
    _description: Option<IgnoredAny>,
    #[serde(rename = "yaml_file_type")]
    _file_type: Option<IgnoredAny>,
    #[serde(rename = "yaml_file_version")]
    _file_version: Option<IgnoredAny>,
}

fn unscaled() -> f64 {
    1.0
}

impl ObjectLibrary {
    pub fn load(path: &Path) -> Result<Self, ScenarioError> {
        let file: LibraryFile = yaml::read(path)?;
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let mut by_identifier = HashMap::new();
        for (index, object) in file.objects.iter().enumerate() {
            by_identifier.entry(object.identifier.clone()).or_insert(index);
        }
        Ok(Self { path: path.to_owned(), folder, objects: file.objects, by_identifier })
    }

    pub fn object(&self, identifier: &str) -> Option<&ObjectEntry> {
        self.by_identifier.get(identifier).map(|&index| &self.objects[index])
    }

    /// Returns all identifiers, for a message about an unknown one.
    pub fn known(&self) -> String {
        self.objects.iter().map(|object| object.identifier.as_str()).collect::<Vec<_>>().join(", ")
    }

    /// Returns the solids of an obstacle in its own frame: the cuboids of its mesh, twelve faces each, or the enclosed volume.
    pub fn obstacle(&self, object: &ObjectEntry) -> Result<Vec<(Pose, Solid)>, ShapeError> {
        let path = self.folder.join(&object.mesh_fn);
        let soup = TriangleSoup::load(&path, Vector::repeat(object.scale))?;
        let faces = soup.triangles.len();
        let cuboids: Option<Vec<_>> = (0..faces)
            .step_by(FACES_OF_CUBOID)
            .map(|first| {
                cuboid_of_faces(&soup, first..faces.min(first + FACES_OF_CUBOID), CORNER_TOLERANCE_M)
            })
            .collect();
        match cuboids {
            Some(cuboids) => {
                cuboids.into_iter().map(|(pose, half)| Ok((pose, Solid::cuboid(half)?))).collect()
            }
            None => Ok(vec![(Pose::identity(), Solid::mesh(&soup).map_err(|fault| fault.in_file(&path))?)]),
        }
    }

    /// Returns mass and friction of an object to grasp, if the library states them. A mass of 0, which fixes an object in a
    /// simulator, counts as not stated.
    pub fn physics(&self, object: &ObjectEntry) -> Result<TargetPhysics, ScenarioError> {
        let positive = |what: &'static str, number: &Spanned<f64>| {
            yaml::positive(&self.path, what, number.value, number.referenced)
        };
        let mass = object.mass.as_ref().filter(|mass| mass.value != 0.0);
        Ok(TargetPhysics {
            mass_kg: mass.map(|mass| positive("mass", mass)).transpose()?,
            friction: object
                .friction_coeff
                .as_ref()
                .map(|number| positive("friction", number).map(Friction::from))
                .transpose()?,
            rolling_m: None,
        })
    }

    /// Returns the solid of an object to grasp, in its own frame: the volume that its simplified mesh encloses, not its hull;
    /// the scans have holes.
    pub fn target(&self, object: &ObjectEntry) -> Result<Solid, ShapeError> {
        let path = self.folder.join(object.vhacd_fn.as_ref().unwrap_or(&object.mesh_fn));
        let soup = TriangleSoup::load(&path, Vector::repeat(object.scale))?;
        Solid::mesh(&soup).map_err(|fault| fault.in_file(&path))
    }
}

const FACES_OF_CUBOID: usize = 12;

/// Tolerance of corners, in metres. Mesh files are read in single precision, so a coordinate of 2 m is off by at most 1.2e-7 m.
const CORNER_TOLERANCE_M: f64 = 1e-6;
