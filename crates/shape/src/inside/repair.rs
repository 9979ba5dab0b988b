use std::collections::HashSet;

use serde::Serialize;

use crate::inside::closed_mesh::check_indices;
use crate::inside::enclosure::{Nest, cavities};
use crate::inside::same_place::merged;
use crate::inside::self_crossing::shallow_crossings;
use crate::inside::shell::shells;
use crate::{ShapeError, TriangleSoup};

/// A mesh that encloses a volume, and what was done to make it so.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RepairedMesh {
    /// The mesh: closed, normals outwards, no triangle deep through another.
    #[serde(skip)]
    pub soup: TriangleSoup,
    /// Vertices that were merged with one at the same place.
    pub merged_vertices: usize,
    /// Triangles that were left out, because they had no area after that, stood there twice, or are inside what is full.
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
    ///    where it is the wall of a cavity ([`Solid::mesh`](crate::Solid::mesh) has the same cavities).
    /// 4. What then has a hole, is one-sided, or passes through itself by more than a scan's noise is refused.
    /// 5. Bodies wholly inside what is full go: they are no part of the surface, and would count twice.
    ///
    /// # Errors
    /// [`ShapeError::Empty`], [`ShapeError::VertexIndex`], [`ShapeError::Open`], [`ShapeError::OneSided`],
    /// [`ShapeError::SelfCrossing`].
    pub fn of(soup: &TriangleSoup) -> Result<Self, ShapeError> {
        check_indices(soup)?;
        let (vertices, place) = merged(&soup.vertices);
        let mut triangles = Vec::new();
        let mut known = HashSet::new();
        for triangle in &soup.triangles {
            let [a, b, c] = triangle.map(|vertex| place[vertex as usize]);
            let mut key = [a, b, c];
            key.sort_unstable();
            if a != b && b != c && c != a && known.insert(key) {
                triangles.push([a, b, c]);
            }
        }
        let merged_vertices = soup.vertices.len() - vertices.len();
        let mut repaired = TriangleSoup { vertices, triangles };
        check_indices(&repaired)?;
        let (flipped_triangles, inner) = orient(&mut repaired)?;
        let shallow_crossings = shallow_crossings(&repaired)?;
        let mut index = 0..;
        repaired.triangles.retain(|_| index.next().is_none_or(|index| !inner.contains(&index)));
        let dropped_triangles = soup.triangles.len() - repaired.triangles.len();
        let soup = repaired;
        Ok(Self { soup, merged_vertices, dropped_triangles, flipped_triangles, shallow_crossings })
    }
}

/// Turns the triangles outwards; returns how many were turned, and which are inside what is full.
fn orient(soup: &mut TriangleSoup) -> Result<(usize, HashSet<u32>), ShapeError> {
    let (bodies, _) = shells(soup)?;
    let shared: usize = bodies.iter().filter(|body| !body.is_alone).map(|body| body.facets.len()).sum();
    if shared > 0 {
        return Err(ShapeError::OneSided { faces: shared });
    }
    let (mut turned, mut inner) = (Vec::new(), HashSet::new());
    let cavity_of = cavities(soup, &bodies);
    let nest = Nest::new(soup, &bodies);
    for (index, body) in bodies.iter().enumerate() {
        let around = nest.around(index);
        let is_hollow_here =
            |outer: u32| around.iter().any(|shell| cavity_of[*shell as usize] == Some(outer));
        let is_full_here = around.iter().any(|&outer| {
            let is_body = cavity_of[outer as usize].is_none();
            is_body && cavity_of[index] != Some(outer) && !is_hollow_here(outer)
        });
        if is_full_here {
            inner.extend(body.facets.iter().map(|facet| facet.triangle));
            continue;
        }
        let is_cavity = cavity_of[index].is_some();
        turned.extend(body.facets.iter().filter(|facet| facet.is_inward != is_cavity).map(|f| f.triangle));
    }
    for &triangle in &turned {
        soup.triangles[triangle as usize].swap(1, 2);
    }
    Ok((turned.len(), inner))
}
