//! Planning scenes of MoveIt as the worlds of scenarios.

use std::path::Path;

use cranny_scenario::{Scenario, TargetPhysics, read_moveit_scene};
use pyo3::PyResult;

use crate::handover::fault::fault;

/// Returns the scenario with the collision objects of a planning scene (YAML) instead of its obstacles and floor. An object with
/// the target's name replaces the target.
pub fn with_scene(own: &Scenario, path: &Path) -> PyResult<Scenario> {
    let read = read_moveit_scene(path, &own.robot).map_err(fault)?;
    let target = own.target.map(|target| &own.world.bodies()[target]);
    let mut bodies = read.bodies().to_vec();
    let place = target.map(|target| {
        bodies.iter().position(|body| body.name == target.name).unwrap_or_else(|| {
            bodies.push(target.clone());
            bodies.len() - 1
        })
    });
    // A planning scene does not state the masses of objects.
    let is_kept = |name: &String| read.bodies().iter().all(|body| body.name != *name);
    let mut scenario = own.clone();
    scenario.sources.retain(|name, _| is_kept(name));
    scenario.physics.retain(|name, _| is_kept(name));
    let is_own = place.is_some_and(|place| place >= read.bodies().len());
    scenario.given_physics = if is_own { scenario.given_physics } else { TargetPhysics::default() };
    let world = scenario.world.with_bodies(bodies).map_err(fault)?;
    Ok(Scenario { world, target: place, export: None, ..scenario })
}
