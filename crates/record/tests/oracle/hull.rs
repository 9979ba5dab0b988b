//! Convex hull of a set of points by incremental construction.

use std::collections::BTreeSet;

use cranny_spatial::{Point, Vector};

use crate::mesh::Mesh;

/// Distance from the present hull within which a point counts as on it, in metres: far below the 10 µm that count as contact,
/// far above rounding.
const ON_THE_HULL_M: f64 = 1e-9;

/// Computes the convex hull of `points`, to within [`ON_THE_HULL_M`].
///
/// 1. Start with a tetrahedron of points that lie far apart.
/// 2. For each further point, remove the faces that it sees from outside.
/// 3. Join it to the rim of the gap.
///
/// # Panics
/// If all points lie in one plane.
pub fn convex_hull(points: &[Point]) -> Mesh {
    // 1.
    let mut faces = tetrahedron(points);
    for (index, point) in points.iter().enumerate() {
        // 2.
        let (seen, kept): (Vec<_>, Vec<_>) =
            faces.iter().partition(|face| height_above(points, face, point) > ON_THE_HULL_M);
        faces = kept;
        // 3.
        let directed: BTreeSet<_> = seen.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
        let rim = directed.iter().filter(|&&[from, to]| !directed.contains(&[to, from]));
        faces.extend(rim.map(|&[from, to]| [from, to, index]));
    }
    Mesh::new(points.to_vec(), faces).without_unused_vertices()
}

/// Returns the distance of `point` outside the plane of a face, in metres.
pub fn height_above(vertices: &[Point], face: &[usize; 3], point: &Point) -> f64 {
    let [a, b, c] = face.map(|vertex| vertices[vertex]);
    (b - a).cross(&(c - a)).normalize().dot(&(point - a))
}

fn tetrahedron(points: &[Point]) -> Vec<[usize; 3]> {
    let farthest = |measure: &dyn Fn(&Point) -> f64| {
        let far = (0..points.len()).max_by(|&i, &j| measure(&points[i]).total_cmp(&measure(&points[j])));
        far.expect("a hull needs points")
    };
    let a = farthest(&|p| p.x);
    let b = farthest(&|p| (p - points[a]).norm());
    let line: Vector = points[b] - points[a];
    let c = farthest(&|p| line.cross(&(p - points[a])).norm());
    let height = |p: &Point| height_above(points, &[a, b, c], p);
    let d = farthest(&|p| height(p).abs());
    assert!(height(&points[d]).abs() > ON_THE_HULL_M, "the points lie in one plane");
    let (b, c) = if height(&points[d]) > 0.0 { (c, b) } else { (b, c) };
    vec![[a, b, c], [a, d, b], [b, d, c], [c, d, a]]
}
