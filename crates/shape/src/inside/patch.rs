use std::collections::BTreeMap;
use std::ops::ControlFlow;

use cranny_spatial::{Point, Vector};

use crate::distance::ray::triangle_normal;
use crate::inside::disjoint_sets::DisjointSets;
use crate::inside::edge_use::{EdgeUse, join_around};
use crate::inside::near_pairs::visit_near_pairs;
use crate::surface::triangles_meet;
use crate::{ShapeError, TriangleSoup};

/// Patches: faces connected by edges of two faces. The lesser of its two sides identifies a patch.
pub(crate) struct Patches {
    /// Side of a patch to which each side of a face belongs.
    side_of: Vec<u32>,
    /// True for a patch that is closed by itself.
    is_closed: Vec<bool>,
}

impl Patches {
    /// Patches of the joined sides, with the edges of more than two faces.
    pub fn of(sides: &mut DisjointSets, crowded: &[&[EdgeUse]]) -> Self {
        let side_of: Vec<u32> = (0..sides.len()).map(|side| sides.root(side)).collect();
        let mut patches = Self { is_closed: vec![true; side_of.len()], side_of };
        for (patch, _) in patches.rims(crowded) {
            patches.is_closed[patch as usize] = false;
        }
        patches
    }

    /// Makes the triangles of flat patches with the same rim copies of the first of them; returns true if there were any.
    pub fn leave_out_equal(
        &self,
        soup: &TriangleSoup,
        crowded: &[&[EdgeUse]],
        first_copies: &mut [u32],
    ) -> bool {
        let mut rims = self.rims(crowded);
        rims.sort_unstable();
        let mut by_rim: BTreeMap<Vec<u64>, Vec<u32>> = BTreeMap::new();
        for rim in rims.chunk_by(|a, b| a.0 == b.0) {
            by_rim.entry(rim.iter().map(|(_, edge)| *edge).collect()).or_default().push(rim[0].0);
        }
        by_rim.retain(|_, patches| patches.len() > 1);
        if by_rim.is_empty() {
            return false;
        }
        let mut members: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for triangle in self.open_faces(first_copies) {
            members.entry(self.patch(2 * triangle)).or_default().push(triangle);
        }
        let mut is_any = false;
        for equal in by_rim.values() {
            let kept = members[&equal[0]][0];
            let normal = triangle_normal(&soup.corners(kept as usize));
            let is_flat = |patch: &u32| {
                let mut normals = members[patch].iter().map(|t| triangle_normal(&soup.corners(*t as usize)));
                normal.norm() > 0.0 && normals.all(|other| other.cross(&normal).norm() < ONE_PLANE_RAD)
            };
            if is_flat(&equal[0]) {
                for triangle in equal[1..].iter().filter(|patch| is_flat(patch)).flat_map(|p| &members[p]) {
                    first_copies[*triangle as usize] = kept;
                    is_any = true;
                }
            }
        }
        for triangle in 0..first_copies.len() {
            // The original of these copies has become a copy itself.
            if let Some(&first) = first_copies.get(first_copies[triangle] as usize) {
                first_copies[triangle] = first;
            }
        }
        is_any
    }

    /// Joins the sides at the edges of more than two faces. Returns the number of faces of connected patches that also meet
    /// elsewhere, because the space between them is then undefined.
    ///
    /// # Errors
    /// [`ShapeError::NarrowTriangles`].
    pub fn join(
        &self,
        soup: &TriangleSoup,
        crowded: &[&[EdgeUse]],
        first_copies: &[u32],
        sides: &mut DisjointSets,
    ) -> Result<usize, ShapeError> {
        let mut complexes = DisjointSets::new(self.side_of.len());
        let mut crossing = 0;
        for edge in crowded {
            let mut uses = edge.to_vec();
            uses.sort_by_key(|at| (self.group(*at), at.ahead));
            for group in uses.chunk_by(|a, b| self.group(*a) == self.group(*b)) {
                let mut by_angle = angles(soup, group);
                by_angle.sort_by(|a, b| a.0.total_cmp(&b.0));
                let ordered: Vec<EdgeUse> = by_angle.iter().map(|(_, at)| *at).collect();
                join_around(sides, &ordered);
                if self.group(group[0]) == OPEN {
                    for at in group {
                        complexes.join(self.patch(group[0].ahead), self.patch(at.ahead));
                    }
                    if group.len() > 2 {
                        crossing += faces_in_one_plane(&by_angle);
                    }
                }
            }
        }
        Ok(crossing + self.crossing_faces(soup, first_copies, &mut complexes)?)
    }

    /// Patch of a side.
    fn patch(&self, side: u32) -> u32 {
        self.side_of[side as usize].min(self.side_of[(side ^ 1) as usize])
    }

    /// Patch of a face at an edge, if the patch is closed; [`OPEN`] for all open patches.
    fn group(&self, at: EdgeUse) -> u32 {
        let patch = self.patch(at.ahead);
        if self.is_closed[patch as usize] { patch } else { OPEN }
    }

    fn open_faces(&self, first_copies: &[u32]) -> Vec<u32> {
        let faces = (0..).zip(first_copies).filter(|(triangle, first)| triangle == *first);
        let open = faces.filter(|(triangle, _)| !self.is_closed[self.patch(2 * triangle) as usize]);
        open.map(|(triangle, _)| triangle).collect()
    }

    /// Pairs of a patch and an edge at which it ends.
    fn rims(&self, crowded: &[&[EdgeUse]]) -> Vec<(u32, u64)> {
        let mut rims = Vec::new();
        for edge in crowded {
            let mut here: Vec<u32> = edge.iter().map(|at| self.patch(at.ahead)).collect();
            here.sort_unstable();
            let ends = here.chunk_by(|a, b| a == b).filter(|uses| uses.len() % 2 == 1);
            rims.extend(ends.map(|uses| (uses[0], edge[0].edge)));
        }
        rims
    }

    /// Number of faces of open patches that meet others of the same complex, except at common corners and edges.
    fn crossing_faces(
        &self,
        soup: &TriangleSoup,
        first_copies: &[u32],
        complexes: &mut DisjointSets,
    ) -> Result<usize, ShapeError> {
        let faces = self.open_faces(first_copies);
        let corners: Vec<[Point; 3]> = faces.iter().map(|face| soup.corners(*face as usize)).collect();
        let complex: Vec<u32> = faces.iter().map(|face| complexes.root(self.patch(2 * face))).collect();
        if faces.is_empty() {
            return Ok(0);
        }
        let triangles: Vec<[u32; 3]> = faces.iter().map(|face| soup.triangles[*face as usize]).collect();
        let mut meets_another = vec![false; faces.len()];
        visit_near_pairs(&triangles, &corners, |face, other| {
            if !meets_another[face] && complex[face] == complex[other] {
                let [one, two] = [triangles[face], triangles[other]];
                let shared: Vec<usize> = (0..3).filter(|&corner| two.contains(&one[corner])).collect();
                meets_another[face] = match shared[..] {
                    [] => triangles_meet(&corners[face], &corners[other]),
                    [corner] => {
                        let same = two.iter().position(|v| *v == one[corner]).unwrap_or(0);
                        triangles_meet(&without_corner(&corners[face], corner), &corners[other])
                            || triangles_meet(&corners[face], &without_corner(&corners[other], same))
                    }
                    _ => false,
                };
            }
            ControlFlow::Continue(())
        })?;
        Ok(meets_another.into_iter().filter(|meets| *meets).count())
    }
}

const OPEN: u32 = u32::MAX;

/// Angle below which faces at one edge are in one plane, in radians. Flat sides read from a file in single precision
/// differ by 1e-5.
const ONE_PLANE_RAD: f64 = 1e-4;

/// A triangle with one corner moved in by a thousandth of its height.
fn without_corner(corners: &[Point; 3], corner: usize) -> [Point; 3] {
    let mut cut = *corners;
    let middle = (corners[(corner + 1) % 3].coords + corners[(corner + 2) % 3].coords) * 0.5;
    cut[corner] += (middle - corners[corner].coords) * 1e-3;
    cut
}

/// Number of the faces around an edge, in their order, that lie on the face before them.
fn faces_in_one_plane(by_angle: &[(f64, EdgeUse)]) -> usize {
    let before = |index: usize| by_angle[(index + by_angle.len() - 1) % by_angle.len()].0;
    let gap = |index: usize| (by_angle[index].0 - before(index)).rem_euclid(std::f64::consts::TAU);
    (0..by_angle.len()).filter(|index| gap(*index) < ONE_PLANE_RAD).count()
}

/// Angle of each face about the edge, from the first face, in radians.
fn angles(soup: &TriangleSoup, group: &[EdgeUse]) -> Vec<(f64, EdgeUse)> {
    let vertex = |index: u64| -> Point { soup.vertices[usize::try_from(index).unwrap_or(usize::MAX)] };
    let (low, high) = (group[0].edge >> 32, group[0].edge & u64::from(u32::MAX));
    let foot = vertex(low);
    let axis = (vertex(high) - foot).try_normalize(0.0).unwrap_or_else(Vector::zeros);
    let across = |at: &EdgeUse| {
        let corners = soup.triangles[at.ahead as usize / 2].map(u64::from);
        let opposite = corners.into_iter().find(|&corner| corner != low && corner != high).unwrap_or(low);
        let towards = vertex(opposite) - foot;
        towards - axis * axis.dot(&towards)
    };
    let zero = across(&group[0]);
    let angle = |at: &EdgeUse| {
        let towards = across(at);
        libm::atan2(axis.dot(&zero.cross(&towards)), zero.dot(&towards))
    };
    group.iter().map(|at| (angle(at), *at)).collect()
}
