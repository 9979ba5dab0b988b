//! Tests of configurations that the released planners' check accepts and the exact one refuses.

use std::sync::Arc;

use crate::fixture::{FOLDED, arm, ball, block, cell, link};
use cranny_collision::{Body, Cell, ReleasedCheck, World};
use cranny_robot::Robot;
use cranny_shape::Solid;
use cranny_spatial::{Pose, Vector};

fn both(robot: &Arc<Robot>, bodies: Vec<Body>) -> (ReleasedCheck, Cell) {
    let surfaces = ReleasedCheck::surfaces_of(&World::new(bodies.clone()).expect("good poses"));
    let check = ReleasedCheck::new(robot.clone(), surfaces, Vec::new(), 0.0).expect("good triangles");
    (check, cell(robot, bodies, 0.0))
}

#[test]
fn a_link_wholly_inside_an_obstacle_passes_there_only() {
    let (check, cell) = both(&ball(), vec![block("block", [0.0; 3], [0.5; 3])]);
    assert!(check.is_free(&[0.0; 3], &mut check.scratch()));
    assert!(!cell.is_free(&[0.0; 3], &mut cell.scratch()));
    let through = [0.48, 0.0, 0.0];
    assert!(!check.is_free(&through, &mut check.scratch()));
    assert!(!cell.is_free(&through, &mut cell.scratch()));
}

#[test]
fn fingers_beside_the_chain_to_the_tip_are_not_checked() {
    let robot = arm();
    let frames = robot.frames_at(&[0.0; 4]);
    let finger = frames.link(link(&robot, "left_finger")).translation;
    let pebble = block("pebble", [finger.x, finger.y, finger.z], [0.02, 0.002, 0.002]);
    let (check, cell) = both(&robot, vec![pebble]);
    assert!(check.is_free(&[0.0; 4], &mut check.scratch()));
    let contacts = cell.contacts(&[0.0; 4], &mut cell.scratch());
    assert_eq!(contacts.iter().map(|contact| cell.name(contact.first)).collect::<Vec<_>>(), ["left_finger"]);
}

#[test]
fn self_collision_passes() {
    let (check, cell) = both(&arm(), Vec::new());
    assert!(check.is_free(&FOLDED, &mut check.scratch()));
    assert!(!cell.is_free(&FOLDED, &mut cell.scratch()));
}

#[test]
fn instead_of_a_floor_the_origins_of_some_links_stay_above_a_height() {
    let robot = ball();
    let tool = link(&robot, "ball");
    let check = ReleasedCheck::new(robot, Vec::new(), vec![tool], 0.04).expect("good triangles");
    let mut scratch = check.scratch();
    // The check uses the origin, not the ball around it.
    for (height_m, is_free) in [(0.041, true), (0.04, true), (0.039, false), (-1.0, false)] {
        assert_eq!(check.is_free(&[0.0, 0.0, height_m], &mut scratch), is_free, "{height_m}");
    }
}

#[test]
fn joint_limits_enter_but_not_where_frames_are_given() {
    let (check, _) = both(&ball(), Vec::new());
    let mut scratch = check.scratch();
    for value in [2.1, f64::NAN, f64::INFINITY] {
        assert!(!check.is_free(&[0.0, value, 0.0], &mut scratch));
    }
    let frames = check.robot().frames_at(&[0.0, 2.1, 0.0]);
    assert!(check.holds(&frames));
    assert!(check.is_free(&[0.0, 1.9, 0.0], &mut scratch));
    assert!((scratch.frames().link(check.robot().tip()).translation.y - 1.9).abs() < 1e-12);
}

#[test]
fn bodies_become_boxes_and_half_spaces_nothing() {
    let globe = Body::new("globe", Pose::translation(0.5, 0.0, 0.0), Solid::sphere(0.2).expect("a size"));
    let bodies = vec![Body::floor(0.0), block("block", [0.0; 3], [0.1, 0.2, 0.3]), globe];
    let surfaces = ReleasedCheck::surfaces_of(&World::new(bodies).expect("good poses"));
    let expected = [(0.0, Vector::new(0.1, 0.2, 0.3)), (0.5, Vector::repeat(0.2))];
    assert_eq!(surfaces.len(), expected.len());
    for ((pose, surface), (x, half_extents)) in surfaces.iter().zip(expected) {
        assert!((pose.translation.x - x).abs() < 1e-12);
        assert!((surface.aabb().half_extents - half_extents).norm() < 1e-12);
    }
}
