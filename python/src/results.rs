//! `ResultsFile`: the results of campaigns, as columns.

use std::path::PathBuf;
use std::sync::Mutex;

use cranny_bench::report::{Enclosure, Summary};
use cranny_bench::{BenchError, Results, StoredTrial};
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::handover::array::rows;
use crate::handover::fault::{bad_value, fault};
use crate::handover::json::python_of;
use crate::handover::pickled::{Made, Reduced};
use crate::handover::whole;

/// Results of campaigns: one SQLite file, open until `close`. `bench.Results` reads from it.
#[pyclass(name = "ResultsFile", module = "cranny", frozen)]
pub struct PyResultsFile {
    results: Mutex<Option<Results>>,
    path: PathBuf,
}

#[pymethods]
impl PyResultsFile {
    #[new]
    fn new(path: PathBuf) -> PyResult<Self> {
        let results = Results::open(&path).map_err(fault)?;
        Ok(Self { results: Mutex::new(Some(results)), path })
    }

    /// Path of the file.
    #[getter]
    fn path(&self) -> PathBuf {
        self.path.clone()
    }

    /// Closes the file; later calls raise ValueError.
    fn close(&self) -> PyResult<()> {
        *self.results.lock().map_err(fault)? = None;
        Ok(())
    }

    /// Returns all trials, in the order in which they ended: a dictionary of columns, lists of one value per trial.
    fn trials<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let trials = self.ask(py, Results::trials)?;
        let columns = PyDict::new(py);
        macro_rules! column {
            ($name:literal, $value:expr) => {{
                let value = $value;
                columns.set_item($name, trials.iter().map(|t: &StoredTrial| value(t)).collect::<Vec<_>>())?;
            }};
        }
        column!("id", |t: &StoredTrial| t.id);
        column!("run", |t: &StoredTrial| t.run);
        column!("scenario", |t: &StoredTrial| t.record.trial.scenario.clone());
        column!("planner", |t: &StoredTrial| t.record.trial.planner.clone());
        column!("settings", |t: &StoredTrial| t.record.trial.settings.clone());
        column!("criterion", |t: &StoredTrial| t.record.trial.criterion.name());
        column!("seed", |t: &StoredTrial| t.record.trial.seed);
        column!("time_limit_s", |t: &StoredTrial| t.record.trial.time_limit_s);
        column!("iteration_limit", |t: &StoredTrial| t.record.trial.iteration_limit);
        column!("goal", |t: &StoredTrial| t.record.trial.goal);
        column!("outcome", |t: &StoredTrial| t.record.outcome.name());
        column!("solved", |t: &StoredTrial| t.record.is_solved());
        column!("detail", |t: &StoredTrial| t.record.detail.clone());
        column!("planning_time_s", |t: &StoredTrial| t.record.statistics.planning_time_s);
        column!("ik_time_s", |t: &StoredTrial| t.record.statistics.ik_time_s);
        column!("collision_time_s", |t: &StoredTrial| t.record.statistics.collision_time_s);
        column!("iterations", |t: &StoredTrial| t.record.statistics.iterations);
        column!("nodes", |t: &StoredTrial| t.record.statistics.nodes);
        column!("collision_checks", |t: &StoredTrial| t.record.statistics.collision_checks);
        column!("path_length", |t: &StoredTrial| t.record.path_length);
        column!("clearance_m", |t: &StoredTrial| t.record.clearance_m);
        column!("memory_bytes", |t: &StoredTrial| t.record.memory_bytes);
        column!("grasp", |t: &StoredTrial| t.record.grasp);
        column!("grasp_score", |t: &StoredTrial| t.record.grasp_score);
        column!("also_solved", |t: &StoredTrial| t.record.also_solved);
        Ok(columns)
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        Made::UNKNOWN.reduced(slf, "it is an open file; pickle its path, and load it again")
    }

    /// Returns the path that the planner of trial `id` found, (N, dof); (0, 0) without a path.
    fn path_of<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = whole::id)] id: u64,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let path = self.ask(py, |results| results.path_of(id))?;
        rows(py, &path, path.first().map_or(0, Vec::len))
    }

    /// Returns all figures of a report, as a dictionary: `rows`, `curves`, `comparisons`, …
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_of(py, &self.ask(py, Summary::of_results)?)
    }

    /// Returns the report as one page that opens without a network.
    fn html(&self, py: Python<'_>) -> PyResult<String> {
        let summary = self.ask(py, Summary::of_results)?;
        Ok(py.detach(|| summary.html(&Enclosure::default())))
    }
}

impl PyResultsFile {
    fn ask<T: Send>(
        &self,
        py: Python<'_>,
        question: impl FnOnce(&Results) -> Result<T, BenchError> + Send,
    ) -> PyResult<T> {
        py.detach(move || match self.results.lock().map_err(fault)?.as_ref() {
            Some(results) => question(results).map_err(fault),
            None => Err(bad_value(format!("the results in {} are closed", self.path.display()))),
        })
    }
}
