//! Closest points lie on the solids, and are as far apart as these.

use cranny_shape::{Solid, TriangleSoup, closest_points, separation};
use cranny_spatial::{Point, Pose, Stream, Vector};
use proptest::prelude::*;

/// Agreement of the iteration on curved faces with the certificate, in metres.
const CLOSE_M: f64 = 2e-5;

fn random_pose(random: &mut Stream) -> Pose {
    let mut draw = || random.uniform_between(-0.5, 0.5);
    let translation = Vector::new(draw(), draw(), draw());
    Pose::from_parts(translation.into(), random.rotation())
}

/// Random solid of a random kind.
fn random_solid(random: &mut Stream) -> Solid {
    let mut size = || random.uniform_between(0.05, 0.2);
    let (a, b, c) = (size(), size(), size());
    let points: Vec<Point> = (0..12).map(|_| Point::from(random.rotation() * Vector::z() * a)).collect();
    match random.index(7) {
        0 => Solid::cuboid(Vector::new(a, b, c)).unwrap(),
        1 => Solid::sphere(a).unwrap(),
        2 => Solid::capsule(b, a).unwrap(),
        3 => Solid::cylinder(b, a).unwrap(),
        4 => Solid::hull(&points).unwrap(),
        5 => Solid::mesh(&TriangleSoup::convex_hull(&points).unwrap()).unwrap(),
        _ => Solid::half_space(),
    }
}

/// Distance of a point from a solid, in metres, by a ball around it.
fn distance_of(point: &Point, solid: &Solid, pose: &Pose) -> f64 {
    const RADIUS_M: f64 = 1e-6;
    let ball = Solid::sphere(RADIUS_M).unwrap();
    separation(&ball, &Pose::translation(point.x, point.y, point.z), solid, pose, f64::MAX).lower_m
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_points_lie_on_the_solids_and_are_as_far_apart_as_these(seed in any::<u64>()) {
        let mut random = Stream::new(seed, 0);
        let (a, b) = (random_solid(&mut random), random_solid(&mut random));
        let (pose_a, pose_b) = (random_pose(&mut random), random_pose(&mut random));
        let gap = separation(&a, &pose_a, &b, &pose_b, f64::MAX);
        match closest_points(&a, &pose_a, &b, &pose_b) {
            None => prop_assert!(gap.lower_m <= 1e-9, "{gap:?}"),
            Some([on_a, on_b]) => {
                prop_assert!(((on_b - on_a).norm() - gap.lower_m).abs() < CLOSE_M, "{gap:?} {on_a} {on_b}");
                prop_assert!(distance_of(&on_a, &a, &pose_a) < CLOSE_M);
                prop_assert!(distance_of(&on_b, &b, &pose_b) < CLOSE_M);
            }
        }
    }

    #[test]
    fn the_order_of_the_two_does_not_matter(seed in any::<u64>()) {
        let mut random = Stream::new(seed, 1);
        let (a, b) = (random_solid(&mut random), random_solid(&mut random));
        let (pose_a, pose_b) = (random_pose(&mut random), random_pose(&mut random));
        let one = closest_points(&a, &pose_a, &b, &pose_b);
        let other = closest_points(&b, &pose_b, &a, &pose_a);
        prop_assert_eq!(one.is_some(), other.is_some());
        if let (Some([a, b]), Some([c, d])) = (one, other) {
            prop_assert!(((b - a).norm() - (d - c).norm()).abs() < CLOSE_M);
        }
    }
}

#[test]
fn a_sphere_above_a_floor_points_straight_down() {
    let (sphere, floor) = (Solid::sphere(0.1).unwrap(), Solid::half_space());
    let at = Pose::translation(0.3, -0.2, 0.5);
    let [on_sphere, on_floor] = closest_points(&sphere, &at, &floor, &Pose::identity()).unwrap();
    assert!((on_sphere - Point::new(0.3, -0.2, 0.4)).norm() < 1e-12);
    assert!((on_floor - Point::new(0.3, -0.2, 0.0)).norm() < 1e-12);
    assert_eq!(closest_points(&sphere, &Pose::identity(), &floor, &Pose::identity()), None);
    assert_eq!(closest_points(&floor, &Pose::identity(), &floor, &at), None);
}
