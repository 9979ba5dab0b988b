use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use cranny_collision::Margins;
use cranny_explore::{CameraKind, ExploreSettings, Explored, ViewReport, explore, true_contact};
use cranny_file::counted;
use cranny_path::AuditSettings;
use cranny_plan::{Outcome, Registry};
use cranny_record::{PlanFile, PlanOptions, PlanSource};
use cranny_scenario::{
    OpenOptions, Recipe, Scenario, ScenarioError, SeenOptions, check_free_folder, write_whole_file,
    write_whole_folder,
};
use cranny_sense::{CameraFile, CameraFrame, DepthFormat};
use cranny_task::Problem;
use serde::Serialize;

use crate::Answer;
use crate::arguments::{Output, PlanArguments};
use crate::failure::Failure;
use crate::planning::explore_arguments::CameraArgument;
use crate::planning::obstruction::{Obstruction, position_of, text_of};
use crate::planning::plan_request::ask;
use crate::planning::task::{Demand, Task};
use crate::progress::{SearchProgress, stop_on_interrupt};
use crate::text::{self, at_least_mm};

/// Output of `plan --explore --json`.
#[derive(Serialize)]
struct Answered<'a> {
    scenario: &'a str,
    solved: bool,
    /// True if Ctrl-C ended it, after which nothing is written.
    stopped: bool,
    views: Vec<SeenView>,
    /// Judgement of the plan in the true scenario; `None` without a plan.
    true_scene: Option<TrueScene>,
    folder: Option<&'a Path>,
    plan_file: Option<&'a Path>,
    plan: &'a PlanFile,
}

#[derive(Serialize)]
struct SeenView {
    name: String,
    position_m: [f64; 3],
    quaternion_xyzw: [f64; 4],
    /// In hand: proven path from the start to the configuration of the view (m, rad).
    #[serde(skip_serializing_if = "Vec::is_empty")]
    waypoints: Vec<Vec<f64>>,
    free_m3: f64,
    occupied_m3: f64,
    unseen_m3: f64,
    outcome: Outcome,
    #[serde(flatten)]
    obstruction: Option<Obstruction>,
}

#[derive(Serialize)]
struct TrueScene {
    free: bool,
    /// First contact, or another fault.
    fault: Option<String>,
}

/// Name of the plan in the folder.
const PLAN: &str = "plan.json";

pub fn run(arguments: &PlanArguments, registry: &Registry, output: Output) -> Result<Answer, Failure> {
    let asked = &arguments.explore;
    arguments.output.as_deref().map_or(Ok(()), check_free_folder)?;
    let margins = arguments.task.margins.or(Margins::default());
    let Task { scenario: truth, problem, source } =
        Task::open(&arguments.task, Demand { margins, ..Demand::default() }, output)?;
    let place = arguments.output.clone().unwrap_or_else(|| PathBuf::from(format!("{}.explored", truth.id)));
    check_free_folder(&place)?;
    // A scenario that cannot be written is refused before the search.
    Recipe::of_scenario(&truth.with_known_bodies_only(&asked.known)?)?;
    let options = PlanOptions { registry: registry.clone(), ..ask(arguments, problem.robot().dof())? };
    let (request, _) = options.request(&problem, Some(&truth))?;
    let cameras = asked.cameras.as_deref().map(CameraFile::read).transpose()?;
    let settings = ExploreSettings {
        views: asked.views.unwrap_or(8),
        cameras: cameras.map_or_else(Vec::new, |file| file.cameras),
        kind: match asked.camera {
            Some(CameraArgument::Hand) => CameraKind::Hand,
            Some(CameraArgument::Fixed) | None => CameraKind::Fixed,
        },
        noise_seed: asked.noise_seed,
        margins: source.margins,
        request,
        known: asked.known.clone(),
        options: SeenOptions::default(),
    };
    if settings.kind == CameraKind::Hand
        && settings.cameras.iter().all(|camera| camera.frame == CameraFrame::World)
    {
        let problem = "no camera is on a link of the robot; give a file of --cameras with `frame: link NAME`";
        return Err(Failure::Flag { flag: "camera", problem: problem.to_owned() });
    }
    let mut progress = SearchProgress::new(output.quiet, stop_on_interrupt());
    let (mut number, is_page) = (0, !output.quiet && !output.json);
    let mut fault = None;
    let explored = explore(&truth, &settings, &mut progress, &mut |report| {
        number += 1;
        if is_page {
            fault = text::print(&view_lines(number, report, &problem)).err().or(fault.take());
        }
    });
    progress.finish();
    let explored = explored?;
    if let Some(fault) = fault {
        return Err(fault);
    }
    let solved = explored.answer.is_solved();
    let id = place.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let in_folder = PlanSource { scenario: id, margins: source.margins, ..PlanSource::default() };
    let plan = PlanFile::of(&explored.answer, &in_folder);
    let stopped = explored.answer.outcome == Outcome::Cancelled;
    // The same command begins again.
    let is_written = solved || (arguments.output.is_some() && !stopped);
    let plan_file = place.join(PLAN);
    if is_written {
        write(&explored, &settings, &truth, &plan, &place)?;
    }
    let is_proven = solved && is_valid_in(&place, &plan, &in_folder)?;
    let true_scene = if solved {
        let fault = true_contact(&problem, &explored.answer)?;
        Some(TrueScene { free: fault.is_none(), fault })
    } else {
        None
    };
    let answered = Answered {
        scenario: &truth.id,
        solved: is_proven,
        stopped,
        views: explored.reports.iter().map(|report| SeenView::of(report, &problem)).collect(),
        true_scene,
        folder: is_written.then_some(place.as_path()),
        plan_file: is_written.then_some(plan_file.as_path()),
        plan: &plan,
    };
    text::answer(&answered, || page(&answered, &explored), output)?;
    Ok(if is_proven { Answer::Done } else { Answer::No })
}

/// Writes the folder: what was seen as a scenario, and the plan. The depths are written exactly, so that the map of the folder is that
/// of the plan.
fn write(
    explored: &Explored,
    settings: &ExploreSettings,
    truth: &Scenario,
    plan: &PlanFile,
    place: &Path,
) -> Result<(), Failure> {
    let files = explored.views.files(DepthFormat::Npy)?;
    write_whole_folder(place, |folder| {
        for file in &files {
            write_whole_file(&folder.join(&file.name), &file.content)?;
        }
        settings.options.write_scenario(truth, &settings.known, folder)?;
        plan.write(&folder.join(PLAN)).map_err(|fault| ScenarioError::Unwritable {
            path: folder.join(PLAN),
            reason: std::io::Error::other(fault.to_string()),
        })
    })?;
    Ok(())
}

/// Judges the plan in the scenario of the folder, as `verify` does.
fn is_valid_in(folder: &Path, plan: &PlanFile, source: &PlanSource) -> Result<bool, Failure> {
    let seen = Scenario::open(&folder.to_string_lossy(), &OpenOptions::default())?;
    let problem = seen.problem(source.margins)?;
    let judgement = plan.judge(source, &problem, AuditSettings::default())?;
    Ok(judgement.is_some_and(|judgement| judgement.audit.valid))
}

impl SeenView {
    fn of(report: &ViewReport, problem: &Problem) -> Self {
        Self {
            name: report.name.clone(),
            position_m: position_of(&report.camera),
            quaternion_xyzw: report.camera.world_from_camera.rotation.coords.into(),
            waypoints: report.motion.clone(),
            free_m3: report.free_m3,
            occupied_m3: report.occupied_m3,
            unseen_m3: report.unseen_m3,
            outcome: report.outcome,
            obstruction: obstruction(report, problem),
        }
    }
}

fn obstruction(report: &ViewReport, problem: &Problem) -> Option<Obstruction> {
    let blockage = report.blockage.as_ref()?;
    Some(Obstruction::new(blockage, report.next.as_ref(), problem.robot()))
}

/// Returns the lines on a view.
fn view_lines(number: usize, report: &ViewReport, problem: &Problem) -> String {
    let [free, occupied, unseen] =
        [report.free_m3, report.occupied_m3, report.unseen_m3].map(|volume_m3| 1e3 * volume_m3);
    let mut lines = format!(
        "view {number}: from {} m; {free:.0} l are free or inside of known bodies, {occupied:.0} l occupied, {unseen:.0} l unseen; {}\n",
        text_of(&position_of(&report.camera)),
        report.outcome.name()
    );
    for (name, value) in obstruction(report, problem).iter().flat_map(Obstruction::lines) {
        let _ = writeln!(lines, "  {name:<12}{value}");
    }
    lines
}

fn page(answered: &Answered, explored: &Explored) -> String {
    let Answered { scenario, solved, stopped, views, true_scene, folder, plan_file, plan } = answered;
    let views = counted(views.len(), "view");
    let mut page = if *solved {
        format!("{scenario}: solved after {views}, proven in the space that they show\n")
    } else if *stopped {
        format!("{scenario}: stopped after {views}, not kept\n")
    } else {
        format!("{scenario}: not solved after {views} ({})\n", plan.outcome.name())
    };
    let mut line = |name: &str, value: String| {
        let _ = writeln!(page, "  {name:<12}{value}");
    };
    if !plan.waypoints.is_empty() {
        let length = cranny_file::at_most(plan.path_length, 1.0, 3);
        line("path", format!("{}, length {length}", counted(plan.waypoints.len(), "way point")));
    }
    if let Some(clearance_m) = plan.clearance_m {
        line("clearance", format!("{} or more along the whole path, proven", at_least_mm(clearance_m)));
    }
    if let Some(statement) = explored.seen.seen_statement().filter(|_| *solved) {
        line("note", statement);
    }
    if plan.outcome == Outcome::Solved && !solved {
        line("judged", "NOT valid in the folder; please report this".to_owned());
    }
    if let Some(TrueScene { fault, .. }) = true_scene {
        line("true scene", fault.clone().unwrap_or_else(|| "free".to_owned()));
    }
    if let Some(folder) = folder {
        line("written to", folder.display().to_string());
    }
    if let (Some(folder), Some(plan_file), true) = (folder, plan_file, *solved) {
        line("to judge it", format!("cranny verify {} {}", folder.display(), plan_file.display()));
    }
    page
}
