//! `Plan`: a planning result with everything needed to verify and reproduce it.

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

/// Minimum rate of samples, in hertz. An instant nearer to the end than a millionth of an interval counts as the end; at lower rates
/// that is more than a millisecond, and may be the start.
const LEAST_RATE_HZ: f64 = 1e-3;

#[pymethods]
impl PyPlan {
    /// Reads a `.plan.json` of `scenario` (a Scenario or a MoveItProblem); None: the built-in one that it names.
    ///
    /// No statement of the file is trusted: the path is verified again, every property is measured along it, and `differs`
    /// lists the statements that differ. If the file promises more than was measured, the plan is False, and `verify()` names
    /// the statement. Details of the search (`report["statistics"]`, `["planner"]`, `["seed"]`, …), and for a file without a
    /// path `outcome`, `not_checked` and the reasons (`report["failures"]`, `["no_grasp"]`), are taken from the file:
    /// `unjudged` lists these keys.
    #[staticmethod]
    #[pyo3(signature = (path, scenario=None))]
    fn load(py: Python<'_>, path: PathBuf, scenario: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        Self::of_file(py, PlanFile::read(&path).map_err(fault)?, scenario)
    }

    /// Way points from the start to the goal, (N, dof), joined by straight lines; (0, dof) if no path was found.
    #[getter]
    fn path<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        rows(py, &self.file.waypoints, self.file.joint_names.len())
    }

    /// Segments of the path, each starting at the end of the one before, as dicts of `mode` ("reach", "lift-off", "carry"),
    /// `attached` (the object in the hand, or None), `opening_m` (finger opening; None: fully open), `uneven_m` (additional
    /// travel of the finger that meets the object last, or None), `stage` (index in `task`) and `path`, (N, dof). One, unless
    /// the task has several stages.
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

    /// Stages of the task, in order: dictionaries of `pick`, `move` or `place`, with their settings. Empty if the goal of the
    /// scenario is the only one.
    #[getter]
    fn task<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_of(py, &self.file.task)
    }

    /// Name of the scenario's task that this plan solves, or None.
    #[getter]
    fn task_name(&self) -> Option<&str> {
        self.file.task_name.as_deref()
    }

    /// Tolerated errors for which every segment stays proven, each kind of error by itself: a dictionary of "object" (before
    /// the hand closes), "slip" (in the hand), "base" and "joints", each a dictionary (m, rad) or None without any pair to
    /// check; None without a proof.
    #[getter]
    fn robustness<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.measured.robustness.as_ref().map(|robustness| python_of(py, robustness)).transpose()
    }

    /// Proven lower bound on the length of every path of the task, in the plain norm of the joints (m and rad alike), or None.
    #[getter]
    fn least_length(&self) -> Option<f64> {
        self.measured.least_length
    }

    /// Tilt of the held object along the whole motion: a dictionary of "greatest_rad" (a proven upper bound) and "most_rad"
    /// (the limit), in radians; None without a limit.
    #[getter]
    fn tilt<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.measured.tilt.as_ref().map(|tilt| python_of(py, tilt)).transpose()
    }

    /// Slack of the tool within each of its bounds along the whole motion: dictionaries of "name" and "slack_m" or "slack_rad"
    /// (a proven lower bound); empty if the tool is not bounded.
    #[getter]
    fn tool<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_of(py, &self.measured.tool)
    }

    /// Firmness of the hold on the carried object: a dictionary of "factor" (by which all loads may grow before a pad slips,
    /// the minimum along the motion; None without times), "at_rest" (for the weight alone) and "mass_assumed"; None if no
    /// object is carried, or if it cannot be computed.
    #[getter]
    fn hold<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.measured.hold.as_ref().map(|hold| python_of(py, hold)).transpose()
    }

    /// Plans that were tested in physics, of which this is the last: a list of dictionaries of "seed", "outcome", "kept",
    /// "as_planned" and, for a failed grasp, "left_out"; empty if none was tested.
    #[getter]
    fn tries<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_of(py, &self.file.tries)
    }

    /// Time of each way point, (N,), in seconds; None for a robot without acceleration limits.
    #[getter]
    fn times<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArrayDyn<f64>>>> {
        let times = self.trajectory.as_ref().map(|trajectory| trajectory.waypoint_times_s());
        times.map(|times| shaped(py, times.clone(), &[times.len()])).transpose()
    }

    /// Duration from the first way point to the last, in seconds; None if `times` is None.
    #[getter]
    fn duration_s(&self) -> Option<f64> {
        self.trajectory.as_ref().map(|trajectory| trajectory.duration_s())
    }

    /// Outcome of the search: "solved", "budget-exhausted", "gave-up", "cancelled", "start-invalid", "goals-invalid" or
    /// "no-reachable-grasp". For a file without a path as stated: see `unjudged`.
    #[getter]
    fn outcome(&self) -> &'static str {
        self.measured.outcome.name()
    }

    /// True if a path was found and verified under the criterion.
    #[getter]
    fn solved(&self) -> bool {
        self.measured.outcome == Outcome::Solved && self.is_valid
    }

    /// Index of the grasp at the end of the path, or None.
    #[getter]
    fn grasp(&self) -> Option<usize> {
        self.measured.grasp
    }

    /// Grasp at the end of the path if no set of grasps was given: a dictionary of `world_from_gripper` (4 × 4, in the planning
    /// frame), `opening_m` (finger opening when the first finger touches), `score` and `uneven_m` (additional travel of the
    /// other finger); else None.
    #[getter]
    fn own_grasp<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_of(py, &self.measured.own_grasp)
    }

    /// Proven minimum clearance along the whole path in metres, or None.
    #[getter]
    fn clearance_m(&self) -> Option<f64> {
        self.measured.clearance_m
    }

    /// Pairs that are not compared: dictionaries of `first`, `second`, `depth_m` and `reason` ("always-touching",
    /// "adjacent-touching", "adjacent-at-joint", "adjacent-unproven", "adjacent-free", "never-moves"; "resting": contact of an
    /// object with its support, with `segment` and `allowance_m`). The verdict excludes them; "adjacent-free" pairs are proven
    /// never to touch, and only their distance is excluded from margins and clearances.
    #[getter]
    fn not_checked<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_of(py, &self.measured.not_checked)
    }

    /// Names of the joints, in the order of every way point.
    #[getter]
    fn joint_names(&self) -> Vec<String> {
        self.measured.joint_names.clone()
    }

    /// Statements of the plan's file that differ from the measurements, or from the task that it is verified in: dictionaries
    /// of `key`, `stated` and `measured`. Statements that promise more than was measured are violations instead: see `verify`.
    /// Empty for a plan that was not read.
    #[getter]
    fn differs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_of(py, &self.differs)
    }

    /// Keys of the plan's file whose values are not measured but taken as stated. Empty for a plan that was not read.
    #[getter]
    fn unjudged(&self) -> Vec<&'static str> {
        self.unjudged.clone()
    }

    /// Content of a plan file as a dictionary: `planner`, `seed`, `statistics`, `timing`, …; and `failures`, the obstacles
    /// between the robot and each grasp, from planners that record them, and `no_grasp`, the reason if no grasp was reached.
    #[getter]
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let report = python_of(py, &self.measured)?;
        report.set_item("valid", self.is_valid)?;
        Ok(report)
    }

    /// Samples position, velocity and acceleration of the joints at `rate` (Hz, at least 0.001), with the end: a Samples of arrays
    /// (T, dof).
    #[pyo3(signature = (rate=100.0))]
    fn sample(&self, py: Python<'_>, rate: f64) -> PyResult<PySamples> {
        let trajectory = self.timed_at(rate)?;
        py.detach(|| PySamples::of(&trajectory, rate)).map_err(fault)
    }

    /// Samples the motions between hand movements separately, each from time 0: to the grasp, with the carried target from
    /// there, and away from the target after it is put down. In between, the hand closes and opens.
    #[pyo3(signature = (rate=100.0))]
    fn sample_ways(&self, py: Python<'_>, rate: f64) -> PyResult<Vec<PySamples>> {
        let trajectory = self.timed_at(rate)?;
        py.detach(|| PySamples::of_ways(&trajectory, rate)).map_err(fault)
    }

    /// Returns the hand commands for `cranny.ros`: the finger opening of each of these motions (m) and the force (N); None if
    /// the fingers do not close on an object.
    fn _closing(&self) -> PyResult<Option<(Vec<f64>, f64)>> {
        let force_n = robot_hand(self.task.problem.robot()).closing_force_n;
        Ok(self.timed()?.openings_m().map(|openings_m| (openings_m.to_vec(), force_n)))
    }

    /// Verifies the path again, like any external path, from its way points alone, and the statements of its file.
    fn verify(&self, py: Python<'_>) -> PyResult<PyVerification> {
        let judgement = py
            .detach(|| self.judge())
            .and_then(|found| found.ok_or_else(|| cranny_path::PathError::EmptyPath.into()));
        Ok(PyVerification { audit: judgement.map_err(fault)?.audit })
    }

    /// Writes a `.plan.json` atomically.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        self.measured.write(&path).map_err(fault)
    }

    /// Writes the samples at `rate` (Hz) as CSV: seconds, positions, velocities, accelerations, and the finger opening if the
    /// hand closes on an object.
    #[pyo3(signature = (path, rate=100.0))]
    fn save_trajectory(&self, path: PathBuf, rate: f64) -> PyResult<()> {
        let trajectory = self.timed_at(rate)?;
        write_trajectory_csv(&path, &trajectory, rate).map_err(fault)
    }

    /// Pickles the scenario, the content of a plan file, and the way points with all digits.
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

/// Restores a pickled plan and verifies it again.
#[pyfunction]
#[pyo3(name = "_restored_plan")]
pub fn restored_plan(scenario: &Bound<'_, PyAny>, text: &str, path: &Bound<'_, PyAny>) -> PyResult<PyPlan> {
    let file: PlanFile = serde_json::from_str(text).map_err(fault)?;
    let path = Numbers::read(path, "path")?;
    let waypoints = path.finite()?.chunks_exact(file.joint_names.len().max(1)).map(<[f64]>::to_vec).collect();
    PyPlan::of_file(scenario.py(), PlanFile { waypoints, ..file }, Some(scenario))
}

impl PyPlan {
    /// Verifies the content of a plan file and returns the plan.
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

    /// Verifies a plan in a task.
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

    /// Verifies as [`PlanFile::judge`], in the task that it was planned for or read in.
    pub fn judge(&self) -> Result<Option<Judgement>, PlanError> {
        self.file.judge(&self.task.source, &self.task.problem, AuditSettings::default())
    }

    /// Returns the trajectory, to be sampled at a rate (Hz).
    fn timed_at(&self, rate: f64) -> PyResult<Arc<TaskTrajectory>> {
        if rate > 0.0 && rate < LEAST_RATE_HZ {
            return Err(bad_value(format!("rate is {rate} Hz, but at least {LEAST_RATE_HZ} Hz is expected")));
        }
        self.timed()
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
