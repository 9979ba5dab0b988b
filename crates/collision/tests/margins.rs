//! Tests of the clearances that are demanded of different collision pairs.

use crate::fixture::{arm, ball, block, cell, hand, link};
use cranny_collision::{Body, Cell, Collider, Margins, Part, World};
use cranny_shape::Solid;
use cranny_spatial::{CONTACT_M, Pose};
use cranny_test_robots::BALL_RADIUS_M;

#[test]
fn a_link_nearer_than_the_margin_is_not_free() {
    let cell = cell(&ball(), vec![Body::floor(0.0)], 0.02);
    let mut scratch = cell.scratch();
    assert!(cell.is_free(&[0.0, 0.0, BALL_RADIUS_M + 0.0201], &mut scratch));
    let near = [0.0, 0.0, BALL_RADIUS_M + 0.0199];
    assert!(!cell.is_free(&near, &mut scratch));
    let contact = cell.first_contact(&near, &mut scratch).expect("too near");
    assert!((contact.clearance_m - 0.0199).abs() < 1e-9);
    assert!((contact.required_m - 0.02).abs() < 1e-15);
    assert!(contact.depth_m <= 0.0);
    assert_eq!((cell.name(contact.first), cell.name(contact.second)), ("ball", "floor"));
}

#[test]
fn without_a_margin_ten_micrometres_count_as_contact() {
    let cell = cell(&ball(), vec![Body::floor(0.0)], 0.0);
    let mut scratch = cell.scratch();
    assert!(cell.is_free(&[0.0, 0.0, BALL_RADIUS_M + 1.01 * CONTACT_M], &mut scratch));
    assert!(!cell.is_free(&[0.0, 0.0, BALL_RADIUS_M + 0.99 * CONTACT_M], &mut scratch));
}

#[test]
fn the_margin_holds_between_links_too() {
    let robot = arm();
    let q = [0.0, 0.0, 2.0, 0.0];
    let loose = cell(&robot, Vec::new(), 0.0);
    let clearance_m = loose.clearance(&q, &mut loose.scratch());
    assert!(clearance_m > 0.01);
    let tight = cell(&robot, Vec::new(), clearance_m + 1e-4);
    assert!(!tight.is_free(&q, &mut tight.scratch()));
    let enough = cell(&robot, Vec::new(), clearance_m - 1e-4);
    assert!(enough.is_free(&q, &mut enough.scratch()));
}

/// Returns a floor, a table on it, the object on the table, and a wall that the object leans on.
fn still_life() -> World {
    let bodies = vec![
        Body::floor(0.0),
        block("table", [0.6, 0.0, 0.1], [0.2, 0.2, 0.1]),
        block("object", [0.6, 0.0, 0.25], [0.05, 0.05, 0.05]),
        block("wall", [0.75, 0.0, 0.5], [0.1, 0.2, 0.5]),
    ];
    World::new(bodies).expect("good poses")
}

#[test]
fn the_grasp_margin_holds_between_the_hand_and_what_it_grasps_only() {
    let (robot, world) = (arm(), still_life());
    let target = world.body_index("object").expect("it is there");
    let table = world.body_index("table").expect("it is there");
    // Both margins exceed every distance, so that every pair is listed with its demanded clearance.
    let margins = Margins { margin_m: 10.0, grasp_margin_m: 9.0, ..Margins::default() };
    let cell = Cell::for_grasp(robot.clone(), world.clone(), target, margins).expect("good margins");
    assert_eq!(robot.hand_links(), hand(&robot));
    let contacts = cell.contacts(&[0.0; 4], &mut cell.scratch());
    let moving = ["cart", "upper", "lower", "palm", "left_finger", "right_finger"];
    assert_eq!(contacts.len(), moving.len() * world.bodies().len() + cell.self_pairs().len());
    for contact in contacts {
        let of_hand = matches!(contact.first, Collider::Link(link) if hand(&robot).contains(&link));
        let of_target = [Collider::Body(target), Collider::Body(table)].contains(&contact.second);
        let expected_m = if of_hand && of_target { 9.0 } else { 10.0 };
        assert!((contact.required_m - expected_m).abs() < 1e-12, "{contact:?}");
    }
}

#[test]
fn a_grasp_margin_above_the_other_is_demanded_as_well() {
    let (robot, bodies) = (ball(), vec![block("object", [0.0; 3], [0.1; 3])]);
    let world = World::new(bodies).expect("good poses");
    let margins = Margins { grasp_margin_m: 0.03, ..Margins::default() };
    assert_eq!(robot.hand_links(), [link(&robot, "ball")]);
    let cell = Cell::for_grasp(robot, world, 0, margins).expect("good margins");
    let mut scratch = cell.scratch();
    assert!(!cell.is_free(&[0.0, 0.0, 0.1 + BALL_RADIUS_M + 0.029], &mut scratch));
    assert!(cell.is_free(&[0.0, 0.0, 0.1 + BALL_RADIUS_M + 0.031], &mut scratch));
}

fn supports(bodies: Vec<Body>) -> Vec<String> {
    let world = World::new(bodies).expect("good poses");
    world.supports_of(0).into_iter().map(|body| world.bodies()[body].name.clone()).collect()
}

#[test]
fn an_object_rests_on_the_table_and_not_on_floor_or_wall() {
    let world = still_life();
    assert_eq!(world.supports_of(2), [1]);
    assert_eq!(world.supports_of(1), [0]);
}

#[test]
fn an_object_rests_on_what_is_below_it_within_a_centimetre() {
    for (height_m, rests) in [(-0.005, true), (0.0, true), (0.005, true), (0.02, false)] {
        let object = || block("object", [0.0, 0.0, height_m + 0.05], [0.05; 3]);
        let expected = |name: &str| if rests { vec![name.to_owned()] } else { Vec::new() };
        assert_eq!(supports(vec![object(), Body::floor(0.0)]), expected("floor"), "{height_m}");
        let slab = block("slab", [0.0, 0.0, -0.1], [1.0, 1.0, 0.1]);
        assert_eq!(supports(vec![object(), slab]), expected("slab"), "{height_m}");
    }
}

#[test]
fn a_table_of_three_parts_supports_what_stands_on_it_and_on_the_floor_below_it() {
    let mut table = block("table", [0.0, 0.0, 0.45], [0.5, 0.4, 0.05]);
    for side in [-0.45, 0.45] {
        let solid = Solid::cuboid([0.05, 0.4, 0.2].into()).expect("a positive size");
        table.parts.push(Part { world_from_solid: Pose::translation(side, 0.0, 0.2), solid });
    }
    let above = block("object", [0.0, 0.0, 0.55], [0.05; 3]);
    assert_eq!(supports(vec![above, table.clone(), Body::floor(0.0)]), ["table"]);
    let below = block("object", [0.0, 0.0, 0.05], [0.05; 3]);
    assert_eq!(supports(vec![below, table, Body::floor(0.0)]), ["floor"]);
}

#[test]
fn what_stands_beside_an_object_does_not_support_it() {
    let object = || block("object", [0.0, 0.0, 0.05], [0.05; 3]);
    let curb = block("curb", [0.061, 0.0, 0.01], [0.01; 3]);
    assert_eq!(supports(vec![object(), curb, Body::floor(0.0)]), ["floor"]);
}

#[test]
fn what_hangs_above_an_object_does_not_support_it() {
    let object = block("object", [0.0, 0.0, 0.5], [0.05; 3]);
    assert!(supports(vec![object, block("lid", [0.0, 0.0, 0.65], [0.1; 3])]).is_empty());
}
