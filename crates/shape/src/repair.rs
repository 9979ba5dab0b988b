use serde::Serialize;

use crate::closed_mesh::check_indices;
use crate::enclosure::Nest;
use crate::same_place::merged;
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
    /// 1. Vertices closer than [`SAME_PLACE_M`](crate::SAME_PLACE_M) become one.
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
