//! `Grasps`: a set of grasps as arrays.

use std::path::PathBuf;

use cranny_grasp::{
    COVERAGE_THRESHOLD, Grasp, GraspError, GraspSet, RobustScore, coverage, csv_text, read_csv,
};
use cranny_scenario::write_whole_file;
use cranny_spatial::nalgebra::Quaternion;
use cranny_spatial::{Pose, Rotation, Vector};
use numpy::PyArrayDyn;
use pyo3::prelude::*;

use crate::handover::array::{self, Numbers, matrices, shaped};
use crate::handover::fault::{bad_value, fault};
use crate::handover::pickled::{Reduced, restored_by};

/// Set of N grasps of an object: poses of the gripper frame, scores and widths. Immutable.
///
/// The gripper frame has its origin between the finger pads, y along the axis on which the fingers close, z out of the palm; two
/// equal pads turned by 180° about z are the same grasp. Poses are in the planning frame, those of `sample_grasps` in the frame of
/// the mesh.
#[pyclass(name = "Grasps", module = "cranny", frozen)]
pub struct PyGrasps {
    pub set: GraspSet,
}

#[pymethods]
impl PyGrasps {
    /// Creates grasps at `poses` (N, 4, 4). `scores` (N,) in [0, 1] and `widths` (N,) in metres; NaN, or None for all: unknown.
    /// `robust_scores` (N,) in [0, 1] are the fractions of `robust_trials` (N,) in which a grasp held the object in physics
    /// with small errors (`simulate_grasps`); both or neither must be known for a grasp. `loads` (N,) are factors by which
    /// gravity may grow before a pad slips.
    #[new]
    #[pyo3(signature = (poses, scores=None, *, widths=None, robust_scores=None, robust_trials=None, loads=None))]
    fn new(
        poses: &Bound<'_, PyAny>,
        scores: Option<&Bound<'_, PyAny>>,
        widths: Option<&Bound<'_, PyAny>>,
        robust_scores: Option<&Bound<'_, PyAny>>,
        robust_trials: Option<&Bound<'_, PyAny>>,
        loads: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let (_, poses) = array::poses(poses, "poses")?;
        let scores = known(scores, "scores", poses.len())?;
        let widths = known(widths, "widths", poses.len())?;
        let robust_scores = known(robust_scores, "robust_scores", poses.len())?;
        let robust_trials = known(robust_trials, "robust_trials", poses.len())?;
        let loads = known(loads, "loads", poses.len())?;
        let mut grasps = Vec::new();
        for (index, world_from_gripper) in poses.into_iter().enumerate() {
            let robust = robust(index, robust_scores[index], robust_trials[index])?;
            let (score, width_m, load) = (scores[index], widths[index], loads[index]);
            grasps.push(Grasp { world_from_gripper, score, width_m, robust, load, has_no_twin: false });
        }
        Ok(Self { set: GraspSet::new(grasps).map_err(fault)? })
    }

    /// Reads a `grasps.csv`, by line: 16 numbers of the pose row by row, score, width, robust score, robust trials and load.
    #[staticmethod]
    fn load(path: PathBuf) -> PyResult<Self> {
        Ok(Self { set: read_csv(&path).map_err(fault)? })
    }

    /// Writes a `grasps.csv` atomically.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        write_whole_file(&path, csv_text(&self.set).as_bytes()).map_err(fault)
    }

    /// Poses of the gripper frame, (N, 4, 4), in metres.
    #[getter]
    fn poses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        matrices(py, self.set.grasps().iter().map(|grasp| grasp.world_from_gripper))
    }

    /// Score of each grasp, (N,), in [0, 1]; NaN if unknown.
    #[getter]
    fn scores<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.each(py, |grasp| grasp.score)
    }

    /// Width of the object between the fingers, (N,), in metres; NaN if unknown.
    #[getter]
    fn widths<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.each(py, |grasp| grasp.width_m)
    }

    /// Fraction of its trials in which each grasp held the object in physics, (N,), in [0, 1]; NaN if untested.
    #[getter]
    fn robust_scores<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.each(py, |grasp| grasp.robust.map(|robust| robust.score()))
    }

    /// Number of trials of each robust score, (N,); NaN if untested.
    #[getter]
    fn robust_trials<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.each(py, |grasp| grasp.robust.map(|robust| robust.trials as f64))
    }

    /// Factor by which gravity may grow before a pad slips, (N,); NaN if not computed.
    #[getter]
    fn loads<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.each(py, |grasp| grasp.load)
    }

    /// Returns the indices (N,) in the order of decreasing score; unscored grasps come last.
    fn by_score<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<i64>>> {
        shaped(py, self.set.by_score().into_iter().map(array::index).collect(), &[self.set.len()])
    }

    /// Returns the nearest grasp to a gripper at `pose` (4, 4): its index, and the distance in metres and radians.
    fn nearest(&self, pose: &Bound<'_, PyAny>) -> PyResult<Option<(usize, f64, f64)>> {
        let (true, poses) = array::poses(pose, "pose")? else {
            return Err(bad_value("pose is a batch, but one pose of shape (4, 4) is expected"));
        };
        let nearest = poses.first().and_then(|pose| self.set.nearest(pose));
        Ok(nearest.map(|(index, difference)| (index, difference.translation_m, difference.rotation_rad)))
    }

    /// Returns the fraction of these grasps, in [0, 1], within `threshold` (millimetres plus degrees) of a grasp of `other`.
    #[pyo3(
        signature = (other, *, threshold=COVERAGE_THRESHOLD),
        text_signature = "($self, other, *, threshold=15.0)"
    )]
    fn covered_by(&self, py: Python<'_>, other: &Self, threshold: f64) -> PyResult<f64> {
        if threshold.is_nan() || threshold < 0.0 {
            return Err(bad_value(format!("threshold is {threshold}, but a number from 0 on is expected")));
        }
        Ok(py.detach(|| coverage(self.set.grasps(), other.set.grasps(), threshold)))
    }

    fn __len__(&self) -> usize {
        self.set.len()
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        let (py, set) = (slf.py(), &slf.get().set);
        // Quaternions, because a conversion from matrices would change the last digits of the rotations.
        let numbers = set.grasps().iter().flat_map(|grasp| {
            let Pose { translation, rotation } = &grasp.world_from_gripper;
            let unknown = |value: Option<f64>| value.unwrap_or(f64::NAN);
            let robust = grasp.robust.map(|robust| (robust.score(), robust.trials as f64)).unzip();
            let known = [grasp.score, grasp.width_m, robust.0, robust.1, grasp.load].map(unknown);
            translation.vector.iter().chain(rotation.coords.iter()).copied().chain(known).collect::<Vec<_>>()
        });
        let rows = shaped(py, numbers.collect(), &[set.len(), ROW])?;
        restored_by(py, "_restored_grasps", (rows,))
    }

    fn __repr__(&self) -> String {
        format!("<cranny.Grasps: {}>", self.set.len())
    }
}

/// Numbers of a grasp in a pickle: translation, rotation (x, y, z, w), score, width, robust score and its trials, load.
const ROW: usize = 12;

/// Restores pickled grasps.
#[pyfunction]
#[pyo3(name = "_restored_grasps")]
pub fn restored_grasps(rows: &Bound<'_, PyAny>) -> PyResult<PyGrasps> {
    let numbers = Numbers::read(rows, "rows")?;
    let [_, ROW] = *numbers.shape() else { return Err(numbers.wrong_shape("(N, 12)")) };
    let mut grasps = Vec::new();
    for (index, row) in numbers.values()?.as_chunks::<ROW>().0.iter().enumerate() {
        let &[x, y, z, i, j, k, w, ref figures @ ..] = row;
        let rotation = Rotation::new_unchecked(Quaternion::new(w, i, j, k));
        let [score, width_m, robust_score, robust_trials, load] = figures.map(known_number);
        grasps.push(Grasp {
            world_from_gripper: Pose::from_parts(Vector::new(x, y, z).into(), rotation),
            score,
            width_m,
            robust: robust(index, robust_score, robust_trials)?,
            load,
            has_no_twin: false,
        });
    }
    Ok(PyGrasps { set: GraspSet::new(grasps).map_err(fault)? })
}

impl PyGrasps {
    fn each<'py>(
        &self,
        py: Python<'py>,
        value: impl Fn(&Grasp) -> Option<f64>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let values = self.set.grasps().iter().map(|grasp| value(grasp).unwrap_or(f64::NAN)).collect();
        shaped(py, values, &[self.set.len()])
    }
}

/// Reads one value per grasp; NaN means unknown.
fn known(value: Option<&Bound<'_, PyAny>>, what: &str, count: usize) -> PyResult<Vec<Option<f64>>> {
    let Some(value) = value else { return Ok(vec![None; count]) };
    let numbers = Numbers::read(value, what)?;
    if *numbers.shape() != [count] {
        return Err(numbers.wrong_shape(&format!("({count},) for the {count} poses")));
    }
    Ok(numbers.values()?.iter().copied().map(known_number).collect())
}

fn known_number(value: f64) -> Option<f64> {
    Some(value).filter(|value| !value.is_nan())
}

fn robust(grasp: usize, score: Option<f64>, trials: Option<f64>) -> PyResult<Option<RobustScore>> {
    match (score, trials) {
        (None, None) => Ok(None),
        (Some(score), Some(trials)) => RobustScore::of_share(score, trials)
            .map(Some)
            .ok_or_else(|| fault(GraspError::Robust { grasp, score, trials })),
        _ => Err(bad_value(format!("grasp {grasp}: give both robust_scores and robust_trials, or neither"))),
    }
}
