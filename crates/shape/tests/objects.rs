//! Processing of the mesh of an object: repair, volume, convex pieces, stable poses.

use std::f64::consts::{PI, TAU};

use cranny_shape::{
    AreaDistribution, ConvexParts, DecompositionSettings, Loft, RepairedMesh, ShapeError, Solid, Surface,
    TriangleSoup, VolumeMoments, distinct_poses, separation, stable_poses,
};
use cranny_spatial::{Point, Pose, Rotation, Stream, Vector, sin_cos};
use proptest::prelude::*;

pub(crate) fn cuboid(x: f64, y: f64, z: f64) -> TriangleSoup {
    Surface::cuboid_soup(&(Vector::new(x, y, z) * 0.5))
}

fn moved(soup: &TriangleSoup, pose: &Pose) -> TriangleSoup {
    TriangleSoup {
        vertices: soup.vertices.iter().map(|v| pose * v).collect(),
        triangles: soup.triangles.clone(),
    }
}

pub(crate) fn together(one: &TriangleSoup, other: &TriangleSoup) -> TriangleSoup {
    let corners = |soup: &TriangleSoup| -> Vec<Point> {
        (0..soup.triangles.len()).flat_map(|t| soup.corners(t)).collect()
    };
    TriangleSoup::from_corners([corners(one), corners(other)].concat()).unwrap()
}

/// L-shaped solid: not convex, with a known volume.
fn angle_iron() -> TriangleSoup {
    let outline = [(0.0, 0.0), (0.2, 0.0), (0.2, 0.05), (0.05, 0.05), (0.05, 0.2), (0.0, 0.2)];
    let ring = |z: f64| outline.map(|(x, y)| Point::new(x, y, z)).to_vec();
    // A fan about the centre of the outline would leave it, so the caps are cut by hand.
    let mut corners = Vec::new();
    let (low, high) = (ring(0.0), ring(0.1));
    for i in 0..6 {
        let j = (i + 1) % 6;
        corners.extend([low[i], low[j], high[j], low[i], high[j], high[i]]);
    }
    for [a, b, c] in [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]] {
        corners.extend([high[a], high[b], high[c], low[a], low[c], low[b]]);
    }
    TriangleSoup::from_corners(corners).unwrap()
}

#[test]
fn flipped_and_doubled_faces_are_repaired() {
    let whole = cuboid(0.1, 0.2, 0.3);
    // Every triangle has its own three vertices, some are reversed, one is a duplicate.
    let mut soup = TriangleSoup::default();
    for (index, triangle) in (0..12).chain([3]).enumerate() {
        let first = u32::try_from(soup.vertices.len()).unwrap();
        soup.vertices.extend(whole.corners(triangle));
        let turned = index % 3 == 1;
        soup.triangles.push(if turned {
            [first, first + 2, first + 1]
        } else {
            [first, first + 1, first + 2]
        });
    }
    let repaired = RepairedMesh::of(&soup).unwrap();
    assert_eq!(repaired.merged_vertices, 39 - 8);
    assert_eq!((repaired.dropped_triangles, repaired.flipped_triangles), (1, 4));
    let volume_m3 = VolumeMoments::of_mesh(&repaired.soup).unwrap().volume_m3;
    assert!((volume_m3 - 0.006).abs() < 1e-15, "{volume_m3}");
}

/// A box within another is a cavity if its faces point inwards, as in collision checks. Else it is redundant.
#[test]
fn a_cavity_is_kept_and_a_body_within_another_is_part_of_it() {
    let outer = cuboid(0.3, 0.3, 0.3);
    let inside_out = |soup: &TriangleSoup| {
        let mut soup = soup.clone();
        soup.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        soup
    };
    let inner = cuboid(0.1, 0.1, 0.1);
    let full = cuboid(0.04, 0.04, 0.04);
    for (soup, volume_m3, triangles) in [
        (inside_out(&outer), 0.027, 12),
        (together(&outer, &inner), 0.027, 12),
        (together(&inner, &outer), 0.027, 12),
        (together(&outer, &inside_out(&inner)), 0.026, 24),
        (together(&together(&outer, &inside_out(&inner)), &full), 0.026_064, 36),
        (together(&together(&outer, &inner), &full), 0.027, 12),
    ] {
        let repaired = RepairedMesh::of(&soup).unwrap();
        assert!((repaired.soup.signed_volume_m3() - volume_m3).abs() < 1e-12, "{volume_m3}");
        assert_eq!(repaired.soup.triangles.len(), triangles);
        assert_eq!(repaired.dropped_triangles, soup.triangles.len() - triangles);
    }
}

/// A body that touches another one at a face, an edge or a corner stays, on whichever side it is; one within it does not.
#[test]
fn a_body_that_touches_another_is_no_part_of_it() {
    let block = cuboid(0.2, 0.2, 0.2);
    let small = cuboid(0.06, 0.05, 0.04);
    let beside = [0.13, 0.125, 0.12];
    let within = [0.07, 0.075, 0.08];
    for pattern in 1..8_u8 {
        let touching = |axis: u8| pattern >> axis & 1 == 1;
        for side in [-1.0, 1.0] {
            for (reach, is_kept) in [(beside, true), (within, false)] {
                let place = |axis: u8| if touching(axis) { side * reach[usize::from(axis)] } else { 0.003 };
                let other = moved(&small, &shift(place(0), place(1), place(2)));
                for soup in [together(&block, &other), together(&other, &block)] {
                    let repaired = RepairedMesh::of(&soup).unwrap();
                    let volume_m3 = if is_kept { 0.008 + 0.000_12 } else { 0.008 };
                    assert!(
                        (repaired.soup.signed_volume_m3() - volume_m3).abs() < 1e-12,
                        "{pattern} {side} {is_kept}"
                    );
                }
            }
        }
    }
}

#[test]
fn what_cannot_be_repaired_is_refused_with_its_reason() {
    let mut open = cuboid(0.1, 0.1, 0.1);
    open.triangles.pop();
    assert!(matches!(RepairedMesh::of(&open), Err(ShapeError::Open { edges: 3 })));

    let crossing = together(&cuboid(0.1, 0.1, 0.1), &moved(&cuboid(0.1, 0.1, 0.1), &shift(0.03, 0.04, 0.05)));
    let fault = RepairedMesh::of(&crossing).unwrap_err();
    assert!(matches!(fault, ShapeError::SelfCrossing { .. }), "{fault}");
    assert!(fault.to_string().contains("trimesh.boolean.union"), "{fault}");

    // Apart from each other the same two boxes are valid.
    let apart = together(&cuboid(0.1, 0.1, 0.1), &moved(&cuboid(0.1, 0.1, 0.1), &shift(0.3, 0.04, 0.05)));
    assert_eq!(RepairedMesh::of(&apart).unwrap().flipped_triangles, 0);

    // A Klein bottle: closed by count, but one-sided.
    let klein = klein_bottle(12, 8);
    let fault = RepairedMesh::of(&klein).unwrap_err();
    assert!(matches!(fault, ShapeError::OneSided { .. }), "{fault}");

    assert!(matches!(RepairedMesh::of(&TriangleSoup::default()), Err(ShapeError::Empty)));
}

fn shift(x: f64, y: f64, z: f64) -> Pose {
    Pose::translation(x, y, z)
}

/// Torus whose tube is glued to itself in reverse.
fn klein_bottle(around: u32, tube: u32) -> TriangleSoup {
    let vertex = |i: u32, j: u32| {
        let (i, j) = if i == around { (0, (tube - j) % tube) } else { (i, j % tube) };
        i * tube + j
    };
    let mut soup = TriangleSoup::default();
    for i in 0..around {
        for j in 0..tube {
            let (sin_i, cos_i) = sin_cos(TAU * f64::from(i) / f64::from(around));
            let (sin_j, cos_j) = sin_cos(TAU * f64::from(j) / f64::from(tube));
            let reach = 0.1 + 0.03 * cos_j;
            soup.vertices.push(Point::new(reach * cos_i, reach * sin_i, 0.03 * sin_j));
            let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
            soup.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    soup
}

#[test]
fn moments_of_a_turned_cuboid_are_those_of_the_textbook() {
    let (x, y, z) = (0.1, 0.2, 0.4);
    let pose = Pose::new(Vector::new(3.0, -2.0, 1.0), Vector::new(0.3, -0.8, 0.5));
    let moments = VolumeMoments::of_mesh(&moved(&cuboid(x, y, z), &pose)).unwrap();
    assert!((moments.volume_m3 - x * y * z).abs() < 1e-14);
    assert!((moments.center - pose * Point::origin()).norm() < 1e-12);
    let textbook = Vector::new(y * y + z * z, x * x + z * z, x * x + y * y) / 12.0;
    let rotation = pose.rotation.to_rotation_matrix();
    let expected = rotation.matrix()
        * cranny_spatial::nalgebra::Matrix3::from_diagonal(&textbook)
        * rotation.matrix().transpose();
    assert!((moments.inertia_per_mass_m2 - expected).amax() < 1e-12);
}

#[test]
fn moments_of_a_fine_sphere_are_nearly_those_of_a_sphere() {
    let moments = VolumeMoments::of_mesh(&TriangleSoup::geodesic_sphere(0.1, 4)).unwrap();
    let share = moments.volume_m3 / (4.0 / 3.0 * PI * 1e-3);
    assert!(share < 1.0 && share > 0.997, "{share}");
    assert!((moments.inertia_per_mass_m2.m11 / (0.4 * 0.01) - 1.0).abs() < 3e-3);
    assert!(moments.center.coords.norm() < 1e-12);
}

#[test]
fn convex_parts_of_an_angle_iron_are_few_and_their_error_is_honest() {
    let mesh = angle_iron();
    let found = ConvexParts::of_mesh(&mesh, &DecompositionSettings::default()).unwrap();
    assert!((2..=6).contains(&found.parts.len()), "{}", found.parts.len());
    assert!(found.error.excess < 0.02 && found.error.missing < 0.02, "{:?}", found.error);
    // The error of the hull is known: the triangle between the two arms.
    let hull = TriangleSoup::convex_hull(&mesh.vertices).unwrap();
    let of_hull = ConvexParts::measured(&mesh, vec![hull.clone()]).unwrap();
    let volume_m3 = mesh.signed_volume_m3();
    let expected = hull.signed_volume_m3() / volume_m3 - 1.0;
    assert!((volume_m3 - 0.00175).abs() < 1e-12);
    assert!((of_hull.error.excess - expected).abs() < 5e-3, "{:?}, {expected}", of_hull.error);
    assert!(of_hull.error.missing < 1e-3);
    let half = vec![moved(&cuboid(0.2, 0.05, 0.1), &shift(0.1, 0.025, 0.05))];
    let of_half = ConvexParts::measured(&mesh, half).unwrap();
    assert!((of_half.error.missing - 0.75 / 1.75).abs() < 5e-3 && of_half.error.excess < 1e-3);
}

/// Solid angle of a rectangle a × b seen from the distance d above its middle, over 4π.
fn share_of_rectangle(a: f64, b: f64, d: f64) -> f64 {
    (a * b / (2.0 * d * (4.0 * d * d + a * a + b * b).sqrt())).atan() / PI
}

#[test]
fn a_cuboid_rests_on_its_six_sides_with_the_shares_of_their_solid_angles() {
    let (x, y, z) = (0.038, 0.089, 0.175);
    let poses = stable_poses(&cuboid(x, y, z).vertices, &Point::origin()).unwrap();
    let found: Vec<f64> = poses.iter().map(|pose| pose.probability).collect();
    let shares = [(y, z, x), (x, z, y), (x, y, z)].map(|(a, b, d)| share_of_rectangle(a, b, 0.5 * d));
    assert_eq!(found.len(), 6);
    for (index, share) in found.iter().enumerate() {
        assert!((share - shares[index / 2]).abs() < 1e-12, "{found:?}, {shares:?}");
    }
    for (pose, height) in poses.iter().zip([x, x, y, y, z, z]) {
        assert!((pose.ground_from_body.translation.z - 0.5 * height).abs() < 1e-12);
    }
}

#[test]
fn a_leaning_prism_topples_from_the_faces_that_do_not_hold_it() {
    // Its top is shifted by twice its width: standing on an end, the centre of mass is beyond the edge.
    let ring = |x: f64, z: f64| {
        [(0.0, 0.0), (0.1, 0.0), (0.1, 0.1), (0.0, 0.1)].map(|(a, b)| Point::new(x + a, b, z)).to_vec()
    };
    let mesh = Loft::new(vec![ring(0.0, 0.0), ring(0.2, 0.3)]).unwrap().mesh().unwrap();
    let center = VolumeMoments::of_mesh(&mesh).unwrap().center;
    let poses = stable_poses(&mesh.vertices, &center).unwrap();
    assert_eq!(poses.len(), 4, "{poses:?}");
    assert!((poses.iter().map(|pose| pose.probability).sum::<f64>() - 1.0).abs() < 1e-12);
    let down = |pose: &Pose| pose.rotation.inverse() * -Vector::z();
    assert!(poses.iter().all(|pose| down(&pose.ground_from_body).z.abs() < 0.9));
}

/// Solid of regular polygons around z, given by heights and radii (m).
fn lathed(sides: u32, profile: &[(f64, f64)]) -> TriangleSoup {
    let ring = |&(z, radius): &(f64, f64)| {
        let corner = |side: u32| {
            let (sine, cosine) = sin_cos(TAU * f64::from(side) / f64::from(sides));
            Point::new(radius * cosine, radius * sine, z)
        };
        (0..sides).map(corner).collect()
    };
    Loft::new(profile.iter().map(ring).collect()).unwrap().mesh().unwrap()
}

/// Probabilities of the distinct poses of a mesh, and the number of poses before the merge.
fn distinct(mesh: &TriangleSoup) -> (Vec<f64>, usize) {
    let center = VolumeMoments::of_mesh(mesh).unwrap().center;
    let poses = stable_poses(&mesh.vertices, &center).unwrap();
    let found = distinct_poses(&poses, mesh).unwrap();
    assert!((found.iter().map(|pose| pose.probability).sum::<f64>() - 1.0).abs() < 1e-12);
    (found.iter().map(|pose| pose.probability).collect(), poses.len())
}

#[test]
fn a_round_bottle_lies_in_one_way_and_not_in_one_for_each_side() {
    let bottle = lathed(48, &[(0.0, 0.03), (0.15, 0.03), (0.18, 0.012), (0.22, 0.012)]);
    let (found, before) = distinct(&bottle);
    assert!(before >= 49, "{before}");
    assert!((2..=3).contains(&found.len()), "{found:?}");
    // After a rotation and a shift its vertices are no longer equal to the last bit.
    let tilted = moved(&bottle, &Pose::new(Vector::new(0.3, -0.2, 0.1), Vector::new(0.5, 0.4, -0.9)));
    assert_eq!(distinct(&tilted).0.len(), found.len());
    // The two ends of a prism are one pose, and so are its five sides.
    let (found, before) = distinct(&lathed(5, &[(0.0, 0.03), (0.05, 0.03)]));
    assert_eq!((found.len(), before), (2, 7));
}

#[test]
fn poses_that_look_different_stay_apart() {
    // Opposite sides of a cuboid are equal by a half turn.
    let (found, before) = distinct(&cuboid(0.038, 0.089, 0.175));
    assert_eq!((found.len(), before), (3, 6));
    let both_sides = 2.0 * share_of_rectangle(0.089, 0.175, 0.5 * 0.038);
    assert!((found[0] - both_sides).abs() < 1e-12, "{found:?}");
    // A peg on one side leaves no symmetry but that of the peg's side. Standing on that side or on the opposite one
    // differs, and so do its left and right if the peg is off the middle.
    let peg = moved(&cuboid(0.01, 0.01, 0.02), &shift(0.012, 0.031, 0.097));
    let (found, before) = distinct(&together(&cuboid(0.038, 0.089, 0.175), &peg));
    assert_eq!(found.len(), before, "{found:?}");
    // A mirror image is not a rotation: a solid with only a mirror symmetry keeps all its poses.
    let points =
        [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.03, 0.05, 0.02], [0.03, -0.05, 0.02], [0.05, 0.0, 0.09]];
    let mirrored = TriangleSoup::convex_hull(&points.map(Point::from)).unwrap();
    let (found, before) = distinct(&mirrored);
    assert_eq!(found.len(), before, "{found:?}");
}

#[test]
fn a_centre_of_mass_outside_is_refused() {
    let far = Point::new(1.0, 0.0, 0.0);
    assert!(matches!(
        stable_poses(&cuboid(0.1, 0.1, 0.1).vertices, &far),
        Err(ShapeError::CenterOutside { .. })
    ));
}

#[test]
fn points_of_a_surface_are_uniform_over_its_area() {
    let surface = Surface::new(&cuboid(0.1, 0.2, 0.4)).unwrap();
    let area = AreaDistribution::new(&surface).unwrap();
    assert!((area.area_m2() - 2.0 * (0.02 + 0.04 + 0.08)).abs() < 1e-12);
    let mut random = Stream::new(1, 0);
    let (mut of_side, mut upper) = ([0; 3], 0);
    for _ in 0..60_000 {
        let found = area.point([random.uniform(), random.uniform(), random.uniform()]);
        let axis = found.normal.iamax();
        of_side[axis] += 1;
        let half = [0.05, 0.1, 0.2][axis];
        assert!((found.point[axis] - half * found.normal[axis].signum()).abs() < 1e-15);
        upper += usize::from(found.point.z > 0.1);
    }
    let share = |count: usize| count as f64 / 60_000.0;
    assert!((share(of_side[0]) - 4.0 / 7.0).abs() < 0.01, "{of_side:?}");
    assert!((share(of_side[1]) - 2.0 / 7.0).abs() < 0.01 && (share(of_side[2]) - 1.0 / 7.0).abs() < 0.01);
    // The upper quarter has a quarter of the sides and one of the two ends.
    assert!((share(upper) - (0.25 * 6.0 / 7.0 + 0.5 / 7.0)).abs() < 0.01);
}

#[test]
fn a_loft_needs_rings_that_fit() {
    let ring = |count: usize| vec![Point::origin(); count];
    for rings in [vec![], vec![ring(4)], vec![ring(2), ring(2)], vec![ring(4), ring(5)]] {
        assert!(matches!(Loft::new(rings), Err(ShapeError::Rings { .. })));
    }
}

proptest! {
    #[test]
    fn rays_meet_what_a_scan_of_all_triangles_finds(seed in 0_u64..200) {
        let mut random = Stream::new(seed, 0);
        let soup = TriangleSoup::geodesic_sphere(0.1, 2);
        let surface = Surface::new(&soup).unwrap();
        let mut vector = || Vector::new(random.normal(), random.normal(), random.normal());
        let (origin, direction) = (Point::from(vector() * 0.1), vector().normalize());
        let found = surface.ray_hits(&origin, &direction, 1.0);
        // Oracle: intersects the plane of each triangle, and checks on which side of each edge it is met.
        let mut expected: Vec<f64> = Vec::new();
        for index in 0..soup.triangles.len() {
            let [a, b, c] = soup.corners(index);
            let normal = (b - a).cross(&(c - a));
            let distance = (a - origin).dot(&normal) / direction.dot(&normal);
            let point = origin + direction * distance;
            let inside = [(a, b), (b, c), (c, a)]
                .iter()
                .all(|(from, to)| (to - from).cross(&(point - from)).dot(&normal) >= 0.0);
            if inside && (0.0..=1.0).contains(&distance) {
                expected.push(distance);
            }
        }
        expected.sort_by(f64::total_cmp);
        prop_assert_eq!(found.len(), expected.len());
        for (hit, distance) in found.iter().zip(&expected) {
            prop_assert!((hit.distance_m - distance).abs() < 1e-12);
        }
    }

    #[test]
    fn a_swept_solid_touches_what_the_solid_touches_on_its_way(seed in 0_u64..60) {
        let mut random = Stream::new(seed, 0);
        let mut vector = |size: f64| {
            Vector::new(random.normal(), random.normal(), random.normal()) * size
        };
        let solids = [
            Solid::cuboid(Vector::new(0.02, 0.05, 0.01)).unwrap(),
            Solid::sphere(0.03).unwrap(),
            Solid::capsule(0.05, 0.01).unwrap(),
        ];
        let obstacle = Solid::cuboid(Vector::new(0.04, 0.03, 0.02)).unwrap();
        let pose = Pose::new(vector(0.1), vector(1.0));
        let shift = vector(0.1);
        for solid in &solids {
            let [swept] = &solid.swept(&shift)[..] else { panic!("one convex solid") };
            let gap = separation(swept, &Pose::identity(), &obstacle, &pose, 1.0);
            // The least distance of the solid on its path, sampled densely: never less than that of the sweep, and more by at
            // most half the sampling distance.
            let steps = 200;
            let on_the_way = (0..=steps)
                .map(|step| {
                    let there = Pose::from_parts((shift * (f64::from(step) / f64::from(steps))).into(),
                        Rotation::identity());
                    separation(solid, &there, &obstacle, &pose, 1.0).upper_m
                })
                .fold(f64::INFINITY, f64::min);
            prop_assert!(on_the_way >= gap.lower_m - 1e-9);
            prop_assert!(on_the_way <= gap.upper_m + shift.norm() / f64::from(steps) + 1e-6);
        }
    }
}
