//! Hulls of many points take less than seconds, and contain all of them.

use cranny_shape::{MOST_HULL_CORNERS, Solid, TriangleSoup, separation};
use cranny_spatial::{Point, Pose, Rotation, Stream, Vector};

/// Asserts that none of some hundred of the points is outside.
fn holds_all(hull: &Solid, points: &[Point]) {
    let speck = Solid::sphere(1e-9).unwrap();
    for point in points.iter().step_by(1 + points.len() / 500) {
        let there = Pose::from_parts(point.coords.into(), Rotation::identity());
        let gap = separation(&speck, &there, hull, &Pose::identity(), f64::MAX);
        assert!(gap.lower_m <= 0.0, "{point} is {} m outside", gap.lower_m);
    }
}

#[test]
fn a_hull_of_more_corners_than_can_be_kept_is_rounded_around_them() {
    let sphere = TriangleSoup::geodesic_sphere(0.1, 6).vertices;
    assert!(sphere.len() > 2 * MOST_HULL_CORNERS);
    let hull = Solid::hull(&sphere).unwrap();
    let (corners, radius_m) = hull.bounding_points().unwrap();
    // Otherwise a distance to the hull would take as long as to all forty thousand.
    assert!(corners.len() < 2500, "{}", corners.len());
    assert!(radius_m > 0.0 && radius_m < 3e-4, "{radius_m}");
    holds_all(&hull, &sphere);
}

#[test]
fn points_inside_cost_a_hull_nothing_and_change_nothing() {
    let mut random = Stream::new(4, 0);
    let mut draw = || Vector::new(random.normal(), random.normal(), random.normal());
    let outside: Vec<Point> = (0..300).map(|_| (draw().normalize() * 0.1).into()).collect();
    let inside = (0..60_000).map(|_| Point::from(draw().normalize() * 0.08));
    let all: Vec<Point> = outside.iter().copied().chain(inside).collect();
    let (hull, expected) = (Solid::hull(&all).unwrap(), Solid::hull(&outside).unwrap());
    assert!(hull.bounding_points().unwrap().1 <= 0.0);
    holds_all(&hull, &all);
    let sorted = |solid: &Solid| {
        let mut points = solid.bounding_points().unwrap().0;
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        points
    };
    assert_eq!(sorted(&hull), sorted(&expected));
    let mesh = TriangleSoup::convex_hull(&all).unwrap();
    assert_eq!(mesh.vertices.len(), 300);
}

#[test]
fn a_plate_of_many_points_is_no_hull() {
    let plate: Vec<Point> =
        (0..40_000).map(|i| Point::new(f64::from(i % 200) * 1e-3, f64::from(i / 200) * 1e-3, 0.0)).collect();
    assert!(Solid::hull(&plate).is_err());
}
