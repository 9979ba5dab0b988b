//! Tests of single configurations: all queries agree, and the distances are correct.

use crate::fixture::{arm, ball, block, cell, link, random_blocks};
use cranny_collision::{Body, Cell, Collider, Margins, World};
use cranny_shape::Solid;
use cranny_spatial::{CONTACT_M, Pose, Stream, Vector};
use cranny_test_robots::BALL_RADIUS_M;
use proptest::prelude::*;

fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(cases(1000))]

    #[test]
    fn free_clearance_and_contacts_agree(
        seed in any::<u64>(), margin_m in prop_oneof![Just(0.0), 0.0..0.05]
    ) {
        let (robot, mut random) = (arm(), Stream::new(seed, 0));
        let mut bodies = random_blocks(3, &mut random);
        bodies.push(Body::floor(-0.06));
        let cell = cell(&robot, bodies, margin_m);
        let mut scratch = cell.scratch();
        // Some values are slightly beyond the limits.
        let q: Vec<f64> = robot.random_configuration(&mut random).iter().map(|value| value * 1.05).collect();
        let is_clear = cell.is_clear(&q, &mut scratch);
        prop_assert_eq!(cell.is_free(&q, &mut scratch), is_clear && robot.within_limits(&q));
        let required = margin_m.max(CONTACT_M);
        let clearance = cell.clearance(&q, &mut scratch);
        let tolerance = CONTACT_M;
        let agrees =
            if is_clear { clearance > required - tolerance } else { clearance < required + tolerance };
        prop_assert!(agrees, "{clearance} {required}");
        let contacts = cell.contacts(&q, &mut scratch);
        prop_assert_eq!(contacts.is_empty(), is_clear);
        let least = contacts.iter().map(|contact| contact.clearance_m).fold(f64::INFINITY, f64::min);
        prop_assert!(is_clear || (least - clearance).abs() < tolerance, "{least} {clearance}");
        for contact in &contacts {
            prop_assert!(contact.clearance_m < required + tolerance && contact.depth_m >= 0.0);
            prop_assert!((contact.required_m - required).abs() < 1e-15);
            prop_assert!(contact.depth_m <= 0.0 || contact.clearance_m < tolerance);
        }
        let pairs: Vec<_> = contacts.iter().map(|contact| (contact.first, contact.second)).collect();
        prop_assert!(pairs.iter().enumerate().all(|(index, pair)| !pairs[..index].contains(pair)));
        match cell.first_contact(&q, &mut scratch) {
            Some(first) => prop_assert!(pairs.contains(&(first.first, first.second))),
            None => prop_assert!(is_clear),
        }
    }

    #[test]
    fn the_clearance_of_a_ball_follows_closed_formulas(
        q in prop::array::uniform3(-1.0..1.0), half in prop::array::uniform3(0.05..0.4), turn in -3.0..3.0
    ) {
        let (place, radius_m) = (Vector::new(0.5, -0.4, 0.3), 0.2);
        let world_from_block = Pose::new(Vector::new(-0.5, 0.3, 0.1), Vector::new(0.3, 0.4, 0.5) * turn);
        let bodies = vec![
            Body::floor(-0.8),
            Body::new("block", world_from_block, Solid::cuboid(half.into()).unwrap()),
            Body::new("globe", Pose::new(place, Vector::zeros()), Solid::sphere(radius_m).unwrap()),
        ];
        let cell = cell(&ball(), bodies, 0.0);
        let center = Vector::from(q);
        let in_block = world_from_block.inverse_transform_point(&center.into()).coords;
        let outside = (in_block.abs() - Vector::from(half)).sup(&Vector::zeros()).norm();
        let expected = (q[2] + 0.8).min(outside).min((center - place).norm() - radius_m) - BALL_RADIUS_M;
        let clearance = cell.clearance(&q, &mut cell.scratch());
        prop_assert!((clearance - expected.max(0.0)).abs() < 1e-6, "{clearance} {expected}");
        prop_assert!(clearance <= expected.max(0.0) + 1e-12);
    }

    #[test]
    fn the_hand_alone_touches_what_it_touches_on_the_arm(seed in any::<u64>(), grasp_margin_m in 0.0..0.03) {
        let (robot, mut random) = (arm(), Stream::new(seed, 0));
        let mut bodies = random_blocks(6, &mut random);
        bodies.push(Body::floor(0.26));
        let margins = Margins { margin_m: 0.01, grasp_margin_m, ..Margins::default() };
        let cell = Cell::for_grasp(robot.clone(), World::new(bodies).unwrap(), 0, margins).unwrap();
        let (mut scratch, mut frames) = (cell.scratch(), robot.frames());
        let q = robot.random_configuration(&mut random);
        robot.forward_kinematics(&q, &mut frames);
        let of_hand: Vec<_> = cell
            .contacts(&q, &mut scratch)
            .into_iter()
            .filter(|contact| {
                let is_rigid = |link| robot.ancestors(link) == robot.ancestors(robot.tip());
                let is_of_hand = matches!(contact.first, Collider::Link(link) if is_rigid(link));
                is_of_hand && matches!(contact.second, Collider::Body(_))
            })
            .map(|contact| (contact.first, contact.second))
            .collect();
        let world_from_tip = frames.link(robot.tip());
        let found = cell.hand_contact(world_from_tip, &mut scratch);
        prop_assert_eq!(cell.hand_is_free(world_from_tip, &mut scratch), of_hand.is_empty());
        prop_assert_eq!(found.is_some(), !of_hand.is_empty());
        prop_assert!(found.is_none_or(|found| of_hand.contains(&(found.first, found.second))));
    }
}

#[test]
fn a_ball_in_the_floor_is_as_deep_as_it_has_sunk() {
    let cell = cell(&ball(), vec![Body::floor(0.0)], 0.0);
    let contact = cell.first_contact(&[0.3, 0.2, 0.02], &mut cell.scratch()).expect("a contact");
    assert!((contact.depth_m - 0.03).abs() < 1e-9 && contact.clearance_m <= 0.0);
    assert!((contact.point.expect("an overlap") - Vector::new(0.3, 0.2, 0.0)).coords.norm() < 0.05);
}

#[test]
fn a_contact_with_two_parts_of_a_body_is_listed_once_with_the_greater_depth() {
    let mut step = block("step", [0.0, 0.0, -0.1], [1.0, 1.0, 0.1]);
    step.parts.extend(block("step", [0.0, 0.0, 0.0], [1.0, 1.0, 0.02]).parts);
    let cell = cell(&ball(), vec![step], 0.0);
    let contacts = cell.contacts(&[0.0, 0.0, 0.04], &mut cell.scratch());
    assert_eq!(contacts.len(), 1);
    assert!((contacts[0].depth_m - 0.03).abs() < 1e-6, "{contacts:?}");
}

#[test]
fn with_nothing_to_touch_the_clearance_is_infinite() {
    let cell = cell(&ball(), Vec::new(), 0.0);
    assert!(cell.clearance(&[0.0; 3], &mut cell.scratch()).is_infinite());
    assert!(cell.first_contact(&[0.0; 3], &mut cell.scratch()).is_none());
}

#[test]
fn a_link_that_no_joint_moves_is_not_checked_against_the_world() {
    let (robot, around_rail) = (arm(), vec![block("sleeper", [0.9, 0.0, 0.0], [0.05; 3])]);
    let cell = cell(&robot, around_rail, 0.0);
    assert!(cell.is_free(&[-0.5, 0.0, 0.0, 0.0], &mut cell.scratch()));
    let contact = cell.first_contact(&[0.9, 0.0, 0.0, 0.0], &mut cell.scratch()).expect("the cart touches");
    assert_eq!(contact.first, Collider::Link(link(&robot, "cart")));
}
