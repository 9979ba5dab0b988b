//! Conversions of NumPy arrays, and of everything that NumPy converts to arrays, to rows of numbers.

use cranny_grasp::{pose_of_rows, rows_of_pose};
use cranny_robot::Robot;
use cranny_shape::TriangleSoup;
use cranny_spatial::{Point, Pose, Vector};
use numpy::{
    PyArray1, PyArrayDyn, PyArrayMethods as _, PyReadonlyArrayDyn, PyUntypedArray, PyUntypedArrayMethods as _,
};
use pyo3::prelude::*;

use crate::handover::fault::{bad_type, bad_value, fault};

/// Contiguous numbers, row by row, read from Python's memory without a copy. If another thread writes to them during a call,
/// results match neither the old nor the new values.
pub struct Numbers<'py> {
    array: PyReadonlyArrayDyn<'py, f64>,
    what: String,
}

impl<'py> Numbers<'py> {
    /// Reads `value`, which errors call `what`. Masked values become NaN: unknown, or not finite.
    pub fn read(value: &Bound<'py, PyAny>, what: &str) -> PyResult<Self> {
        let value = &unmasked(value)?;
        let array = match value.cast::<PyArrayDyn<f64>>() {
            Ok(array) if is_plain(array) => array.clone(),
            _ => converted(value, what)?,
        };
        let array = array
            .try_readonly()
            .map_err(|_| bad_value(format!("{what}: the array is being written to elsewhere")))?;
        Ok(Self { array, what: what.to_owned() })
    }

    pub fn shape(&self) -> &[usize] {
        self.array.shape()
    }

    pub fn values(&self) -> PyResult<&[f64]> {
        self.array.as_slice().map_err(|_| bad_value(format!("{}: the array is not contiguous", self.what)))
    }

    /// Returns the values if all are finite.
    pub fn finite(&self) -> PyResult<&[f64]> {
        let values = self.values()?;
        match values.iter().position(|value| !value.is_finite()) {
            None => Ok(values),
            Some(place) => {
                let mut rest = place;
                let mut index: Vec<usize> = Vec::new();
                for &side in self.shape().iter().rev() {
                    index.push(rest % side.max(1));
                    rest /= side.max(1);
                }
                index.reverse();
                let value = values[place];
                Err(bad_value(format!("{}: {value} at {index:?}, but every value must be finite", self.what)))
            }
        }
    }

    /// Returns an error that shows the shape found and the one expected.
    pub fn wrong_shape(&self, expected: &str) -> PyErr {
        let shape = tuple_text(self.shape());
        bad_value(format!("{} has shape {shape}, but {expected} is expected", self.what))
    }
}

/// Returns true if the array is contiguous and aligned.
fn is_plain(array: &Bound<'_, PyArrayDyn<f64>>) -> bool {
    array.is_c_contiguous() && (array.data() as usize).is_multiple_of(align_of::<f64>())
}

/// Replaces masked values by NaN, because NumPy's conversions drop the mask; other values are unchanged.
fn unmasked<'py>(value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let is_derived =
        value.is_instance_of::<PyUntypedArray>() && !value.is_exact_instance_of::<PyUntypedArray>();
    if !is_derived || !value.hasattr("filled")? {
        return Ok(value.clone());
    }
    let kind: String = value.getattr("dtype")?.getattr("kind")?.extract()?;
    if !matches!(kind.as_str(), "f" | "i" | "u") {
        return Ok(value.clone());
    }
    value.call_method1("astype", ("float64",))?.call_method1("filled", (f64::NAN,))
}

/// Converts with NumPy: numbers only, without loss of digits.
fn converted<'py>(value: &Bound<'py, PyAny>, what: &str) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let py = value.py();
    let numpy = py.import("numpy")?;
    let array = numpy.call_method1("asarray", (value,)).map_err(|reason| {
        let told = bad_type(format!("{what}: an array of numbers is expected ({reason})"));
        told.set_cause(py, Some(reason));
        told
    })?;
    let dtype = array.getattr("dtype")?;
    let kind: String = dtype.getattr("kind")?.extract()?;
    if !matches!(kind.as_str(), "f" | "i" | "u") {
        return Err(bad_type(format!("{what} has dtype {dtype}, but float64 is expected")));
    }
    let required = numpy.call_method1("require", (array, "float64", ["C", "A"]))?;
    Ok(required.cast_into::<PyArrayDyn<f64>>()?)
}

fn tuple_text(shape: &[usize]) -> String {
    match shape {
        [one] => format!("({one},)"),
        _ => format!("({})", shape.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")),
    }
}

/// One configuration or many (m, rad), finite, one value per joint.
pub struct Configurations<'py> {
    numbers: Numbers<'py>,
    pub is_single: bool,
    pub count: usize,
    pub dof: usize,
}

impl<'py> Configurations<'py> {
    pub fn read(value: &Bound<'py, PyAny>, what: &str, robot: &Robot) -> PyResult<Self> {
        let numbers = Numbers::read(&in_order_of(value, robot)?, what)?;
        let dof = robot.dof();
        let (is_single, count) = match *numbers.shape() {
            [values] if values == dof => (true, 1),
            [rows, values] if values == dof => (false, rows),
            _ => {
                let (name, joints) = (robot.name(), if dof == 1 { "joint" } else { "joints" });
                let expected = format!("({dof},) or (N, {dof}) for the {dof} {joints} of {name}");
                return Err(numbers.wrong_shape(&expected));
            }
        };
        numbers.finite()?;
        Ok(Self { numbers, is_single, count, dof })
    }

    pub fn values(&self) -> PyResult<&[f64]> {
        self.numbers.values()
    }

    /// Returns one row per configuration.
    pub fn rows(&self, dof: usize) -> PyResult<Vec<Vec<f64>>> {
        Ok(self.values()?.chunks_exact(dof.max(1)).map(<[f64]>::to_vec).collect())
    }
}

/// Reorders values with joint names (`cranny.ros.JointPositions`) to the robot's order; others are unchanged.
fn in_order_of<'py>(value: &Bound<'py, PyAny>, robot: &Robot) -> PyResult<Bound<'py, PyAny>> {
    match value.getattr_opt("in_order_of")? {
        Some(in_order_of) => in_order_of.call1((robot.joint_names().to_vec(),)),
        None => Ok(value.clone()),
    }
}

/// Reads a single configuration (m, rad); values with joint names may also be one row.
pub fn configuration(value: &Bound<'_, PyAny>, what: &str, robot: &Robot) -> PyResult<Vec<f64>> {
    let numbers = Numbers::read(&in_order_of(value, robot)?, what)?;
    let dof = robot.dof();
    let is_row = *numbers.shape() == [1, dof] && value.hasattr("in_order_of")?;
    if *numbers.shape() != [dof] && !is_row {
        return Err(numbers.wrong_shape(&format!("({dof},) for the {dof} joints of {}", robot.name())));
    }
    Ok(numbers.finite()?.to_vec())
}

/// Reads one pose or many, as (4, 4) or (N, 4, 4); the flag is true for a single pose.
pub fn poses(value: &Bound<'_, PyAny>, what: &str) -> PyResult<(bool, Vec<Pose>)> {
    let numbers = Numbers::read(value, what)?;
    let is_single = match *numbers.shape() {
        [4, 4] => true,
        [_, 4, 4] => false,
        _ => return Err(numbers.wrong_shape("(4, 4) or (N, 4, 4)")),
    };
    let poses = numbers.finite()?.as_chunks::<16>().0.iter().enumerate().map(|(index, rows)| {
        pose_of_rows(rows).map_err(|reason| {
            let place = if is_single { String::new() } else { format!("[{index}]") };
            fault(format!("{what}{place}: {reason}"))
        })
    });
    Ok((is_single, poses.collect::<PyResult<_>>()?))
}

/// Reads one pose: (4, 4), or (3,) for a translation in metres; the identity for `None`.
pub fn pose_or_translation(value: Option<&Bound<'_, PyAny>>, what: &str) -> PyResult<Pose> {
    let Some(value) = value else { return Ok(Pose::identity()) };
    let numbers = Numbers::read(value, what)?;
    match *numbers.shape() {
        [3] => Ok(Pose::from_parts(
            Vector::from_column_slice(numbers.finite()?).into(),
            cranny_spatial::Rotation::identity(),
        )),
        [4, 4] => poses(value, what)?.1.pop().ok_or_else(|| numbers.wrong_shape("(4, 4)")),
        _ => Err(numbers.wrong_shape("(4, 4), or (3,) for a translation,")),
    }
}

/// Copies the numbers into an array that no other code can write to.
pub fn copied<'py>(value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    value.py().import("numpy")?.call_method1("array", (value, "float64"))
}

/// Reads three lengths.
pub fn vector(value: &Bound<'_, PyAny>, what: &str) -> PyResult<Vector> {
    let numbers = Numbers::read(value, what)?;
    if *numbers.shape() != [3] {
        return Err(numbers.wrong_shape("(3,)"));
    }
    Ok(Vector::from_column_slice(numbers.finite()?))
}

/// Reads the triangles of a `trimesh.Trimesh`, of any object with `vertices` and `faces`, or of a pair of arrays (V, 3) in
/// metres and (F, 3) of indices.
pub fn triangles(mesh: &Bound<'_, PyAny>) -> PyResult<TriangleSoup> {
    let (vertices, faces) = match (mesh.getattr_opt("vertices")?, mesh.getattr_opt("faces")?) {
        (Some(vertices), Some(faces)) => (vertices, faces),
        _ => mesh.extract::<(Bound<'_, PyAny>, Bound<'_, PyAny>)>().map_err(|_| {
            bad_type(format!(
                "mesh: expected something with `vertices` and `faces`, or a pair of arrays (V, 3) and (F, 3), \
                 not {}",
                mesh.get_type()
            ))
        })?,
    };
    let vertices = Numbers::read(&vertices, "mesh.vertices")?;
    let [_, 3] = *vertices.shape() else { return Err(vertices.wrong_shape("(V, 3)")) };
    let corners = Numbers::read(&faces, "mesh.faces")?;
    let [_, 3] = *corners.shape() else { return Err(corners.wrong_shape("(F, 3)")) };
    let count = vertices.shape()[0];
    let mut soup = TriangleSoup { vertices: Vec::new(), triangles: Vec::new() };
    soup.vertices.extend(vertices.finite()?.as_chunks::<3>().0.iter().map(|v| Point::from(*v)));
    for triangle in corners.finite()?.as_chunks::<3>().0 {
        let mut indices = [0; 3];
        for (index, &corner) in indices.iter_mut().zip(triangle) {
            if corner.fract() != 0.0 || !(0.0..count as f64).contains(&corner) {
                return Err(bad_value(format!(
                    "mesh.faces: vertex index {corner} is out of range: the mesh has {count} vertices"
                )));
            }
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a whole number in the range of the vertices, of which there are fewer than 2³²"
            )]
            {
                *index = corner as u32;
            }
        }
        soup.triangles.push(indices);
    }
    Ok(soup)
}

/// Converts an index to NumPy's type; no collection is large enough to overflow it.
pub fn index(index: usize) -> i64 {
    i64::try_from(index).unwrap_or(i64::MAX)
}

/// Returns values in an array of this shape.
pub fn shaped<'py, T: numpy::Element>(
    py: Python<'py>,
    values: Vec<T>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    PyArray1::from_vec(py, values).reshape(shape.to_vec())
}

/// Returns matrices (N, 4, 4).
pub fn matrices(
    py: Python<'_>,
    poses: impl ExactSizeIterator<Item = Pose>,
) -> PyResult<Bound<'_, PyArrayDyn<f64>>> {
    let count = poses.len();
    shaped(py, poses.flat_map(|pose| rows_of_pose(&pose)).collect(), &[count, 4, 4])
}

/// Returns rows (N, dof).
pub fn rows<'py>(py: Python<'py>, rows: &[Vec<f64>], dof: usize) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    shaped(py, rows.concat(), &[rows.len(), dof])
}
