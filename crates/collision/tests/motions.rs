//! Tests of straight motions: verdicts, their symmetry, and the least distance along them.

use crate::fixture::{arm, ball, between, block, cell, random_blocks};
use cranny_collision::{Body, Motion};
use cranny_shape::Solid;
use cranny_spatial::{CONTACT_M, Pose, Stream, Vector};
use cranny_test_robots::BALL_RADIUS_M;
use proptest::prelude::*;

/// Maximum amount by which `least_clearance` is below the true distance, in metres.
const TOLERANCE_M: f64 = 1e-5;

fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() }
}

/// Returns the distance of `point` from the segment between `a` and `b`.
fn from_segment(point: &Vector, a: &Vector, b: &Vector) -> f64 {
    let along = b - a;
    let at = ((point - a).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
    (a + along * at - point).norm()
}

proptest! {
    #![proptest_config(cases(300))]

    #[test]
    fn a_motion_and_its_reverse_get_the_same_verdict(seed in any::<u64>(), margin_m in 0.0..0.03) {
        let (robot, mut random) = (arm(), Stream::new(seed, 0));
        let cell = cell(&robot, random_blocks(2, &mut random), margin_m);
        let mut scratch = cell.scratch();
        let (a, b) = (robot.random_configuration(&mut random), robot.random_configuration(&mut random));
        let there = cell.motion_is_free(&a, &b, &mut scratch);
        let back = cell.motion_is_free(&b, &a, &mut scratch);
        let kind = std::mem::discriminant::<Motion>;
        prop_assert_eq!(kind(&there), kind(&back), "{:?} {:?}", there, back);
        let least = cell.least_clearance(&a, &b, &mut scratch);
        let least_back = cell.least_clearance(&b, &a, &mut scratch);
        prop_assert!((least - least_back).abs() <= TOLERANCE_M, "{} {}", least, least_back);
    }

    /// Compares clearances of unproven paths too, so that every draw counts.
    #[test]
    fn the_clearance_of_a_path_is_the_least_of_its_edges(
        seed in any::<u64>(), margin_m in 0.0..0.03, share in 0.0..0.5,
    ) {
        let (robot, mut random) = (arm(), Stream::new(seed, 2));
        let blocks = random_blocks(2, &mut random);
        let cell = cell(&robot, blocks.clone(), if seed % 2 == 0 { 0.0 } else { margin_m });
        let mut scratch = cell.scratch();
        let path: Vec<Vec<f64>> = (0..4).map(|_| robot.random_configuration(&mut random)).collect();
        let edges = path.windows(2).map(|edge| cell.least_clearance(&edge[0], &edge[1], &mut scratch));
        let least_m = edges.fold(f64::INFINITY, f64::min);
        let found_m = cell.path_clearance(&path, share, &mut scratch);
        prop_assert!(found_m <= least_m + TOLERANCE_M + 1e-9, "{found_m} {least_m}");
        prop_assert!(found_m >= least_m * (1.0 - share) - 2.0 * TOLERANCE_M - 1e-9, "{found_m} {least_m}");
    }

    #[test]
    fn the_least_clearance_is_that_of_dense_samples(seed in any::<u64>()) {
        const SAMPLES: u32 = 1000;
        let (robot, mut random) = (arm(), Stream::new(seed, 1));
        let cell = cell(&robot, random_blocks(2, &mut random), 0.0);
        let mut scratch = cell.scratch();
        let (a, b) = (robot.random_configuration(&mut random), robot.random_configuration(&mut random));
        let least = cell.least_clearance(&a, &b, &mut scratch);
        let sampled = (0..=SAMPLES)
            .map(|i| cell.clearance(&between(&a, &b, f64::from(i) / f64::from(SAMPLES)), &mut scratch))
            .fold(f64::INFINITY, f64::min);
        // No point of the arm is farther than 0.8 m from any of its axes; two links may approach each other.
        let travel_m: f64 = 2.0 * a.iter().zip(&b).map(|(a, b)| (a - b).abs()).sum::<f64>();
        let sampling_m = travel_m * 0.5 / f64::from(SAMPLES);
        prop_assert!(least <= sampled + 1e-9, "{least} {sampled}");
        prop_assert!(least >= sampled - sampling_m - TOLERANCE_M - 1e-6, "{least} {sampled}");
    }

    #[test]
    fn the_least_clearance_of_a_passing_ball_follows_a_closed_formula(
        a in prop::array::uniform3(-1.0..1.0), b in prop::array::uniform3(-1.0..1.0)
    ) {
        let globe = Body::new("globe", Pose::identity(), Solid::sphere(0.1).unwrap());
        let cell = cell(&ball(), vec![globe, Body::floor(-0.9)], 0.0);
        let (from, to) = (Vector::from(a), Vector::from(b));
        let to_globe = from_segment(&Vector::zeros(), &from, &to) - 0.1 - BALL_RADIUS_M;
        let truth = to_globe.min(a[2].min(b[2]) + 0.9 - BALL_RADIUS_M).max(0.0);
        let least = cell.least_clearance(&a, &b, &mut cell.scratch());
        prop_assert!(least <= truth + 1e-9 && least >= truth - TOLERANCE_M - 1e-8, "{least} {truth}");
        let motion = cell.motion_is_free(&a, &b, &mut cell.scratch());
        prop_assert_eq!(motion.is_proven(), truth > CONTACT_M, "{:?} {}", motion, truth);
    }
}

#[test]
fn an_edge_of_no_length_is_as_free_as_its_point() {
    let cell = cell(&ball(), vec![Body::floor(0.0)], 0.0);
    let mut scratch = cell.scratch();
    let above = [0.1, 0.2, 0.3];
    assert!(cell.motion_is_free(&above, &above, &mut scratch).is_proven());
    assert!((cell.least_clearance(&above, &above, &mut scratch) - 0.25).abs() <= TOLERANCE_M + 1e-9);
    let within = [0.1, 0.2, 0.02];
    let motion = cell.motion_is_free(&within, &within, &mut scratch);
    assert!(matches!(motion, Motion::Contact { contact, .. } if (contact.depth_m - 0.03).abs() < 1e-9));
    assert!(cell.least_clearance(&within, &within, &mut scratch) <= 0.0);
}

#[test]
fn either_end_outside_its_limits_is_refused_by_the_name_of_the_joint() {
    let cell = cell(&ball(), Vec::new(), 0.0);
    let mut scratch = cell.scratch();
    let inside = [0.0; 3];
    for (joint, value) in [(0, 2.1), (1, -2.1), (2, f64::NAN), (0, f64::INFINITY), (1, f64::NEG_INFINITY)] {
        let mut outside = inside;
        outside[joint] = value;
        for (a, b) in [(&inside, &outside), (&outside, &inside), (&outside, &outside)] {
            assert_eq!(cell.motion_is_free(a, b, &mut scratch), Motion::OutOfLimits { joint });
        }
    }
    // The limits themselves are allowed.
    assert!(cell.motion_is_free(&[-2.0; 3], &[2.0; 3], &mut scratch).is_proven());
}

#[test]
fn a_margin_above_the_clearance_is_refused_and_one_below_it_is_proven() {
    let (a, b) = ([-0.5, 0.0, 0.2], [0.5, 0.0, 0.2]);
    let pass = |margin_m: f64| {
        let cell = cell(&ball(), vec![block("hurdle", [0.0; 3], [0.01, 0.5, 0.1])], margin_m);
        cell.motion_is_free(&a, &b, &mut cell.scratch())
    };
    let clearance_m = 0.2 - 0.1 - BALL_RADIUS_M;
    assert!(pass(0.0).is_proven());
    assert!(pass(clearance_m - 1e-4).is_proven());
    let Motion::Contact { at, contact } = pass(clearance_m + 1e-4) else { panic!("the margin is not kept") };
    assert!((at - 0.5).abs() < 0.02);
    assert!((contact.required_m - clearance_m - 1e-4).abs() < 1e-12);
    assert!((contact.clearance_m - clearance_m).abs() < 1e-4 && contact.depth_m <= 0.0);
}

#[test]
fn what_comes_within_a_hair_of_contact_is_neither_proven_nor_refuted() {
    let cell = cell(&ball(), vec![Body::floor(0.0)], 0.0);
    let height = BALL_RADIUS_M + CONTACT_M + 5e-8;
    let motion = cell.motion_is_free(&[0.0, 0.0, height], &[1e-3, 0.0, height], &mut cell.scratch());
    let Motion::Unresolved { at, contact } = motion else { panic!("{motion:?}") };
    assert!((0.0..=1.0).contains(&at));
    assert_eq!((cell.name(contact.first), cell.name(contact.second)), ("ball", "floor"));
    assert!((contact.clearance_m - CONTACT_M).abs() < 1e-6 && contact.depth_m <= 0.0);
}
