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
    render(&["021", "-o", "a.bmp"], &["--output", "a.bmp", ".png", ".glb"]);
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
