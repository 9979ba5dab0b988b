//! Pictures from the command line.

use std::path::Path;
use std::process::Output;

use assert_cmd::Command;

fn run(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::cargo_bin("cranny").expect("the program");
    command.current_dir(folder).args(arguments).output().expect("it runs")
}

fn done(folder: &Path, arguments: &[&str]) -> serde_json::Value {
    let output = run(folder, &[arguments, &["--json"]].concat());
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {error}");
    serde_json::from_slice(&output.stdout).expect("one JSON document")
}

fn refused(folder: &Path, arguments: &[&str], words: &[&str]) {
    let before = std::fs::read_dir(folder).expect("a folder").count();
    let output = run(folder, arguments);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
    for word in words {
        assert!(error.contains(word), "no '{word}' in: {error}");
    }
    assert_eq!(error.matches("error:").count(), 1, "{error}");
    assert_eq!(std::fs::read_dir(folder).expect("a folder").count(), before, "something was written");
}

fn begins_with(file: &Path, magic: &[u8]) -> bool {
    std::fs::read(file).is_ok_and(|bytes| bytes.starts_with(magic))
}

const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";

#[test]
fn a_plan_becomes_what_the_ending_of_the_file_says() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    done(folder, &["plan", "021", "-o", "p.plan.json"]);
    let small = ["--size", "80x60", "--samples", "1"];
    let render = |file: &str, more: &[&str]| {
        let shown = done(folder, &[&["render", "021", "p.plan.json", "-o", file], more].concat());
        assert_eq!(shown["files"][0], file);
        shown
    };
    let picture =
        render("a.png", &[&small[..], &["--camera=-40,30", "--ghosts", "1", "--time", "1.5"]].concat());
    assert_eq!((picture["width"].as_u64(), picture["height"].as_u64()), (Some(80), Some(60)));
    render("views.png", &[&small[..], &["--view", "all"]].concat());
    let moving = render("a.gif", &[&small[..], &["--rate", "3"]].concat());
    let count = moving["pictures"].as_u64().expect("a number");
    assert!(count > 4, "{count}");
    // At equal steps of time, so that few pictures a second are in real time too.
    let plan = std::fs::read(folder.join("p.plan.json")).expect("a plan");
    let plan: serde_json::Value = serde_json::from_slice(&plan).expect("JSON");
    let duration_s = plan["timing"]["duration_s"].as_f64().expect("a number");
    assert!((count as f64 - (3.0 * duration_s).ceil() - 1.0).abs() < 0.5, "{count} in {duration_s} s");
    for (file, more) in
        [("b.glb", ["--view", "top"]), ("b.html", ["--size", "80x60"]), ("b.png", ["--rate", "3"])]
    {
        let words = [&["render", "021", "p.plan.json", "-o", file], &more[..]].concat();
        refused(folder, &words, &[more[0], "has no effect on"]);
    }
    assert_eq!(render("a.apng", &[&small[..], &["--rate", "3"]].concat())["pictures"], count);
    assert_eq!(render("frames/", &[&small[..], &["--rate", "3"]].concat())["pictures"], count);
    render("a.glb", &[]);
    for (file, magic) in
        [("a.png", PNG), ("views.png", PNG), ("a.gif", b"GIF89a"), ("a.apng", PNG), ("a.glb", b"glTF")]
    {
        assert!(begins_with(&folder.join(file), magic), "{file}");
    }
    assert_eq!(std::fs::read_dir(folder.join("frames")).expect("a folder").count() as u64, count);
    assert!(begins_with(&folder.join("frames/0000.png"), PNG));
}

#[test]
fn a_film_has_the_pictures_of_its_rate_and_speed() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    done(folder, &["plan", "021", "-o", "p.plan.json"]);
    let count = |file: &str, more: &[&str]| {
        let words =
            ["render", "021", "p.plan.json", "--size", "32x24", "--samples", "1", "--rate", "5", "-o", file];
        done(folder, &[&words[..], more].concat())["pictures"].as_u64().expect("a number")
    };
    let whole = count("a.gif", &[]);
    assert_eq!(count("b.apng", &["--speed", "1"]), whole);
    for (speed, file) in [("2", "c.gif"), ("0.5", "frames/"), ("4", "d.apng")] {
        let factor: f64 = speed.parse().expect("a number");
        let (expected, found) = ((whole - 1) as f64 / factor + 1.0, count(file, &["--speed", speed]) as f64);
        assert!((found - expected).abs() <= 2.0, "{found} pictures instead of {expected} at speed {speed}");
    }
    // Pictures of two films are not mixed.
    let shorter = ["render", "021", "p.plan.json", "--size", "32x24", "--rate", "1", "-o", "frames/"];
    refused(folder, &shorter, &["frames/", ".png", "exists already"]);
    done(folder, &["render", "021", "p.plan.json", "-o", "a.glb"]);
    done(folder, &["render", "021", "p.plan.json", "-o", "b.glb", "--speed", "0.25"]);
    let size = |file: &str| std::fs::metadata(folder.join(file)).expect("a file").len();
    assert!(size("b.glb") > size("a.glb"), "a slower animation has more samples");
    for speed in ["0", "-1", "0.009", "101", "nan", "inf", "fast"] {
        refused(
            folder,
            &["render", "021", "p.plan.json", "-o", "x.gif", "--speed", speed],
            &["--speed", speed, "0.01 to 100"],
        );
    }
    for file in ["x.png", "x.html"] {
        refused(folder, &["render", "021", "p.plan.json", "-o", file, "--speed", "2"], &["--speed", ".mp4"]);
    }
    refused(folder, &["render", "--all", "-o", "x.png", "--speed", "2"], &["--speed"]);
}

/// Writes a program `ffmpeg` to a folder of its own, and returns a `PATH` with it.
#[cfg(unix)]
fn path_with_ffmpeg(folder: &Path, script: &str) -> String {
    use std::os::unix::fs::PermissionsExt;

    let (bin, program) = (folder.join("bin"), folder.join("bin/ffmpeg"));
    std::fs::create_dir_all(&bin).expect("a folder");
    std::fs::write(&program, format!("#!/bin/sh\n{script}")).expect("written");
    std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).expect("a program");
    format!("{}:/usr/bin:/bin", bin.display())
}

#[cfg(unix)]
#[test]
fn a_film_goes_through_ffmpeg_picture_by_picture() {
    let folder = tempfile::tempdir().expect("a folder");
    let tools = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    done(folder, &["plan", "021", "-o", "p.plan.json"]);
    let render = |path: &str, words: &[&str]| {
        let mut command = Command::cargo_bin("cranny").expect("the program");
        command.current_dir(folder).env("PATH", path).args([
            "render",
            "021",
            "p.plan.json",
            "--samples",
            "1",
        ]);
        command.args(words).output().expect("it runs")
    };
    // It writes its input as it comes.
    let copies = "echo \"$*\" > \"$0.words\"; for last; do :; done; cat > \"${last#file:}\"\n";
    let path = path_with_ffmpeg(tools.path(), copies);
    let output = render(&path, &["-o", "a.mp4", "--size", "80x60", "--rate", "3", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let shown: serde_json::Value = serde_json::from_slice(&output.stdout).expect("one JSON document");
    let count = shown["pictures"].as_u64().expect("a number");
    assert!(count > 4 && shown["files"][0] == "a.mp4", "{shown}");
    let whole = std::fs::read(folder.join("a.mp4")).expect("a film");
    assert_eq!(whole.len() as u64, count * 80 * 60 * 3);
    let words = std::fs::read_to_string(tools.path().join("bin/ffmpeg.words")).expect("its arguments");
    for word in
        ["-framerate 3 ", "-video_size 80x60", "rgb24", "yuv420p", "libx264", "-threads 1", "+bitexact"]
    {
        assert!(words.contains(word), "no '{word}' in: {words}");
    }
    // It fails at once, or in the middle, or is missing.
    let fails = |script: &str, said: &str| {
        let output = render(&path_with_ffmpeg(tools.path(), script), &["-o", "b.mp4", "--size", "160x120"]);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(
            error.contains(&format!("b.mp4: ffmpeg failed: {said}\n")) && error.lines().count() == 1,
            "{error}"
        );
    };
    fails("echo \"[vost#0:0 @ 0x5] Unknown encoder 'libx264'\" >&2; exit 8\n", "Unknown encoder 'libx264'");
    fails("head -c 100000 > /dev/null; exit 7\n", "ended with exit code 7");
    fails("kill -9 $$\n", "ended by signal 9");
    let output = render(&tools.path().display().to_string(), &["-o", "b.mp4"]);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(error.contains("ffmpeg") && error.contains("PATH") && error.contains(".gif"), "{error}");
    let output = render(&path, &["-o", "b.mp4", "--size", "81x60"]);
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.code() == Some(2) && error.contains("--size") && error.contains("82x60"),
        "{error}"
    );
    // Nothing of the failures remains, and only a film is overwritten.
    let names = || {
        let entries = std::fs::read_dir(folder).expect("a folder");
        let mut names: Vec<_> = entries.map(|entry| entry.expect("an entry").file_name()).collect();
        names.sort();
        names
    };
    assert_eq!(names(), ["a.mp4", "p.plan.json"]);
    let output = render(&path, &["-o", "a.mp4", "--size", "80x60"]);
    assert_eq!(output.status.code(), Some(2), "pictures without a header are no film");
    assert!(std::fs::read(folder.join("a.mp4")).expect("a film") == whole);
}

#[test]
fn a_scenario_without_a_plan_and_bare_way_points_are_drawn_too() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let size = ["--size", "80x60"];
    done(folder, &[&["render", "041", "-o", "start.png"], &size[..]].concat());
    let start = "0,0,-0.0178,-0.7601,0.0198,-2.3421,0.0298,1.5412,0.7534\n";
    std::fs::write(folder.join("way.csv"), format!("{start}{}", start.replace("-2.3421", "-1.5")))
        .expect("written");
    done(folder, &[&["render", "041", "way.csv", "-o", "way.png"], &size[..]].concat());
    let read = |name: &str| std::fs::read(folder.join(name)).expect("a file");
    assert!(read("start.png") != read("way.png"));
    done(folder, &[&["render", "041", "-o", "again.png"], &size[..]].concat());
    assert!(read("start.png") == read("again.png"), "the same command, other bytes");
    done(folder, &["render", "041", "-o", "start.glb"]);
}

#[test]
fn all_scenarios_stand_on_one_sheet() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let shown = done(folder, &["render", "--all", "-o", "sheet.png", "--size", "48x36", "--samples", "1"]);
    assert_eq!((shown["width"].as_u64(), shown["height"].as_u64()), (Some(300), Some(332)));
    assert!(begins_with(&folder.join("sheet.png"), PNG));
}

/// A time beyond the end of the plan, or without a plan, must not be ignored.
#[test]
fn a_moment_that_is_not_there_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let planned = done(folder, &["plan", "021", "-o", "p.plan.json"]);
    let duration_s = planned["duration_s"].as_f64().expect("a duration");
    let small = ["--size", "80x60", "--samples", "1", "--time"];
    let moment = |arguments: &[&str], time: &str, words: &[&str]| {
        refused(folder, &[&["render"], arguments, &small[..], &[time]].concat(), words);
    };
    let last = format!("0 to {duration_s:.3}");
    moment(&["021", "-o", "a.png"], "4", &["--time", "021", "plan"]);
    moment(&["021", "p.plan.json", "-o", "a.png"], "99", &["--time", "99", &last]);
    moment(&["021", "p.plan.json", "-o", "a.png"], "inf", &["--time", &last]);
    moment(&["021", "p.plan.json", "-o", "a.png"], "NaN", &["--time"]);
    moment(&["021", "p.plan.json", "-o", "a.gif"], "1", &["--time", ".png"]);
    moment(&["021", "p.plan.json", "-o", "a.html"], "1", &["--time", ".png"]);
    moment(&["--all", "-o", "a.png"], "1", &["--time", "011", "plan"]);
    // The duration as `cranny plan` prints it.
    let printed = format!("{duration_s:.3}");
    done(folder, &[&["render", "021", "p.plan.json", "-o", "a.png"], &small[..], &[&printed]].concat());
}

#[test]
fn objects_have_pictures() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    done(folder, &["object", "show", "banana", "--picture", "banana.png"]);
    done(folder, &["object", "export", "tennis_ball", "-o", "ball"]);
    assert!(begins_with(&folder.join("banana.png"), PNG));
    assert!(begins_with(&folder.join("ball/thumbnail.png"), PNG));
    refused(folder, &["object", "show", "banana", "--picture", "no/such.png"], &["no/such.png"]);
}

#[test]
fn what_cannot_be_drawn_is_refused_and_nothing_is_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let render =
        |arguments: &[&str], words: &[&str]| refused(folder, &[&["render"], arguments].concat(), words);
    render(&["099", "-o", "a.png"], &["099", "021"]);
    render(&["021", "-o", "a.bmp"], &["--output", "a.bmp", ".png", ".mp4", ".glb"]);
    render(&["021", "-o", "a"], &["--output", "'a'"]);
    render(&["021", "-o", "no/such/a.png"], &["no/such"]);
    render(&["021", "-o", "."], &["plan"]);
    render(&["021", "-o", "a.gif"], &["plan"]);
    render(&["021", "gone.plan.json", "-o", "a.png"], &["gone.plan.json"]);
    render(&["021", "-o", "a.png", "--size", "10"], &["--size", "1280x960"]);
    for size in ["0x0", "15x100", "100x8193", "100000x100000", "99999999999999999999x10"] {
        render(&["021", "-o", "a.png", "--size", size], &["--size", size]);
    }
    render(&["021", "-o", "a.glb", "--size", "100000x100000"], &["16 to 8192"]);
    render(&["--all", "-o", "a.png", "--size", "8000x8000"], &["--size", "2048"]);
    for ghosts in ["100000000", "101", "-1"] {
        render(&["021", "-o", "a.png", "--ghosts", ghosts], &["ghosts"]);
    }
    render(&["021", "-o", "a.gif", "--rate", "100000000"], &["--rate", "1..=50"]);
    render(&["021", "-o", "a.png", "--camera", "up"], &["--camera"]);
    render(&["021", "-o", "a.png", "--camera", "0,91"], &["--camera"]);
    render(&["021", "-o", "a.png", "--time", "-1"], &["--time"]);
    render(&["021", "-o", "a.gif", "--rate", "0"], &["--rate"]);
    render(&["--all", "-o", "a.glb"], &["--all", ".png"]);
    render(&["--all", "nowhere", "-o", "a.png"], &["nowhere"]);
    render(&["-o", "a.png"], &["ID"]);
    std::fs::write(folder.join("short.csv"), "0,1,2\n").expect("written");
    render(&["021", "short.csv", "-o", "a.png"], &["short.csv"]);
    std::fs::create_dir(folder.join("taken.png")).expect("a folder");
    render(&["021", "taken.png", "-o", "a.png"], &["taken.png"]);
}
