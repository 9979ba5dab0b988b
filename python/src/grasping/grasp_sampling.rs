//! `sample_grasps`: antipodal grasps of a mesh.

use std::path::PathBuf;
use std::sync::Mutex;

use cranny_grasp::{
    COVERAGE_THRESHOLD, GraspSet, SampledGrasp, SamplerSettings, covering_subset, sample_grasps as sample,
};
use cranny_scenario::{DEFAULT_FRICTION, filter_around_object, panda_hand, read_gripper};
use cranny_shape::Surface;
use cranny_task::APPROACH_M;
use pyo3::prelude::*;

use crate::grasping::grasp_set::PyGrasps;
use crate::handover::array::triangles;
use crate::handover::fault::{bad_value, fault};
use crate::handover::interrupt::Interrupt;
use crate::handover::whole;

/// Maximum number of grasps; more would be a mistake, because they are compared with each other.
const MOST_GRASPS: usize = 1_000_000;

/// Maximum number of directions about one axis; more would be a mistake.
const MOST_APPROACHES: usize = 360;

/// Samples antipodal grasps of an object, scored by the friction that they need, and chooses `count` of them that lie near as
/// many as possible of all `candidates` (by default ten times as many).
///
/// `mesh`: a `trimesh.Trimesh`, any object with `vertices` and `faces`, or a pair of arrays (V, 3) in metres and (F, 3) of
/// indices. `gripper`: a YAML file; by default the hand of the built-in robot. `friction`: the coefficient between pads and
/// object. `approaches`: directions about each closing axis. Unless `bare`, only grasps that the open hand can reach without
/// collision, along the last `approach_m` (m) in a straight line. The same `seed` gives the same grasps on any number of
/// threads. Poses are in the frame of the mesh.
#[pyfunction]
#[pyo3(
    signature = (mesh, gripper=None, *, count=200, candidates=None, friction=DEFAULT_FRICTION, approaches=12,
        approach_m=APPROACH_M, bare=false, seed=0),
    text_signature = "(mesh, gripper=None, *, count=200, candidates=None, friction=0.35, approaches=12, \
        approach_m=0.05, bare=False, seed=0)"
)]
#[allow(clippy::too_many_arguments, reason = "the keywords of the Python function")]
pub fn sample_grasps(
    mesh: &Bound<'_, PyAny>,
    gripper: Option<PathBuf>,
    #[pyo3(from_py_with = whole::count)] count: usize,
    #[pyo3(from_py_with = whole::candidates)] candidates: Option<usize>,
    friction: f64,
    #[pyo3(from_py_with = whole::approaches)] approaches: usize,
    approach_m: f64,
    bare: bool,
    #[pyo3(from_py_with = whole::seed)] seed: u64,
) -> PyResult<PyGrasps> {
    let py = mesh.py();
    let wished = candidates.unwrap_or(count.saturating_mul(10)).max(count);
    for (what, value, most) in [("count", wished, MOST_GRASPS), ("approaches", approaches, MOST_APPROACHES)] {
        if value > most {
            return Err(bad_value(format!("{what} is {value}, but at most {most} is allowed")));
        }
    }
    let mesh = triangles(mesh)?;
    let hand = match gripper {
        Some(path) => read_gripper(&path).map_err(fault)?,
        None => panda_hand().map_err(fault)?,
    };
    let interrupt = Mutex::new(Interrupt::new());
    let found = py.detach(|| -> PyResult<GraspSet> {
        let surface = Surface::new(&mesh).map_err(fault)?;
        let settings = SamplerSettings {
            count: wished,
            friction,
            opening_m: hand.opening_m,
            approaches,
            // Rejects early what the filter of the hand would reject anyway.
            finger_depth_m: Some(hand.finger_depth_m).filter(|depth_m| !bare && *depth_m > 0.0),
            seed,
            ..SamplerSettings::default()
        };
        let filter = || filter_around_object(&hand, &mesh, &surface, Vec::new(), approach_m).map_err(fault);
        let filter = if bare { None } else { Some(filter()?) };
        let accept = |sampled: &SampledGrasp| filter.as_ref().is_none_or(|f| f.is_free(&sampled.grasp));
        let found = sample(&surface, &settings, &accept, &mut |_| {
            !interrupt.lock().is_ok_and(|mut interrupt| interrupt.asks())
        });
        let grasps: Vec<_> = found.map_err(fault)?.grasps.iter().map(|sampled| sampled.grasp).collect();
        let chosen = covering_subset(&grasps, count, COVERAGE_THRESHOLD);
        GraspSet::new(chosen.into_iter().map(|index| grasps[index]).collect()).map_err(fault)
    });
    if let Ok(interrupt) = interrupt.into_inner() {
        interrupt.result()?;
    }
    Ok(PyGrasps { set: found? })
}
