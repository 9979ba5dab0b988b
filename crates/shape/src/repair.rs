use std::collections::HashMap;

use cranny_spatial::Point;

use crate::mesh::{check_indices, signed_solid_angle};
use crate::self_crossing::shallow_crossings;
use crate::{ShapeError, TriangleSoup};

/// A mesh that encloses a volume, and what was done to make it so.
#[derive(Clone, Debug, PartialEq)]
pub struct RepairedMesh {
    /// The mesh: closed, normals outwards, no triangle deep through another.
    pub soup: TriangleSoup,
    /// Vertices that were merged with one at the same place.
    pub merged_vertices: usize,
    /// Triangles that were left out, because they had no area after that or stood there twice.
    pub dropped_triangles: usize,
    /// Triangles that were turned round.
    pub flipped_triangles: usize,
    /// Pairs of triangles that still pass through each other, by no more than the noise of a scan.
    pub shallow_crossings: usize,
}

impl RepairedMesh {
    /// Repairs what can be repaired without a guess.
    ///
    /// 1. Vertices closer than [`SAME_PLACE_M`] become one.
    /// 2. Triangles with two equal corners go; of equal triangles one stays.
    /// 3. Triangles are turned so that neighbours agree, and each body so that it faces outwards, or inwards
    ///    where it is the wall of a cavity.
    /// 4. What then has a hole, is one-sided, or passes through itself by more than a scan's noise is refused.
    ///
    /// # Errors
    /// [`ShapeError::Empty`], [`ShapeError::VertexIndex`], [`ShapeError::Open`], [`ShapeError::OneSided`],
    /// [`ShapeError::SelfCrossing`].
    pub fn of(soup: &TriangleSoup) -> Result<Self, ShapeError> {
        check_indices(soup)?;
        let (vertices, place) = merged(&soup.vertices);
        let mut triangles = Vec::new();
        let mut known = std::collections::HashSet::new();
        for triangle in &soup.triangles {
            let [a, b, c] = triangle.map(|vertex| place[vertex as usize]);
            let mut key = [a, b, c];
            key.sort_unstable();
            if a != b && b != c && c != a && known.insert(key) {
                triangles.push([a, b, c]);
            }
        }
        let dropped_triangles = soup.triangles.len() - triangles.len();
        let merged_vertices = soup.vertices.len() - vertices.len();
        let mut repaired = TriangleSoup { vertices, triangles };
        check_indices(&repaired)?;
        let flipped_triangles = orient(&mut repaired)?;
        let shallow_crossings = shallow_crossings(&repaired)?;
        let soup = repaired;
        Ok(Self { soup, merged_vertices, dropped_triangles, flipped_triangles, shallow_crossings })
    }
}

/// Vertices closer than this are one, in metres: well below the noise of any export, above the rounding of
/// single precision at a metre.
pub const SAME_PLACE_M: f64 = 1e-6;

/// The vertices without those that have one before them at the same place, and the new index of each.
fn merged(vertices: &[Point]) -> (Vec<Point>, Vec<u32>) {
    let mut kept: Vec<Point> = Vec::new();
    let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    // Coordinates are at most 1000 m, so a cell number stays far below the limits of i64.
    #[allow(clippy::cast_possible_truncation)]
    let cell = |p: &Point| [p.x, p.y, p.z].map(|x| (x / SAME_PLACE_M).floor() as i64);
    let mut place = Vec::with_capacity(vertices.len());
    for vertex in vertices {
        let [x, y, z] = cell(vertex);
        let around =
            (-1..=1).flat_map(|i| (-1..=1).flat_map(move |j| (-1..=1).map(move |k| [x + i, y + j, z + k])));
        let near = around.filter_map(|key| cells.get(&key)).flatten();
        let same = near.copied().filter(|i| (kept[*i as usize] - vertex).norm() <= SAME_PLACE_M).min();
        place.push(same.unwrap_or_else(|| {
            kept.push(*vertex);
            let index = u32::try_from(kept.len() - 1).unwrap_or(u32::MAX);
            cells.entry([x, y, z]).or_default().push(index);
            index
        }));
    }
    (kept, place)
}

/// Turns the triangles outwards; returns how many were turned.
fn orient(soup: &mut TriangleSoup) -> Result<usize, ShapeError> {
    let edges = edges_of(soup);
    let odd = edges.values().filter(|triangles| triangles.len() % 2 == 1).count();
    if odd > 0 {
        return Err(ShapeError::Open { edges: odd });
    }
    // Where more than two triangles share an edge it does not say which of them go together: such an edge is
    // not followed, only judged at the end.
    let neighbours = |triangle: usize, soup: &TriangleSoup| {
        directed_edges(soup.triangles[triangle]).map(|edge| match edges[&sorted(edge)].as_slice() {
            [a, b] => Some((if *a == triangle { *b } else { *a }, edge)),
            _ => None,
        })
    };
    let mut body = vec![usize::MAX; soup.triangles.len()];
    let mut bodies: Vec<Vec<usize>> = Vec::new();
    let mut turned = vec![false; soup.triangles.len()];
    for seed in 0..soup.triangles.len() {
        if body[seed] != usize::MAX {
            continue;
        }
        let mut members = vec![seed];
        body[seed] = bodies.len();
        let mut next = 0;
        while let Some(&triangle) = members.get(next) {
            next += 1;
            for (other, edge) in neighbours(triangle, soup).into_iter().flatten() {
                if body[other] != usize::MAX {
                    continue;
                }
                body[other] = bodies.len();
                members.push(other);
                if directed_edges(soup.triangles[other]).contains(&edge) {
                    soup.triangles[other].swap(1, 2);
                    turned[other] = true;
                }
            }
        }
        bodies.push(members);
    }
    for members in &bodies {
        let witness = soup.corners(members[0])[0];
        let around = bodies.iter().filter(|others| {
            body[others[0]] != body[members[0]]
                && solid_angle(soup, others, &witness).abs() > std::f64::consts::TAU
        });
        let is_cavity = around.count() % 2 == 1;
        let volume: f64 = members.iter().map(|&t| signed_volume(soup, t, &witness)).sum();
        if (volume < 0.0) != is_cavity {
            for &triangle in members {
                soup.triangles[triangle].swap(1, 2);
                turned[triangle] = !turned[triangle];
            }
        }
    }
    let contradicting = unbalanced_edges(soup);
    if contradicting > 0 {
        return Err(ShapeError::OneSided { edges: contradicting });
    }
    Ok(turned.iter().filter(|turned| **turned).count())
}

fn signed_volume(soup: &TriangleSoup, triangle: usize, eye: &Point) -> f64 {
    let [a, b, c] = soup.corners(triangle).map(|corner| corner - eye);
    a.dot(&b.cross(&c)) / 6.0
}

fn solid_angle(soup: &TriangleSoup, triangles: &[usize], eye: &Point) -> f64 {
    triangles.iter().map(|&t| signed_solid_angle(&soup.corners(t), eye)).sum()
}

fn directed_edges([a, b, c]: [u32; 3]) -> [(u32, u32); 3] {
    [(a, b), (b, c), (c, a)]
}

fn sorted((a, b): (u32, u32)) -> (u32, u32) {
    (a.min(b), a.max(b))
}

/// The triangles at each edge.
fn edges_of(soup: &TriangleSoup) -> HashMap<(u32, u32), Vec<usize>> {
    let mut edges: HashMap<(u32, u32), Vec<usize>> = HashMap::new();
    for (index, triangle) in soup.triangles.iter().enumerate() {
        for edge in directed_edges(*triangle) {
            edges.entry(sorted(edge)).or_default().push(index);
        }
    }
    edges
}

/// How many edges are run through more often in one direction than in the other.
fn unbalanced_edges(soup: &TriangleSoup) -> usize {
    let mut balance: HashMap<(u32, u32), i64> = HashMap::new();
    for edge in soup.triangles.iter().flat_map(|t| directed_edges(*t)) {
        *balance.entry(sorted(edge)).or_default() += if edge.0 < edge.1 { 1 } else { -1 };
    }
    balance.values().filter(|sum| **sum != 0).count()
}
