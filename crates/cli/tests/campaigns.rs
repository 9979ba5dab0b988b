//! Campaigns from the example page to the final report: errors are reported before the first trial, failures after the last.

use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

/// Runs `words`, separated by spaces, with `bin` of the folder first in PATH.
fn cranny(folder: &Path, words: &str) -> Output {
    let path = std::env::var("PATH").unwrap_or_default();
    Command::new(assert_cmd::cargo::cargo_bin("cranny"))
        .current_dir(folder)
        .env("PATH", format!("{}:{path}", folder.join("bin").display()))
        .args(words.split(' '))
        .output()
        .expect("it runs")
}

fn error(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn script(folder: &Path, name: &str, text: &str) {
    let path = folder.join(name);
    std::fs::create_dir_all(path.parent().expect("a folder")).expect("made");
    std::fs::write(&path, format!("#!/bin/sh\n{text}\n")).expect("written");
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).expect("executable");
}

/// Every example must complete, including those with a planner that supports only one of the criteria.
#[test]
fn every_example_of_the_page_runs() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/campaigns.md");
    let page = std::fs::read_to_string(page).expect("the page");
    let examples: Vec<&str> =
        page.split("```yaml\n").skip(1).filter_map(|rest| rest.split("```").next()).collect();
    assert!(examples.len() >= 2);
    for example in examples {
        let folder = folder();
        let path = folder.path();
        // Provides the programs that the examples assume; any result of theirs is an outcome.
        assert_eq!(cranny(path, "scenario new my_shelf").status.code(), Some(0));
        script(path, "my_planner.py", "");
        script(path, "bin/python3", "exit 0");
        script(path, "burs_of_free_space", "exit 1");
        std::fs::write(path.join("campaign.yaml"), example).expect("written");
        let run = "bench run campaign.yaml --runs 1 --iterations 1 --time-limit 1 --workers 2 --json";
        let output = cranny(path, run);
        assert_eq!(output.status.code(), Some(0), "{}{example}", error(&output));
        let said: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        assert!(said["trials"].as_u64() > Some(0) && said["trials"] == said["run"], "{said}");
    }
}

#[test]
fn what_would_end_a_campaign_later_is_said_before_its_first_trial() {
    let folder = folder();
    let path = folder.path();
    assert_eq!(cranny(path, "scenario new broken").status.code(), Some(0));
    std::fs::write(path.join("broken/grasps.csv"), "1,2,3\n").expect("written");
    let yaml = "scenarios: ['021']\nplanners: [{planner: reach}]\n\
                exceptions: [{scenario: '021', planner: raech, time_limit_s: 9}]\n";
    std::fs::write(path.join("exception.yaml"), yaml).expect("written");
    for (words, said) in [
        // The first trials would be under exact, which the planner supports.
        (
            "--scenarios 021 --planners reach --criterion exact,paper",
            &["021", "reach", "exact criterion"][..],
        ),
        // Trials of each goal start with the first planner.
        ("--scenarios 021 --planners ik-rrt,j-plus-rrt --each-goal", &["021", "j-plus-rrt", "grasps"]),
        ("--scenarios 021,./broken --planners reach", &["grasps.csv:1"]),
        ("--scenarios 021 --planners reach --planner exec:no-such-program", &["no-such-program", "PATH"]),
        ("exception.yaml", &["exception.yaml:3", "raech", "reach"]),
        ("--scenarios all --planners reach --runs 50001", &["1000020 trials", "at most 1000000"]),
    ] {
        let output = cranny(path, &format!("bench run -o results.db {words}"));
        let error = error(&output);
        assert_eq!(output.status.code(), Some(2), "{words}: {error}");
        for word in said {
            assert!(error.contains(word), "{words}: no '{word}' in {error}");
        }
        assert!(!path.join("results.db").exists(), "{words}: a file was begun");
    }
}

#[test]
fn a_start_that_is_not_free_is_noted_before_the_first_trial() {
    let folder = folder();
    let path = folder.path();
    assert_eq!(cranny(path, "scenario new mine").status.code(), Some(0));
    let file = path.join("mine/scenario.yaml");
    let yaml = std::fs::read_to_string(&file).expect("a scenario");
    std::fs::write(&file, yaml.replace("position: [0.9, 0, 0.6]", "position: [0.3, 0, 0.6]"))
        .expect("written");
    let output = cranny(path, "bench run --scenarios ./mine --planners reach --runs 1");
    let error = error(&output);
    assert_eq!(output.status.code(), Some(0), "{error}");
    assert!(
        error.contains("note: ") && error.contains("start of mine") && error.contains("start-invalid"),
        "{error}"
    );
}

#[test]
fn the_last_lines_say_who_crashed_how_often_and_why() {
    let folder = folder();
    let path = folder.path();
    script(path, "bad.sh", "echo warming up >&2; echo no module named such >&2; exit 3");
    script(path, "odd.sh", "echo once upon a time");
    let run = "bench run --scenarios 021 --planners reach --planner bad=exec:./bad.sh --planner odd=exec:./odd.sh \
               --runs 2 --time-limit 5";
    let output = cranny(path, run);
    let page = String::from_utf8_lossy(&output.stdout).into_owned();
    // Crashes are outcomes: every trial is in the results.
    assert_eq!(output.status.code(), Some(0), "{}", error(&output));
    assert!(
        page.contains("bad: 2 crashed; the first: ended with exit code 3: no module named such"),
        "{page}"
    );
    assert!(page.contains("odd: 2 garbled; the first: ") && page.contains("once upon a time"), "{page}");
    assert!(!page.contains("reach:"), "{page}");
    let said: Value =
        serde_json::from_slice(&cranny(path, &format!("{run} -o other.db --json")).stdout).expect("JSON");
    assert_eq!(
        (&said["lost"][0]["planner"], &said["lost"][0]["trials"]),
        (&"bad".into(), &2.into()),
        "{said}"
    );
}

/// A larger required clearance around the target gives other trials, none with less clearance.
#[test]
fn trials_keep_the_room_that_the_target_is_to_have() {
    let folder = folder();
    let path = folder.path();
    let solved = |robust: &str| {
        let run = format!(
            "bench run --scenarios 031 --planners reach --runs 2 --iterations 2000 --robust {robust} --json"
        );
        let output = cranny(path, &run);
        assert_eq!(output.status.code(), Some(0), "{}", error(&output));
        let said: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        (said["run"].as_u64(), said["solved"].as_u64())
    };
    assert_eq!(solved("2,2"), (Some(2), Some(2)));
    assert_eq!(solved("500,0"), (Some(2), Some(0)));
    assert_eq!(solved("2,2").0, Some(0), "known by then");
    let refused = cranny(path, "bench run --scenarios 031 --planners reach --robust 2");
    assert!(refused.status.code() == Some(2) && error(&refused).contains("--robust"), "{}", error(&refused));
}

/// Such a campaign wrote to a file without a name up to its end, and then reported success.
#[test]
fn a_campaign_whose_results_are_removed_ends_by_itself_with_an_error() {
    let folder = folder();
    let results = folder.path().join("results.db");
    let mut campaign = Command::new(assert_cmd::cargo::cargo_bin("cranny"));
    campaign.current_dir(folder.path()).args(["bench", "run", "--scenarios", "021", "--planners", "reach"]);
    campaign.args(["--runs", "100000"]).stderr(std::process::Stdio::piped());
    let campaign = campaign.spawn().expect("it starts");
    let ended = || cranny_bench::Results::glance(&results).map(|planners| planners.len());
    while !matches!(ended(), Ok(1)) {
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    std::fs::remove_file(&results).expect("removed");
    let output = campaign.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(2), "{}", error(&output));
    assert!(error(&output).contains("results.db: the results file was removed"), "{}", error(&output));
    let entries = std::fs::read_dir(folder.path()).expect("a folder").map(|entry| entry.expect("an entry"));
    let saved: Vec<_> =
        entries.map(|entry| entry.path()).filter(|path| path.to_string_lossy().contains("-saved-")).collect();
    let [saved] = &saved[..] else { panic!("{saved:?}") };
    assert!(cranny_bench::Results::open(saved).expect("results").count().expect("a count") > 0);
}
