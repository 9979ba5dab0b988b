use std::collections::{BTreeMap, HashMap};

use cranny_spatial::Point;

use crate::inside::same_place::merged;
use crate::{Aabb, TriangleSoup};

/// Maximum size of a hole that is closed, as a share of the mesh; sizes are the diagonals of boxes. Larger holes are openings
/// through which an object may be meant to pass.
const SMALL_SHARE: f64 = 0.1;

/// A mesh whose holes are closed.
pub(crate) struct Closed {
    pub soup: TriangleSoup,
    pub holes: usize,
}

/// Closes each hole of a mesh by a fan of triangles between its rim and the mean of the rim's corners. `None` if a rim is
/// not a single loop, or larger than [`SMALL_SHARE`]. Keeps all triangles of the mesh and thus all of its surface.
pub(crate) fn closed(soup: &TriangleSoup) -> Option<Closed> {
    let (mut vertices, place) = merged(&soup.vertices);
    let mut triangles: Vec<[u32; 3]> =
        soup.triangles.iter().map(|triangle| triangle.map(|vertex| place[vertex as usize])).collect();
    let most = SMALL_SHARE * Aabb::around(vertices.iter(), 0.0).half_extents.norm();
    let mut holes = 0;
    let mut next = rims(&triangles)?;
    while let Some((&first, _)) = next.first_key_value() {
        let mut rim = vec![first];
        while let Some(vertex) = next.remove(&rim[rim.len() - 1]) {
            rim.push(vertex);
        }
        // The rim must end at its first vertex, and pass through no vertex twice.
        if rim.pop() != Some(first) || rim.len() < 3 {
            return None;
        }
        let corners = || rim.iter().map(|vertex| &vertices[*vertex as usize]);
        if Aabb::around(corners(), 0.0).half_extents.norm() > most {
            return None;
        }
        let mean = corners().map(|corner| corner.coords).sum::<cranny_spatial::Vector>() / rim.len() as f64;
        let middle = u32::try_from(vertices.len()).ok()?;
        let edges = rim.iter().zip(rim.iter().cycle().skip(1));
        triangles.extend(edges.map(|(&from, &to)| [from, to, middle]));
        vertices.push(Point::from(mean));
        holes += 1;
    }
    Some(Closed { soup: TriangleSoup { vertices, triangles }, holes })
}

/// Edges that belong to one triangle, as a map from each vertex to the next, against the direction of that triangle.
/// `None` if three or more triangles meet at an edge, or two rims at a vertex.
fn rims(triangles: &[[u32; 3]]) -> Option<BTreeMap<u32, u32>> {
    let mut count: HashMap<[u32; 2], (u32, [u32; 2])> = HashMap::new();
    for &[a, b, c] in triangles.iter().filter(|[a, b, c]| a != b && b != c && c != a) {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            let known = count.entry([from.min(to), from.max(to)]).or_insert((0, [to, from]));
            known.0 += 1;
        }
    }
    let mut next = BTreeMap::new();
    for (faces, [from, to]) in count.into_values() {
        match faces {
            2 => {}
            1 if next.insert(from, to).is_none() => {}
            _ => return None,
        }
    }
    Some(next)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ShapeError, Solid, separation};

    /// Ball of 1 m without the faces whose corners all lie above a height.
    fn open_above(height_m: f64) -> TriangleSoup {
        let mut soup = Solid::sphere(1.0).expect("a ball").tessellation().expect("it has an end");
        let is_high = |vertex: &u32| soup.vertices[*vertex as usize].z > height_m;
        soup.triangles =
            soup.triangles.iter().filter(|corners| !corners.iter().all(is_high)).copied().collect();
        soup
    }

    #[test]
    fn what_a_small_hole_leads_to_is_full_and_a_large_one_stays_open() {
        let mut soup = Solid::sphere(1.0).expect("a ball").tessellation().expect("it has an end");
        soup.triangles.pop();
        assert!(matches!(Solid::mesh(&soup), Err(ShapeError::Open { .. })));
        let solid = Solid::mesh_with_small_holes(&soup).expect("a small hole");
        assert_eq!(solid.mesh_repairs().map(|repairs| repairs.closed_holes), Some(1));
        let (ball, here) = (Solid::sphere(0.01).expect("a ball"), cranny_spatial::Pose::identity());
        assert!(separation(&solid, &here, &ball, &here, 1.0).lower_m <= 0.0, "the inside is full");
        let closed = closed(&soup).expect("a small hole");
        assert_eq!(&closed.soup.triangles[..soup.triangles.len()], &soup.triangles[..], "nothing is lost");
        assert!(matches!(Solid::mesh_with_small_holes(&open_above(0.5)), Err(ShapeError::Open { .. })));
    }
}
