//! Fingerprints of contents: one number, by which a reopened object is compared with the one that was pickled.

use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash as _, Hasher as _};

use cranny_collision::World;
use cranny_robot::Robot;
use cranny_shape::Solid;
use cranny_spatial::Pose;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::classes::{PyMoveItProblem, PyRobot, PyScenario};
use crate::handover::fault::{bad_type, fault};
use crate::handover::pickled::{Made, Reduced, restored_by};

impl Made {
    /// Returns the result of `__reduce__` for `thing`; TypeError with `hint` if its origin is unknown.
    pub fn reduced<'py>(&self, thing: &Bound<'py, PyAny>, hint: &str) -> PyResult<Reduced<'py>> {
        let py = thing.py();
        let Some(call) = &self.0 else {
            return Err(bad_type(format!("this {} cannot be pickled: {hint}", thing.get_type().name()?)));
        };
        let (function, arguments) = (call.function.bind(py), call.arguments.bind(py));
        if !call.is_of_files {
            return Ok((function.clone(), arguments.clone()));
        }
        let whole = (function, arguments, fingerprint(thing), env!("CARGO_PKG_VERSION"));
        restored_by(py, "_restored", whole)
    }
}

/// Reopens a pickled object and checks that it is unchanged.
#[pyfunction]
#[pyo3(name = "_restored")]
pub fn restored<'py>(
    function: &Bound<'py, PyAny>,
    arguments: &Bound<'py, PyTuple>,
    known: u64,
    version: &str,
) -> PyResult<Bound<'py, PyAny>> {
    const OWN: &str = env!("CARGO_PKG_VERSION");
    if version != OWN {
        return Err(fault(format!("it was pickled by cranny {version}, and this is {OWN}: open it anew")));
    }
    let thing = function.call1(arguments)?;
    if fingerprint(&thing) != known {
        let shown = thing.repr()?;
        return Err(fault(format!("the files of {shown} have changed since it was pickled: open it anew")));
    }
    Ok(thing)
}

/// Hashes numbers, names and surfaces into one number, to detect changed files.
fn fingerprint(thing: &Bound<'_, PyAny>) -> u64 {
    let mut print = Fingerprint(DefaultHasher::new());
    if let Ok(robot) = thing.cast::<PyRobot>() {
        print.robot(&robot.get().robot);
    } else if let Ok(scenario) = thing.cast::<PyScenario>() {
        let scenario = &scenario.get().scenario;
        print.robot(&scenario.robot);
        print.world(&scenario.world);
        (&scenario.id, scenario.criterion.name(), scenario.target).hash(&mut print.0);
        print.numbers(&scenario.start);
        scenario.ik.iter().for_each(|q| print.numbers(q));
        for grasp in scenario.grasps.grasps() {
            print.pose(&grasp.world_from_gripper);
            let robust = grasp.robust.map(|robust| (robust.score(), robust.trials as f64)).unzip();
            let known = [grasp.score, grasp.width_m, robust.0, robust.1, grasp.load];
            print.numbers(&known.map(|value| value.unwrap_or(f64::NAN)));
        }
        if let Some(export) = &scenario.export {
            print.numbers(export.aabb().low().coords.as_slice());
            print.numbers(export.aabb().high().coords.as_slice());
        }
    } else if let Ok(problem) = thing.cast::<PyMoveItProblem>() {
        let problem = &problem.get().problem;
        print.robot(&problem.robot);
        print.world(&problem.world);
        problem.id.hash(&mut print.0);
        print.numbers(&problem.start);
        problem.goals.iter().for_each(|q| print.numbers(q));
    }
    print.0.finish()
}

struct Fingerprint(DefaultHasher);

impl Fingerprint {
    fn numbers(&mut self, values: &[f64]) {
        values.len().hash(&mut self.0);
        for value in values {
            value.to_bits().hash(&mut self.0);
        }
    }

    fn pose(&mut self, pose: &Pose) {
        self.numbers(pose.translation.vector.as_slice());
        self.numbers(pose.rotation.coords.as_slice());
    }

    fn solid(&mut self, solid: &Solid) {
        let Some(soup) = solid.tessellation() else { return };
        soup.vertices.iter().for_each(|vertex| self.numbers(vertex.coords.as_slice()));
        soup.triangles.hash(&mut self.0);
    }

    fn world(&mut self, world: &World) {
        for body in world.bodies() {
            body.name.hash(&mut self.0);
            for part in &body.parts {
                self.pose(&part.world_from_solid);
                self.solid(&part.solid);
            }
        }
    }

    fn robot(&mut self, robot: &Robot) {
        (robot.name(), robot.joint_names(), robot.tip()).hash(&mut self.0);
        for limits in robot.limits() {
            let acceleration = limits.acceleration.unwrap_or(f64::NAN);
            self.numbers(&[limits.lower, limits.upper, limits.velocity, acceleration]);
        }
        // At values other than zero, where the poses depend on the attachments and the axes of all joints.
        let frames = robot.frames_at(&vec![0.3; robot.dof()]);
        for (index, link) in robot.links().iter().enumerate() {
            link.name.hash(&mut self.0);
            self.pose(frames.link(index));
            for shape in &link.collisions {
                self.pose(&shape.link_from_shape);
                self.solid(&shape.solid);
            }
        }
    }
}
