use std::cell::{Cell, OnceCell};
use std::collections::HashSet;

use cranny_spatial::Point;

use crate::distance::triangle_tree::TriangleTree;
use crate::inside::backwards::wound_backwards;
use crate::inside::near_pairs::most_pairs;
use crate::inside::same_place::merged;
use crate::inside::shell::{DEGENERATE, Facet, Shell, shells};
use crate::inside::shell_sides::ShellSides;
use crate::surface::{Surface, triangles_meet};
use crate::{Aabb, MeshRepairs, ShapeError, TriangleSoup};

/// Mesh with a well-defined inside, independent of the windings in its file.
pub(crate) struct Enclosure {
    /// Triangles with normals outwards; for a mesh that needed no repair those of the file, in their order.
    pub soup: TriangleSoup,
    pub inside: Inside,
    pub repairs: MeshRepairs,
}

/// Volume that the triangles of a mesh enclose.
#[derive(Clone, Debug)]
pub(crate) struct Inside {
    walls: ShellSides,
    /// For each closed surface, the shell of which it is the wall of a cavity, if any.
    cavity_of: Vec<Option<u32>>,
}

impl Enclosure {
    /// Determines the volume that a soup encloses. Each shell counts by itself, so overlapping shells are all solid.
    ///
    /// 1. Finds the shells of the mesh. If it has holes, merges vertices closer than [`VERTEX_MERGE_M`](crate::VERTEX_MERGE_M)
    ///    first. If components that share edges cross, finds the shells of one component after the other.
    /// 2. A shell is a cavity if all its faces point inwards, and a shell whose faces all point outwards contains it without
    ///    touching it. Any other shell is solid.
    /// 3. Turns the faces of other shells outwards, and leaves out duplicates.
    ///
    /// # Errors
    /// [`ShapeError::Empty`], [`ShapeError::VertexIndex`], [`ShapeError::Open`], [`ShapeError::OneSided`],
    /// [`ShapeError::WoundBackwards`], [`ShapeError::NarrowTriangles`], [`ShapeError::NestedBodies`],
    /// [`ShapeError::ManyBodies`].
    pub fn of(soup: &TriangleSoup) -> Result<Self, ShapeError> {
        crate::inside::closed_mesh::check_indices(soup)?;
        // 1.
        let (found, first, merged_vertices) = joined_shells(soup)?;
        let mut is_turned = vec![false; soup.triangles.len()];
        let mut is_left_out = vec![false; soup.triangles.len()];
        let mut is_wall_inside = vec![true; soup.triangles.len()];
        for shell in found.iter().filter(|shell| shell.is_alone) {
            if let Some(p) = wound_backwards(soup, shell, &box_around(soup, &shell.facets)) {
                return Err(ShapeError::WoundBackwards { x: p.x, y: p.y, z: p.z });
            }
        }
        // 2.
        let cavities = cavities(soup, &found)?;
        // 3.
        for (shell, cavity_of) in found.iter().zip(&cavities) {
            // The outer shell of components that share faces sees the faces from outside.
            let is_outside = shell.volume_m3 < 0.0;
            if cavity_of.is_none() && (shell.is_alone || is_outside) {
                for facet in &shell.facets {
                    is_turned[facet.triangle as usize] = facet.is_inward != is_outside;
                }
            }
            if shell.is_alone || is_outside {
                for facet in &shell.facets {
                    is_wall_inside[facet.triangle as usize] = false;
                }
            }
        }
        for (triangle, &first) in first.iter().enumerate().filter(|(_, first)| **first != DEGENERATE) {
            is_left_out[triangle] = first as usize != triangle && !is_wall_inside[first as usize];
        }
        let count = |flags: &[bool]| flags.iter().filter(|flag| **flag).count();
        let repairs = MeshRepairs {
            triangles: soup.triangles.len(),
            merged_vertices,
            flipped_triangles: count(&is_turned),
            doubled_triangles: count(&is_left_out),
            closed_holes: 0,
        };
        let mut kept = TriangleSoup { vertices: soup.vertices.clone(), triangles: Vec::new() };
        kept.triangles.reserve_exact(soup.triangles.len() - repairs.doubled_triangles);
        let mut new_index = vec![0_u32; soup.triangles.len()];
        for (triangle, &[a, b, c]) in soup.triangles.iter().enumerate() {
            new_index[triangle] = u32::try_from(kept.triangles.len()).unwrap_or(u32::MAX);
            if !is_left_out[triangle] {
                kept.triangles.push(if is_turned[triangle] { [a, c, b] } else { [a, b, c] });
            }
        }
        let facets = |shell: Shell| {
            let moved = |facet: Facet| Facet {
                triangle: new_index[facet.triangle as usize],
                is_inward: facet.is_inward != is_turned[facet.triangle as usize],
            };
            shell.facets.into_iter().map(moved).collect::<Vec<_>>()
        };
        let facets: Vec<Vec<Facet>> = found.into_iter().map(facets).collect();
        let walls = ShellSides::new(kept.triangles.len(), facets.iter().map(Vec::as_slice));
        Ok(Self { soup: kept, inside: Inside { walls, cavity_of: cavities }, repairs })
    }
}

impl Inside {
    /// Returns true if a point is in one of the shells, and in no cavity of that shell.
    pub fn contains(&self, tree: &TriangleTree, corners: impl Fn(u32) -> [Point; 3], point: &Point) -> bool {
        let around = self.walls.around(tree, corners, point, None);
        let is_cavity_of =
            |body: u32| around.iter().any(|shell| self.cavity_of[*shell as usize] == Some(body));
        around.iter().any(|body| self.cavity_of[*body as usize].is_none() && !is_cavity_of(*body))
    }
}

/// Returns the shells, the first copy of each triangle, and the number of vertices merged to find them.
fn joined_shells(soup: &TriangleSoup) -> Result<(Vec<Shell>, Vec<u32>, usize), ShapeError> {
    let (found, first, merged_vertices) = match shells(soup) {
        Ok((found, first)) => (found, first, 0),
        Err(ShapeError::Open { edges }) => {
            let (vertices, place) = merged(&soup.vertices);
            let merged_vertices = soup.vertices.len() - vertices.len();
            let triangles = soup.triangles.iter().map(|triangle| triangle.map(|v| place[v as usize]));
            let joined = TriangleSoup { triangles: triangles.collect(), vertices };
            match shells(&joined) {
                Ok((found, first)) => (found, first, merged_vertices),
                // The error reports the holes of the mesh as it was given.
                Err(ShapeError::Open { .. }) => return Err(ShapeError::Open { edges }),
                Err(fault) => return Err(fault),
            }
        }
        Err(fault) => {
            let (found, first) = shells_of_runs(soup).ok_or(fault)?;
            (found, first, 0)
        }
    };
    if found.is_empty() { Err(ShapeError::Empty) } else { Ok((found, first, merged_vertices)) }
}

/// Shells of closed components that follow each other in the file, each found without the others; `None` if the file cannot be
/// divided in this manner.
fn shells_of_runs(soup: &TriangleSoup) -> Option<(Vec<Shell>, Vec<u32>)> {
    let mut found = Vec::new();
    let mut first_copies = Vec::with_capacity(soup.triangles.len());
    // Edges with an odd number of faces, and the faces, of the current component.
    let (mut odd, mut known) = (HashSet::new(), HashSet::new());
    let mut run = TriangleSoup { vertices: soup.vertices.clone(), triangles: Vec::new() };
    for &[a, b, c] in &soup.triangles {
        run.triangles.push([a, b, c]);
        let mut face = [a, b, c];
        face.sort_unstable();
        if face[0] != face[1] && face[1] != face[2] && known.insert(face) {
            for edge in [[face[0], face[1]], [face[1], face[2]], [face[0], face[2]]] {
                if !odd.remove(&edge) {
                    odd.insert(edge);
                }
            }
        }
        if odd.is_empty() {
            let begin = u32::try_from(first_copies.len()).ok()?;
            let (mut of_run, first_of_run) = shells(&run).ok()?;
            // Two triangulations of one flat piece are closed too, but do not form a component.
            if of_run.iter().any(|shell| is_flat(&run, shell)) {
                return None;
            }
            for facet in of_run.iter_mut().flat_map(|shell| &mut shell.facets) {
                facet.triangle += begin;
            }
            found.extend(of_run);
            let shifted = |first: u32| if first == DEGENERATE { DEGENERATE } else { first + begin };
            first_copies.extend(first_of_run.into_iter().map(shifted));
            run.triangles.clear();
            known.clear();
        }
    }
    odd.is_empty().then_some((found, first_copies))
}

/// For each shell, the shell in which it is a cavity, if any.
///
/// # Errors
/// [`ShapeError::NestedBodies`], [`ShapeError::ManyBodies`].
pub(crate) fn cavities(soup: &TriangleSoup, shells: &[Shell]) -> Result<Vec<Option<u32>>, ShapeError> {
    let all = |shell: &Shell, is_inward: bool| {
        shell.is_alone && shell.facets.iter().all(|facet| facet.is_inward == is_inward)
    };
    let is_outer: Vec<bool> = shells.iter().map(|shell| all(shell, false)).collect();
    let mut cavity_of = vec![None; shells.len()];
    if shells.len() < 2 || !shells.iter().any(|shell| all(shell, true)) {
        return Ok(cavity_of);
    }
    let boxes: Vec<Aabb> = shells.iter().map(|shell| box_around(soup, &shell.facets)).collect();
    let mut nest = Nest::new(soup, shells);
    let mut effort = most_pairs(soup.triangles.len());
    let built: Vec<OnceCell<(Vec<[Point; 3]>, TriangleTree)>> = vec![OnceCell::new(); shells.len()];
    let corners =
        |shell: usize| shells[shell].facets.iter().map(|facet| soup.corners(facet.triangle as usize));
    let mut touch = |inner: usize, outer: usize| -> Result<bool, ShapeError> {
        let (around, tree) = built[outer].get_or_init(|| {
            let corners: Vec<[Point; 3]> = corners(outer).collect();
            let tree = TriangleTree::new(&corners);
            (corners, tree)
        });
        for triangle in corners(inner) {
            for near in tree.near(&Aabb::around(&triangle, 0.0)) {
                effort = effort.checked_sub(1).ok_or_else(|| many_bodies(soup, shells))?;
                if triangles_meet(&triangle, &around[near as usize]) {
                    return Ok(true);
                }
            }
        }
        Ok(false)
    };
    for (inner, _) in shells.iter().enumerate().filter(|(_, shell)| all(shell, true)) {
        let around = nest.around(inner)?;
        let contains_box = |&outer: &u32| {
            let outer = &boxes[outer as usize];
            outer.contains(&boxes[inner].low()) && outer.contains(&boxes[inner].high())
        };
        for outer in around.into_iter().filter(|&outer| is_outer[outer as usize]).filter(contains_box) {
            if !touch(inner, outer as usize)? {
                cavity_of[inner] = Some(outer);
                break;
            }
        }
    }
    Ok(cavity_of)
}

/// Closed surfaces that may be nested.
pub(crate) struct Nest<'a> {
    soup: &'a TriangleSoup,
    shells: &'a [Shell],
    tree: TriangleTree,
    walls: ShellSides,
    /// Box of each shell, and a tree over them.
    boxes: Vec<Aabb>,
    box_tree: TriangleTree,
    /// Number of triangles with which segments may still be compared.
    left: usize,
}

impl<'a> Nest<'a> {
    pub fn new(soup: &'a TriangleSoup, shells: &'a [Shell]) -> Self {
        let corners: Vec<[Point; 3]> = (0..soup.triangles.len()).map(|t| soup.corners(t)).collect();
        let walls = ShellSides::new(soup.triangles.len(), shells.iter().map(|shell| shell.facets.as_slice()));
        let boxes: Vec<Aabb> = shells.iter().map(|shell| box_around(soup, &shell.facets)).collect();
        let box_tree = TriangleTree::of_boxes(boxes.iter().copied());
        let left = most_pairs(soup.triangles.len());
        Self { soup, shells, tree: TriangleTree::new(&corners), walls, boxes, box_tree, left }
    }

    /// Shells around a shell that passes through none of them, in ascending order; shells that only touch it from outside are none.
    /// If two shells have a common inner point, the one with the greater volume is around the other.
    ///
    /// # Errors
    /// [`ShapeError::NestedBodies`], [`ShapeError::ManyBodies`].
    pub fn around(&mut self, shell: usize) -> Result<Vec<u32>, ShapeError> {
        /// Maximum number of shells around one: each is compared with each.
        const MOST: usize = 100;
        /// Above the rounding of boxes, in metres.
        const ROUNDING_M: f64 = 1e-9;
        let (low, high) = (self.boxes[shell].low(), self.boxes[shell].high());
        let volume_m3 = |shell: usize| self.shells[shell].volume_m3.abs();
        let is_larger = |other: &u32| {
            let other = *other as usize;
            let size = volume_m3(other).total_cmp(&volume_m3(shell)).then(shell.cmp(&other));
            let grown = self.boxes[other].grown(ROUNDING_M);
            size.is_gt() && grown.contains(&low) && grown.contains(&high)
        };
        let mut larger: Vec<u32> =
            self.box_tree.near(&Aabb::around([&low], ROUNDING_M)).filter(is_larger).collect();
        if larger.is_empty() {
            return Ok(larger);
        }
        let compared = Cell::new(0);
        let corners = |triangle: u32| {
            compared.set(compared.get() + 1);
            self.soup.corners(triangle as usize)
        };
        let around = self.around_inner_point(shell, corners);
        self.left =
            self.left.checked_sub(compared.get()).ok_or_else(|| many_bodies(self.soup, self.shells))?;
        larger.retain(|other| around.binary_search(other).is_ok());
        larger.sort_unstable();
        let bodies = larger.len();
        if bodies <= MOST { Ok(larger) } else { Err(ShapeError::NestedBodies { bodies, most: MOST }) }
    }

    /// Shells around a point within a shell, in ascending order: half-way from the middle of one of its large faces to the wall
    /// behind, where no shell passes that only touches it. Of a shell without such a point, one of its corners is taken.
    fn around_inner_point(&self, shell: usize, corners: impl Fn(u32) -> [Point; 3]) -> Vec<u32> {
        /// Number of faces that are tried.
        const MOST: usize = 16;
        let Shell { facets, .. } = &self.shells[shell];
        let normal = |facet: &Facet| {
            let [a, b, c] = self.soup.corners(facet.triangle as usize);
            let normal = (b - a).cross(&(c - a));
            if facet.is_inward { normal } else { -normal }
        };
        let mut largest: Vec<(f64, &Facet)> =
            facets.iter().map(|facet| (normal(facet).norm_squared(), facet)).collect();
        largest.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        let surface = Surface::of_corners(facets.iter().map(|facet| corners(facet.triangle)).collect());
        let reach_m = 4.0 * self.boxes[shell].half_extents.norm();
        for (_, facet) in largest.into_iter().take(MOST) {
            let [a, b, c] = self.soup.corners(facet.triangle as usize);
            let middle = Point::from((a.coords + b.coords + c.coords) / 3.0);
            let Some(inward) = normal(facet).try_normalize(0.0) else { continue };
            let hits = surface.ray_hits(&middle, &inward, reach_m);
            let wall = hits.iter().map(|hit| hit.distance_m).find(|distance_m| *distance_m > 1e-9 * reach_m);
            let Some(depth_m) = wall else { continue };
            let around = self.walls.around(&self.tree, &corners, &(middle + inward * (0.5 * depth_m)), None);
            if around.iter().any(|own| *own as usize == shell) {
                return around;
            }
        }
        let corner = corners(facets[0].triangle)[0];
        self.walls.around(&self.tree, corners, &corner, u32::try_from(shell).ok())
    }
}

fn many_bodies(soup: &TriangleSoup, shells: &[Shell]) -> ShapeError {
    ShapeError::ManyBodies { bodies: shells.len(), most: most_pairs(soup.triangles.len()) }
}

/// Returns true if a shell encloses no more than a sheet does.
fn is_flat(soup: &TriangleSoup, shell: &Shell) -> bool {
    /// Volume of a sheet, as a share of its size cubed: sides of 10⁹ times its thickness.
    const SHEET: f64 = 1e-9;
    let size_m = 2.0 * box_around(soup, &shell.facets).half_extents.max();
    shell.volume_m3.abs() <= SHEET * size_m * size_m * size_m
}

fn box_around(soup: &TriangleSoup, facets: &[Facet]) -> Aabb {
    let corners = facets.iter().flat_map(|facet| soup.triangles[facet.triangle as usize]);
    Aabb::around(corners.map(|vertex| &soup.vertices[vertex as usize]), 0.0)
}
