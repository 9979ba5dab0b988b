use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use cranny_bench::{CampaignProgress, Results, Shard, Tally};
use cranny_file::{counted, shell_file, visible_line};
use serde::Serialize;

use crate::Answer;
use crate::arguments::Output;
use crate::campaigns::cluster_folder::{ClusterCampaign, ClusterFolder};
use crate::campaigns::slurm::{self, TaskState};
use crate::failure::Failure;
use crate::text;

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny bench status campaign          the folder of `bench slurm`
  cranny bench status part-*.db         parts of a campaign, run with --shard
  cranny bench status part-*.db --json

Each task keeps a small file that says how far it is, so that results are not opened while another machine writes them;
where there is none the results are asked, which do not say how many trials there are to be. A shard of the campaign
without a file among those given is missing. Exit 0: every trial has ended; exit 1: not yet, a shard is missing, or nobody
knows.")]
pub struct StatusArguments {
    /// Folder of `bench slurm`, or files of results
    #[arg(value_name = "FOLDER|RESULTS", required = true, num_args = 1..)]
    places: Vec<PathBuf>,
}

/// State of an array task.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
enum State {
    Done,
    Running,
    Waiting,
    /// Not done, and unknown to Slurm.
    Lost,
    /// Not done, and Slurm is not available.
    Open,
    /// Shard of which no file is given.
    Missing,
    /// The total number of trials is unknown.
    Unknown,
}

/// Output of `bench status --json`.
#[derive(Serialize)]
struct Answered {
    /// Number of trials of all array tasks together, if known.
    trials: Option<usize>,
    ended: usize,
    solved: usize,
    /// Estimated remaining time with the current number of running array tasks, in seconds.
    left_s: Option<f64>,
    planners: BTreeMap<String, Tally>,
    tasks: Vec<TaskLine>,
    /// Command that resubmits lost array tasks.
    resume: Option<String>,
}

#[derive(Serialize)]
struct TaskLine {
    task: String,
    state: State,
    #[serde(flatten)]
    standing: CampaignProgress,
}

pub fn run(arguments: &StatusArguments, output: Output) -> Result<Answer, Failure> {
    let mut answered = match &arguments.places[..] {
        [folder] if folder.is_dir() => of_folder(&ClusterFolder { path: folder.clone() })?,
        files => of_files(files)?,
    };
    answered.add_up();
    text::answer(&answered, || answered.page(), output)?;
    let is_done = answered.tasks.iter().all(|task| task.state == State::Done);
    Ok(if is_done { Answer::Done } else { Answer::No })
}

fn of_folder(folder: &ClusterFolder) -> Result<Answered, Failure> {
    let campaign: ClusterCampaign = folder.campaign()?;
    let active = slurm::active_tasks(&campaign.jobs)?;
    let state = |number: u64, standing: &CampaignProgress| match active.get(&number) {
        _ if standing.is_done() => State::Done,
        Some(TaskState::Running) => State::Running,
        Some(TaskState::Waiting) => State::Waiting,
        None if campaign.jobs.is_empty() => State::Open,
        None => State::Lost,
    };
    let tasks = folder.tasks(&campaign).into_iter().map(|task| {
        let (name, mut standing) = (task.number.to_string(), task.standing);
        let state = state(task.number, &standing);
        if state == State::Lost {
            // Includes results stored after the last write of its standing.
            standing.planners = Results::glance(&folder.results(&name)).unwrap_or(standing.planners);
        }
        TaskLine { task: name, state, standing }
    });
    let tasks: Vec<TaskLine> = tasks.collect();
    let is_lost = tasks.iter().any(|task| task.state == State::Lost);
    let resume = is_lost.then(|| format!("cranny bench slurm --resume {}", shell_file(&folder.path)));
    Ok(Answered { trials: Some(campaign.manifest.trials), resume, ..Answered::of(tasks) })
}

fn of_files(files: &[PathBuf]) -> Result<Answered, Failure> {
    let task = |file: &PathBuf| -> Result<TaskLine, Failure> {
        let standing = match CampaignProgress::read(&file.with_extension("json")) {
            Some(standing) => standing,
            None => CampaignProgress::of_results(file)?,
        };
        let state = match standing.trials {
            None => State::Unknown,
            Some(_) if standing.is_done() => State::Done,
            Some(_) => State::Open,
        };
        let name = file.file_name().map_or(file.as_path(), Path::new);
        Ok(TaskLine { task: name.display().to_string(), state, standing })
    };
    let mut tasks = files.iter().map(task).collect::<Result<Vec<_>, _>>()?;
    tasks.extend(missing(&tasks));
    let trials = tasks.iter().map(|task| task.standing.trials).sum();
    Ok(Answered { trials, ..Answered::of(tasks) })
}

/// Returns the shards of which no file is among these; none if one of the files is of a whole campaign, or does not state
/// its shard.
fn missing(tasks: &[TaskLine]) -> Vec<TaskLine> {
    if tasks.iter().any(|task| task.standing.shards.is_empty()) {
        return Vec::new();
    }
    let there: Vec<Shard> = tasks.iter().flat_map(|task| task.standing.shards.iter().copied()).collect();
    let line = |shard: Shard| TaskLine {
        task: shard.to_string(),
        state: State::Missing,
        standing: CampaignProgress { shards: vec![shard], ..CampaignProgress::default() },
    };
    Shard::missing(&there).into_iter().map(line).collect()
}

impl Answered {
    fn of(tasks: Vec<TaskLine>) -> Self {
        Self {
            trials: None,
            ended: 0,
            solved: 0,
            left_s: None,
            planners: BTreeMap::new(),
            tasks,
            resume: None,
        }
    }

    /// Sums up the tallies of all array tasks.
    fn add_up(&mut self) {
        for TaskLine { standing, .. } in &self.tasks {
            for (planner, tally) in &standing.planners {
                let all = self.planners.entry(planner.clone()).or_default();
                *all = all.plus(*tally);
            }
        }
        let all = self.planners.values().copied().fold(Tally::default(), Tally::plus);
        (self.ended, self.solved) = (all.ended, all.solved);
        let running =
            self.tasks.iter().filter(|task| matches!(task.state, State::Running | State::Open)).count();
        // Estimates the remaining time from the mean time of the trials that have ended.
        let (run, elapsed_s) = self.tasks.iter().fold((0, 0.0), |(run, elapsed_s), task| {
            (run + task.standing.run, elapsed_s + task.standing.elapsed_s)
        });
        let left = self.trials.map(|trials| trials.saturating_sub(self.ended));
        self.left_s = left
            .filter(|left| *left > 0 && run > 0 && running > 0)
            .map(|left| elapsed_s / run as f64 * left as f64 / running as f64);
    }

    fn page(&self) -> String {
        let Self { trials, ended, solved, left_s, planners, tasks, resume } = self;
        let share = |part: usize, whole: usize| 100.0 * part as f64 / whole.max(1) as f64;
        let mut page = match trials {
            Some(trials) => format!("{ended} of {}", counted(*trials, "trial")),
            None => format!("{} ended", counted(*ended, "trial")),
        };
        let _ = write!(page, ", {solved} of them solved ({:.1} %)", share(*solved, *ended));
        if let Some(left_s) = left_s {
            let _ = write!(page, ", about {} left", duration(*left_s));
        }
        page.push('\n');
        let states = [
            (State::Done, "done"),
            (State::Running, "running"),
            (State::Waiting, "waiting"),
            (State::Lost, "lost"),
            (State::Open, "not done"),
            (State::Missing, "missing"),
            (State::Unknown, "unknown"),
        ];
        for (state, name) in states {
            let of_state: Vec<&TaskLine> = tasks.iter().filter(|task| task.state == state).collect();
            if of_state.is_empty() {
                continue;
            }
            let _ = write!(page, "  {name:<10} {} of {} tasks", of_state.len(), tasks.len());
            if state != State::Done {
                /// Maximum number of array tasks listed per state; `--json` lists all.
                const MOST: usize = 8;
                let told = of_state.iter().take(MOST).map(|task| {
                    let tally = task.standing.tally();
                    let of = task.standing.trials.map_or_else(String::new, |trials| format!("/{trials}"));
                    format!("{} ({}{of})", task.task, tally.ended)
                });
                let more = if of_state.len() > MOST { ", …" } else { "" };
                let _ = write!(page, ": {}{more}", told.collect::<Vec<_>>().join(", "));
            }
            page.push('\n');
        }
        for (planner, Tally { ended, solved }) in planners {
            let (planner, percent) = (visible_line(planner), share(*solved, *ended));
            let _ = writeln!(page, "  {planner}: {solved} of {ended} solved ({percent:.1} %)");
        }
        if tasks.iter().any(|task| task.state == State::Unknown) {
            page.push_str(
                "  the total number of trials is not recorded: run the same command again to run the rest, \
                 if any is left\n",
            );
        }
        if tasks.iter().any(|task| task.state == State::Missing) {
            page.push_str(
                "  no file of a missing shard is given: name its results too, or run it with --shard\n",
            );
        }
        if let Some(resume) = resume {
            let _ = writeln!(page, "  to submit what was lost: {resume}");
        }
        page
    }
}

/// Formats a duration, rounded to a readable unit.
fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s if s < 172_800.0 => format!("{:.0} h", s / 3600.0),
        s => format!("{:.0} days", s / 86400.0),
    }
}
