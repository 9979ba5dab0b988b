//! Objects on disk: a folder with `object.yaml`, the mesh, and a mesh for each convex part.

use std::path::{Path, PathBuf};

use cranny_robot::Location;
use cranny_shape::{ConvexParts, ShapeError, Solid, StablePose, TriangleSoup, VolumeError, stable_poses};
use cranny_spatial::nalgebra::{Matrix3, Quaternion};
use cranny_spatial::{Point, Pose, Rotation, Vector};
use serde::{Deserialize, Serialize};

use crate::files::atomic_file::write_into;
use crate::files::yaml;
use crate::object::object_type::check_numbers;
use crate::{Friction, ObjectError, ObjectSettings, ObjectType, ScenarioError, write_whole_file};

/// File that identifies a folder as an object.
pub const OBJECT_FILE: &str = "object.yaml";

const MESH_FILE: &str = "mesh.obj";
const PARTS_FOLDER: &str = "parts";

/// Schema of an `object.yaml`: metres, kilograms; matrices row by row.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ObjectFile {
    name: String,
    mesh: PathBuf,
    convex_parts: Vec<PathBuf>,
    /// Errors of the convex parts, as shares of the volume.
    convex_parts_error: VolumeError,
    mass_kg: f64,
    friction: Friction,
    volume_m3: f64,
    center_of_mass: [f64; 3],
    /// Inertia about the centre of mass: xx, yy, zz, xy, xz, yz.
    inertia_kg_m2: [f64; 6],
    stable_poses: Vec<RestingPose>,
    /// Red, green and blue, 0 to 1, sRGB.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    colour: Option<[f64; 3]>,
}

/// Returns the colour that an `object.yaml` states; `None` if it states none, or is invalid.
pub(crate) fn object_colour(path: &Path) -> Option<[f64; 3]> {
    yaml::read::<ObjectFile>(path).ok()?.colour.filter(is_colour)
}

fn is_colour(colour: &[f64; 3]) -> bool {
    colour.iter().all(|channel| (0.0..=1.0).contains(channel))
}

/// Pose of the object above the ground z = 0.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RestingPose {
    /// Probability of the pose.
    pub probability: f64,
    /// Position of the object's origin relative to the ground, in metres.
    pub position: [f64; 3],
    /// Orientation as a quaternion.
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
        let file = ObjectFile {
            name: self.name.clone(),
            mesh: MESH_FILE.into(),
            convex_parts,
            convex_parts_error: self.parts.error,
            mass_kg: self.mass_kg,
            friction: self.friction,
            volume_m3: self.volume_m3,
            center_of_mass: self.center_of_mass.into(),
            inertia_kg_m2: upper_triangle(&self.inertia_kg_m2),
            stable_poses: self.stable_poses.iter().map(RestingPose::of).collect(),
            colour: self.colour,
        };
        let path = folder.join(OBJECT_FILE);
        let text = serde_saphyr::to_string(&file).map_err(|reason| ScenarioError::Unwritable {
            path: path.clone(),
            reason: std::io::Error::other(reason.to_string()),
        })?;
        write_whole_file(&path, text.as_bytes())
    }

    /// Reads the output of [`Self::write_folder`], and compares it with the meshes.
    ///
    /// # Errors
    /// [`ScenarioError`] with file and line for an invalid object, [`ScenarioError::ShapeFile`] for a mesh that cannot be read
    /// or encloses no volume, [`ObjectError::Stated`] for a figure that disagrees with the mesh.
    pub fn read_folder(folder: &Path) -> Result<Self, ScenarioError> {
        let path = folder.join(OBJECT_FILE);
        let file: ObjectFile = yaml::read(&path)?;
        let load = |name: &PathBuf| TriangleSoup::load(&folder.join(name), Vector::repeat(1.0));
        let in_mesh = |fault: ShapeError| ScenarioError::from(fault.in_file(&folder.join(&file.mesh)));
        let in_file = |fault| {
            let at = Location { file: path.display().to_string(), line: 0 };
            ScenarioError::At { at, fault: Box::new(fault) }
        };
        check_numbers(file.mass_kg, file.friction).map_err(|fault| in_file(fault.into()))?;
        let mesh = load(&file.mesh)?;
        Solid::mesh(&mesh).map_err(in_mesh)?;
        let parts = file.convex_parts.iter().map(load).collect::<Result<_, _>>()?;
        let parts = ConvexParts::measured(&mesh, parts).map_err(in_mesh)?;
        let mut settings = ObjectSettings::new(file.name.clone(), file.mass_kg);
        settings.friction = file.friction;
        settings.least_probability = 0.0;
        let measured = Self::of_parts(mesh, parts, &settings)?;
        file.check(&measured).map_err(|(key, stated, expected)| {
            let figures = format!("{key} is {stated}; meshes and mass demand {expected}");
            ObjectError::Stated { path: path.clone(), figures }
        })?;
        if let Some(colour) = file.colour.filter(|colour| !is_colour(colour)) {
            let figures = format!("colour is {colour:?}; it must be three numbers from 0 to 1");
            return Err(ObjectError::Stated { path, figures }.into());
        }
        let [xx, yy, zz, xy, xz, yz] = file.inertia_kg_m2;
        Ok(Self {
            colour: file.colour,
            center_of_mass: Point::from(file.center_of_mass),
            inertia_kg_m2: Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz),
            stable_poses: file.stable_poses.iter().map(RestingPose::pose).collect(),
            ..measured
        })
    }
}

/// Maximum difference between a stated and a measured figure, as a share of the measured one: rounding.
const ROUNDING: f64 = 1e-3;
/// Maximum difference between shares of the volume, which is measured along lines.
const SHARE_ROUNDING: f64 = 0.01;

/// Minimum inertia as a share of that of uniform density; a smaller one belongs to another mass.
const LEAST_SPREAD: f64 = 0.05;

impl ObjectFile {
    /// Compares the content of the file with that of the mesh; the error is the first key that differs, with stated and
    /// expected value.
    ///
    /// Centre of mass and inertia may be of any density in the mesh's convex hull, stable poses only those for that centre.
    fn check(&self, measured: &ObjectType) -> Result<(), (&'static str, String, String)> {
        let differs = |key, stated: &[f64], measured: &[f64], most: f64| {
            let is_near = |(a, b): (&f64, &f64)| (a - b).abs() <= most;
            let alike = stated.iter().zip(measured).all(is_near);
            if alike { Ok(()) } else { Err((key, format!("{stated:?}"), format!("{measured:?}"))) }
        };
        differs("volume_m3", &[self.volume_m3], &[measured.volume_m3], ROUNDING * measured.volume_m3)?;
        let [stated, error] = [self.convex_parts_error, measured.parts.error];
        let [stated, error] = [[stated.excess, stated.missing], [error.excess, error.missing]];
        differs("convex_parts_error", &stated, &error, SHARE_ROUNDING)?;
        let size_m = measured.volume_m3.cbrt();
        let center = Point::from(self.center_of_mass);
        let vertices = &measured.mesh.vertices;
        let is_inside = TriangleSoup::convex_hull(vertices).is_ok_and(|hull| {
            (0..hull.triangles.len()).map(|triangle| hull.corners(triangle)).all(|[a, b, c]| {
                let outwards = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_default();
                outwards.dot(&(center - a)) <= ROUNDING * size_m
            })
        });
        if !is_inside {
            let stated = format!("{:?}", self.center_of_mass);
            return Err(("center_of_mass", stated, "a point within the convex hull of the mesh".to_owned()));
        }
        // Principal moments must be possible for a mass within reach of the centre; none exceeds the sum of the others.
        let [xx, yy, zz, xy, xz, yz] = self.inertia_kg_m2;
        let moments = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz).symmetric_eigenvalues();
        let reach_m2 = vertices.iter().map(|vertex| (vertex - center).norm_squared()).fold(0.0, f64::max);
        let most = self.mass_kg * reach_m2 * (1.0 + ROUNDING);
        let least = LEAST_SPREAD * measured.inertia_kg_m2.trace();
        let is_possible = moments.min() > 0.0
            && moments.max() <= most
            && 2.0 * moments.max() <= moments.sum() * (1.0 + ROUNDING)
            && moments.sum() >= least;
        if !is_possible {
            let expected = format!(
                "principal moments of at most {most:.3e}, of {least:.3e} or more in all, none greater than the sum \
                 of the others"
            );
            return Err(("inertia_kg_m2", format!("{:?}", self.inertia_kg_m2), expected));
        }
        let stable = stable_poses(vertices, &center).unwrap_or_default();
        let mut left = 1.0 + SHARE_ROUNDING;
        for pose in &self.stable_poses {
            let stated = pose.pose();
            let is_alike = |known: &StablePose| {
                let [a, b] = [&stated.ground_from_body, &known.ground_from_body];
                // A rotation about the vertical and a translation on the ground do not change a stable pose.
                let up = |pose: &Pose| pose.rotation.inverse() * Vector::z();
                (up(a) - up(b)).norm() <= ROUNDING
                    && (a.translation.z - b.translation.z).abs() <= ROUNDING * size_m
            };
            left -= stated.probability;
            if !(stated.probability >= 0.0 && left >= 0.0 && pose.is_unit() && stable.iter().any(is_alike)) {
                let stated = format!(
                    "z {} and quaternion {:?} with probability {}",
                    pose.position[2], pose.quaternion_xyzw, pose.probability
                );
                return Err((
                    "stable_poses",
                    stated,
                    "a pose at rest, of probabilities of at most 1 in all".to_owned(),
                ));
            }
        }
        Ok(())
    }
}

/// Returns xx, yy, zz, xy, xz, yz of a symmetric matrix.
fn upper_triangle(matrix: &Matrix3<f64>) -> [f64; 6] {
    [matrix.m11, matrix.m22, matrix.m33, matrix.m12, matrix.m13, matrix.m23]
}

impl RestingPose {
    /// Converts a stable pose for the file.
    pub fn of(stable: &StablePose) -> Self {
        let pose = &stable.ground_from_body;
        Self {
            probability: stable.probability,
            position: pose.translation.vector.into(),
            quaternion_xyzw: pose.rotation.coords.into(),
        }
    }

    fn is_unit(&self) -> bool {
        (self.quaternion_xyzw.iter().map(|part| part * part).sum::<f64>() - 1.0).abs() <= ROUNDING
    }

    fn pose(&self) -> StablePose {
        let [x, y, z, w] = self.quaternion_xyzw;
        let rotation = Rotation::from_quaternion(Quaternion::new(w, x, y, z));
        let ground_from_body = Pose::from_parts(Vector::from(self.position).into(), rotation);
        StablePose { ground_from_body, probability: self.probability, tilt_rad: None }
    }
}
