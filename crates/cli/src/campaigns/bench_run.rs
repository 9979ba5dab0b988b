use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::{Args, ValueEnum};
use cranny_bench::{
    Campaign, CampaignObserver, CampaignPlanner, CampaignSettings, CarryTo, MEGABYTE, MOST_MEMORY_MB,
    MOST_TRIALS, Manifest, PlannerCall, ProgressFile, Results, RunInformation, RunSummary, Sandbox, Shard,
    TrialOutcome, TrialRecord, run_campaign,
};
use cranny_file::counted;
use cranny_plan::Registry;
use cranny_solve::PoseRadius;
use cranny_task::Criterion;
use indicatif::ProgressBar;
use serde::Serialize;
use strum::VariantArray as _;

use crate::arguments::{MarginArguments, Output};
use crate::campaigns::bench_worker;
use crate::campaigns::cluster_folder::ClusterCampaign;
use crate::choices::CriterionArgument;
use crate::failure::Failure;
use crate::file_kind::FileKind;
use crate::number_argument::{MOST_ITERATIONS, pose_error, seconds, whole};
use crate::program::version::COMMIT;
use crate::progress::{bar, spinner, stop_on_interrupt};
use crate::{Answer, output_file, text};

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny bench run --scenarios 01x,045 --planners j-plus-rrt,ik-rrt,reach \\
      --runs 100 -o results.db
  cranny bench run --scenarios all --planners reach --time-limit 10 \\
      --planner \"exec:python3 plain_rrt.py\"
  cranny bench run campaign.yaml -o results.db
  cranny bench run --preset paper --runs 20 --time-limit 30 -o table.db
  cranny bench run --scenarios all --planners reach --carry home
  cranny bench run --scenarios all --planners grasp-reach,grasp-rrt \\
      --grasps none
  cranny bench run campaign.yaml -o results.db --again killed,crashed     run lost trials again
  cranny bench run --scenarios 021 --criterion paper \\
      --planner \"released:./burs_of_free_space -planner 0\"

The same command again continues an interrupted campaign; no trial is counted twice.
Exit 0: the results contain every trial, failures included; exit 1: interrupted.
Flags override the campaign file and the preset. A planner of your own is called as docs/exec_protocol.md defines.")]
pub struct RunArguments {
    /// Campaign file (YAML)
    #[arg(value_name = "CAMPAIGN", conflicts_with = "preset")]
    campaign: Option<PathBuf>,
    /// Built-in campaign: `paper` is the paper's Table I
    #[arg(long, value_enum)]
    preset: Option<PresetArgument>,
    /// Built-in ids (x stands for any digit: 01x), `all`, folders, archives; comma-separated
    #[arg(long, value_name = "IDS", value_delimiter = ',', num_args = 1..)]
    scenarios: Vec<String>,
    /// Built-in planners, comma-separated; with a campaign file or a preset, a selection from its planners
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    planners: Vec<String>,
    /// Planner, built-in or external: `exec:PROGRAM ARGUMENT…`, `released:PROGRAM ARGUMENT…`, with `NAME=` before it to name
    /// it; repeatable
    #[arg(long, value_name = "PLANNER")]
    planner: Vec<String>,
    /// Criteria for solved trials, comma-separated [default: exact]
    #[arg(long, value_enum, value_delimiter = ',')]
    criterion: Vec<CriterionArgument>,
    /// Seeds for each planner in each scenario [default: 100]
    #[arg(long, value_name = "N", value_parser = whole(1..=MOST_TRIALS))]
    runs: Option<u64>,
    /// First seed [default: 0]
    #[arg(long, value_name = "N", value_parser = whole(0..=MOST_ITERATIONS))]
    first_seed: Option<u64>,
    /// Time limit of a search, in seconds [default: 120]
    #[arg(long, value_name = "S", value_parser = seconds)]
    time_limit: Option<Duration>,
    /// Maximum number of iterations of a search [default: no limit]
    #[arg(long, value_name = "N", value_parser = whole(0..=MOST_ITERATIONS))]
    iterations: Option<u64>,
    /// Memory limit of a search, in MB of 10⁶ bytes [default: 4096]
    #[arg(long, value_name = "MB", value_parser = whole(1..=MOST_MEMORY_MB))]
    memory_limit: Option<u64>,
    /// Plan to each known goal configuration of a scenario separately, as the paper's table of IK-RRT does
    #[arg(long)]
    each_goal: bool,
    /// Judge every path under the other criterion as well
    #[arg(long)]
    judge_both: bool,
    /// Do not measure the minimum clearance along every path, which takes some milliseconds in addition to the trial's own time
    #[arg(long)]
    no_clearance: bool,
    /// Carry the target on after the grasp: `home`, to the robot's start configuration; `out`, until it is 50 mm clear of
    /// everything but the floor; or `place`, to the first place of its scenario, where it is put down
    #[arg(long, value_name = "home|out|place", value_parser = carry_to)]
    carry: Option<CarryTo>,
    /// Plan the task of this name in each scenario (`tasks` of its scenario.yaml)
    #[arg(long, value_name = "NAME", conflicts_with = "carry")]
    task: Option<String>,
    /// Require that the plan tolerates this error of the target's pose, as `plan --robust` does
    #[arg(long, value_name = "MM,DEG", value_parser = pose_error)]
    robust: Option<PoseRadius>,
    /// Require that the hand holds the object with this factor, as `plan --hold` does [default: 1.5]
    #[arg(long, value_name = "FACTOR", allow_negative_numbers = true)]
    hold: Option<f64>,
    /// Execute each plan of a built-in planner in physics and plan again until one goes as planned, at most N times, as `plan
    /// --try-in-physics` does; the times of the searches are added
    #[arg(long, value_name = "N", value_parser = whole::<u64>(1..=1000))]
    try_in_physics: Option<u64>,
    /// Provide no set of grasps: `none`. Planners then generate their own, which the judge measures on the target's mesh
    #[arg(long, value_name = "none", value_parser = ["none"])]
    grasps: Option<String>,
    #[command(flatten)]
    margins: MarginArguments,
    /// Sandbox of external programs: the mechanisms that this machine has (auto), none (off), or all of them, else nothing is
    /// run (require)
    #[arg(long, value_name = "SANDBOX", default_value = "auto", value_parser = bench_worker::sandbox)]
    sandbox: Sandbox,
    /// Number of parallel trials; with more than one, times differ from those on an idle machine, and the results state so
    #[arg(long, value_name = "N", default_value = "1", value_parser = whole::<usize>(1..=1024))]
    workers: usize,
    /// Repeat trials with these outcomes and replace their results: killed, crashed, hung, …; comma-separated
    #[arg(long, value_name = "OUTCOMES", value_delimiter = ',', value_parser = outcome)]
    again: Vec<TrialOutcome>,
    /// Run one shard of the trials: 3/8 is the third of eight
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
    /// Refuse to run unless program, scenarios, planners and trials match this file, which `bench slurm` wrote
    #[arg(long, value_name = "FILE")]
    manifest: Option<PathBuf>,
    /// Write the progress of the campaign to this file, for `bench status` [default with --shard: the results with .json]
    #[arg(long, value_name = "FILE")]
    standing: Option<PathBuf>,
    /// File of results, created if it does not exist
    #[arg(long, short, value_name = "FILE", default_value = "results.db")]
    output: PathBuf,
}

fn outcome(text: &str) -> Result<TrialOutcome, String> {
    let known = || TrialOutcome::VARIANTS.iter().map(|outcome| outcome.name()).collect::<Vec<_>>().join(", ");
    text.parse().map_err(|_| format!("unknown outcome (known: {})", known()))
}

fn carry_to(text: &str) -> Result<CarryTo, String> {
    text.parse().map_err(|_| "give `home`, `out` or `place`".to_owned())
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum PresetArgument {
    /// J⁺-RRT and IK-RRT in the twenty scenarios under the paper criterion, 100 runs of 120 s
    Paper,
}

/// Output of `bench run --json`.
#[derive(Serialize)]
struct Answered<'a> {
    file: &'a Path,
    trials: usize,
    known: usize,
    run: usize,
    solved: usize,
    stopped: bool,
    /// Trials of this run that failed abnormally, by planner and outcome.
    lost: Vec<Lost>,
}

/// Trials of one planner with one abnormal outcome.
#[derive(Serialize)]
struct Lost {
    planner: String,
    outcome: &'static str,
    trials: usize,
    /// Message of the first such trial.
    first: String,
}

pub fn run(arguments: &RunArguments, registry: &Registry, output: Output) -> Result<Answer, Failure> {
    cranny_file::system::close_to_others();
    let campaign = campaign(arguments, registry)?;
    // Checks the results file before many scenarios are opened.
    output_file::check_folder(&arguments.output)?;
    if std::fs::metadata(&arguments.output).is_ok_and(|found| !found.is_file() || found.len() > 0) {
        Results::open(&arguments.output)?;
    }
    let beside = arguments.shard.map(|_| arguments.output.with_extension("json"));
    let standing = arguments.standing.clone().or(beside);
    if let Some(file) = &standing {
        if std::path::absolute(file)? == std::path::absolute(&arguments.output)? {
            let problem = "the progress cannot be in the file of results; name another one";
            return Err(Failure::Flag { flag: "standing", problem: problem.to_owned() });
        }
        output_file::check(file, FileKind::Progress, output)?;
    }
    let spinner = spinner("opening the scenarios", output.quiet);
    let schedule = campaign.schedule(registry);
    spinner.finish_and_clear();
    let mut schedule = schedule?;
    let stop = stop_on_interrupt();
    if let Some(file) = &arguments.manifest {
        let here = Manifest::of(&schedule, &std::env::current_exe()?);
        here.check(&ClusterCampaign::read(file)?.manifest)?;
    }
    if !output.quiet {
        for note in &schedule.notes {
            writeln!(std::io::stderr(), "note: {note}")?;
        }
    }
    let mut results = Results::create(&arguments.output)?;
    if let Some(shard) = arguments.shard {
        shard.check(&schedule, &results)?;
        schedule = shard.of(schedule);
    }
    let command = std::env::args().collect::<Vec<_>>().join(" ");
    let workers = arguments.workers;
    let settings = CampaignSettings {
        worker: bench_worker::worker()?,
        workers,
        memory_limit_bytes: campaign.memory_limit_bytes,
        information: RunInformation::here(COMMIT, &command, workers),
        sandbox: arguments.sandbox,
        again: arguments.again.clone(),
    };
    let mut progress = CampaignBar::new(output.quiet);
    let ended = match standing {
        None => run_campaign(&schedule, &settings, &mut results, &mut progress, &stop),
        Some(file) => {
            let machine = settings.information.machine.clone();
            let standing = ProgressFile::new(&file, workers, &machine, &mut progress);
            let mut standing = standing.of_shard(arguments.shard);
            let ended = run_campaign(&schedule, &settings, &mut results, &mut standing, &stop);
            standing.write();
            ended
        }
    };
    progress.finish();
    let RunSummary { trials, known, run, solved, is_stopped: stopped } = ended?;
    let (file, lost) = (&arguments.output, progress.lost);
    let answered = Answered { file, trials, known, run, solved, stopped, lost };
    text::answer(&answered, || answered.page(), output)?;
    Ok(if stopped { Answer::No } else { Answer::Done })
}

impl Answered<'_> {
    fn page(&self) -> String {
        let Self { file, trials, known, run, solved, stopped, lost } = self;
        let mut page = format!("{}: {} of {}", file.display(), known + run, counted(*trials, "trial"));
        if *run > 0 {
            let _ = write!(page, ", {run} run now, {solved} of those solved");
        }
        page.push('\n');
        for Lost { planner, outcome, trials, first } in lost {
            let _ = writeln!(page, "  {planner}: {trials} {outcome}; the first: {first}");
        }
        if *stopped {
            page.push_str("stopped; run the same command again to continue\n");
        }
        page
    }
}

/// Combines campaign file, preset and flags.
fn campaign(arguments: &RunArguments, registry: &Registry) -> Result<Campaign, Failure> {
    let mut campaign = match (&arguments.campaign, arguments.preset) {
        (Some(file), _) => Campaign::read(file, registry)?,
        (None, Some(PresetArgument::Paper)) => Campaign::paper()?,
        (None, None) => Campaign::default(),
    };
    if !arguments.scenarios.is_empty() {
        campaign.scenarios.clone_from(&arguments.scenarios);
    }
    choose_planners(&mut campaign, arguments, registry)?;
    if !arguments.criterion.is_empty() {
        campaign.criteria = arguments.criterion.iter().map(|criterion| Criterion::from(*criterion)).collect();
    }
    for planner in &mut campaign.planners {
        planner.each_goal |= arguments.each_goal;
        planner.runs = planner.runs.filter(|_| arguments.runs.is_none());
        planner.time_limit_s = planner.time_limit_s.filter(|_| arguments.time_limit.is_none());
    }
    if let Some(runs) = arguments.runs {
        campaign.runs = runs;
    }
    if let Some(limit) = arguments.time_limit {
        campaign.time_limit_s = limit.as_secs_f64();
        campaign.exceptions.clear();
    }
    campaign.first_seed = arguments.first_seed.unwrap_or(campaign.first_seed);
    campaign.iteration_limit = arguments.iterations.or(campaign.iteration_limit);
    if let Some(limit) = arguments.memory_limit {
        campaign.memory_limit_bytes = limit * MEGABYTE;
    }
    campaign.judge_both |= arguments.judge_both;
    campaign.demand.carry = arguments.carry.or(campaign.demand.carry);
    campaign.demand.task = arguments.task.clone().or(campaign.demand.task.take());
    campaign.demand.robust = arguments.robust.or(campaign.demand.robust);
    campaign.demand.hold = arguments.hold.or(campaign.demand.hold);
    campaign.demand.try_in_physics = arguments.try_in_physics.or(campaign.demand.try_in_physics);
    campaign.demand.without_grasp_set |= arguments.grasps.is_some();
    campaign.demand.margins = arguments.margins.or(campaign.demand.margins);
    campaign.measure_clearance &= !arguments.no_clearance;
    if campaign.scenarios.is_empty() {
        let problem =
            "required, unless a campaign file or a --preset is given (`--scenarios all`: all built-in ones)";
        return Err(Failure::Flag { flag: "scenarios", problem: problem.to_owned() });
    }
    if campaign.planners.is_empty() {
        let problem = format!("required (built in: {})", registry.names().join(", "));
        return Err(Failure::Flag { flag: "planners", problem });
    }
    Ok(campaign)
}

/// Selects the planners that flags name from those of a campaign file or preset, and adds the others.
fn choose_planners(
    campaign: &mut Campaign,
    arguments: &RunArguments,
    registry: &Registry,
) -> Result<(), Failure> {
    if arguments.planners.is_empty() && arguments.planner.is_empty() {
        return Ok(());
    }
    let known = std::mem::take(&mut campaign.planners);
    for word in arguments.planners.iter().chain(&arguments.planner) {
        let planner = match known.iter().find(|planner| planner.name == *word) {
            Some(planner) => planner.clone(),
            None => planner_of(word, registry)?,
        };
        campaign.planners.push(planner);
    }
    Ok(())
}

/// Parses `reach`, `exec:…`, `released:…`, or one of them after `NAME=`.
fn planner_of(word: &str, registry: &Registry) -> Result<CampaignPlanner, Failure> {
    let (name, call) = match word.split_once('=') {
        Some((name, call)) if !name.contains([':', ' ']) && !name.is_empty() => (Some(name), call),
        _ => (None, word),
    };
    let planner = CampaignPlanner::new(PlannerCall::parse(call, registry)?);
    Ok(CampaignPlanner { name: name.map_or(planner.name.clone(), str::to_owned), ..planner })
}

/// Progress bar with the running success rate.
struct CampaignBar {
    bar: ProgressBar,
    quiet: bool,
    ended: usize,
    solved: usize,
    lost: Vec<Lost>,
}

impl CampaignBar {
    fn new(quiet: bool) -> Self {
        Self { bar: ProgressBar::hidden(), quiet, ended: 0, solved: 0, lost: Vec::new() }
    }

    fn finish(&self) {
        self.bar.finish_and_clear();
    }

    /// Counts outcomes caused by the planner's program or its call rather than by its search.
    fn note_loss(&mut self, record: &TrialRecord) {
        use TrialOutcome::{Crashed, Garbled, Hung, Killed, OutOfMemory, Rejected, Undecided};
        if !matches!(record.outcome, Crashed | Garbled | Hung | Killed | OutOfMemory | Rejected | Undecided) {
            return;
        }
        let (planner, outcome) = (&record.trial.planner, record.outcome.name());
        match self.lost.iter_mut().find(|lost| lost.planner == *planner && lost.outcome == outcome) {
            Some(lost) => lost.trials += 1,
            None => self.lost.push(Lost {
                planner: planner.clone(),
                outcome,
                trials: 1,
                first: record.detail.clone().unwrap_or_default(),
            }),
        }
    }
}

impl CampaignObserver for CampaignBar {
    fn begins(&mut self, to_run: usize, _known: &[TrialRecord]) {
        self.bar = bar(to_run as u64, self.quiet);
    }

    fn notes(&mut self, note: &str) {
        if !self.quiet {
            // A terminal that is gone cannot show it.
            let _ = self.bar.suspend(|| writeln!(std::io::stderr(), "note: {note}"));
        }
    }

    fn trial_ended(&mut self, record: &TrialRecord) {
        self.ended += 1;
        self.solved += usize::from(record.is_solved());
        let percent = 100.0 * self.solved as f64 / self.ended as f64;
        self.note_loss(record);
        self.bar.set_message(format!("{percent:.0} % solved"));
        self.bar.inc(1);
    }
}
