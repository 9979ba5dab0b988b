//! Commands that are stopped by Ctrl-C: finished results stay, and the same command resumes from them. Others leave nothing.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use cranny_grasp::GraspSet;
use cranny_scenario::{OpenOptions, Scenario};

fn command(folder: &Path, arguments: &str) -> Command {
    let mut command = Command::new(assert_cmd::cargo::cargo_bin("cranny"));
    command.current_dir(folder).args(arguments.split(' ')).arg("--json");
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// Returns the output of a command stopped while it works; if stopped too early, it is empty, and the test waits longer.
fn stopped_after(seconds: f64, folder: &Path, arguments: &str) -> Output {
    let output = stopped_once(seconds, folder, arguments);
    if output.stdout.is_empty() { stopped_after(2.0 * seconds, folder, arguments) } else { output }
}

fn stopped_once(seconds: f64, folder: &Path, arguments: &str) -> Output {
    stop_after(seconds, &mut command(folder, arguments))
}

fn stop_after(seconds: f64, command: &mut Command) -> Output {
    let mut child = command.spawn().expect("it starts");
    // Its standard input must not end before it does: a command that reads from there would find an empty file.
    let _input = child.stdin.take();
    std::thread::sleep(Duration::from_secs_f64(seconds));
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill");
    assert!(sent.success());
    child.wait_with_output().expect("it ends")
}

fn document(output: &Output) -> serde_json::Value {
    serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|_| panic!("{}", String::from_utf8_lossy(&output.stderr)))
}

#[test]
fn a_simulation_of_grasps_goes_on_where_it_was_stopped() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let scenario = Scenario::open("021", &OpenOptions::default()).expect("a scenario");
    let grasps = GraspSet::new(scenario.grasps.grasps()[..8].to_vec()).expect("grasps");
    std::fs::write(folder.join("few.csv"), cranny_grasp::csv_text(&grasps)).expect("written");
    let simulate =
        |file: &str| format!("simulate grasps 021 --support-only --grasps few.csv --trials 3 -o {file}");
    let begin = std::time::Instant::now();
    let whole = command(folder, &simulate("whole.csv")).output().expect("it runs");
    // Measures the duration on this machine under its current load.
    let whole_s = begin.elapsed().as_secs_f64();
    let (mut known, mut was_stopped) = (0, false);
    let mut after_s = 0.45 * whole_s;
    loop {
        let output = stopped_after(after_s, folder, &simulate("scored.csv"));
        let found = document(&output);
        assert_eq!(found["known"], known, "{found}");
        // Other programs may have slowed the first run down, and not this one.
        if found["stopped"] == false && !was_stopped && after_s > 0.02 * whole_s {
            std::fs::remove_file(folder.join("scored.csv")).expect("removed");
            after_s *= 0.5;
            continue;
        }
        known = found["grasps"].as_u64().expect("a count");
        if found["stopped"] == false {
            break;
        }
        was_stopped = true;
        assert_eq!(output.status.code(), Some(1));
        assert!(!folder.join("scored.csv").exists());
        let kept = found["unfinished"].as_str().expect("a file").to_owned();
        assert!(kept.starts_with("scored.csv.unfinished-") && folder.join(&kept).exists());
        // Finished results belong to these settings only.
        let other = stopped_after(0.3 * whole_s, folder, &format!("{} --seed 1", simulate("scored.csv")));
        let other = document(&other);
        assert!(other["known"] == 0 && other["unfinished"] != kept.as_str(), "{other}");
        std::fs::remove_file(folder.join(other["unfinished"].as_str().expect("a file"))).expect("removed");
    }
    assert!(was_stopped, "it is stopped before half of its time");
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).expect("a file");
    assert_eq!(read("scored.csv"), read("whole.csv"));
    let names =
        std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").file_name());
    assert_eq!(names.count(), 3, "nothing is left that was unfinished");
    assert!(document(&whole)["unfinished"].is_null());
}

/// Kills a command after some time, as `kill -9` does.
fn killed_after(seconds: f64, folder: &Path, arguments: &str) {
    let mut child = command(folder, arguments).spawn().expect("it starts");
    std::thread::sleep(Duration::from_secs_f64(seconds));
    // It may have ended already.
    let _ = child.kill();
    child.wait().expect("it ends");
}

/// Returns all files below a folder with their content.
fn contents(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut all = BTreeMap::new();
    let mut open = vec![folder.to_owned()];
    while let Some(next) = open.pop() {
        for entry in std::fs::read_dir(&next).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                open.push(path);
            } else {
                let below = path.strip_prefix(folder).expect("below it").to_owned();
                all.insert(below, std::fs::read(&path).expect("a file"));
            }
        }
    }
    all
}

#[test]
fn a_set_of_scenarios_goes_on_after_it_was_killed_or_stopped() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let generate = |set: &str| format!("scenario generate --family gap --count 60 -o {set}");
    let begin = std::time::Instant::now();
    assert_eq!(document(&command(folder, &generate("whole")).output().expect("it runs"))["written"], 60);
    let whole_s = begin.elapsed().as_secs_f64();
    for share in [0.1, 0.3, 0.5, 0.6, 0.7, 0.8, 0.9] {
        killed_after(share * whole_s, folder, &generate("set"));
    }
    // It may have finished before the last of them.
    if !folder.join("set").exists() {
        let _ = stopped_once(0.8 * whole_s, folder, &generate("set"));
    }
    if !folder.join("set").exists() {
        assert_eq!(document(&command(folder, &generate("set")).output().expect("it runs"))["stopped"], false);
    }
    assert!(contents(&folder.join("set")) == contents(&folder.join("whole")));
    let names =
        std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").file_name());
    assert_eq!(names.count(), 2, "nothing is left that was unfinished");
}

#[test]
fn a_set_of_demonstrations_goes_on_after_it_was_killed_or_stopped() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    std::fs::write(
        folder.join("recipe.yaml"),
        "count: 1000\nfamilies: [gap]\nclutter: 0\nqueries_per_scene: 5\n",
    )
    .expect("written");
    let generate = |set: &str| format!("dataset generate recipe.yaml -o {set}");
    let begin = std::time::Instant::now();
    let whole = document(&command(folder, &generate("whole")).output().expect("it runs"));
    assert_eq!((&whole["rows"], &whole["complete"]), (&1000.into(), &true.into()));
    let whole_s = begin.elapsed().as_secs_f64();
    killed_after(0.8 * whole_s, folder, &generate("set"));
    let stopped = stopped_once(0.7 * whole_s, folder, &generate("set"));
    // It may have finished before.
    if !stopped.stdout.is_empty() && document(&stopped)["complete"] == false {
        assert_eq!(stopped.status.code(), Some(1));
    }
    killed_after(0.3 * whole_s, folder, &generate("set"));
    let rest = document(&command(folder, &generate("set")).output().expect("it runs"));
    let number = |key: &str| rest[key].as_u64().expect("a count");
    assert_eq!((&rest["complete"], number("known") + number("rows")), (&true.into(), 1000));
    assert!(contents(&folder.join("set")) == contents(&folder.join("whole")));
    let names =
        std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").file_name());
    assert_eq!(names.count(), 3, "nothing is left that was unfinished");
}

#[test]
fn a_sampling_goes_on_where_it_was_stopped_while_candidates_are_chosen_too() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let sample = |file: &str| format!("grasps sample banana --count 1500 --candidates 20000 -o {file}");
    let whole = command(folder, &sample("whole.csv")).output().expect("it runs");
    assert_eq!(document(&whole)["stopped"], false);
    let mut stops = 0;
    loop {
        let found = document(&stopped_after(0.4, folder, &sample("banana.csv")));
        if found["stopped"] == false {
            break;
        }
        stops += 1;
        let kept = found["unfinished"].as_str().expect("a file");
        assert!(folder.join(kept).exists() && !folder.join("banana.csv").exists());
        // The choice takes longer than the time before each stop.
        if found["candidates"] == 20_000 {
            let rest = command(folder, &sample("banana.csv")).output().expect("it runs");
            assert_eq!(document(&rest)["stopped"], false);
            break;
        }
    }
    assert!(stops > 0);
    let grasps = |file: &str| std::fs::read_to_string(folder.join(file)).expect("grasps");
    assert_eq!(grasps("banana.csv"), grasps("whole.csv"));
    let files = std::fs::read_dir(folder).expect("a folder").count();
    assert_eq!(files, 2, "nothing is left that was unfinished");
}

/// Returns a recording of a tile that rises for 400 s: each film of it takes minutes.
#[cfg(unix)]
fn long_recording() -> String {
    use cranny_shape::TriangleSoup;
    use cranny_spatial::{Point, Pose};
    use cranny_view::{BodyRecording, MovingBody};

    let surface = TriangleSoup {
        vertices: [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0]].map(Point::from).to_vec(),
        triangles: vec![[0, 1, 2]],
    };
    let times_s: Vec<f64> = (0..8000).map(|instant| f64::from(instant) / 20.0).collect();
    let world_from_body = times_s.iter().map(|time_s| Pose::translation(0.0, 0.0, 0.001 * time_s)).collect();
    let tile = MovingBody { name: "tile".to_owned(), surface, is_grasped: true, world_from_body };
    let recording =
        BodyRecording { name: "tile".to_owned(), times_s, bodies: vec![tile], ..Default::default() };
    recording.json().expect("finite")
}

#[cfg(unix)]
#[test]
fn a_command_without_results_to_keep_ends_with_1_and_leaves_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    std::fs::write(folder.join("run.json"), long_recording()).expect("written");
    std::os::unix::fs::symlink("/dev/stdin", folder.join("wait.plan.json")).expect("a link");
    let tools = tempfile::tempdir().expect("a folder");
    let ffmpeg = tools.path().join("ffmpeg");
    std::fs::write(&ffmpeg, "#!/bin/sh\nfor last; do :; done; cat > \"${last#file:}\"\n").expect("written");
    let runs = std::os::unix::fs::PermissionsExt::from_mode(0o755);
    std::fs::set_permissions(&ffmpeg, runs).expect("a program");
    let path = format!("{}:/usr/bin:/bin", tools.path().display());
    let names = || {
        let entries = std::fs::read_dir(folder).expect("a folder");
        let mut names: Vec<_> = entries.map(|entry| entry.expect("an entry").file_name()).collect();
        names.sort();
        names
    };
    let before = names();
    for arguments in [
        "render run.json -o run.gif --size 160x120",
        "render run.json -o run.mp4 --size 160x120",
        "render run.json -o frames/",
        // These read a pipe that does not end.
        "verify 021 wait.plan.json",
        "simulate plan 021 wait.plan.json",
        "render 021 wait.plan.json -o 021.png",
    ] {
        let output = stop_after(1.0, command(folder, arguments).env("PATH", &path));
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!((output.status.code(), &output.stdout[..]), (Some(1), &b""[..]), "{arguments}: {said}");
        assert!(said.contains("stopped"), "{arguments}: {said}");
        assert_eq!(names(), before, "{arguments}");
    }
}

#[cfg(unix)]
#[test]
fn nohup_protects_a_command_from_the_end_of_its_terminal_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let program = assert_cmd::cargo::cargo_bin("cranny");
    std::os::unix::fs::symlink("/dev/stdin", folder.path().join("wait.plan.json")).expect("a link");
    let mut shell = Command::new("sh");
    shell.args(["-c", "trap '' HUP; exec \"$0\" verify 021 wait.plan.json"]).arg(program);
    shell.current_dir(folder.path()).stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::null());
    let mut child = shell.spawn().expect("it starts");
    let mut status_after = |signal: &str| {
        std::thread::sleep(Duration::from_secs(1));
        let id = child.id().to_string();
        assert!(Command::new("kill").args([signal, &id]).status().expect("kill").success());
        std::thread::sleep(Duration::from_millis(500));
        child.try_wait().expect("a status").map(|status| status.code())
    };
    assert_eq!(status_after("-HUP"), None, "it continues");
    assert_eq!(status_after("-TERM"), Some(Some(1)));
}
