use cranny_spatial::{Point, Pose, Vector};

use crate::distance::triangle_tree::TriangleTree;
use crate::inside::closed_mesh::check_indices;
use crate::{Aabb, ShapeError, TriangleSoup};

/// Triangles without an interior: two surfaces touch only where a triangle of one meets a triangle of the other. The
/// released planners check such surfaces (README, "What solved means").
#[derive(Clone, Debug)]
pub struct Surface {
    pub(crate) corners: Vec<[Point; 3]>,
    /// Box of each triangle; `normals` contains its unit normal, zero for a triangle without area.
    boxes: Vec<Aabb>,
    normals: Vec<Vector>,
    pub(crate) tree: TriangleTree,
    aabb: Aabb,
}

/// Maximum number of triangles for which a plain scan is faster than the tree.
const SCAN_LIMIT: usize = 24;

/// Maximum number of boxes for which a plain scan is faster than the tree.
const BOX_SCAN_LIMIT: usize = 96;

/// Tolerance, in metres: far above the rounding of a distance within 100 m, far below any measured distance.
const ROUNDING_M: f64 = 1e-12;

impl Surface {
    /// The surface of a triangle soup, open or closed.
    ///
    /// # Errors
    /// [`ShapeError::Empty`] or [`ShapeError::VertexIndex`].
    pub fn new(soup: &TriangleSoup) -> Result<Self, ShapeError> {
        check_indices(soup)?;
        Ok(Self::of_checked(soup))
    }

    pub(crate) fn of_checked(soup: &TriangleSoup) -> Self {
        Self::of_corners((0..soup.triangles.len()).map(|t| soup.corners(t)).collect())
    }

    pub(crate) fn of_corners(corners: Vec<[Point; 3]>) -> Self {
        let aabb = Aabb::around(corners.iter().flatten(), 0.0);
        let boxes = corners.iter().map(|triangle| Aabb::around(triangle, 0.0)).collect();
        let normal =
            |[a, b, c]: &[Point; 3]| (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vector::zeros);
        let normals = corners.iter().map(normal).collect();
        Self { tree: TriangleTree::new(&corners), boxes, normals, corners, aabb }
    }

    /// Triangles for which `keeps` returns true, given a corner and the unit normal; `None` if there are none.
    pub fn filtered(&self, keeps: impl Fn(&Point, &Vector) -> bool) -> Option<Self> {
        let kept =
            self.corners.iter().zip(&self.normals).filter(|(corners, normal)| keeps(&corners[0], normal));
        let corners: Vec<[Point; 3]> = kept.map(|(corners, _)| *corners).collect();
        (!corners.is_empty()).then(|| Self::of_corners(corners))
    }

    /// The twelve triangles of a cuboid centred at the origin, normals outwards.
    pub fn cuboid_soup(half_extents: &Vector) -> TriangleSoup {
        let sign = |bit: u32| if bit == 0 { -1.0 } else { 1.0 };
        let corner = |i: u32| Vector::new(sign(i & 1), sign(i & 2), sign(i & 4)).component_mul(half_extents);
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        TriangleSoup {
            vertices: (0..8).map(|i| corner(i).into()).collect(),
            triangles: quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        }
    }

    /// The twelve triangles of a box.
    pub fn of_box(aabb: &Aabb) -> Self {
        let mut soup = Self::cuboid_soup(&aabb.half_extents);
        for vertex in &mut soup.vertices {
            *vertex += aabb.center.coords;
        }
        Self::of_checked(&soup)
    }

    /// Axis-aligned box around the surface in its own frame.
    pub fn aabb(&self) -> &Aabb {
        &self.aabb
    }

    /// Returns true if a triangle of this surface meets one of `other`, both placed in a common frame.
    pub fn touches(&self, common_from_self: &Pose, other: &Self, common_from_other: &Pose) -> bool {
        let other_from_self = common_from_other.inv_mul(common_from_self);
        let rotation = other_from_self.rotation.to_rotation_matrix();
        let rotation = rotation.matrix();
        let region = Aabb {
            center: other_from_self * self.aabb.center,
            half_extents: rotation.abs() * self.aabb.half_extents,
        };
        if !region.overlaps(&other.aabb) {
            return false;
        }
        let shift = other_from_self.translation.vector;
        let meets = |index: usize| {
            // A box wholly on one side of the triangle's plane is clear of it.
            let [corner, normal] = [other.corners[index][0].coords, other.normals[index]];
            let offset = normal.dot(&(region.center.coords - corner)).abs();
            if offset > rotation.tr_mul(&normal).abs().dot(&self.aabb.half_extents) + ROUNDING_M {
                return false;
            }
            self.meets_triangle(&other.corners[index].map(|c| rotation.tr_mul(&(c.coords - shift)).into()))
        };
        if other.corners.len() <= BOX_SCAN_LIMIT {
            return other.boxes.iter().enumerate().any(|(index, at)| region.overlaps(at) && meets(index));
        }
        other.tree.near(&region).any(|index| meets(index as usize))
    }

    fn meets_triangle(&self, triangle: &[Point; 3]) -> bool {
        let region = Aabb::around(triangle, 0.0);
        if !region.overlaps(&self.aabb) {
            return false;
        }
        if self.corners.len() <= SCAN_LIMIT {
            return self.corners.iter().any(|own| triangles_meet(own, triangle));
        }
        self.tree.near(&region).any(|index| triangles_meet(&self.corners[index as usize], triangle))
    }
}

/// Returns true if two triangles share a point. The separating axes are the two normals, the nine products of edges, and
/// the six in-plane edge normals that decide the coplanar case (Ericson 2005, §5.2).
pub(crate) fn triangles_meet(a: &[Point; 3], b: &[Point; 3]) -> bool {
    let edges = |t: &[Point; 3]| [t[1] - t[0], t[2] - t[1], t[0] - t[2]];
    let separates = |axis: &Vector| {
        let reach = |t: &[Point; 3]| {
            let [x, y, z] = t.map(|corner| axis.dot(&corner.coords));
            (x.min(y).min(z), x.max(y).max(z))
        };
        let ((low_a, high_a), (low_b, high_b)) = (reach(a), reach(b));
        low_a > high_b || low_b > high_a
    };
    let (edges_a, edges_b) = (edges(a), edges(b));
    let (normal_a, normal_b) = (edges_a[0].cross(&edges_a[1]), edges_b[0].cross(&edges_b[1]));
    if separates(&normal_a) || separates(&normal_b) {
        return false;
    }
    if edges_a.iter().any(|ea| edges_b.iter().any(|eb| separates(&ea.cross(eb)))) {
        return false;
    }
    !edges_a.iter().any(|e| separates(&normal_a.cross(e)))
        && !edges_b.iter().any(|e| separates(&normal_b.cross(e)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use cranny_spatial::Stream;

    /// Returns true if an edge of one triangle pierces the other: an oracle that uses no separating axes.
    fn edges_pierce(a: &[Point; 3], b: &[Point; 3]) -> bool {
        let pierces = |edge: (Point, Point), t: &[Point; 3]| {
            let volume = |p: &Point, q: &Point, r: &Point, s: &Point| (q - p).cross(&(r - p)).dot(&(s - p));
            let (p, q) = edge;
            let (above, below) = (volume(&t[0], &t[1], &t[2], &p), volume(&t[0], &t[1], &t[2], &q));
            let sides = [0, 1, 2].map(|i| volume(&p, &q, &t[i], &t[(i + 1) % 3]));
            above * below <= 0.0 && (sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0))
        };
        let any = |s: &[Point; 3], t: &[Point; 3]| (0..3).any(|i| pierces((s[i], s[(i + 1) % 3]), t));
        any(a, b) || any(b, a)
    }

    #[test]
    fn separating_axes_agree_with_piercing_edges() {
        let mut random = Stream::new(3, 0);
        let mut meeting = 0;
        for _ in 0..20_000 {
            let mut triangle =
                || [0; 3].map(|_| Point::new(random.uniform(), random.uniform(), random.uniform()));
            let (a, b) = (triangle(), triangle());
            assert_eq!(triangles_meet(&a, &b), edges_pierce(&a, &b), "{a:?} {b:?}");
            meeting += usize::from(triangles_meet(&a, &b));
        }
        assert!((1000..19_000).contains(&meeting), "{meeting}");
    }

    #[test]
    fn a_box_inside_a_box_touches_nothing() {
        let surface = |h: f64| Surface::new(&Surface::cuboid_soup(&Vector::repeat(h))).expect("a cuboid");
        let (big, small) = (surface(1.0), surface(0.1));
        let there = Pose::translation(0.95, 0.0, 0.0);
        assert!(!small.touches(&Pose::identity(), &big, &Pose::identity()));
        assert!(small.touches(&there, &big, &Pose::identity()));
        assert!(big.touches(&Pose::identity(), &small, &there));
    }
}
