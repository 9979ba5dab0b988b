//! Tests that malformed input is refused with a message that names it.

use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::fixture::{ball, block, cell};
use cranny_collision::{Body, Cell, CollisionError, Margins, Part, Scratch, World};
use cranny_shape::Solid;
use cranny_spatial::{FARTHEST_M, Pose, Vector};

fn at(x: f64) -> Pose {
    Pose::translation(x, 0.0, 0.0)
}

#[test]
fn a_pose_that_is_not_finite_or_too_far_away_is_refused_by_the_name_of_its_body() {
    let turned = Pose::new(Vector::zeros(), Vector::new(f64::NAN, 0.0, 0.0));
    let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, FARTHEST_M + 1.0, -FARTHEST_M - 1.0].map(at);
    for pose in bad.into_iter().chain([turned]) {
        let mut lamp = block("lamp", [0.0; 3], [0.1; 3]);
        lamp.parts.push(Part { world_from_solid: pose, solid: Solid::half_space() });
        let refused = World::new(vec![Body::floor(0.0), lamp]);
        let message = refused.as_ref().err().map(ToString::to_string).unwrap_or_default();
        assert!(matches!(refused, Err(CollisionError::Pose { name }) if name == "lamp"));
        assert!(message.contains("'lamp'"), "{message}");
    }
    assert!(World::new(vec![block("far", [FARTHEST_M, 0.0, 0.0], [0.1; 3])]).is_ok());
}

#[test]
fn a_margin_that_is_negative_or_not_finite_is_refused() {
    for value in [-1e-9, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let margins = [
            Margins { margin_m: value, ..Margins::default() },
            Margins { grasp_margin_m: value, ..Margins::default() },
        ];
        for margins in margins {
            let refused = Cell::new(ball(), World::default(), margins);
            let Err(CollisionError::Margin { value: named }) = refused else { panic!("{value} is refused") };
            assert_eq!(named.to_bits(), value.to_bits());
        }
    }
}

#[test]
fn an_unknown_body_is_refused_with_the_names_that_there_are() {
    let world = World::new(vec![Body::floor(0.0), block("table", [0.0; 3], [0.1; 3])]).expect("good poses");
    assert_eq!(world.body_index("table").ok(), Some(1));
    let message = world.body_index("tabel").expect_err("there is none").to_string();
    assert!(message.contains("'tabel'") && message.contains("floor, table"), "{message}");
}

#[test]
fn a_configuration_of_the_wrong_length_panics() {
    let cell = cell(&ball(), vec![Body::floor(-1.0)], 0.0);
    let good = [0.0; 3];
    for bad in [&[][..], &[0.0; 2], &[0.0; 4]] {
        let panics = |ask: &dyn Fn(&mut Scratch)| {
            let mut scratch = cell.scratch();
            catch_unwind(AssertUnwindSafe(|| ask(&mut scratch))).is_err()
        };
        assert!(panics(&|scratch| _ = cell.is_free(bad, scratch)));
        assert!(panics(&|scratch| _ = cell.is_clear(bad, scratch)));
        assert!(panics(&|scratch| _ = cell.clearance(bad, scratch)));
        assert!(panics(&|scratch| _ = cell.contacts(bad, scratch)));
        assert!(panics(&|scratch| _ = cell.first_contact(bad, scratch)));
        for (a, b) in [(&good[..], bad), (bad, &good[..])] {
            assert!(panics(&|scratch| _ = cell.motion_is_free(a, b, scratch)));
            assert!(panics(&|scratch| _ = cell.least_clearance(a, b, scratch)));
        }
    }
}

#[test]
fn a_value_that_is_not_finite_is_never_free() {
    let cell = cell(&ball(), vec![Body::floor(-1.0), block("block", [0.0; 3], [0.1; 3])], 0.0);
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for joint in 0..3 {
            let mut q = [0.5; 3];
            q[joint] = value;
            assert!(!cell.is_free(&q, &mut cell.scratch()), "{q:?}");
        }
    }
}
