//! `Samples`: a trajectory sampled at equal intervals.

use cranny_path::{Trajectory, TrajectorySample};
use cranny_plan::PlanError;
use cranny_solve::TaskTrajectory;
use numpy::PyArrayDyn;
use pyo3::prelude::*;

use crate::handover::array::{Numbers, shaped};
use crate::handover::pickled::{Reduced, restored_by};

/// Trajectory at T instants: arrays (T, dof) in the order of `joint_names`.
#[pyclass(name = "Samples", module = "cranny", frozen)]
pub struct PySamples {
    joint_names: Vec<String>,
    times: Vec<f64>,
    positions: Vec<f64>,
    velocities: Vec<f64>,
    accelerations: Vec<f64>,
    /// Finger openings, in metres, if the fingers close on an object.
    openings: Option<Vec<f64>>,
}

impl PySamples {
    pub fn of(trajectory: &TaskTrajectory, rate_hz: f64) -> Result<Self, PlanError> {
        let mut samples = Self::collected(trajectory.joint_names(), trajectory.samples(rate_hz)?);
        let opening = |time_s: &f64| trajectory.opening_m(*time_s);
        samples.openings = samples.times.iter().map(opening).collect();
        Ok(samples)
    }

    /// Samples the motion to the grasp, and the one after it if any, each from time 0.
    pub fn of_ways(trajectory: &TaskTrajectory, rate_hz: f64) -> Result<Vec<Self>, PlanError> {
        let ways = trajectory.legs().iter();
        ways.map(|way: &Trajectory| Ok(Self::collected(way.joint_names(), way.samples(rate_hz)?))).collect()
    }

    fn collected(joint_names: &[String], all: impl Iterator<Item = TrajectorySample>) -> Self {
        let mut samples = Self {
            joint_names: joint_names.to_vec(),
            times: Vec::new(),
            positions: Vec::new(),
            velocities: Vec::new(),
            accelerations: Vec::new(),
            openings: None,
        };
        for sample in all {
            samples.times.push(sample.time_s);
            samples.positions.extend(sample.position);
            samples.velocities.extend(sample.velocity);
            samples.accelerations.extend(sample.acceleration);
        }
        samples
    }

    fn rows<'py>(&self, py: Python<'py>, values: &[f64]) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        shaped(py, values.to_vec(), &[self.times.len(), self.joint_names.len()])
    }
}

/// Restores pickled samples.
#[pyfunction]
#[pyo3(name = "_restored_samples")]
pub fn restored_samples(
    joint_names: Vec<String>,
    times: &Bound<'_, PyAny>,
    positions: &Bound<'_, PyAny>,
    velocities: &Bound<'_, PyAny>,
    accelerations: &Bound<'_, PyAny>,
    openings: Option<&Bound<'_, PyAny>>,
) -> PyResult<PySamples> {
    let times = Numbers::read(times, "times")?.values()?.to_vec();
    let read = |rows: &Bound<'_, PyAny>| {
        let rows = Numbers::read(rows, "rows")?;
        if *rows.shape() != [times.len(), joint_names.len()] {
            return Err(rows.wrong_shape("(T, dof)"));
        }
        rows.values().map(<[f64]>::to_vec)
    };
    let (positions, velocities) = (read(positions)?, read(velocities)?);
    let accelerations = read(accelerations)?;
    let openings = match openings.map(|openings| Numbers::read(openings, "openings")).transpose()? {
        Some(openings) if *openings.shape() != [times.len()] => return Err(openings.wrong_shape("(T,)")),
        Some(openings) => Some(openings.values()?.to_vec()),
        None => None,
    };
    Ok(PySamples { joint_names, times, positions, velocities, accelerations, openings })
}

#[pymethods]
impl PySamples {
    /// Names of the joints.
    #[getter]
    fn joint_names(&self) -> Vec<String> {
        self.joint_names.clone()
    }

    /// Times of the samples, (T,), in seconds from 0.
    #[getter]
    fn times<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        shaped(py, self.times.clone(), &[self.times.len()])
    }

    /// Joint values, (T, dof), in m or rad.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.rows(py, &self.positions)
    }

    /// Joint velocities, (T, dof), in m/s or rad/s.
    #[getter]
    fn velocities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.rows(py, &self.velocities)
    }

    /// Joint accelerations, (T, dof), in m/s² or rad/s²; at a discontinuity, the value right after it.
    #[getter]
    fn accelerations<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.rows(py, &self.accelerations)
    }

    /// Finger openings, (T,), in m; None if the fingers do not close on an object.
    #[getter]
    fn openings<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArrayDyn<f64>>>> {
        self.openings.as_ref().map(|openings| shaped(py, openings.clone(), &[self.times.len()])).transpose()
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        let (py, own) = (slf.py(), slf.get());
        let rows = (own.times(py)?, own.positions(py)?, own.velocities(py)?, own.accelerations(py)?);
        let openings = own.openings(py)?;
        restored_by(py, "_restored_samples", (own.joint_names(), rows.0, rows.1, rows.2, rows.3, openings))
    }

    fn __len__(&self) -> usize {
        self.times.len()
    }

    fn __repr__(&self) -> String {
        let last = self.times.last().copied().unwrap_or_default();
        format!("<cranny.Samples: {} instants in {last:.3} s>", self.times.len())
    }
}
