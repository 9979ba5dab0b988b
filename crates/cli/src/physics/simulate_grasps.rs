use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::PathBuf;
use std::sync::atomic::Ordering;

use clap::Args;
use cranny_bench::statistics::wilson;
use cranny_file::counted;
use cranny_grasp::{Grasp, GraspSet, csv_text};
use cranny_scenario::ScenarioError;
use cranny_sim::{Disturbance, GraspOutcome, GraspRow, GraspTest};
use indicatif::ProgressBar;
use serde::Serialize;

use crate::arguments::Output;
use crate::failure::Failure;
use crate::file_kind::FileKind;
use crate::number_argument::whole;
use crate::physics::load_prediction::{LoadPrediction, load_text};
use crate::physics::simulate_subject::{Subject, SubjectArguments, flag};
use crate::progress::{bar, stop_on_interrupt};
use crate::unfinished::Unfinished;
use crate::{Answer, output_file, physics::recording, text};

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny simulate grasps 021
  cranny simulate grasps 031 --support-only --friction 0.5 --json
  cranny simulate grasps 041 --grasp 7 --record grasp7.glb    or .gif, to be looked at
  cranny simulate grasps 041 --grasp 7 --record grasp7.json   for `cranny view grasp7.json`, or `render`
  cranny simulate grasps 011 --trials 32                       a robust score: slightly wrong grasps too
  cranny simulate grasps 011 --trials 32 -o scored.csv         the grasps with it, beside the geometric score
  cranny simulate grasps mug --grasps mug.csv --pose 0         an object on the ground

The object comes to rest; the open hand stands at the grasp, closes with its closing force, lifts 100 mm and shakes
along and about each axis (10 mm, 10°, 5 Hz). held: the object is then within 10 mm and 15° of where it was in the
hand; slipped: elsewhere in it; dropped: no longer touched; never-closed: the fingers found nothing; knocked-away: and
pushed it off. An open hand that stands in the object (knocked-away) or with a finger in what is around (never-closed) by
more than 1 mm begins nothing. What simulators say of real grasps is right for about 85 in 100.

Load: computed of each grasp, for a hand of two flat pads. The factor by which gravity (at rest), or the loads of lifting
and shaking (along the course), may grow until a pad slips; below 1 a pad slips for as long as that lasts.")]
pub struct SimulateGraspsArguments {
    #[command(flatten)]
    pub subject: SubjectArguments,
    /// Test only this grasp, by its index from 0
    #[arg(long, value_name = "K")]
    pub grasp: Option<usize>,
    /// Number of additional trials of each grasp, with small errors of the hand, friction, mass and force (3 mm and 3° on each
    /// axis, 25 %, 10 %, 10 %), the same for every grasp: the fraction of successes is the robust score
    #[arg(long, value_name = "N", default_value = "0", value_parser = whole::<usize>(0..=10_000))]
    pub trials: usize,
    /// Seed of the trials
    #[arg(long, value_name = "N", default_value = "0", value_parser = whole(0..=u64::MAX))]
    pub seed: u64,
    /// Write the grasps as a file of grasps, with their robust scores and numbers of trials (with --trials). After Ctrl-C,
    /// finished results are kept beside it, and the same command resumes from them
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Record the motion (with --grasp): .glb, .gif, or .json for `cranny render`
    #[arg(long, value_name = "FILE", requires = "grasp")]
    pub record: Option<PathBuf>,
}

/// Output of `simulate grasps --json`; its keys are stable.
#[derive(Serialize)]
struct Simulated {
    subject: String,
    hand: String,
    grasps: usize,
    held: usize,
    success_rate: f64,
    /// 95 % confidence interval of the success rate.
    wilson_interval: Option<[f64; 2]>,
    /// True if Ctrl-C left grasps untested.
    stopped: bool,
    /// Number of rows that an earlier run of the same command had finished.
    known: usize,
    /// Total number of grasps to test.
    wanted: usize,
    /// File of the grasps with their robust scores.
    #[serde(skip_serializing_if = "Option::is_none")]
    file: Option<PathBuf>,
    /// File of the finished rows, from which the same command resumes.
    #[serde(skip_serializing_if = "Option::is_none")]
    unfinished: Option<PathBuf>,
    /// Agreement of the computed load with the simulated outcomes, if it was computed.
    #[serde(skip_serializing_if = "Option::is_none")]
    load: Option<LoadPrediction>,
    rows: Vec<Row>,
}

#[derive(Serialize)]
struct Row {
    #[serde(flatten)]
    row: GraspRow,
    /// 95 % confidence interval of the robust score.
    #[serde(skip_serializing_if = "Option::is_none")]
    robust_interval: Option<[f64; 2]>,
}

pub fn run(arguments: &SimulateGraspsArguments, output: Output) -> Result<Answer, Failure> {
    let recorded = arguments
        .record
        .as_deref()
        .map(|file| recording::kind_of(file).map(|kind| (file, kind)))
        .transpose()?;
    if let Some((file, kind)) = recorded {
        output_file::check(file, kind, output)?;
    }
    if let Some(file) = &arguments.output {
        if arguments.trials == 0 {
            let problem = "a robust score needs --trials, such as --trials 32".to_owned();
            return Err(flag("output", problem));
        }
        output_file::check(file, FileKind::Grasps, output)?;
    }
    let Subject { name, hand, test, grasps, given } = Subject::open(&arguments.subject, output)?;
    let grasps = grasps.grasps();
    let chosen: Vec<usize> = match arguments.grasp {
        None => (0..grasps.len()).collect(),
        Some(grasp) if grasp < grasps.len() => vec![grasp],
        Some(_) => return Err(flag("grasp", text::only_so_many(grasps.len(), "grasp"))),
    };
    let trials = (arguments.trials, arguments.seed);
    let unfinished = match &arguments.output {
        None => None,
        Some(file) => {
            // All inputs of a row: hand, object, surroundings, physics and motion; the grasps; the trials.
            let depends_on = [&format!("{test:?}"), &csv_text(&given), &format!("{trials:?}")];
            Some(Unfinished::beside(file, &depends_on.map(String::as_str), output)?)
        }
    };
    let known: Vec<GraspRow> = unfinished.as_ref().map_or(Ok(Vec::new()), Unfinished::rows)?;
    let is_open = |grasp: &usize| known.iter().all(|row| row.grasp != *grasp);
    let open: Vec<usize> = chosen.iter().copied().filter(is_open).collect();
    let (wanted, known_count) = (chosen.len(), chosen.len() - open.len());
    let stop = stop_on_interrupt();
    let progress = bar((open.len() * (1 + arguments.trials)) as u64, output.quiet);
    let rows = tried(&test, grasps, &open, trials, &progress, &|| stop.load(Ordering::Relaxed));
    progress.finish_and_clear();
    let mut rows = [known, rows].concat();
    rows.retain(|row| chosen.contains(&row.grasp));
    rows.sort_by_key(|row| row.grasp);
    let stopped = rows.len() < wanted;
    let (mut written, mut kept) = (None, None);
    if let (Some(file), Some(unfinished)) = (&arguments.output, &unfinished) {
        if stopped {
            kept = Some(unfinished.keep(&rows)?.to_owned());
        } else {
            let set = with_robust_scores(&given, &rows)?;
            output_file::write(file, FileKind::Grasps, csv_text(&set).as_bytes(), output)?;
            unfinished.clear()?;
            written = Some(file.clone());
        }
    }
    let held = rows.iter().filter(|row| row.outcome == GraspOutcome::Held).count();
    let with_interval = |row: GraspRow| {
        let robust_interval = row.robust.and_then(|robust| interval(robust.held, robust.trials));
        Row { row, robust_interval }
    };
    let simulated = Simulated {
        subject: name,
        hand: hand.name,
        grasps: rows.len(),
        held,
        success_rate: held as f64 / rows.len().max(1) as f64,
        wilson_interval: interval(held, rows.len()),
        stopped,
        known: known_count,
        wanted,
        file: written,
        unfinished: kept,
        load: LoadPrediction::of(&rows),
        rows: rows.into_iter().map(with_interval).collect(),
    };
    if let (Some((file, kind)), [grasp]) = (recorded, &chosen[..]) {
        let run = test.run(&grasps[*grasp].world_from_gripper, &Disturbance::default(), true);
        let recording =
            recording::of_run(&simulated.subject, test.surroundings(), &run.recording.unwrap_or_default());
        recording::write(&recording, file, kind, output)?;
    }
    text::answer(&simulated, || simulated.page(), output)?;
    Ok(if held > 0 && !simulated.stopped { Answer::Done } else { Answer::No })
}

/// Tests grasps in batches; when stopped, only the current batch is incomplete.
pub fn tried(
    test: &GraspTest,
    grasps: &[Grasp],
    open: &[usize],
    trials: (usize, u64),
    progress: &ProgressBar,
    is_stopped: &(dyn Fn() -> bool + Sync),
) -> Vec<GraspRow> {
    // Enough runs to keep all threads busy.
    let at_a_time = (4 * rayon::current_num_threads()).div_ceil(1 + trials.0);
    let batches = open.chunks(at_a_time).take_while(|_| !is_stopped());
    batches.flat_map(|some| test.rows(grasps, some, trials, &|| progress.inc(1), is_stopped)).collect()
}

impl Simulated {
    fn page(&self) -> String {
        let percent = |share: f64| format!("{:.1} %", 100.0 * share);
        let sure = self.wilson_interval.map_or_else(String::new, |[low, high]| {
            format!(", {} to {} at 95 %", percent(low), percent(high))
        });
        let mut page = format!(
            "{}: {} holds {} of {} ({}{sure})\n",
            self.subject,
            self.hand,
            self.held,
            counted(self.grasps, "grasp"),
            percent(self.success_rate)
        );
        let mut outcomes: BTreeMap<&str, usize> = BTreeMap::new();
        for row in &self.rows {
            *outcomes.entry(row.row.outcome.name()).or_default() += 1;
        }
        for (outcome, count) in outcomes {
            let _ = writeln!(page, "  {count:>5}  {outcome}");
        }
        let robust = self.rows.iter().filter_map(|Row { row, .. }| Some((row, row.robust?.score())));
        let mut robust: Vec<(&GraspRow, f64)> = robust.collect();
        robust.sort_by(|a, b| b.1.total_cmp(&a.1));
        for (row, score) in robust.into_iter().take(MOST_SHOWN) {
            let geometric = text::score(row.score);
            let _ =
                writeln!(page, "  grasp {:>4}: robust score {score:.2}, geometric {geometric}", row.grasp);
        }
        match &self.load {
            Some(load) if self.rows.len() > 1 => page.push_str(&load.page()),
            None if self.rows.first().is_some_and(|Row { row, .. }| row.load.is_none()) => {
                page.push_str(
                    "  load        not computed: the hand does not have two flat pads that close on each \
                     other\n",
                );
            }
            _ => {}
        }
        if let [Row { row, .. }] = &self.rows[..] {
            let moved = text::millimetres(row.translation_error_m);
            let turned = text::degrees(row.rotation_error_rad);
            let (held_s, force_n) = (row.held_s, row.contact_force_n);
            let _ = writeln!(
                page,
                "  moved {moved}, turned {turned}, held {held_s:.2} s, pressed with {force_n:.1} N"
            );
            if let Some(load) = row.load {
                let _ = writeln!(page, "  load        {}", load_text(&load));
            }
        }
        if self.known > 0 {
            let _ = writeln!(page, "  {} of them by an earlier run", self.known);
        }
        if let Some(file) = &self.file {
            let _ = writeln!(page, "  written to {}", file.display());
        }
        if self.stopped {
            let left = self.wanted - self.grasps;
            let _ = write!(page, "stopped: {left} of {} not tried", counted(self.wanted, "grasp"));
            if let Some(file) = &self.unfinished {
                let _ = write!(page, "; run the same command again to continue from {}", file.display());
            }
            page.push('\n');
        }
        page
    }
}

/// Returns the grasps with the robust scores of the tested ones; the others keep theirs.
fn with_robust_scores(given: &GraspSet, rows: &[GraspRow]) -> Result<GraspSet, Failure> {
    let mut grasps: Vec<Grasp> = given.grasps().to_vec();
    for row in rows {
        grasps[row.grasp].robust = row.robust;
    }
    Ok(GraspSet::new(grasps).map_err(ScenarioError::from)?)
}

/// Maximum number of robust scores printed.
const MOST_SHOWN: usize = 10;

fn interval(held: usize, trials: usize) -> Option<[f64; 2]> {
    wilson(held, trials).map(|interval| [interval.low, interval.high])
}
