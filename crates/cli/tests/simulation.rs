//! Grasps in physics from the command line.

use std::path::Path;
use std::process::Output;

use assert_cmd::Command;
use cranny_scenario::{OpenOptions, Scenario};

fn run(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::cargo_bin("cranny").expect("the program");
    command.current_dir(folder).arg("simulate").args(arguments).output().expect("it runs")
}

/// Returns exit code and document of a command that answers.
fn answer(folder: &Path, arguments: &[&str]) -> (i32, serde_json::Value) {
    let output = run(folder, &[arguments, &["--json"]].concat());
    let document = serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|_| panic!("{arguments:?}: {}", String::from_utf8_lossy(&output.stderr)));
    (output.status.code().expect("a code"), document)
}

fn refused(folder: &Path, arguments: &[&str], words: &[&str]) {
    let output = run(folder, arguments);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
    for word in words {
        assert!(error.contains(word), "no '{word}' in: {error}");
    }
}

#[test]
fn a_grasp_of_a_scenario_is_tried_and_recorded() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let one = ["grasps", "021", "--grasp", "3", "--support-only", "--trials", "4", "--record", "three.glb"];
    let (code, document) = answer(folder, &one);
    assert_eq!(code, 0);
    assert_eq!(
        (&document["subject"], &document["grasps"], &document["held"]),
        (&"021".into(), &1.into(), &1.into())
    );
    let row = &document["rows"][0];
    assert_eq!((&row["grasp"], &row["outcome"]), (&3.into(), &"held".into()));
    for key in ["translation_error_m", "rotation_error_rad", "held_s", "contact_force_n", "score"] {
        assert!(row[key].is_f64(), "{key}: {row}");
    }
    assert_eq!(row["robust"]["trials"], 4);
    assert_eq!(&std::fs::read(folder.join("three.glb")).expect("written")[..4], b"glTF");
    // The recorded trajectories are drawn later, without physics.
    answer(folder, &["grasps", "021", "--grasp", "3", "--support-only", "--record", "three.json"]);
    let recording = cranny_view::BodyRecording::read(&folder.join("three.json")).expect("a recording");
    assert!(recording.bodies.iter().any(|body| body.is_grasped) && recording.times_s.len() > 10);
    let render = |words: &str| {
        let mut command = Command::cargo_bin("cranny").expect("the program");
        let command = command.current_dir(folder).args(["render", "three.json"]);
        command.args(words.split_whitespace()).output().expect("it runs")
    };
    for (words, file, head) in [
        ("-o a.gif --rate 5 --size 32x24", "a.gif", &b"GIF8"[..]),
        ("-o a.png --time 0.1 --size 32x24", "a.png", b"\x89PNG"),
        ("-o frames/ --rate 1 --size 32x24", "frames/0001.png", b"\x89PNG"),
        ("-o a.html", "a.html", b"<!"),
    ] {
        let output = render(words);
        assert!(output.status.success(), "{words}: {}", String::from_utf8_lossy(&output.stderr));
        assert!(std::fs::read(folder.join(file)).expect("written").starts_with(head), "{words}");
    }
    // The model is the same as if it had been written at once.
    assert!(render("-o again.glb").status.success());
    let model = |name: &str| std::fs::read(folder.join(name)).expect("written");
    assert_eq!(model("again.glb"), model("three.glb"));
    for (words, said) in [
        ("three.json -o a.png", "contains the whole scene"),
        ("-o a.png --time 1000", "after the end of the motion"),
    ] {
        let output = render(words);
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && error.contains(said), "{words}: {error}");
    }
    // An object that is too heavy drops, which is a negative result.
    let (code, document) = answer(folder, &["grasps", "021", "--grasp", "3", "--mass", "50"]);
    assert_eq!((code, &document["held"]), (1, &0.into()));
}

#[test]
fn grasps_of_an_object_stand_in_a_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let mut sample = Command::cargo_bin("cranny").expect("the program");
    let sample =
        sample.current_dir(folder).args(["grasps", "sample", "sugar_box", "--count", "2", "-o", "box.csv"]);
    assert!(sample.output().expect("it runs").status.success());
    let (_, floating) = answer(folder, &["grasps", "sugar_box", "--grasps", "box.csv", "--friction", "0.9"]);
    assert_eq!(floating["grasps"], 2);
    // The same grasp fails with a heavy object.
    let heavy = ["grasps", "sugar_box", "--grasps", "box.csv", "--mass", "40", "--pose", "0"];
    assert_eq!(answer(folder, &heavy).1["held"], 0);
    // Robust scores are added to the columns of the file, whose poses stay in the frame of the object.
    let scored =
        ["grasps", "sugar_box", "--grasps", "box.csv", "--pose", "0", "--trials", "2", "--grasp", "1"];
    let (_, document) = answer(folder, &[&scored[..], &["-o", "scored.csv"]].concat());
    assert_eq!(document["file"], "scored.csv");
    let read = |name: &str| cranny_grasp::read_csv(&folder.join(name)).expect("grasps");
    let (before, after) = (read("box.csv"), read("scored.csv"));
    let robust = &document["rows"][0]["robust"];
    let known = after.grasps()[1].robust.expect("a robust score");
    assert_eq!((known.trials, &known.held.into()), (2, &robust["held"]));
    assert_eq!(after.grasps()[0].robust, None);
    for (before, after) in before.grasps().iter().zip(after.grasps()) {
        assert_eq!((before.score, before.width_m), (after.score, after.width_m));
        assert!(before.difference(&after.world_from_gripper).translation_m < 1e-12);
    }
    // A second run keeps the values of the other grasps.
    let zero = ["grasps", "sugar_box", "--grasps", "scored.csv", "--trials", "1", "--grasp", "0"];
    answer(folder, &[&zero[..], &["-o", "scored.csv"]].concat());
    let trials = |grasp: &cranny_grasp::Grasp| grasp.robust.map(|robust| robust.trials);
    assert_eq!(read("scored.csv").grasps().iter().map(trials).collect::<Vec<_>>(), [Some(1), Some(2)]);
    refused(folder, &["grasps", "sugar_box"], &["--grasps", "cranny grasps sample sugar_box"]);
    refused(
        folder,
        &["grasps", "sugar_box", "--grasps", "box.csv", "--pose", "9"],
        &["3 stable poses", "counted from 0"],
    );
    refused(folder, &["grasps", "sugar_box", "--grasps", "box.csv", "--support-only"], &["--support-only"]);
}

#[test]
fn physics_counts_where_a_plan_is_asked_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let plan = |arguments: &[&str]| {
        let mut command = Command::cargo_bin("cranny").expect("the program");
        command.current_dir(folder).args(["plan", "021", "--iterations", "3000"]).args(arguments);
        command.output().expect("it runs")
    };
    let read = |name: &str| cranny_record::PlanFile::read(&folder.join(name)).expect("a plan");
    // By the geometric score, another grasp is tried first.
    assert!(plan(&["--planner", "ik-rrt", "-o", "geometric.json"]).status.success());
    let (scenario, best) = (Scenario::open("021", &OpenOptions::default()).expect("a scenario"), 139);
    assert_ne!(read("geometric.json").grasp, Some(best));
    let robust =
        |grasp| Some(cranny_grasp::RobustScore { trials: 4, held: if grasp == best { 4 } else { 1 } });
    let grasps = scenario.grasps.grasps().iter().enumerate();
    let scored =
        grasps.map(|(index, grasp)| cranny_grasp::Grasp { robust: robust(index), ..*grasp }).collect();
    let scored = cranny_grasp::GraspSet::new(scored).expect("grasps");
    std::fs::write(folder.join("scored.csv"), cranny_grasp::csv_text(&scored)).expect("written");
    let by_physics =
        ["--planner", "ik-rrt", "--grasps", "scored.csv", "--score", "physics", "-o", "p.plan.json"];
    let output = plan(&by_physics);
    assert!(String::from_utf8_lossy(&output.stdout).contains("139 of 200 (robust score 1.00)"), "{output:?}");
    let planned = read("p.plan.json");
    assert_eq!((planned.grasp, planned.score), (Some(best), cranny_grasp::ScoreKind::Physics));
    assert_eq!(planned.grasps.as_deref(), Some("scored.csv"));
    assert_eq!(planned.score, cranny_grasp::ScoreKind::Physics);
    // Grasps below the minimum score are no goals, and the numbers of the grasps stay.
    let above = [&by_physics[..6], &["--min-score", "0.5", "-o", "m.plan.json"]].concat();
    let output = plan(&above);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.contains("139 of 200 (robust score 1.00; 199 below 0.5 are no goals)"), "{text}");
    let planned = read("m.plan.json");
    assert_eq!(
        (planned.grasp, planned.min_score, planned.below_min_score),
        (Some(best), Some(0.5), Some(199))
    );
    for (least, words) in [("1.5", "from 0 to 1"), ("-1", "from 0 to 1"), ("nan", "from 0 to 1")] {
        let refused = plan(&["--min-score", least]);
        assert_eq!(refused.status.code(), Some(2));
        assert!(String::from_utf8_lossy(&refused.stderr).contains(words), "{refused:?}");
    }
    let refused = plan(&["--min-score", "1"]);
    let error = String::from_utf8_lossy(&refused.stderr);
    assert!(error.contains("--min-score: no grasp has a geometric score of 1 or more; the best"), "{error}");
    // An untested grasp has no robust score.
    let refused = plan(&["--score", "physics"]);
    let error = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(2));
    assert!(error.contains("--score: grasp 0 has no robust score") && error.contains("--trials"), "{error}");
}

#[test]
fn the_grasps_of_a_campaign_are_tried_once_each() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let cranny = |words: &str| {
        let mut command = Command::cargo_bin("cranny").expect("the program");
        command.current_dir(folder).args(words.split_whitespace()).output().expect("it runs")
    };
    let example = |name: &str| {
        let entry = cranny_scenario::catalogue().iter().find(|entry| entry.id == "021").expect("built in");
        std::fs::create_dir_all(folder.join(name)).expect("a folder");
        let (scenario, grasps) = entry.files();
        std::fs::write(folder.join(name).join("scenario.yaml"), scenario).expect("written");
        std::fs::write(folder.join(name).join("grasps.csv"), grasps).expect("written");
    };
    example("mine");
    assert!(cranny("bench run --scenarios ./mine --planners reach --runs 3 -o results.db").status.success());
    let words = ["results", "results.db", "--support-only", "--trials", "1"];
    let (code, document) = answer(folder, &words);
    let planner = &document["planners"][0];
    assert_eq!((code, &document["scenarios"], &planner["solved"]), (0, &1.into(), &3.into()));
    assert_eq!((&planner["planner"], &planner["criterion"]), (&"reach".into(), &"exact".into()));
    assert!(planner["robust_score"].is_f64() && planner["held"].as_u64().is_some_and(|held| held <= 3));
    assert_eq!(answer(folder, &words).1, document);
    let rows = || -> u64 {
        let results = rusqlite::Connection::open(folder.join("results.db")).expect("a database");
        results.query_row("SELECT count(*) FROM simulated_grasps", [], |row| row.get(0)).expect("a count")
    };
    assert_eq!(document["grasps"], rows());
    // A scenario without a mass is skipped, and the others are not.
    std::fs::create_dir(folder.join("light")).expect("a folder");
    let (scenario, grasps) = ("mine/scenario.yaml", "mine/grasps.csv");
    let read = |file: &str| std::fs::read_to_string(folder.join(file)).expect("a file");
    let light = read(scenario).replace("  mass_kg: 0.058\n", "");
    std::fs::write(folder.join("light/scenario.yaml"), light).expect("written");
    std::fs::copy(folder.join(grasps), folder.join("light/grasps.csv")).expect("copied");
    let both = "bench run --scenarios ./mine,./light --planners reach --runs 3 -o both.db";
    assert!(cranny(both).status.success());
    let (code, of_both) = answer(folder, &["results", "both.db", "--support-only", "--trials", "1"]);
    assert_eq!((code, &of_both["scenarios"], &of_both["planners"]), (1, &1.into(), &document["planners"]));
    let skipped = &of_both["skipped"][0];
    assert_eq!((&skipped["scenario"], &skipped["trials"]), (&"light".into(), &3.into()));
    assert!(skipped["reason"].as_str().is_some_and(|reason| reason.contains("mass_kg")), "{skipped}");
    // The campaign is unchanged, and can be resumed.
    assert!(cranny("bench report results.db -o report.json").status.success());
    assert!(cranny("bench run --scenarios ./mine --planners reach --runs 4 -o results.db").status.success());
    std::fs::write(folder.join("mine/grasps.csv"), "1,0,0,2,0,1,0,2,0,0,1,0.5,0,0,0,1\n").expect("written");
    refused(folder, &["results", "results.db"], &["results.db", "scenario mine", "changed", "mine"]);
    // Without a solved trial there is no grasp.
    let none = "bench run --scenarios 021 --planners ik-rrt --runs 1 --iterations 0 -o none.db";
    assert!(cranny(none).status.success());
    refused(folder, &["results", "none.db"], &["none.db", "no trial is solved"]);
    std::fs::write(folder.join("text.db"), "no database\n").expect("written");
    refused(folder, &["results", "text.db"], &["text.db", "cranny bench run"]);
    refused(folder, &["results", "nothing.db"], &["nothing.db", "cranny bench run"]);
}

#[test]
fn bad_input_is_refused_in_one_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    refused(folder, &["grasps", "021", "--grasp", "999"], &["--grasp", "200 grasps"]);
    refused(folder, &["grasps", "021", "--grasp", "0", "--record", "a.mp4"], &["--record", ".glb"]);
    refused(folder, &["grasps", "021", "--record", "a.glb"], &["--grasp"]);
    refused(folder, &["grasps", "021", "--grasp", "0", "-o", "a.csv"], &["--output", "--trials"]);
    refused(folder, &["grasps", "021", "--friction", "-1"], &["--friction", "positive"]);
    refused(folder, &["grasps", "nothing_there"], &["nothing_there"]);
    // A scenario whose target has no mass.
    let scenario = "robot: panda_mobile\nstart: [0, 0, 0, 0, 0, -1.5, 0, 1.5, 0]\nfloor: null\ntarget:\n  name: cup\n  \
                    pose: {position: [2, 2, 0.5]}\n  shapes:\n    - sphere: {radius: 0.03}\n";
    std::fs::create_dir(folder.join("cup")).expect("a folder");
    std::fs::write(folder.join("cup/scenario.yaml"), scenario).expect("written");
    std::fs::write(folder.join("cup/grasps.csv"), "1,0,0,2,0,1,0,2,0,0,1,0.5,0,0,0,1\n").expect("written");
    refused(folder, &["grasps", "cup"], &["cup", "mass_kg"]);
    assert_ne!(run(folder, &["grasps", "cup", "--mass", "0.1"]).status.code(), Some(2));
}

#[test]
fn an_object_is_dropped_again_and_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let drops = ["settle", "sugar_box", "--count", "40", "--seed", "2"];
    let (code, document) = answer(folder, &drops);
    assert_eq!(code, 0);
    let counts = document["poses"]
        .as_array()
        .expect("poses")
        .iter()
        .map(|pose| pose["count"].as_u64().expect("a count"));
    let others = ["elsewhere", "still_moving"].map(|key| document[key].as_u64().expect("a count"));
    assert_eq!(counts.sum::<u64>() + others.iter().sum::<u64>(), 40);
    // A box comes to rest on one of its sides.
    assert_eq!(others, [0, 0]);
    assert_eq!(answer(folder, &drops).1, document);
    refused(folder, &["settle", "sugar_box", "--count", "0"], &["--count", "from 1"]);
    refused(folder, &["settle", "nothing"], &["nothing", "banana"]);
}

#[test]
fn an_experiment_is_written_for_another_engine() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let (code, document) = answer(folder, &["export", "021", "--support-only"]);
    assert_eq!((code, &document["grasps"]), (0, &200.into()));
    let text = std::fs::read_to_string(folder.join("experiment.json")).expect("written");
    let experiment: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(experiment["grasps"].as_array().expect("grasps").len(), 200);
    // A file of its kind is overwritten, another is not.
    assert_eq!(answer(folder, &["export", "021", "--friction", "0.5"]).0, 0);
    refused(folder, &["export", "021", "--mjcf"], &["experiment.json", "--force"]);
    assert_eq!(answer(folder, &["export", "021", "--mjcf", "-o", "ball.xml"]).0, 0);
    assert!(std::fs::read_to_string(folder.join("ball.xml")).expect("written").starts_with("<mujoco"));
}

#[test]
fn a_target_is_carried_home_and_the_plan_is_executed() {
    let folder = tempfile::tempdir().unwrap();
    let command = |arguments: &[&str]| {
        let mut command = Command::cargo_bin("cranny").expect("the program");
        command.current_dir(folder.path()).args(arguments).output().unwrap()
    };
    let planned = command(&["plan", "021", "--carry", "home"]);
    assert_eq!(planned.status.code(), Some(0), "{}", String::from_utf8_lossy(&planned.stderr));
    assert!(String::from_utf8_lossy(&planned.stdout).contains("carries"));
    assert_eq!(command(&["verify", "021", "021.plan.json"]).status.code(), Some(0));
    let (code, executed) = answer(folder.path(), &["plan", "021", "021.plan.json"]);
    assert_eq!((code, &executed["outcome"]), (0, &"held".into()), "{executed}");
    assert_eq!(executed["contacts"], serde_json::json!([]));
    assert!(executed["rose_m"].as_f64().unwrap() > 0.1, "{executed}");
    for (carry, said) in
        [("away", "not a valid destination"), ("1,2", "2 values, but the robot has 9 joints")]
    {
        let refused = command(&["plan", "021", "--carry", carry]);
        let words = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(refused.status.code() == Some(2) && words.contains(said), "{words}");
    }
    refused(folder.path(), &["plan", "021", "021.plan.json", "--lift=-5"], &["--lift", "'-5'"]);
}

/// Each pick starts from the final poses of the one before; in the recording each body appears once.
#[test]
fn steps_are_executed_one_after_the_other() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let command = |arguments: &[&str]| {
        let mut command = Command::cargo_bin("cranny").expect("the program");
        command.current_dir(folder).args(arguments).output().unwrap()
    };
    assert_eq!(command(&["plan", "235", "--steps"]).status.code(), Some(0));
    let (code, executed) =
        answer(folder, &["plan", "235", "235.plan.json", "--mass", "0.1", "--record", "steps.json"]);
    let steps = executed["steps"].as_array().unwrap();
    let is_there = |step: &serde_json::Value| {
        let placed = &step["placed"];
        let within = |key: &str, most: f64| placed[key].as_f64().is_some_and(|off| off <= most);
        let is_there = within("translation_m", 0.01) && within("rotation_rad", 0.1746);
        // A released object is no longer in the hand.
        if step["released"].is_object() {
            let outcome = if is_there { "placed" } else { "misplaced" };
            assert_eq!(step["outcome"], outcome, "{step}");
            assert!(!is_there || step["is_in_hand"] == false, "{step}");
            assert!(step["released"]["position_m"].is_array() && placed["is_there"] == is_there, "{step}");
        }
        step["outcome"] == "placed"
    };
    let as_planned = steps.len() == 3 && steps.iter().all(is_there);
    assert_eq!((code == 0, &executed["as_planned"]), (as_planned, &as_planned.into()), "{executed}");
    assert_eq!(steps[0]["object"], "column 1");
    assert!(steps.len() > 1, "the first is put down, if not where it was to be: {executed}");
    let recording = cranny_view::BodyRecording::read(&folder.join("steps.json")).unwrap();
    let named = |name: &str| recording.bodies.iter().filter(|body| body.name == name).collect::<Vec<_>>();
    let instants = recording.times_s.len();
    for name in ["column 1", "column 2", "panda_link7"] {
        let [body] = named(name)[..] else { panic!("{name}: {}", named(name).len()) };
        assert_eq!(body.world_from_body.len(), instants, "{name}");
    }
    let place = |index: usize| named("column 1")[0].world_from_body[index].translation.vector;
    assert!((place(instants - 1) - place(0)).norm() > 0.3, "it was taken elsewhere");
    // An object that was put down is still there when the next pick starts.
    let jumps = (1..instants).filter(|&index| (place(index) - place(index - 1)).norm() > 0.1).count();
    assert_eq!(jumps, 0);

    // Plans of other picks, or of a robot that does not continue where it stopped, are not executed.
    let plans: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folder.join("235.plan.json")).unwrap()).unwrap();
    let lie = |change: &dyn Fn(&mut serde_json::Value), words: &[&str]| {
        let mut lying = plans.clone();
        change(&mut lying);
        std::fs::write(folder.join("lie.plan.json"), lying.to_string()).unwrap();
        refused(folder, &["plan", "235", "lie.plan.json"], words);
    };
    lie(&|plan| plan["task"].as_array_mut().unwrap().swap(0, 3), &["not those of task 'steps'"]);
    lie(&|plan| plan["segments"][1]["stage"] = 4.into(), &["lie.plan.json", "segment 0"]);
    lie(&|plan| plan["format"] = "cranny-plan/9".into(), &["lie.plan.json", "cranny-plan/2"]);
    lie(&|plan| plan["task_name"] = "tidy".into(), &["no task 'tidy'", "'steps'"]);
    // The plan is shown in its own scenario, and refused in others.
    assert_eq!(command(&["render", "235", "235.plan.json", "-o", "235.html"]).status.code(), Some(0));
    for arguments in [
        ["render", "021", "235.plan.json", "-o", "021.html"],
        ["verify", "021", "235.plan.json", "--json", "-q"],
    ] {
        let output = command(&arguments);
        assert_ne!(output.status.code(), Some(0), "{arguments:?}");
    }
    let shown = command(&["render", "021", "235.plan.json", "-o", "021.html"]);
    let words = String::from_utf8_lossy(&shown.stderr).into_owned();
    assert!(words.contains("scenario '021' has no task 'steps'"), "{words}");
    assert_eq!(words.matches("the plan was made for scenario '235'").count(), 1, "{words}");
    let drawn = command(&["render", "021", "235.plan.json", "-o", "021.png", "--size", "32x24"]);
    assert_eq!(drawn.status.code(), Some(2), "a picture is of it or of nothing");
}
