//! Annotation of every grasp of a set with its status.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use cranny_collision::Cell;
use cranny_spatial::PoseDifference;
use cranny_task::{IkAnnotation, IkAnnotationSettings, IkMethod, IkStatus, Problem, TaskError, annotate_ik};

use crate::fixture::{
    OBJECT, START, arm, block, easy_grasps, exact, grasp_at, grasp_out_of_reach, grasps, off, paper,
    still_life,
};

const SETTINGS: IkAnnotationSettings =
    IkAnnotationSettings { method: IkMethod::Restarts, solutions: 3, attempts: 300, seed: 4 };

/// Returns grasps with these results: solved; in a block; out of reach; in reach, but with a pebble in the wrist; solved; near,
/// but not in the plane in which the arm moves.
fn problem() -> Problem {
    let pebble = block("pebble", [-0.4 - 0.105, 0.4, 0.3], [0.01; 3]);
    let rock = block("rock", [0.0, 0.6, 0.3], [0.1; 3]);
    let goal = vec![
        grasp_at(OBJECT, 0.8),
        grasp_at([0.0, 0.6, 0.3], 0.8),
        grasp_out_of_reach(),
        grasp_at([-0.4, 0.4, 0.3], 0.0),
        grasp_at(OBJECT, 1.0).twin(),
        grasp_at([0.3, 0.3, 0.6], 0.8),
    ];
    let mut bodies = still_life();
    bodies.extend([pebble, rock]);
    exact(&arm(), bodies, &START, grasps(goal))
}

fn annotated(problem: &Problem, settings: &IkAnnotationSettings) -> Vec<IkAnnotation> {
    annotate_ik(problem, settings, &|| (), &AtomicBool::new(false)).expect("an exact problem with grasps")
}

fn cell(problem: &Problem) -> &Cell {
    problem.cell().expect("the problem is exact")
}

#[test]
fn every_fate_of_a_grasp_is_told_apart() {
    let found = annotated(&problem(), &SETTINGS);
    let names: Vec<_> = found.iter().map(|annotation| annotation.status.name()).collect();
    assert_eq!(names, ["solved", "hand-collides", "out-of-reach", "no-solution", "solved", "no-solution"]);
    assert_eq!(found.iter().map(|annotation| annotation.grasp).collect::<Vec<_>>(), [0, 1, 2, 3, 4, 5]);
    let IkStatus::HandCollides { link, body, .. } = &found[1].status else { panic!("{:?}", found[1]) };
    assert!(["palm", "left_finger", "right_finger"].contains(&link.as_str()) && body == "rock");
    let IkStatus::OutOfReach { beyond_m } = found[2].status else { panic!("{:?}", found[2]) };
    assert!(beyond_m > 3.0 && beyond_m < 5.0, "{beyond_m}");
    assert_eq!(found[5].status, IkStatus::NoSolution { blocked: 0, contact: None });
    let IkStatus::NoSolution { blocked, contact: Some((_, second)) } = &found[3].status else {
        panic!("{:?}", found[3])
    };
    assert!(*blocked > 0 && second == "pebble", "{second}");
    assert_eq!([1, 2, 5].map(|grasp| found[grasp].attempts), [0, 0, SETTINGS.attempts]);
}

#[test]
fn a_single_shot_finds_part_of_what_restarts_find() {
    let settings = IkAnnotationSettings { method: IkMethod::SingleShot, ..SETTINGS };
    let problem = problem();
    let (shot, full) = (annotated(&problem, &settings), annotated(&problem, &SETTINGS));
    assert!(shot.iter().any(|annotation| annotation.status == IkStatus::Solved));
    for (shot, full) in shot.iter().zip(&full) {
        assert!(shot.attempts <= 2 && shot.solutions.len() <= shot.attempts);
        assert!(full.status == IkStatus::Solved || shot.status != IkStatus::Solved);
        assert_eq!(shot.status == IkStatus::Solved, !shot.solutions.is_empty());
    }
    assert_eq!(shot, annotated(&problem, &IkAnnotationSettings { seed: 5, ..settings }));
}

#[test]
fn solutions_are_exact_free_and_as_many_as_asked_for() {
    let problem = problem();
    let cell = cell(&problem);
    let mut scratch = cell.scratch();
    let set = problem.grasps().expect("the problem has grasps");
    for annotation in annotated(&problem, &SETTINGS) {
        let is_solved = annotation.status == IkStatus::Solved;
        assert_eq!(annotation.solutions.len(), if is_solved { SETTINGS.solutions } else { 0 });
        assert!(annotation.attempts <= SETTINGS.attempts);
        let grasp = &set.grasps()[annotation.grasp];
        for solution in &annotation.solutions {
            assert!(cell.is_free(&solution.q, &mut scratch));
            let direct = off(&problem, &solution.q, &grasp.world_from_gripper);
            let turned = off(&problem, &solution.q, &grasp.twin().world_from_gripper);
            let nearer = if direct.rotation_rad < turned.rotation_rad { direct } else { turned };
            assert!(nearer.is_exact());
            let told = PoseDifference {
                translation_m: solution.translation_error_m,
                rotation_rad: solution.rotation_error_rad,
            };
            assert!((nearer.translation_m - told.translation_m).abs() < 1e-9);
            assert!((nearer.rotation_rad - told.rotation_rad).abs() < 1e-9);
            assert!((solution.clearance_m - cell.clearance(&solution.q, &mut scratch)).abs() < 1e-12);
        }
    }
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| annotated(&problem(), &SETTINGS))
    };
    assert_eq!(with(1), with(2));
    let other_seed = IkAnnotationSettings { seed: 5, ..SETTINGS };
    assert_ne!(annotated(&problem(), &other_seed), with(1));
}

#[test]
fn a_search_that_is_stopped_says_so() {
    let done = AtomicUsize::new(0);
    let count = || _ = done.fetch_add(1, Ordering::Relaxed);
    let found = annotate_ik(&problem(), &SETTINGS, &count, &AtomicBool::new(true)).expect("a good problem");
    assert_eq!(done.load(Ordering::Relaxed), found.len());
    for annotation in [&found[0], &found[3], &found[4], &found[5]] {
        assert_eq!((&annotation.status, annotation.attempts), (&IkStatus::Stopped, 0));
        assert!(annotation.solutions.is_empty());
    }
}

#[test]
fn no_attempts_find_nothing_and_are_not_an_error() {
    let none = IkAnnotationSettings { attempts: 0, ..SETTINGS };
    let found = annotated(&problem(), &none);
    assert_eq!(found[0].status, IkStatus::NoSolution { blocked: 0, contact: None });
}

#[test]
fn only_grasps_under_the_exact_criterion_are_annotated() {
    let configurations = problem()
        .with_goal(cranny_task::Goal::Configurations(vec![START.to_vec()]))
        .expect("a configuration of the arm");
    let released = paper(&arm(), Vec::new(), &START, grasps(easy_grasps()));
    for refused in [configurations, released] {
        let refused = annotate_ik(&refused, &SETTINGS, &|| (), &AtomicBool::new(false));
        assert!(matches!(refused, Err(TaskError::Annotation)));
    }
    let empty = exact(&arm(), still_life(), &START, grasps(Vec::new()));
    assert!(annotated(&empty, &SETTINGS).is_empty());
}
