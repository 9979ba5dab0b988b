//! Filters of point clouds, and points of messages.

use cranny_sense::{CloudField, CloudMessage, PointCloud, ReadCloud, robot_solids};
use cranny_shape::Aabb;
use cranny_spatial::{Point, Pose};
use numpy::PyArrayDyn;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::classes::{PyBody, PyRobot};
use crate::handover::array::{Numbers, configuration, pose_or_translation, shaped};
use crate::handover::fault::{bad_value, fault};

/// Reads points (N, 3) in metres; those with a coordinate that is not finite are dropped and counted.
///
/// # Errors
/// ValueError for another shape or type, a coordinate beyond 1000 m, or a cloud without a valid point.
pub fn points_of(points: &Bound<'_, PyAny>) -> PyResult<ReadCloud> {
    if points.is_none() {
        return Err(bad_value("points is None, but an array (N, 3) of numbers in metres is expected"));
    }
    let of_type = |reason: PyErr| {
        let is_type = reason.is_instance_of::<PyTypeError>(points.py());
        if is_type { bad_value(reason.value(points.py()).to_string()) } else { reason }
    };
    let numbers = Numbers::read(points, "points").map_err(of_type)?;
    let [_, 3] = *numbers.shape() else { return Err(numbers.wrong_shape("(N, 3)")) };
    ReadCloud::of_points(numbers.values()?.as_chunks::<3>().0)
        .map_err(|reason| bad_value(format!("points: {reason}")))
}

type Points<'py> = Bound<'py, PyArrayDyn<f32>>;

fn array<'py>(py: Python<'py>, cloud: &PointCloud) -> PyResult<Points<'py>> {
    shaped(py, cloud.points.as_flattened().to_vec(), &[cloud.points.len(), 3])
}

/// Filters a cloud of points (N, 3), in metres, and returns the points that are left, (M, 3), as float32 in the planning frame, and a
/// dictionary of counts: "points", those dropped by each filter in turn, and "kept".
///
/// - "not_finite": a coordinate is NaN or infinite.
/// - "cropped": outside of the box `crop`, its least and greatest coordinates (2, 3).
/// - "own": within `own_margin_m` (m; None: 0) of `robot` at `q`, by the exact distance; both or neither must be given.
/// - "known": within `known_margin_m` (m; None: 0) of one of the bodies `known`.
/// - "thinned": not the first in its voxel, a cube of the side `voxel_m` (m). Add the diagonal of a voxel, √3 `voxel_m`, to the
///   radius of the points, so that their balls cover what is left out.
///
/// `pose`: `world_from_cloud`, (4, 4) or (3,).
#[pyfunction]
#[pyo3(signature = (points, *, pose=None, crop=None, robot=None, q=None, own_margin_m=None, known=None, known_margin_m=None,
    voxel_m=None))]
#[allow(clippy::too_many_arguments, reason = "the keywords of the Python function")]
pub fn filter_cloud<'py>(
    points: &Bound<'py, PyAny>,
    pose: Option<&Bound<'py, PyAny>>,
    crop: Option<&Bound<'py, PyAny>>,
    robot: Option<&Bound<'py, PyRobot>>,
    q: Option<&Bound<'py, PyAny>>,
    own_margin_m: Option<f64>,
    known: Option<Vec<Bound<'py, PyBody>>>,
    known_margin_m: Option<f64>,
    voxel_m: Option<f64>,
) -> PyResult<(Points<'py>, Bound<'py, PyDict>)> {
    let py = points.py();
    let read = points_of(points)?;
    let pose = pose.map(|pose| pose_or_translation(Some(pose), "pose")).transpose()?;
    let crop = crop.map(box_of).transpose()?;
    let own = match (robot, q, own_margin_m) {
        (Some(robot), Some(q), margin_m) => {
            let robot = &robot.get().robot;
            Some((robot_solids(robot, &configuration(q, "q", robot)?), margin_m.unwrap_or(0.0)))
        }
        (None, None, None) => None,
        (_, _, Some(_)) => return Err(bad_value("own_margin_m needs `robot` and its configuration `q`")),
        (Some(_), None, None) => return Err(bad_value("robot needs its configuration `q`")),
        (None, Some(_), None) => return Err(bad_value("q needs the `robot`")),
    };
    let known_margin_m = match (&known, known_margin_m) {
        (None, Some(_)) => return Err(bad_value("known_margin_m needs the bodies `known`")),
        (_, margin_m) => margin_m.unwrap_or(0.0),
    };
    let known: Vec<_> = known
        .iter()
        .flatten()
        .flat_map(|body| &body.get().body.parts)
        .map(|part| (part.world_from_solid, part.solid.clone()))
        .collect();
    let count = read.cloud.points.len();
    let filtered = py.detach(|| {
        let mut cloud = read.cloud;
        let mut counts = Vec::new();
        let mut left = count;
        let mut counted = |name: &'static str, cloud: &PointCloud| {
            counts.push((name, left - cloud.points.len()));
            left = cloud.points.len();
        };
        if let Some(world_from_cloud) = &pose {
            cloud = cloud.transformed(world_from_cloud);
        }
        if let Some(aabb) = &crop {
            cloud = cloud.cropped(aabb, &Pose::identity());
        }
        counted("cropped", &cloud);
        if let Some((solids, margin_m)) = &own {
            cloud = cloud.without_near(solids, *margin_m)?.cloud;
        }
        counted("own", &cloud);
        if !known.is_empty() {
            cloud = cloud.without_near(&known, known_margin_m)?.cloud;
        }
        counted("known", &cloud);
        if let Some(side_m) = voxel_m {
            cloud = cloud.thinned(side_m)?;
        }
        counted("thinned", &cloud);
        Ok::<_, cranny_sense::SenseError>((cloud, counts))
    });
    let (cloud, counts) = filtered.map_err(fault)?;
    let report = PyDict::new(py);
    report.set_item("points", count + read.dropped)?;
    report.set_item("not_finite", read.dropped)?;
    for (name, dropped) in counts {
        report.set_item(name, dropped)?;
    }
    report.set_item("kept", cloud.points.len())?;
    Ok((array(py, &cloud)?, report))
}

/// Reads a box by its least and greatest coordinates (2, 3), in metres.
pub fn box_of(value: &Bound<'_, PyAny>) -> PyResult<Aabb> {
    let numbers = Numbers::read(value, "box")?;
    let &[x, y, z, to_x, to_y, to_z] = numbers.finite()? else {
        return Err(numbers.wrong_shape("(2, 3), the least and the greatest coordinates,"));
    };
    if *numbers.shape() != [2, 3] {
        return Err(numbers.wrong_shape("(2, 3), the least and the greatest coordinates,"));
    }
    let (low, high) = (Point::new(x, y, z), Point::new(to_x, to_y, to_z));
    if !(0..3).all(|axis| low[axis] < high[axis]) {
        return Err(bad_value("box: the least coordinates must be less than the greatest"));
    }
    Ok(Aabb { center: low + (high - low) * 0.5, half_extents: (high - low) * 0.5 })
}

/// Returns the points (N, 3) of a message, and the number of those that were dropped. A field is its name, offset, type and count.
#[pyfunction]
#[pyo3(name = "_points_of_message")]
#[allow(clippy::too_many_arguments, reason = "the fields of the message")]
pub fn points_of_message<'py>(
    py: Python<'py>,
    height: usize,
    width: usize,
    fields: Vec<(String, usize, u8, usize)>,
    is_bigendian: bool,
    point_step: usize,
    row_step: usize,
    data: &[u8],
) -> PyResult<(Points<'py>, usize)> {
    let fields = fields
        .into_iter()
        .map(|(name, offset, datatype, count)| CloudField { name, offset, datatype, count })
        .collect();
    let message = CloudMessage { height, width, fields, is_bigendian, point_step, row_step, data };
    let read = py.detach(|| message.read()).map_err(bad_value)?;
    Ok((array(py, &read.cloud)?, read.dropped))
}
