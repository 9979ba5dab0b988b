use std::fmt::Write as _;
use std::io::Write as _;
use std::path::PathBuf;

use clap::Args;
use cranny_bench::{CampaignSettings, Replay, Results, RunInformation, Sandbox, replay};
use cranny_file::counted;
use cranny_record::write_waypoints_csv;
use serde::Serialize;

use crate::arguments::Output;
use crate::campaigns::bench_worker;
use crate::failure::Failure;
use crate::file_kind::FileKind;
use crate::number_argument::whole;
use crate::program::version::COMMIT;
use crate::progress::{spinner, stop_on_interrupt};
use crate::{Answer, output_file, text};

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny bench replay results.db 17
  cranny bench replay results.db 17 -o path.csv       keep the path, for `cranny verify`
  cranny bench replay results.db 17 --scenario ./035  the scenario has moved

Of a built-in planner the stored number of iterations is the budget, so that a trial which time cut short ends
at the same node. Exit 0: the same path, bit by bit, after the same search; exit 1: another one.")]
pub struct ReplayArguments {
    /// File of results
    #[arg(value_name = "RESULTS")]
    results: PathBuf,
    /// Number of the trial, from 1
    #[arg(value_name = "TRIAL", value_parser = whole::<u64>(1..=i64::MAX.cast_unsigned()))]
    trial: u64,
    /// Scenario to use, if it has moved
    #[arg(long, value_name = "ID")]
    scenario: Option<String>,
    /// Run the program that the results name, if the trial used an external program: only for results that you trust
    #[arg(long)]
    allow_exec: bool,
    /// Sandbox of that program, as in `bench run`
    #[arg(long, value_name = "SANDBOX", default_value = "auto", value_parser = bench_worker::sandbox)]
    sandbox: Sandbox,
    /// Write the way points to this file (.csv)
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// Output of `bench replay --json`.
#[derive(Serialize)]
struct Answered<'a> {
    trial: u64,
    scenario: &'a str,
    planner: &'a str,
    criterion: &'a str,
    seed: u64,
    goal: Option<usize>,
    same_path: bool,
    same_search: bool,
    outcome: &'a str,
    stored_outcome: &'a str,
    iterations: u64,
    stored_iterations: u64,
    planning_time_s: f64,
    stored_planning_time_s: f64,
    waypoints: &'a [Vec<f64>],
    stored_version: &'a str,
}

/// Memory limit of a replay: generous, so that memory does not end a search that a campaign completed.
const MEMORY_LIMIT_BYTES: u64 = 16 << 30;

pub fn run(arguments: &ReplayArguments, output: Output) -> Result<Answer, Failure> {
    if let Some(file) = &arguments.output {
        output_file::check(file, FileKind::Waypoints, output)?;
    }
    let results = Results::open(&arguments.results)?;
    let settings = CampaignSettings {
        worker: bench_worker::worker()?,
        workers: 1,
        memory_limit_bytes: MEMORY_LIMIT_BYTES,
        information: RunInformation::here(COMMIT, "", 1),
        sandbox: arguments.sandbox,
        again: Vec::new(),
    };
    let stop = stop_on_interrupt();
    let spinner = spinner("replaying", output.quiet);
    let source = arguments.scenario.as_deref();
    let replayed = replay(&results, arguments.trial, source, arguments.allow_exec, &settings, &stop);
    spinner.finish_and_clear();
    let Some(replayed) = replayed? else {
        writeln!(std::io::stderr(), "stopped before the trial had ended")?;
        return Ok(Answer::No);
    };
    let run = results.runs()?.into_iter().find(|run| run.id == replayed.stored.run);
    let version = run.map(|run| run.information.version).unwrap_or_default();
    if let (Some(file), false) = (&arguments.output, replayed.path.is_empty()) {
        output_file::check(file, FileKind::Waypoints, output)?;
        write_waypoints_csv(file, &replayed.path)?;
    }
    text::answer(&answered(&replayed, &version), || page(&replayed, &version), output)?;
    Ok(if replayed.is_same() { Answer::Done } else { Answer::No })
}

fn answered<'a>(replayed: &'a Replay, version: &'a str) -> Answered<'a> {
    let (stored, now) = (&replayed.stored.record, &replayed.record);
    Answered {
        trial: replayed.stored.id,
        scenario: &stored.trial.scenario,
        planner: &stored.trial.planner,
        criterion: stored.trial.criterion.name(),
        seed: stored.trial.seed,
        goal: stored.trial.goal,
        same_path: replayed.is_same_path,
        same_search: replayed.is_same_search,
        outcome: now.outcome.name(),
        stored_outcome: stored.outcome.name(),
        iterations: now.statistics.iterations,
        stored_iterations: stored.statistics.iterations,
        planning_time_s: now.statistics.planning_time_s,
        stored_planning_time_s: stored.statistics.planning_time_s,
        waypoints: &replayed.path,
        stored_version: version,
    }
}

fn page(replayed: &Replay, version: &str) -> String {
    let (stored, now) = (&replayed.stored.record, &replayed.record);
    let trial = &stored.trial;
    let mut page = format!(
        "trial {}: {} by {} (criterion {}, seed {}{})\n",
        replayed.stored.id,
        trial.scenario,
        trial.planner,
        trial.criterion.name(),
        trial.seed,
        trial.goal.map_or_else(String::new, |goal| format!(", goal {goal}")),
    );
    for (name, record) in [("stored", stored), ("replay", now)] {
        let _ = writeln!(
            page,
            "  {name:<8}{}, {}, {}, {:.3} s",
            record.outcome.name(),
            counted(record.statistics.iterations, "iteration"),
            counted(record.statistics.nodes, "node"),
            record.statistics.planning_time_s
        );
        if let Some(detail) = &record.detail {
            let _ = writeln!(page, "          {detail}");
        }
    }
    let way_points = replayed.path.len();
    let verdict = match (replayed.is_same_path, replayed.is_same_search) {
        (true, true) if way_points > 0 => {
            format!("the same path, bit by bit: {}", counted(way_points, "way point"))
        }
        (true, true) => "no path again, after the same search".to_owned(),
        (true, false) => "the same path, but after another search".to_owned(),
        (false, _) => "ANOTHER path".to_owned(),
    };
    let _ = writeln!(page, "  {verdict}");
    let here = env!("CARGO_PKG_VERSION");
    if !replayed.is_same() && version != here {
        let _ = writeln!(page, "  the trial was run by Cranny {version}; this is {here}");
    }
    page
}
