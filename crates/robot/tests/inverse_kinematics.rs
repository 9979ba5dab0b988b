//! Solutions reach their targets, are distinct and repeatable, and most reachable targets are reached.

use cranny_robot::{IkSearch, IkSearchSettings, IkSettings, IkSolver, Robot, solve_restarts};
use cranny_spatial::{Pose, PoseDifference, Stream};
use proptest::prelude::*;

fn tip_at(robot: &Robot, q: &[f64]) -> Pose {
    let frames = robot.frames_at(q);
    *frames.link(robot.tip())
}

fn random_target(robot: &Robot, random: &mut Stream) -> Pose {
    let parts: Vec<f64> = (0..robot.dof()).map(|_| random.uniform()).collect();
    tip_at(robot, &crate::fixture::within_limits(robot, &parts))
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_solution_reaches_its_target(parts in prop::collection::vec(0.0..1.0, 9), seed in 0u64..1000) {
        let robot = crate::fixture::mobile_arm();
        let settings = IkSearchSettings::default();
        let target = tip_at(&robot, &crate::fixture::within_limits(&robot, &parts));
        let mut search = IkSearch::new(&robot, &target, settings);
        let found = search.next_solution(&mut Stream::new(seed, 0), 200, &mut |_| true).cloned();
        let found = found.expect("a reachable target is reached from one of 200 starts");
        prop_assert!(robot.within_limits(&found.q));
        let difference = PoseDifference::between(&tip_at(&robot, &found.q), &target);
        prop_assert!(difference.translation_m <= settings.ik.translation_tolerance_m);
        prop_assert!(difference.rotation_rad <= settings.ik.rotation_tolerance_rad);
        prop_assert!((difference.translation_m - found.translation_error_m).abs() < 1e-12);
        prop_assert!((difference.rotation_rad - found.rotation_error_rad).abs() < 1e-12);
    }
}

#[test]
fn solutions_are_distinct_accepted_and_the_same_again() {
    let robot = crate::fixture::mobile_arm();
    let target = tip_at(&robot, &crate::fixture::HOME);
    let settings = IkSearchSettings::default();
    let solve = |seed| {
        let mut left_only = |q: &[f64]| q[0] < 0.0;
        solve_restarts(&robot, &target, &mut Stream::new(seed, 0), settings, 30, 500, &mut left_only)
    };
    let solutions = solve(3);
    assert_eq!(solutions.len(), 30);
    assert!(solutions.iter().all(|solution| solution.q[0] < 0.0));
    for (index, first) in solutions.iter().enumerate() {
        for second in &solutions[..index] {
            let differs = |(joint, (a, b)): (usize, (&f64, &f64))| {
                (a - b).abs() > if joint < 2 { settings.distinct_m } else { settings.distinct_rad }
            };
            assert!(first.q.iter().zip(&second.q).enumerate().any(differs));
        }
    }
    assert_eq!(solutions, solve(3));
    assert_ne!(solutions, solve(4));
}

#[test]
fn two_thirds_of_random_starts_succeed_within_ten_steps_on_average() {
    // Planners rely on these rates when they budget attempts.
    let robot = crate::fixture::mobile_arm();
    let mut random = Stream::new(11, 0);
    let (mut attempts, mut successes, mut iterations) = (0, 0, 0);
    for _ in 0..100 {
        let target = random_target(&robot, &mut random);
        let mut search = IkSearch::new(&robot, &target, IkSearchSettings::default());
        while search.attempts() < 20 {
            let found = search.next_solution(&mut random, 1, &mut |_| true).map(|found| found.iterations);
            attempts += 1;
            successes += usize::from(found.is_some());
            iterations += found.unwrap_or(0);
        }
    }
    eprintln!("{successes} of {attempts} attempts, {iterations} steps in them");
    assert!(3 * successes >= 2 * attempts, "{successes} of {attempts}");
    assert!(iterations <= 10 * successes, "{iterations} steps in {successes} successes");
}

#[test]
fn a_small_displacement_is_solved_near_the_start() {
    let robot = crate::fixture::mobile_arm();
    let mut solver = IkSolver::new(&robot, IkSettings::default());
    let mut random = Stream::new(5, 0);
    let home = tip_at(&robot, &crate::fixture::HOME);
    for _ in 0..100 {
        let mut nudge = || random.uniform_between(-0.03, 0.03);
        let (translation, rotation) = (
            cranny_spatial::Vector::new(nudge(), nudge(), nudge()),
            cranny_spatial::Vector::new(nudge(), nudge(), nudge()),
        );
        let target = home * Pose::new(translation, rotation);
        let found = solver.solve_from(&target, &crate::fixture::HOME).expect("a near target is reached");
        let farthest =
            found.q.iter().zip(&crate::fixture::HOME).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(farthest < 0.3, "{farthest}");
        let mut fresh = IkSolver::new(&robot, IkSettings::default());
        assert_eq!(fresh.solve_from(&target, &crate::fixture::HOME), Some(found));
    }
}

#[test]
fn the_pull_keeps_solutions_nearer_to_the_start() {
    let robot = crate::fixture::mobile_arm();
    let mut random = Stream::new(6, 0);
    let targets: Vec<Pose> = (0..200).map(|_| random_target(&robot, &mut random)).collect();
    let mean_distance = |pull| {
        let mut solver = IkSolver::new(&robot, IkSettings { pull, ..IkSettings::default() });
        let distances: Vec<f64> = targets
            .iter()
            .filter_map(|target| solver.solve_from(target, &crate::fixture::HOME))
            .map(|found| {
                found.q.iter().zip(&crate::fixture::HOME).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
            })
            .collect();
        eprintln!("pull {pull}: {} of {} targets", distances.len(), targets.len());
        distances.iter().sum::<f64>() / distances.len() as f64
    };
    let (free, pulled) = (mean_distance(0.0), mean_distance(IkSettings::default().pull));
    assert!(pulled < free, "{pulled} {free}");
}

#[test]
fn a_target_out_of_reach_has_no_solution() {
    let robot = crate::fixture::mobile_arm();
    let mut target = tip_at(&robot, &crate::fixture::HOME);
    target.translation.vector.x += 5.0;
    let mut search = IkSearch::new(&robot, &target, IkSearchSettings::default());
    assert!(search.next_solution(&mut Stream::new(1, 0), 100, &mut |_| true).is_none());
    assert_eq!(search.attempts(), 100);
    // A target that is not a number has no solution either.
    target.translation.vector.y = f64::NAN;
    let mut search = IkSearch::new(&robot, &target, IkSearchSettings::default());
    assert!(search.next_solution(&mut Stream::new(1, 0), 100, &mut |_| true).is_none());
    assert!(search.next_from(&crate::fixture::HOME, &mut |_| true).is_none());
}

#[test]
fn an_arm_with_few_joints_is_solved_too() {
    // Two joints cannot reach an arbitrary pose, but they can reach one of their own.
    let robot = crate::fixture::mimic();
    let target = tip_at(&robot, &[0.4, -0.2]);
    let mut search = IkSearch::new(&robot, &target, IkSearchSettings::default());
    let found = search.next_solution(&mut Stream::new(1, 0), 200, &mut |_| true).expect("solvable");
    assert!((found.q[1] + 0.2).abs() < 1e-2, "{:?}", found.q);
}
