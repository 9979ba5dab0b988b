//! `Contact` and `Motion`: detailed results of a cell's checks.

use cranny_collision::{Cell, Contact, Motion};
use numpy::PyArrayDyn;
use pyo3::prelude::*;

use crate::handover::array::shaped;
use crate::handover::fault::bad_value;
use crate::handover::pickled::{Reduced, restored_by};

/// Pair of bodies or links that violates its required clearance.
#[pyclass(name = "Contact", module = "cranny", frozen)]
pub struct PyContact {
    /// Name of the link.
    #[pyo3(get)]
    first: String,
    /// Name of another link, or of a body.
    #[pyo3(get)]
    second: String,
    /// Distance of the pair in metres; 0 if they overlap.
    #[pyo3(get)]
    clearance_m: f64,
    /// Required clearance in metres.
    #[pyo3(get)]
    required_m: f64,
    /// Penetration depth in metres; 0 if they are only too close.
    #[pyo3(get)]
    depth_m: f64,
    point: Option<[f64; 3]>,
}

impl PyContact {
    pub fn of(cell: &Cell, contact: &Contact) -> Self {
        let [first, second] = contact.names(cell);
        let Contact { clearance_m, required_m, depth_m, .. } = *contact;
        let point = contact.point.map(|point| point.coords.into());
        Self { first, second, clearance_m, required_m, depth_m, point }
    }
}

#[pymethods]
impl PyContact {
    /// Point in the overlap, (3,) in the planning frame, in metres; None if they are only too close.
    #[getter]
    fn point<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArrayDyn<f64>>>> {
        self.point.map(|point| shaped(py, point.to_vec(), &[3])).transpose()
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        let (py, own) = (slf.py(), slf.get());
        let lengths = (own.clearance_m, own.required_m, own.depth_m);
        restored_by(py, "_restored_contact", (&own.first, &own.second, lengths, own.point))
    }

    fn __repr__(&self) -> String {
        let Self { first, second, depth_m, clearance_m, .. } = self;
        if *depth_m > 0.0 {
            format!("<cranny.Contact: {first} is {:.2} mm deep in {second}>", depth_m * 1000.0)
        } else {
            format!("<cranny.Contact: {first} is {:.2} mm from {second}>", clearance_m * 1000.0)
        }
    }
}

/// Restores a pickled contact.
#[pyfunction]
#[pyo3(name = "_restored_contact")]
pub fn restored_contact(
    first: String,
    second: String,
    lengths: (f64, f64, f64),
    point: Option<[f64; 3]>,
) -> PyContact {
    let (clearance_m, required_m, depth_m) = lengths;
    PyContact { first, second, clearance_m, required_m, depth_m, point }
}

/// Result of the check of a straight motion between two configurations. True only if all of it is proven free.
#[pyclass(name = "Motion", module = "cranny", frozen)]
pub struct PyMotion {
    /// "proven", "contact", "unresolved" (neither contact nor proof: a pair comes within 1 µm of the required clearance),
    /// "out-of-bounds" (a bound of the tool is not proven) or "out-of-limits".
    #[pyo3(get)]
    kind: &'static str,
    /// Position along the motion, in [0, 1], at which it is not free; None if it is free, or if an end is out of limits.
    #[pyo3(get)]
    at: Option<f64>,
    /// Pair that touches or is undecided there.
    #[pyo3(get)]
    contact: Option<Py<PyContact>>,
    /// Joint that is out of its limits.
    #[pyo3(get)]
    joint: Option<String>,
    /// Name of the tool bound that is not proven.
    #[pyo3(get)]
    bound: Option<String>,
}

impl PyMotion {
    pub fn of(py: Python<'_>, cell: &Cell, motion: &Motion) -> PyResult<Self> {
        let with = |kind, at: f64, contact: &Contact| -> PyResult<Self> {
            let contact = Some(Py::new(py, PyContact::of(cell, contact))?);
            Ok(Self { kind, at: Some(at), contact, joint: None, bound: None })
        };
        match motion {
            Motion::Proven => Ok(Self { kind: "proven", at: None, contact: None, joint: None, bound: None }),
            Motion::Contact { at, contact } => with("contact", *at, contact),
            Motion::Unresolved { at, contact } => with("unresolved", *at, contact),
            Motion::OutOfBounds { at, bound, .. } => {
                let bound = cell.tool_bounds().nth(*bound).map(|bound| bound.name.clone());
                Ok(Self { kind: "out-of-bounds", at: Some(*at), contact: None, joint: None, bound })
            }
            Motion::OutOfLimits { joint } => {
                let joint = Some(cell.robot().joint_names()[*joint].clone());
                Ok(Self { kind: "out-of-limits", at: None, contact: None, joint, bound: None })
            }
        }
    }
}

#[pymethods]
impl PyMotion {
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        let (py, own) = (slf.py(), slf.get());
        let contact = own.contact.as_ref().map(|contact| contact.bind(py));
        restored_by(py, "_restored_motion", (own.kind, own.at, contact, &own.joint, &own.bound))
    }

    fn __bool__(&self) -> bool {
        self.kind == "proven"
    }

    fn __repr__(&self) -> String {
        match self.at {
            Some(at) => format!("<cranny.Motion: {} at {at:.3}>", self.kind),
            None => format!("<cranny.Motion: {}>", self.kind),
        }
    }
}

/// Restores a pickled motion.
#[pyfunction]
#[pyo3(name = "_restored_motion")]
pub fn restored_motion(
    kind: &str,
    at: Option<f64>,
    contact: Option<Py<PyContact>>,
    joint: Option<String>,
    bound: Option<String>,
) -> PyResult<PyMotion> {
    let kind = ["proven", "contact", "unresolved", "out-of-bounds", "out-of-limits"]
        .into_iter()
        .find(|known| *known == kind);
    let kind = kind.ok_or_else(|| bad_value("unknown kind of motion"))?;
    Ok(PyMotion { kind, at, contact, joint, bound })
}
