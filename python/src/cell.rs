//! `Cell`: a robot in a world.

use std::sync::Arc;

use cranny_collision::{Cell, Contact, Margins, Motion, Scratch, World};
use cranny_scenario::RobotSource;
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict as _, PyBool, PyTuple};

use crate::body::named_twice;
use crate::classes::{PyBody, PyCell, PyRobot};
use crate::grasping::contact::{PyContact, PyMotion};
use crate::handover::array::{Configurations, shaped};
use crate::handover::fault::{bad_value, fault};
use crate::handover::pickled::{Made, Reduced, partial};
use crate::handover::rows::computed;
use crate::handover::whole;

/// Rows per block of SIMD work: some milliseconds.
const LANE_BLOCK: usize = 8192;

/// Rows per block of exact work: some milliseconds.
const EXACT_BLOCK: usize = 64;

#[pymethods]
impl PyCell {
    /// Creates a cell of `robot` in a world of `bodies`; all checks require the clearance `margin_m` (m) between any two.
    ///
    /// `scenario.cell()` returns the cell of a scenario, with its target.
    #[new]
    #[pyo3(signature = (robot, bodies, *, margin_m=0.0))]
    fn new(robot: &Bound<'_, PyRobot>, bodies: Vec<Py<PyBody>>, margin_m: f64) -> PyResult<Self> {
        let py = robot.py();
        let keywords = [("margin_m", margin_m)].into_py_dict(py)?;
        let constructor = partial(py.get_type::<Self>().as_any(), &keywords)?;
        let made = Made::by(constructor, (robot, PyTuple::new(py, &bodies)?))?;
        let bodies: Vec<_> = bodies.iter().map(|body| body.get().body.clone()).collect();
        if let Some(name) = named_twice(&bodies) {
            return Err(bad_value(format!("two bodies have the name '{name}', but names must be unique")));
        }
        let world = World::new(bodies).map_err(fault)?;
        let margins = Margins { margin_m, ..Margins::default() };
        let cell = Cell::new(robot.get().robot.clone(), world, margins).map_err(fault)?;
        Ok(Self { cell: Arc::new(cell), made })
    }

    /// Robot of the cell.
    #[getter]
    fn robot(slf: &Bound<'_, Self>) -> PyResult<PyRobot> {
        let made = Made::by_attribute(slf, "robot")?;
        Ok(PyRobot { robot: slf.get().cell.robot().clone(), source: RobotSource::Other, made })
    }

    /// All bodies, in the planning frame.
    #[getter]
    fn world(&self) -> Vec<PyBody> {
        self.cell.world().bodies().iter().map(PyBody::of_scene).collect()
    }

    /// Names of the link pairs that are checked against each other.
    #[getter]
    fn self_pairs(&self) -> Vec<(String, String)> {
        let name = |link: usize| self.cell.robot().links()[link].name.clone();
        self.cell.self_pairs().into_iter().map(|(a, b)| (name(a), name(b))).collect()
    }

    /// Returns True if `q` is within the joint limits and every pair keeps its clearance: a bool; for a batch, an array (N,).
    #[pyo3(signature = (q, *, threads=Some(1)), text_signature = "($self, q, *, threads=1)")]
    fn is_free<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = whole::threads)] threads: Option<usize>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (py, cell, dof) = (q.py(), &*self.cell, self.cell.robot().dof());
        let q = Configurations::read(q, "q", cell.robot())?;
        let values = q.values()?;
        if q.is_single {
            let is_free = py.detach(|| cell.is_free(values, &mut cell.scratch()));
            return Ok(PyBool::new(py, is_free).to_owned().into_any());
        }
        let room = || (cell.scratch(), Vec::new());
        let free =
            computed(py, (q.count, 1), LANE_BLOCK, threads, room, |(scratch, verdicts), range, out| {
                cell.are_free(&values[range.start * dof..range.end * dof], scratch, verdicts);
                out.copy_from_slice(verdicts);
            })?;
        Ok(shaped(py, free, &[q.count])?.into_any())
    }

    /// Returns the minimum distance over all pairs at `q` in metres, a certified lower bound: a float; for a batch, an array
    /// (N,). 0 in contact, infinite without any pair. Joint limits are not checked.
    #[pyo3(signature = (q, *, threads=Some(1)), text_signature = "($self, q, *, threads=1)")]
    fn clearance<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = whole::threads)] threads: Option<usize>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (py, cell) = (q.py(), &*self.cell);
        let q = Configurations::read(q, "q", cell.robot())?;
        let work = |scratch: &mut Scratch, q: &[f64], out: &mut [f64]| out[0] = cell.clearance(q, scratch);
        let least = q.computed(py, 1, EXACT_BLOCK, threads, || cell.scratch(), work)?;
        scalar_or_array(py, q.is_single, least)
    }

    /// Returns the first pair at `q` that violates its clearance, in a fixed order, hand and wrist before the base, or None.
    /// For a batch, a list of N of them. Joint limits are not checked.
    #[pyo3(signature = (q, *, threads=Some(1)), text_signature = "($self, q, *, threads=1)")]
    fn first_contact<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = whole::threads)] threads: Option<usize>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (py, cell) = (q.py(), &*self.cell);
        let q = Configurations::read(q, "q", cell.robot())?;
        let work = |scratch: &mut Scratch, q: &[f64], out: &mut [Option<Contact>]| {
            out[0] = cell.first_contact(q, scratch);
        };
        let found = q.computed(py, 1, EXACT_BLOCK, threads, || cell.scratch(), work)?;
        let told: Vec<_> =
            found.iter().map(|found| found.as_ref().map(|contact| PyContact::of(cell, contact))).collect();
        single_or_list(py, q.is_single, told)
    }

    /// Returns every pair that violates its clearance at `q`, (dof,), once each.
    fn contacts(&self, q: &Bound<'_, PyAny>) -> PyResult<Vec<PyContact>> {
        let q = crate::handover::array::configuration(q, "q", self.cell.robot())?;
        let contacts = self.cell.contacts(&q, &mut self.cell.scratch());
        Ok(contacts.iter().map(|contact| PyContact::of(&self.cell, contact)).collect())
    }

    /// Returns True if the whole straight motion from `a` to `b` is proven free: a bool. For batches, (N, dof) both or one of
    /// them (dof,), an array (N,) of bools.
    #[pyo3(signature = (a, b, *, threads=Some(1)), text_signature = "($self, a, b, *, threads=1)")]
    fn motion_is_free<'py>(
        &self,
        a: &Bound<'py, PyAny>,
        b: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = whole::threads)] threads: Option<usize>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (is_single, motions) = self.motions(a, b, threads)?;
        let proven: Vec<bool> = motions.iter().map(Motion::is_proven).collect();
        match (is_single, &proven[..]) {
            (true, [only]) => Ok(PyBool::new(a.py(), *only).to_owned().into_any()),
            _ => Ok(shaped(a.py(), proven.clone(), &[proven.len()])?.into_any()),
        }
    }

    /// Checks the straight motion from `a` to `b` and returns a Motion, with the obstruction to the proof and its position; for
    /// batches, a list of N of them.
    #[pyo3(signature = (a, b, *, threads=Some(1)), text_signature = "($self, a, b, *, threads=1)")]
    fn motion<'py>(
        &self,
        a: &Bound<'py, PyAny>,
        b: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = whole::threads)] threads: Option<usize>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = a.py();
        let (is_single, motions) = self.motions(a, b, threads)?;
        let told: Vec<_> =
            motions.iter().map(|motion| PyMotion::of(py, &self.cell, motion)).collect::<PyResult<_>>()?;
        single_or_list(py, is_single, told)
    }

    /// Returns the minimum distance over all pairs along the straight motion from `a` to `b`, (dof,) each, in metres: a
    /// certified lower bound, at most 10 µm too low; 0 if there is contact. Joint limits are not checked.
    fn least_clearance(&self, py: Python<'_>, a: &Bound<'_, PyAny>, b: &Bound<'_, PyAny>) -> PyResult<f64> {
        let a = crate::handover::array::configuration(a, "a", self.cell.robot())?;
        let b = crate::handover::array::configuration(b, "b", self.cell.robot())?;
        Ok(py.detach(|| self.cell.least_clearance(&a, &b, &mut self.cell.scratch())))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        slf.get().made.reduced(slf, "make it again")
    }

    fn __repr__(&self) -> String {
        let (robot, bodies) = (self.cell.robot().name(), self.cell.world().bodies().len());
        format!("<cranny.Cell: {robot} among {bodies} bodies>")
    }
}

impl PyCell {
    fn motions(
        &self,
        a: &Bound<'_, PyAny>,
        b: &Bound<'_, PyAny>,
        threads: Option<usize>,
    ) -> PyResult<(bool, Vec<Motion>)> {
        let (py, cell, dof) = (a.py(), &*self.cell, self.cell.robot().dof());
        let a = Configurations::read(a, "a", cell.robot())?;
        let b = Configurations::read(b, "b", cell.robot())?;
        let count = match (a.is_single, b.is_single) {
            (true, _) => b.count,
            (_, true) => a.count,
            _ if a.count == b.count => a.count,
            _ => {
                return Err(bad_value(format!(
                    "a has shape ({}, {dof}) and b has shape ({}, {dof}), but the same number of rows is \
                     expected",
                    a.count, b.count
                )));
            }
        };
        let (from, to) = (a.values()?, b.values()?);
        let (a_step, b_step) = (usize::from(!a.is_single) * dof, usize::from(!b.is_single) * dof);
        let motions = computed(
            py,
            (count, 1),
            EXACT_BLOCK,
            threads,
            || cell.scratch(),
            |scratch, range, out: &mut [Option<Motion>]| {
                for (index, out) in range.zip(out) {
                    let (a, b) = (&from[index * a_step..][..dof], &to[index * b_step..][..dof]);
                    *out = Some(cell.motion_is_free(a, b, scratch));
                }
            },
        )?;
        Ok((a.is_single && b.is_single, motions.into_iter().flatten().collect()))
    }
}

fn scalar_or_array(py: Python<'_>, is_single: bool, values: Vec<f64>) -> PyResult<Bound<'_, PyAny>> {
    if let (true, [only]) = (is_single, &values[..]) {
        return only.into_bound_py_any(py);
    }
    let count = values.len();
    Ok(shaped(py, values, &[count])?.into_any())
}

fn single_or_list<'py, T>(py: Python<'py>, is_single: bool, mut told: Vec<T>) -> PyResult<Bound<'py, PyAny>>
where
    T: IntoPyObjectExt<'py>,
    Vec<T>: IntoPyObjectExt<'py>,
{
    match (is_single, told.pop()) {
        (true, Some(only)) => only.into_bound_py_any(py),
        (_, last) => {
            told.extend(last);
            told.into_bound_py_any(py)
        }
    }
}
