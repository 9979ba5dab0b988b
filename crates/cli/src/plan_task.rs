use std::path::PathBuf;

use cranny_grasp::GraspSet;
use cranny_plan::{Criterion, Problem};
use cranny_scenario::{Demands, MoveItOptions, MoveItProblem, PlanMargins, mesh_repairs};

use crate::arguments::{Output, TaskArguments};
use crate::failure::Failure;
use crate::task::{Task, metres, note_all};

/// What is planned or judged: a scenario, or a problem in other people's files.
pub struct PlanTask {
    /// What the plan says it is of.
    pub id: String,
    /// What can be grasped; nothing where the goal is a configuration.
    pub grasps: GraspSet,
    pub problem: Problem,
    pub margins: PlanMargins,
}

impl PlanTask {
    /// What the flags say, `moveit` being a scene and a request or nothing; where they are silent the given
    /// criterion and margins, else the defaults.
    pub fn open(
        arguments: &TaskArguments,
        moveit: &[PathBuf],
        criterion: Option<Criterion>,
        margins: PlanMargins,
        output: Output,
    ) -> Result<Self, Failure> {
        if let [scene, request] = moveit {
            return Self::open_moveit([scene, request], arguments, margins, output);
        }
        let Task { scenario, problem, margins } = Task::open(arguments, criterion, margins, output)?;
        Ok(Self { id: scenario.id, grasps: scenario.grasps, problem, margins })
    }

    fn open_moveit(
        [scene, request]: [&PathBuf; 2],
        arguments: &TaskArguments,
        margins: PlanMargins,
        output: Output,
    ) -> Result<Self, Failure> {
        let options = MoveItOptions { robot: arguments.robot.clone(), ..MoveItOptions::default() };
        let opened = MoveItProblem::open(scene, request, &options)?;
        note_all(&opened.deviations, output)?;
        note_all(&mesh_repairs(&opened.robot, &opened.world), output)?;
        let margin_m = metres("margin", arguments.margin)?.unwrap_or(margins.margin_m);
        let demands = Demands { margin_m, ..Demands::default() };
        let mut problem = opened.problem(&demands)?;
        if arguments.strict_pairs {
            problem = problem.checking_all_pairs();
        }
        Ok(Self {
            problem,
            id: opened.id,
            grasps: GraspSet::default(),
            margins: PlanMargins { margin_m, ..PlanMargins::default() },
        })
    }
}
