//! Trajectories from the command line: beside the plan, in the summary, in the answer.

use std::path::Path;
use std::process::Output;

use assert_cmd::Command;
use serde_json::Value;

fn cranny(folder: &Path, arguments: &[&str]) -> Output {
    Command::cargo_bin("cranny")
        .expect("the program")
        .current_dir(folder)
        .args(arguments)
        .output()
        .expect("it runs")
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

fn read(folder: &Path, file: &str) -> String {
    std::fs::read_to_string(folder.join(file)).expect("a file")
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("numbers").iter().map(|x| x.as_f64().expect("a number")).collect()
}

#[test]
fn a_rate_writes_the_trajectory_beside_the_plan() {
    let folder = folder();
    for (flags, method) in
        [(&["--json"][..], "jerk-limited"), (&["--json", "--timing", "time-optimal"], "time-optimal")]
    {
        let arguments = [&["plan", "021", "--rate", "100", "-o", "here.plan.json"], flags].concat();
        let planned = cranny(folder.path(), &arguments);
        assert_eq!(planned.status.code(), Some(0), "{}", String::from_utf8_lossy(&planned.stderr));
        let answer: Value = serde_json::from_slice(&planned.stdout).expect("one JSON document");
        assert_eq!(answer["trajectory_file"], "here.trajectory.csv");
        assert!(answer["timing_time_s"].as_f64().is_some_and(|s| s > 0.0));
        let duration_s = answer["duration_s"].as_f64().expect("a duration");

        let plan: Value = serde_json::from_str(&read(folder.path(), "here.plan.json")).expect("a plan");
        assert_eq!(plan["timing"]["method"], method);
        assert_eq!(plan["timing"]["duration_s"].as_f64(), Some(duration_s));
        let way_points: Vec<Vec<f64>> =
            plan["waypoints"].as_array().expect("way points").iter().map(numbers).collect();
        let times = numbers(&plan["timing"]["waypoint_times_s"]);
        assert_eq!((times.len(), times[0]), (way_points.len(), 0.0));
        assert_eq!(times.last(), Some(&duration_s));

        let table = read(folder.path(), "here.trajectory.csv");
        let (header, rows) = table.split_once('\n').expect("a header");
        assert!(header.starts_with("time_s,q_base_joint_y,q_base_joint_x,q_panda_joint1,"));
        assert!(header.ends_with(",a_panda_joint6,a_panda_joint7") && header.contains(",v_panda_joint1,"));
        let rows: Vec<Vec<f64>> =
            rows.lines().map(|row| row.split(',').map(|x| x.parse().expect("a number")).collect()).collect();
        assert!(rows.iter().all(|row| row.len() == 1 + 3 * 9));
        assert!((rows[1][0] - 0.01).abs() < 1e-12);
        let (first, last) = (&rows[0], &rows[rows.len() - 1]);
        assert_eq!((first[0], &first[1..10]), (0.0, &way_points[0][..]));
        assert_eq!((last[0], &last[1..10]), (duration_s, &way_points[way_points.len() - 1][..]));
        assert!(first[10..19].iter().chain(&last[10..19]).all(|v| *v == 0.0));
    }
}

#[test]
fn every_plan_says_how_long_it_takes_and_writes_no_table_unasked() {
    let folder = folder();
    let planned = cranny(folder.path(), &["plan", "021"]);
    assert_eq!(planned.status.code(), Some(0));
    let summary = String::from_utf8_lossy(&planned.stdout);
    assert!(summary.contains("trajectory") && summary.contains("jerk-limited, corners rounded"), "{summary}");
    assert!(read(folder.path(), "021.plan.json").contains("\"waypoint_times_s\""));
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 1);
}

#[test]
fn corners_are_rounded_where_they_are_proven_unless_stops_are_demanded() {
    let folder = folder();
    let duration_s = |flags: &[&str]| {
        let planned = cranny(folder.path(), &[&["plan", "021", "--json"], flags].concat());
        assert_eq!(planned.status.code(), Some(0));
        let answer: Value = serde_json::from_slice(&planned.stdout).expect("one JSON document");
        assert_eq!(answer["timing"]["blended"], flags.is_empty());
        answer["duration_s"].as_f64().expect("a duration")
    };
    assert!(duration_s(&[]) < duration_s(&["--stop-at-corners"]));
}

#[test]
fn a_rate_that_is_none_is_refused_before_the_search() {
    let folder = folder();
    for rate in ["0", "nan", "-5", "1e9", "fast"] {
        let refused = cranny(folder.path(), &["plan", "021", &format!("--rate={rate}")]);
        assert_eq!(refused.status.code(), Some(2));
        assert!(String::from_utf8_lossy(&refused.stderr).contains("samples per second"));
    }
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 0);
}

#[test]
fn a_robot_without_limits_of_acceleration_gets_a_plan_but_no_trajectory() {
    let folder = folder();
    let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenario/robots/panda_mobile");
    for file in ["panda_mobile.urdf", "panda_mobile.srdf"] {
        std::fs::copy(robots.join(file), folder.path().join(file)).expect("a copy");
    }
    let plan = ["plan", "021", "--robot", "panda_mobile.urdf"];
    let planned = cranny(folder.path(), &plan);
    assert_eq!(planned.status.code(), Some(0), "{}", String::from_utf8_lossy(&planned.stderr));
    let summary = String::from_utf8_lossy(&planned.stdout).into_owned();
    assert!(summary.contains("none: joint 'base_joint_y' has no acceleration limit"), "{summary}");
    for flags in [&["--rate", "100"][..], &["--jerk-limited"]] {
        let refused = cranny(folder.path(), &[&plan[..], flags].concat());
        assert_eq!(refused.status.code(), Some(2));
        let message = String::from_utf8_lossy(&refused.stderr).into_owned();
        for word in ["base_joint_y", "acceleration", "limits.yaml"] {
            assert!(message.contains(word), "no '{word}' in {message}");
        }
    }
}
