//! Plans whose hand must hold the carried object, from the command line.

use std::path::Path;

use assert_cmd::Command;

/// Returns exit code and document of a simulation that answers.
fn answer(folder: &Path, arguments: &[&str]) -> (i32, serde_json::Value) {
    let (code, page, words) = cranny(folder, &[&["simulate"], arguments, &["--json"]].concat());
    (code, serde_json::from_str(&page).unwrap_or_else(|_| panic!("{arguments:?}: {words}")))
}

fn cranny(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    let mut command = Command::cargo_bin("cranny").expect("the program");
    let output = command.current_dir(folder).args(arguments).output().expect("it runs");
    let words = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code().expect("a code"), words(&output.stdout), words(&output.stderr))
}

fn document(folder: &Path, file: &str) -> serde_json::Value {
    serde_json::from_slice(&std::fs::read(folder.join(file)).expect("written")).expect("JSON")
}

/// At home, each of two grasps of the template holds the can on its side.
#[test]
fn a_goal_that_tilts_the_object_with_each_grasp_ends_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    assert_eq!(cranny(folder, &["scenario", "new", "my"]).0, 0);
    let [file, grasps] = ["my/scenario.yaml", "my/grasps.csv"].map(|name| folder.join(name));
    let text = std::fs::read_to_string(&file).unwrap();
    let (before, after) = text.split_once("\n  mass_kg:").expect("a mass");
    std::fs::write(&file, format!("{before}\n  upright_deg: 15\n  mass_kg:{after}")).unwrap();
    let text = std::fs::read_to_string(&grasps).unwrap();
    std::fs::write(&grasps, text.split_inclusive('\n').take(3).collect::<String>()).unwrap();
    let (code, page, _) = cranny(folder, &["plan", "my", "--carry", "home"]);
    assert!(code == 1 && page.contains("no-reachable-grasp") && page.contains("the bound 'tilt'"), "{page}");
    assert!(!page.contains("time-limit"), "{page}");
}

/// The plan of the README's first picture: the file states the hold factor, and `verify` confirms it.
#[test]
fn the_plan_of_the_first_picture_holds_its_object() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let (code, page, _) = cranny(folder, &["plan", "012", "--carry", "home"]);
    assert!(code == 0 && page.contains("along the whole motion"), "{page}");
    let plan = document(folder, "012.plan.json");
    assert!(plan["hold"]["factor"].as_f64().unwrap() >= 1.5 && plan["hold"]["mass_assumed"] == false);
    let (code, page, _) = cranny(folder, &["verify", "012", "012.plan.json"]);
    assert!(code == 0 && page.contains("hold"), "{page}");
    let (code, executed) = answer(folder, &["plan", "012", "012.plan.json", "--export", "run.json"]);
    assert_eq!((code, &executed["outcome"], &executed["is_kept"]), (0, &"held".into(), &true.into()));
    assert!(document(folder, "run.json")["held"].as_array().unwrap().len() > 500);
    assert_eq!(answer(folder, &["plan", "012", "012.plan.json", "--disturb", "3"]).0, 0);
    // A file that states a larger factor is detected.
    let mut lie = plan;
    lie["hold"]["factor"] = 9.0.into();
    std::fs::write(folder.join("lie.plan.json"), lie.to_string()).unwrap();
    let (code, page, _) = cranny(folder, &["verify", "012", "lie.plan.json"]);
    assert!(code == 1 && page.contains("hold.factor"), "{page}");
}

/// A slower motion along the same path holds at least as firmly, so no peak of the load of the faster one was missed.
#[test]
fn a_slower_copy_of_a_motion_holds_as_firmly() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for (scenario, flags) in [
        ("031", &["--carry", "home", "--seed", "2"][..]),
        ("033", &["--carry", "home", "--seed", "9", "--timing", "time-optimal"]),
        ("131", &["--place", "inside", "--seed", "7"]),
    ] {
        let (code, page, _) =
            cranny(folder, &[&["plan", scenario, "-o", "fast.plan.json", "--force"], flags].concat());
        assert_eq!(code, 0, "{page}");
        for share in [0.9988, 0.9983, 0.9975, 0.994] {
            let mut slow = document(folder, "fast.plan.json");
            for segment in slow["segments"].as_array_mut().unwrap() {
                if !segment["attached"].is_null() {
                    segment["speed"] = (segment["speed"].as_f64().unwrap_or(1.0) * share).into();
                }
            }
            std::fs::write(folder.join("slow.plan.json"), slow.to_string()).unwrap();
            let (_, page, _) = cranny(folder, &["verify", scenario, "slow.plan.json"]);
            assert!(
                page.contains("timing.duration_s") && !page.contains("hold_demanded: the file"),
                "{page}"
            );
            for line in page.lines().filter(|line| line.contains("hold.factor: ")) {
                let numbers = line.split([' ', ',']).filter_map(|word| word.parse::<f64>().ok());
                let [stated, measured] = numbers.collect::<Vec<_>>()[..] else { panic!("{line}") };
                assert!(measured >= stated, "{scenario} {share}: {line}");
            }
        }
    }
}

#[test]
fn a_hold_that_no_grasp_has_is_no_plan_and_its_reason_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let (code, page, _) =
        cranny(folder, &["plan", "012", "--carry", "home", "--hold", "50", "--time-limit", "3"]);
    assert!(code == 1 && page.contains("holds the object too weakly"), "{page}");
    let (code, _, words) = cranny(folder, &["plan", "012", "--carry", "home", "--hold", "-1"]);
    assert!(code == 2 && words.contains("not a valid factor of loads"), "{words}");
}

#[test]
fn plans_are_tried_in_physics_until_one_holds() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // Without a required hold factor, the first grasp of the box lets it slip.
    let weak = ["plan", "031", "--carry", "home", "--hold", "0", "--seed", "4"];
    let tried = |most: &str| {
        let tries = ["--try-in-physics", most, "-o", "031.plan.json"];
        let (code, page, words) = cranny(folder, &[&weak[..], &tries].concat());
        assert!(code < 2, "{words}");
        (code, page, document(folder, "031.plan.json"))
    };
    let (first, page, once) = tried("1");
    assert!(page.contains("physics     seed 4: slipped"), "{page}");
    let (code, _, plan) = tried("8");
    let tries = plan["tries"].as_array().unwrap();
    assert_eq!(tries[0]["as_planned"], once["tries"][0]["as_planned"]);
    assert_eq!((first == 0, code == 0), (tries.len() == 1, tries.last().unwrap()["as_planned"] == true));
    assert!(tries.len() > 1 && tries[0]["left_out"].is_object(), "{tries:?}");
    assert_eq!(plan["seed"], tries.last().unwrap()["seed"]);
    assert_eq!(cranny(folder, &["verify", "031", "031.plan.json"]).0, 0);
    let (code, executed) = answer(folder, &["plan", "031", "031.plan.json"]);
    assert_eq!(
        (code == 0, &executed["is_kept"]),
        (tries.last().unwrap()["as_planned"] == true, &tries.last().unwrap()["kept"])
    );
}

#[test]
fn grasps_that_hold_are_sampled() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let sample = [
        "grasps",
        "sample",
        "sugar_box",
        "--count",
        "5",
        "--candidates",
        "20",
        "--hold",
        "2",
        "-o",
        "firm.csv",
    ];
    let (code, page, words) = cranny(folder, &sample);
    assert!(code == 0 && page.contains("does not hold"), "{page}{words}");
    let (code, _, words) = cranny(folder, &["grasps", "sample", "sugar_box", "--mass", "0"]);
    assert!(code == 2 && words.contains("--mass"), "{words}");
}

#[test]
fn a_target_that_does_not_rest_is_no_sound_scenario() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let scenario = |shape: &str, height: f64| {
        std::fs::create_dir_all(folder.join("mine")).unwrap();
        let text = format!(
            "robot: panda_mobile\nframe: {{position: [0, 0, 0.05]}}\nstart: [0, 0, 0, -0.76, 0, -2.34, 0, 1.54, 0.75]\nfloor: 0\ntarget:\n  name: thing\n  \
             mass_kg: 0.2\n  pose: {{position: [0.8, 0, {height}]}}\n  shapes:\n    - {shape}\n"
        );
        std::fs::write(folder.join("mine/scenario.yaml"), text).unwrap();
        cranny(folder, &["scenario", "check", "mine"])
    };
    let cube = "box: {size: [0.04, 0.04, 0.04]}";
    let (code, page, words) = scenario(cube, 0.02);
    assert_eq!(code, 0, "{page}{words}");
    let (code, page, _) = scenario(cube, 0.06);
    assert!(code == 1 && page.contains("does not rest at its pose") && page.contains("-0.0300"), "{page}");
}

/// A planner that generates its own grasps serves the columns; the target has a set.
#[test]
fn a_named_planner_serves_the_stages_that_it_suits() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let (code, page, words) = cranny(folder, &["plan", "235", "--steps", "--planner", "grasp-reach"]);
    assert_eq!(code, 0, "{page}{words}");
    assert_eq!(cranny(folder, &["verify", "235", "235.plan.json"]).0, 0);
    // The objects are measured after each pick, and the rest is replanned if one is off.
    let (code, executed) = answer(folder, &["plan", "235", "235.plan.json", "--replan"]);
    assert!(code < 2 && executed["new_plans"].is_u64(), "{executed}");
    assert_eq!(executed["as_planned"] == true, executed["stopped"].is_null(), "{executed}");
    let (code, _, words) =
        cranny(folder, &["simulate", "plan", "235", "235.plan.json", "--export", "x.json"]);
    assert!(code == 2 && words.contains("3 picks"), "{words}");
}
