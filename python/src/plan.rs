//! `Plan`: an answer, with all that is needed to judge it and to find it again.

use std::path::PathBuf;
use std::sync::Arc;

use cranny_path::AuditSettings;
use cranny_plan::{Outcome, PlanError};
use cranny_record::{Judgement, PlanFile, write_trajectory_csv};
use cranny_scenario::GivenGrasps;
use cranny_solve::TaskTrajectory;
use cranny_task::{Segment, robot_hand};
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict as _, PyDict};

use crate::classes::{PyPlan, PyScenario, Task};
use crate::handover::array::{Numbers, rows, shaped};
use crate::handover::fault::{bad_value, fault};
use crate::handover::json::python_of;
use crate::handover::pickled::{Reduced, restored_by};
use crate::trajectory::PySamples;
use crate::verification::PyVerification;

#[pymethods]
impl PyPlan {
    /// Reads a `.plan.json` of `scenario` (a Scenario or a MoveItProblem); None: the built-in one that it names.
    ///
    /// Nothing that the file states is trusted: the path is judged anew, every property is a figure measured along it, and
    /// `differs` names those that the file states otherwise. A file that promises more than there is makes a plan that is
    /// False, and `verify()` names the statement. How the path was found (`report["statistics"]`, `["planner"]`, `["seed"]`,
    /// …), and of a file without a path `outcome`, `not_checked` and why there is none (`report["failures"]`,
    /// `["no_grasp"]`), is as the file has it: `unjudged` names these keys.
    #[staticmethod]
    #[pyo3(signature = (path, scenario=None))]
    fn load(py: Python<'_>, path: PathBuf, scenario: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        Self::of_file(py, PlanFile::read(&path).map_err(fault)?, scenario)
    }

    /// Way points from the start to the goal, (N, dof), joined by straight lines; (0, dof) where none was found.
    #[getter]
    fn path<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        rows(py, &self.file.waypoints, self.file.joint_names.len())
    }

    /// The pieces of the path, each from where the one before ends, as dicts of `mode` ("reach", "lift-off", "carry"),
    /// `attached` (what the hand carries, or None), `opening_m` (between the fingers; None: as far as they go), `uneven_m`
    /// (how much farther the finger that meets the object last would have to go than the first, or None), `stage` (index in
    /// `task`) and `path`, (N, dof). One, unless the task has several stages.
    #[getter]
    fn segments<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let dof = self.file.joint_names.len();
        let segment = |segment: &Segment| {
            let row = PyDict::new(py);
            row.set_item("mode", segment.mode.name)?;
            row.set_item("stage", segment.stage)?;
            row.set_item("attached", &segment.attached)?;
            row.set_item("opening_m", segment.opening_m)?;
            row.set_item("uneven_m", segment.uneven_m)?;
            row.set_item("path", rows(py, &segment.waypoints, dof)?)?;
            Ok(row)
        };
        self.measured.segments.iter().map(segment).collect()
    }

    /// The stages of the task, in order: dictionaries of `pick`, `move` or `place`, with what belongs to each. Empty where the
    /// goal of the scenario is all.
    #[getter]
    fn task<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_of(py, &self.file.task)
    }

    /// Name of the task of the scenario that this is a plan for, or None.
    #[getter]
    fn task_name(&self) -> Option<&str> {
        self.file.task_name.as_deref()
    }

    /// How far things may be from where the plan has them while every segment stays proven, each kind of error by itself: a
    /// dictionary of "object" (before the hand closes), "slip" (in the hand), "base" and "joints", each a dictionary (m, rad)
    /// or None where nothing is there to touch; None where there is no proof.
    #[getter]
    fn robustness<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.measured.robustness.as_ref().map(|robustness| python_of(py, robustness)).transpose()
    }

    /// Length, in the plain norm of the joints (m and rad alike), that every path of the task has at least, proven; None where it
    /// is not known.
    #[getter]
    fn least_length(&self) -> Option<f64> {
        self.measured.least_length
    }

    /// Tilt of what is held along the whole motion: a dictionary of "greatest_rad" (a proven upper bound) and "most_rad" (what
    /// is allowed), in radians; None where no tilt is limited.
    #[getter]
    fn tilt<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.measured.tilt.as_ref().map(|tilt| python_of(py, tilt)).transpose()
    }

    /// Distance of the tool within each of its bounds along the whole motion: dictionaries of "name" and "slack_m" or
    /// "slack_rad" (a proven lower bound); empty where the tool is not bounded.
    #[getter]
    fn tool<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_of(py, &self.measured.tool)
    }

    /// Firmness with which the hand holds what it carries: a dictionary of "factor" (by which all loads may grow before a pad
    /// slips, the least along the motion; None without times), "at_rest" (of the weight alone) and "mass_assumed"; None where
    /// nothing is carried, or it cannot be computed.
    #[getter]
    fn hold<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.measured.hold.as_ref().map(|hold| python_of(py, hold)).transpose()
    }

    /// Plans that were tried in physics, of which this is the last: a list of dictionaries of "seed", "outcome", "kept",
    /// "as_planned" and, of a grasp that failed, "left_out"; empty where none was tried.
    #[getter]
    fn tries<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_of(py, &self.file.tries)
    }

    /// When each way point is passed, (N,), in seconds; None for a robot without limits of acceleration.
    #[getter]
    fn times<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArrayDyn<f64>>>> {
        let times = self.trajectory.as_ref().map(|trajectory| trajectory.waypoint_times_s());
        times.map(|times| shaped(py, times.clone(), &[times.len()])).transpose()
    }

    /// From the first way point to the last, in seconds; None where `times` is None.
    #[getter]
    fn duration_s(&self) -> Option<f64> {
        self.trajectory.as_ref().map(|trajectory| trajectory.duration_s())
    }

    /// How the search ended: "solved", "budget-exhausted", "gave-up", "cancelled",
    /// "start-invalid", "goals-invalid" or "no-reachable-grasp". Of a file without a path as stated: see `unjudged`.
    #[getter]
    fn outcome(&self) -> &'static str {
        self.measured.outcome.name()
    }

    /// Whether a path was found and the judge finds that it meets the criterion.
    #[getter]
    fn solved(&self) -> bool {
        self.measured.outcome == Outcome::Solved && self.is_valid
    }

    /// Index of the grasp that the path ends at, if it is one.
    #[getter]
    fn grasp(&self) -> Option<usize> {
        self.measured.grasp
    }

    /// The grasp that the path ends at, where no set of grasps was given: a dictionary of `world_from_gripper` (4 × 4, in the
    /// planning frame), `opening_m` (between the fingers once the first has closed on it), `score` and `uneven_m` (how much
    /// farther the other goes); else None.
    #[getter]
    fn own_grasp<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_of(py, &self.measured.own_grasp)
    }

    /// The least clearance along the whole path in metres, proven; None where there is none.
    #[getter]
    fn clearance_m(&self) -> Option<f64> {
        self.measured.clearance_m
    }

    /// Pairs that are not compared: dictionaries of `first`, `second`, `depth_m` and `reason` ("always-touching",
    /// "adjacent-touching", "adjacent-at-joint", "adjacent-unproven", "adjacent-free", "never-moves"; "resting": contact of an
    /// object with what carries it, with `segment` and `allowance_m`). The verdict holds but for these; those that are
    /// "adjacent-free" are proven never to touch, and only their distance counts for no margin and no clearance.
    #[getter]
    fn not_checked<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_of(py, &self.measured.not_checked)
    }

    /// Names of the joints, in the order of every way point.
    #[getter]
    fn joint_names(&self) -> Vec<String> {
        self.measured.joint_names.clone()
    }

    /// Statements of the file that the plan was read from that differ from what was measured, or from the task that it is
    /// judged in: dictionaries of `key`, `stated` and `measured`. Those that promise more than there is are violations
    /// instead: see `verify`. Empty for a plan that was not read.
    #[getter]
    fn differs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_of(py, &self.differs)
    }

    /// Keys of the file that the plan was read from of which nothing was measured: what they hold is as stated. Empty for a
    /// plan that was not read.
    #[getter]
    fn unjudged(&self) -> Vec<&'static str> {
        self.unjudged.clone()
    }

    /// Everything that stands in a plan file, as a dictionary: `planner`, `seed`, `statistics`, `timing`, …; and
    /// `failures`, what stood between the robot and each grasp, from planners that keep account of it, and `no_grasp`, why
    /// none was taken at all, where the arm came to none.
    #[getter]
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let report = python_of(py, &self.measured)?;
        report.set_item("valid", self.is_valid)?;
        Ok(report)
    }

    /// Where the robot is, how fast and how hard it accelerates, at `rate` samples a second (Hz): a Samples of
    /// arrays (T, dof). The last sample is the end.
    #[pyo3(signature = (rate=100.0))]
    fn sample(&self, py: Python<'_>, rate: f64) -> PyResult<PySamples> {
        let trajectory = self.timed()?;
        py.detach(|| PySamples::of(&trajectory, rate)).map_err(fault)
    }

    /// The same for the way to the grasp by itself and, where the target is carried on, for the way from there, and, where it
    /// is put down, for the way off it, each from 0 on: between them the hand closes, and opens.
    #[pyo3(signature = (rate=100.0))]
    fn sample_ways(&self, py: Python<'_>, rate: f64) -> PyResult<Vec<PySamples>> {
        let trajectory = self.timed()?;
        py.detach(|| PySamples::of_ways(&trajectory, rate)).map_err(fault)
    }

    /// The hand as `cranny.ros` commands it: how far the fingers are apart on each of these ways (m), and their force (N);
    /// None where they close on nothing.
    fn _closing(&self) -> PyResult<Option<(Vec<f64>, f64)>> {
        let force_n = robot_hand(self.task.problem.robot()).closing_force_n;
        Ok(self.timed()?.openings_m().map(|openings_m| (openings_m.to_vec(), force_n)))
    }

    /// Judges the path again, as anybody's, from the way points alone, and what its file states of it.
    fn verify(&self, py: Python<'_>) -> PyResult<PyVerification> {
        let judgement = py
            .detach(|| self.judge())
            .and_then(|found| found.ok_or_else(|| cranny_path::PathError::EmptyPath.into()));
        Ok(PyVerification { audit: judgement.map_err(fault)?.audit })
    }

    /// Writes a `.plan.json`, as a whole or not at all.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        self.measured.write(&path).map_err(fault)
    }

    /// Writes the samples at `rate` (Hz) as CSV: seconds, positions, velocities, accelerations, and, where the hand closes on
    /// something, how far the fingers are apart.
    #[pyo3(signature = (path, rate=100.0))]
    fn save_trajectory(&self, path: PathBuf, rate: f64) -> PyResult<()> {
        let trajectory = self.timed()?;
        write_trajectory_csv(&path, &trajectory, rate).map_err(fault)
    }

    /// The scenario, what stands in a plan file, and the way points to their last digits.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        let (py, plan) = (slf.py(), slf.get());
        let text = serde_json::to_string(&plan.file).map_err(fault)?;
        restored_by(py, "_restored_plan", (plan.task.given.bind(py), text, plan.path(py)?))
    }

    fn __bool__(&self) -> bool {
        self.solved()
    }

    fn __repr__(&self) -> String {
        let PlanFile { scenario, planner, waypoints, .. } = &self.file;
        let stated = if self.unjudged.contains(&"outcome") { " as stated" } else { "" };
        format!(
            "<cranny.Plan of '{scenario}': {}{stated} by {planner}, {} way points>",
            self.outcome(),
            waypoints.len()
        )
    }
}

/// A plan as it was pickled, judged anew.
#[pyfunction]
#[pyo3(name = "_restored_plan")]
pub fn restored_plan(scenario: &Bound<'_, PyAny>, text: &str, path: &Bound<'_, PyAny>) -> PyResult<PyPlan> {
    let file: PlanFile = serde_json::from_str(text).map_err(fault)?;
    let path = Numbers::read(path, "path")?;
    let waypoints = path.finite()?.chunks_exact(file.joint_names.len().max(1)).map(<[f64]>::to_vec).collect();
    PyPlan::of_file(scenario.py(), PlanFile { waypoints, ..file }, Some(scenario))
}

impl PyPlan {
    /// What stands in a plan file, judged anew.
    pub fn of_file(py: Python<'_>, file: PlanFile, scenario: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let named;
        let scenario = if let Some(scenario) = scenario {
            scenario
        } else {
            let what = (file.scenario.clone(),);
            let keywords = [("criterion", file.criterion.name())].into_py_dict(py)?;
            if file.given_grasps() == GivenGrasps::None {
                keywords.set_item("grasps", GivenGrasps::None.text())?;
            }
            named = py.get_type::<PyScenario>().call(what, Some(&keywords))?;
            &named
        };
        let mut task = Task::of(scenario, file.margins)?;
        if let Some(scenario) = &task.scenario {
            task.source = file.source_in(scenario, &task.source);
        }
        Self::judged(py, task, file)
    }

    /// A plan judged in a task.
    pub fn judged(py: Python<'_>, task: Task, file: PlanFile) -> PyResult<Self> {
        let expected = task.problem.robot().joint_names();
        if file.joint_names != expected {
            let (found, expected) = (file.joint_names.join(", "), expected.join(", "));
            return Err(bad_value(format!("the plan is for joints {found}, but the robot has {expected}")));
        }
        let judged = || {
            Ok::<_, PlanError>((
                file.judge(&task.source, &task.problem, AuditSettings::default())?,
                file.trajectory(task.problem.robot())?,
            ))
        };
        let (judgement, trajectory) = py.detach(judged).map_err(fault)?;
        let is_valid = judgement.as_ref().is_some_and(|judgement| judgement.audit.valid);
        let trajectory = trajectory.filter(|_| file.timing.is_some()).map(Arc::new);
        let judgement = judgement.unwrap_or_else(|| file.judge_without_path(&task.source, &task.problem));
        let Judgement { measured, differs, not_compared: unjudged, .. } = judgement;
        Ok(Self { task, file, measured, differs, unjudged, trajectory, is_valid })
    }

    /// As [`PlanFile::judge`], in the task that it was planned for or read in.
    pub fn judge(&self) -> Result<Option<Judgement>, PlanError> {
        self.file.judge(&self.task.source, &self.task.problem, AuditSettings::default())
    }

    fn timed(&self) -> PyResult<Arc<TaskTrajectory>> {
        self.trajectory.clone().ok_or_else(|| {
            bad_value(if self.file.waypoints.is_empty() {
                "there is no path to sample"
            } else {
                "the path has no time: the robot has no limits of acceleration (give them in its limits.yaml), or \
                 the path is not valid"
            })
        })
    }
}
