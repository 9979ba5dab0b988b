//! `cranny bench`: campaigns that survive interruptions, and trials that are repeated exactly.

use std::collections::HashSet;
use std::path::Path;
use std::process::{Output, Stdio};
use std::time::Duration;

use assert_cmd::Command;
use cranny_bench::{Results, StoredTrial, TrialOutcome};
use serde_json::Value;

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

fn cranny(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::cargo_bin("cranny").expect("the program");
    command.current_dir(folder).args(arguments).output().expect("it runs")
}

/// Runs a campaign, which must succeed, and returns the output of `--json`.
fn campaign(folder: &Path, arguments: &str) -> Value {
    let words: Vec<&str> = ["bench", "run", "--json"].into_iter().chain(arguments.split(' ')).collect();
    let output = cranny(folder, &words);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

fn replayed(folder: &Path, trial: u64) -> Value {
    let output = cranny(folder, &["bench", "replay", "results.db", &trial.to_string(), "--json"]);
    let error = String::from_utf8_lossy(&output.stderr);
    let document: Value = serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{error}"));
    assert_eq!(
        output.status.code() == Some(0),
        document["same_path"] == true && document["same_search"] == true
    );
    document
}

#[test]
fn a_campaign_goes_on_where_it_ended_and_counts_nothing_twice() {
    let folder = folder();
    let first = campaign(folder.path(), "--scenarios 021,022 --planners reach,ik-rrt --runs 2");
    assert_eq!((first["trials"].as_u64(), first["run"].as_u64()), (Some(8), Some(8)));
    let again = campaign(folder.path(), "--scenarios 021,022 --planners reach,ik-rrt --runs 2");
    assert_eq!((again["known"].as_u64(), again["run"].as_u64()), (Some(8), Some(0)));
    let more = campaign(folder.path(), "--scenarios 02x --planners reach,ik-rrt --runs 3 --workers 2");
    assert_eq!((more["known"].as_u64(), more["run"].as_u64()), (Some(8), Some(22)));

    let results = Results::open(&folder.path().join("results.db")).expect("results");
    let trials = results.trials().expect("trials");
    let keys: HashSet<String> = trials.iter().map(|trial| trial.record.trial.key()).collect();
    assert_eq!((trials.len(), keys.len()), (30, 30));
    for trial in &trials {
        assert_eq!(trial.record.outcome, TrialOutcome::Solved, "{trial:?}");
        assert!(trial.record.path_length.is_some() && trial.record.grasp_score.is_some());
        assert!(trial.record.statistics.planning_time_s > 0.0);
    }
    let runs = results.runs().expect("runs");
    assert_eq!(runs.iter().map(|run| run.information.workers).collect::<Vec<_>>(), [1, 2]);
    assert!(runs.iter().all(|run| run.ended.is_some() && run.information.command.contains("bench run")));
}

#[test]
fn twenty_times_killed_a_campaign_still_ends_with_every_trial_once() {
    const TRIALS: usize = 400;
    let folder = folder();
    let words = ["bench", "run", "--scenarios", "021", "--planners", "reach", "--runs", "400", "--quiet"];
    let path = folder.path().join("results.db");
    let mut seen = 0;
    for kill in 0..20_u64 {
        let mut child = std::process::Command::new(assert_cmd::cargo::cargo_bin("cranny"))
            .current_dir(folder.path())
            .args(words)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("it runs");
        // Times spread over the opening of the file and the scenario and over the first trials, in no order.
        std::thread::sleep(Duration::from_millis(3 + kill * 7919 % 1000));
        // SIGKILL on Unix.
        child.kill().expect("killed");
        child.wait().expect("gone");
        if let Ok(results) = Results::open(&path) {
            let count = results.records().expect("whole records").len();
            assert!(count >= seen, "{count} trials after {seen}");
            seen = count;
        }
    }
    let last = campaign(folder.path(), "--scenarios 021 --planners reach --runs 400");
    assert_eq!(last["known"].as_u64(), Some(seen as u64));
    let trials = Results::open(&path).expect("results").records().expect("trials");
    let seeds: HashSet<u64> = trials.iter().map(|record| record.trial.seed).collect();
    assert_eq!((trials.len(), seeds.len()), (TRIALS, TRIALS));
    let connection = rusqlite::Connection::open(&path).expect("a database");
    let verdict: String =
        connection.query_row("PRAGMA integrity_check", [], |row| row.get(0)).expect("a verdict");
    assert_eq!(verdict, "ok");
}

#[test]
fn every_planner_s_trial_is_replayed_to_the_same_bytes() {
    let folder = folder();
    campaign(
        folder.path(),
        "--scenarios 021,031 --planners reach,ik-rrt,j-plus-rrt --runs 1 --time-limit 20",
    );
    campaign(folder.path(), "--scenarios 031 --planners ik-rrt,j-plus-rrt --runs 1 --criterion paper");
    for carry in ["home", "out"] {
        campaign(folder.path(), &format!("--scenarios 031 --planners reach --runs 1 --carry {carry}"));
    }
    let results = Results::open(&folder.path().join("results.db")).expect("results");
    let trials = results.trials().expect("trials");
    assert_eq!(trials.len(), 10);
    let mut with_path = 0;
    for trial in trials {
        let again = replayed(folder.path(), trial.id);
        assert_eq!(
            (again["same_path"].as_bool(), again["same_search"].as_bool()),
            (Some(true), Some(true)),
            "{again}"
        );
        assert_eq!(again["stored_outcome"], trial.record.outcome.name());
        with_path += usize::from(again["waypoints"].as_array().is_some_and(|path| !path.is_empty()));
    }
    assert!(with_path >= 8, "{with_path} of 10 have a path");
}

/// Without a required hold factor, `reach` picks the box (031) by grasps of which half let it slip.
#[test]
fn plans_of_a_campaign_are_tried_in_physics() {
    let folder = folder();
    let solved_with = |most: usize| {
        let file = format!("{most}.db");
        campaign(
            folder.path(),
            &format!(
                "--scenarios 031 --planners reach --runs 6 --carry home --hold 0 --try-in-physics {most} -o {file}"
            ),
        );
        let trials = Results::open(&folder.path().join(file)).expect("results").trials().expect("trials");
        let failed = trials.iter().filter(|trial| trial.record.outcome == TrialOutcome::GaveUp);
        for record in failed.map(|trial| &trial.record) {
            let detail = record.detail.as_deref().unwrap_or_default();
            assert!(detail.starts_with(&format!("none of {most} plans went as planned")), "{detail}");
        }
        let is_solved = |trial: &StoredTrial| trial.record.is_solved();
        trials
            .iter()
            .filter(|trial| is_solved(trial))
            .map(|trial| trial.record.trial.seed)
            .collect::<HashSet<u64>>()
    };
    let (once, thrice) = (solved_with(1), solved_with(3));
    assert!(once.len() < thrice.len() && once.is_subset(&thrice), "{once:?} {thrice:?}");
}

#[test]
fn a_trial_that_time_cut_short_ends_at_the_same_node() {
    let folder = folder();
    campaign(folder.path(), "--scenarios 045,025 --planners j-plus-rrt,ik-rrt --runs 1 --time-limit 0.2");
    let results = Results::open(&folder.path().join("results.db")).expect("results");
    let mut cut = 0;
    for trial in results.trials().expect("trials") {
        let again = replayed(folder.path(), trial.id);
        assert_eq!(again["iterations"], again["stored_iterations"], "{again}");
        assert_eq!(again["same_search"], true, "{again}");
        cut += usize::from(trial.record.outcome == TrialOutcome::BudgetExhausted);
    }
    assert!(cut > 0, "nothing was cut short");
}

#[test]
fn each_goal_is_aimed_at_by_itself_and_both_criteria_judge() {
    let folder = folder();
    let run = campaign(folder.path(), "--preset paper --scenarios 031 --runs 1 --time-limit 20 --judge-both");
    let results = Results::open(&folder.path().join("results.db")).expect("results");
    let goals = results.scenarios().expect("scenarios")[0].goals.expect("counted");
    assert!(goals > 0);
    assert_eq!(run["trials"].as_u64(), Some(goals as u64 + 1));
    let trials = results.trials().expect("trials");
    let aimed: HashSet<Option<usize>> = trials.iter().map(|trial| trial.record.trial.goal).collect();
    assert_eq!(aimed.len(), goals + 1);
    for trial in trials.iter().filter(|trial| trial.record.is_solved()) {
        assert!(trial.record.also_solved.is_some() && trial.record.grasp.is_some(), "{trial:?}");
    }
}

#[test]
fn results_of_two_machines_are_joined() {
    let folder = folder();
    campaign(folder.path(), "--scenarios 021 --planners reach --runs 3 -o a.db");
    campaign(folder.path(), "--scenarios 021 --planners reach --runs 4 --first-seed 2 -o b.db");
    // One of the seeds was run on both machines, with different times.
    let words = ["bench", "merge", "a.db", "b.db", "-o", "all.db", "--json"];
    assert_eq!(cranny(folder.path(), &words).status.code(), Some(2));
    assert!(!folder.path().join("all.db").exists());
    let output = cranny(folder.path(), &[&words[..], &["--keep-first"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let merged: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(merged["trials"], 6);
    assert_eq!(merged["merged"][1]["added"], 3);
    assert_eq!(merged["merged"][1]["known"], 1);
    let count =
        |name: &str| Results::open(&folder.path().join(name)).expect("results").runs().expect("runs").len();
    assert_eq!((count("a.db"), count("b.db"), count("all.db")), (1, 1, 2));
}

#[test]
fn bad_campaigns_are_refused_before_anything_is_written() {
    let folder = folder();
    std::fs::write(folder.path().join("bad.yaml"), "scenarios: ['021']\nplaners: [{planner: reach}]\n")
        .expect("written");
    let cases: [(&[&str], &[&str]); 10] = [
        (&["--planners", "reach"], &["--scenarios", "all"]),
        (&["--scenarios", "021"], &["--planners", "j-plus-rrt"]),
        (&["--scenarios", "021", "--planners", "reech"], &["reech", "ik-rrt"]),
        (&["--scenarios", "09x", "--planners", "reach"], &["09x", "stands for any digit"]),
        (&["--scenarios", "021", "--planner", "exec:./nobody"], &["./nobody"]),
        (&["--scenarios", "021", "--planners", "reach", "--runs", "0"], &["--runs"]),
        (&["--scenarios", "021", "--planners", "reach", "--time-limit", "soon"], &["soon"]),
        (
            &["--scenarios", "021", "--planners", "reach", "--carry", "away"],
            &["away", "`home`, `out` or `place`"],
        ),
        (&["bad.yaml"], &["bad.yaml:2", "planers"]),
        (&["none.yaml"], &["none.yaml"]),
    ];
    for (arguments, words) in cases {
        let words_given: Vec<&str> = ["bench", "run"].iter().chain(arguments).copied().collect();
        let output = cranny(folder.path(), &words_given);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        for word in words {
            assert!(error.contains(word), "no '{word}' in: {error}");
        }
        assert!(!folder.path().join("results.db").exists(), "{arguments:?}");
    }
    // A planner that does not support the criterion is reported, and existing results stay.
    campaign(folder.path(), "--scenarios 021 --planners reach --runs 1");
    let output = cranny(
        folder.path(),
        &["bench", "run", "--scenarios", "021", "--planners", "reach", "--criterion", "paper", "--runs", "1"],
    );
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(error.contains("reach") && error.contains("exact criterion"), "{error}");
    assert_eq!(
        Results::open(&folder.path().join("results.db")).expect("results").records().expect("records").len(),
        1
    );
    let output = cranny(folder.path(), &["bench", "replay", "results.db", "7"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("unknown trial 7"));
    let output = cranny(folder.path(), &["bench", "merge", "results.db", "none.db"]);
    assert_eq!(output.status.code(), Some(2));
}
