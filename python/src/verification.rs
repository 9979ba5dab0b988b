//! `Verification`: what a judge found in a path.

use cranny_path::Audit;
use cranny_task::NotChecked;
use pyo3::prelude::*;

use crate::handover::json::python_of;
use crate::handover::pickled::{Made, Reduced};

/// What a judge found in a path. True if the path meets the criterion.
#[pyclass(name = "Verification", module = "cranny", frozen)]
pub struct PyVerification {
    pub audit: Audit,
}

#[pymethods]
impl PyVerification {
    /// Whether there is no violation at all.
    #[getter]
    fn valid(&self) -> bool {
        self.audit.valid
    }

    /// Everything that is wrong, in the order of the path: dictionaries of `kind` ("start", "goal", "joint-limit",
    /// "contact", "clearance", "unresolved", "step"), `edge`, `at` in [0, 1], `first`, `second`, `depth_m` (of a contact;
    /// else None), and what the kind has besides: `off` and its `unit` ("m", "rad"), `clearance_m`, `required_m`,
    /// `excess_m`, `translation_error_m`, `rotation_error_rad`.
    #[getter]
    fn violations<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_of(py, &self.audit.violations)
    }

    /// The grasp nearest to the end: a dictionary of `grasp`, `translation_error_m` and `rotation_error_rad`; None
    /// where no grasp is asked for.
    #[getter]
    fn goal<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_of(py, &self.audit.goal)
    }

    /// The grasp that the path ends at, where no set of grasps is given, as `Plan.own_grasp`; None where it is none.
    #[getter]
    fn own_grasp<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_of(py, &self.audit.own_grasp)
    }

    /// The least distance along the whole path in metres, certified from below; None under "paper", or where there
    /// is nothing to touch.
    #[getter]
    fn clearance_m(&self) -> Option<f64> {
        self.audit.clearance_m
    }

    /// The two things that limit it: a dictionary of `first`, `second`, `required_m` and the `margin` that applies to them
    /// ("margin", "grasp-margin"); None where `clearance_m` is None or 0.
    #[getter]
    fn clearance_limit<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_of(py, &self.audit.clearance_limit)
    }

    /// Pairs that are not compared: dictionaries of `first`, `second`, `depth_m` and `reason` ("always-touching",
    /// "adjacent-touching", "adjacent-at-joint", "adjacent-unproven", "adjacent-free", "never-moves"; "resting": contact of an
    /// object with what carries it, with `segment` and `allowance_m`). The verdict holds but for these; those that are
    /// "adjacent-free" are proven never to touch, and only their distance counts for no margin and no clearance.
    #[getter]
    fn not_checked<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_of(py, &self.audit.not_checked)
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        Made::UNKNOWN.reduced(slf, "pickle its violations, goal and clearance_m, which are plain values")
    }

    fn __bool__(&self) -> bool {
        self.audit.valid
    }

    fn __repr__(&self) -> String {
        let Audit { valid, violations, .. } = &self.audit;
        match NotChecked::summary(&self.audit.not_checked).filter(|_| *valid) {
            Some(summary) => format!("<cranny.Verification: valid, but for {summary}>"),
            None if *valid => "<cranny.Verification: valid>".to_owned(),
            None => format!("<cranny.Verification: not valid, {} violations>", violations.len()),
        }
    }
}
