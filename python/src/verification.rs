//! `Verification`: what a judge found in a path.

use cranny_plan::Audit;
use pyo3::prelude::*;

use crate::json::python_of;
use crate::pickled::{Made, Reduced};

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

    /// Pairs that are not compared: dictionaries of `first`, `second`, `depth_m` and `reason` ("always-touching",
    /// "adjacent-touching", "adjacent-at-joint", "adjacent-unproven", "adjacent-free", "never-moves"). The verdict holds but
    /// for these; those that are "adjacent-free" are proven never to touch, and only their distance counts for no margin and no clearance.
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
        let unchecked = self.audit.not_checked.iter().filter(|pair| pair.is_exception()).count();
        if *valid && unchecked > 0 {
            format!("<cranny.Verification: valid, but for {unchecked} pairs that are not checked>")
        } else if *valid {
            "<cranny.Verification: valid>".to_owned()
        } else {
            format!("<cranny.Verification: not valid, {} violations>", violations.len())
        }
    }
}
