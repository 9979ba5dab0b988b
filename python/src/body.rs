//! `Body`: a rigid body in the world.

use std::collections::HashSet;

use cranny_collision::{Body, Part};
use cranny_shape::{BoxUnion, Outline, Solid, TriangleSoup};
use cranny_spatial::FARTHEST_M;
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict as _, PyDict, PyTuple};

use crate::classes::PyBody;
use crate::handover::array::{copied, matrices, pose_or_translation, shaped, triangles, vector};
use crate::handover::fault::{bad_value, fault};
use crate::handover::pickled::{Made, Reduced, partial};
use crate::sensing::cloud::points_of;

/// Returns a name that two of the bodies share, if any.
pub fn named_twice(bodies: &[Body]) -> Option<&str> {
    let mut names = HashSet::with_capacity(bodies.len());
    bodies.iter().map(|body| body.name.as_str()).find(|name| !names.insert(*name))
}

#[pymethods]
impl PyBody {
    /// Box of full lengths `size` (3,) along x, y, z, in metres, centred at `pose`.
    #[staticmethod]
    #[pyo3(signature = (name, size, *, pose=None))]
    pub fn r#box<'py>(
        py: Python<'py>,
        name: String,
        size: &Bound<'py, PyAny>,
        pose: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Self> {
        let mut halves = vector(size, "size")?;
        for length_m in halves.iter_mut() {
            *length_m = half("each length of a box", *length_m)?;
        }
        let solid = Solid::cuboid(halves).map_err(fault)?;
        let made = Self::made(py, "box", (&name, copied(size)?), None, pose)?;
        Self::of(name, solid, pose, made)
    }

    /// Sphere of `radius` (m), centred at `pose`.
    #[staticmethod]
    #[pyo3(signature = (name, radius, *, pose=None))]
    fn sphere<'py>(
        py: Python<'py>,
        name: String,
        radius: f64,
        pose: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Self> {
        let made = Self::made(py, "sphere", (&name, radius), None, pose)?;
        Self::of(name, Solid::sphere(radius).map_err(fault)?, pose, made)
    }

    /// Cylinder of `radius` and full `length` (m) along the z axis of `pose`, centred there.
    #[staticmethod]
    #[pyo3(signature = (name, radius, *, length, pose=None))]
    fn cylinder<'py>(
        py: Python<'py>,
        name: String,
        radius: f64,
        length: f64,
        pose: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Self> {
        let made = Self::made(py, "cylinder", (&name, radius), Some(length), pose)?;
        let half_length = half("the length of a cylinder", length)?;
        Self::of(name, Solid::cylinder(half_length, radius).map_err(fault)?, pose, made)
    }

    /// Capsule of `radius` (m) along the z axis of `pose`; `length` (m) is that of its cylindrical section.
    #[staticmethod]
    #[pyo3(signature = (name, radius, *, length, pose=None))]
    fn capsule<'py>(
        py: Python<'py>,
        name: String,
        radius: f64,
        length: f64,
        pose: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Self> {
        let made = Self::made(py, "capsule", (&name, radius), Some(length), pose)?;
        let half_length = half("the length of a capsule", length)?;
        Self::of(name, Solid::capsule(half_length, radius).map_err(fault)?, pose, made)
    }

    /// Solid bounded by a closed mesh: a `trimesh.Trimesh`, any object with `vertices` and `faces`, or a pair of arrays (V, 3)
    /// in metres and (F, 3) of indices. `hull`: use its convex hull; the mesh need not be closed.
    #[staticmethod]
    #[pyo3(signature = (name, mesh, *, pose=None, hull=false))]
    fn mesh<'py>(
        name: String,
        mesh: &Bound<'py, PyAny>,
        pose: Option<&Bound<'py, PyAny>>,
        hull: bool,
    ) -> PyResult<Self> {
        let py = mesh.py();
        let soup = triangles(mesh)?;
        let solid = if hull { Solid::hull(&soup.vertices) } else { Solid::mesh(&soup) };
        let keywords = [("hull", hull)].into_py_dict(py)?;
        keywords.set_item("pose", posed(pose)?)?;
        let constructor = partial(&py.get_type::<Self>().getattr("mesh")?, &keywords)?;
        let made = Made::by(constructor, (&name, arrays(py, &soup)?))?;
        Self::of(name, solid.map_err(fault)?, pose, made)
    }

    /// Cloud: a ball of `radius_m` (m) around each of the `points` (N, 3), in metres. The radius must cover the noise and the gaps: at
    /// least half of the diagonal between neighbouring points. Points with a coordinate that is not finite are dropped;
    /// `filter_cloud` counts them.
    #[staticmethod]
    #[pyo3(signature = (name, points, radius_m, *, pose=None))]
    fn cloud<'py>(
        py: Python<'py>,
        name: String,
        points: &Bound<'py, PyAny>,
        radius_m: f64,
        pose: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Self> {
        let read = points_of(points)?;
        let union = py.detach(|| BoxUnion::of_points(&read.cloud.points, radius_m)).map_err(fault)?;
        let kept = shaped(py, read.cloud.points.as_flattened().to_vec(), &[read.cloud.points.len(), 3])?;
        let made = Self::made(py, "cloud", (&name, kept, radius_m), None, pose)?;
        Self::of(name, Solid::union(union), pose, made)
    }

    /// Floor: everything below `height` (m) in the planning frame. Its name is "floor".
    #[staticmethod]
    #[pyo3(signature = (height=0.0))]
    fn floor(py: Python<'_>, height: f64) -> PyResult<Self> {
        if !height.is_finite() {
            return Err(bad_value(format!("height is {height}, but must be finite")));
        }
        Ok(Self {
            body: Body::floor(height),
            made: Made::by(py.get_type::<Self>().getattr("floor")?, (height,))?,
        })
    }

    /// Name of the body.
    #[getter]
    fn name(&self) -> &str {
        &self.body.name
    }

    /// Kind of each of its solids: "box", "sphere", "cylinder", "capsule", "floor", "union" (a cloud, cells of a map) or "mesh" (also for
    /// a hull).
    #[getter]
    fn kinds(&self) -> Vec<&'static str> {
        self.body.parts.iter().map(|part| kind(&part.solid)).collect()
    }

    /// Sizes of each of its solids in metres, as its constructor takes them: (x, y, z) of a box, (radius,) of a
    /// sphere, (radius, length) of a cylinder or capsule, () of others.
    #[getter]
    fn sizes(&self) -> Vec<Vec<f64>> {
        let sizes = |solid: &Solid| match solid.outline() {
            Outline::Cuboid { half_extents } => (half_extents * 2.0).as_slice().to_vec(),
            Outline::Segment { half_length_m: 0.0, radius_m } => vec![radius_m],
            Outline::Segment { half_length_m, radius_m } | Outline::Cylinder { half_length_m, radius_m } => {
                vec![radius_m, 2.0 * half_length_m]
            }
            _ => Vec::new(),
        };
        self.body.parts.iter().map(|part| sizes(&part.solid)).collect()
    }

    /// Poses of its solids, (K, 4, 4), in the planning frame.
    #[getter]
    fn poses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        matrices(py, self.body.parts.iter().map(|part| part.world_from_solid))
    }

    /// Returns the triangles of all its solids in the planning frame, normals outwards: vertices (V, 3) in metres and faces (F,
    /// 3), such that `trimesh.Trimesh(*body.triangles())` is its mesh. Round shapes are faceted; a floor has no triangles.
    fn triangles<'py>(&self, py: Python<'py>) -> PyResult<Triangles<'py>> {
        let mut whole = TriangleSoup::default();
        for Part { world_from_solid, solid } in &self.body.parts {
            whole.append(&solid.tessellation().unwrap_or_default(), world_from_solid);
        }
        arrays(py, &whole)
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        slf.get().made.reduced(slf, "it is part of a scene that was opened; pickle that instead")
    }

    fn __repr__(&self) -> String {
        format!("<cranny.Body '{}': {}>", self.body.name, self.kinds().join(", "))
    }
}

/// Vertices (V, 3) and faces (F, 3).
type Triangles<'py> = (Bound<'py, PyArrayDyn<f64>>, Bound<'py, PyArrayDyn<i64>>);

impl PyBody {
    fn of(name: String, solid: Solid, pose: Option<&Bound<'_, PyAny>>, made: Made) -> PyResult<Self> {
        Ok(Self { body: Body::new(name, pose_or_translation(pose, "pose")?, solid), made })
    }

    /// Wraps a body of an opened scene.
    pub fn of_scene(body: &Body) -> Self {
        Self { body: body.clone(), made: Made::UNKNOWN }
    }

    fn made<'py>(
        py: Python<'py>,
        constructor: &str,
        arguments: impl IntoPyObject<'py, Target = PyTuple, Output = Bound<'py, PyTuple>, Error: Into<PyErr>>,
        length: Option<f64>,
        pose: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Made> {
        let keywords = PyDict::new(py);
        keywords.set_item("pose", posed(pose)?)?;
        if let Some(length) = length {
            keywords.set_item("length", length)?;
        }
        Made::by(partial(&py.get_type::<Self>().getattr(constructor)?, &keywords)?, arguments)
    }
}

/// Returns half of a length (m), for solids that are made of half lengths; a fault names the whole length.
fn half(what: &str, length_m: f64) -> PyResult<f64> {
    let most_m = 2.0 * FARTHEST_M;
    if length_m > 0.0 && length_m <= most_m {
        Ok(0.5 * length_m)
    } else {
        Err(fault(format!("{what} must be a positive number of metres, at most {most_m}, but is {length_m}")))
    }
}

fn posed<'py>(pose: Option<&Bound<'py, PyAny>>) -> PyResult<Option<Bound<'py, PyAny>>> {
    pose.map(copied).transpose()
}

/// Converts a mesh to arrays of vertices and faces.
fn arrays<'py>(py: Python<'py>, soup: &TriangleSoup) -> PyResult<Triangles<'py>> {
    let vertices: Vec<f64> = soup.vertices.iter().flat_map(|v| [v.x, v.y, v.z]).collect();
    let faces: Vec<i64> = soup.triangles.iter().flatten().map(|corner| i64::from(*corner)).collect();
    let (v, f) = (soup.vertices.len(), soup.triangles.len());
    Ok((shaped(py, vertices, &[v, 3])?, shaped(py, faces, &[f, 3])?))
}

fn kind(solid: &Solid) -> &'static str {
    match solid.outline() {
        Outline::Cuboid { .. } => "box",
        Outline::Segment { half_length_m: 0.0, .. } => "sphere",
        Outline::Segment { .. } => "capsule",
        Outline::Cylinder { .. } => "cylinder",
        Outline::HalfSpace => "floor",
        Outline::Union => "union",
        Outline::Other => "mesh",
    }
}
