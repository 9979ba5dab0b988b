use std::io::Write;
use std::path::PathBuf;

use cranny_grasp::GraspSet;
use cranny_plan::Problem;
use cranny_scenario::{Demands, MoveItOptions, MoveItProblem, PlanMargins};

use crate::arguments::{Output, PlanArguments, TaskArguments};
use crate::failure::Failure;
use crate::task::{Task, metres};

/// What is planned: a scenario, or a problem in other people's files.
pub struct PlanTask {
    /// What the plan says it is of.
    pub id: String,
    /// What can be grasped; nothing where the goal is a configuration.
    pub grasps: GraspSet,
    pub problem: Problem,
    pub margins: PlanMargins,
}

impl PlanTask {
    pub fn open(arguments: &PlanArguments, output: Output) -> Result<Self, Failure> {
        if let [scene, request] = &arguments.moveit[..] {
            return Self::open_moveit([scene, request], &arguments.task, output);
        }
        let Task { scenario, problem, margins } = Task::open(&arguments.task, None, PlanMargins::default())?;
        Ok(Self { id: scenario.id, grasps: scenario.grasps, problem, margins })
    }

    fn open_moveit(
        [scene, request]: [&PathBuf; 2],
        arguments: &TaskArguments,
        output: Output,
    ) -> Result<Self, Failure> {
        let options = MoveItOptions { robot: arguments.robot.clone(), ..MoveItOptions::default() };
        let opened = MoveItProblem::open(scene, request, &options)?;
        if !output.quiet {
            for deviation in &opened.deviations {
                writeln!(std::io::stderr(), "note: {deviation}")?;
            }
        }
        let margin_m = metres("margin", arguments.margin)?.unwrap_or_default();
        let demands = Demands { margin_m, ..Demands::default() };
        Ok(Self {
            problem: opened.problem(&demands)?,
            id: opened.id,
            grasps: GraspSet::default(),
            margins: PlanMargins { margin_m, ..PlanMargins::default() },
        })
    }
}
