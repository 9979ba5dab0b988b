//! Objects and grasps from the command line.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Output;

use assert_cmd::Command;

fn run(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::cargo_bin("cranny").expect("the program");
    command.current_dir(folder).args(arguments).output().expect("it runs")
}

/// Runs a command that must succeed and returns its output.
fn done(folder: &Path, arguments: &[&str]) -> String {
    let output = run(folder, arguments);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {error}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn json(folder: &Path, arguments: &[&str]) -> serde_json::Value {
    let arguments = [arguments, &["--json"]].concat();
    serde_json::from_str(&done(folder, &arguments)).expect("one JSON document")
}

/// Checks that bad input gives a message with all these words.
fn refused(folder: &Path, arguments: &[&str], words: &[&str]) {
    let output = run(folder, arguments);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
    for word in words {
        assert!(error.contains(word), "no '{word}' in: {error}");
    }
}

/// Writes a box of 40 × 60 × 100 units as an OBJ file, without its last faces.
fn write_box(folder: &Path, name: &str, left_out: usize) {
    let mut text = String::new();
    for (x, y, z) in (0..8).map(|i| (i & 1, i >> 1 & 1, i >> 2)) {
        let _ = writeln!(text, "v {} {} {}", x * 40, y * 60, z * 100);
    }
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    for [a, b, c, d] in &quads[..6 - left_out] {
        let _ = writeln!(text, "f {} {} {}\nf {} {} {}", a + 1, b + 1, c + 1, a + 1, c + 1, d + 1);
    }
    std::fs::write(folder.join(name), text).expect("written");
}

#[test]
fn an_object_is_made_of_a_mesh_and_grasped() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_box(folder, "box.obj", 0);
    let added = json(folder, &["object", "add", "box.obj", "--mass", "0.4", "--scale", "0.001"]);
    assert!((added["volume_m3"].as_f64().expect("a volume") - 0.00024).abs() < 1e-9);
    // A box has six sides, of which opposite ones are equivalent.
    assert_eq!(added["stable_poses"].as_array().expect("poses").len(), 3);
    assert_eq!(added["convex_parts"], 1);
    let shown = json(folder, &["object", "show", "box"]);
    assert_eq!(shown["stable_poses"], added["stable_poses"]);

    let sampled = json(folder, &["grasps", "sample", "box", "--pose", "0", "-o", "box.csv", "--count", "50"]);
    assert_eq!((sampled["grasps"].as_u64(), sampled["candidates"].as_u64()), (Some(50), Some(500)));
    let set = cranny_grasp::read_csv(&folder.join("box.csv")).expect("grasps");
    assert!(set.grasps().iter().all(|g| g.score.is_some() && g.width_m.is_some_and(|w| w <= 0.08)));

    let whole = json(folder, &["grasps", "coverage", "box.csv", "box.csv"]);
    assert!((whole["coverage"].as_f64().expect("a share") - 1.0).abs() < 1e-12);
    let spread = json(folder, &["grasps", "distances", "box.csv"]);
    assert!(spread["least"].as_f64().expect("a distance") > 0.0);
}

#[test]
fn the_same_seed_gives_the_same_file_on_any_number_of_threads() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |threads: &str, seed: &str, choose: &str| {
        let mut command = Command::cargo_bin("cranny").expect("the program");
        let name = format!("{threads}-{seed}-{choose}.csv");
        let arguments = ["grasps", "sample", "banana", "--seed", seed, "--choose", choose, "-o", &name];
        let output = command.current_dir(&folder).args(arguments).env("RAYON_NUM_THREADS", threads).output();
        assert_eq!(output.expect("it runs").status.code(), Some(0));
        std::fs::read(folder.path().join(name)).expect("a file")
    };
    for choose in ["covering", "farthest", "random"] {
        assert!(file("1", "3", choose) == file("4", "3", choose), "{choose}");
    }
    assert!(file("1", "3", "covering") != file("1", "4", "covering"));
}

#[test]
fn grasps_of_a_scenario_are_filtered_by_the_hand() {
    let folder = tempfile::tempdir().expect("a folder");
    let filtered = json(folder.path(), &["grasps", "filter", "021", "--approach", "300", "-o", "free.csv"]);
    let free = filtered["free"].as_u64().expect("a number");
    assert!(free > 10 && free < 200, "{filtered}");
    let again =
        json(folder.path(), &["grasps", "filter", "021", "--approach", "300", "--grasps", "free.csv"]);
    assert_eq!((again["grasps"].as_u64(), again["free"].as_u64()), (Some(free), Some(free)));
}

#[test]
fn grasps_are_sampled_for_the_target_of_a_scenario() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let sampled = json(folder, &["grasps", "sample", "021", "-o", "ball.csv", "--count", "40"]);
    assert_eq!(sampled["grasps"].as_u64(), Some(40), "{sampled}");
    // They are at the ball's pose in the scenario, and the hand can reach all of them there.
    let filtered = json(folder, &["grasps", "filter", "021", "--grasps", "ball.csv"]);
    assert_eq!(filtered["free"].as_u64(), Some(40), "{filtered}");
    refused(folder, &["grasps", "sample", "021", "--pose", "0"], &["--pose", "scenario"]);
    // A scenario with another robot, whose files are packed too; without its robot.yaml the opening of its gripper is unknown.
    let urdf = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/file_readers/sound/robot/arm.urdf");
    done(folder, &["scenario", "new", "cell", "--robot", urdf, "--tip", "hand"]);
    done(folder, &["scenario", "pack", "cell"]);
    assert_eq!(json(folder, &["info", "cell.zip"])["robot"], json(folder, &["info", "cell"])["robot"]);
    std::fs::remove_file(folder.join("cell/robot/robot.yaml")).expect("it came along");
    refused(folder, &["grasps", "sample", "cell"], &["--gripper", "arm", "robot.yaml"]);
}

#[test]
fn an_object_is_never_written_over_another() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    done(folder, &["object", "export", "banana", "-o", "fruit"]);
    write_box(folder, "box.obj", 0);
    let again = ["object", "add", "box.obj", "--mass", "1", "--scale", "0.001", "-o", "fruit"];
    refused(folder, &again, &["fruit", "exists already"]);
    refused(folder, &["object", "export", "sugar_box", "-o", "fruit"], &["fruit", "exists already"]);
    assert_eq!(json(folder, &["object", "show", "fruit"])["object"], "banana");
}

#[test]
fn what_is_wrong_with_a_scenario_is_said_with_its_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    done(folder, &["scenario", "new", "mine"]);
    let path = folder.join("mine/scenario.yaml");
    let sound = std::fs::read_to_string(&path).expect("a text");
    let checked = |from: &str, to: &str| {
        assert!(sound.contains(from), "{from}");
        std::fs::write(&path, sound.replace(from, to)).expect("written");
        let output = run(folder, &["scenario", "check", "mine"]);
        assert_eq!(output.status.code(), Some(1));
        String::from_utf8(output.stdout).expect("text")
    };
    let said = checked("robot: panda_mobile", "robot: panda");
    assert!(said.contains("scenario.yaml:") && said.contains("neither built in (panda_mobile, "), "{said}");
    let said = checked("cylinder: {radius: 0.03, length: 0.12}", "object: sugar_bix");
    assert!(said.contains("scenario.yaml:") && said.contains("'sugar_bix' (there are:"), "{said}");
    // Errors of the scenario itself are not attributed to the surrounding files.
    refused(folder, &["scenario", "pack", "mine"], &["mine/scenario.yaml:", "sugar_bix"]);
    refused(folder, &["scenario", "pack", "nowhere"], &["nowhere", "holds neither"]);
}

#[test]
fn a_gripper_is_data() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let gripper = |opening: &str| {
        format!(
            "name: narrow\nopening_m: {opening}\nfinger_width_m: 0.01\nfinger_thickness_m: 0.01\n\
             finger_length_m: 0.04\ntip_ahead_m: 0.005\npalm_size_m: [0.05, 0.1, 0.05]\n"
        )
    };
    std::fs::write(folder.join("narrow.yaml"), gripper("0.03")).expect("written");
    done(folder, &["grasps", "sample", "flat_screwdriver", "--gripper", "narrow.yaml", "--count", "20"]);
    let set = cranny_grasp::read_csv(&folder.join("grasps.csv")).expect("grasps");
    assert!(set.grasps().iter().all(|grasp| grasp.width_m.is_some_and(|width| width <= 0.03)));
    // The ball is 65 mm wide, so there is no grasp.
    let none =
        run(folder, &["grasps", "sample", "tennis_ball", "--gripper", "narrow.yaml", "-o", "none.csv"]);
    assert_eq!(none.status.code(), Some(1));
    assert!(!folder.join("none.csv").exists());
    std::fs::write(folder.join("bad.yaml"), gripper("-0.03")).expect("written");
    refused(folder, &["grasps", "sample", "banana", "--gripper", "bad.yaml"], &["bad.yaml", "opening"]);
    std::fs::write(folder.join("bad.yaml"), "name: [").expect("written");
    refused(folder, &["grasps", "sample", "banana", "--gripper", "bad.yaml"], &["bad.yaml:"]);
}

#[test]
fn bad_meshes_and_flags_are_refused_with_a_hint() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_box(folder, "box.obj", 0);
    write_box(folder, "open.obj", 1);
    std::fs::write(folder.join("broken.stl"), "solid").expect("written");
    let add = |mesh: &str, more: &[&str], words: &[&str]| {
        refused(folder, &[&["object", "add", mesh, "--mass", "0.4"], more].concat(), words);
    };
    add("box.obj", &[], &["box.obj", "100.000 m long", "millimetres", "--scale 0.001"]);
    add("open.obj", &["--scale", "0.001"], &["open.obj", "hole", "4"]);
    add("nowhere.obj", &[], &["nowhere.obj"]);
    add("broken.stl", &[], &["broken.stl"]);
    add("box.obj", &["--scale", "0.001", "--friction", "-1"], &["friction", "-1"]);
    add("box.obj", &["--scale", "nan"], &["--scale", "positive"]);
    add("box.obj", &["--scale", "0"], &["--scale", "positive"]);
    refused(folder, &["object", "add", "box.obj", "--mass", "0", "--scale", "0.001"], &["mass"]);
    refused(folder, &["object", "show", "anvil"], &["anvil", "banana"]);
    refused(folder, &["grasps", "sample", "anvil"], &["anvil", "banana"]);
    refused(folder, &["grasps", "sample", "banana", "--pose", "99"], &["--pose", "stable poses"]);
    refused(folder, &["grasps", "sample", "box.obj", "--pose", "0"], &["--pose", "object add"]);
    refused(folder, &["grasps", "sample", "banana", "--friction", "0"], &["friction"]);
    refused(folder, &["grasps", "sample", "banana", "--depth", "5", "-5"], &["depth"]);
    refused(folder, &["grasps", "sample", "banana", "--approach", "-5"], &["approach"]);
    refused(folder, &["grasps", "coverage", "nowhere.csv", "box.csv"], &["nowhere.csv"]);
    assert!(!folder.join("box").exists() && !folder.join("grasps.csv").exists(), "nothing is written");
}
