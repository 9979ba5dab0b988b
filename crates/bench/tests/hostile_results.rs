//! A results file from an untrusted source is refused with a clear message, and nothing in it is executed.

use std::path::{Path, PathBuf};

use crate::fixture::{information, record, trial};
use cranny_bench::report::Summary;
use cranny_bench::{BenchError, Results};
use rusqlite::Connection;

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

/// Creates results with three trials and their log written back.
fn results(folder: &Path) -> PathBuf {
    let path = folder.join("results.db");
    let mut results = Results::create(&path).expect("results");
    let run = results.begin_run(&information("a")).expect("a run");
    for seed in 0..3 {
        assert!(results.append(run, &record(trial(seed)), &[vec![0.0, 1.0]]).expect("appended"));
    }
    path
}

fn change(path: &Path, sql: &str) {
    let connection = Connection::open(path).expect("a database");
    connection.execute_batch(sql).expect("changed");
}

/// The rows of this view never end: counting them would take forever.
#[test]
fn a_view_in_the_place_of_a_table_is_refused_before_anything_is_asked_of_it() {
    let folder = folder();
    for name in ["trials", "runs", "scenarios", "planners"] {
        let path = results(folder.path());
        let endless = "WITH RECURSIVE n (id) AS (SELECT 1 UNION ALL SELECT id + 1 FROM n) SELECT id FROM n";
        let sql = format!("PRAGMA foreign_keys = OFF; DROP TABLE {name}; CREATE VIEW {name} AS {endless}");
        change(&path, &sql);
        let before = std::fs::read(&path).expect("the file");
        for opened in [Results::open(&path), Results::create(&path)] {
            let message = opened.expect_err("a fault").to_string();
            assert!(message.contains("differs from Cranny's database schema"), "{name}: {message}");
        }
        let into = folder.path().join("into.db");
        let merged = Results::merged(&into, std::slice::from_ref(&path), false);
        assert!(matches!(merged, Err(BenchError::OtherTable { .. })) && !into.exists());
        assert!(std::fs::read(&path).expect("the file") == before, "it was changed");
        std::fs::remove_file(&path).expect("removed");
    }
}

#[test]
fn a_table_with_other_columns_or_none_at_all_is_refused() {
    for sql in [
        "DROP TABLE planners",
        "ALTER TABLE trials ADD COLUMN note TEXT",
        "ALTER TABLE trials RENAME COLUMN seed TO sead",
        "DROP INDEX trial_identity",
    ] {
        let folder = folder();
        let path = results(folder.path());
        change(&path, sql);
        assert!(matches!(Results::open(&path), Err(BenchError::OtherTable { .. })), "{sql}");
    }
}

#[test]
fn what_else_a_file_brings_along_is_neither_run_nor_in_the_way() {
    let folder = folder();
    let path = results(folder.path());
    change(
        &path,
        "CREATE TABLE mine (note TEXT);
         CREATE VIEW solved AS SELECT * FROM trials WHERE outcome = 'solved';
         CREATE TRIGGER thief AFTER INSERT ON trials BEGIN DELETE FROM trials; END",
    );
    let mut results = Results::create(&path).expect("results");
    assert!(results.append(1, &record(trial(7)), &[]).expect("appended"));
    assert_eq!(results.count().expect("a count"), 4, "the trigger ran");
}

/// Reports, exports and replays only read; an error in them must not affect the file.
#[test]
fn results_that_are_read_cannot_be_written() {
    let folder = folder();
    let path = results(folder.path());
    let mut opened = Results::open(&path).expect("results");
    assert!(matches!(opened.begin_run(&information("b")), Err(BenchError::Database { .. })));
    assert_eq!(opened.trials().expect("trials").len(), 3);
}

#[test]
fn values_of_another_type_are_an_error_and_not_a_guess() {
    for change_of in [
        "seed = 'seven'",
        "seed = -1",
        "time_limit_s = x'00'",
        "iterations = 1.5",
        "settings = x'ff'",
        "outcome = 7",
        "grasp = 'best'",
        "also_solved = 'perhaps'",
    ] {
        let folder = folder();
        let path = results(folder.path());
        change(&path, &format!("UPDATE trials SET {change_of} WHERE id = 2"));
        let results = Results::open(&path).expect("results");
        let fault = results.trials().expect_err(change_of).to_string();
        assert!(fault.contains("results.db"), "{change_of}: {fault}");
    }
    // Invalid bytes give none or other way points, and take no more memory than their length.
    for bytes in ["x'ffffffff0000000000000000'", "x'00000000'", "x'01'", "'text'", "zeroblob(1000003)"] {
        let folder = folder();
        let path = results(folder.path());
        change(&path, &format!("UPDATE trials SET path = {bytes}"));
        let _ = Results::open(&path).expect("results").path_of(1);
    }
}

#[test]
fn a_solved_trial_without_a_path_and_a_path_that_is_cut_are_not_reported() {
    for (changes, says) in [
        ("path = NULL", "trial 2: 'solved without a path' is not a valid result"),
        ("path = x'02000000'", "trial 2: 'solved without a path' is not a valid result"),
        ("path = x''", "trial 2: 'solved without a path' is not a valid result"),
        ("path = substr(path, 1, 12)", "trial 2: '12 bytes' is not a valid path"),
        ("path = substr(path, 1, 19), outcome = 'rejected'", "trial 2: '19 bytes' is not a valid path"),
        ("path = 'texts'", "trial 2: '5 bytes' is not a valid path"),
        ("planning_time_s = 120.5", "trial 2: it is solved after 120.5 s, but its time limit is 120 s"),
        ("time_limit_s = 0", "trial 2: its time limit is 0"),
        ("path = NULL, outcome = 'gave-up'", ""),
        ("planning_time_s = 121, outcome = 'rejected'", ""),
    ] {
        let folder = folder();
        let path = results(folder.path());
        change(&path, &format!("UPDATE trials SET {changes} WHERE id = 2"));
        let report = Summary::of_results(&Results::open(&path).expect("results"));
        let fault = report.err().map(|fault| fault.to_string()).unwrap_or_default();
        assert!(fault.contains(says) && fault.is_empty() == says.is_empty(), "{changes}: {fault}");
    }
}

#[test]
fn damaged_pages_are_an_error_and_never_the_end_of_the_program() {
    let folder = folder();
    let whole = std::fs::read(results(folder.path())).expect("the file");
    let path = folder.path().join("damaged.db");
    let mut refused = 0;
    // This interval reaches every region of a page.
    for place in (0..whole.len()).step_by(997) {
        let mut bytes = whole.clone();
        bytes[place] ^= 0xa5;
        std::fs::write(&path, &bytes).expect("written");
        refused += usize::from(Results::open(&path).and_then(|results| results.trials()).is_err());
        std::fs::write(&path, &whole[..place]).expect("written");
        let cut = Results::open(&path).and_then(|results| results.trials());
        assert!(place == 0 || cut.is_err(), "cut at {place}");
    }
    assert!(refused > 0);
}
