//! Meshes of very many triangles or bodies: with work that grows with their square, each would take minutes.

use std::f64::consts::{PI, TAU};

use cranny_shape::{RepairedMesh, ShapeError, Solid, TriangleSoup};
use cranny_spatial::{Point, Pose, Rotation, Stream, Vector, sin_cos};

use crate::objects::{cuboid, together};

/// Two cones over one rim, with tips at the two heights: slim triangles, the boxes of which overlap with nearly all others.
fn double_cone(faces: u32, tips: [f64; 2], pose: &Pose) -> TriangleSoup {
    let rim = faces / 2;
    let at = |index: u32| {
        let (sine, cosine) = sin_cos(TAU * f64::from(index) / f64::from(rim));
        Point::new(0.1 * cosine, 0.1 * sine, 0.0)
    };
    let vertices = (0..rim).map(at).chain(tips.map(|height| Point::new(0.0, 0.0, height)));
    let triangles = (0..rim).flat_map(|index| {
        let next = (index + 1) % rim;
        [[index, next, rim], [next, index, rim + 1]]
    });
    TriangleSoup { vertices: vertices.map(|vertex| pose * vertex).collect(), triangles: triangles.collect() }
}

fn tilted() -> Pose {
    Pose::new(Vector::new(0.3, 0.2, 0.1), Vector::new(0.4, 0.5, 0.6))
}

/// Guards against quadratic time and memory: a double cone of 32 000 triangles took more than 40 s, and one through which
/// others pass a gigabyte.
#[test]
fn a_mesh_of_long_narrow_triangles_is_compared_in_little_time() {
    const FACES: u32 = 16_000;
    for (tips, pose) in [([0.2, -0.1], tilted()), ([0.2, 0.05], tilted()), ([0.2, -0.1], Pose::identity())] {
        let repaired = RepairedMesh::of(&double_cone(FACES, tips, &pose)).unwrap();
        let expected_m3 = PI * 0.01 * (tips[0] - tips[1]) / 3.0;
        assert!((repaired.soup.signed_volume_m3() - expected_m3).abs() < 1e-6 * expected_m3);
        assert_eq!(repaired.shallow_crossings, 0);
    }
    // A long prism with fans as ends, from the middle and from a corner of the rim.
    for is_from_middle in [true, false] {
        let prism = prism(FACES / 4, is_from_middle, &tilted());
        assert_eq!(RepairedMesh::of(&prism).unwrap().shallow_crossings, 0);
    }
    // Two that pass through each other, and one through the wall of the other.
    let one = double_cone(FACES, [0.2, -0.1], &tilted());
    for height in [0.05, 0.15] {
        let other = double_cone(FACES, [0.2, -0.1], &(tilted() * Pose::translation(0.0, 0.03, height)));
        let fault = RepairedMesh::of(&together(&one, &other)).unwrap_err();
        assert!(matches!(fault, ShapeError::SelfCrossing { pairs: 1.., .. }), "{fault}");
    }
}

/// Prism of many sides, 1 m long, closed by fans from the middle or from a corner of each rim.
fn prism(sides: u32, is_from_middle: bool, pose: &Pose) -> TriangleSoup {
    let at = |index: u32, height: f64| {
        let (sine, cosine) = sin_cos(TAU * f64::from(index) / f64::from(sides));
        Point::new(0.1 * cosine, 0.1 * sine, height)
    };
    let mut soup = TriangleSoup::default();
    soup.vertices
        .extend((0..sides).map(|index| at(index, 0.0)).chain((0..sides).map(|index| at(index, 1.0))));
    soup.vertices.extend([Point::origin(), Point::new(0.0, 0.0, 1.0)]);
    let tips = if is_from_middle { [2 * sides, 2 * sides + 1] } else { [0, sides] };
    for index in 0..sides {
        let (a, b) = (index, (index + 1) % sides);
        let (c, d) = (a + sides, b + sides);
        soup.triangles.extend([[a, b, d], [a, d, c], [b, a, tips[0]], [c, d, tips[1]]]);
    }
    soup.vertices.iter_mut().for_each(|vertex| *vertex = pose * *vertex);
    soup
}

/// The boxes of stacked needles overlap if the axes of the stacks are not those of the whole.
#[test]
fn narrow_triangles_in_all_directions_are_refused_with_the_limit() {
    let mut random = Stream::new(3, 0);
    let mut soup = TriangleSoup::default();
    for stack in 0..3 {
        let turn = random.rotation();
        for needle in 0..2000 {
            let about = Rotation::from_scaled_axis(Vector::z() * (TAU * random.uniform()));
            let place = turn * Point::new(0.0, 0.0, 2e-4 * f64::from(needle)) + Vector::ith(stack, 5.0);
            let pose = Pose::from_parts(place.coords.into(), turn * about);
            let first = u32::try_from(soup.vertices.len()).unwrap();
            let corners = [(-1.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1e-4, 0.0), (0.0, 0.0, 1e-4)];
            soup.vertices.extend(corners.map(|(x, y, z)| pose * Point::new(x, y, z)));
            let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
            soup.triangles.extend(faces.map(|face: [u32; 3]| face.map(|corner| corner + first)));
        }
    }
    let fault = RepairedMesh::of(&soup).unwrap_err();
    assert!(matches!(fault, ShapeError::NarrowTriangles { triangles: 24_000, most: 2_536_000 }), "{fault}");
}

/// Guards against cubic time: each of the layers was compared with all pairs of others.
#[test]
fn very_many_bodies_inside_each_other_are_refused() {
    let mut soup = TriangleSoup::default();
    for layer in 0..2000_u32 {
        let size = 0.1 + 1e-4 * f64::from(layer);
        soup.append(&cuboid(size, size, size), &Pose::identity());
    }
    let fault = RepairedMesh::of(&soup).unwrap_err();
    assert!(matches!(fault, ShapeError::NestedBodies { most: 100, .. }), "{fault}");
    // They are one solid, unless there are cavities among them.
    assert_eq!(Solid::mesh(&soup).unwrap().mesh_repairs(), None);
    for (layer, triangles) in soup.triangles.chunks_mut(12).enumerate() {
        if layer % 2 == 0 {
            for triangle in triangles {
                triangle.swap(1, 2);
            }
        }
    }
    let fault = Solid::mesh(&soup).unwrap_err();
    assert!(matches!(fault, ShapeError::NestedBodies { most: 100, .. }), "{fault}");
}

/// Guards against quadratic time: the segments that find what surrounds a body point upwards, and met all bodies above it. 8300
/// plates took 7 s, and these would take two minutes.
#[test]
fn very_many_bodies_above_each_other_are_compared_in_little_time() {
    let plates = |count: u32| {
        let mut soup = TriangleSoup::default();
        for layer in 0..count {
            let pose = Pose::translation(0.0, 0.0, 1e-3 * f64::from(layer));
            soup.append(&cuboid(0.1, 0.1, 5e-4), &pose);
        }
        soup
    };
    assert_eq!(RepairedMesh::of(&plates(40_000)).unwrap().dropped_triangles, 0);
    // In a box around them, the segments are needed.
    let mut boxed = plates(8000);
    boxed.append(&cuboid(1.0, 1.0, 20.0), &Pose::identity());
    let fault = RepairedMesh::of(&boxed).unwrap_err();
    assert!(matches!(fault, ShapeError::ManyBodies { bodies: 8001, .. }), "{fault}");
}
