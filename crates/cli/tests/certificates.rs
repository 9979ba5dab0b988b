//! Certificates of the built-in scenarios are accepted by both checkers, and changed ones only if they claim the same.

use std::path::{Path, PathBuf};

use assert_cmd::Command;
use cranny_spatial::Stream;

#[path = "../../../checker/src/lib.rs"]
#[allow(
    clippy::all,
    clippy::pedantic,
    dead_code,
    missing_docs,
    reason = "a program of its own, with its own tests"
)]
mod checker;

use checker::{check, sha256};

/// Runs the program in a folder and returns the exit code, and what it printed on standard output and on standard error.
fn cranny(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::cargo_bin("cranny").expect("the program");
    let output = command.current_dir(folder).args(arguments).output().expect("it runs");
    let text = [output.stdout, output.stderr].concat();
    (output.status.code(), String::from_utf8_lossy(&text).into_owned())
}

/// Plans on a built-in scenario and returns the certificate.
fn certificate(folder: &Path, scenario: &str, flags: &[&str]) -> String {
    let arguments = [&["plan", scenario, "-o", "it.plan.json", "--certificate", "it.cert"], flags].concat();
    let (code, printed) = cranny(folder, &arguments);
    assert_eq!(code, Some(0), "{scenario}: {printed}");
    std::fs::read_to_string(folder.join("it.cert")).expect("a certificate")
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
        let text = certificate(folder.path(), &scenario, &[]);
        let found = check(&text).unwrap_or_else(|fault| panic!("{scenario}: {fault:?}"));
        let scene = &found.scenes[0];
        assert_eq!(scene.name, scenario);
        assert!(scene.pairs > 50 && found.planes > 100 && scene.margin_m > 0.0, "{found:?}");
        if scenario.ends_with('1') {
            python_agrees(folder.path(), &text, true);
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
    assert_eq!(std::fs::read_to_string(folder.path().join("again.cert")).expect("a file"), text);
    assert!(check(&text).is_ok_and(|found| found.scenes[0].margin_m.to_bits() == 0.003_f64.to_bits()));
}

/// Returns a certificate with another line in its scene, and the hash of that scene.
fn with_scene_line(text: &str, begin: &str, line: &str) -> String {
    let old = text.lines().find(|known| known.starts_with(begin)).expect("such a line");
    let changed = text.replacen(old, line, 1);
    let (format, scene) = changed.split_once('\n').expect("a format");
    let (scene, rest) = scene.split_once("hash ").expect("a hash");
    let (_, paths) = rest.split_once('\n').expect("paths");
    format!("{format}\n{scene}hash {}\n{paths}", sha256(scene.as_bytes()))
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
        let fault = check(&more).expect_err("too much is claimed");
        assert!(fault.reason.contains("apart") && !fault.is_malformed, "{fault:?}");
    }
}

/// Random changes of the paths and planes: a certificate that is accepted claims the same scene and the same path as before.
/// Changes of the scene alone do not fit its hash.
#[test]
fn changed_certificates_are_refused_or_claim_the_same() {
    let folder = tempfile::tempdir().expect("a folder");
    let rounds = if std::env::var_os("CRANNY_LONG").is_some() { 2000 } else { 100 };
    let (mut refused, mut same) = (0, 0);
    for (index, scenario) in ["011", "022", "033", "044"].into_iter().enumerate() {
        let text = certificate(folder.path(), scenario, &["--stop-at-corners"]);
        let claims = |text: &str| -> Vec<String> {
            let is_claim = |line: &&str| !line.starts_with("p ");
            text.lines().filter(is_claim).map(ToOwned::to_owned).collect()
        };
        let claimed = claims(&text);
        let mut random = Stream::new(56, index as u64);
        for _ in 0..rounds {
            let changed = change(&text, &mut random);
            match check(&changed) {
                Err(_) => refused += 1,
                Ok(_) if changed == text => {}
                Ok(found) => {
                    assert_eq!(claims(&changed), claimed, "{found:?}");
                    same += 1;
                }
            }
        }
    }
    assert!(refused > 2 * same, "{refused} refused, {same} with the same claims");
}

/// Changes one thing at random.
fn change(text: &str, random: &mut Stream) -> String {
    let mut lines: Vec<String> = text.lines().map(ToOwned::to_owned).collect();
    let paths = lines.iter().position(|line| line.starts_with("hash")).expect("a hash");
    let mut pick = |from: usize, below: usize| from + random.index(below - from);
    let kind = pick(0, 9);
    let of_pairs: Vec<usize> = (paths..lines.len()).filter(|at| lines[*at].starts_with("p ")).collect();
    let of_points: Vec<usize> = (paths..lines.len()).filter(|at| lines[*at].starts_with("q ")).collect();
    let (at, point) = (of_pairs[pick(0, of_pairs.len())], of_points[pick(0, of_points.len())]);
    let replace = |line: &mut String, word: usize, by: &str| {
        let mut words: Vec<&str> = line.split(' ').collect();
        let word = word.min(words.len() - 1);
        words[word] = by;
        *line = words.join(" ");
    };
    let marks = lines[at].split(' ').count();
    match kind {
        // A moved plane.
        0 => {
            let plane =
                format!("{},{},{}", pick(0, 400) as i32 - 200, pick(0, 400) as i32 - 200, pick(1, 200));
            replace(&mut lines[at], pick(3, marks), &plane);
        }
        // A shortened interval, or part.
        1 => {
            let mark = pick(3, marks);
            let words: Vec<String> = lines[at]
                .split(' ')
                .enumerate()
                .filter(|(i, _)| *i != mark)
                .map(|(_, word)| word.to_owned())
                .collect();
            lines[at] = words.join(" ");
        }
        // An omitted, and a repeated pair.
        2 => drop(lines.remove(at)),
        3 => lines.insert(at, lines[at].clone()),
        // Permuted edges and pairs.
        4 => lines.swap(at, of_pairs[pick(0, of_pairs.len())]),
        5 => lines.swap(point, of_points[pick(0, of_points.len())]),
        // Another path.
        6 => {
            let joint = pick(1, lines[point].split(' ').count());
            let value: f64 =
                lines[point].split(' ').nth(joint).and_then(|x| x.parse().ok()).expect("a number");
            let other = if pick(0, 2) == 0 { value + 0.2 } else { value.next_up() };
            replace(&mut lines[point], joint, &other.to_string());
        }
        // No number, a huge number, a huge count.
        7 => {
            let by = ["NaN", "1e999", "99999999999999999999", "-", "inf"][pick(0, 5)];
            let line = pick(1, lines.len());
            let words = lines[line].split(' ').count();
            replace(&mut lines[line], pick(0, words), by);
        }
        // An allowed contact that the scene does not have.
        _ => lines.insert(paths, format!("skip {} {} declared", pick(0, 10), pick(16, 18))),
    }
    lines.join("\n") + "\n"
}

/// Paths that were once called valid have no certificate.
#[test]
fn false_proofs_have_no_certificate() {
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/false_proofs");
    let folder = tempfile::tempdir().expect("a folder");
    for name in [
        "always_touching",
        "geared_joint",
        "large_angle_1",
        "large_angle_2",
        "overlap_opposite",
        "thin_hull_1",
        "thin_hull_2",
        "two_sided",
    ] {
        let scenario: PathBuf = fixtures.join(name);
        let (id, path) = (scenario.to_string_lossy(), scenario.join("p.csv"));
        let (code, printed) =
            cranny(folder.path(), &["certify", &id, &path.to_string_lossy(), "-o", "false.cert"]);
        assert_eq!(code, Some(1), "{name}: {printed}");
        assert!(
            printed.contains("no certificate") && !folder.path().join("false.cert").exists(),
            "{printed}"
        );
    }
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
        assert!(found.scenes.len() >= 3, "{found:?}");
        let lift_off = &found.scenes[1];
        assert_eq!(lift_off.name, format!("{scenario}/lift-off"));
        let names = |sign: &str| lift_off.exceptions.iter().filter(|line| line.starts_with(sign)).count();
        // The object and both fingers.
        assert_eq!((names("-"), names("+")), (3, 3), "{lift_off:?}");
        assert!(lift_off.exceptions.iter().any(|line| line.ends_with("-0.0001")), "{lift_off:?}");
        assert!(!found.scenes[2].exceptions.iter().any(|line| line.ends_with("-0.0001")), "{found:?}");
    }
}

/// What is not covered is refused with a reason.
#[test]
fn a_bound_of_the_tilt_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let arguments = ["plan", "021", "--carry", "home", "--upright", "30", "--certificate", "it.cert"];
    let (code, printed) = cranny(folder.path(), &arguments);
    assert_eq!(code, Some(1), "{printed}");
    assert!(printed.contains("does not cover"), "{printed}");
}
