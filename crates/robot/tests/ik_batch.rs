//! Attempts of inverse kinematics that run in parallel.

use cranny_robot::{IK_BATCH, IkBatch, IkSettings, IkSolution, Robot};
use cranny_spatial::{Pose, PoseDifference, Stream};
use proptest::prelude::*;

fn tip_at(robot: &Robot, q: &[f64]) -> Pose {
    let frames = robot.frames_at(q);
    *frames.link(robot.tip())
}

/// Returns a target for each attempt, and its solution.
fn solve(robot: &Robot, seed: u64) -> Vec<(Pose, Option<IkSolution>)> {
    let mut random = Stream::new(seed, 0);
    let mut batch = IkBatch::new(robot, IkSettings::default());
    let mut targets = Vec::new();
    for attempt in 0..IK_BATCH {
        let parts: Vec<f64> = (0..robot.dof()).map(|_| random.uniform()).collect();
        targets.push(tip_at(robot, &crate::fixture::within_limits(robot, &parts)));
        batch.draw(attempt, &targets[attempt], &mut random);
    }
    batch.run(IK_BATCH);
    targets.into_iter().enumerate().map(|(attempt, target)| (target, batch.solution(attempt))).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn each_solution_reaches_its_own_target(seed in 0u64..100_000) {
        let robot = crate::fixture::mobile_arm();
        let settings = IkSettings::default();
        let found = solve(&robot, seed);
        for (target, solution) in &found {
            let Some(solution) = solution else { continue };
            prop_assert!(robot.within_limits(&solution.q));
            let difference = PoseDifference::between(&tip_at(&robot, &solution.q), target);
            prop_assert!(difference.translation_m <= settings.translation_tolerance_m);
            prop_assert!(difference.rotation_rad <= settings.rotation_tolerance_rad);
            prop_assert!((difference.translation_m - solution.translation_error_m).abs() < 1e-12);
            prop_assert!((difference.rotation_rad - solution.rotation_error_rad).abs() < 1e-12);
        }
        prop_assert_eq!(found, solve(&robot, seed));
    }
}

#[test]
fn tighter_tolerances_than_single_precision_are_met_too() {
    let robot = crate::fixture::mobile_arm();
    let settings =
        IkSettings { translation_tolerance_m: 1e-9, rotation_tolerance_rad: 1e-9, ..IkSettings::default() };
    let mut batch = IkBatch::new(&robot, settings);
    let mut random = Stream::new(2, 0);
    let target = tip_at(&robot, &crate::fixture::HOME);
    let found: Vec<IkSolution> = (0..20)
        .flat_map(|_| {
            (0..IK_BATCH).for_each(|attempt| batch.draw(attempt, &target, &mut random));
            batch.run(IK_BATCH);
            (0..IK_BATCH).filter_map(|attempt| batch.solution(attempt)).collect::<Vec<_>>()
        })
        .collect();
    assert!(found.iter().all(|found| found.translation_error_m <= 1e-9 && found.rotation_error_rad <= 1e-9));
    assert!(found.len() >= 160, "{} of 320", found.len());
}

#[test]
fn a_target_that_is_no_number_or_out_of_reach_has_no_solution() {
    let robot = crate::fixture::mobile_arm();
    let mut batch = IkBatch::new(&robot, IkSettings::default());
    let mut random = Stream::new(2, 0);
    for shift in [f64::NAN, f64::INFINITY, 5.0] {
        let mut target = tip_at(&robot, &crate::fixture::HOME);
        target.translation.vector.x += shift;
        (0..IK_BATCH).for_each(|attempt| batch.draw(attempt, &target, &mut random));
        batch.run(IK_BATCH);
        assert!((0..IK_BATCH).all(|attempt| batch.solution(attempt).is_none()));
    }
}

#[test]
#[should_panic(expected = "no more attempts than lanes")]
fn more_attempts_than_lanes_are_refused() {
    IkBatch::new(&crate::fixture::mobile_arm(), IkSettings::default()).run(IK_BATCH + 1);
}
