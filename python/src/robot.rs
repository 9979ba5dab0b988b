//! `Robot`: links, joints, kinematics.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use cranny_collision::{Cell, Scratch};
use cranny_grasp::rows_of_pose;
use cranny_robot::{
    Dynamics, IkSearchSettings, IkSolver, JointGroup, MeshUse, Robot, RobotOptions, TextSource,
    solve_restarts,
};
use cranny_scenario::{BUILTIN_ROBOTS, BuiltinRobot, RobotSource};
use cranny_spatial::{Pose, Stream, Vector};
use numpy::PyArrayDyn;
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::classes::{PyCell, PyRobot};
use crate::handover::array::{self, Configurations, shaped};
use crate::handover::fault::{bad_type, bad_value, fault};
use crate::handover::pickled::{Made, Reduced, absolute};
use crate::handover::rows::computed;
use crate::handover::whole;

/// Rows per block of work: a few hundred microseconds.
const BLOCK: usize = 256;

/// Maximum number of attempts; more would be a mistake. An attempt takes some ten microseconds.
const MOST_ATTEMPTS: usize = 100_000;

/// Maximum number of sampled configurations; more would be a mistake.
const MOST_SAMPLES: usize = 100_000_000;

#[pymethods]
impl PyRobot {
    #[new]
    #[pyo3(signature = (*_arguments, **_keywords))]
    fn new(_arguments: &Bound<'_, PyTuple>, _keywords: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        Err(bad_type(
            "a Robot is not made by Robot(…), but read by Robot.from_urdf(path) or Robot.from_urdf_text(text); the \
             built-in ones are Robot.builtin(name), that of a scenario is scenario.robot",
        ))
    }

    /// Reads a robot from the URDF, MJCF or SDF file or robot folder at `path`.
    ///
    /// The SRDF, the `limits.yaml` and the `robot.yaml` beside the URDF are read too; `srdf` names another SRDF. `tip`: the
    /// link whose frame reaches the grasps; by default the gripper frame of `robot.yaml`, with open fingers. `joints`: names of
    /// the joints of `q`, in order; or `group`: a group of the SRDF; by default all from the root to the tip. `fixed`: values
    /// (m, rad) of joints outside the group. `packages`: folders to search for `package://` names. `meshes`: "hull" (convex
    /// hull of a mesh) or "solid" (its enclosed volume). `unchecked_pairs`: pairs of links that may touch.
    ///
    /// Raises CrannyError with file, line and a hint.
    #[staticmethod]
    #[pyo3(signature = (path, *, srdf=None, tip=None, joints=None, group=None, fixed=None, packages=None, meshes="hull",
        unchecked_pairs=None))]
    #[allow(clippy::too_many_arguments, reason = "the keywords of the Python function")]
    fn from_urdf(
        py: Python<'_>,
        path: PathBuf,
        srdf: Option<PathBuf>,
        tip: Option<String>,
        joints: Option<Vec<String>>,
        group: Option<String>,
        fixed: Option<BTreeMap<String, f64>>,
        packages: Option<Vec<PathBuf>>,
        meshes: &str,
        unchecked_pairs: Option<Vec<[String; 2]>>,
    ) -> PyResult<Self> {
        let group = match (joints, group) {
            (Some(_), Some(_)) => return Err(bad_value("give joints or group, not both")),
            (Some(joints), None) => JointGroup::Joints(joints),
            (None, Some(group)) => JointGroup::Srdf(group),
            (None, None) => JointGroup::RootToTip,
        };
        let keywords = PyDict::new(py);
        keywords.set_item("srdf", srdf.as_deref().map(absolute).transpose()?)?;
        keywords.set_item("tip", &tip)?;
        match &group {
            JointGroup::Joints(joints) => keywords.set_item("joints", joints)?,
            JointGroup::Srdf(group) => keywords.set_item("group", group)?,
            JointGroup::RootToTip => {}
        }
        keywords.set_item("fixed", &fixed)?;
        let folders = packages.iter().flatten().map(|folder| absolute(folder));
        keywords.set_item("packages", folders.collect::<PyResult<Vec<_>>>()?)?;
        keywords.set_item("meshes", meshes)?;
        keywords.set_item("unchecked_pairs", &unchecked_pairs)?;
        let options = RobotOptions {
            srdf: srdf.map(TextSource::Path),
            group,
            tip,
            fixed: fixed.unwrap_or_default(),
            packages: packages.unwrap_or_default(),
            unchecked_pairs: unchecked_pairs.unwrap_or_default(),
            meshes: match meshes {
                "hull" => MeshUse::Hull,
                "solid" => MeshUse::Solid,
                _ => {
                    return Err(bad_value(format!(
                        "meshes is '{meshes}', but 'hull' or 'solid' is expected"
                    )));
                }
            },
            ..RobotOptions::default()
        };
        let robot = py.detach(|| Robot::load(&path, &options)).map_err(fault)?;
        let reader = py.get_type::<Self>().getattr("from_urdf")?;
        let made = Made::opened(&reader, (absolute(&path)?,), &keywords)?;
        Ok(Self { robot: Arc::new(robot), source: RobotSource::Other, made })
    }

    /// Reads a robot from the text of a URDF without meshes.
    #[staticmethod]
    #[pyo3(signature = (text, *, tip=None))]
    fn from_urdf_text(py: Python<'_>, text: &str, tip: Option<String>) -> PyResult<Self> {
        let keywords = PyDict::new(py);
        keywords.set_item("tip", &tip)?;
        let options = RobotOptions { tip, ..RobotOptions::default() };
        let robot = Robot::from_urdf_text(text, "<text>", None, &options).map_err(fault)?;
        let reader = py.get_type::<Self>().getattr("from_urdf_text")?;
        let made = Made::opened(&reader, (text,), &keywords)?;
        Ok(Self { robot: Arc::new(robot), source: RobotSource::Other, made })
    }

    /// Returns the built-in robot: a Franka Panda with its hand on a base that slides along y and x, 9 joints.
    #[staticmethod]
    #[pyo3(name = "panda_mobile")]
    fn built_in(py: Python<'_>) -> PyResult<Self> {
        let made = Made::by(py.get_type::<Self>().getattr("panda_mobile")?, ())?;
        Self::of_builtin(py, &BUILTIN_ROBOTS[0], made)
    }

    /// Returns a built-in robot by its name: "panda_mobile", "ur5e", "ur5e_mobile", "fr3" or "fetch_like".
    ///
    /// Raises ValueError for another name.
    #[staticmethod]
    fn builtin(py: Python<'_>, name: &str) -> PyResult<Self> {
        let known = || BUILTIN_ROBOTS.iter().map(|robot| robot.name).collect::<Vec<_>>().join(", ");
        let unknown = || bad_value(format!("unknown built-in robot '{name}' (known: {})", known()));
        let robot = BuiltinRobot::of_name(name).ok_or_else(unknown)?;
        let made = Made::by(py.get_type::<Self>().getattr("builtin")?, (name,))?;
        Self::of_builtin(py, robot, made)
    }

    /// Name in the URDF.
    #[getter]
    fn name(&self) -> &str {
        self.robot.name()
    }

    /// Number of joints of `q`.
    #[getter]
    fn dof(&self) -> usize {
        self.robot.dof()
    }

    /// Names of the joints, in the order of `q`.
    #[getter]
    fn joint_names(&self) -> Vec<String> {
        self.robot.joint_names().to_vec()
    }

    /// Unit of each value of `q`: "m" or "rad".
    #[getter]
    fn joint_units(&self) -> Vec<&'static str> {
        self.robot.limits().iter().map(|limits| limits.unit.symbol()).collect()
    }

    /// Names of all links, the root first.
    #[getter]
    fn link_names(&self) -> Vec<String> {
        self.robot.links().iter().map(|link| link.name.clone()).collect()
    }

    /// Link whose frame is the gripper frame, which reaches the grasps.
    #[getter]
    fn tip(&self) -> String {
        self.robot.links()[self.robot.tip()].name.clone()
    }

    /// Lower limit of each joint, (dof,), in m or rad.
    #[getter]
    fn lower<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.per_joint(py, |limits| limits.lower)
    }

    /// Upper limit of each joint, (dof,), in m or rad.
    #[getter]
    fn upper<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.per_joint(py, |limits| limits.upper)
    }

    /// Velocity limit of each joint, (dof,), in m/s or rad/s.
    #[getter]
    fn velocity<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.per_joint(py, |limits| limits.velocity)
    }

    /// Acceleration limit of each joint, (dof,), in m/s² or rad/s²; NaN if the robot's files state none.
    #[getter]
    fn acceleration<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.per_joint(py, |limits| limits.acceleration.unwrap_or(f64::NAN))
    }

    /// Returns the pose `root_from_link` of `link`, by default the tip, at `q`: (4, 4), metres; (N, 4, 4) for a batch.
    ///
    /// Limits are not checked. `threads`: number of cores that share a batch; None: all. An unknown link raises KeyError.
    #[pyo3(signature = (q, link=None, *, threads=Some(1)), text_signature = "($self, q, link=None, *, threads=1)")]
    fn fk<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        link: Option<&str>,
        #[pyo3(from_py_with = whole::threads)] threads: Option<usize>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let (py, robot) = (q.py(), &*self.robot);
        let q = Configurations::read(q, "q", robot)?;
        let link = self.link(link)?;
        let poses = q.computed(
            py,
            16,
            BLOCK,
            threads,
            || robot.frames(),
            |frames, q, out: &mut [f64]| {
                if link == robot.tip() {
                    robot.tip_kinematics(q, frames);
                } else {
                    robot.forward_kinematics(q, frames);
                }
                out.copy_from_slice(&rows_of_pose(frames.link(link)));
            },
        )?;
        shaped(py, poses, &[q.count, 4, 4][usize::from(q.is_single)..])
    }

    /// Returns the geometric Jacobian of `link`, by default the tip, at its origin, in the root frame: (6, dof), or (N, 6, dof)
    /// for a batch. Rows 0–2: metres of the origin; rows 3–5: radians of its rotation; per metre or radian of each joint.
    /// An unknown link raises KeyError.
    #[pyo3(signature = (q, link=None, *, threads=Some(1)), text_signature = "($self, q, link=None, *, threads=1)")]
    fn jacobian<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        link: Option<&str>,
        #[pyo3(from_py_with = whole::threads)] threads: Option<usize>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let (py, robot, dof) = (q.py(), &*self.robot, self.robot.dof());
        let q = Configurations::read(q, "q", robot)?;
        let link = self.link(link)?;
        let room = || (robot.frames(), robot.empty_jacobian());
        let jacobians = q.computed(py, 6 * dof, BLOCK, threads, room, |(frames, jacobian), q, out| {
            robot.forward_kinematics(q, frames);
            robot.jacobian(frames, link, jacobian);
            // The matrix is stored in column-major order.
            out.iter_mut().zip(jacobian.transpose().iter()).for_each(|(out, entry)| *out = *entry);
        })?;
        shaped(py, jacobians, &[q.count, 6, dof][usize::from(q.is_single)..])
    }

    /// Returns the force or torque (N, N m) that each joint needs at `q` (m, rad) with these velocities and accelerations (per
    /// s, s²), for the masses of the links in the URDF: (dof,), or (N, dof) for a batch, all three of one shape. `up` (3,):
    /// direction against gravity in the root frame. Friction and rotor inertia, which a URDF does not state, are neglected.
    #[pyo3(signature = (q, velocity, acceleration, *, up=[0.0, 0.0, 1.0]),
        text_signature = "($self, q, velocity, acceleration, *, up=(0, 0, 1))")]
    fn joint_forces<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        velocity: &Bound<'py, PyAny>,
        acceleration: &Bound<'py, PyAny>,
        up: [f64; 3],
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let (py, robot, dof) = (q.py(), &*self.robot, self.robot.dof());
        let read = |value, what| Configurations::read(value, what, robot);
        let given = [read(q, "q")?, read(velocity, "velocity")?, read(acceleration, "acceleration")?];
        if given.iter().any(|of| (of.count, of.is_single) != (given[0].count, given[0].is_single)) {
            return Err(bad_value("q, velocity and acceleration must have the same shape"));
        }
        let length = up.iter().map(|x| x * x).sum::<f64>().sqrt();
        if (length - 1.0).abs().is_nan() || (length - 1.0).abs() > 1e-6 {
            return Err(bad_value(format!("up has the length {length}, not 1")));
        }
        let missing = |link| bad_value(format!("the URDF states no mass and inertia of link '{link}'"));
        let dynamics = Dynamics::new(robot, &Vector::from(up), None).map_err(missing)?;
        let mut frames = robot.frames();
        let mut forces = Vec::with_capacity(given[0].count * dof);
        let [q, velocity, acceleration] = [given[0].values()?, given[1].values()?, given[2].values()?]
            .map(|values| values.chunks_exact(dof));
        for ((q, velocity), acceleration) in q.zip(velocity).zip(acceleration) {
            let of_row = robot.path_forces(&dynamics, [q, velocity, acceleration], &mut frames);
            forces.extend(of_row.bend.iter().zip(&of_row.weight).map(|(bend, weight)| bend + weight));
        }
        shaped(py, forces, &[given[0].count, dof][usize::from(given[0].is_single)..])
    }

    /// Returns configurations that bring the tip to `pose`, (4, 4) `root_from_tip`: an array (K, dof), 0 ≤ K ≤ `count`, of
    /// distinct solutions within the joint limits, for poses (N, 4, 4) a list of N arrays. An empty array proves nothing.
    ///
    /// At most `attempts` searches start at random configurations drawn from `seed`; with `start` (dof,), a single one starts
    /// there instead. `cell`: return only solutions that are free in it. Each pose of a batch draws from a random stream of its own,
    /// by its index: only the first has the solutions that a call for it alone has with the same seed.
    #[pyo3(
        signature = (pose, *, count=1, attempts=200, seed=0, start=None, cell=None, threads=Some(1)),
        text_signature = "($self, pose, *, count=1, attempts=200, seed=0, start=None, cell=None, threads=1)"
    )]
    #[allow(clippy::too_many_arguments, reason = "the keywords of the Python function")]
    fn ik<'py>(
        &self,
        pose: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = whole::count)] count: usize,
        #[pyo3(from_py_with = whole::attempts)] attempts: usize,
        #[pyo3(from_py_with = whole::seed)] seed: u64,
        start: Option<&Bound<'py, PyAny>>,
        cell: Option<&PyCell>,
        #[pyo3(from_py_with = whole::threads)] threads: Option<usize>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = pose.py();
        let robot = &*self.robot;
        if attempts > MOST_ATTEMPTS {
            return Err(bad_value(format!("attempts is {attempts}, but at most {MOST_ATTEMPTS} are made")));
        }
        let (is_single, poses) = array::poses(pose, "pose")?;
        let start = start.map(|start| array::configuration(start, "start", robot)).transpose()?;
        let cell: Option<&Cell> = match cell {
            Some(cell) if cell.cell.robot().joint_names() != robot.joint_names() => {
                return Err(bad_value("the cell holds another robot, with other joints"));
            }
            cell => cell.map(|cell| &*cell.cell),
        };
        let settings = IkSearchSettings::default();
        let search = Search { robot, start, cell, settings, count, attempts, seed };
        let room = || cell.map(Cell::scratch);
        let found =
            computed(py, (poses.len(), 1), 1, threads, room, |scratch, range, out: &mut [Vec<Vec<f64>>]| {
                for (index, out) in range.zip(out) {
                    *out = search.run(&poses[index], index as u64, scratch.as_mut());
                }
            })?;
        let dof = robot.dof();
        if is_single {
            return Ok(array::rows(py, &found.concat(), dof)?.into_any());
        }
        let arrays: Vec<_> = found.iter().map(|rows| array::rows(py, rows, dof)).collect::<PyResult<_>>()?;
        Ok(arrays.into_pyobject(py)?.into_any())
    }

    /// Returns `count` uniform samples within the joint limits, (count, dof), the same for one `seed` on every machine.
    #[pyo3(signature = (count, *, seed=0))]
    fn sample<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = whole::count)] count: usize,
        #[pyo3(from_py_with = whole::seed)] seed: u64,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let dof = self.robot.dof();
        if count.saturating_mul(dof) > MOST_SAMPLES {
            return Err(bad_value(format!("count is {count}, which is too large for memory")));
        }
        let mut random = Stream::new(seed, 0);
        let values = (0..count).flat_map(|_| self.robot.random_configuration(&mut random)).collect();
        shaped(py, values, &[count, dof])
    }

    /// Pickled as a Scenario is.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        slf.get().made.reduced(slf, "read it again")
    }

    fn __repr__(&self) -> String {
        format!("<cranny.Robot '{}': {} joints, tip '{}'>", self.robot.name(), self.robot.dof(), self.tip())
    }
}

impl PyRobot {
    fn of_builtin(py: Python<'_>, builtin: &BuiltinRobot, made: Made) -> PyResult<Self> {
        let robot = py.detach(|| builtin.robot(&RobotOptions::default())).map_err(fault)?;
        Ok(Self { robot, source: RobotSource::Builtin(builtin.name), made })
    }

    fn per_joint<'py>(
        &self,
        py: Python<'py>,
        value: impl Fn(&cranny_robot::JointLimits) -> f64,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        shaped(py, self.robot.limits().iter().map(value).collect(), &[self.robot.dof()])
    }

    fn link(&self, name: Option<&str>) -> PyResult<usize> {
        let Some(name) = name else { return Ok(self.robot.tip()) };
        self.robot.link_index(name).ok_or_else(|| {
            let known = self.link_names().join(", ");
            PyKeyError::new_err(format!("{} has no link '{name}' (it has: {known})", self.robot.name()))
        })
    }
}

/// Settings of a search for inverse kinematics solutions, shared by all poses.
struct Search<'a> {
    robot: &'a Robot,
    start: Option<Vec<f64>>,
    cell: Option<&'a Cell>,
    settings: IkSearchSettings,
    count: usize,
    attempts: usize,
    seed: u64,
}

impl Search<'_> {
    /// Returns the solutions for pose `number`, which has a random stream of its own.
    fn run(&self, pose: &Pose, number: u64, mut scratch: Option<&mut Scratch>) -> Vec<Vec<f64>> {
        let mut accept = |q: &[f64]| match (self.cell, scratch.as_deref_mut()) {
            (Some(cell), Some(scratch)) => cell.is_free(q, scratch),
            _ => true,
        };
        if let Some(start) = &self.start {
            let found = IkSolver::new(self.robot, self.settings.ik).solve_from(pose, start);
            return found.into_iter().map(|found| found.q).filter(|q| accept(q)).take(self.count).collect();
        }
        let mut random = Stream::new(self.seed, number);
        let found = solve_restarts(
            self.robot,
            pose,
            &mut random,
            self.settings,
            self.count,
            self.attempts,
            &mut accept,
        );
        found.into_iter().map(|found| found.q).collect()
    }
}
