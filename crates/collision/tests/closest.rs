//! Tests of the closest pair: its distance is the clearance, its points are that far apart, its depth is the greatest.

use crate::fixture::{arm, cell, random_blocks};
use cranny_collision::{Body, Collider};
use cranny_spatial::{CONTACT_M, Stream};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn it_agrees_with_clearance_and_contacts(seed in any::<u64>()) {
        let (robot, mut random) = (arm(), Stream::new(seed, 0));
        let mut bodies = random_blocks(3, &mut random);
        bodies.push(Body::floor(-0.06));
        let cell = cell(&robot, bodies, 0.0);
        let mut scratch = cell.scratch();
        let q = robot.random_configuration(&mut random);
        let closest = cell.closest(&q, &mut scratch).expect("there are pairs");
        let clearance_m = cell.clearance(&q, &mut scratch);
        let contacts = cell.contacts(&q, &mut scratch);
        let [a, b] = closest.points.expect("apart or overlapping");
        let apart_m = (b - a).norm();
        if clearance_m > 0.0 {
            prop_assert!((closest.distance_m - clearance_m).abs() < 1e-12, "{closest:?} {clearance_m}");
            prop_assert!((apart_m - clearance_m).abs() < 10.0 * CONTACT_M, "{closest:?} {clearance_m}");
        } else {
            let deepest_m = contacts.iter().map(|contact| contact.depth_m).fold(0.0, f64::max);
            prop_assert!((closest.distance_m + deepest_m).abs() < 1e-12, "{closest:?} {deepest_m}");
            let is_it = contacts.iter().any(|c| (c.first, c.second) == (closest.first, closest.second));
            prop_assert!(is_it && apart_m.abs() < 1e-12);
        }
        prop_assert!(matches!(closest.first, Collider::Link(_)));
    }
}

#[test]
fn a_robot_alone_in_nothing_has_only_itself() {
    let robot = arm();
    let cell = cell(&robot, Vec::new(), 0.0);
    let mut scratch = cell.scratch();
    let closest = cell.closest(&vec![0.0; robot.dof()], &mut scratch);
    let is_of_links = closest.is_none_or(|c| matches!(c.second, Collider::Link(_)));
    assert!(is_of_links);
    assert_eq!(closest.is_some(), !cell.self_pairs().is_empty());
}

#[test]
fn the_balls_of_each_link_contain_it() {
    let robot = arm();
    let cell = cell(&robot, Vec::new(), 0.0);
    let balls = cell.link_balls();
    assert_eq!(balls.len(), robot.links().len());
    for (link, balls) in robot.links().iter().zip(&balls) {
        for shape in &link.collisions {
            let (points, _) = shape.solid.bounding_points().expect("a solid with an end");
            for point in points {
                let at = shape.link_from_shape * point;
                assert!(
                    balls.iter().any(|ball| (at - ball.center).norm() <= ball.radius_m + 1e-6),
                    "{}",
                    link.name
                );
            }
        }
    }
}
