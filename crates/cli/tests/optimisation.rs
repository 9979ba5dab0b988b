//! `cranny plan --optimise SECONDS`: better paths after the first.

use std::path::Path;
use std::process::Output;

use assert_cmd::Command;
use serde_json::Value;

fn cranny(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::cargo_bin("cranny").expect("the program");
    command.current_dir(folder).args(arguments).output().expect("it runs")
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

fn costs(document: &Value) -> Vec<f64> {
    let improvements = document["optimisation"]["improvements"].as_array().expect("a list");
    improvements.iter().map(|step| step["cost"].as_f64().expect("a cost")).collect()
}

const BETTER: [&str; 6] = ["plan", "021", "--optimise", "600", "--iterations", "2000"];

#[test]
fn the_cost_over_time_stands_in_the_answer_and_in_the_plan_file_and_the_path_is_valid() {
    let folder = folder();
    let planned = cranny(folder.path(), &[&BETTER[..], &["--json"]].concat());
    assert_eq!(planned.status.code(), Some(0), "{}", String::from_utf8_lossy(&planned.stderr));
    let answer: Value = serde_json::from_slice(&planned.stdout).expect("one JSON document");
    let text = std::fs::read_to_string(folder.path().join("021.plan.json")).expect("a plan file");
    let file: Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(answer["optimisation"], file["optimisation"]);
    let costs = costs(&answer);
    assert!(costs.len() > 1 && costs.windows(2).all(|pair| pair[1] < pair[0]), "{costs:?}");
    assert!(answer["optimisation"]["improvements"][0]["time_s"].is_f64());
    assert_eq!(cranny(folder.path(), &["verify", "021", "021.plan.json"]).status.code(), Some(0));
}

#[test]
fn iterations_decide_the_path_and_the_page_says_how_its_cost_fell() {
    let folder = folder();
    let run = |file: &str| {
        let planned = cranny(folder.path(), &[&BETTER[..], &["-o", file]].concat());
        assert_eq!(planned.status.code(), Some(0));
        let text = std::fs::read_to_string(folder.path().join(file)).expect("a plan file");
        let plan: Value = serde_json::from_str(&text).expect("JSON");
        let page = String::from_utf8_lossy(&planned.stdout).into_owned();
        let told: Vec<&str> = page.lines().filter(|line| line.starts_with("  cost")).collect();
        let costs = costs(&plan);
        assert!(told.len() > 1 && told.len() <= costs.len(), "{page}");
        for (line, cost) in [(told[0], costs[0]), (told[told.len() - 1], costs[costs.len() - 1])] {
            assert!(line.contains(&format!(" {cost:.3} (mix) after ")), "{line}: {cost}");
        }
        plan["waypoints"].to_string()
    };
    assert_eq!(run("a.plan.json"), run("b.plan.json"));
}

#[test]
fn what_does_not_go_together_is_refused() {
    let folder = folder();
    for (flags, word) in [
        (&["--optimise", "-1"][..], "from 0 to"),
        (&["--optimise", "1", "--no-shortcut"], "cannot be used with"),
        (&["--optimise", "1", "--criterion", "paper"], "only a path that is proven"),
        (&["--optimise", "1", "--score-weight", "nan"], "not a valid weight"),
        (&["--optimise", "1", "--score-weight", "-2"], "not a valid weight"),
        (&["--score-weight", "2"], "--optimise"),
    ] {
        let refused = cranny(folder.path(), &[&["plan", "021"], flags].concat());
        let text = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(refused.status.code() == Some(2) && text.contains(word), "{flags:?}: {text}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 0);
}
