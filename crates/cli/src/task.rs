use cranny_plan::{Criterion, Problem};
use cranny_scenario::{Demands, OpenOptions, Scenario};

use crate::arguments::TaskArguments;
use crate::failure::Failure;

/// A scenario and the problem that the flags make of it.
pub struct Task {
    pub scenario: Scenario,
    pub problem: Problem,
}

impl Task {
    pub fn open(arguments: &TaskArguments) -> Result<Self, Failure> {
        let options = OpenOptions {
            criterion: arguments.criterion.map(Criterion::from),
            robot: arguments.robot.clone(),
            geometry: arguments.geometry.map(Into::into),
        };
        let scenario = Scenario::open(&arguments.id, &options)?;
        let problem = scenario.problem(&Demands {
            margin_m: metres("margin", arguments.margin)?,
            grasp_margin_m: metres("grasp-margin", arguments.grasp_margin)?,
        })?;
        Ok(Self { scenario, problem })
    }
}

fn metres(flag: &'static str, millimetres: f64) -> Result<f64, Failure> {
    if millimetres.is_finite() && millimetres >= 0.0 {
        Ok(millimetres / 1000.0)
    } else {
        let problem = format!("'{millimetres}' is no clearance; give millimetres, at least 0");
        Err(Failure::Flag { flag, problem })
    }
}
