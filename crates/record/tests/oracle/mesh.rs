//! Closed triangle meshes and their intersection test: edges against triangles, and nothing else.

use std::collections::{BTreeMap, BTreeSet};

use cranny_shape::TriangleSoup;
use cranny_spatial::{Point, Pose, Vector};

/// A closed surface of triangles.
#[derive(Clone, Debug)]
pub struct Mesh {
    pub vertices: Vec<Point>,
    pub triangles: Vec<[usize; 3]>,
    /// Every edge once.
    edges: Vec<[usize; 2]>,
}

impl Mesh {
    /// # Panics
    /// If an edge is not used equally often in both directions.
    pub fn new(vertices: Vec<Point>, triangles: Vec<[usize; 3]>) -> Self {
        let mut balance: BTreeMap<[usize; 2], i32> = BTreeMap::new();
        for &[a, b, c] in &triangles {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                let sign = if from < to { 1 } else { -1 };
                *balance.entry([from.min(to), from.max(to)]).or_default() += sign;
            }
        }
        assert!(balance.values().all(|&sum| sum == 0), "the mesh has a hole");
        Self { vertices, triangles, edges: balance.into_keys().collect() }
    }

    /// Creates a mesh in which vertices within a nanometre of each other are merged.
    ///
    /// # Panics
    /// As [`Self::new`].
    pub fn of_soup(soup: &TriangleSoup) -> Self {
        let mut known: BTreeMap<[i64; 3], usize> = BTreeMap::new();
        let mut vertices = Vec::new();
        let mut index_of = |vertex: &Point| {
            #[expect(clippy::cast_possible_truncation, reason = "a scene is no larger than a planet")]
            let key = [vertex.x, vertex.y, vertex.z].map(|value| (value * 1e9).round() as i64);
            *known.entry(key).or_insert_with(|| {
                vertices.push(*vertex);
                vertices.len() - 1
            })
        };
        let welded: Vec<usize> = soup.vertices.iter().map(&mut index_of).collect();
        let triangles = soup.triangles.iter().map(|corners| corners.map(|corner| welded[corner as usize]));
        let triangles = triangles.filter(|[a, b, c]| a != b && b != c && c != a).collect();
        Self::new(vertices, triangles)
    }

    /// Creates a cuboid centred at the origin.
    pub fn cuboid(half_extents: Vector) -> Self {
        let sign = |corner: usize, axis: usize| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 };
        let corner = |k: usize| Vector::new(sign(k, 0), sign(k, 1), sign(k, 2)).component_mul(&half_extents);
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Self::new((0..8).map(|k| corner(k).into()).collect(), triangles)
    }

    /// Returns the pieces that share no vertex, each closed.
    pub fn pieces(&self) -> Vec<Self> {
        let mut label: Vec<usize> = (0..self.vertices.len()).collect();
        // Every edge passes the lower label on, until nothing changes.
        let mut changed = true;
        while changed {
            changed = false;
            for &[a, b] in &self.edges {
                let low = label[a].min(label[b]);
                changed |= label[a] != low || label[b] != low;
                (label[a], label[b]) = (low, low);
            }
        }
        let labels: BTreeSet<usize> = self.triangles.iter().map(|t| label[t[0]]).collect();
        let piece = |wanted: usize| {
            let triangles = self.triangles.iter().copied().filter(|t| label[t[0]] == wanted).collect();
            Self::new(self.vertices.clone(), triangles).without_unused_vertices()
        };
        labels.into_iter().map(piece).collect()
    }

    /// Returns this surface without unused vertices; the others keep their order.
    #[must_use]
    pub fn without_unused_vertices(&self) -> Self {
        let used: BTreeSet<usize> = self.triangles.iter().flatten().copied().collect();
        let position: BTreeMap<usize, usize> =
            used.iter().enumerate().map(|(new, &old)| (old, new)).collect();
        let vertices = used.iter().map(|&old| self.vertices[old]).collect();
        Self::new(vertices, self.triangles.iter().map(|t| t.map(|old| position[&old])).collect())
    }

    /// Returns the mesh at a pose in the root frame.
    pub fn placed(&self, root_from_mesh: &Pose) -> Placed<'_> {
        let mut placed = Placed { mesh: self, vertices: self.vertices.clone(), bounds: Bounds::NOTHING };
        placed.move_to(root_from_mesh);
        placed
    }
}

/// A mesh at a pose in the root frame.
#[derive(Clone, Debug)]
pub struct Placed<'a> {
    mesh: &'a Mesh,
    pub vertices: Vec<Point>,
    pub bounds: Bounds,
}

impl Placed<'_> {
    pub fn move_to(&mut self, root_from_mesh: &Pose) {
        let rotation = root_from_mesh.rotation.to_rotation_matrix();
        for (placed, vertex) in self.vertices.iter_mut().zip(&self.mesh.vertices) {
            *placed = rotation * vertex + root_from_mesh.translation.vector;
        }
        self.bounds = Bounds::around(&self.vertices);
    }

    /// Returns true if the two solids share a point: their surfaces cross, or one lies inside the other.
    pub fn meets(&self, other: &Self) -> bool {
        let shared = self.bounds.intersection(&other.bounds);
        !shared.is_empty()
            && (self.has_edge_through(other, &shared)
                || other.has_edge_through(self, &shared)
                || self.lies_within(other)
                || other.lies_within(self))
    }

    /// Returns true if an edge of this mesh crosses a triangle of `other`. Both meshes can only cross within `shared`.
    fn has_edge_through(&self, other: &Self, shared: &Bounds) -> bool {
        let edges: Vec<_> = self.those_near(&self.mesh.edges, shared).collect();
        !edges.is_empty()
            && other.those_near(&other.mesh.triangles, shared).any(|(triangle, bounds)| {
                edges.iter().any(|(edge, near)| near.meets(&bounds) && goes_through(edge, &triangle))
            })
    }

    /// Returns the corners and bounds of those edges or triangles that do not lie beyond one side of `region`.
    fn those_near<const N: usize>(
        &self,
        pieces: &[[usize; N]],
        region: &Bounds,
    ) -> impl Iterator<Item = ([Point; N], Bounds)> {
        let sides: Vec<u8> = self.vertices.iter().map(|vertex| region.sides_beyond(vertex)).collect();
        let is_near =
            move |piece: &&[usize; N]| piece.iter().fold(u8::MAX, |all, &vertex| all & sides[vertex]) == 0;
        pieces.iter().filter(is_near).map(|piece| {
            let corners = piece.map(|vertex| self.vertices[vertex]);
            (corners, Bounds::around(&corners))
        })
    }

    /// Returns true if this mesh lies inside `other`, given that their surfaces do not cross, so that one vertex decides.
    fn lies_within(&self, other: &Self) -> bool {
        other.bounds.contain(&self.bounds) && other.contains(&self.vertices[0])
    }

    /// Returns true if `point` lies inside: a ray from it meets the surface an odd number of times. The majority of three rays
    /// decides, because one may run along an edge.
    fn contains(&self, point: &Point) -> bool {
        /// Ray length beyond any scene, in metres.
        const RAY_M: f64 = 100.0;
        let directions = [
            Vector::new(0.267, 0.535, 0.802),
            Vector::new(-0.81, 0.31, 0.497),
            Vector::new(0.13, -0.79, 0.6),
        ];
        let is_odd = |direction: &&Vector| {
            let ray = [*point, point + **direction * RAY_M];
            let triangles = self.mesh.triangles.iter().map(|t| t.map(|vertex| self.vertices[vertex]));
            triangles.filter(|triangle| goes_through(&ray, triangle)).count() % 2 == 1
        };
        directions.iter().filter(is_odd).count() >= 2
    }
}

/// Returns true if the segment has a point in common with the triangle, touching included. A segment in the plane of the
/// triangle does not count: a neighbouring edge or triangle shows any crossing there.
pub fn goes_through([p, q]: &[Point; 2], [a, b, c]: &[Point; 3]) -> bool {
    let (before, after) = (volume(a, b, c, p), volume(a, b, c, q));
    if (before > 0.0 && after > 0.0) || (before < 0.0 && after < 0.0) || (before == 0.0 && after == 0.0) {
        return false;
    }
    let sides = [volume(p, q, a, b), volume(p, q, b, c), volume(p, q, c, a)];
    sides.iter().all(|&side| side >= 0.0) || sides.iter().all(|&side| side <= 0.0)
}

/// Returns six times the signed volume of the tetrahedron.
fn volume(a: &Point, b: &Point, c: &Point, d: &Point) -> f64 {
    (b - a).cross(&(c - a)).dot(&(d - a))
}

/// A box along the axes of the root frame.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    pub low: Vector,
    pub high: Vector,
}

impl Bounds {
    const NOTHING: Self = Self {
        low: Vector::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        high: Vector::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    pub fn around(points: &[Point]) -> Self {
        points.iter().fold(Self::NOTHING, |bounds, point| Self {
            low: bounds.low.inf(&point.coords),
            high: bounds.high.sup(&point.coords),
        })
    }

    pub fn corners(&self) -> [Point; 8] {
        let ends = [self.low, self.high];
        std::array::from_fn(|k| Point::new(ends[k & 1].x, ends[k >> 1 & 1].y, ends[k >> 2].z))
    }

    fn intersection(&self, other: &Self) -> Self {
        Self { low: self.low.sup(&other.low), high: self.high.inf(&other.high) }
    }

    fn is_empty(&self) -> bool {
        (0..3).any(|axis| self.low[axis] > self.high[axis])
    }

    /// Returns one bit for each of the six sides that the point lies beyond.
    fn sides_beyond(&self, point: &Point) -> u8 {
        let beyond = |axis: usize| {
            u8::from(point[axis] < self.low[axis]) | u8::from(point[axis] > self.high[axis]) << 1
        };
        beyond(0) | beyond(1) << 2 | beyond(2) << 4
    }

    fn meets(&self, other: &Self) -> bool {
        (0..3).all(|axis| self.low[axis] <= other.high[axis] && other.low[axis] <= self.high[axis])
    }

    fn contain(&self, other: &Self) -> bool {
        (0..3).all(|axis| self.low[axis] <= other.low[axis] && other.high[axis] <= self.high[axis])
    }
}
