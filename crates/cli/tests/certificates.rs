//! Certificates of the built-in scenarios are accepted by both checkers, and plans that are false have none.

use std::path::{Path, PathBuf};

use assert_cmd::Command;

#[path = "../../../checker/src/lib.rs"]
#[allow(
    clippy::all,
    clippy::pedantic,
    dead_code,
    missing_docs,
    reason = "a program of its own, with its own tests"
)]
pub mod checker;

use checker::{check, sha256};

/// Runs the program in a folder and returns the exit code, and what it printed on standard output and on standard error.
pub fn cranny(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::cargo_bin("cranny").expect("the program");
    let output = command.current_dir(folder).args(arguments).output().expect("it runs");
    let text = [output.stdout, output.stderr].concat();
    (output.status.code(), String::from_utf8_lossy(&text).into_owned())
}

/// Returns a certificate with repeated lines in their place.
pub fn unfolded(text: &str) -> String {
    let lines: Vec<&str> = text.split_inclusive('\n').collect();
    let in_place = |line: &&str| match line.strip_prefix("= ") {
        None => (*line).to_owned(),
        Some(words) => {
            let numbers: Vec<usize> =
                words.split_whitespace().map(|word| word.parse().expect("a number")).collect();
            lines[numbers[0] - 1..numbers[0] - 1 + numbers[1]].concat()
        }
    };
    lines.iter().map(in_place).collect()
}

/// Plans on a built-in scenario and returns the certificate, with repeated lines in their place.
pub fn certificate(folder: &Path, scenario: &str, flags: &[&str]) -> String {
    let arguments = [&["plan", scenario, "-o", "it.plan.json", "--certificate", "it.cert"], flags].concat();
    let (code, printed) = cranny(folder, &arguments);
    assert_eq!(code, Some(0), "{scenario}: {printed}");
    unfolded(&std::fs::read_to_string(folder.join("it.cert")).expect("a certificate"))
}

fn scenarios() -> Vec<String> {
    (1..=4).flat_map(|family| (1..=5).map(move |step| format!("0{family}{step}"))).collect()
}

fn python_agrees(folder: &Path, text: &str, is_certified: bool) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../checker/check.py");
    let file = folder.join("python.cert");
    std::fs::write(&file, text).expect("written");
    match std::process::Command::new("python3").args([&script, &file]).output() {
        Ok(output) => {
            let printed = String::from_utf8_lossy(&output.stdout);
            let found = output.status.success() && printed.starts_with("certified\n");
            assert_eq!(found, is_certified, "{printed}{}", String::from_utf8_lossy(&output.stderr));
        }
        Err(_) => eprintln!("SKIPPED: the checker in Python (no python3)"),
    }
}

/// Both checkers accept the certificate of each scenario, with way points and rounded corners.
#[test]
fn certificates_of_the_twenty_scenarios_are_accepted() {
    let folder = tempfile::tempdir().expect("a folder");
    for scenario in scenarios() {
        for flags in [&[][..], &["--stop-at-corners"]] {
            let text = certificate(folder.path(), &scenario, flags);
            let found = check(&text).unwrap_or_else(|fault| panic!("{scenario} {flags:?}: {fault:?}"));
            let written = std::fs::read_to_string(folder.path().join("it.cert")).expect("a certificate");
            assert!(written.len() <= text.len() && check(&written).as_ref() == Ok(&found), "{scenario}");
            assert!(found[0].starts_with(&format!("scene {scenario} ")), "{found:?}");
            let pairs = text.lines().filter(|line| line.starts_with("p ")).count();
            assert!(pairs > 50 && found[2].ends_with("at least 0.00001 m apart but for `keep`"), "{found:?}");
            if scenario.ends_with('1') && flags.is_empty() {
                python_agrees(folder.path(), &text, true);
            }
        }
    }
}

/// `certify` writes what `plan --certificate` does, and a margin is certified.
#[test]
fn a_margin_is_certified() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = certificate(folder.path(), "021", &["--margin", "3"]);
    let (code, printed) = cranny(folder.path(), &["certify", "021", "it.plan.json", "-o", "again.cert"]);
    assert_eq!(code, Some(0), "{printed}");
    let again = std::fs::read_to_string(folder.path().join("again.cert")).expect("a file");
    assert_eq!(unfolded(&again), text);
    assert!(check(&text).is_ok_and(|found| found[2].ends_with("at least 0.003 m apart but for `keep`")));
}

/// Returns a certificate with another line in its scene, and the hash of that scene.
pub fn with_scene_line(text: &str, begin: &str, line: &str) -> String {
    let old = text.lines().find(|known| known.starts_with(begin)).expect("such a line");
    let changed = text.replacen(old, line, 1);
    let (format, scene) = changed.split_once('\n').expect("a format");
    let (scene, rest) = scene.split_once("hash ").expect("a hash");
    let (_, paths) = rest.split_once('\n').expect("paths");
    format!("{format}\n{scene}hash {}\n{paths}", sha256(scene.as_bytes()))
}

/// Writes a gap between two walls, of this width, and a box 0.55 m farther behind it than in the paper.
fn deep_gap(folder: &Path, width_m: f64) -> PathBuf {
    let (first, last) = (width_m.to_string(), (width_m - 0.01).to_string());
    let set = format!("gaps-{first}");
    let sweep =
        ["scenario", "sweep", "gap", "--from", &first, "--to", &last, "--steps", "2", "-o", &set, "-q"];
    let (code, printed) = cranny(folder, &sweep);
    assert_eq!(code, Some(0), "{printed}");
    let scene = folder.join(&set).join(format!("gap-{width_m:.4}"));
    let file = scene.join("scenario.yaml");
    let text = std::fs::read_to_string(&file).expect("a scenario");
    let (before, target) = text.split_once("target:").expect("a target");
    let (head, rest) = target.split_once("position: [").expect("a position");
    let (position, rest) = rest.split_once(']').expect("three numbers");
    let deeper = |text: &str| text.trim().parse::<f64>().expect("a number") + 0.55;
    let at: Vec<&str> = position.split(',').collect();
    let moved = format!("{before}target:{head}position: [{}, {}, {}]{rest}", at[0], deeper(at[1]), at[2]);
    std::fs::write(&file, moved).expect("written");
    let grasps = scene.join("grasps.csv");
    let text = std::fs::read_to_string(&grasps).expect("grasps");
    let row = |(number, line): (usize, &str)| {
        let mut words: Vec<String> = line.split(',').map(str::to_owned).collect();
        if number > 0 {
            words[3] = deeper(&words[3]).to_string();
        }
        words.join(",") + "\n"
    };
    std::fs::write(&grasps, text.lines().enumerate().map(row).collect::<String>()).expect("written");
    scene
}

/// Both checkers accept that no motion exists if the base cannot pass; if it can, there is no such certificate.
#[test]
fn that_no_motion_exists_is_certified() {
    let folder = tempfile::tempdir().expect("a folder");
    let narrow = deep_gap(folder.path(), 0.398);
    let (code, printed) = cranny(folder.path(), &["certify", &narrow.to_string_lossy(), "-o", "no.cert"]);
    assert!(code == Some(0) && printed.starts_with("certificate of no motion: no.cert"), "{printed}");
    let text = std::fs::read_to_string(folder.path().join("no.cert")).expect("a certificate");
    let found = check(&text).expect("it holds");
    assert!(found[1].starts_with("no motion leads to a goal"), "{found:?}");
    python_agrees(folder.path(), &text, true);
    // Nothing is excluded; and a narrower base.
    let boxes = text.lines().find(|line| line.starts_with("boxes ")).expect("boxes");
    let is_excluded = |mark: &&str| mark.contains(',');
    let open: Vec<&str> = boxes.split(' ').map(|mark| if is_excluded(&mark) { "." } else { mark }).collect();
    let open = open.join(" ");
    for wrong in [
        text.replacen(boxes, &open, 1),
        with_scene_line(&text, "box 0 0 0 1 0 0 0 .2 .2 .01", "box 0 0 0 1 0 0 0 .19 .19 .01"),
    ] {
        assert!(check(&wrong).is_err());
        python_agrees(folder.path(), &wrong, false);
    }
    let file = narrow.to_string_lossy();
    let plan = ["plan", &file, "--time-limit", "0.2", "-o", "no.plan.json", "--certificate", "again.cert"];
    assert_eq!(cranny(folder.path(), &plan).0, Some(1));
    assert_eq!(std::fs::read_to_string(folder.path().join("again.cert")).expect("a file"), text);
    let (code, printed) = cranny(folder.path(), &["certify", &file, "no.plan.json", "-o", "third.cert"]);
    assert_eq!(code, Some(0), "{printed}");
    let wide = deep_gap(folder.path(), 0.405);
    let (code, printed) = cranny(folder.path(), &["certify", &wide.to_string_lossy(), "-o", "wide.cert"]);
    assert!(code == Some(1) && printed.contains("no certificate of no motion"), "{printed}");
}

/// Both checkers accept that grasps have no configuration, and no motion to a grasp that a plan reaches is certified to be impossible.
#[test]
fn that_grasps_are_impossible_is_certified() {
    let folder = tempfile::tempdir().expect("a folder");
    for (scenario, least) in [("021", 20), ("035", 3)] {
        let words = ["certify", scenario, "--impossible-grasps", "-o", "no.cert", "--json"];
        let (code, printed) = cranny(folder.path(), &words);
        assert_eq!(code, Some(0), "{printed}");
        let written: serde_json::Value = serde_json::from_str(&printed).expect("JSON");
        let impossible = written["grasps"].as_array().expect("grasps");
        assert!(impossible.len() >= least, "{printed}");
        let text = std::fs::read_to_string(folder.path().join("no.cert")).expect("a certificate");
        let found = check(&text).expect("it holds");
        assert_eq!(found[2], format!("goals {0}, of which {0} are blocked", 2 * impossible.len()));
        python_agrees(folder.path(), &text, true);
        let (_, ik) = cranny(folder.path(), &["ik", scenario, "--attempts", "200", "--json", "-q"]);
        let rows: serde_json::Value = serde_json::from_str(&ik).expect("JSON");
        for row in rows.as_array().or(rows["grasps"].as_array()).expect("rows") {
            let is_certified = impossible.contains(&row["grasp"]);
            assert!(!is_certified || row["status"] != "solved", "{row}");
        }
        // One of the lines is missing, or another goal.
        let blocked = text.lines().find(|line| line.starts_with("blocked 1 ")).expect("such a line");
        for wrong in [
            text.replacen(&format!("{blocked}\n"), "", 1),
            text.replacen(blocked, &blocked.replacen('1', "0", 1), 1),
        ] {
            assert!(check(&wrong).is_err());
            python_agrees(folder.path(), &wrong, false);
        }
        std::fs::remove_file(folder.path().join("no.cert")).expect("removed");
    }
    let (code, printed) = cranny(folder.path(), &["certify", "011", "--impossible-grasps"]);
    assert!(code == Some(1) && printed.contains("no certificate"), "{printed}");
    let (code, printed) = cranny(folder.path(), &["certify", "021", "it.plan.json", "--impossible-grasps"]);
    assert!(code == Some(2) && printed.contains("cannot be used with"), "{printed}");
}

/// A greater distance than the path has is not certified, whatever the planes are.
#[test]
fn more_than_the_clearance_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    for scenario in ["011", "024", "035", "045"] {
        let text = certificate(folder.path(), scenario, &[]);
        let plan = std::fs::read(folder.path().join("it.plan.json")).expect("a plan");
        let plan: serde_json::Value = serde_json::from_slice(&plan).expect("JSON");
        let clearance_m = plan["clearance_m"].as_f64().expect("a clearance");
        let more = with_scene_line(&text, "margin", &format!("margin {}", clearance_m + 2e-5));
        let (_, reason) = check(&more).expect_err("too much is claimed");
        assert!(reason.contains("apart"), "{reason}");
    }
}

/// Paths that were once called valid have no certificate.
#[test]
fn false_proofs_have_no_certificate() {
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/false_proofs");
    let folder = tempfile::tempdir().expect("a folder");
    for name in [
        "always_touching",
        "false_contact",
        "geared_joint",
        "large_angle_1",
        "large_angle_2",
        "overlap_opposite",
        "thin_hull_1",
        "thin_hull_2",
        "two_sided",
    ] {
        let scenario: PathBuf = fixtures.join(name);
        // This one is a single configuration.
        let file = if name == "false_contact" { "q.csv" } else { "p.csv" };
        let (id, path) = (scenario.to_string_lossy(), scenario.join(file));
        let (code, printed) =
            cranny(folder.path(), &["certify", &id, &path.to_string_lossy(), "-o", "false.cert"]);
        assert_eq!(code, Some(1), "{name}: {printed}");
        assert!(
            printed.contains("no certificate") && !folder.path().join("false.cert").exists(),
            "{printed}"
        );
    }
}

/// The straight edge from the start to the end of a path has a certificate only if `cranny verify` proves it.
#[test]
fn plans_made_false_have_no_certificate() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut refused = 0;
    for scenario in scenarios() {
        let text = certificate(folder.path(), &scenario, &["--stop-at-corners"]);
        let points: Vec<String> =
            text.lines().filter_map(|line| line.strip_prefix("q ")).map(|q| q.replace(' ', ",")).collect();
        let ends = format!("{}\n{}\n", points[0], points[points.len() - 1]);
        std::fs::write(folder.path().join("direct.csv"), ends).expect("written");
        let (verified, _) = cranny(folder.path(), &["verify", &scenario, "direct.csv"]);
        let (code, printed) =
            cranny(folder.path(), &["certify", &scenario, "direct.csv", "-o", "direct.cert"]);
        assert_eq!(code == Some(0), verified == Some(0), "{scenario}: {printed}");
        refused += usize::from(code != Some(0));
    }
    assert!(refused >= 10, "{refused}");
}

/// A motion with an object in the hand has a scene for each part. The object may touch its support to 0.1 mm during lift-off.
#[test]
fn a_carried_object_is_certified() {
    let folder = tempfile::tempdir().expect("a folder");
    for (scenario, flags) in
        [("021", ["--carry", "home"]), ("011", ["--carry", "home"]), ("012", ["--place", "outside"])]
    {
        let text = certificate(folder.path(), scenario, &flags);
        let found = check(&text).unwrap_or_else(|fault| panic!("{scenario}: {fault:?}"));
        if scenario == "021" {
            python_agrees(folder.path(), &text, true);
            // The same arm in another order of its parents, in the last scene alone.
            let at = text.rfind("\nscene ").expect("a scene") + 1;
            let (before, last) = text.split_at(at);
            let other = format!("x\n{last}").replacen("link panda_link8 10 ", "link panda_link8 9 ", 1);
            let other = with_scene_line(&other, "tip", "tip 15");
            let other = format!("{before}{}", &other[2..]);
            let (_, reason) = check(&other).expect_err("another arm");
            assert!(reason.contains("down to the tip"), "{reason}");
            python_agrees(folder.path(), &other, false);
        }
        let scenes: Vec<&[String]> =
            found.split_inclusive(|line| line.starts_with("scene ")).skip(1).collect();
        assert!(
            scenes.len() >= 3
                && found.iter().any(|line| line.starts_with(&format!("scene {scenario}/lift-off ")))
        );
        let lift_off = scenes[1];
        let names = |sign: &str| lift_off.iter().filter(|line| line.starts_with(sign)).count();
        // The object and both fingers; a table in parts is listed part by part, as the object may touch only one of them.
        let of_parts = lift_off.iter().filter(|line| line.starts_with("+ body table/")).count();
        assert_eq!((names("- "), names("+ ")), (3 + usize::from(of_parts > 0), 3 + of_parts), "{lift_off:?}");
        assert!(lift_off.iter().any(|line| line.ends_with(" -.0001")), "{lift_off:?}");
        assert!(!scenes[2].iter().any(|line| line.ends_with(" -.0001")), "{found:?}");
    }
}

/// Bounds of the tool and of the tilt of a held object are part of a certificate, and a lower one is refused.
#[test]
fn bounds_along_the_motion_are_certified() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = certificate(folder.path(), "021", &["--carry", "home", "--upright", "30"]);
    let found = check(&text).expect("a certificate");
    assert!(found.iter().any(|line| line.starts_with("cone tilt ")), "{found:?}");
    python_agrees(folder.path(), &text, true);
    let old = text.lines().find(|line| line.starts_with("cone tilt ")).expect("a bound");
    let angle = old.rsplit(' ').next().expect("an angle");
    let lower = with_scene_line(&text, "cone tilt ", &old.replace(angle, "0.000001"));
    // Only the scene with this bound has another hash.
    assert!(check(&lower).is_err());
}
