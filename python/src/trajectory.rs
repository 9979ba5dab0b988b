//! `Samples`: a trajectory at even instants.

use cranny_plan::{PlanError, Trajectory};
use numpy::PyArrayDyn;
use pyo3::prelude::*;

use crate::array::shaped;

/// A trajectory at T instants: arrays (T, dof) in the order of `joint_names`.
#[pyclass(name = "Samples", module = "cranny", frozen)]
pub struct PySamples {
    joint_names: Vec<String>,
    times: Vec<f64>,
    positions: Vec<f64>,
    velocities: Vec<f64>,
    accelerations: Vec<f64>,
}

impl PySamples {
    pub fn of(trajectory: &Trajectory, rate_hz: f64) -> Result<Self, PlanError> {
        let mut samples = Self {
            joint_names: trajectory.joint_names().to_vec(),
            times: Vec::new(),
            positions: Vec::new(),
            velocities: Vec::new(),
            accelerations: Vec::new(),
        };
        for sample in trajectory.samples(rate_hz)? {
            samples.times.push(sample.time_s);
            samples.positions.extend(sample.position);
            samples.velocities.extend(sample.velocity);
            samples.accelerations.extend(sample.acceleration);
        }
        Ok(samples)
    }

    fn rows<'py>(&self, py: Python<'py>, values: &[f64]) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        shaped(py, values.to_vec(), &[self.times.len(), self.joint_names.len()])
    }
}

#[pymethods]
impl PySamples {
    /// Names of the joints.
    #[getter]
    fn joint_names(&self) -> Vec<String> {
        self.joint_names.clone()
    }

    /// The instants, (T,), in seconds from 0.
    #[getter]
    fn times<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        shaped(py, self.times.clone(), &[self.times.len()])
    }

    /// Joint values, (T, dof), in m or rad.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.rows(py, &self.positions)
    }

    /// Their speeds, (T, dof), in m/s or rad/s.
    #[getter]
    fn velocities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.rows(py, &self.velocities)
    }

    /// Their accelerations, (T, dof), in m/s² or rad/s²; where one jumps, the value right after.
    #[getter]
    fn accelerations<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.rows(py, &self.accelerations)
    }

    fn __len__(&self) -> usize {
        self.times.len()
    }

    fn __repr__(&self) -> String {
        let last = self.times.last().copied().unwrap_or_default();
        format!("<cranny.Samples: {} instants in {last:.3} s>", self.times.len())
    }
}
