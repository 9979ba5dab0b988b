//! Logs for OMPL's tools: their content, and their conversion by the statistics script of the `ompl` package.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use cranny_bench::{BenchError, OmplLog, TrialOutcome};
use rusqlite::Connection;

use crate::synthetic::{Campaign, campaign, empty};

/// Returns the Python with `xtask/python-requirements.txt`, which `cargo xtask test` installs.
fn python() -> Option<PathBuf> {
    let python = std::env::var_os("CRANNY_PYTHON").map(PathBuf::from);
    if python.is_none() {
        assert!(std::env::var_os("CRANNY_REQUIRE_ALL").is_none(), "CRANNY_PYTHON is not set");
        // Writing to standard error directly bypasses the capture of the test runner, which would hide the skipped test.
        let _ = writeln!(
            std::io::stderr(),
            "SKIPPED: CRANNY_PYTHON is not set, so no log is read by OMPL's script"
        );
    }
    python
}

/// Converts logs to a database with OMPL's script.
fn database(python: &Path, folder: &Path, logs: &[OmplLog]) -> Connection {
    let names: Vec<String> = logs.iter().map(|log| format!("{}.log", log.name)).collect();
    for (log, name) in logs.iter().zip(&names) {
        std::fs::write(folder.join(name), &log.text).expect("the log is written");
    }
    let output = Command::new(python)
        .current_dir(folder)
        .args(["-W", "error", "-m", "ompl.ompl_benchmark_statistics", "-d", "arena.db"])
        .args(&names)
        .output()
        .expect("the script runs");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    assert_eq!(said, "", "the script complains");
    Connection::open(folder.join("arena.db")).expect("a database")
}

fn count(database: &Connection, sql: &str) -> usize {
    database.query_row(sql, [], |row| row.get(0)).unwrap_or_else(|fault| panic!("{sql}: {fault}"))
}

fn all(campaign: &Campaign) -> OmplLog {
    OmplLog::of_all(&campaign.source()).expect("a log")
}

#[test]
fn the_statistics_script_reads_one_experiment_of_all_trials() {
    let Some(python) = python() else { return };
    let (campaign, folder) = (campaign(), tempfile::tempdir().expect("a folder"));
    let database = database(&python, folder.path(), &[all(&campaign)]);
    assert_eq!(count(&database, "SELECT count(*) FROM experiments"), 1);
    assert_eq!(count(&database, "SELECT count(*) FROM runs"), campaign.trials.len());
    let solved = campaign.trials.iter().filter(|trial| trial.record.is_solved()).count();
    assert_eq!(count(&database, "SELECT count(*) FROM runs WHERE solved = 1"), solved);
    assert_eq!(count(&database, "SELECT count(*) FROM runs WHERE status = 6"), solved);
    // A failed run has no length, so that plots of lengths omit it instead of showing zero.
    assert_eq!(count(&database, "SELECT count(*) FROM runs WHERE solution_length IS NOT NULL"), solved);
    let crashed = "SELECT count(*) FROM runs JOIN enums ON runs.status = enums.value WHERE enums.name = 'status' AND \
                   enums.description = 'Crash'";
    assert_eq!(count(&database, crashed), 1);
}

#[test]
fn the_statistics_script_reads_one_experiment_a_scenario() {
    let Some(python) = python() else { return };
    let (campaign, folder) = (campaign(), tempfile::tempdir().expect("a folder"));
    let logs = OmplLog::of_each(&campaign.source()).expect("logs");
    let database = database(&python, folder.path(), &logs);
    assert_eq!(count(&database, "SELECT count(*) FROM experiments"), logs.len());
    assert_eq!(count(&database, "SELECT count(*) FROM runs"), campaign.trials.len());
    assert_eq!(count(&database, "SELECT count(*) FROM experiments WHERE version IS NULL"), 0);
    let sql = "SELECT timelimit, runcount, hostname, cpuinfo, date, dial_m FROM experiments WHERE name = '045-exact'";
    type Experiment = (f64, i64, String, String, String, f64);
    let found: Experiment = database
        .query_row(sql, [], |row| {
            Ok((row.get(0)?, row.get(1)?, row.get(2)?, row.get(3)?, row.get(4)?, row.get(5)?))
        })
        .expect("the experiment is there");
    let (processor, date) = ("A processor, of some kind\n", "2026-11-21T18:00:00Z");
    assert_eq!(found, (90.0, 20, "bench-host".to_owned(), processor.to_owned(), date.to_owned(), 0.54));
    let mean: f64 = database
        .query_row(
            "SELECT avg(time) FROM runs JOIN experiments ON experimentid = experiments.id JOIN plannerConfigs ON \
             plannerid = plannerConfigs.id WHERE experiments.name = '045-exact' AND plannerConfigs.name = 'reach'",
            [],
            |row| row.get(0),
        )
        .expect("reach has runs");
    let times: Vec<f64> = campaign
        .trials
        .iter()
        .filter(|trial| trial.record.trial.scenario == "045" && trial.record.trial.planner == "reach")
        .map(|trial| trial.record.statistics.planning_time_s)
        .collect();
    assert!((mean - times.iter().sum::<f64>() / times.len() as f64).abs() < 1e-12);
}

#[test]
fn a_log_has_the_lines_that_the_parser_wants_in_their_order() {
    let mut campaign = campaign();
    campaign
        .trials
        .retain(|trial| trial.record.trial.scenario == "041" && trial.record.trial.planner == "reach");
    let log = all(&campaign);
    assert_eq!(log.name, "041-exact");
    let lines: Vec<&str> = log.text.lines().collect();
    let wanted = [
        "Cranny version ",
        "Experiment 041-exact",
        "4 experiment properties",
        "scenario VARCHAR(512) = 041",
        "Running on bench-host",
        "Starting at 2026-11-21T18:00:00Z",
        "<<<|",
        "|>>>",
        "<<<|",
        "|>>>",
        "0 is the random seed",
        "30 seconds per run",
        "4096 MB per run",
        "20 runs per planner",
        "1 enum type",
        "1 planners",
        "reach",
        "4 common properties",
        "14 properties for each run",
        "20 runs",
        ".",
    ];
    let mut rest = lines.iter();
    for start in wanted {
        assert!(rest.any(|line| line.starts_with(start)), "no '{start}' in its place:\n{}", log.text);
    }
    let runs = lines.iter().filter(|line| line.ends_with("; "));
    assert!(runs.clone().all(|run| run.matches("; ").count() == 14));
    assert_eq!(runs.count(), 20);
}

#[test]
fn text_that_would_break_the_format_is_made_harmless() {
    let mut campaign = campaign();
    campaign.trials.truncate(3);
    for trial in &mut campaign.trials {
        trial.record.trial.planner = "exec:a; b\nc".to_owned();
        trial.record.outcome = TrialOutcome::Garbled;
    }
    campaign.runs[0].information.command = "cranny\n|>>>\nbench".to_owned();
    let log = all(&campaign);
    assert!(log.text.contains("\nexec:a, b\\nc\n"), "{}", log.text);
    assert_eq!(log.text.matches("|>>>").count(), 2, "{}", log.text);
    let (nothing, _) = empty();
    assert!(matches!(OmplLog::of_all(&nothing.source()), Err(BenchError::NoTrials { .. })));
    assert!(matches!(OmplLog::of_each(&nothing.source()), Err(BenchError::NoTrials { .. })));
}
