use std::sync::Arc;

use cranny_spatial::{Point, Vector};

use crate::distance::convex::{Convex, Core, HullPoints};
use crate::distance::triangle_tree::TriangleTree;
use crate::inside::disjoint_sets::DisjointSets;
use crate::inside::enclosure::{Enclosure, Inside};
use crate::inside::small_holes::{Closed, closed};
use crate::{Aabb, Ball, Bounds, MeshRepairs, ShapeError, TriangleSoup, distance::parry};

/// A closed triangle mesh and the volume that it encloses.
#[derive(Clone, Debug)]
pub(crate) struct Mesh {
    triangles: Vec<Convex>,
    balls: Vec<Ball>,
    tree: TriangleTree,
    /// Convex hull of all vertices, which contains the mesh; `None` for more than [`MOST_CORNERS`].
    hull: Option<Core>,
    /// `None` for a surface that encloses nothing.
    inside: Option<Inside>,
    witnesses: Vec<Point>,
    repairs: MeshRepairs,
}

impl Mesh {
    /// # Errors
    /// [`ShapeError::Empty`], [`ShapeError::VertexIndex`], [`ShapeError::Open`], [`ShapeError::OneSided`].
    pub fn new(soup: &TriangleSoup) -> Result<Self, ShapeError> {
        let Enclosure { soup, inside, repairs } = Enclosure::of(soup)?;
        let corners: Vec<[Point; 3]> = (0..soup.triangles.len()).map(|t| soup.corners(t)).collect();
        Ok(Self { inside: Some(inside), ..Self::of_corners(&corners, one_vertex_per_body(&soup), repairs) })
    }

    /// Mesh whose small holes, if any, are closed first.
    ///
    /// # Errors
    /// As [`Self::new`]; [`ShapeError::Open`] for a hole that is not small.
    pub fn with_small_holes(soup: &TriangleSoup) -> Result<Self, ShapeError> {
        let fault = match Self::new(soup) {
            Err(fault @ ShapeError::Open { .. }) => fault,
            known => return known,
        };
        let Closed { soup, holes } = closed(soup).ok_or(fault)?;
        let mut mesh = Self::new(&soup)?;
        mesh.repairs.closed_holes = holes;
        Ok(mesh)
    }

    /// Surface higher than `height_m` (m) along the unit vector `direction` (mesh frame), which encloses nothing; `None` if
    /// nothing is that high.
    pub fn above(&self, direction: &Vector, height_m: f64) -> Option<Self> {
        let higher = |corner: &Point| direction.dot(&corner.coords) - height_m;
        let mut kept: Vec<[Point; 3]> = Vec::new();
        for triangle in self.triangles.iter().map(corners) {
            let polygon = cut_off(&triangle, higher);
            kept.extend((2..polygon.len()).map(|last| [polygon[0], polygon[last - 1], polygon[last]]));
        }
        let repairs = MeshRepairs { triangles: kept.len(), ..self.repairs };
        (!kept.is_empty()).then(|| Self::of_corners(&kept, vec![kept[0][0]], repairs))
    }

    fn of_corners(corners: &[[Point; 3]], witnesses: Vec<Point>, repairs: MeshRepairs) -> Self {
        let triangles = corners.iter().map(triangle).collect();
        let balls = corners.iter().map(|t| Bounds::around(&t.map(|corner| (corner, 0.0))).ball).collect();
        let tree = TriangleTree::new(corners);
        Self { triangles, balls, tree, hull: hull_of(corners), inside: None, witnesses, repairs }
    }

    pub fn repairs(&self) -> &MeshRepairs {
        &self.repairs
    }

    /// One vertex of every component of the mesh. If none of them lies inside a solid whose surface the mesh does not cross,
    /// the mesh lies wholly outside it.
    pub fn witnesses(&self) -> &[Point] {
        &self.witnesses
    }

    pub fn triangles(&self) -> &[Convex] {
        &self.triangles
    }

    /// Convex core that contains the mesh and has every corner as a vertex; `None` if there are too many.
    pub fn hull(&self) -> Option<&Core> {
        self.hull.as_ref()
    }

    pub fn vertices(&self) -> impl Iterator<Item = Point> {
        self.triangles.iter().flat_map(corners)
    }

    /// Corners of at most [`MOST_PIECES`] pieces of the surface, each of neighbouring triangles.
    pub fn pieces(&self) -> Vec<Vec<Point>> {
        let mut triangles: Vec<[Point; 3]> = self.triangles.iter().map(corners).collect();
        let mut pieces = Vec::new();
        split(&mut triangles, MOST_PIECES, &mut pieces);
        pieces
    }

    /// Indices of the triangles whose boxes meet `region` (mesh frame).
    pub fn triangles_near(&self, region: &Aabb) -> Vec<u32> {
        self.tree.near(region).collect()
    }

    /// Calls `visit` with triangles within `reach_m` (m), as [`TriangleTree::nearest`] does. `gap_m` returns a lower
    /// bound of the distance to a ball (mesh frame).
    pub fn nearest_triangles(
        &self,
        gap_m: impl Fn(&Ball) -> f64,
        reach_m: f64,
        visit: impl Fn(u32, f64) -> f64,
    ) {
        let of_triangle = |triangle: u32, reach_m: f64| {
            let is_far = gap_m(&self.balls[triangle as usize]) > reach_m;
            if is_far { reach_m } else { visit(triangle, reach_m) }
        };
        self.tree.nearest(&gap_m, reach_m, of_triangle);
    }

    /// Returns true if the volume contains `point` (mesh frame). Components that touch or overlap are all solid.
    pub fn contains(&self, point: &Point) -> bool {
        let corners = |triangle: u32| corners(&self.triangles[triangle as usize]);
        self.inside.as_ref().is_some_and(|inside| inside.contains(&self.tree, corners, point))
    }

    /// Corners of the triangles whose boxes meet `region` (mesh frame).
    pub fn corners_near(&self, region: &Aabb) -> impl Iterator<Item = [Point; 3]> {
        self.tree.near(region).map(|triangle| corners(&self.triangles[triangle as usize]))
    }
}

/// Maximum number of vertices for which a scan of all is faster than a search of the nearby triangles.
const MOST_CORNERS: usize = 16_000;

fn hull_of(corners: &[[Point; 3]]) -> Option<Core> {
    let vertices = each_once(corners.iter().flatten().copied().collect());
    let vertices: Vec<_> = vertices.iter().map(parry::point).collect();
    (vertices.len() <= MOST_CORNERS).then(|| Core::Hull(Arc::new(HullPoints::new(&vertices))))
}

/// Returns the points in ascending order, each once. The corners of the triangles of a mesh have each vertex about six times.
pub(crate) fn each_once(mut points: Vec<Point>) -> Vec<Point> {
    let order = |a: &Point, b: &Point| {
        a.x.total_cmp(&b.x).then_with(|| a.y.total_cmp(&b.y)).then_with(|| a.z.total_cmp(&b.z))
    };
    points.sort_unstable_by(order);
    points.dedup();
    points
}

/// Region of a triangle with positive height: a convex polygon, corners in order.
fn cut_off(triangle: &[Point; 3], height_m: impl Fn(&Point) -> f64) -> Vec<Point> {
    let mut polygon = Vec::new();
    for (index, a) in triangle.iter().enumerate() {
        let b = &triangle[(index + 1) % 3];
        let (of_a, of_b) = (height_m(a), height_m(b));
        if of_a > 0.0 {
            polygon.push(*a);
        }
        if (of_a > 0.0) != (of_b > 0.0) {
            polygon.push(a + (b - a) * (of_a / (of_a - of_b)));
        }
    }
    polygon
}

/// Solid angle of a triangle seen from `eye` (van Oosterom & Strackee 1983, "The solid angle of a plane triangle",
/// whole); positive if the eye sees the back of the triangle.
pub(crate) fn signed_solid_angle(corners: &[Point; 3], eye: &Point) -> f64 {
    let [a, b, c] = corners.map(|corner| corner - eye);
    let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
    let denominator = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
    2.0 * libm::atan2(a.dot(&b.cross(&c)), denominator)
}

/// Maximum number of pieces; more pieces reduce the bulge only a little.
const MOST_PIECES: usize = 32;

/// Halves triangles across the longest side of the box around their first corners, until there are `most` pieces.
fn split(triangles: &mut [[Point; 3]], most: usize, pieces: &mut Vec<Vec<Point>>) {
    /// Maximum number of triangles that are not halved; their halves are no closer to convex.
    const FEWEST: usize = 8;
    if most <= 1 || triangles.len() <= FEWEST {
        pieces.push(triangles.iter().flatten().copied().collect());
        return;
    }
    let firsts: Vec<Point> = triangles.iter().map(|triangle| triangle[0]).collect();
    let axis = Aabb::around(&firsts, 0.0).half_extents.imax();
    let middle = triangles.len() / 2;
    triangles.select_nth_unstable_by(middle, |a, b| a[0][axis].total_cmp(&b[0][axis]));
    let (low, high) = triangles.split_at_mut(middle);
    split(low, most / 2, pieces);
    split(high, most / 2, pieces);
}

fn triangle(corners: &[Point; 3]) -> Convex {
    Convex::sharp(Core::Triangle(corners.map(|corner| parry::point(&corner))))
}

fn corners(triangle: &Convex) -> [Point; 3] {
    match triangle.core {
        Core::Triangle(corners) => corners.map(|p| Point::new(p.x, p.y, p.z)),
        _ => unreachable!("a mesh is made of triangles"),
    }
}

/// First vertex of every set of triangles that are connected by vertices.
fn one_vertex_per_body(soup: &TriangleSoup) -> Vec<Point> {
    let mut bodies = DisjointSets::new(soup.vertices.len());
    for &[a, b, c] in &soup.triangles {
        bodies.join(a, b);
        bodies.join(b, c);
    }
    let mut roots: Vec<u32> = soup.triangles.iter().map(|triangle| bodies.root(triangle[0])).collect();
    roots.sort_unstable();
    roots.dedup();
    roots.into_iter().map(|vertex| soup.vertices[vertex as usize]).collect()
}
