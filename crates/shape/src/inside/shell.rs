//! Closed surfaces of a mesh, even if its faces are reversed, doubled or glued together.

use crate::inside::disjoint_sets::DisjointSets;
use crate::inside::edge_use::{EdgeUse, join_around};
use crate::inside::patch::Patches;
use crate::{ShapeError, TriangleSoup};

/// Closed surface: faces connected by their edges that separate the space inside from the space outside.
#[derive(Clone, Debug)]
pub(crate) struct Shell {
    /// Its faces, by triangle; of equal triangles the first.
    pub facets: Vec<Facet>,
    /// Enclosed volume, in cubic metres; negative for the outside of components that share faces.
    pub volume_m3: f64,
    /// True if its faces belong to it alone: a component without inner walls.
    pub is_alone: bool,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Facet {
    pub triangle: u32,
    /// True if its normal points into the space that the shell encloses.
    pub is_inward: bool,
}

/// Shells of a soup with valid indices, in the order of their first triangles, and the [`first_copies`] of its triangles,
/// with equal flat patches counted as copies too.
///
/// Separates space as in Zhou et al. 2016 ("Mesh arrangements for solid geometry", §3.2): each face has two sides, and two
/// sides that meet at an edge without a face between them bound the same space. So the windings of the file do not matter, and
/// nothing can cancel.
///
/// 1. Keeps one of equal triangles as a face, and collects the faces of each edge.
/// 2. Joins the sides across an edge of two faces. Faces connected so are a patch; of flat patches with the same rim one stays.
/// 3. At an edge of more faces, a patch that is closed without the others is a component that touches them: joins its sides
///    among themselves. Joins those of the other patches around the edge, by angle; these must not meet elsewhere.
/// 4. Joined sides are a shell. The two shells of a component that shares no face are one surface; keeps the one with positive
///    volume.
///
/// # Errors
/// [`ShapeError::Open`], [`ShapeError::NarrowTriangles`], or [`ShapeError::OneSided`] if both sides of a face bound the same
/// space, or faces of connected patches cross.
pub(crate) fn shells(soup: &TriangleSoup) -> Result<(Vec<Shell>, Vec<u32>), ShapeError> {
    let mut first_copies = first_copies(&soup.triangles);
    loop {
        // 1.
        let uses = edge_uses(soup, &first_copies);
        let edges = || uses.chunk_by(|a, b| a.edge == b.edge);
        let open = edges().filter(|edge| edge.len() == 1).count();
        if open > 0 {
            return Err(ShapeError::Open { edges: open });
        }
        // 2.
        let mut sides = DisjointSets::new(2 * soup.triangles.len());
        for edge in edges().filter(|edge| edge.len() == 2) {
            join_around(&mut sides, edge);
        }
        let crowded: Vec<&[EdgeUse]> = edges().filter(|edge| edge.len() > 2).collect();
        if !crowded.is_empty() {
            let patches = Patches::of(&mut sides, &crowded);
            if patches.leave_out_equal(soup, &crowded, &mut first_copies) {
                continue;
            }
            // 3.
            let crossing = patches.join(soup, &crowded, &first_copies, &mut sides)?;
            if crossing > 0 {
                return Err(ShapeError::OneSided { faces: crossing });
            }
        }
        // 4.
        let found = shells_of_sides(soup, &first_copies, &mut sides)?;
        return Ok((found, first_copies));
    }
}

fn shells_of_sides(
    soup: &TriangleSoup,
    first_copies: &[u32],
    sides: &mut DisjointSets,
) -> Result<Vec<Shell>, ShapeError> {
    let mut of_side: Vec<(u32, u32)> = Vec::with_capacity(2 * soup.triangles.len());
    let mut one_sided = 0;
    for (triangle, &first) in (0..).zip(first_copies).filter(|(triangle, first)| triangle == *first) {
        let [front, back] = [2 * first, 2 * triangle + 1].map(|side| sides.root(side));
        one_sided += usize::from(front == back);
        of_side.extend([(front, 2 * triangle), (back, 2 * triangle + 1)]);
    }
    if one_sided > 0 {
        return Err(ShapeError::OneSided { faces: one_sided });
    }
    of_side.sort_unstable();
    let mut sizes = vec![0_u32; 2 * soup.triangles.len()];
    for (root, _) in &of_side {
        sizes[*root as usize] += 1;
    }
    let mut shells = Vec::new();
    for members in of_side.chunk_by(|a, b| a.0 == b.0) {
        let root = members[0].0;
        let across = sides.root(members[0].1 ^ 1);
        let is_alone = sizes[across as usize] == sizes[root as usize]
            && members.iter().all(|(_, side)| sides.root(side ^ 1) == across);
        if !is_alone || root < across {
            let facet = |&(_, side): &(u32, u32)| Facet { triangle: side / 2, is_inward: side % 2 == 0 };
            shells.push(Shell::of(soup, members.iter().map(facet).collect(), is_alone));
        }
    }
    shells.sort_by_key(|shell| shell.facets[0].triangle);
    Ok(shells)
}

/// First triangle with the same corners, in either winding, for each triangle; [`DEGENERATE`] for one with two equal corners.
fn first_copies(triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut sorted: Vec<([u32; 3], u32)> = (0..)
        .zip(triangles)
        .map(|(index, triangle)| {
            let mut corners = *triangle;
            corners.sort_unstable();
            (corners, index)
        })
        .collect();
    sorted.sort_unstable();
    let mut first = vec![DEGENERATE; triangles.len()];
    for copies in sorted.chunk_by(|a, b| a.0 == b.0) {
        let ([a, b, c], least) = copies[0];
        if a != b && b != c {
            for (_, copy) in copies {
                first[*copy as usize] = least;
            }
        }
    }
    first
}

pub(crate) const DEGENERATE: u32 = u32::MAX;

impl Shell {
    fn of(soup: &TriangleSoup, mut facets: Vec<Facet>, is_alone: bool) -> Self {
        // The eye is a corner of the shell, so that the sum does not cancel far from the origin.
        let eye = soup.corners(facets[0].triangle as usize)[0];
        let signed = |facet: &Facet| {
            let [a, b, c] = soup.corners(facet.triangle as usize).map(|corner| corner - eye);
            let volume_m3 = a.dot(&b.cross(&c)) / 6.0;
            if facet.is_inward { -volume_m3 } else { volume_m3 }
        };
        let mut volume_m3: f64 = facets.iter().map(signed).sum();
        if is_alone && volume_m3 < 0.0 {
            volume_m3 = -volume_m3;
            for facet in &mut facets {
                facet.is_inward = !facet.is_inward;
            }
        }
        Self { facets, volume_m3, is_alone }
    }
}

fn edge_uses(soup: &TriangleSoup, first_copies: &[u32]) -> Vec<EdgeUse> {
    let mut uses = Vec::with_capacity(3 * soup.triangles.len());
    for (index, (&[a, b, c], &first)) in (0..).zip(soup.triangles.iter().zip(first_copies)) {
        if index != first {
            continue;
        }
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let edge = u64::from(from.min(to)) << 32 | u64::from(from.max(to));
            uses.push(EdgeUse { edge, ahead: 2 * index + u32::from(from > to) });
        }
    }
    uses.sort_unstable_by_key(|at| (at.edge, at.ahead));
    uses
}
