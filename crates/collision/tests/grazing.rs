//! Tests that verdicts are correct for motions that pass a body at about the contact distance.

use crate::fixture::ball;
use cranny_collision::{Body, Cell, Margins, Motion, World};
use cranny_shape::{Solid, Surface};
use cranny_spatial::{CONTACT_M, Pose, Stream, Vector};
use cranny_test_robots::BALL_RADIUS_M;

/// Creates a solid of a random kind whose upper side is the plane z = 0 about the origin.
fn plate(random: &mut Stream) -> Solid {
    let half = Vector::new(random.uniform_between(0.1, 0.5), random.uniform_between(0.1, 0.5), 0.02);
    let soup = Surface::cuboid_soup(&half);
    match random.index(4) {
        0 => Solid::cuboid(half),
        1 => Solid::hull(&soup.vertices),
        2 => Solid::mesh(&soup),
        _ => Solid::cylinder(0.02, half.x),
    }
    .expect("a size")
}

/// Checks that unresolved edges are close to contact: once, 16 of 189 were clear by more than 15 µm, and the named pairs were
/// up to 42 µm apart.
#[test]
fn a_motion_past_a_plate_is_called_what_it_is() {
    let mut random = Stream::new(14, 0);
    let robot = ball();
    let (mut unresolved, mut contacts, mut proven) = (0, 0, 0);
    for _ in 0..500 {
        let gap_m = random.uniform_between(-CONTACT_M, 3.0 * CONTACT_M);
        // A plate in a random orientation; the ball passes over it, parallel to its upper side.
        let attitude = random.rotation();
        let up = attitude * Vector::z();
        let body = Body::new("plate", Pose::from_parts((up * -0.02).into(), attitude), plate(&mut random));
        let world = World::new(vec![body]).expect("a good pose");
        let cell = Cell::new(robot.clone(), world, Margins::default()).expect("no margin");
        let along =
            attitude * Vector::new(random.uniform_between(-1.0, 1.0), random.uniform_between(-1.0, 1.0), 0.0);
        let middle = up * (BALL_RADIUS_M + gap_m);
        let [a, b] =
            [-1.0, 1.0].map(|side| (middle + along * (side * 0.05)).iter().copied().collect::<Vec<_>>());
        match cell.motion_is_free(&a, &b, &mut cell.scratch()) {
            Motion::Proven => {
                proven += 1;
                assert!(gap_m >= CONTACT_M - 1e-8, "proven at {gap_m} m");
            }
            Motion::Contact { contact, .. } => {
                contacts += 1;
                assert!(gap_m <= CONTACT_M + 1e-6, "{contact:?} at {gap_m} m");
                assert!(contact.depth_m <= (-gap_m).max(0.0) + 1e-6, "{contact:?} at {gap_m} m");
            }
            Motion::Unresolved { contact, .. } => {
                unresolved += 1;
                assert!(gap_m <= 1.5 * CONTACT_M, "{contact:?} at {gap_m} m");
            }
            Motion::OutOfLimits { joint } => panic!("joint {joint}"),
            Motion::OutOfBounds { .. } => panic!("nothing is bounded"),
        }
        let q: Vec<f64> = middle.iter().copied().collect();
        let mut scratch = cell.scratch();
        assert_eq!(cell.is_free(&q, &mut scratch), cell.first_contact(&q, &mut scratch).is_none());
        assert!(
            cell.is_free(&q, &mut scratch) == (gap_m >= CONTACT_M) || (gap_m - CONTACT_M).abs() < 1e-7,
            "{gap_m}"
        );
    }
    assert!(proven > 100 && contacts > 100, "{proven} {contacts} {unresolved}");
}
