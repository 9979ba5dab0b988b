use std::path::{Path, PathBuf};

use cranny_collision::Margins;
use cranny_path::{Audit, AuditSettings, audit};
use cranny_plan::Registry;
use cranny_record::{Judgement, PlanFile, PlanSource, read_waypoints};
use cranny_scenario::{Geometry, GivenGrasps, OpenOptions, Scenario};
use cranny_solve::{Timing, ik_statuses};
use cranny_task::{Criterion, Problem};
use cranny_view::{PageCells, PageData, PagePlan, PageSettings};

use crate::arguments::Output;
use crate::choices::GeometryArgument;
use crate::failure::Failure;
use crate::planning::plan_task::{check_plan, read_plan};
use crate::planning::task::open_scenario;
use crate::{physics::recording, pictures::search_replay, progress, text};

/// Content of a viewer page.
pub struct PageRequest<'a> {
    /// Scenario id, or the file of a recording.
    pub id: &'a str,
    /// Plan files or way points.
    pub plans: &'a [PathBuf],
    pub robot: Option<&'a Path>,
    pub geometry: Option<GeometryArgument>,
    /// Criterion for bare way points; `None` for the scenario's own.
    pub criterion: Option<Criterion>,
    /// Allowed goal grasps, instead of those that the plans name.
    pub grasps: GivenGrasps,
    /// Registry of the planners that repeat the searches, if their trees are shown.
    pub search_trees: Option<&'a Registry>,
}

/// Page, and the cells in which configurations are checked if it has a robot.
pub struct PageTask {
    pub page: PageData,
    pub cells: Option<PageCells>,
}

impl PageTask {
    pub fn open(request: &PageRequest, output: Output) -> Result<Self, Failure> {
        if let Some(file) = recording::file_of(request.id) {
            let recording = recording::read(
                file,
                &[
                    ("--robot", request.robot.is_some()),
                    ("--geometry", request.geometry.is_some()),
                    ("--search-tree", request.search_trees.is_some()),
                    ("the plan", !request.plans.is_empty()),
                ],
            )?;
            return Ok(Self { page: PageData::of_recording(&recording), cells: None });
        }
        let files = request
            .plans
            .iter()
            .map(|file| read_plan(file))
            .collect::<Result<Vec<_>, cranny_record::RecordError>>()?;
        let read = || files.iter().flatten();
        let robot_of = |plan: &PlanFile| plan.robot.clone().map(PathBuf::from);
        let options = OpenOptions {
            criterion: request.criterion,
            robot: request.robot.map(Path::to_owned).or_else(|| read().find_map(robot_of)),
            geometry: request
                .geometry
                .map(Geometry::from)
                .or_else(|| read().find_map(PlanFile::given_geometry)),
            grasps: read().map(PlanFile::given_grasps).fold(request.grasps.clone(), GivenGrasps::or),
        };
        let OpenOptions { robot, geometry, grasps, .. } = options.clone();
        let mut source = PlanSource { robot, geometry, grasps, ..PlanSource::default() };
        let mut tasks = Tasks { id: request.id, options, opened: Vec::new(), problems: Vec::new(), output };
        let own = tasks.open(None)?;
        let shown = tasks.open(Some(Criterion::Exact))?;
        source.scenario.clone_from(&shown.id);
        let exact = tasks.problem(Criterion::Exact, Margins::default(), None)?;
        let cell = exact.cell().ok_or(cranny_task::TaskError::Annotation)?;
        let mut plans = Vec::new();
        for (file, read) in request.plans.iter().zip(&files) {
            let name = file.file_name().unwrap_or(file.as_os_str()).to_string_lossy().into_owned();
            let robot = &shown.robot;
            let Some(plan) = read else {
                let waypoints = read_waypoints(file, robot.dof())?;
                let problem = tasks.problem(own.criterion, Margins::default(), None)?;
                let trajectory = Timing::default().along(robot, &waypoints)?;
                let verification = Some(audit(&problem, &waypoints)?);
                let path =
                    PagePlan::of_waypoints(name, &waypoints, robot, trajectory.as_ref(), verification)?;
                plans.push(path);
                continue;
            };
            check_plan(file, plan, &shown.robot, &shown.id, "shown in")?;
            let problem = tasks.problem(plan.criterion, plan.margins, plan.goal_threshold)?;
            let timed = plan.trajectory(robot)?;
            let task = plan.source_in(&shown, &PlanSource { margins: plan.margins, ..source.clone() });
            let verification = verdict(file, plan.judge(&task, &problem, AuditSettings::default())?)?;
            let along = if plan.task.len() > 1 { plan.states(&problem)? } else { None };
            let states = along.map_or_else(Vec::new, |along| along.states);
            let mut shown_plan = PagePlan::of_file(name, plan, robot, timed.as_ref(), verification, states)?;
            if let Some(registry) = request.search_trees {
                let tree = search_replay::replay(file, plan, &problem, registry, output)?;
                shown_plan.search_tree = Some(tree);
            }
            plans.push(shown_plan);
        }
        let spinner = progress::spinner("measuring clearance and inverse kinematics", output.quiet);
        let statuses = ik_statuses(&exact, &shown.ik)?;
        let page = PageData::of(&shown, &plans, cell, &statuses, PageSettings::default())?;
        spinner.finish_and_clear();
        Ok(Self { page, cells: Some(PageCells::of(cell.clone(), &plans)) })
    }
}

/// Returns the verdict on a plan, and prints a note for each statement of its file that differs from the measurement.
fn verdict(file: &Path, judgement: Option<Judgement>) -> Result<Option<Audit>, Failure> {
    for statement in judgement.iter().flat_map(|judgement| &judgement.differs) {
        text::note(&format!("{}: {statement}", file.display()))?;
    }
    Ok(judgement.map(|judgement| judgement.audit))
}

/// Scenario and its problems, each created once.
struct Tasks<'a> {
    id: &'a str,
    options: OpenOptions,
    opened: Vec<Scenario>,
    problems: Vec<((Criterion, Margins), Problem)>,
    output: Output,
}

impl Tasks<'_> {
    /// Opens the scenario under a criterion; reuses an already opened one with that criterion.
    fn open(&mut self, criterion: Option<Criterion>) -> Result<Scenario, Failure> {
        let is_it = |scenario: &&Scenario| criterion.is_none_or(|criterion| scenario.criterion == criterion);
        if let Some(known) = self.opened.iter().find(is_it) {
            return Ok(known.clone());
        }
        let options = OpenOptions { criterion, ..self.options.clone() };
        // Notes on a scenario are printed once.
        let scenario = match self.opened.first() {
            Some(_) => Scenario::open(self.id, &options)?,
            None => open_scenario(self.id, &options, self.output)?,
        };
        self.opened.push(scenario.clone());
        Ok(scenario)
    }

    fn problem(
        &mut self,
        criterion: Criterion,
        margins: Margins,
        goal_threshold: Option<f64>,
    ) -> Result<Problem, Failure> {
        let known = self.problems.iter().find(|(key, _)| *key == (criterion, margins));
        let mut problem = if let Some((_, problem)) = known {
            problem.clone()
        } else {
            let problem = self.open(Some(criterion))?.problem(margins)?;
            self.problems.push(((criterion, margins), problem.clone()));
            problem
        };
        if let Some(threshold) = goal_threshold {
            problem = problem.with_goal_threshold(threshold);
        }
        Ok(problem)
    }
}
