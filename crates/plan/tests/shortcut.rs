//! Guarantees of shortening a path.

use cranny_path::{PathError, ShortcutSettings, audit, path_length, shortcut};
use cranny_task::{Goal, Problem, TaskError};

use crate::fixture::{START, arm, ball, block, easy, exact, plan};

fn settings(seed: u64) -> ShortcutSettings {
    ShortcutSettings { seed, ..ShortcutSettings::default() }
}

fn found(problem: &Problem, seed: u64) -> Vec<Vec<f64>> {
    plan("reach", problem, 1_000_000, seed).path
}

#[test]
fn a_path_to_a_grasp_ends_at_the_same_grasp_by_a_shorter_way() {
    let problem = easy();
    let mut ends_moved = 0;
    for seed in 0..10 {
        let path = found(&problem, seed);
        let short = shortcut(&problem, &path, settings(seed)).expect("an exact problem").path;
        let [before, after] = [&path, &short].map(|path| audit(&problem, path).expect("a path of the robot"));
        assert!(after.valid, "{:?}", after.violations);
        assert_eq!(before.goal.map(|goal| goal.grasp), after.goal.map(|goal| goal.grasp));
        assert_eq!(short[0], path[0]);
        assert!(path_length(&short) <= path_length(&path));
        ends_moved += usize::from(short.last() != path.last());
    }
    assert!(ends_moved > 5, "an arm on a rail has room to hold an object otherwise");
}

#[test]
fn a_path_to_a_configuration_ends_there() {
    let wall = || vec![block("wall", [0.0, -0.2, 0.0], [0.01, 1.0, 2.0])];
    let goal = vec![0.5, -0.9, 0.0];
    let problem = exact(&ball(), wall(), &[-0.5, -0.9, 0.0], Goal::Configurations(vec![goal.clone()]));
    for seed in 0..5 {
        let path = found(&problem, seed);
        let short = shortcut(&problem, &path, settings(seed)).expect("an exact problem").path;
        assert_eq!((&short[0], short.last()), (&path[0], Some(&goal)));
        assert!(audit(&problem, &short).expect("a path of the robot").valid);
        // The path leads around the edge of the wall and back. No path is shorter than this, and the result is not much longer.
        let shortest = 2.0 * 0.5_f64.hypot(1.75) - 1e-9;
        assert!((shortest..1.2 * shortest).contains(&path_length(&short)), "{}", path_length(&short));
    }
}

#[test]
fn a_seed_gives_the_same_bytes() {
    let problem = easy();
    let path = found(&problem, 4);
    let short = || shortcut(&problem, &path, settings(9)).expect("an exact problem").path;
    assert_eq!(short(), short());
}

#[test]
fn a_path_of_one_way_point_stays_as_it_is() {
    let problem = easy();
    let path = vec![START.to_vec()];
    assert_eq!(shortcut(&problem, &path, settings(0)).expect("an exact problem").path, path);
}

#[test]
fn what_is_not_proven_is_not_shortened() {
    let problem = crate::fixture::paper(
        &arm(),
        Vec::new(),
        &START,
        crate::fixture::grasps(crate::fixture::easy_grasps()),
    );
    let refused = shortcut(&problem, &[START.to_vec()], settings(0));
    assert!(matches!(refused, Err(PathError::Task(TaskError::Goal { .. }))), "{refused:?}");
}
