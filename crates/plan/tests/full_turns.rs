//! Joints with a range of several turns: paths do not wind.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::sync::Arc;

use cranny_collision::{Margins, World};
use cranny_grasp::{Grasp, GraspSet};
use cranny_path::{ShortcutSettings, audit, shortcut};
use cranny_plan::{Budget, Outcome, Registry, Unobserved};
use cranny_robot::{Robot, RobotOptions};
use cranny_task::{Goal, Problem};

use crate::fixture::block;

/// Returns an arm of six joints that turn by 2π in both directions, as many current arms do.
fn arm() -> Arc<Robot> {
    arm_of(r#"type="revolute""#, r#"lower="-6.2832" upper="6.2832""#)
}

/// Returns an arm of six joints of this type with these limits.
fn arm_of(kind: &str, range: &str) -> Arc<Robot> {
    let mut urdf = String::from(r#"<robot name="six"><link name="l0"/>"#);
    let joints = [
        ("0 0 0.1", "0 0 1"),
        ("0 0.1 0.1", "0 1 0"),
        ("0.4 0 0", "0 1 0"),
        ("0.4 0 0", "0 1 0"),
        ("0 -0.1 0", "0 0 1"),
        ("0 0 -0.1", "0 1 0"),
    ];
    for (index, (origin, axis)) in joints.into_iter().enumerate() {
        let (parent, child) = (index, index + 1);
        let _ = write!(
            urdf,
            r#"<link name="l{child}"><collision><geometry><sphere radius="0.03"/></geometry></collision></link>
<joint name="j{child}" {kind}><parent link="l{parent}"/><child link="l{child}"/><origin xyz="{origin}"/>
<axis xyz="{axis}"/><limit {range} velocity="1" effort="1"/></joint>"#
        );
    }
    urdf += r#"<link name="tip"/><joint name="t" type="fixed"><parent link="l6"/><child link="tip"/><origin xyz="0 0.08 0"/></joint></robot>"#;
    Arc::new(Robot::from_urdf_text(&urdf, "six.urdf", None, &RobotOptions::default()).expect("a good URDF"))
}

const START: [f64; 6] = [0.0, -1.2, 1.6, -0.4, 0.3, 0.2];

/// Returns the problem to grasp at the tip pose of `q`, near an obstacle.
fn problem(q: &[f64]) -> Problem {
    problem_of(arm(), START, q)
}

fn problem_of(robot: Arc<Robot>, start: [f64; 6], q: &[f64]) -> Problem {
    let frames = robot.frames_at(q);
    let grasp = Grasp::at(*frames.link(robot.tip()));
    let world = World::new(vec![block("post", [0.45, 0.35, 0.5], [0.03, 0.03, 0.3])]).expect("a good pose");
    let goal = Goal::Grasps(GraspSet::new(vec![grasp]).expect("a good pose"));
    Problem::exact(robot, world, None, start.to_vec(), goal, Margins::default()).expect("a good problem")
}

/// Returns the range of the values of a joint along a path.
fn turned(path: &[Vec<f64>], joint: usize) -> f64 {
    let values = || path.iter().map(|q| q[joint]);
    values().fold(f64::MIN, f64::max) - values().fold(f64::MAX, f64::min)
}

/// Checks that no joint turns by more than half a turn to a goal less than that away.
#[test]
fn no_goal_is_more_than_half_a_turn_away() {
    let problem = problem(&[1.3, -0.6, 1.0, -0.6, 0.1, 0.4]);
    for name in ["reach", "ik-rrt"] {
        for seed in 0..10 {
            let found = Registry::default().planner(name).expect("a planner").plan(
                &problem,
                &Budget::default(),
                seed,
                &mut Unobserved,
            );
            let found = found.expect("a good problem");
            assert_eq!(found.outcome, Outcome::Solved);
            let settings = ShortcutSettings { seed, ..ShortcutSettings::default() };
            let path = shortcut(&problem, &found.path, settings).expect("proven").path;
            assert!(audit(&problem, &path).expect("a path").valid);
            let end = path.last().expect("a path");
            for (joint, (end, start)) in end.iter().zip(START).enumerate() {
                let half = std::f64::consts::PI + 1e-9;
                assert!((end - start).abs() <= half, "{name} {seed}: joint {joint} ends at {end}");
                assert!(turned(&path, joint) < 1.1 * half, "{name} {seed}: joint {joint} winds");
            }
        }
    }
}

#[test]
fn a_path_that_winds_is_turned_back() {
    let mut goal = START.to_vec();
    goal[0] = 5.94;
    let problem = problem(&goal);
    let mut path: Vec<Vec<f64>> = vec![START.to_vec()];
    for turn in [-1.5, -3.5, -5.0, -6.0, -3.0, 0.0, 2.0, 4.0, 5.94] {
        let mut q = START.to_vec();
        q[0] = turn;
        path.push(q);
    }
    let path = shortcut(&problem, &path, ShortcutSettings::default()).expect("exact").path;
    assert!(turned(&path, 0) < 0.5, "{path:?}");
    assert!(audit(&problem, &path).expect("a path").valid);
}

/// Checks that a joint without limits passes a full turn if that is the shorter direction.
#[test]
fn continuous_joints_wrap() {
    let mut start = START;
    start[0] = 6.2;
    start[4] = -6.1;
    let problem = problem_of(arm_of(r#"type="continuous""#, ""), start, &[1.3, -0.6, 1.0, -0.6, -0.2, 0.4]);
    let mut beyond = 0;
    for seed in 0..10 {
        let found = Registry::default().planner("reach").expect("a planner");
        let found = found.plan(&problem, &Budget::default(), seed, &mut Unobserved).expect("a good problem");
        assert_eq!(found.outcome, Outcome::Solved);
        let path = shortcut(&problem, &found.path, ShortcutSettings::default()).expect("proven").path;
        assert!(audit(&problem, &path).expect("a path").valid);
        let (first, last) = (&path[0], &path[path.len() - 1]);
        assert!(
            last.iter().zip(first).all(|(end, start)| (end - start).abs() <= std::f64::consts::PI + 1e-9)
        );
        beyond += usize::from(path.iter().flatten().any(|value| value.abs() > TAU));
    }
    assert!(beyond > 3, "{beyond} of 10 paths go past a full turn");
}

/// Checks that values that differ by full turns are equivalent for a continuous joint.
#[test]
fn goals_and_starts_of_joints_without_an_end_are_wrapped() {
    let robot = arm_of(r#"type="continuous""#, "");
    let at = |value: f64| [0.0, 0.0, 0.0, 0.0, value, 0.0].to_vec();
    let problem = |start: f64, goal: f64| {
        let goal = Goal::Configurations(vec![at(goal)]);
        let world = World::new(Vec::new()).expect("nothing");
        Problem::exact(robot.clone(), world, None, at(start), goal, Margins::default()).expect("a problem")
    };
    for (start, goal, turns) in
        [(3.0, -3.0, TAU - 6.0), (37.7, 15.0, 15.0 - 37.7 + 4.0 * TAU), (9.0, -9.0, 2.0 * TAU - 18.0)]
    {
        let problem = problem(start, goal);
        let planner = Registry::default().planner("rrt-connect").expect("a planner");
        let report = planner.plan(&problem, &Budget::default(), 0, &mut Unobserved).expect("a search");
        assert_eq!(report.outcome, Outcome::Solved);
        let [first, last] = [report.path.first(), report.path.last()].map(|q| q.expect("a path")[4]);
        assert!((last - first - turns).abs() < 1e-9, "{start} to {goal}: from {first} to {last}");
        assert!(audit(&problem, &report.path).expect("a path").valid);
    }
    // A path that ends a full turn away has arrived.
    let far = problem(3.0, -3.0);
    for end in [-3.0, TAU - 3.0] {
        assert!(audit(&far, &[at(3.0), at(end)]).expect("a path").valid, "{end}");
    }
    assert!(!audit(&far, &[at(3.0), at(TAU - 2.9)]).expect("a path").valid);
}

/// Checks that an infeasible goal is reported with the joint or pair that is the reason.
#[test]
fn goals_that_cannot_be_gone_to_have_a_reason() {
    let goals = vec![vec![7.0, 0.0, 0.0, 0.0, 0.0, 0.0], vec![0.0; 6], vec![0.5; 6]];
    let goal = Goal::Configurations(goals);
    let world = World::new(vec![block("wall", [0.85, -0.05, 0.0], [0.1; 3])]).expect("a wall");
    let problem =
        Problem::exact(arm(), world, None, vec![1.0; 6], goal, Margins::default()).expect("a problem");
    let faults: Vec<Vec<String>> = problem
        .goal_faults()
        .iter()
        .map(|of_goal| of_goal.iter().map(ToString::to_string).collect())
        .collect();
    assert_eq!(faults[0], ["j1 is 7.0000, outside its limits [-6.2832, 6.2832]"]);
    assert!(faults[1].iter().any(|fault| fault.contains("touches wall")), "{faults:?}");
    assert_eq!((faults.len(), faults[2].len()), (3, 0), "{faults:?}");
}
