//! Bounds of tool and joints of a `scenario.yaml`: plans keep and state them, audits check them, and they are written again.

use std::fs;
use std::path::{Path, PathBuf};

use cranny_collision::Margins;
use cranny_path::AuditSettings;
use cranny_plan::Unobserved;
use cranny_record::{PlanFile, PlanSource};
use cranny_scenario::{OpenOptions, Scenario};
use cranny_solve::{Request, Timing, solve};
use cranny_task::{Problem, Stage};
use serde_json::json;

const BOUNDS: &str = "tool_bounds:
  - name: lane
    pose: {position: [1, 0.5, 0.6]}
    size: [1.2, 1.6, 1.3]
  - {name: level, axis: [0, 0, 1], toward: [0, 1, -1], within_deg: 60}
  - {name: around the table, point: [0, 0, 0.1], pose: {position: [1, 0, 0.5]}, radius: 1.2}
joint_bounds:
  panda_joint1: [-0.3, 0.3]
speeds:
  all: {speed: 0.5, tool_speed_m_s: 0.4, turn_speed_deg_s: 80}
  carry: {acceleration: 0.25}
";

/// Creates scenario 021 with bounds, in a folder.
fn folder(bounds: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("021");
    Scenario::open("021", &OpenOptions::default()).unwrap().write_folder(&path).unwrap();
    let file = path.join("scenario.yaml");
    let text = fs::read_to_string(&file).unwrap();
    fs::write(&file, format!("{text}{bounds}")).unwrap();
    (folder, path)
}

fn opened(path: &Path) -> Scenario {
    Scenario::open(path.to_str().unwrap(), &OpenOptions::default()).unwrap()
}

fn planned(problem: &Problem, stages: Vec<Stage>, seed: u64) -> PlanFile {
    let request = Request { stages, seed, timing: Some(Timing::default()), ..Request::default() };
    let answer = solve(problem, &request, &mut Unobserved).unwrap();
    assert!(answer.is_valid(), "seed {seed}");
    PlanFile::of(&answer, &PlanSource { scenario: "021".to_owned(), ..PlanSource::default() })
}

#[test]
fn what_is_planned_keeps_the_bounds_and_states_how_far() {
    let (_folder, path) = folder(BOUNDS);
    let problem = opened(&path).problem(Margins::default()).unwrap();
    let (robot, bounds) = (problem.robot(), problem.cell().unwrap().world().tool_bounds());
    let stages = [Vec::new(), vec![Stage::pick(), Stage::home()]];
    for (stages, seed) in stages.into_iter().zip(0..) {
        let plan = planned(&problem, stages, seed);
        let trajectory = plan.trajectory(robot).unwrap().unwrap();
        for (bound, stated) in bounds.iter().zip(&plan.tool) {
            assert_eq!(bound.name, stated.name);
            let slack = stated.slack_m.or(stated.slack_rad).unwrap();
            let samples = trajectory.legs().iter().flat_map(|leg| leg.samples(500.0).unwrap());
            let excess = |q: &[f64]| bound.region.excess(robot.frames_at(q).link(robot.tip()));
            let seen = samples.map(|sample| excess(&sample.position)).fold(f64::NEG_INFINITY, f64::max);
            assert!(-seen >= slack - 1e-9 && -seen <= slack + 6e-3, "{}: {seen}, stated {slack}", bound.name);
        }
        assert!(plan.waypoints.iter().all(|q| q[2].abs() <= 0.3));
        assert_eq!(plan.tool.len(), 3);
        let judge = |plan: &PlanFile| {
            let source = PlanSource { scenario: "021".to_owned(), ..PlanSource::default() };
            plan.judge(&source, &problem, AuditSettings::default()).unwrap().unwrap()
        };
        assert!(judge(&plan).audit.valid && judge(&plan).differs.is_empty(), "{:?}", judge(&plan).differs);
        let mut boast: serde_json::Value = serde_json::to_value(&plan).unwrap();
        boast["tool"][0]["slack_m"] = json!(plan.tool[0].slack_m.unwrap() * 1.01);
        assert!(!judge(&serde_json::from_value(boast).unwrap()).audit.valid);
    }
}

#[test]
fn a_plan_of_the_scenario_without_bounds_is_none_in_it() {
    let free = Scenario::open("021", &OpenOptions::default()).unwrap();
    let plan = planned(&free.problem(Margins::default()).unwrap(), Vec::new(), 0);
    let (_folder, path) =
        folder("tool_bounds: [{name: low, pose: {position: [1, 0, 0.1]}, size: [9, 9, 0.1]}]\n");
    let problem = opened(&path).problem(Margins::default()).unwrap();
    let source = PlanSource { scenario: "021".to_owned(), ..PlanSource::default() };
    let judged = plan.judge(&source, &problem, AuditSettings::default()).unwrap().unwrap();
    let kinds: Vec<&str> = judged.audit.violations.iter().map(cranny_path::Violation::kind).collect();
    assert!(!kinds.is_empty() && kinds.iter().all(|kind| *kind == "tool"), "{kinds:?}");
    let start = problem.configuration_faults(problem.start());
    assert!(start[0].to_string().contains("the bound 'low' is exceeded by"), "{start:?}");
}

#[test]
fn bounds_and_tilts_are_written_again() {
    let (folder, path) = folder(BOUNDS);
    let scenario = opened(&path);
    let mut bodies = scenario.world.bodies().to_vec();
    bodies[scenario.target.unwrap()].tilt_rad = Some(0.25);
    let scenario = Scenario { world: scenario.world.with_bodies(bodies).unwrap(), ..scenario };
    let again = folder.path().join("again");
    scenario.write_folder(&again).unwrap();
    let read = opened(&again);
    let target = &read.world.bodies()[read.target.unwrap()];
    assert!((target.tilt_rad.unwrap() - 0.25).abs() < 1e-9);
    assert_eq!(read.joint_bounds, scenario.joint_bounds);
    assert_eq!(read.speeds, scenario.speeds);
    assert!(read.speeds.len() == 2 && read.speeds[0].mode.is_none() && read.speeds[0].tool_m_s == Some(0.4));
    assert_eq!(read.robot.limits(), scenario.robot.limits());
    let tips = [read.start.clone(), vec![0.3; 9]];
    let tips = tips.iter().map(|q| *read.robot.frames_at(q).link(read.robot.tip()));
    for (tip, (a, b)) in tips.flat_map(|tip| {
        read.world.tool_bounds().iter().zip(scenario.world.tool_bounds()).map(move |pair| (tip, pair))
    }) {
        assert_eq!(a.name, b.name);
        assert!((a.region.excess(&tip) - b.region.excess(&tip)).abs() < 1e-9, "{a:?} {b:?}");
    }
}

#[test]
fn a_bound_that_is_none_is_refused_with_its_line() {
    for (bounds, says) in [
        ("tool_bounds: [{name: a, size: [1, 1, 0]}]\n", "bound 'a' is not valid"),
        ("tool_bounds: [{name: a, radius: .nan}]\n", "bound 'a' is not valid"),
        ("tool_bounds: [{name: a}]\n", "either the `size` of a box"),
        ("tool_bounds: [{name: a, axis: [0, 0, 1], toward: [0, 0, 1]}]\n", "either the `size` of a box"),
        (
            "tool_bounds: [{name: a, axis: [0, 0, 0], toward: [0, 0, 1], within_deg: 5}]\n",
            "bound 'a' is not valid",
        ),
        ("tool_bounds: [{name: a, radius: 1}, {name: a, radius: 2}]\n", "'a'"),
        (
            "speeds: {all: {speed: 1.5}}\n",
            "'1.5' is not a valid limit: expected a number above 0 and at most 1",
        ),
        ("speeds: {fly: {speed: 1}}\n", "'fly' is not a motion mode (known: reach,"),
        ("joint_bounds: {panda_joint1: [1, -1]}\n", "no value of panda_joint1"),
        ("joint_bounds: {panda_joint1: [8, 9]}\n", "no value of panda_joint1"),
        (
            "tool_bounds: [{name: a, link: panda_leftfinger, radius: 1}]\n",
            "is a finger, which the hand moves",
        ),
        ("tool_bounds: [{name: a, link: elbow, radius: 1}]\n", "the robot has no link 'elbow'"),
        ("joint_bounds: {elbow: [0, 1]}\n", "elbow"),
    ] {
        let (_folder, path) = folder(bounds);
        let fault = Scenario::open(path.to_str().unwrap(), &OpenOptions::default()).unwrap_err().to_string();
        assert!(fault.contains("scenario.yaml:") && fault.contains(says), "{bounds}: {fault}");
    }
}
