use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use cranny_collision::{Margins, ToolBound, ToolRegion};
use cranny_file::system::{self, FileStamp};
use cranny_grasp::rows_of_pose;
use cranny_plan::Statistics;
use cranny_scenario::{Recipe, ScenarioError};
use cranny_task::{AfterPlacing, Criterion, LiftOffSettings, PlaceRegion, Problem, Segment, Stage};
use serde_json::json;

use crate::foreign::enclosure::MOST_PROCESSES;
use crate::foreign::foreign_answer::{self, ForeignAnswer};
use crate::foreign::foreign_process::{self, Ending, Limits, MOST_OUTPUT_BYTES, Ran};
use crate::foreign::process_group::Leash;
use crate::foreign::sandbox::Isolation;
use crate::running::opened_scenario::OpenedScenario;
use crate::running::worker_message::{Message, Request};
use crate::store::exports::{ExportFolder, folders_of_campaigns};
use crate::store::hidden_results::results_beside;
use crate::{BenchError, CarryTo, MEGABYTE, PathDemand, PlannerCall, TrialOutcome, TrialRecord};

/// External program, with the files of one scenario.
pub struct ForeignPlanner {
    command: Vec<String>,
    is_released: bool,
    files: ForeignFiles,
}

/// Files that a program may read.
pub struct ForeignFiles {
    /// Folder in the released layout.
    released: PathBuf,
    /// Folder in Cranny's layout.
    cranny: PathBuf,
    /// URDF file of the robot.
    urdf: PathBuf,
    /// Folder with one scratch folder for each trial.
    scratch: PathBuf,
    /// Folders written for the program.
    kept: Vec<PathBuf>,
    /// Files written for the program, with stamps that reveal changes by it.
    written: Vec<(PathBuf, Option<FileStamp>)>,
}

/// One trial of an external program.
pub struct ForeignTask<'a> {
    pub request: &'a Request,
    pub opened: &'a OpenedScenario,
    /// The goal configuration to aim at (m, rad; one value per joint); `None` for all grasps.
    pub goal: Option<&'a [f64]>,
    /// Destination of the target after the grasp, if there is one.
    pub carry: Option<CarryTo>,
    /// Stages of the task; empty if the path ends at the goal.
    pub stages: &'a [Stage],
}

/// Time past its limit after which a program counts as hung: enough to notice the limit, clean up and print.
const GRACE: Duration = Duration::from_secs(1);

/// System messages about denied write access.
const DENIALS: [&str; 4] = ["ermission denied", "Errno 13", "ead-only file system", "Errno 30"];

/// Command line of the released program with its authors' settings, as in its own scripts. `-max_iters` cannot be reached
/// within minutes.
const RELEASED_COMMAND: &str = "test -grasp {grasps} -urdf {urdf} -obstacle {obstacles} -start_config {start} \
    -target_configs {ik} -ik_index {goal} -max_iters {iterations} -d_crit 0.1 -delta_q 3.1415 -epsilon_q 0.1 \
    -num_spikes 7 -p_close_enough 50.0 -prob_steer 0.01 -q_resolution 0.1 -use_rot 100 -rot_ratio 0.5 \
    -groundLevel 0.0 -minColSegIdx 6 -render 0 -seed {seed} -target_prefix {prefix}";

impl ForeignPlanner {
    /// Writes the files of the scenario, unless they exist already.
    pub fn new(request: &Request, opened: &OpenedScenario) -> Result<Self, BenchError> {
        let call = &request.question.call;
        let (command, is_released) = match call {
            PlannerCall::BuiltIn { .. } => return Err(BenchError::Program { program: call.name() }),
            PlannerCall::Exec { command } => (command.clone(), false),
            PlannerCall::Released { program, arguments } => {
                let usual = RELEASED_COMMAND.split_whitespace().map(str::to_owned);
                (
                    std::iter::once(program.clone()).chain(usual).chain(arguments.iter().cloned()).collect(),
                    true,
                )
            }
        };
        let folder = opened.export_folder(&request.exports)?;
        let files = ForeignFiles::write(&folder, &request.question.source, opened)?;
        Ok(Self { command, is_released, files })
    }

    /// Runs the program on a trial, and reports its start, and its end before its output is read. Returns its record and the
    /// segments of its path, not yet judged.
    pub fn plan(
        &self,
        task: &ForeignTask,
        leash: &Leash,
        tell: &mut dyn FnMut(&Message) -> Result<(), BenchError>,
    ) -> Result<(TrialRecord, Vec<Segment>), BenchError> {
        let trial = &task.request.question.trial;
        let time = Duration::try_from_secs_f64(trial.time_limit_s).unwrap_or(Duration::MAX);
        // Each trial gets a new folder, so that files of earlier trials are not visible.
        let folder = ExportFolder::new_in(&self.files.scratch, "trial-");
        let folder = folder
            .map_err(|reason| ScenarioError::Unwritable { path: self.files.scratch.clone(), reason })?;
        let scratch = folder.path();
        let hidden = hidden_from(task.request);
        let limits = Limits {
            time: time.saturating_add(GRACE),
            memory_bytes: task.request.memory_limit_bytes,
            scratch,
            isolation: task.request.isolation,
            hidden: &hidden,
            kept: &self.files.kept,
            worker: &task.request.worker,
        };
        let words = self.command.iter().map(|word| self.filled(word, task, scratch)).collect::<Vec<_>>();
        let missing = || BenchError::Program { program: String::new() };
        let (program, arguments) = words.split_first().ok_or_else(missing)?;
        let mut command = Command::new(program);
        command.args(arguments).current_dir(scratch).env("TMPDIR", scratch);
        let input = self.files.problem(task, scratch).to_string() + "\n";
        let mut told = Ok(());
        let begins = || told = tell(&Message::Opened);
        let ran = foreign_process::run(&command, input, limits, leash, begins);
        let Ran { ending, elapsed_s, memory_bytes, files } =
            ran.map_err(|reason| BenchError::NotRunnable { program: program.clone(), reason })?;
        told?;
        tell(&Message::Planned)?;
        let statistics = Statistics { planning_time_s: elapsed_s, ..Statistics::default() };
        let without =
            |outcome, detail| (TrialRecord::without_path(trial, outcome, detail, statistics), Vec::new());
        let answer = match ending {
            Ending::Hung => without(TrialOutcome::Hung, Some(format!("ended after {elapsed_s:.1} s"))),
            Ending::OutOfMemory { bytes, scratch_bytes } => {
                let mut detail = format!("held {} MB", bytes / MEGABYTE);
                if scratch_bytes >= MEGABYTE {
                    let scratch_mb = scratch_bytes / MEGABYTE;
                    let _ = write!(detail, ", of these {scratch_mb} MB in files of its scratch folder");
                }
                without(TrialOutcome::OutOfMemory, Some(detail))
            }
            Ending::Crowd(processes) => {
                let detail = format!("had {processes} processes; at most {MOST_PROCESSES} are allowed");
                without(TrialOutcome::Crashed, Some(detail))
            }
            Ending::Flood => {
                let detail = format!("printed more than {} MiB", MOST_OUTPUT_BYTES >> 20);
                without(TrialOutcome::Garbled, Some(detail))
            }
            Ending::Exited { status, complaint, .. } if !status.success() => {
                let mut detail = system::ending(status);
                if !complaint.is_empty() {
                    detail = format!("{detail}: {complaint}");
                }
                if limits.isolation != Isolation::default()
                    && DENIALS.iter().any(|denial| complaint.contains(denial))
                {
                    detail = format!(
                        "{detail} (it may write only in its scratch folder; --sandbox off lifts this limit)"
                    );
                }
                without(TrialOutcome::Crashed, Some(detail))
            }
            Ending::Exited { output, .. } => {
                let joints = task.opened.problem.robot().dof();
                let read = if self.is_released {
                    foreign_answer::read_released(&files.scratch().join(PREFIX), joints)
                } else {
                    foreign_answer::read_output(&output, joints, task.stages)
                };
                match read {
                    Ok(ForeignAnswer { outcome, stated, segments, statistics }) => {
                        let statistics = Statistics { planning_time_s: elapsed_s, ..statistics };
                        let detail = stated.map(|word| format!("it states '{word}'"));
                        (TrialRecord::without_path(trial, outcome, detail, statistics), segments)
                    }
                    Err(fault) => without(TrialOutcome::Garbled, Some(fault)),
                }
            }
        };
        let changed = self.files.first_changed();
        if !folder.remove() || changed.is_some() {
            // The next trial gets new files.
            task.opened.discard_export();
        }
        let (record, segments) = match changed {
            None => answer,
            Some(file) => {
                let detail = format!("it changed a file that it was given: {}", file.display());
                without(TrialOutcome::Garbled, Some(detail))
            }
        };
        Ok((TrialRecord { memory_bytes, ..record }, segments))
    }

    /// Replaces the placeholders in a word of the command.
    fn filled(&self, word: &str, task: &ForeignTask, scratch: &Path) -> String {
        /// Iteration limit if only time counts: more than any planner reaches in hours, and within 32 bits.
        const ENDLESS: u64 = 2_000_000_000;
        let trial = &task.request.question.trial;
        let path = |path: &Path| path.display().to_string();
        let export = |name: &str| path(&self.files.released.join("export").join(name));
        let placeholders: [(&str, String); 15] = [
            ("{scenario}", trial.scenario.clone()),
            ("{criterion}", trial.criterion.name().to_owned()),
            ("{seed}", trial.seed.to_string()),
            ("{time_limit_s}", trial.time_limit_s.to_string()),
            ("{iterations}", trial.iteration_limit.unwrap_or(ENDLESS).to_string()),
            ("{goal}", trial.goal.unwrap_or(0).to_string()),
            ("{released}", path(&self.files.released)),
            ("{cranny}", path(&self.files.cranny)),
            ("{urdf}", path(&self.files.urdf)),
            ("{obstacles}", export("obstacles.obj")),
            ("{grasps}", export("grasps.csv")),
            ("{start}", export("robot_start_conf.csv")),
            ("{ik}", export("grasp_IK_solutions.csv")),
            ("{scratch}", path(scratch)),
            ("{prefix}", path(&scratch.join(PREFIX))),
        ];
        placeholders.iter().fold(word.to_owned(), |word, (name, value)| word.replace(name, value))
    }
}

/// First part of the names of files that the released program writes.
const PREFIX: &str = "trial";

/// Returns the files and folders that a program does not see: those of other trials and campaigns, results, and sockets, behind
/// which services run outside of the enclosure.
fn hidden_from(request: &Request) -> Vec<PathBuf> {
    [folders_of_campaigns(&request.exports), results_beside(&request.results), system::socket_paths()]
        .concat()
}

/// Returns the mark of a complete folder; it is written last.
pub fn mark_of_the_whole(folder: &Path, criterion: Criterion) -> PathBuf {
    folder.join(format!("{}.whole", criterion.name()))
}

impl ForeignFiles {
    /// Returns the document for the standard input of the program.
    pub fn problem(&self, task: &ForeignTask, scratch: &Path) -> serde_json::Value {
        let (trial, problem) = (&task.request.question.trial, &task.opened.problem);
        let robot = problem.robot();
        let named = robot.joint_names().iter().zip(robot.limits());
        let joints: Vec<_> = named
            .map(|(name, limits)| json!({"name": name, "lower": limits.lower, "upper": limits.upper}))
            .collect();
        let grasp = |grasp: &cranny_grasp::Grasp| json!({"pose": rows_of_pose(&grasp.world_from_gripper), "score": grasp.score});
        let export = self.released.join("export");
        let margins = problem.cell().map(|cell| cell.margins());
        let bounds = problem.cell().map_or(&[][..], |cell| cell.world().tool_bounds());
        let Margins { margin_m, grasp_margin_m, object_margin_m, tilt_rad } =
            margins.unwrap_or(PathDemand::of_settings(&trial.settings).margins);
        json!({
            "protocol": 1,
            "protocols": [1, 2],
            "scenario": trial.scenario,
            "criterion": trial.criterion.name(),
            "seed": trial.seed,
            "time_limit_s": trial.time_limit_s,
            "iteration_limit": trial.iteration_limit,
            "joints": joints,
            "start": problem.start(),
            "grasps": task.opened.scenario.grasps.grasps().iter().map(grasp).collect::<Vec<_>>(),
            "tip": robot.links()[robot.tip()].name,
            "goal_configuration": task.goal,
            "target": problem.target().and_then(|target| Some(&problem.cell()?.world().bodies()[target].name)),
            "carry": task.carry.map(|carry| asked_to_carry(carry, task.stages, problem)),
            "task": task.stages.iter().map(|stage| asked_stage(stage, problem)).collect::<Vec<_>>(),
            "margin_m": margin_m,
            "grasp_margin_m": grasp_margin_m,
            "object_margin_m": object_margin_m,
            "tilt_rad": tilt_rad,
            "tool_bounds": bounds.iter().map(asked_bound).collect::<Vec<_>>(),
            "files": {
                "released": self.released,
                "cranny": self.cranny,
                "urdf": self.urdf,
                "obstacles": export.join("obstacles.obj"),
                "grasps": export.join("grasps.csv"),
                "start": export.join("robot_start_conf.csv"),
                "ik": export.join("grasp_IK_solutions.csv"),
                "scratch": scratch,
            },
        })
    }

    /// Writes all files into a folder, which may exist.
    pub fn write(folder: &Path, source: &str, opened: &OpenedScenario) -> Result<Self, BenchError> {
        let unwritable = |path: &Path, reason| ScenarioError::Unwritable { path: path.to_owned(), reason };
        let scratch = folder.join("scratch");
        std::fs::create_dir_all(&scratch).map_err(|reason| unwritable(&scratch, reason))?;
        let recipe = Recipe::of_scenario(&opened.scenario)?;
        let mut files = Self {
            released: folder.join("released"),
            cranny: folder.join("cranny").join(&opened.scenario.id),
            urdf: folder.join("robot").join(recipe.robot.urdf_name()),
            scratch,
            kept: ["robot", "cranny", "released"].map(|written| folder.join(written)).into(),
            written: Vec::new(),
        };
        let mark = mark_of_the_whole(folder, opened.problem.criterion());
        let is_whole = mark.is_file();
        if !is_whole {
            recipe.robot.write(&folder.join("robot"))?;
            let ik = if opened.scenario.has_grasp_set { opened.goals()?.to_vec() } else { Vec::new() };
            let recipe = Recipe { ik, ..recipe };
            recipe.write_folder(&files.cranny)?;
            recipe.write_released(&files.released)?;
            std::fs::write(&mark, "").map_err(|reason| unwritable(&mark, reason))?;
        }
        for written in files.kept.clone() {
            files.note_written(&written);
        }
        // A released scenario is passed unchanged, with its own robot.
        let source = Path::new(source);
        if opened.scenario.has_grasp_set
            && source.join("scene.yaml").is_file()
            && source.join("export/obstacles.obj").is_file()
        {
            source.clone_into(&mut files.released);
            let robot = source.join("../../robots/franka_panda/mobile_panda_fingersSmallMesh.urdf");
            if robot.is_file() {
                files.urdf = robot;
            }
        }
        Ok(files)
    }

    /// Returns the files after their folder was moved.
    pub fn moved(self, from: &Path, to: &Path) -> Self {
        // A released scenario may lie elsewhere.
        let place = |path: PathBuf| path.strip_prefix(from).map(|below| to.join(below)).unwrap_or(path);
        let written = self.written.into_iter().map(|(path, stamp)| (place(path), stamp)).collect();
        Self {
            released: place(self.released),
            cranny: place(self.cranny),
            urdf: place(self.urdf),
            scratch: place(self.scratch),
            kept: self.kept.into_iter().map(place).collect(),
            written,
        }
    }

    /// Records all files below a folder and makes them read-only.
    fn note_written(&mut self, folder: &Path) {
        let Ok(entries) = std::fs::read_dir(folder) else { return };
        let mut paths: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
        paths.sort();
        for path in paths {
            if path.is_dir() {
                self.note_written(&path);
                continue;
            }
            if let Ok(mut permissions) = std::fs::metadata(&path).map(|facts| facts.permissions()) {
                permissions.set_readonly(true);
                // If the permission cannot be set, a change is still detected.
                let _ = std::fs::set_permissions(&path, permissions);
            }
            let stamp = FileStamp::of(&path);
            self.written.push((path, stamp));
        }
    }

    /// Returns the first file that was changed after writing.
    fn first_changed(&self) -> Option<&Path> {
        let mut changed = self.written.iter().filter(|(path, stamp)| FileStamp::of(path) != *stamp);
        changed.next().map(|(path, _)| path.as_path())
    }
}

/// Returns the form of protocol 2 for a carried target, whose task is one pick and one further stage.
fn asked_to_carry(carry: CarryTo, stages: &[Stage], problem: &Problem) -> serde_json::Value {
    let LiftOffSettings { most_m, clear_m, slack_m } = LiftOffSettings::default();
    let mut asked = json!({
        "to": carry.name(),
        "clear_m": null,
        "lift_off": {"most_m": most_m, "clear_m": clear_m, "slack_m": slack_m},
    });
    for stage in stages {
        let mut keys = asked_stage(stage, problem);
        if !keys["clear_m"].is_null() {
            asked["clear_m"] = keys["clear_m"].take();
        }
        if keys["place"].is_object() {
            asked["place"] = keys["place"].take();
            asked["place"]["then"] = AfterPlacing::Home.name().into();
        }
    }
    asked
}

/// Returns a stage as in a plan file, with its full placement: name, support, pose in the planning frame (m, row by row)
/// and size (m).
fn asked_stage(stage: &Stage, problem: &Problem) -> serde_json::Value {
    let mut asked = json!(stage);
    if let Stage::Place(place) = stage
        && let Ok(goal) = problem.place(&place.place)
    {
        let (on, pose, size_m) = match &goal.spot {
            PlaceRegion::Surface { on, pose, size_m } => (Some(on), pose, Some(size_m)),
            PlaceRegion::Target(pose) => (None, pose, None),
        };
        asked["place"] = json!({"name": goal.name, "on": on, "pose": rows_of_pose(pose), "size_m": size_m});
    }
    asked
}

/// Returns a bound of the tool for a program: poses and directions in the planning frame, metres and radians.
fn asked_bound(bound: &ToolBound) -> serde_json::Value {
    match &bound.region {
        ToolRegion::Cone { axis_in_link, toward, most_rad } => json!({
            "name": bound.name,
            "link": bound.link,
            "axis_in_link": axis_in_link.as_slice(),
            "toward": toward.as_slice(),
            "most_rad": most_rad,
        }),
        ToolRegion::Box { point_in_link, world_from_box, half_m } => json!({
            "name": bound.name,
            "link": bound.link,
            "point_in_link_m": point_in_link.coords.as_slice(),
            "pose": rows_of_pose(world_from_box),
            "size_m": (half_m * 2.0).as_slice(),
        }),
        ToolRegion::Ball { point_in_link, center, radius_m } => json!({
            "name": bound.name,
            "link": bound.link,
            "point_in_link_m": point_in_link.coords.as_slice(),
            "center_m": center.coords.as_slice(),
            "radius_m": radius_m,
        }),
    }
}
