use std::fmt::Display;

use cranny_collision::Margins;
use cranny_plan::{Criterion, Problem};
use cranny_scenario::{OpenOptions, Scenario, mesh_repairs};

use crate::arguments::{Output, TaskArguments};
use crate::failure::Failure;
use crate::text;

/// A scenario and the problem that the flags make of it.
pub struct Task {
    pub scenario: Scenario,
    pub problem: Problem,
    pub margins: Margins,
}

impl Task {
    /// What the flags say; where they are silent the given criterion and margins, else the defaults.
    pub fn open(
        arguments: &TaskArguments,
        criterion: Option<Criterion>,
        margins: Margins,
        output: Output,
    ) -> Result<Self, Failure> {
        let options = OpenOptions {
            criterion: arguments.criterion.map(Criterion::from).or(criterion),
            robot: arguments.robot.clone(),
            geometry: arguments.geometry.map(Into::into),
            grasps: arguments.grasps.clone(),
        };
        let scenario = open_scenario(&arguments.id, &options, output)?;
        let margins = arguments.margins.or(margins);
        let mut problem = scenario.problem(margins)?;
        if arguments.strict_pairs {
            problem = problem.checking_all_pairs();
        }
        Ok(Self { scenario, problem, margins })
    }
}

/// A scenario; the user is told what had to be repaired in its meshes.
pub fn open_scenario(id: &str, options: &OpenOptions, output: Output) -> Result<Scenario, Failure> {
    let scenario = Scenario::open(id, options)?;
    note_all(&mesh_repairs(&scenario.robot, &scenario.world), output)?;
    Ok(scenario)
}

/// Tells the user, who may have asked for quiet, on standard error.
pub fn note_all(notes: &[impl Display], output: Output) -> Result<(), Failure> {
    for note in notes.iter().filter(|_| !output.quiet) {
        text::note(&note.to_string())?;
    }
    Ok(())
}
