use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::PathBuf;
use std::sync::atomic::Ordering;

use clap::Args;
use cranny_bench::statistics::wilson;
use cranny_bench::{BenchError, Results, SimulatedGrasp, StoredTrial, source_of};
use cranny_file::counted;
use cranny_grasp::{GraspSet, csv_text};
use cranny_scenario::{OpenOptions, TargetPhysics};
use cranny_sim::{GraspOutcome, GraspRow, GraspTest};
use cranny_task::robot_hand;
use serde::Serialize;

use crate::arguments::Output;
use crate::failure::Failure;
use crate::number_argument::whole;
use crate::physics::simulate_grasps::tried;
use crate::planning::task::open_scenario;
use crate::progress::{bar, stop_on_interrupt};
use crate::unfinished::Unfinished;
use crate::{Answer, text};

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny simulate results results.db
  cranny simulate results results.db --trials 32 --json

Each grasp at which a solved trial ends is tried once, as `cranny simulate grasps` does it: the hand alone, in the
scenario of the trial. What came of it is kept in the same file, in a table simulated_grasps, in the place of what was
kept there under the same settings; trials stay as they are. A scenario that cannot be simulated, such as one whose
target has no mass, is skipped and named; then the exit code is 1.")]
pub struct SimulateResultsArguments {
    /// File of campaign results, as `cranny bench run` wrote it
    #[arg(value_name = "RESULTS")]
    pub results: PathBuf,
    /// Simulate only the support of the target, without the other surroundings; the hand may then overlap obstacles
    #[arg(long)]
    pub support_only: bool,
    /// Number of additional trials of each grasp, with small errors in everything, for its robust score
    #[arg(long, value_name = "N", default_value = "0", value_parser = whole::<usize>(0..=10_000))]
    pub trials: usize,
    /// Seed of these trials
    #[arg(long, value_name = "N", default_value = "0", value_parser = whole(0..=u64::MAX))]
    pub seed: u64,
}

/// Output of `simulate results --json`; its keys are stable.
#[derive(Serialize)]
struct Simulated {
    results: PathBuf,
    /// Settings of the tests, by which their rows in the table are identified.
    settings: Settings,
    scenarios: usize,
    grasps: usize,
    held: usize,
    /// Scenarios that cannot be simulated; their trials are not counted.
    skipped: Vec<Skipped>,
    /// True if Ctrl-C left grasps unprocessed; the table is then not written.
    stopped: bool,
    /// File of the finished rows, from which the same command resumes.
    #[serde(skip_serializing_if = "Option::is_none")]
    unfinished: Option<PathBuf>,
    planners: Vec<PlannerGrasps>,
}

#[derive(Serialize)]
struct Skipped {
    scenario: String,
    /// Number of solved trials.
    trials: usize,
    reason: String,
}

#[derive(Clone, Copy, Serialize)]
struct Settings {
    support_only: bool,
    trials: usize,
    seed: u64,
}

/// Final grasps of a planner's solved trials.
#[derive(Serialize)]
struct PlannerGrasps {
    planner: String,
    settings: String,
    criterion: &'static str,
    /// Number of solved trials.
    solved: usize,
    /// Number of solved trials whose grasp keeps the object.
    held: usize,
    held_rate: f64,
    /// 95 % confidence interval of the rate of such trials.
    wilson_interval: Option<[f64; 2]>,
    /// Mean over the solved trials.
    #[serde(skip_serializing_if = "Option::is_none")]
    robust_score: Option<f64>,
}

/// Id and content hash of a scenario.
type ScenarioKey = (String, String);

/// Test result of each grasp of a scenario.
type Rows = BTreeMap<(ScenarioKey, usize), GraspRow>;

#[allow(clippy::too_many_lines, reason = "one step after the other")]
pub fn run(arguments: &SimulateResultsArguments, output: Output) -> Result<Answer, Failure> {
    let file = &arguments.results;
    let results = Results::open(file)?;
    let mut solved = results.trials()?;
    solved.retain(|trial| trial.record.is_solved() && trial.record.grasp.is_some());
    if solved.is_empty() {
        let problem = "no trial is solved at a grasp, so there is nothing to simulate".to_owned();
        return Err(Failure::File { path: file.clone(), problem });
    }
    let mut wanted: BTreeMap<ScenarioKey, (&StoredTrial, BTreeSet<usize>)> = BTreeMap::new();
    for trial in &solved {
        let entry = wanted.entry(scenario_of(trial)).or_insert_with(|| (trial, BTreeSet::new()));
        entry.1.extend(trial.record.grasp);
    }
    // All scenarios are opened before the first is simulated, so that errors are reported at once.
    let (mut tests, mut skipped) = (Vec::new(), Vec::new());
    for (key, (trial, chosen)) in wanted {
        let own = &trial.record.trial;
        let source = source_of(&results, &own.scenario, &own.scenario_hash, None).map_err(|fault| match fault {
            BenchError::OtherScenario { scenario, source_name } => {
                let problem = format!(
                    "scenario {scenario} differs from that of its trials: its content has changed, or it was \
                     moved; restore the original at {source_name}"
                );
                Failure::File { path: file.clone(), problem }
            }
            other => other.into(),
        })?;
        let scenario = open_scenario(&source, &OpenOptions::default(), output)?;
        let (last, count) = (chosen.last().copied().unwrap_or(0), scenario.grasps.len());
        if last >= count {
            let problem = format!(
                "a trial ends at grasp {last} of {}, which has {}",
                scenario.id,
                counted(count, "grasp")
            );
            return Err(Failure::File { path: file.clone(), problem });
        }
        let hand = robot_hand(&scenario.robot);
        match GraspTest::of_scenario(&scenario, &hand, &TargetPhysics::default(), arguments.support_only) {
            Ok(test) => tests.push((key, test, scenario.grasps, chosen.into_iter().collect::<Vec<_>>())),
            Err(reason) => {
                let trials = solved.iter().filter(|trial| scenario_of(trial) == key).count();
                skipped.push(Skipped { scenario: scenario.id, trials, reason: reason.to_string() });
            }
        }
    }
    for Skipped { scenario, trials, reason } in &skipped {
        let trials = counted(*trials, "solved trial");
        text::note(&format!(
            "{scenario} is skipped with its {trials}, for it cannot be simulated: {reason}"
        ))?;
    }
    if tests.is_empty() {
        let problem = "none of its scenarios can be simulated".to_owned();
        return Err(Failure::File { path: file.clone(), problem });
    }
    drop(results);

    let stop = stop_on_interrupt();
    let is_stopped = || stop.load(Ordering::Relaxed);
    let (support_only, trials, seed) = (arguments.support_only, arguments.trials, arguments.seed);
    let settings = Settings { support_only, trials, seed };
    let settings_text = serde_json::to_string(&settings).map_err(std::io::Error::other)?;
    let of_test = |(key, test, grasps, _): &(ScenarioKey, GraspTest, GraspSet, Vec<usize>)| {
        format!("{key:?} {test:?} {}", csv_text(grasps))
    };
    let depends_on: Vec<String> =
        std::iter::once(settings_text.clone()).chain(tests.iter().map(of_test)).collect();
    let depends_on: Vec<&str> = depends_on.iter().map(String::as_str).collect();
    let unfinished = Unfinished::beside(file, &depends_on, output)?;
    let known: Vec<(ScenarioKey, GraspRow)> = unfinished.rows()?;
    let mut rows: Rows = known.into_iter().map(|(key, row)| ((key, row.grasp), row)).collect();
    rows.retain(|(key, grasp), _| {
        tests.iter().any(|(own, _, _, chosen)| own == key && chosen.contains(grasp))
    });
    for (key, _, _, chosen) in &mut tests {
        chosen.retain(|&grasp| !rows.contains_key(&(key.clone(), grasp)));
    }
    let open: usize = tests.iter().map(|(_, _, _, chosen)| chosen.len()).sum();
    let wanted = rows.len() + open;
    let progress = bar((open * (1 + trials)) as u64, output.quiet);
    let scenarios = tests.len();
    for (key, test, grasps, chosen) in tests {
        let found = tried(&test, grasps.grasps(), &chosen, (trials, seed), &progress, &is_stopped);
        rows.extend(found.into_iter().map(|row| ((key.clone(), row.grasp), row)));
    }
    progress.finish_and_clear();

    let stopped = rows.len() < wanted;
    let mut kept_in = None;
    if stopped {
        let finished: Vec<(&ScenarioKey, &GraspRow)> =
            rows.iter().map(|((key, _), row)| (key, row)).collect();
        kept_in = Some(unfinished.keep(&finished)?.to_owned());
    } else {
        let kept: Vec<SimulatedGrasp> = rows.iter().map(kept).collect();
        Results::create(file)?.keep_simulated_grasps(&settings_text, &kept)?;
        unfinished.clear()?;
    }
    let simulated = Simulated {
        results: file.clone(),
        settings,
        scenarios,
        grasps: rows.len(),
        held: rows.values().filter(|row| is_held(row)).count(),
        skipped,
        stopped,
        unfinished: kept_in,
        planners: of_planners(&solved, &rows),
    };
    text::answer(&simulated, || simulated.page(), output)?;
    Ok(if stopped || !simulated.skipped.is_empty() { Answer::No } else { Answer::Done })
}

fn scenario_of(trial: &StoredTrial) -> ScenarioKey {
    let trial = &trial.record.trial;
    (trial.scenario.clone(), trial.scenario_hash.clone())
}

fn is_held(row: &GraspRow) -> bool {
    row.outcome == GraspOutcome::Held
}

/// Returns a row of the stored table.
fn kept((((scenario, scenario_hash), _), row): (&(ScenarioKey, usize), &GraspRow)) -> SimulatedGrasp {
    SimulatedGrasp {
        scenario: scenario.clone(),
        scenario_hash: scenario_hash.clone(),
        grasp: row.grasp,
        outcome: row.outcome.name().to_owned(),
        translation_error_m: row.translation_error_m,
        rotation_error_rad: row.rotation_error_rad,
        held_s: row.held_s,
        contact_force_n: row.contact_force_n,
        robust: row.robust.map(|robust| (robust.held, robust.trials)),
    }
}

/// Aggregates the test results by planner, settings and criterion.
fn of_planners(solved: &[StoredTrial], rows: &Rows) -> Vec<PlannerGrasps> {
    let mut of_planner: BTreeMap<(&str, &str, &'static str), Vec<&GraspRow>> = BTreeMap::new();
    for stored in solved {
        let trial = &stored.record.trial;
        let row = stored.record.grasp.and_then(|grasp| rows.get(&(scenario_of(stored), grasp)));
        let key = (trial.planner.as_str(), trial.settings.as_str(), trial.criterion.name());
        of_planner.entry(key).or_default().extend(row);
    }
    let planner = |((planner, settings, criterion), rows): ((&str, &str, _), Vec<&GraspRow>)| {
        let (solved, held) = (rows.len(), rows.iter().filter(|row| is_held(row)).count());
        let robust: Option<Vec<f64>> =
            rows.iter().map(|row| row.robust.map(|robust| robust.score())).collect();
        PlannerGrasps {
            planner: planner.to_owned(),
            settings: settings.to_owned(),
            criterion,
            solved,
            held,
            held_rate: held as f64 / solved.max(1) as f64,
            wilson_interval: wilson(held, solved).map(|interval| [interval.low, interval.high]),
            robust_score: robust.map(|scores| scores.iter().sum::<f64>() / solved.max(1) as f64),
        }
    };
    of_planner.into_iter().filter(|(_, rows)| !rows.is_empty()).map(planner).collect()
}

impl Simulated {
    fn page(&self) -> String {
        let percent = |share: f64| format!("{:.1} %", 100.0 * share);
        let Self { results, grasps, held, scenarios, .. } = self;
        let results = results.display();
        let (grasps, scenarios) = (counted(*grasps, "grasp"), counted(*scenarios, "scenario"));
        let mut page = format!("{results}: {held} of {grasps} held, in {scenarios}; solved trials:\n");
        for PlannerGrasps {
            planner,
            criterion,
            solved,
            held,
            held_rate,
            wilson_interval,
            robust_score,
            ..
        } in &self.planners
        {
            let sure = wilson_interval.map_or_else(String::new, |[low, high]| {
                format!(", {} to {} at 95 %", percent(low), percent(high))
            });
            let robust = robust_score
                .map_or_else(String::new, |score| format!(", robust score {score:.2} on average"));
            let share = percent(*held_rate);
            let _ = writeln!(
                page,
                "  {planner:<14}{criterion:<6} {held} of {solved} end at a grasp that is held ({share}{sure}){robust}"
            );
        }
        for Skipped { scenario, trials, .. } in &self.skipped {
            let _ = writeln!(page, "  skipped: {scenario} with {}", counted(*trials, "solved trial"));
        }
        let end = match &self.unfinished {
            Some(file) => format!(
                "stopped before the end; run the same command again to continue from {}",
                file.display()
            ),
            None => "kept in its table simulated_grasps".to_owned(),
        };
        let _ = writeln!(page, "  {end}");
        page
    }
}
