//! Space that cameras have seen, as obstacles.

use cranny_scenario::SeenOptions;
use cranny_sense::{Unseen, View};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::classes::PyScenario;
use crate::handover::array::copied;
use crate::handover::fault::{bad_value, fault};
use crate::handover::pickled::{Made, partial};
use crate::sensing::cloud::box_of;
use crate::sensing::depth_view::PyDepthView;

/// Returns a scenario with a map of the space that these views show as further obstacles, for `World`.
#[pyfunction]
#[pyo3(name = "_with_views", signature = (scenario, views, *, unseen="solid", cell_m=None, fine_m=None, region=None, robot_reach_m=None,
    floor_reach_m=None, tolerance_m=None))]
#[allow(clippy::too_many_arguments, reason = "the keywords of the Python function")]
pub fn with_views<'py>(
    scenario: &Bound<'py, PyScenario>,
    views: Vec<Bound<'py, PyDepthView>>,
    unseen: &str,
    cell_m: Option<f64>,
    fine_m: Option<f64>,
    region: Option<&Bound<'py, PyAny>>,
    robot_reach_m: Option<f64>,
    floor_reach_m: Option<f64>,
    tolerance_m: Option<f64>,
) -> PyResult<PyScenario> {
    let py = scenario.py();
    let default = SeenOptions::default();
    let options = SeenOptions {
        unseen: match unseen {
            "solid" => Unseen::Solid,
            "free" => Unseen::Free,
            _ => {
                return Err(bad_value(format!(
                    "unseen is '{unseen}', but \"solid\" or \"free\" is expected"
                )));
            }
        },
        cell_m: cell_m.unwrap_or(default.cell_m),
        fine_m: fine_m.unwrap_or(default.fine_m),
        region: region.map(box_of).transpose()?,
        robot_reach_m: robot_reach_m.unwrap_or(default.robot_reach_m),
        floor_reach_m: floor_reach_m.unwrap_or(default.floor_reach_m),
        tolerance_m: tolerance_m.unwrap_or(default.tolerance_m),
    };
    let own = &scenario.get().scenario;
    let all: Vec<View> = views.iter().map(|view| view.get().view.clone()).collect();
    let seen = py.detach(|| own.with_seen(&all, &options)).map_err(fault)?;
    let keywords = PyDict::new(py);
    keywords.set_item("unseen", unseen)?;
    keywords.set_item("region", region.map(copied).transpose()?)?;
    for (key, value) in [
        ("cell_m", cell_m),
        ("fine_m", fine_m),
        ("robot_reach_m", robot_reach_m),
        ("floor_reach_m", floor_reach_m),
        ("tolerance_m", tolerance_m),
    ] {
        keywords.set_item(key, value)?;
    }
    let function = py.import("cranny._cranny")?.getattr("_with_views")?;
    let made = Made::by(partial(&function, &keywords)?, (scenario, views))?;
    Ok(PyScenario { made, ..PyScenario::with(scenario, seen) })
}
