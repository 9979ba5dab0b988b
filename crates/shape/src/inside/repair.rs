use std::collections::HashSet;

use serde::Serialize;

use crate::inside::closed_mesh::check_indices;
use crate::inside::enclosure::{Nest, cavities};
use crate::inside::same_place::merged;
use crate::inside::self_crossing::shallow_crossings;
use crate::inside::shell::shells;
use crate::{ShapeError, TriangleSoup};

/// Mesh that encloses a volume, and the repairs that it needed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RepairedMesh {
    /// Repaired mesh: closed, normals outwards, no triangle deep through another.
    #[serde(skip)]
    pub soup: TriangleSoup,
    /// Number of vertices merged with one at the same position.
    pub merged_vertices: usize,
    /// Number of triangles left out: without area after the merge, duplicates, or inside a solid region.
    pub dropped_triangles: usize,
    /// Number of triangles whose winding was reversed.
    pub flipped_triangles: usize,
    /// Number of pairs of triangles that still pass through each other, by no more than the noise of a scan.
    pub shallow_crossings: usize,
}

impl RepairedMesh {
    /// Makes all repairs that need no guess.
    ///
    /// 1. Merges vertices closer than [`VERTEX_MERGE_M`](crate::VERTEX_MERGE_M).
    /// 2. Removes triangles with two equal corners, and duplicate triangles.
    /// 3. Turns triangles so that neighbours agree, and each component so that it faces outwards, or inwards if it is the wall
    ///    of a cavity ([`Solid::mesh`](crate::Solid::mesh) has the same cavities).
    /// 4. Rejects a mesh that has a hole, is one-sided, or passes through itself by more than the noise of a scan.
    /// 5. Removes components wholly inside a solid region: they are not on the surface, and would count twice.
    ///
    /// # Errors
    /// [`ShapeError::Empty`], [`ShapeError::VertexIndex`], [`ShapeError::Open`], [`ShapeError::OneSided`],
    /// [`ShapeError::SelfCrossing`], [`ShapeError::NarrowTriangles`], [`ShapeError::NestedBodies`],
    /// [`ShapeError::ManyBodies`].
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
        let soup = if dropped_triangles > 0 { without_unused_vertices(&repaired) } else { repaired };
        Ok(Self { soup, merged_vertices, dropped_triangles, flipped_triangles, shallow_crossings })
    }
}

/// Returns the triangles with the vertices that they use, in their order.
fn without_unused_vertices(soup: &TriangleSoup) -> TriangleSoup {
    let mut index = vec![None; soup.vertices.len()];
    for vertex in soup.triangles.iter().flatten() {
        index[*vertex as usize] = Some(0);
    }
    for (new, count) in index.iter_mut().flatten().zip(0_u32..) {
        *new = count;
    }
    let used = soup.vertices.iter().zip(&index).filter_map(|(vertex, new)| new.map(|_| *vertex));
    let renamed = soup.triangles.iter().map(|triangle| triangle.map(|v| index[v as usize].unwrap_or(0)));
    TriangleSoup { vertices: used.collect(), triangles: renamed.collect() }
}

/// Turns the triangles outwards; returns the number of turned ones, and those inside a solid region.
fn orient(soup: &mut TriangleSoup) -> Result<(usize, HashSet<u32>), ShapeError> {
    let (bodies, _) = shells(soup)?;
    let shared: usize = bodies.iter().filter(|body| !body.is_alone).map(|body| body.facets.len()).sum();
    if shared > 0 {
        return Err(ShapeError::OneSided { faces: shared });
    }
    let (mut turned, mut inner) = (Vec::new(), HashSet::new());
    let cavity_of = cavities(soup, &bodies)?;
    let mut nest = Nest::new(soup, &bodies);
    for (index, body) in bodies.iter().enumerate() {
        let around = nest.around(index)?;
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
