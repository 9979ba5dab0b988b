//! Merging of results loses no trial, and takes nothing for true that only one of the files states.

use std::path::{Path, PathBuf};

use cranny_bench::{BenchError, Merged, Results, ScenarioSource, TrialOutcome};
use rusqlite::Connection;

use crate::fixture::{information, record, trial};

/// Creates results with a run on `machine` and a trial for each seed.
fn results(path: &Path, machine: &str, seeds: std::ops::Range<u64>) -> Results {
    let mut results = Results::create(path).expect("results");
    let run = results.begin_run(&information(machine)).expect("a run");
    for seed in seeds {
        assert!(results.append(run, &record(trial(seed)), &[vec![0.5]]).expect("appended"));
    }
    results
}

fn change(path: &Path, sql: &str) {
    let connection = Connection::open(path).expect("a database");
    connection.execute_batch(&format!("PRAGMA foreign_keys = OFF; {sql}")).expect("changed");
}

struct Files(tempfile::TempDir);

impl Files {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }
}

fn machines(results: &Results) -> Vec<(u64, String)> {
    let runs = results.runs().expect("runs");
    let machine = |id: u64| {
        let run = runs.iter().find(|run| run.id == id).expect("every trial has a run");
        run.information.machine.clone()
    };
    let trials = results.trials().expect("trials");
    trials.iter().map(|own| (own.record.trial.seed, machine(own.run))).collect()
}

#[test]
fn a_trial_whose_run_is_missing_is_kept_on_an_unknown_machine() {
    for (sql, known) in [("DELETE FROM runs", 0), ("DELETE FROM runs WHERE machine = 'b'", 2)] {
        let files = Files::new();
        let mut other = results(&files.path("other.db"), "a", 0..2);
        let run = other.begin_run(&information("b")).expect("a run");
        for seed in 2..5 {
            assert!(other.append(run, &record(trial(seed)), &[]).expect("appended"));
        }
        drop(other);
        change(&files.path("other.db"), sql);
        let expected = |seed: u64| if seed < known { "a" } else { "unknown" };
        let expected: Vec<_> = (0..5).map(|seed| (seed, expected(seed).to_owned())).collect();
        assert_eq!(machines(&Results::open(&files.path("other.db")).expect("results")), expected);

        let into = files.path("all.db");
        for (added, before) in [(5, 0), (0, 5)] {
            let (merged, taken) = Results::merged(&into, &[files.path("other.db")], false).expect("merged");
            assert_eq!(taken, [Merged { added, known: before }], "{sql}");
            assert_eq!(machines(&merged), expected, "{sql}");
        }
        // Such results are merged again like any others.
        let (merged, taken) = Results::merged(&files.path("again.db"), &[into], false).expect("merged");
        assert_eq!((taken[0], machines(&merged)), (Merged { added: 5, known: 0 }, expected));
    }
}

#[test]
fn a_run_that_another_file_describes_otherwise_is_refused() {
    for column in ["machine", "processor", "version", "command"] {
        let files = Files::new();
        drop(results(&files.path("a.db"), "a", 0..2));
        std::fs::copy(files.path("a.db"), files.path("b.db")).expect("copied");
        change(&files.path("b.db"), &format!("UPDATE runs SET {column} = 'faster', ended = 'later'"));
        let inputs = [files.path("a.db"), files.path("b.db")];
        let into = files.path("all.db");
        let refused = Results::merged(&into, &inputs, false);
        assert!(
            matches!(refused, Err(BenchError::OtherRun { runs: 1, .. })) && !into.exists(),
            "{refused:?}"
        );
        let (merged, _) = Results::merged(&into, &inputs, true).expect("merged");
        assert_eq!(merged.runs().expect("runs").len(), 1);
    }
}

#[test]
fn a_row_that_no_report_could_read_is_not_merged() {
    for sql in ["outcome = 'solvd'", "criterion = 'loose'", "seed = 'two'", "grasp = 'best'"] {
        let files = Files::new();
        drop(results(&files.path("a.db"), "a", 0..3));
        change(&files.path("a.db"), &format!("UPDATE trials SET {sql} WHERE id = 2"));
        let into = files.path("all.db");
        let refused = Results::merged(&into, &[files.path("a.db")], true).expect_err(sql).to_string();
        assert!(refused.contains("a.db") && !into.exists(), "{refused}");
    }
}

#[test]
fn figures_that_no_report_accepts_are_not_merged() {
    for (table, sql) in [
        ("trials", "UPDATE trials SET planning_time_s = -5"),
        ("trials", "UPDATE trials SET time_limit_s = 9e999"),
        ("trials", "UPDATE trials SET time_limit_s = 0"),
        ("trials", "UPDATE trials SET planning_time_s = 120.5"),
        ("runs", "UPDATE runs SET cores = -1"),
    ] {
        let files = Files::new();
        let mut into = results(&files.path("into.db"), "a", 0..2);
        drop(results(&files.path("other.db"), "b", 2..4));
        change(&files.path("other.db"), sql);
        let refused = into.merge(&files.path("other.db"), false);
        assert!(refused.is_err(), "{table}: {sql}");
        assert_eq!(into.count().expect("a count"), 2, "{sql}");
    }
}

#[test]
fn a_file_that_is_refused_leaves_none_of_the_others_merged() {
    let files = Files::new();
    for (name, machine, seeds) in [("into.db", "a", 0..2), ("new.db", "b", 2..4), ("bad.db", "c", 4..6)] {
        drop(results(&files.path(name), machine, seeds));
    }
    change(&files.path("bad.db"), "UPDATE trials SET planning_time_s = -5");
    let others = [files.path("new.db"), files.path("bad.db")];
    let refused = Results::merged(&files.path("into.db"), &others, false).map(drop);
    assert!(refused.is_err_and(|fault| fault.to_string().contains("bad.db")));
    assert_eq!(Results::open(&files.path("into.db")).expect("results").count().expect("a count"), 2);
}

/// As after `mktemp`.
#[test]
fn several_files_are_merged_into_an_empty_one() {
    let files = Files::new();
    for (name, machine, seeds) in [("one.db", "a", 0..2), ("two.db", "b", 2..4)] {
        drop(results(&files.path(name), machine, seeds));
    }
    std::fs::write(files.path("into.db"), "").expect("written");
    let others = [files.path("one.db"), files.path("two.db")];
    let (merged, _) = Results::merged(&files.path("into.db"), &others, false).expect("merged");
    assert_eq!(merged.count().expect("a count"), 4);
}

#[test]
fn what_only_one_file_knows_of_a_scenario_is_kept() {
    let files = Files::new();
    for (name, goals) in [("a.db", None), ("b.db", Some(4))] {
        let scenario_hash = "ab".repeat(32);
        let source = ScenarioSource { scenario: "021".into(), scenario_hash, source: name.into(), goals };
        results(&files.path(name), name, 0..1).note_scenario(&source).expect("noted");
    }
    let inputs = [files.path("a.db"), files.path("b.db")];
    let (merged, _) = Results::merged(&files.path("all.db"), &inputs, true).expect("merged");
    let scenarios = merged.scenarios().expect("scenarios");
    assert_eq!((&*scenarios[0].source, scenarios[0].goals), ("a.db", Some(4)));
}

#[test]
fn the_paths_of_trials_are_merged_with_them() {
    let files = Files::new();
    drop(results(&files.path("a.db"), "a", 0..2));
    let (merged, _) = Results::merged(&files.path("all.db"), &[files.path("a.db")], false).expect("merged");
    assert_eq!(merged.path_of(2).expect("a path"), [[0.5]]);
    assert_eq!(merged.trial(2).expect("a trial").record.outcome, TrialOutcome::Solved);
}

/// `SQLite`, and the check whether a file can be written, would wait for the other end.
#[cfg(unix)]
#[test]
fn pipes_in_the_place_of_results_block_nothing() {
    let files = Files::new();
    let pipe = |name: &str| {
        let made = std::process::Command::new("mkfifo").arg(files.path(name)).status().expect("mkfifo");
        assert!(made.success());
    };
    pipe("pipe.db");
    for ending in ["-wal", "-journal", "-shm"] {
        let name = format!("a{ending}.db");
        drop(results(&files.path(&name), "a", 0..1));
        pipe(&format!("{name}{ending}"));
        let opened = Results::open(&files.path(&name));
        assert!(matches!(opened, Err(BenchError::Unreadable { .. })), "{ending}: {opened:?}");
    }
    for opened in [Results::open(&files.path("pipe.db")), Results::create(&files.path("pipe.db"))] {
        let is_refused = matches!(opened, Err(BenchError::NotResults { .. } | BenchError::Unreadable { .. }));
        assert!(is_refused, "{opened:?}");
    }
    assert!(Results::glance(&files.path("pipe.db")).is_err());
}
