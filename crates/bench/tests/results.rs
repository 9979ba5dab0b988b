//! Results: exact round trips, no duplicates, and no silent errors.

use std::path::Path;

use cranny_bench::{
    BenchError, Merged, Results, ScenarioSource, SimulatedGrasp, Trial, TrialOutcome, TrialRecord,
};
use cranny_task::Criterion;
use strum::VariantArray as _;

use crate::fixture::{information, record, trial};

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

/// Creates results with one run and a trial for each seed.
fn results(path: &Path, machine: &str, seeds: impl Iterator<Item = u64>) -> Results {
    let mut results = Results::create(path).expect("results");
    let run = results.begin_run(&information(machine)).expect("a run");
    for seed in seeds {
        assert!(results.append(run, &record(trial(seed)), &[]).expect("appended"));
    }
    results
}

#[test]
fn a_trial_is_read_back_bit_by_bit() {
    let folder = folder();
    let path = folder.path().join("results.db");
    let whole = TrialRecord {
        detail: Some("edge 3 at 0.5: hand is deep in table".into()),
        outcome: TrialOutcome::Rejected,
        clearance_m: Some(5e-324),
        also_solved: Some(false),
        memory_bytes: Some(123 << 20),
        ..record(Trial { criterion: Criterion::Paper, goal: Some(3), iteration_limit: Some(0), ..trial(5) })
    };
    let way = vec![vec![-0.0, 1.0 / 3.0], vec![f64::MAX, 1e-300]];
    let mut written = results(&path, "a", 0..1);
    assert!(written.append(1, &whole, &way).expect("appended"));
    written.end_run(1).expect("ended");
    drop(written);

    let read = Results::open(&path).expect("results");
    assert_eq!(read.records().expect("records"), [record(trial(0)), whole.clone()]);
    let stored = read.trial(2).expect("the second");
    assert_eq!((stored.id, stored.run), (2, 1));
    let bits = |path: &[Vec<f64>]| path.concat().iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&read.path_of(2).expect("a path")), bits(&way));
    assert_eq!(read.path_of(1).expect("no path"), Vec::<Vec<f64>>::new());
    let runs = read.runs().expect("runs");
    assert_eq!(runs[0].information, information("a"));
    assert!(runs[0].began.ends_with('Z') && runs[0].ended.is_some());
}

#[test]
fn what_is_found_of_grasps_replaces_what_was_found_under_the_same_settings() {
    let folder = folder();
    let path = folder.path().join("results.db");
    let mut results = results(&path, "a", 0..2);
    let before = results.records().expect("records");
    let found = |grasp: usize, robust| SimulatedGrasp {
        scenario: "021".into(),
        scenario_hash: "ab".repeat(32),
        grasp,
        outcome: "held".into(),
        translation_error_m: 1.0 / 3.0,
        rotation_error_rad: 0.0,
        held_s: 1.8,
        contact_force_n: 70.0,
        robust,
    };
    let mut keep = |settings: &str, grasps: &[SimulatedGrasp]| {
        results.keep_simulated_grasps(settings, grasps).expect("kept");
    };
    keep("a", &[found(1, None), found(2, None)]);
    keep("b", &[found(1, Some((3, 4)))]);
    keep("a", &[found(3, None)]);
    let other = rusqlite::Connection::open(&path).expect("a database");
    let sql = "SELECT settings, grasp, translation_error_m, robust_held, robust_trials FROM simulated_grasps \
               ORDER BY settings, grasp";
    let mut rows = other.prepare(sql).expect("a table");
    type Row = (String, usize, f64, Option<usize>, Option<usize>);
    let row = |row: &rusqlite::Row| Ok((row.get(0)?, row.get(1)?, row.get(2)?, row.get(3)?, row.get(4)?));
    let rows: Vec<Row> = rows.query_map([], row).and_then(Iterator::collect).expect("rows");
    let third = 1.0 / 3.0;
    assert_eq!(rows, [("a".into(), 3, third, None, None), ("b".into(), 1, third, Some(3), Some(4))]);
    assert_eq!(Results::open(&path).expect("results").records().expect("records"), before);
    // The operation is all or nothing: a duplicate grasp is an error.
    let twice = results.keep_simulated_grasps("b", &[found(5, None), found(5, None)]);
    assert!(matches!(twice, Err(BenchError::Database { .. })), "{twice:?}");
    let count = |sql: &str| other.query_row(sql, [], |row| row.get::<_, usize>(0)).expect("a count");
    assert_eq!(count("SELECT count(*) FROM simulated_grasps WHERE settings = 'b' AND grasp = 1"), 1);
    // A foreign table of that name is not touched.
    other
        .execute_batch("DROP TABLE simulated_grasps; CREATE TABLE simulated_grasps (mine)")
        .expect("changed");
    let refused = results.keep_simulated_grasps("a", &[found(1, None)]).expect_err("a fault").to_string();
    assert!(refused.contains("'simulated_grasps' differs from Cranny's database schema"), "{refused}");
}

#[test]
fn every_outcome_has_a_name_of_its_own_that_finds_it() {
    for &outcome in TrialOutcome::VARIANTS {
        assert_eq!(outcome.name().parse(), Ok(outcome));
    }
    assert!("solvd".parse::<TrialOutcome>().is_err());
}

#[test]
fn a_trial_is_never_there_twice_and_every_part_of_it_tells_it_apart() {
    let folder = folder();
    let mut results = results(&folder.path().join("results.db"), "a", 0..1);
    let slower = TrialRecord { outcome: TrialOutcome::Hung, ..record(trial(0)) };
    assert!(!results.append(1, &slower, &[]).expect("no fault"));
    assert_eq!(results.records().expect("records"), [record(trial(0))]);
    let others = [
        Trial { scenario: "022".into(), ..trial(0) },
        Trial { scenario_hash: "cd".repeat(32), ..trial(0) },
        Trial { planner: "ik-rrt".into(), ..trial(0) },
        Trial { settings: "{\"step\":0.5}".into(), ..trial(0) },
        Trial { criterion: Criterion::Paper, ..trial(0) },
        Trial { seed: 1, ..trial(0) },
        Trial { time_limit_s: 30.0, ..trial(0) },
        Trial { iteration_limit: Some(9), ..trial(0) },
        Trial { goal: Some(0), ..trial(0) },
    ];
    for other in others {
        assert!(results.append(1, &record(other.clone()), &[]).expect("appended"), "{other:?}");
        assert!(!results.append(1, &record(other.clone()), &[]).expect("no fault"), "{other:?}");
    }
    assert_eq!(results.count().expect("a count"), 10);
}

#[test]
fn merging_takes_up_what_is_new_with_its_run_and_does_nothing_the_second_time() {
    let folder = folder();
    let (a, b) = (folder.path().join("a.db"), folder.path().join("b.db"));
    let mut first = results(&a, "first", 0..5);
    let mut second = results(&b, "second", 3..9);
    let place = ScenarioSource {
        scenario: "021".into(),
        scenario_hash: "ab".repeat(32),
        source: "021".into(),
        goals: Some(4),
    };
    second.note_scenario(&place).expect("noted");
    second.note_planner("reach", "{}", "[]").expect("noted");
    drop(second);
    assert_eq!(first.merge(&b, false).expect("merged"), Merged { added: 4, known: 2 });
    assert_eq!(first.merge(&b, false).expect("merged"), Merged { added: 0, known: 6 });
    let trials = first.trials().expect("trials");
    let runs = first.runs().expect("runs");
    let machine = |id: u64| runs.iter().find(|run| run.id == id).map(|run| run.information.machine.as_str());
    let origins: Vec<_> = trials.iter().map(|t| (t.record.trial.seed, machine(t.run))).collect();
    for (seed, origin) in origins {
        assert_eq!(origin, Some(if seed < 5 { "first" } else { "second" }));
    }
    assert_eq!(first.scenarios().expect("scenarios"), [place]);
    assert_eq!(first.planner_source("reach", "{}").expect("a planner").as_deref(), Some("[]"));
    assert_eq!(first.planner_source("reach", "{ }").expect("none"), None);
}

#[test]
fn what_is_no_results_is_refused_and_left_as_it_is() {
    let folder = folder();
    let file = |name: &str, content: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, content).expect("written");
        path
    };
    let text = file(
        "notes.db",
        b"these are notes, long enough to have a header of a hundred bytes, which \
        they do not have, because they are notes and nothing but notes",
    );
    assert!(matches!(Results::create(&text), Err(BenchError::NotResults { .. })));
    assert!(std::fs::read(&text).expect("still there").starts_with(b"these are notes"));
    let missing = folder.path().join("missing.db");
    assert!(matches!(Results::open(&missing), Err(BenchError::NoResults { .. })));
    assert!(!missing.exists());
    let nowhere = folder.path().join("no/such/folder/results.db");
    assert!(matches!(Results::create(&nowhere), Err(BenchError::Unwritable { .. })));

    let foreign = folder.path().join("foreign.db");
    let connection = rusqlite::Connection::open(&foreign).expect("a database");
    connection.execute_batch("CREATE TABLE runs (id INTEGER)").expect("a table");
    assert!(matches!(Results::create(&foreign), Err(BenchError::NotResults { .. })));
    let later = folder.path().join("later.db");
    results(&later, "a", 0..1);
    rusqlite::Connection::open(&later)
        .expect("a database")
        .pragma_update(None, "user_version", 3)
        .expect("set");
    assert!(matches!(Results::open(&later), Err(BenchError::ResultsVersion { actual: 3, .. })));
}

#[test]
fn a_row_that_says_what_it_cannot_is_an_error_that_names_it() {
    let folder = folder();
    let path = folder.path().join("results.db");
    let results = results(&path, "a", 0..2);
    let connection = rusqlite::Connection::open(&path).expect("a database");
    connection.execute("UPDATE trials SET outcome = 'solvd' WHERE id = 2", []).expect("updated");
    let message = results.records().expect_err("a fault").to_string();
    assert!(message.contains("trial 2: 'solvd' is not a valid outcome"), "{message}");
    assert!(matches!(results.trial(9), Err(BenchError::NoTrial { last: 2, .. })));
}

#[test]
fn older_results_are_read_as_they_are_merged_and_gone_on_with() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    drop(results(&path("older.db"), "a", 0..2));
    // An older version recorded neither memory nor isolation.
    let connection = rusqlite::Connection::open(path("older.db")).expect("opened");
    let sql = "ALTER TABLE runs DROP COLUMN memory_limit_bytes; ALTER TABLE runs DROP COLUMN sandbox;
               ALTER TABLE trials DROP COLUMN memory_bytes; PRAGMA user_version = 1";
    connection.execute_batch(sql).expect("older");
    drop(connection);
    std::fs::copy(path("older.db"), path("copy.db")).expect("copied");

    let read = Results::open(&path("older.db")).expect("results");
    let older = |seed| TrialRecord { memory_bytes: None, ..record(trial(seed)) };
    assert_eq!(read.records().expect("records"), [older(0), older(1)]);
    assert_eq!(read.runs().expect("runs")[0].information.memory_limit_bytes, None);
    drop(read);
    let mut results = Results::create(&path("older.db")).expect("results");
    let run = results.begin_run(&information("b")).expect("a run");
    let with_memory = TrialRecord { memory_bytes: Some(7), ..record(trial(2)) };
    assert!(results.append(run, &with_memory, &[]).expect("appended"));
    let merged = results.merge(&path("copy.db"), false).expect("merged");
    assert_eq!(merged, Merged { added: 0, known: 2 });
    assert_eq!(results.records().expect("records"), [older(0), older(1), with_memory]);
}

#[test]
fn a_trial_that_went_differently_in_two_files_is_refused_unless_the_first_is_to_stay() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    drop(results(&path("a.db"), "a", 0..3));
    let mut other = results(&path("b.db"), "b", 0..1);
    let slower = cranny_plan::Statistics { planning_time_s: 9.5, ..record(trial(2)).statistics };
    let again = TrialRecord { statistics: slower, ..record(trial(2)) };
    assert!(other.append(1, &again, &[]).expect("appended"));
    drop(other);
    let (into, files) = (path("all.db"), [path("a.db"), path("b.db")]);
    match Results::merged(&into, &files, false) {
        Err(BenchError::Overlap { path: of, count: 1, first, .. }) => {
            assert!(of == path("b.db") && first.ends_with("seed 2"), "{first}");
        }
        merged => panic!("{merged:?}"),
    }
    assert!(!into.exists());
    let (merged, taken) = Results::merged(&into, &files, true).expect("merged");
    assert_eq!(taken[1], Merged { added: 0, known: 2 });
    assert_eq!(merged.records().expect("records")[2], record(trial(2)));
    assert_eq!(Results::glance(&into).expect("tallies").values().map(|tally| tally.ended).sum::<usize>(), 3);
    assert_eq!(merged.count().expect("a count"), 3);
}
