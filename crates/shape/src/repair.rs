use std::collections::HashMap;

use cranny_spatial::Point;
use serde::Serialize;

use crate::enclosure::Nest;
use crate::mesh::check_indices;
use crate::self_crossing::shallow_crossings;
use crate::shell::shells;
use crate::{ShapeError, TriangleSoup};

/// A mesh that encloses a volume, and what was done to make it so.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RepairedMesh {
    /// The mesh: closed, normals outwards, no triangle deep through another.
    #[serde(skip)]
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

/// What was done to the triangles of a mesh so that its inside is well defined.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MeshRepairs {
    /// How many triangles there were.
    pub triangles: usize,
    /// Vertices that were taken for one with another at the same place.
    pub merged_vertices: usize,
    /// Triangles that were turned to face outwards.
    pub flipped_triangles: usize,
    /// Triangles that were left out because they stood there twice.
    pub doubled_triangles: usize,
}

impl MeshRepairs {
    /// Whether anything had to be done.
    pub fn is_any(&self) -> bool {
        self.merged_vertices + self.flipped_triangles + self.doubled_triangles > 0
    }
}

impl std::fmt::Display for MeshRepairs {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let triangles = self.triangles;
        let done = [
            (self.flipped_triangles, format!("of {triangles} triangles turned to face outwards")),
            (self.doubled_triangles, format!("of {triangles} triangles left out that stand there twice")),
            (self.merged_vertices, "vertices joined with others less than 1 µm away".to_owned()),
        ];
        let said: Vec<String> = done
            .iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, what)| format!("{count} {what}"))
            .collect();
        write!(f, "its mesh was repaired: {}", said.join(", "))
    }
}

/// Vertices closer than this are one, in metres: well below the noise of any export, above the rounding of
/// single precision at a metre.
pub const SAME_PLACE_M: f64 = 1e-6;

/// The vertices without those that have one before them at the same place, and the new index of each.
pub(crate) fn merged(vertices: &[Point]) -> (Vec<Point>, Vec<u32>) {
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
    let (bodies, _) = shells(soup)?;
    let shared: usize = bodies.iter().filter(|body| !body.is_alone).map(|body| body.facets.len()).sum();
    if shared > 0 {
        return Err(ShapeError::OneSided { faces: shared });
    }
    let mut turned = Vec::new();
    let nest = Nest::new(soup, &bodies);
    for (index, body) in bodies.iter().enumerate() {
        let is_cavity = nest.around(index).len() % 2 == 1;
        turned.extend(body.facets.iter().filter(|facet| facet.is_inward != is_cavity).map(|f| f.triangle));
    }
    for &triangle in &turned {
        soup.triangles[triangle as usize].swap(1, 2);
    }
    Ok(turned.len())
}
