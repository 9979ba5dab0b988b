//! Plans of several steps: one file of all.

use std::path::PathBuf;

use cranny_scenario::{PlanFile, SequencePlan};
use pyo3::prelude::*;

use crate::fault::{bad_value, fault};
use crate::plan::PyPlan;
use crate::scenario::PyScenario;
use crate::task::Task;

/// Writes the plans of the steps of `scenario`, in their order, as one `.plan.json`, as a whole or not at all.
#[pyfunction]
#[pyo3(name = "_save_steps")]
pub fn save_steps(path: PathBuf, scenario: &PyScenario, plans: Vec<Bound<'_, PyPlan>>) -> PyResult<()> {
    let files = plans.iter().map(|plan| plan.get().file.clone()).collect();
    SequencePlan::of(&scenario.scenario, files).write(&path).map_err(fault)
}

/// Reads such a file; each plan is judged anew in the world that those before it leave, up to the first that does not hold.
#[pyfunction]
#[pyo3(name = "_load_steps", signature = (path, scenario=None))]
pub fn load_steps<'py>(
    py: Python<'py>,
    path: PathBuf,
    scenario: Option<Bound<'py, PyScenario>>,
) -> PyResult<(Bound<'py, PyScenario>, Vec<Bound<'py, PyPlan>>)> {
    let read = SequencePlan::read(&path).map_err(fault)?;
    let read = read.ok_or_else(|| {
        bad_value(format!("{}: no plan of several steps (one of one is for Plan.load)", path.display()))
    })?;
    let scenario = match scenario {
        Some(scenario) => scenario,
        None => py.get_type::<PyScenario>().call1((&read.scenario,))?.cast_into()?,
    };
    let plans = judged(&scenario, read.steps)?;
    Ok((scenario, plans))
}

/// Plans as those of the steps of `scenario`, each judged anew in the world that those before it leave, up to the first that
/// does not hold.
#[pyfunction]
#[pyo3(name = "_judged_steps")]
pub fn judged_steps<'py>(
    scenario: &Bound<'py, PyScenario>,
    plans: Vec<Bound<'py, PyPlan>>,
) -> PyResult<Vec<Bound<'py, PyPlan>>> {
    judged(scenario, plans.iter().map(|plan| plan.get().file.clone()).collect())
}

fn judged<'py>(scenario: &Bound<'py, PyScenario>, files: Vec<PlanFile>) -> PyResult<Vec<Bound<'py, PyPlan>>> {
    let py = scenario.py();
    let (mut now, mut plans) = (scenario.clone(), Vec::new());
    let steps = scenario.get().scenario.steps.clone();
    if files.len() > steps.len() {
        let (more, all) = (files.len(), steps.len());
        return Err(bad_value(format!("{more} plans of steps, but the scenario has {all} steps")));
    }
    for (step, file) in steps.iter().zip(files) {
        step.check(&file).map_err(fault)?;
        let of_step = now.call_method1("with_target", (&step.pick,))?;
        let mut task = Task::of(&of_step, file.margins)?;
        // Grasps are given for the scenario's own target alone: of another object a plan states that none are, or what all
        // steps were planned with.
        let of_all = &scenario.get().given_grasps;
        let is_of_all =
            !of_step.cast::<PyScenario>()?.get().scenario.has_grasp_set && file.given_grasps() == *of_all;
        if is_of_all {
            task.source.grasps = of_all.clone();
        }
        let plan = Bound::new(py, PyPlan::judged(py, task, file)?)?;
        let is_valid = plan.get().is_valid;
        if is_valid {
            now = now.call_method1("after", (&plan,))?.cast_into()?;
        }
        plans.push(plan);
        if !is_valid {
            break;
        }
    }
    Ok(plans)
}
