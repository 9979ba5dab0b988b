//! Output files: no file of another kind is overwritten unless forced, no partial file is written, and failures leave none.

use std::collections::BTreeMap;
use std::os::unix::fs::FileTypeExt as _;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

/// Runs `words`, separated by spaces.
fn cranny(folder: &Path, words: &str) -> Output {
    let program = assert_cmd::cargo::cargo_bin("cranny");
    Command::new(program).current_dir(folder).args(words.split(' ')).output().expect("it runs")
}

fn error(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn done(folder: &Path, words: &str) {
    let output = cranny(folder, words);
    assert_eq!(output.status.code(), Some(0), "{words}: {}", error(&output));
}

/// Creates a mesh, a scenario, results and a plan as inputs of other commands.
fn workshop() -> tempfile::TempDir {
    let folder = folder();
    let path = folder.path();
    let tetrahedron = "v 0 0 0\nv 0.05 0 0\nv 0 0.05 0\nv 0 0 0.05\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    std::fs::write(path.join("mesh.obj"), tetrahedron).expect("written");
    done(path, "scenario new mine");
    done(path, "scenario export 021 -o released");
    done(path, "plan 021 -o reach.plan.json");
    done(path, "bench run --scenarios 021 --planners reach --runs 2 -o trials.db");
    folder
}

/// Returns every file below a folder with its content; folders have none.
fn everything(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            found.extend(everything(&path));
        }
        found.insert(path.display().to_string(), std::fs::read(&path).unwrap_or_default());
    }
    found
}

/// Text notes take the names of all output files. A kind that is not recognised by its first bytes would fail as well: the same
/// command could not be run twice.
#[test]
fn a_file_of_another_kind_is_written_over_only_when_forced_and_one_of_the_same_kind_always() {
    const NOTES: &str = "notes on grasping, which nobody has a copy of\n";
    let folder = workshop();
    let path = folder.path();
    let writers = [
        ("plan 021", "021.plan.json"),
        ("plan 021 -o a.json", "a.json"),
        ("plan 021 --rate 10 -o b.plan.json", "b.trajectory.csv"),
        ("grasps sample banana --count 5", "grasps.csv"),
        ("grasps sample banana --count 5 -o c.csv", "c.csv"),
        ("grasps filter 021 -o d.csv", "d.csv"),
        ("simulate grasps 021 --support-only --grasp 3 --trials 1 -o l.csv", "l.csv"),
        ("simulate grasps 021 --support-only --grasp 3 --record m.json", "m.json"),
        ("object show tennis_ball --picture e.png", "e.png"),
        ("render 021 --size 16x16 --samples 1 -o f.png", "f.png"),
        ("render 021 reach.plan.json --size 16x16 --samples 1 --rate 1 -o g.gif", "g.gif"),
        ("render 021 reach.plan.json --size 16x16 --samples 1 --rate 1 -o frames/", "frames/0000.png"),
        ("render 021 -o h.glb", "h.glb"),
        ("scenario pack mine", "mine.zip"),
        ("bench report trials.db", "trials.html"),
        ("bench report trials.db -o i.json", "i.json"),
        ("bench report trials.db -o i.tex", "i.tex"),
        ("bench report trials.db -o i.md", "i.md"),
        ("bench report trials.db -o i.csv", "i.csv"),
        ("bench report trials.db --plots plots", "plots/021_reach_exact.svg"),
        ("bench export trials.db -o j.log", "j.log"),
        ("bench export trials.db -o logs/", "logs/021_exact.log"),
        ("bench replay trials.db 1 -o k.csv", "k.csv"),
    ];
    for (words, file) in writers {
        let file = path.join(file);
        // The command chooses the names of files in a folder.
        let file = if let Some(inside) = file.parent().filter(|inside| *inside != path) {
            done(path, words);
            let names = std::fs::read_dir(inside).expect("a folder").map(|entry| entry.expect("one").path());
            let mut names: Vec<_> = names.collect();
            names.sort();
            names.remove(0)
        } else {
            file
        };
        std::fs::write(&file, NOTES).expect("written");
        let before = everything(path);
        let refused = cranny(path, words);
        let said = error(&refused);
        assert_eq!(refused.status.code(), Some(2), "{words}: {said}");
        assert!(said.contains("exists already and is no ") && said.contains("--force"), "{words}: {said}");
        assert_eq!(said.lines().count(), 1, "{words}: {said}");
        assert!(everything(path) == before, "{words}: something was written");
        done(path, &format!("{words} --force"));
        assert_ne!(std::fs::read_to_string(&file).ok().as_deref(), Some(NOTES), "{words}");
        done(path, words);
    }
    // An empty file, as `mktemp` makes it, may be overwritten.
    std::fs::write(path.join("empty.csv"), "").expect("written");
    done(path, "grasps sample banana --count 5 -o empty.csv");
}

#[test]
fn results_folders_and_devices_are_not_written_over_even_when_forced() {
    let folder = workshop();
    let path = folder.path();
    std::fs::write(path.join("notes.db"), "notes").expect("written");
    std::fs::create_dir(path.join("plan.json")).expect("a folder");
    let before = everything(path);
    for (words, word) in [
        ("bench run --scenarios 021 --planners reach --runs 1 --force -o notes.db", "not a results file"),
        ("bench merge trials.db trials.db --force -o notes.db", "not a results file"),
        ("bench report trials.db --force -o trials.db", "it is a database"),
        ("grasps filter 021 --force -o trials.db", "it is a database"),
        ("plan 021 --force -o trials.db", "it is a database"),
        ("plan 021 --force -o plan.json", "directory"),
        ("plan 021 --force -o /dev/null", "device"),
        ("bench run --scenarios 021 --planners reach --runs 1 -o /dev/null", "device"),
        ("render 021 --force -o no/such/folder.png", "folder does not exist"),
        ("scenario new mine --force", "exists already"),
        ("scenario new mesh.obj --force", "exists already"),
        ("scenario import released --force -o mine", "exists already"),
        ("scenario export 021 --force -o mine", "exists already"),
        ("scenario generate --family gap --count 1 --force -o mine", "exists already"),
        ("scenario sweep gap --from 0.6 --to 0.5 --steps 2 --force -o mine", "exists already"),
        ("object export banana --force -o mine", "exists already"),
        ("object add mesh.obj --mass 0.1 --force -o mine", "exists already"),
    ] {
        let output = cranny(path, words);
        let said = error(&output);
        assert_eq!(output.status.code(), Some(2), "{words}: {said}");
        assert!(said.contains(word), "{words}: no '{word}' in {said}");
        assert!(everything(path) == before, "{words}: something was written");
    }
    assert!(std::fs::metadata("/dev/null").expect("a device").file_type().is_char_device());
}

/// With a file size limit of zero, as on a full disk, files can be created but not written; commands must not leave
/// `x.png.part`, an empty `z.zip` or an incomplete folder.
#[test]
fn where_nothing_can_be_written_nothing_stays() {
    let folder = workshop();
    let path = folder.path();
    let temporary = path.join("temporary");
    std::fs::create_dir(&temporary).expect("a folder");
    let before = everything(path);
    for words in [
        "plan 021 -o a.plan.json",
        "plan 021 --rate 10 -o a.plan.json",
        "grasps sample banana --count 5 -o b.csv",
        "grasps filter 021 -o b.csv",
        "object show tennis_ball --picture c.png",
        "object export banana",
        "object export banana -o new/folders/banana",
        "object add mesh.obj --mass 0.1 --parts 1 --resolution 8",
        "render 021 --size 16x16 --samples 1 -o d.png",
        "render 021 -o d.glb",
        "render 021 reach.plan.json --size 16x16 --samples 1 --rate 1 -o d.gif",
        "render 021 reach.plan.json --size 16x16 --samples 1 --rate 1 -o frames/",
        "scenario new yours",
        "scenario import released -o yours",
        "scenario export 021 -o yours",
        "scenario pack mine -o e.zip",
        "scenario generate --family gap --count 2 -o set",
        "scenario sweep gap --from 0.6 --to 0.5 --steps 2 -o set",
        "bench run --scenarios 021 --planners reach --runs 1 -o f.db",
        "bench merge trials.db trials.db -o f.db",
        "bench report trials.db -o g.html",
        "bench report trials.db -o g.json --plots plots",
        "bench export trials.db -o h.log",
        "bench export trials.db -o logs/",
        "bench replay trials.db 1 -o i.csv",
    ] {
        let program = assert_cmd::cargo::cargo_bin("cranny");
        let output = Command::new("bash")
            .args(["-c", "trap '' XFSZ; ulimit -f 0; exec \"$@\"", "bash"])
            .arg(program)
            .args(words.split(' '))
            .env("TMPDIR", &temporary)
            .current_dir(path)
            .output()
            .expect("bash");
        let said = error(&output);
        assert_eq!(output.status.code(), Some(2), "{words}: {said}");
        assert!(said.contains("error: ") && !said.contains("panicked"), "{words}: {said}");
        let after = everything(path);
        let new: Vec<&String> = after.keys().filter(|name| !before.contains_key(*name)).collect();
        // SQLite creates these two beside results that are read; the next writer removes them.
        let new: Vec<_> =
            new.iter().filter(|name| !name.ends_with("-wal") && !name.ends_with("-shm")).collect();
        assert!(new.is_empty(), "{words}: {new:?} stayed: {said}");
    }
}

/// Runs a command, interrupts it with Ctrl-C, and returns its output of `--json`.
fn interrupted(folder: &Path, words: &str) -> serde_json::Value {
    let program = assert_cmd::cargo::cargo_bin("cranny");
    // On a busy machine it may not have started yet, and then ends at once without results.
    for seconds in [1, 4, 16, 64] {
        let child = Command::new(&program)
            .current_dir(folder)
            .args(words.split(' '))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("it runs");
        std::thread::sleep(Duration::from_secs(seconds));
        let id = child.id().to_string();
        assert!(
            Command::new("kill").args(["-INT", &id]).status().expect("kill").success(),
            "{words} had ended"
        );
        let output = child.wait_with_output().expect("it ends");
        if let Some(code) = output.status.code() {
            assert_eq!(code, 1, "{words}: {}", error(&output));
            return serde_json::from_slice(&output.stdout).expect("JSON");
        }
    }
    panic!("{words}: it never began");
}

#[test]
fn what_ctrl_c_ended_is_not_written_as_if_it_were_whole() {
    let folder = folder();
    let path = folder.path();
    // Sampling this many approaches does not end within the test.
    let said = interrupted(path, "grasps sample 012 --count 100000 --approaches 3600 --json");
    assert!(said["stopped"] == true && said["file"].is_null() && !path.join("grasps.csv").exists(), "{said}");
    assert!(path.join(said["unfinished"].as_str().expect("a file")).exists());

    let said = interrupted(path, "ik 025 --attempts 1000000000 --solutions 1000 --json");
    assert_eq!(said["stopped"], true);

    let said = interrupted(path, "scenario generate --family gap --count 1000000 --json");
    assert_eq!(said["stopped"], true);
    // The written scenarios are complete, and the list names exactly these.
    assert!(!path.join("gap-0").exists());
    let written = said["written"].as_u64().expect("a number");
    let unfinished = path.join(said["unfinished"].as_str().expect("a folder"));
    let list = std::fs::read_to_string(unfinished.join("unfinished.jsonl")).expect("a list");
    assert_eq!(list.lines().count() as u64, written + 1);
    assert_eq!(std::fs::read_dir(unfinished.join("set")).expect("a folder").count() as u64, written);
    let names: Vec<_> = everything(path).into_keys().filter(|name| name.contains("partial")).collect();
    assert_eq!(names, Vec::<String>::new());
}
