//! Pictures and pages of scenarios and plans, as the bytes or the text of files.

use std::path::Path;

use cranny_collision::{Margins, World};
use cranny_scenario::Scenario;
use cranny_solve::{TaskTrajectory, ik_statuses};
use cranny_spatial::Pose;
use cranny_view::{
    Animation, PageCells, PageData, PagePlan, PageSettings, Picture, PictureSettings, SampledPath, Scene,
    SceneSettings, StandardView, TreeRecording, ViewError,
};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use strum::VariantArray as _;

use crate::classes::{PyPlan, PyScenario};
use crate::handover::fault::{bad_value, fault};
use crate::handover::interrupt::Interrupt;
use crate::handover::whole;

/// Sample rate of a path of which one frame is shown, in Hz.
const STILL_RATE_HZ: f64 = 20.0;

/// File name in errors for a picture in memory.
const IN_MEMORY: &str = "picture";

/// Maximum number of frames of a motion that is drawn at once.
const MOST_FRAMES: usize = 2000;

/// Returns a PNG of `scenario`; with `plan`, of its end and the path to it. `view`: "three-quarter", "front", "side" or "top".
/// `width` and `height` in pixels, 16 to 8192.
#[pyfunction]
#[pyo3(signature = (scenario, plan=None, *, view="three-quarter", width=960, height=720))]
pub fn picture<'py>(
    py: Python<'py>,
    scenario: &PyScenario,
    plan: Option<&Bound<'py, PyPlan>>,
    view: &str,
    #[pyo3(from_py_with = whole::width)] width: usize,
    #[pyo3(from_py_with = whole::height)] height: usize,
) -> PyResult<Bound<'py, PyBytes>> {
    let view = standard_view(view)?;
    let settings = PictureSettings { width, height, ..PictureSettings::default() };
    let plan = plan.map(Bound::get);
    let bytes = py.detach(|| {
        let scene = scene_of(&scenario.scenario, plan, STILL_RATE_HZ)?;
        let picture = Picture::of(&scene, view, &settings).map_err(fault)?;
        picture.png(Path::new(IN_MEMORY)).map_err(fault)
    })?;
    Ok(PyBytes::new(py, &bytes))
}

/// Returns an animated PNG of `plan` in `scenario`, at `rate` frames per second, 1 to 50.
#[pyfunction]
#[pyo3(signature = (scenario, plan, *, view="three-quarter", width=640, height=480, rate=10))]
pub fn moving_picture<'py>(
    py: Python<'py>,
    scenario: &PyScenario,
    plan: &Bound<'py, PyPlan>,
    view: &str,
    #[pyo3(from_py_with = whole::width)] width: usize,
    #[pyo3(from_py_with = whole::height)] height: usize,
    #[pyo3(from_py_with = whole::rate)] rate: u16,
) -> PyResult<Bound<'py, PyBytes>> {
    let view = standard_view(view)?;
    let settings = PictureSettings { width, height, ghosts: 0, ..PictureSettings::default() };
    let mut interrupt = Interrupt::new();
    let plan = plan.get();
    let bytes = py.detach(|| -> PyResult<Vec<u8>> {
        let scene = scene_of(&scenario.scenario, Some(plan), f64::from(rate))?;
        let Some(last) = scene.last_frame() else { return Err(bad_value("the plan has no path to show")) };
        if last >= MOST_FRAMES {
            return Err(bad_value(format!(
                "{last} pictures, but at most {MOST_FRAMES} are drawn: lower the rate"
            )));
        }
        let mut pictures = Vec::new();
        let frames: Vec<usize> = (0..=last).collect();
        // In small batches, so that Ctrl-C is handled between them.
        for some in frames.chunks(8) {
            pictures.extend(
                Animation::draw(&scene, view, &settings, some, |_, picture| Ok(picture)).map_err(fault)?,
            );
            if interrupt.asks() {
                return Ok(Vec::new());
            }
        }
        let file = tempfile::NamedTempFile::new().map_err(fault)?;
        Animation { pictures, rate_hz: rate }.write_apng(file.path()).map_err(fault)?;
        cranny_file::head(file.path(), u64::MAX).map_err(fault)
    });
    interrupt.result()?;
    Ok(PyBytes::new(py, &bytes?))
}

/// Returns the viewer with `scenario`, and with `plan` if given, as one HTML document; None if the package lacks the viewer.
#[pyfunction]
#[pyo3(signature = (scenario, plan=None))]
pub fn page(
    py: Python<'_>,
    scenario: &PyScenario,
    plan: Option<&Bound<'_, PyPlan>>,
) -> PyResult<Option<String>> {
    let plan = plan.map(Bound::get);
    let html = py.detach(|| page_of(scenario, plan, None).map(|(page, _)| page.html()));
    match html? {
        Err(ViewError::NoPage) => Ok(None),
        html => html.map(Some).map_err(fault),
    }
}

/// Returns the content of the viewer's page of a scenario, with the search trees of a single plan if known, and the cells in
/// which it checks configurations.
pub fn page_of(
    scenario: &PyScenario,
    plan: Option<&PyPlan>,
    search_tree: Option<TreeRecording>,
) -> PyResult<(PageData, PageCells)> {
    let shown = &scenario.scenario;
    let exact = scenario.exact_problem(Margins::default())?;
    let cell = exact.cell().ok_or_else(|| bad_value("the scenario has no exact cell"))?;
    let page_plan = match plan {
        None => None,
        Some(plan) => {
            check_shown(shown, plan)?;
            let timed = timed_in(shown, plan)?;
            let verification = plan.judge().map_err(fault)?.map(|judgement| judgement.audit);
            let along = match plan.file.task.len() {
                0 | 1 => None,
                _ => plan.file.states(&plan.task.problem).map_err(fault)?,
            };
            let states = along.map_or_else(Vec::new, |along| along.states);
            let page =
                PagePlan::of_file("plan", &plan.file, &shown.robot, timed.as_ref(), verification, states);
            Some(PagePlan { search_tree, ..page.map_err(fault)? })
        }
    };
    let statuses = ik_statuses(&exact, &shown.ik).map_err(fault)?;
    let page =
        PageData::of(shown, page_plan.as_slice(), cell, &statuses, PageSettings::default()).map_err(fault)?;
    Ok((page, PageCells::of(cell.clone(), page_plan.as_slice())))
}

/// Checks that a plan was made for the world in which it is shown.
fn check_shown(scenario: &Scenario, plan: &PyPlan) -> PyResult<()> {
    let planned = plan.task.scenario.as_deref();
    if planned.is_none_or(|planned| stand_alike(&planned.world, &scenario.world)) {
        return Ok(());
    }
    Err(bad_value(format!(
        "plan: it was planned for '{}', whose world differs from that of '{}' (Plan.load(path, scenario) \
         judges it there)",
        plan.file.scenario, scenario.id
    )))
}

/// Returns true if all bodies of two worlds have the same poses.
fn stand_alike(a: &World, b: &World) -> bool {
    let poses = |world: &World| -> Vec<Pose> {
        world.bodies().iter().flat_map(|body| body.parts.iter().map(|part| part.world_from_solid)).collect()
    };
    poses(a) == poses(b)
}

fn scene_of(scenario: &Scenario, plan: Option<&PyPlan>, rate_hz: f64) -> PyResult<Scene> {
    let path = match plan {
        None => None,
        Some(plan) => {
            check_shown(scenario, plan)?;
            let timed = timed_in(scenario, plan)?;
            SampledPath::of_plan(&scenario.robot, &plan.file, timed.as_ref(), rate_hz).map_err(fault)?
        }
    };
    Scene::of_task(scenario, path.as_ref(), &SceneSettings::default()).map_err(fault)
}

/// Returns the trajectory of a plan, after checking that it is for the robot of the scenario.
fn timed_in(scenario: &Scenario, plan: &PyPlan) -> PyResult<Option<TaskTrajectory>> {
    plan.file.check_joints(Path::new(IN_MEMORY), &scenario.robot).map_err(fault)?;
    plan.file.trajectory(&scenario.robot).map_err(fault)
}

fn standard_view(name: &str) -> PyResult<StandardView> {
    let known = || StandardView::VARIANTS.iter().map(|view| view.name()).collect::<Vec<_>>().join(", ");
    name.parse().map_err(|_| bad_value(format!("unknown view '{name}' (known: {})", known())))
}
