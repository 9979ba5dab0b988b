//! The program from the command line: answers, exit codes, files.

use std::path::Path;
use std::process::Output;

use assert_cmd::Command;
use serde_json::Value;

fn cranny(folder: &Path, arguments: &[&str]) -> Output {
    Command::cargo_bin("cranny")
        .expect("the program")
        .current_dir(folder)
        .args(arguments)
        .output()
        .expect("it runs")
}

fn json(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).expect("one JSON document on standard output")
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

fn has_keys(value: &Value, keys: &str) {
    for key in keys.split_whitespace() {
        assert!(value.get(key).is_some(), "no key '{key}' in {value}");
    }
}

#[test]
fn a_built_in_scenario_is_planned_verified_and_written() {
    let folder = folder();
    let planned = cranny(folder.path(), &["plan", "021"]);
    assert_eq!(planned.status.code(), Some(0));
    let summary = String::from_utf8_lossy(&planned.stdout);
    for word in ["solved", "grasp", "mm", "°", "clearance", "way points", "iterations", "021.plan.json"] {
        assert!(summary.contains(word), "no '{word}' in {summary}");
    }
    let verified = cranny(folder.path(), &["verify", "021", "021.plan.json", "--json"]);
    assert_eq!(verified.status.code(), Some(0));
    let verdict = json(&verified);
    has_keys(&verdict, "valid violations goal clearance_m");
    assert_eq!(verdict["valid"], true);
    assert!(verdict["goal"]["translation_error_m"].as_f64().is_some_and(|e| e <= 1e-3));
    assert!(verdict["clearance_m"].as_f64().is_some_and(|c| c > 0.0));
}

#[test]
fn the_json_keys_of_a_plan_stay() {
    let folder = folder();
    let planned = cranny(folder.path(), &["plan", "022", "--json", "--seed", "3", "-o", "p.plan.json"]);
    assert_eq!(planned.status.code(), Some(0));
    has_keys(
        &json(&planned),
        "scenario planner criterion seed outcome grasp translation_error_m rotation_error_rad clearance_m \
         path_length planning_time_s iterations waypoints plan_file",
    );
    assert_eq!(json(&planned)["outcome"], "solved");
    assert_eq!(json(&planned)["criterion"], "exact");
}

/// Plans in 021 with one environment variable set and returns the way points.
fn way_points(planner: &str, variable: (&str, &str)) -> String {
    let folder = folder();
    let output = Command::cargo_bin("cranny")
        .expect("the program")
        .current_dir(folder.path())
        .env(variable.0, variable.1)
        .args(["plan", "021", "--planner", planner, "--seed", "1", "--iterations", "200000", "-o", "p.json"])
        .output()
        .expect("it runs");
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stdout));
    let text = std::fs::read_to_string(folder.path().join("p.json")).expect("a plan file");
    serde_json::from_str::<Value>(&text).expect("JSON")["waypoints"].to_string()
}

#[test]
fn a_seed_and_a_budget_of_iterations_give_the_same_bytes_on_any_number_of_threads() {
    for planner in ["reach", "ik-rrt", "j-plus-rrt"] {
        let first = way_points(planner, ("RAYON_NUM_THREADS", "1"));
        assert_eq!(first, way_points(planner, ("RAYON_NUM_THREADS", "1")));
        assert_eq!(first, way_points(planner, ("RAYON_NUM_THREADS", "2")));
    }
}

#[test]
fn every_instruction_set_gives_the_same_bytes() {
    for planner in ["reach", "ik-rrt", "j-plus-rrt"] {
        let widest = way_points(planner, ("CRANNY_SIMD", "avx512"));
        for narrower in ["avx2", "sse2"] {
            assert_eq!(widest, way_points(planner, ("CRANNY_SIMD", narrower)), "{planner} with {narrower}");
        }
    }
}

#[test]
fn ik_says_for_every_grasp_what_became_of_it() {
    let folder = folder();
    let found = cranny(folder.path(), &["ik", "021", "--attempts", "200", "--grasp-margin", "4", "--json"]);
    assert_eq!(found.status.code(), Some(0));
    let grasps = json(&found)["grasps"].as_array().expect("a list").clone();
    assert_eq!(grasps.len(), 200);
    let solved = grasps.iter().find(|g| g["status"] == "solved").expect("a grasp that can be held");
    has_keys(&solved["solutions"][0], "q translation_error_m rotation_error_rad clearance_m");
    assert!(grasps.iter().any(|g| g["status"] == "hand-collides" && g["blocked_by"].is_string()));
    let threads = |n: &str| {
        let mut command = Command::cargo_bin("cranny").expect("the program");
        command.env("RAYON_NUM_THREADS", n).args([
            "ik",
            "021",
            "--attempts",
            "200",
            "--grasp-margin",
            "4",
            "--json",
        ]);
        command.output().expect("it runs").stdout
    };
    assert_eq!(threads("1"), threads("2"));
}

#[test]
fn ik_by_a_single_shot_makes_at_most_one_attempt_at_each_pose() {
    let folder = folder();
    let found = cranny(folder.path(), &["ik", "021", "--single-shot", "--json"]);
    let grasps = json(&found)["grasps"].as_array().expect("a list").clone();
    assert!(grasps.iter().all(|g| g["attempts"].as_u64().is_some_and(|attempts| attempts <= 2)));
    let is_blocked = |g: &Value| g["status"] == "no-solution" && g["blocked_by"].is_string();
    assert!(grasps.iter().any(is_blocked), "what stood in the way of an arm is named");
    let both = cranny(folder.path(), &["ik", "021", "--single-shot", "--attempts", "5"]);
    assert_eq!(both.status.code(), Some(2));
}

#[test]
fn a_bad_path_is_refused_with_every_violation_named() {
    let folder = folder();
    let straight = "0,0,-0.0178,-0.7601,0.0198,-2.3421,0.0298,1.5412,0.7534\n0.9,0.9,0,1.5,0,-0.5,0,1.5,0\n";
    std::fs::write(folder.path().join("straight.csv"), straight).expect("written");
    let verified = cranny(folder.path(), &["verify", "021", "straight.csv", "--json"]);
    assert_eq!(verified.status.code(), Some(1));
    let verdict = json(&verified);
    assert_eq!(verdict["valid"], false);
    let violations = verdict["violations"].as_array().expect("a list");
    let contact = violations.iter().find(|v| v["kind"] == "contact").expect("a contact");
    has_keys(contact, "kind edge at first second depth_m");
    assert!(contact["depth_m"].as_f64().is_some_and(|d| d > 0.0));
    assert!(violations.iter().any(|v| v["kind"] == "goal"));
    let text = cranny(folder.path(), &["verify", "021", "straight.csv"]);
    assert!(String::from_utf8_lossy(&text.stdout).contains("deep in"));
}

#[test]
fn margins_are_demanded_of_plan_and_verification() {
    let folder = folder();
    let margins = ["--margin", "5", "--grasp-margin", "1"];
    let planned = cranny(folder.path(), &[&["plan", "021"], &margins[..]].concat());
    assert_eq!(planned.status.code(), Some(0));
    let verified = cranny(folder.path(), &[&["verify", "021", "021.plan.json"], &margins[..]].concat());
    assert_eq!(verified.status.code(), Some(0));
    let harder = cranny(folder.path(), &["verify", "021", "021.plan.json", "--margin", "60"]);
    assert_eq!(harder.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&harder.stdout).contains("60.000 mm are demanded"));
}

#[test]
fn a_search_that_runs_out_of_budget_is_an_honest_no() {
    let folder = folder();
    let planned = cranny(folder.path(), &["plan", "021", "--iterations", "1", "--planner", "j-plus-rrt"]);
    assert_eq!(planned.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&planned.stdout).contains("budget-exhausted"));
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 0, "nothing is written");
}

#[test]
fn list_info_and_help_answer() {
    let folder = folder();
    let list = cranny(folder.path(), &["list"]);
    assert!(String::from_utf8_lossy(&list.stdout).contains("025"));
    let info = json(&cranny(folder.path(), &["info", "025", "--json"]));
    assert_eq!((&info["grasps"], &info["start_is_free"]), (&200.into(), &true.into()));
    for command in ["plan", "verify", "ik"] {
        let help = cranny(folder.path(), &["help", command]);
        assert!(String::from_utf8_lossy(&help.stdout).contains("Examples"), "{command}");
    }
}

#[test]
fn a_grasp_of_its_own_is_planned_and_judged_and_lies_about_it_are_found() {
    let folder = folder();
    let planned = cranny(folder.path(), &["plan", "021", "--grasps", "none", "--json"]);
    assert_eq!(planned.status.code(), Some(0), "{}", String::from_utf8_lossy(&planned.stderr));
    let plan = json(&planned);
    assert_eq!((&plan["planner"], &plan["grasps"]), (&"grasp-reach".into(), &"none".into()));
    has_keys(&plan["own_grasp"], "world_from_gripper opening_m score uneven_m");
    assert!(plan["grasp"].is_null());
    let verify = |name: &str| cranny(folder.path(), &["verify", "021", name, "--json"]);
    let verdict = json(&verify("021.plan.json"));
    assert_eq!((&verdict["valid"], &verdict["own_grasp"]), (&true.into(), &plan["own_grasp"]));
    let info = cranny(folder.path(), &["info", "021", "--grasps", "none", "--json"]);
    assert_eq!(json(&info)["grasps"], 0);

    let read = std::fs::read_to_string(folder.path().join("021.plan.json")).expect("a plan");
    let sound: Value = serde_json::from_str(&read).expect("JSON");
    for (pointer, value, code, says) in [
        ("/own_grasp/score", 0.999.into(), 1, "stated 0.999"),
        ("/own_grasp/opening_m", 0.001.into(), 1, "stated 1.00"),
        ("/own_grasp/uneven_m", 0.5.into(), 1, "before the other, stated 500.00"),
        ("/own_grasp/world_from_gripper/0/3", 9.0.into(), 1, "from the stated one"),
        ("/own_grasp/world_from_gripper/0/0", 9.0.into(), 1, "is not a pose"),
        ("/own_grasp/world_from_gripper", Value::Null, 2, "lie.plan.json"),
        ("/own_grasp/score", Value::Null, 2, "lie.plan.json"),
    ] {
        let mut lie = sound.clone();
        *lie.pointer_mut(pointer).expect("a key") = value;
        std::fs::write(folder.path().join("lie.plan.json"), lie.to_string()).expect("a writable folder");
        let judged = cranny(folder.path(), &["verify", "021", "lie.plan.json"]);
        let said = [judged.stdout, judged.stderr].concat();
        let said = String::from_utf8_lossy(&said);
        assert!(judged.status.code() == Some(code) && said.contains(says), "{pointer}: {said}");
    }
}

#[test]
fn what_goes_with_no_set_of_grasps_is_said() {
    let folder = folder();
    for (arguments, says) in [
        (&["plan", "021", "--grasps", "none", "--planner", "ik-rrt"][..], "grasp-reach, grasp-rrt"),
        (&["plan", "021", "--planner", "grasp-rrt"], "--grasps none"),
        (&["plan", "021", "--grasps", "none", "--criterion", "paper"], "the exact criterion"),
        (&["plan", "021", "--grasps", "none", "--score", "physics"], "geometric score"),
        (&["plan", "021", "--grasps", "nowhere.csv"], "nowhere.csv"),
        (
            &["bench", "run", "--scenarios", "021", "--planners", "reach", "--grasps", "none"],
            "grasp-reach, grasp-rrt",
        ),
        (
            &[
                "bench",
                "run",
                "--scenarios",
                "021",
                "--planners",
                "grasp-reach",
                "--grasps",
                "none",
                "--judge-both",
            ],
            "judge_both",
        ),
    ] {
        let refused = cranny(folder.path(), arguments);
        let said = String::from_utf8_lossy(&refused.stderr);
        assert!(refused.status.code() == Some(2) && said.contains(says), "{arguments:?}: {said}");
    }
}

#[test]
fn trials_with_and_without_a_set_of_grasps_stand_apart() {
    let folder = folder();
    let run = |more: &[&str]| {
        let all = [&["bench", "run", "--scenarios", "021", "--runs", "2", "--quiet"], more].concat();
        let ran = cranny(folder.path(), &all);
        assert_eq!(ran.status.code(), Some(0), "{}", String::from_utf8_lossy(&ran.stderr));
    };
    run(&["--planners", "grasp-reach", "--grasps", "none"]);
    run(&["--planners", "reach"]);
    let report = cranny(folder.path(), &["bench", "report", "results.db", "--format", "json"]);
    let summary = json(&report);
    let rows = summary["rows"].as_array().expect("rows");
    let mut names: Vec<_> = rows.iter().filter_map(|row| row["planner_name"].as_str()).collect();
    names.sort_unstable();
    assert_eq!(names, ["grasp-reach (no grasp set)", "reach"]);
    assert!(rows.iter().all(|row| row["solved"] == 2 && row["grasp_score"].is_object()), "{rows:?}");
    assert!(summary["warnings"].to_string().contains("a different problem"), "{}", summary["warnings"]);
    let replayed = cranny(folder.path(), &["bench", "replay", "results.db", "1"]);
    assert_eq!(replayed.status.code(), Some(0), "{}", String::from_utf8_lossy(&replayed.stderr));
}

#[test]
fn the_version_says_what_a_report_of_a_fault_needs() {
    let folder = folder();
    let said = cranny(folder.path(), &["--version"]);
    let text = String::from_utf8_lossy(&said.stdout);
    assert!(text.starts_with(concat!("cranny ", env!("CARGO_PKG_VERSION"), "\n")), "{text}");
    for word in ["commit: ", "target: ", "vectors: "] {
        assert!(text.contains(word), "no '{word}' in {text}");
    }
    let short = cranny(folder.path(), &["-V"]);
    assert_eq!(String::from_utf8_lossy(&short.stdout).lines().count(), 1);
}

/// Guards reproducibility to the byte: the digest in `doctor.rs` is the same on every machine.
#[test]
fn the_doctor_finds_plans_proofs_and_every_vector_instruction_sound() {
    let folder = folder();
    let levels = cranny_spatial::simd_levels();
    for (level, _) in levels {
        let mut command = Command::cargo_bin("cranny").expect("the program");
        let said = command.env("CRANNY_SIMD", level).args(["doctor", "--json"]).output().expect("it runs");
        let findings = json(&said);
        assert_eq!(said.status.code(), Some(0), "{findings:#}");
        has_keys(&findings, "version commit target vectors cores parts checks sound");
        assert_eq!((&findings["vectors"], &findings["sound"]), (&level.into(), &true.into()));
        assert_eq!(findings["checks"].as_array().map(Vec::len), Some(4));
    }
    let said = cranny(folder.path(), &["doctor", "--quiet"]);
    assert!(String::from_utf8_lossy(&said.stdout).contains("No problems found."));
}

#[test]
fn shells_complete_every_command() {
    let folder = folder();
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let said = cranny(folder.path(), &["completions", shell]);
        let script = String::from_utf8_lossy(&said.stdout);
        assert_eq!(said.status.code(), Some(0));
        for word in ["cranny", "doctor", "simulate", "grasp-margin"] {
            assert!(script.contains(word), "no '{word}' for {shell}");
        }
    }
    assert_eq!(cranny(folder.path(), &["completions", "dos"]).status.code(), Some(2));
}

#[test]
fn every_command_has_a_manual_page_and_nothing_else_is_written_over() {
    let folder = folder();
    let page = cranny(folder.path(), &["man"]);
    assert!(String::from_utf8_lossy(&page.stdout).contains(".TH cranny 1"));
    let pages = folder.path().join("man1");
    for _ in 0..2 {
        assert_eq!(cranny(folder.path(), &["man", "-o", "man1"]).status.code(), Some(0));
    }
    for name in ["cranny.1", "cranny-plan.1", "cranny-bench-run.1", "cranny-doctor.1"] {
        assert!(pages.join(name).is_file(), "no {name}");
    }
    std::fs::write(pages.join("cranny-plan.1"), "my notes").expect("written");
    std::fs::write(pages.join("cranny.1"), "").expect("written");
    assert_eq!(cranny(folder.path(), &["man", "-o", "man1"]).status.code(), Some(2));
    assert_eq!(std::fs::read(pages.join("cranny.1")).expect("read"), b"");
    assert_eq!(std::fs::read(pages.join("cranny-plan.1")).expect("read"), b"my notes");
}

#[test]
fn the_licences_of_others_go_with_the_program() {
    let folder = folder();
    let said = cranny(folder.path(), &["licences"]);
    let text = String::from_utf8_lossy(&said.stdout);
    for word in ["Cranny (MIT)", "Apache License", "three.js", "rapier3d-f64", "parry3d-f64", "nalgebra"] {
        assert!(text.contains(word), "no '{word}'");
    }
}

#[test]
fn a_plan_without_a_path_is_told_by_its_outcome() {
    let folder = folder();
    let searched = cranny(folder.path(), &["plan", "045", "--iterations", "1", "-o", "none.plan.json"]);
    assert_eq!(searched.status.code(), Some(1));
    let judged = cranny(folder.path(), &["verify", "045", "none.plan.json"]);
    assert_eq!(judged.status.code(), Some(2));
    let said = String::from_utf8_lossy(&judged.stderr);
    assert!(
        said.contains(
            "none.plan.json: the plan has no path (stated outcome of its search: budget-exhausted)"
        ),
        "{said}"
    );
}

#[test]
fn a_verdict_says_by_which_criterion() {
    let folder = folder();
    let planned = cranny(folder.path(), &["plan", "021", "--criterion", "paper", "--planner", "j-plus-rrt"]);
    assert_eq!(planned.status.code(), Some(0));
    let judged = cranny(folder.path(), &["verify", "021", "021.plan.json"]);
    let said = String::from_utf8_lossy(&judged.stdout);
    assert!(said.starts_with("valid under the paper's criterion, which proves nothing: "), "{said}");
    let judged = cranny(folder.path(), &["verify", "021", "021.plan.json", "--json"]);
    assert_eq!(json(&judged)["criterion"], "paper");
}

#[test]
fn a_verdict_names_the_robot_and_the_grasps_that_the_plan_brought_along() {
    let folder = folder();
    let own = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenario/scenarios/021/grasps.csv");
    std::fs::copy(own, folder.path().join("given.csv")).expect("copied");
    for [flag, file] in [["--robot", "ur5e-mobile"], ["--grasps", "given.csv"]] {
        assert_eq!(cranny(folder.path(), &["plan", "021", flag, file]).status.code(), Some(0), "{file}");
        let judged = cranny(folder.path(), &["verify", "021", "021.plan.json"]);
        let said = String::from_utf8_lossy(&judged.stdout);
        assert_eq!(judged.status.code(), Some(0), "{said}");
        let line = format!("  {:<12}{file}, from the plan file", &flag[2..]);
        assert!(said.contains(&line), "{said}");
    }
    let mine = cranny(folder.path(), &["verify", "021", "021.plan.json", "--grasps", "given.csv"]);
    assert!(!String::from_utf8_lossy(&mine.stdout).contains("from the plan file"), "flags go before it");
}
