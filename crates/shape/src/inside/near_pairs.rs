//! Pairs of triangles that may meet, found without a comparison of all.

use std::ops::ControlFlow;

use cranny_spatial::Point;

use crate::distance::triangle_tree::TriangleTree;
use crate::inside::fan_boxes::FanBoxes;
use crate::{Aabb, ShapeError};

/// Calls `visit` once for each pair of triangles that may meet, the lesser index first, until it breaks.
///
/// 1. Pairs whose boxes overlap are visited. In most meshes each box overlaps with some ten others.
/// 2. The boxes of long, narrow triangles, as in fans about a tip and along a cylinder, may overlap all. From the triangle
///    on at which the limit is reached, pairs must also overlap in [`FanBoxes`].
///
/// Pairs that meet only on an axis of [`FanBoxes`], up to its [`NOISE`](crate::inside::fan_boxes::NOISE), may be left out.
///
/// # Errors
/// [`ShapeError::NarrowTriangles`] if more pairs remain than the limit, which is linear in the number of triangles.
pub(crate) fn visit_near_pairs(
    triangles: &[[u32; 3]],
    corners: &[[Point; 3]],
    mut visit: impl FnMut(usize, usize) -> ControlFlow<()>,
) -> Result<(), ShapeError> {
    let most = most_pairs(corners.len());
    // 1.
    let tree = TriangleTree::new(corners);
    let mut pairs = 0;
    let mut near = Vec::new();
    let mut begin = 0;
    while begin < corners.len() && pairs <= most {
        near.clear();
        near.extend(tree.near(&Aabb::around(&corners[begin], 0.0)).map(|other| other as usize));
        pairs += near.len();
        if near.iter().filter(|other| **other > begin).any(|&other| visit(begin, other).is_break()) {
            return Ok(());
        }
        begin += 1;
    }
    if begin == corners.len() {
        return Ok(());
    }
    // 2.
    let narrow = || narrow_triangles(corners.len());
    if corners.len() > MOST_IN_FANS {
        return Err(narrow());
    }
    let boxes = FanBoxes::new(triangles, corners);
    let mut left = MOST_COMPARISONS + MOST_COMPARISONS_EACH * most;
    for first in begin..corners.len() {
        left = boxes.near(first, left, &mut near).ok_or_else(narrow)?;
        if near.iter().filter(|other| **other > first).any(|&other| visit(first, other).is_break()) {
            return Ok(());
        }
    }
    Ok(())
}

/// Maximum number of pairs with overlapping boxes that are compared in a mesh of a number of triangles.
pub(crate) fn most_pairs(triangles: usize) -> usize {
    MOST_PAIRS + MOST_PAIRS_EACH * triangles
}

/// Error for a mesh with more pairs.
pub(crate) fn narrow_triangles(triangles: usize) -> ShapeError {
    ShapeError::NarrowTriangles { triangles, most: most_pairs(triangles) }
}

/// Maximum number of pairs with overlapping boxes, apart from those below: all pairs of 1000 triangles.
const MOST_PAIRS: usize = 1_000_000;

/// Further pairs for each triangle: the scans of objects have some 20.
const MOST_PAIRS_EACH: usize = 64;

/// Comparisons of fan boxes, apart from those below: all pairs of the slivers of 20 plates with rims of 1500 corners in all
/// directions, in a few seconds.
const MOST_COMPARISONS: usize = 40_000_000;

/// Comparisons of fan boxes in place of each of these pairs, each of which takes about as long as a pair. Cones and prisms need
/// a tenth of them.
const MOST_COMPARISONS_EACH: usize = 3;

/// Maximum number of triangles in [`FanBoxes`], each of which takes 600 bytes.
const MOST_IN_FANS: usize = 1_000_000;
