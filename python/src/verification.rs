//! `Verification`: the result of verifying a path.

use cranny_path::Audit;
use cranny_task::NotChecked;
use pyo3::prelude::*;

use crate::handover::json::python_of;
use crate::handover::pickled::{Made, Reduced};

/// Result of verifying a path. True if the path meets the criterion.
#[pyclass(name = "Verification", module = "cranny", frozen)]
pub struct PyVerification {
    pub audit: Audit,
}

#[pymethods]
impl PyVerification {
    /// True if there is no violation.
    #[getter]
    fn valid(&self) -> bool {
        self.audit.valid
    }

    /// Violations in the order of the path: dictionaries of `kind`, `edge`, `at` in [0, 1], `first`, `second`, `depth_m` (for a
    /// contact; else None), and further keys of the kind:
    ///
    /// - "start", "joint-limit": `off` and its `unit` ("m", "rad"); `first` is the joint.
    /// - "contact": none. "clearance": `clearance_m`, `required_m`. "unresolved": `clearance_m`. "step": `excess_m`.
    /// - "goal": `translation_error_m` and `rotation_error_rad` from the nearest grasp; or `off` and `unit`; or `clearance_m` and
    ///   `required_m` of an object that is carried out; or none.
    /// - "grip", of a hand that does not hold as it should or as stated: `score`, `required`, `opening_m`, `said_opening_m`,
    ///   `said_score`, or none.
    /// - "lift-off", "set-down": `length_m` and `most_m`, or none. "retreat": `clearance_m`, `required_m`. "not-straight": `length_m`,
    ///   `required_m`.
    /// - "tilt": `tilt_rad`, `most_rad`. "tool": `bound`, its name, and the excess `by_rad` or `by_m`.
    /// - "statement", of a plan's file that promises more than was measured: `key`, `stated` and `measured`, in words.
    #[getter]
    fn violations<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_of(py, &self.audit.violations)
    }

    /// Grasp nearest to the end: a dictionary of `grasp`, `translation_error_m` and `rotation_error_rad`; None if the goal is
    /// not a grasp.
    #[getter]
    fn goal<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_of(py, &self.audit.goal)
    }

    /// Grasp at the end of the path if no set of grasps is given, as `Plan.own_grasp`; None if there is none.
    #[getter]
    fn own_grasp<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_of(py, &self.audit.own_grasp)
    }

    /// Minimum distance along the whole path in metres, a certified lower bound; None under "paper", or without pairs to check.
    #[getter]
    fn clearance_m(&self) -> Option<f64> {
        self.audit.clearance_m
    }

    /// Pair that limits the clearance: a dictionary of `first`, `second`, `required_m` and the `margin` that applies to it
    /// ("margin", "grasp-margin"); None if `clearance_m` is None or 0.
    #[getter]
    fn clearance_limit<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_of(py, &self.audit.clearance_limit)
    }

    /// Pairs that are not compared: dictionaries of `first`, `second`, `depth_m` and `reason` ("always-touching",
    /// "adjacent-touching", "adjacent-at-joint", "adjacent-unproven", "adjacent-free", "never-moves"; "resting": contact of an
    /// object with its support, with `segment` and `allowance_m`). The verdict excludes them; "adjacent-free" pairs are proven
    /// never to touch, and only their distance is excluded from margins and clearances.
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
