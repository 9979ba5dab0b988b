use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use clap::{Args, Subcommand};
use cranny_file::counted;
use cranny_grasp::{
    COVERAGE_THRESHOLD, Grasp, GraspSet, SampledGrasp, Sampling, TooWide, csv_text, nearest_distances,
    read_csv, resume_sampling, spread,
};
use cranny_scenario::{OpenOptions, Scenario, ScenarioError};
use cranny_shape::Surface;
use cranny_task::{APPROACH_M, FailureReason, HandFilter, robot_hand};
use serde::Serialize;

use crate::arguments::Output;
use crate::choices::{LeastScore, ScoreArgument, least_score};
use crate::content::grasp_loads::{GraspLoads, sorted};
use crate::content::grasp_subject::{SampleArguments, Subject};
use crate::content::grasps_import::ImportArguments;
use crate::failure::Failure;
use crate::file_kind::FileKind;
use crate::progress::{bar, stop_on_interrupt, unless_stopped};
use crate::unfinished::Unfinished;
use crate::{Answer, content::grasps_import, output_file, text};

#[derive(Clone, Debug, Args)]
pub struct GraspsArguments {
    #[command(subcommand)]
    pub command: GraspsCommand,
}

#[derive(Clone, Debug, Subcommand)]
pub enum GraspsCommand {
    /// Sample antipodal grasps on an object, on a mesh, or on the target of a scenario
    Sample(Box<SampleArguments>),
    /// Keep the grasps that the hand alone can reach in a scenario
    Filter(FilterArguments),
    /// Measure how much of one set of grasps another covers
    Coverage(CoverageArguments),
    /// Measure the distances between the grasps of a file
    Distances(DistancesArguments),
    #[command(
        name = "import",
        about = "Read grasps of other projects: ACRONYM, GraspNet, GraspGen, Isaac, NumPy"
    )]
    Import(ImportArguments),
}

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny grasps filter 021 -o free.csv
  cranny grasps filter my_shelf --grasps mine.csv --approach 30 -o free.csv
  cranny grasps filter 031 --min-score load=2 --sort load -o firm.csv

Grasps of a file are those of the scenario's planning frame. A grasp stays if the hand, or the hand turned by
180°, is free at it and along the approach. The load of each, the factor by which gravity may grow before a pad
slips, is computed and written beside its score.")]
pub struct FilterArguments {
    /// Built-in scenario, or the folder of one
    #[arg(value_name = "ID")]
    pub id: String,
    /// File of grasps to filter [default: the scenario's own]
    #[arg(long, value_name = "FILE")]
    pub grasps: Option<PathBuf>,
    /// File to write the remaining grasps to [default: none]
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Length of the straight approach that must be free, in millimetres
    #[arg(long, value_name = "MM", default_value_t = APPROACH_M * 1000.0)]
    pub approach: f64,
    /// Keep only grasps of at least this score, from 0 to 1, or of this load, from 0: `load=2`. Without a kind: geometric
    #[arg(long, value_name = "[KIND=]S", allow_hyphen_values = true, value_parser = least_score)]
    pub min_score: Option<LeastScore>,
    /// Sort the grasps by this score, highest first
    #[arg(long, value_enum, value_name = "KIND")]
    pub sort: Option<ScoreArgument>,
}

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny grasps coverage reference.csv mine.csv
  cranny grasps coverage reference.csv mine.csv --threshold 30 --json")]
pub struct CoverageArguments {
    /// Grasps to be covered
    #[arg(value_name = "REFERENCE")]
    pub reference: PathBuf,
    /// Grasps that cover them
    #[arg(value_name = "SET")]
    pub set: PathBuf,
    /// Distance within which a grasp counts as covered, in millimetres plus degrees
    #[arg(long, value_name = "D", default_value_t = COVERAGE_THRESHOLD)]
    pub threshold: f64,
}

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny grasps distances grasps.csv")]
pub struct DistancesArguments {
    /// File of grasps
    #[arg(value_name = "GRASPS")]
    pub grasps: PathBuf,
}

pub fn run(arguments: &GraspsArguments, output: Output) -> Result<Answer, Failure> {
    match &arguments.command {
        GraspsCommand::Sample(arguments) => sample(arguments, output),
        GraspsCommand::Filter(arguments) => filter(arguments, output),
        GraspsCommand::Coverage(arguments) => coverage(arguments, output),
        GraspsCommand::Distances(arguments) => distances(arguments, output),
        GraspsCommand::Import(arguments) => grasps_import::run(arguments, output),
    }
}

/// Output of `grasps sample --json`.
#[derive(Serialize)]
struct Sampled {
    object: String,
    grasps: usize,
    candidates: usize,
    first_contacts: usize,
    pairs: usize,
    rejected: usize,
    merged: usize,
    best_score: f64,
    mean_score: f64,
    /// Required hold factor.
    #[serde(skip_serializing_if = "Option::is_none")]
    hold: Option<f64>,
    /// Loads of the grasps, if they can be computed.
    #[serde(skip_serializing_if = "Option::is_none")]
    load: Option<GraspLoads>,
    stopped: bool,
    /// File of the candidates, from which the same command resumes.
    #[serde(skip_serializing_if = "Option::is_none")]
    unfinished: Option<PathBuf>,
    /// Reason for not sampling: the object is too wide for the hand.
    #[serde(skip_serializing_if = "Option::is_none")]
    too_wide: Option<TooWide>,
    file: Option<PathBuf>,
}

fn sample(arguments: &SampleArguments, output: Output) -> Result<Answer, Failure> {
    // Checks the output file before the search.
    output_file::check(&arguments.output, FileKind::Grasps, output)?;
    let subject = Subject::open(arguments)?;
    let surface = Surface::new(&subject.mesh).map_err(ScenarioError::from)?;
    let settings = subject.settings(arguments);
    let filter =
        if arguments.bare { None } else { Some(subject.filter(&surface, arguments.approach / 1000.0)?) };
    let measured = subject.load_measure(arguments)?;
    let stop = stop_on_interrupt();
    let demand = measured.as_ref().and_then(|(measure, _)| Some((measure, arguments.hold?)));
    let filters = (arguments.approach, arguments.bare, arguments.hold, arguments.mass);
    let unfinished = Unfinished::beside(
        &arguments.output,
        &[&format!("{subject:?}"), &format!("{settings:?} {filters:?}")],
        output,
    )?;
    let known = unfinished.rows::<Sampling>()?.pop().unwrap_or_default();
    let progress = bar(settings.count as u64, output.quiet);
    let is_firm = |grasp: &Grasp| {
        demand.is_none_or(|(measure, factor)| {
            let pose = &grasp.world_from_gripper;
            measure.is_firm(pose, factor) && measure.is_seated(pose)
        })
    };
    let accept = |sampled: &SampledGrasp| {
        is_firm(&sampled.grasp) && filter.as_ref().is_none_or(|f| f.is_free(&sampled.grasp))
    };
    // Checked before a million contacts are sampled in vain.
    let too_wide = TooWide::of(&surface, &settings, 0.0);
    let mut going_on = |count| {
        progress.set_position(count as u64);
        !stop.load(Ordering::Relaxed)
    };
    let found = match too_wide {
        Some(_) => Ok(Sampling::default()),
        None => resume_sampling(known, &surface, &settings, &accept, &mut going_on),
    };
    progress.finish_and_clear();
    let found = found.map_err(ScenarioError::from)?;
    let candidates: Vec<Grasp> = found.grasps.iter().map(|sampled| sampled.grasp).collect();
    let (choice, count, seed) = (arguments.choose, arguments.count, arguments.seed);
    let choose = move || {
        let chosen = choice.choose(&candidates, count, seed);
        chosen.into_iter().map(|index| candidates[index]).collect::<Vec<Grasp>>()
    };
    let is_whole = found.grasps.len() >= settings.count || found.first_contacts >= settings.most_contacts;
    let chosen = if is_whole || too_wide.is_some() { unless_stopped(&stop, choose) } else { None };
    let kept_in = match chosen {
        None => Some(unfinished.keep(std::slice::from_ref(&found))?.to_owned()),
        Some(_) => None,
    };
    let chosen = chosen.unwrap_or_default();
    let scores = || chosen.iter().filter_map(|grasp| grasp.score);
    let mut sampled = Sampled {
        object: subject.name,
        grasps: chosen.len(),
        candidates: found.grasps.len(),
        first_contacts: found.first_contacts,
        pairs: found.pairs,
        rejected: found.rejected,
        merged: found.merged,
        best_score: scores().fold(0.0, f64::max),
        // The sum of an empty iterator is −0.
        mean_score: (scores().sum::<f64>() + 0.0) / chosen.len().max(1) as f64,
        hold: arguments.hold,
        load: None,
        stopped: kept_in.is_some(),
        unfinished: kept_in,
        too_wide,
        file: None,
    };
    let mut set = GraspSet::new(chosen).map_err(ScenarioError::from)?;
    if let Some((measure, is_mass_assumed)) = &measured {
        set = set.with_loads(measure);
        sampled.load = GraspLoads::of(&set, *is_mass_assumed);
    }
    if let Some(kind) = arguments.sort {
        set = sorted(&set, kind.into());
    }
    if !set.is_empty() {
        output_file::write(&arguments.output, FileKind::Grasps, csv_text(&set).as_bytes(), output)?;
        sampled.file = Some(arguments.output.clone());
    }
    if !sampled.stopped {
        unfinished.clear()?;
    }
    text::answer(&sampled, || sampled.page(), output)?;
    // Fewer grasps than requested are a negative result, although they are written.
    Ok(if set.len() == arguments.count { Answer::Done } else { Answer::No })
}

/// Writes grasps, or the partial result of a stopped command, and returns the file.
fn written(file: &Path, set: &GraspSet, is_stopped: bool, output: Output) -> Result<PathBuf, Failure> {
    let text = csv_text(set);
    if is_stopped {
        return output_file::write_part(file, FileKind::Grasps, text.as_bytes(), output);
    }
    output_file::write(file, FileKind::Grasps, text.as_bytes(), output)?;
    Ok(file.to_owned())
}

impl Sampled {
    fn page(&self) -> String {
        let mut page = String::new();
        let mut line = |name: &str, value: String| {
            let _ = writeln!(page, "  {name:<14}{value}");
        };
        line("object", self.object.clone());
        line("grasps", format!("{} of {}", self.grasps, counted(self.candidates, "candidate")));
        line(
            "contacts",
            format!("{} from {}", counted(self.pairs, "pair"), counted(self.first_contacts, "first contact")),
        );
        let rejected = if self.hold.is_some() { "hand collides or does not hold" } else { "hand collides" };
        line("left out", format!("{} {rejected}, {} the same as another", self.rejected, self.merged));
        line("score", format!("{:.3} on average, {:.3} at best", self.mean_score, self.best_score));
        if let Some(load) = &self.load {
            line("load", load.text());
        }
        if let Some(file) = &self.unfinished {
            line(
                "stopped",
                format!("the candidates are in {}; run the same command again to continue", file.display()),
            );
            return page;
        }
        let file = self.file.as_ref().map(|file| file.display().to_string());
        let why_not = match self.too_wide {
            Some(too_wide) => too_wide.to_string(),
            None => "no grasp was found".to_owned(),
        };
        line("written to", file.unwrap_or_else(|| format!("nowhere: {why_not}")));
        page
    }
}

/// Output of `grasps filter --json`.
#[derive(Serialize)]
struct Filtered {
    scenario: String,
    grasps: usize,
    free: usize,
    /// Number of free grasps left out because of their score.
    below_min_score: usize,
    /// Loads of the remaining grasps, if they can be computed.
    #[serde(skip_serializing_if = "Option::is_none")]
    load: Option<GraspLoads>,
    blocked_by: Vec<Blocking>,
    /// Number of grasps whose stated width the hand cannot take.
    wrong_width: usize,
    stopped: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    file: Option<PathBuf>,
}

#[derive(Serialize)]
struct Blocking {
    body: String,
    grasps: usize,
}

fn filter(arguments: &FilterArguments, output: Output) -> Result<Answer, Failure> {
    if let Some(path) = &arguments.output {
        output_file::check(path, FileKind::Grasps, output)?;
    }
    let scenario = Scenario::open(&arguments.id, &OpenOptions::default())?;
    let scenario = match &arguments.grasps {
        Some(path) => scenario.with_grasps(read_csv(path).map_err(ScenarioError::from)?),
        None => scenario,
    };
    let set = &scenario.grasps;
    let hand = robot_hand(&scenario.robot);
    let filter = HandFilter::new(&hand, scenario.world.clone(), arguments.approach / 1000.0)
        .map_err(ScenarioError::from)?;
    let mut blocked = vec![0; scenario.world.bodies().len()];
    let (mut free, mut wrong_width) = (Vec::new(), 0);
    let progress = bar(set.len() as u64, output.quiet);
    let stop = stop_on_interrupt();
    let mut tried = 0;
    for grasp in set.grasps() {
        if stop.load(Ordering::Relaxed) {
            break;
        }
        if FailureReason::of_width(&scenario.robot, grasp).is_some() {
            wrong_width += 1;
        } else if filter.is_free(grasp) {
            free.push(*grasp);
        } else if let Some(body) = filter.blocking_body(&grasp.world_from_gripper) {
            blocked[body] += 1;
        }
        tried += 1;
        progress.inc(1);
    }
    progress.finish_and_clear();
    let names = scenario.world.bodies().iter().map(|body| body.name.clone());
    let blocked_by = names.zip(blocked).filter(|(_, grasps)| *grasps > 0);
    let mut filtered = Filtered {
        scenario: scenario.id.clone(),
        grasps: tried,
        free: 0,
        below_min_score: 0,
        load: None,
        blocked_by: blocked_by.map(|(body, grasps)| Blocking { body, grasps }).collect(),
        wrong_width,
        stopped: tried < set.len(),
        file: None,
    };
    let free = GraspSet::new(free).map_err(ScenarioError::from)?;
    let load_model = scenario.load_model();
    let loaded = load_model.as_ref().map_or_else(|| free.clone(), |known| free.with_loads(known.measure()));
    let mut stays = match arguments.min_score {
        None => loaded,
        Some(least) => least.among(&loaded),
    };
    (filtered.free, filtered.below_min_score) = (stays.len(), free.len() - stays.len());
    filtered.load = load_model.and_then(|known| GraspLoads::of(&stays, known.is_mass_assumed));
    if let Some(kind) = arguments.sort {
        stays = sorted(&stays, kind.into());
    }
    if let Some(path) = arguments.output.as_ref().filter(|_| !stays.is_empty()) {
        filtered.file = Some(written(path, &stays, filtered.stopped, output)?);
    }
    text::answer(&filtered, || filtered.page(), output)?;
    Ok(if filtered.free > 0 && !filtered.stopped { Answer::Done } else { Answer::No })
}

impl Filtered {
    fn page(&self) -> String {
        let Self { scenario, grasps, free, below_min_score, .. } = self;
        let mut page = format!(
            "{scenario}: the hand alone can take {} of {}\n",
            free + below_min_score,
            counted(*grasps, "grasp")
        );
        if *below_min_score > 0 {
            let _ = writeln!(page, "  {below_min_score:>5}  of a lower score than demanded");
        }
        if let Some(load) = &self.load {
            let _ = writeln!(page, "  load {}", load.text());
        }
        for Blocking { body, grasps } in &self.blocked_by {
            let _ = writeln!(page, "  {grasps:>5}  blocked by {body}");
        }
        if self.wrong_width > 0 {
            let _ = writeln!(page, "  {:>5}  of a width that the hand cannot take", self.wrong_width);
        }
        if self.stopped {
            page.push_str("stopped before all grasps were tried");
            if let Some(file) = &self.file {
                let _ = write!(page, "; the free grasps found until then are in {}", file.display());
            }
            page.push('\n');
        }
        page
    }
}

/// Output of `grasps coverage --json`.
#[derive(Serialize)]
struct CoverageAnswer {
    coverage: f64,
    covered: usize,
    reference: usize,
    set: usize,
    threshold: f64,
    median_distance: f64,
}

fn coverage(arguments: &CoverageArguments, output: Output) -> Result<Answer, Failure> {
    if arguments.threshold.is_nan() || arguments.threshold <= 0.0 {
        return Err(Failure::Flag { flag: "threshold", problem: "expected a distance above 0".into() });
    }
    let read = |path| read_csv(path).map_err(ScenarioError::from);
    let (reference, set) = (read(&arguments.reference)?, read(&arguments.set)?);
    let mut distances = nearest_distances(reference.grasps(), set.grasps());
    distances.sort_by(f64::total_cmp);
    let covered = distances.iter().filter(|distance| **distance <= arguments.threshold).count();
    let answer = CoverageAnswer {
        coverage: covered as f64 / reference.len() as f64,
        covered,
        reference: reference.len(),
        set: set.len(),
        threshold: arguments.threshold,
        median_distance: distances[distances.len() / 2],
    };
    let CoverageAnswer { coverage, covered, reference, set, threshold, median_distance } = answer;
    let page = || {
        format!(
            "{:.1} % covered: {covered} of {}, within {threshold} (mm + degrees) of one of {set}; half within \
             {median_distance:.1}\n",
            coverage * 100.0,
            counted(reference, "grasp")
        )
    };
    text::answer(&answer, page, output.aloud())?;
    Ok(Answer::Done)
}

/// Output of `grasps distances --json`; distances in millimetres plus degrees.
#[derive(Serialize)]
struct DistancesAnswer {
    grasps: usize,
    least: Option<f64>,
    median: Option<f64>,
    greatest: Option<f64>,
}

/// Maximum number of grasps to compare: 5·10⁹ pairs, some minutes on a few cores.
const MOST_TO_COMPARE: usize = 100_000;

fn distances(arguments: &DistancesArguments, output: Output) -> Result<Answer, Failure> {
    let set = read_csv(&arguments.grasps).map_err(ScenarioError::from)?;
    if set.len() > MOST_TO_COMPARE {
        let problem = format!(
            "{} grasps make {:.0e} pairs, but at most {MOST_TO_COMPARE} grasps can be compared with each \
             other (give fewer rows)",
            set.len(),
            0.5 * set.len() as f64 * set.len() as f64
        );
        return Err(Failure::File { path: arguments.grasps.clone(), problem });
    }
    let spread = spread(set.grasps());
    let spread = DistancesAnswer {
        grasps: set.len(),
        least: spread.map(|spread| spread.least),
        median: spread.map(|spread| spread.median),
        greatest: spread.map(|spread| spread.greatest),
    };
    let number = |value: Option<f64>| value.map_or_else(|| "—".to_owned(), |d| format!("{d:.1}"));
    let [least, median, greatest] = [spread.least, spread.median, spread.greatest].map(number);
    let page = || {
        format!(
            "{}; between two of them, in mm + degrees: least {least}, median {median}, greatest \
             {greatest}\n",
            counted(spread.grasps, "grasp")
        )
    };
    text::answer(&spread, page, output.aloud())?;
    Ok(Answer::Done)
}
