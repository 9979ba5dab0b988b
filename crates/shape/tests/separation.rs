//! Distances against oracles other than GJK: closed formulas, samples of the surface, and other descriptions of the same solid.

use cranny_shape::{
    Range, Solid, Surface, TriangleSoup, overlap, quick_lower_bound, reaches, separation, separation_in,
};
use cranny_spatial::{Point, Pose, Stream, Vector};
use proptest::prelude::*;

const FAR: f64 = f64::MAX;

fn random_pose(random: &mut Stream, spread: f64) -> Pose {
    let mut draw = || random.uniform_between(-spread, spread);
    let translation = Vector::new(draw(), draw(), draw());
    Pose::from_parts(translation.into(), random.rotation())
}

fn cuboid_corners(half: &Vector) -> Vec<Point> {
    Surface::cuboid_soup(half).vertices
}

/// Random solid of a random kind, with points on its surface (within 4 mm of any surface point).
fn random_solid(random: &mut Stream) -> (Solid, Vec<Point>) {
    let mut size = || random.uniform_between(0.05, 0.2);
    let (a, b, c) = (size(), size(), size());
    let turn = std::f64::consts::TAU;
    match random.index(5) {
        0 => {
            let half = Vector::new(a, b, c);
            let grid = |f: &dyn Fn(f64, f64) -> Vector| -> Vec<Point> {
                let steps = (0..=60).map(|i| f64::from(i) / 30.0 - 1.0);
                steps
                    .clone()
                    .flat_map(|u| steps.clone().map(move |v| (u, v)))
                    .map(|(u, v)| f(u, v).component_mul(&half).into())
                    .collect()
            };
            let mut points = Vec::new();
            for s in [-1.0, 1.0] {
                points.extend(grid(&|u, v| Vector::new(s, u, v)));
                points.extend(grid(&|u, v| Vector::new(u, s, v)));
                points.extend(grid(&|u, v| Vector::new(u, v, s)));
            }
            (Solid::cuboid(half).unwrap(), points)
        }
        1 => {
            let points = (0..8000).map(|_| Point::from(random.rotation() * Vector::z() * a)).collect();
            (Solid::sphere(a).unwrap(), points)
        }
        2 => {
            let points = (0..12000).map(|_| {
                let direction = random.rotation() * Vector::z() * a;
                let z = if random.uniform() < 0.5 {
                    random.uniform_between(-b, b)
                } else {
                    b.copysign(direction.z)
                };
                if z.abs() < b {
                    let flat = Vector::new(direction.x, direction.y, 0.0).normalize() * a;
                    Point::new(flat.x, flat.y, z)
                } else {
                    Point::from(direction + Vector::z() * z)
                }
            });
            (Solid::capsule(b, a).unwrap(), points.collect())
        }
        3 => {
            let points = (0..12000).map(|_| {
                let (sin, cos) = cranny_spatial::sin_cos(random.uniform() * turn);
                let (r, z) = if random.uniform() < 0.5 {
                    (a, random.uniform_between(-b, b))
                } else {
                    (a * random.uniform().sqrt(), b.copysign(random.uniform() - 0.5))
                };
                Point::new(r * cos, r * sin, z)
            });
            (Solid::cylinder(b, a).unwrap(), points.collect())
        }
        _ => {
            // A mesh that is not convex: two boxes, one beside the other.
            let (p, q) = (Vector::new(a, b, c), Vector::new(b, 0.05, a));
            let mut corners = Vec::new();
            for (half, shift) in [(p, Vector::zeros()), (q, Vector::new(a + b, 0.0, 0.0))] {
                let soup = Surface::cuboid_soup(&half);
                corners.extend((0..12).flat_map(|t| soup.corners(t)).map(|x| x + shift));
            }
            let soup = TriangleSoup::from_corners(corners).unwrap();
            let points = (0..30_000).map(|_| {
                let [x, y, z] = soup.corners(random.index(24));
                let (mut u, mut v) = (random.uniform(), random.uniform());
                if u + v > 1.0 {
                    (u, v) = (1.0 - u, 1.0 - v);
                }
                x + (y - x) * u + (z - x) * v
            });
            let points = points.collect();
            (Solid::mesh(&soup).unwrap(), points)
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..Default::default() })]

    #[test]
    fn bounds_enclose_the_distance_of_sampled_surfaces(seed in any::<u64>()) {
        let mut random = Stream::new(seed, 0);
        let ((a, points), (b, others)) = (random_solid(&mut random), random_solid(&mut random));
        let (pose_a, pose_b) = (random_pose(&mut random, 0.3), random_pose(&mut random, 0.3));
        let found = separation(&a, &pose_a, &b, &pose_b, FAR);
        prop_assert!(found.lower_m <= found.upper_m + 1e-12);
        prop_assert!(found.upper_m - found.lower_m < cranny_spatial::CONTACT_M, "{found:?}");
        prop_assert!(quick_lower_bound(&a, &pose_a, &b, &pose_b, FAR) <= found.upper_m + 1e-12);
        // Distances of the other solid's points to this one are simple, and never below the true distance.
        let probe = Solid::sphere(1e-9).unwrap();
        let nearest = points
            .iter()
            .step_by(7)
            .map(|p| separation(&probe, &Pose::from_parts((pose_a * p).coords.into(), pose_a.rotation), &b, &pose_b, FAR).lower_m)
            .fold(FAR, f64::min);
        prop_assert!(found.lower_m <= nearest + 2e-9);
        if found.lower_m > 0.0 {
            let sampled = points.iter().step_by(3).fold(FAR, |least, p| {
                let p = pose_a * p;
                others.iter().step_by(3).fold(least, |least, o| least.min((pose_b * o - p).norm()))
            });
            prop_assert!(sampled >= found.lower_m - 1e-9);
            prop_assert!(sampled <= found.upper_m + 0.03, "{sampled} {found:?}");
            prop_assert!(overlap(&a, &pose_a, &b, &pose_b).is_none_or(|o| o.depth_m < 1e-6));
        } else {
            let depth = overlap(&a, &pose_a, &b, &pose_b);
            prop_assert!(depth.is_some(), "contact without an overlap");
        }
    }

    #[test]
    fn an_early_answer_is_the_same_answer(seed in any::<u64>(), beyond in 0.0..0.3) {
        let mut random = Stream::new(seed, 1);
        let ((a, _), (b, _)) = (random_solid(&mut random), random_solid(&mut random));
        let (pose_a, pose_b) = (random_pose(&mut random, 0.3), random_pose(&mut random, 0.3));
        let whole = separation(&a, &pose_a, &b, &pose_b, FAR);
        let early = separation(&a, &pose_a, &b, &pose_b, beyond);
        prop_assert_eq!(early.lower_m >= beyond, whole.lower_m >= beyond);
        prop_assert!(early.lower_m <= whole.upper_m + 1e-12);
    }

    /// Distances below a bound are exact; others are only known to exceed it.
    #[test]
    fn what_matters_of_a_distance_is_the_same(seed in any::<u64>(), beyond_m in 0.0..0.3, exact_below_m in 0.0..0.3) {
        let mut random = Stream::new(seed, 2);
        let ((a, _), (b, _)) = (random_solid(&mut random), random_solid(&mut random));
        let (pose_a, pose_b) = (random_pose(&mut random, 0.3), random_pose(&mut random, 0.3));
        let whole = separation(&a, &pose_a, &b, &pose_b, FAR);
        let found = separation_in(&a, &pose_a, &b, &pose_b, Range { beyond_m, exact_below_m });
        let matters_m = beyond_m.min(exact_below_m);
        prop_assert!(found.lower_m <= whole.upper_m + 1e-12);
        if whole.lower_m >= matters_m {
            prop_assert!(found.lower_m >= matters_m, "{found:?} {whole:?}");
        } else {
            prop_assert!((found.lower_m - whole.lower_m).abs() < 1e-7, "{found:?} {whole:?}");
        }
    }

    #[test]
    fn what_is_wholly_inside_a_mesh_touches_however_it_is_turned(seed in any::<u64>()) {
        let mut random = Stream::new(seed, 3);
        let shell = Solid::mesh(&Surface::cuboid_soup(&Vector::repeat(0.13))).unwrap();
        let at_shell = random_pose(&mut random, 1.0);
        let (half, radius) = (Vector::repeat(0.05), 0.1);
        let inner = [
            Solid::sphere(radius).unwrap(),
            Solid::cuboid(half).unwrap(),
            Solid::mesh(&Surface::cuboid_soup(&half)).unwrap(),
        ];
        for solid in inner {
            let there = at_shell * random_pose(&mut random, 0.02);
            prop_assert!(separation(&shell, &at_shell, &solid, &there, FAR).upper_m <= 0.0);
            prop_assert!(separation(&solid, &there, &shell, &at_shell, FAR).upper_m <= 0.0);
        }
    }

    #[test]
    fn a_box_is_a_box_as_cuboid_hull_and_mesh(seed in any::<u64>()) {
        let mut random = Stream::new(seed, 2);
        let mut size = || random.uniform_between(0.02, 0.2);
        let half = Vector::new(size(), size(), size());
        let kinds = [
            Solid::cuboid(half).unwrap(),
            Solid::hull(&cuboid_corners(&half)).unwrap(),
            Solid::mesh(&Surface::cuboid_soup(&half)).unwrap(),
        ];
        let (other, _) = random_solid(&mut random);
        let (pose, pose_other) = (random_pose(&mut random, 0.2), random_pose(&mut random, 0.2));
        let found = kinds.each_ref().map(|kind| separation(kind, &pose, &other, &pose_other, FAR).lower_m);
        prop_assert!((found[0] - found[1]).abs() < 1e-6 && (found[0] - found[2]).abs() < 1e-6, "{found:?}");
        let turned = kinds.each_ref().map(|kind| separation(&other, &pose_other, kind, &pose, FAR).lower_m);
        prop_assert!((found[0] - turned[0]).abs() < 1e-6 && (found[0] - turned[2]).abs() < 1e-6);
    }
}

#[test]
fn spheres_and_planes_have_their_closed_formulas() {
    let (a, b) = (Solid::sphere(0.1).unwrap(), Solid::sphere(0.25).unwrap());
    let there = Pose::translation(0.3, 0.4, 0.0);
    let found = separation(&a, &Pose::identity(), &b, &there, FAR);
    assert!((found.lower_m - 0.15).abs() < 1e-12 && (found.upper_m - 0.15).abs() < 1e-12);
    let floor = Solid::half_space();
    let above = Pose::translation(2.0, -1.0, 0.7);
    assert!((separation(&floor, &Pose::identity(), &b, &above, FAR).lower_m - 0.45).abs() < 1e-12);
    let sunk = overlap(&b, &Pose::translation(0.0, 0.0, 0.05), &floor, &Pose::identity()).unwrap();
    assert!((sunk.depth_m - 0.2).abs() < 1e-12);
    let deep = overlap(&a, &Pose::identity(), &b, &Pose::translation(0.0, 0.2, 0.0)).unwrap();
    assert!((deep.depth_m - 0.15).abs() < 1e-9);
}

#[test]
fn what_is_inside_touches() {
    let shell = Solid::mesh(&Surface::cuboid_soup(&Vector::repeat(1.0))).unwrap();
    let pebble = Solid::sphere(0.01).unwrap();
    let here = Pose::translation(0.3, -0.2, 0.5);
    assert!(separation(&shell, &Pose::identity(), &pebble, &here, FAR).upper_m <= 0.0);
    assert!(overlap(&shell, &Pose::identity(), &pebble, &here).unwrap().depth_m > 0.4);
    let kernel = Solid::mesh(&Surface::cuboid_soup(&Vector::repeat(0.1))).unwrap();
    assert!(separation(&kernel, &here, &shell, &Pose::identity(), FAR).upper_m <= 0.0);
    assert!(separation(&shell, &Pose::identity(), &kernel, &here, FAR).upper_m <= 0.0);
}

#[test]
fn a_mesh_with_a_hole_is_no_solid() {
    let mut soup = Surface::cuboid_soup(&Vector::repeat(0.1));
    soup.triangles.pop();
    let fault = Solid::mesh(&soup).unwrap_err().to_string();
    assert!(fault.contains("hole") && fault.contains("3 of its edges"), "{fault}");
}

#[test]
fn sizes_and_points_that_are_none_are_refused() {
    for size in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(Solid::sphere(size).is_err());
        assert!(Solid::capsule(0.1, size).is_err());
        assert!(Solid::cylinder(size, 0.1).is_err());
        assert!(Solid::cuboid(Vector::new(0.1, size, 0.1)).is_err());
    }
    let flat: Vec<Point> = (0..9).map(|i| Point::new(f64::from(i % 3), f64::from(i / 3), 0.0)).collect();
    assert!(Solid::hull(&flat).is_err());
    assert!(Solid::hull(&[]).is_err());
    assert!(Solid::hull(&[Point::new(f64::NAN, 0.0, 0.0); 5]).is_err());
}

/// The early decision that a distance is reached agrees with the distance itself.
#[test]
fn what_reaches_a_distance_is_what_the_separation_says() {
    let mut random = Stream::new(17, 0);
    let (mut reached, mut missed) = (0, 0);
    for _ in 0..3000 {
        let ((a, _), (b, _)) = (random_solid(&mut random), random_solid(&mut random));
        let (pose_a, pose_b) = (random_pose(&mut random, 0.3), random_pose(&mut random, 0.3));
        let apart_m = separation(&a, &pose_a, &b, &pose_b, FAR);
        let near_m = apart_m.lower_m + random.uniform_between(-1e-4, 1e-4);
        for distance_m in [random.uniform_between(1e-5, 0.3), near_m.max(1e-5)] {
            let expected = separation(&a, &pose_a, &b, &pose_b, distance_m).lower_m >= distance_m;
            assert_eq!(reaches(&a, &pose_a, &b, &pose_b, distance_m), expected, "{apart_m:?} {distance_m}");
            if expected { reached += 1 } else { missed += 1 }
        }
    }
    assert!(reached > 1000 && missed > 1000, "{reached} {missed}");
}
