use std::fmt::Display;
use std::path::PathBuf;

use cranny_collision::Margins;
use cranny_record::{PlanFile, PlanSource};
use cranny_scenario::{Geometry, GivenGrasps, OpenOptions, Scenario, brief_model_notes};
use cranny_solve::PoseRadius;
use cranny_task::{Criterion, Problem};

use crate::arguments::{Output, TaskArguments};
use crate::failure::Failure;
use crate::progress::spinner;
use crate::text;

/// Scenario, and its problem with the settings of the flags.
pub struct Task {
    pub scenario: Scenario,
    pub problem: Problem,
    /// Source of both.
    pub source: PlanSource,
}

/// Settings used for flags that are not given. Default: those of the scenario, and no margins.
#[derive(Clone, Debug, Default)]
pub struct Demand {
    pub criterion: Option<Criterion>,
    pub robot: Option<PathBuf>,
    pub geometry: Option<Geometry>,
    pub grasps: GivenGrasps,
    /// File of grasps that a plan states and that does not exist.
    pub lost_grasps: Option<PathBuf>,
    pub margins: Margins,
    /// Required tolerance of the target's pose error.
    pub robust: Option<PoseRadius>,
}

impl Demand {
    /// Returns the settings that a plan was made for, with the scenario's own grasps if its file of grasps no longer exists.
    pub fn of_plan(plan: &PlanFile) -> Self {
        let (grasps, lost_grasps) = match plan.given_grasps() {
            GivenGrasps::File(file) if !file.is_file() => (GivenGrasps::Own, Some(file)),
            given => (given, None),
        };
        let (robot, geometry) = (plan.robot.clone().map(PathBuf::from), plan.given_geometry());
        let criterion = Some(plan.criterion);
        Self { criterion, robot, geometry, grasps, lost_grasps, margins: plan.margins, robust: None }
    }
}

impl Task {
    /// Opens the task of the flags, with the values of `otherwise` for the others.
    pub fn open(arguments: &TaskArguments, otherwise: Demand, output: Output) -> Result<Self, Failure> {
        let Demand { criterion, robot, geometry, grasps, lost_grasps, margins, robust } = otherwise;
        if let Some(file) = lost_grasps.filter(|_| arguments.grasps.is_none()) {
            let file = file.display();
            let own = "the scenario's own grasps take their place (--grasps FILE names others)";
            text::note(&format!("{file}: the plan's file of grasps does not exist here; {own}"))?;
        }
        let options = OpenOptions {
            criterion: arguments.criterion.map(Criterion::from).or(criterion),
            robot: arguments.robot.clone().or(robot),
            geometry: arguments.geometry.map(Into::into).or(geometry),
            grasps: arguments.grasps.clone().unwrap_or(grasps),
        };
        let scenario = open_scenario(&arguments.id, &options, output)?;
        // Margins are not checked under `paper`.
        let margins = if scenario.criterion == Criterion::Exact { margins } else { Margins::default() };
        let margins = cranny_record::margins_forgiving(&scenario, arguments.margins.or(margins), robust)
            .map_err(|_| {
                let problem = "the scenario has no target, so no target pose can be uncertain".to_owned();
                Failure::Flag { flag: "robust", problem }
            })?;
        let spinner = spinner("preparing the scenario", output.quiet);
        let problem = scenario.problem(margins);
        spinner.finish_and_clear();
        let mut problem = problem?;
        if arguments.strict_pairs {
            problem = problem.checking_all_pairs();
        }
        let OpenOptions { robot, geometry, grasps, .. } = options;
        let source =
            PlanSource { scenario: scenario.id.clone(), robot, geometry, grasps, margins, task: None };
        Ok(Self { scenario, problem, source })
    }
}

/// Opens a scenario and prints notes on repaired meshes and doubtful content.
pub fn open_scenario(id: &str, options: &OpenOptions, output: Output) -> Result<Scenario, Failure> {
    let spinner = spinner("opening the scenario", output.quiet);
    let scenario = Scenario::open(id, options);
    spinner.finish_and_clear();
    let scenario = scenario?;
    note_all(&brief_model_notes(&scenario.robot, &scenario.world), output)?;
    note_all(scenario.misplaced_grasps().as_slice(), output)?;
    note_all(&scenario.blind_views(), output)?;
    Ok(scenario)
}

/// Prints notes on standard error, unless `quiet` is set.
pub fn note_all(notes: &[impl Display], output: Output) -> Result<(), Failure> {
    for note in notes.iter().filter(|_| !output.quiet) {
        text::note(&note.to_string())?;
    }
    Ok(())
}
