//! Golden cases: each file of `tests/golden` is one, and a new one is a new file (`tests/golden/README.md`).

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use cranny_robot::{JointGroup, Robot, RobotOptions};
use serde_json::Value;

/// File of `tests/golden`: its purpose and the expected result, then its input files.
struct Case {
    path: PathBuf,
    head: Vec<String>,
    files: Vec<(String, String)>,
}

impl Case {
    fn all(folder: &str) -> Vec<Self> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(folder);
        let mut paths: Vec<_> =
            fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()).collect();
        paths.sort();
        paths.into_iter().map(Self::read).collect()
    }

    fn read(path: PathBuf) -> Self {
        let text = fs::read_to_string(&path).expect("UTF-8");
        let mut head = Vec::new();
        let mut files: Vec<(String, String)> = Vec::new();
        for line in text.split_inclusive('\n') {
            let name = line.trim_end().strip_prefix("-- ").and_then(|rest| rest.strip_suffix(" --"));
            match (name, files.last_mut()) {
                (Some(name), _) => files.push((name.to_owned(), String::new())),
                (None, Some((_, text))) => text.push_str(line),
                (None, None) => head.push(line.trim_end().to_owned()),
            }
        }
        assert!(head[0].starts_with("# "), "{}: the first line says what the case guards", path.display());
        Self { path, head, files }
    }

    /// Creates a folder with its files.
    fn unpacked(&self) -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, text) in &self.files {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().expect("a folder")).expect("created");
            fs::write(path, text).expect("written");
        }
        folder
    }

    fn file(&self, name: &str) -> &str {
        let found = self.files.iter().find(|(file, _)| file == name);
        &found.unwrap_or_else(|| panic!("{self}: no file {name}")).1
    }

    /// Returns the text after `sign` in the lines of the head.
    fn said(&self, sign: &str) -> Vec<&str> {
        self.head.iter().filter_map(|line| line.strip_prefix(sign)).collect()
    }
}

impl std::fmt::Display for Case {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{}", self.path.display())
    }
}

fn cranny(folder: &Path, arguments: &str) -> std::process::Output {
    let mut command = Command::cargo_bin("cranny").expect("the program");
    command.current_dir(folder).args(arguments.split_whitespace()).output().expect("it runs")
}

/// Expects exit code 2, the exact message, an empty stdout, and no new files.
#[test]
fn bad_input_is_refused_word_for_word() {
    let cases = Case::all("bad_input");
    for case in &cases {
        let folder = case.unpacked();
        let [command] = case.said("$ cranny ")[..] else { panic!("{case}: one command") };
        let output = cranny(folder.path(), command);
        let message = String::from_utf8(output.stderr).expect("UTF-8");
        let lines: Vec<&str> = message.lines().filter(|line| !line.is_empty()).collect();
        assert_eq!(output.status.code(), Some(2), "{case}: {message}");
        if std::env::var_os("CRANNY_WRITE").is_some() {
            rewrite(case, &lines);
            continue;
        }
        assert_eq!(case.said("> "), lines, "{case}");
        assert!(output.stdout.is_empty(), "{case}");
        let files = fs::read_dir(folder.path()).expect("a folder").count();
        assert_eq!(files, case.files.len(), "{case}: something was written");
    }
    assert!(cases.len() >= 100, "{} cases", cases.len());
}

/// Replaces the expected message of a case by `message`.
fn rewrite(case: &Case, message: &[&str]) {
    let head = case.head.iter().filter(|line| !line.starts_with("> ") && !line.is_empty()).cloned();
    let lines: Vec<String> = head.chain(message.iter().map(|line| format!("> {line}"))).collect();
    let mut text = lines.join("\n") + "\n";
    text.extend(case.files.iter().map(|(name, file)| format!("-- {name} --\n{file}")));
    fs::write(&case.path, text).expect("written");
}

/// `free M`: proven, with a clearance of at most the true one. `contact A B M`: found between the two, at most as deep as
/// anywhere on the path (`M`), and not merely grazing. `limits JOINT`: that joint exceeds its range.
#[test]
fn scenes_have_the_verdicts_that_geometry_gives_them() {
    let cases = Case::all("scenes");
    for case in &cases {
        let folder = case.unpacked();
        let output = cranny(folder.path(), "verify . path.csv --any-end --json");
        let audit: Value = serde_json::from_slice(&output.stdout)
            .unwrap_or_else(|_| panic!("{case}: {}", String::from_utf8_lossy(&output.stderr)));
        let [truth] = case.said("truth ")[..] else { panic!("{case}: one truth") };
        let violations = audit["violations"].as_array().expect("a list");
        match truth.split(' ').collect::<Vec<_>>()[..] {
            ["free", true_m] => {
                assert_eq!(output.status.code(), Some(0), "{case}: {audit}");
                let true_m: f64 = true_m.parse().expect("metres");
                let proven_m = audit["clearance_m"].as_f64().expect("a clearance");
                assert!(
                    proven_m <= true_m + 1e-9 && proven_m >= true_m - 2e-5,
                    "{case}: proven {proven_m}, in truth {true_m}"
                );
            }
            ["contact", first, second, true_m] => {
                assert_eq!(output.status.code(), Some(1), "{case}: {audit}");
                let depths: Vec<f64> = violations
                    .iter()
                    .filter(|found| found["kind"] == "contact")
                    .filter(|found| {
                        let pair = [&found["first"], &found["second"]];
                        pair == [first, second] || pair == [second, first]
                    })
                    .map(|found| found["depth_m"].as_f64().expect("a depth"))
                    .collect();
                let true_m: f64 = true_m.parse().expect("metres");
                let within = |depth_m: &f64| *depth_m > 0.2 * true_m && *depth_m < true_m + 1e-6;
                assert!(depths.iter().any(within), "{case}: {depths:?} deep, in truth {true_m}; {audit}");
            }
            ["limits", joint] => {
                assert_eq!(output.status.code(), Some(1), "{case}: {audit}");
                assert!(
                    violations.iter().any(|found| found["kind"] == "joint-limit" && found["first"] == joint),
                    "{case}: {audit}"
                );
            }
            _ => panic!("{case}: a truth is `free M`, `contact A B M` or `limits JOINT`"),
        }
    }
    assert!(cases.len() >= 25, "{} cases", cases.len());
}

/// `poses.csv`: link, joint values, then the three upper rows of `root_from_link`, row by row. Its first line names the joints.
#[test]
fn links_are_where_others_put_them() {
    let cases = Case::all("robots");
    for case in &cases {
        let folder = case.unpacked();
        let mut lines = case.file("poses.csv").lines();
        let joints = lines.next().expect("a first line").split(',').skip(1).map(str::to_owned);
        let options = RobotOptions { group: JointGroup::Joints(joints.collect()), ..RobotOptions::default() };
        let (file, _) = case.files.iter().find(|(name, _)| name.starts_with("robot.")).expect("a robot");
        let robot = Robot::load(&folder.path().join(file), &options)
            .unwrap_or_else(|error| panic!("{case}: {error}"));
        for line in lines {
            let (link, numbers) = line.split_once(',').expect("a link");
            let numbers: Vec<f64> =
                numbers.split(',').map(|number| number.parse().expect("a number")).collect();
            let (q, rows) = numbers.split_at(robot.dof());
            let index =
                robot.links().iter().position(|known| known.name == link).expect("a link of the robot");
            let actual = robot.frames_at(q).link(index).to_homogeneous();
            for (place, expected) in rows.iter().enumerate() {
                let found = actual[(place / 4, place % 4)];
                assert!((found - expected).abs() < 1e-9, "{case}: {line}\n{actual}");
            }
            assert_eq!(rows.len(), 12, "{case}: {line}");
        }
    }
    assert!(cases.len() >= 34, "{} cases", cases.len());
}
