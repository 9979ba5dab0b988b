use std::path::{Path, PathBuf};

use cranny_collision::Margins;
use cranny_grasp::GraspSet;
use cranny_record::{PlanFile, PlanSource, RecordError};
use cranny_robot::Robot;
use cranny_scenario::{MoveItOptions, MoveItProblem, Scenario, brief_model_notes};
use cranny_task::Problem;

use crate::arguments::{Output, TaskArguments};
use crate::failure::Failure;
use crate::planning::task::{Demand, Task, note_all};
use crate::text;

/// Planning task: a scenario, or a problem from external files.
pub struct PlanTask {
    pub source: PlanSource,
    /// Candidate grasps; empty if the goal is a configuration.
    pub grasps: GraspSet,
    pub problem: Problem,
    /// Deviations of the problem from its files, in sentences.
    pub deviations: Vec<String>,
    /// Maximum speed of the gripper frame that the files require, in m/s.
    pub tool_m_s: Option<f64>,
    /// Scenario of the task; `None` for a problem from external files.
    pub scenario: Option<Scenario>,
}

/// Reads the plan of a file; `None` for a file of bare way points.
pub fn read_plan(file: &Path) -> Result<Option<PlanFile>, RecordError> {
    let is_plan = file.extension().is_some_and(|extension| extension == "json");
    is_plan.then(|| PlanFile::read(file)).transpose()
}

impl PlanTask {
    /// Opens the task of the flags, with the values of `otherwise` for the others. `moveit` is a scene and a request, or empty.
    pub fn open(
        arguments: &TaskArguments,
        moveit: &[PathBuf],
        otherwise: Demand,
        output: Output,
    ) -> Result<Self, Failure> {
        if let [scene, request] = moveit {
            return Self::open_moveit([scene, request], arguments, otherwise.margins, output);
        }
        let Task { scenario, problem, source } = Task::open(arguments, otherwise, output)?;
        let (grasps, scenario) = (scenario.grasps.clone(), Some(scenario));
        let deviations = scenario.iter().filter_map(Scenario::seen_statement).collect();
        Ok(Self { source, grasps, problem, deviations, tool_m_s: None, scenario })
    }

    fn open_moveit(
        [scene, request]: [&PathBuf; 2],
        arguments: &TaskArguments,
        margins: Margins,
        output: Output,
    ) -> Result<Self, Failure> {
        let options = MoveItOptions { robot: arguments.robot.clone(), ..MoveItOptions::default() };
        let opened = MoveItProblem::open(scene, request, &options)?;
        // The JSON answer contains them too; the printed text gets them only here.
        let deviations: Vec<String> = opened.deviations.iter().map(ToString::to_string).collect();
        if output.json {
            note_all(&deviations, output)?;
        }
        note_all(&brief_model_notes(&opened.robot, &opened.world), output)?;
        let margins = Margins { grasp_margin_m: 0.0, ..arguments.margins.or(margins) };
        let mut problem = opened.problem(margins)?;
        if arguments.strict_pairs {
            problem = problem.checking_all_pairs();
        }
        let source = PlanSource {
            scenario: opened.id,
            robot: arguments.robot.clone(),
            margins,
            ..PlanSource::default()
        };
        let (grasps, tool_m_s) = (GraspSet::default(), opened.tool_speed_m_s);
        Ok(Self { source, grasps, problem, deviations, tool_m_s, scenario: None })
    }
}

/// Refuses a plan of a robot with other joints. Prints a note if the scenario of the plan is not the one that it is now "judged
/// against" or "shown in".
pub fn check_plan(
    file: &Path,
    plan: &PlanFile,
    robot: &Robot,
    scenario: &str,
    used: &str,
) -> Result<(), Failure> {
    plan.check_joints(file, robot)?;
    let planned = &plan.scenario;
    if planned == scenario {
        return Ok(());
    }
    let file = file.display();
    text::note(&format!("{file}: the plan was made for scenario '{planned}', and is {used} '{scenario}'"))
}
