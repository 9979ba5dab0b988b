use cranny_spatial::simd_level;
use fearless_simd::{Simd, dispatch};

use crate::Aabb;

/// Bounds of the distance to a union of boxes, on a grid: most queries of a tree need no more.
#[derive(Clone, Debug)]
pub(crate) struct FreeGrid {
    low: [f32; 3],
    /// Cells per metre.
    scale: f32,
    size: [usize; 3],
    /// For each cell a lower bound of the distance of its points from the boxes, in units of `unit_m`, or [`FULL`].
    bounds: Vec<u8>,
    /// For each cell the index of a box near it, or [`NO_BOX`].
    near: Vec<u32>,
    unit_m: f32,
}

/// Answer of the grid to whether a point is closer to a box than a distance.
pub(crate) enum Closeness {
    Closer,
    Farther,
    /// It is, if this box is; or others may be.
    AtBox(u32),
    Open,
}

/// Bound of a cell that lies within one box.
const FULL: u8 = u8::MAX;

/// Units of a bound per side of a cell.
const UNITS: f64 = 8.0;

/// Number of cells in each direction within which boxes are found.
const WINDOW: u32 = 24;

/// Cells are searched as the square of a gap, in cells, above this number of bits for the index of a box.
const INDEX_BITS: u32 = 21;

/// Index in place of that of a box.
const NO_BOX: u32 = (1 << INDEX_BITS) - 1;

/// Square of the bound of cells beyond the window, in cells.
const BEYOND: u32 = WINDOW * WINDOW;

/// Maximum number of cells along the longest side, for points and for boxes with an extent: the cells of a map of space surround
/// most queries, and take longer to build than the few milliseconds of a cloud.
const MOST_CELLS: [f64; 2] = [48.0, 160.0];

/// Number of cells along the longest side per cube root of the number of points or boxes.
const CELLS_EACH: [f64; 2] = [3.0, 8.0];

/// Part of a cell by which boxes and queries may be rounded.
const ROUNDING: f64 = 2e-3;

impl FreeGrid {
    /// Creates the grid of `boxes` in the box around all of them; `are_points`: none of them has an extent.
    ///
    /// The square of the distance between two cells is a sum over the axes, so that three passes, one along each axis, find the
    /// nearest cell that a box meets (Felzenszwalb & Huttenlocher 2012, §2.1, by search in a part of each row). Cells are aligned
    /// with the smallest box, since the boxes of a map are those of an octree.
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "indices are clamped to the grid, and bounds rounded outwards"
    )]
    pub fn new(
        around: &Aabb,
        (count, are_points): (usize, bool),
        boxes: impl Iterator<Item = Aabb> + Clone,
    ) -> Self {
        let longest_m = 2.0 * around.half_extents.max();
        let kind = usize::from(!are_points);
        let cells = (CELLS_EACH[kind] * libm::cbrt(count as f64)).clamp(1.0, MOST_CELLS[kind]);
        let least_m = boxes.clone().map(|aabb| 2.0 * aabb.half_extents.min()).fold(longest_m, f64::min);
        let cell_m = aligned((longest_m / cells).max(1e-3), least_m);
        // The corner is where single precision has it, a little lower than that of the boxes.
        let low =
            (around.low() - around.half_extents * 1e-6).map(|value| f64::from((value as f32).next_down()));
        let size = [0, 1, 2].map(|axis| ((around.high()[axis] - low[axis]) / cell_m) as usize + 1);
        let place = |axis: usize, value: f64| (value - low[axis]) / cell_m;
        let in_grid = |axis: usize, place: f64| (place.max(0.0) as usize).min(size[axis] - 1);
        let row_of = |x: usize, y: usize| (x * size[1] + y) * size[2];
        let mut found = vec![(BEYOND << INDEX_BITS) | NO_BOX; size.iter().product()];
        for (index, aabb) in (0..).zip(boxes.clone()) {
            // Without its outermost layer, which the bounds below consider, a box meets no further cells at its faces.
            let met = [0, 1, 2].map(|axis| {
                let ends = [aabb.low()[axis], aabb.high()[axis]].map(|end| place(axis, end));
                let middle = 0.5 * (ends[0] + ends[1]);
                [(ends[0] + ROUNDING).min(middle), (ends[1] - ROUNDING).max(middle)]
                    .map(|end| in_grid(axis, end))
            });
            for x in met[0][0]..=met[0][1] {
                for y in met[1][0]..=met[1][1] {
                    found[row_of(x, y)..][met[2][0]..=met[2][1]].fill(NO_BOX.min(index));
                }
            }
        }
        found.chunks_exact_mut(size[2]).for_each(square_gaps);
        let mut next = found.clone();
        for (size_along, stride) in [(size[1], size[2]), (size[0], size[1] * size[2])] {
            dispatch!(simd_level(), simd => simd.vectorize(
                #[inline(always)]
                || spread(&found, &mut next, size[2], size_along, stride),
            ));
            std::mem::swap(&mut found, &mut next);
        }
        let units: Vec<u8> = (0..=BEYOND)
            .map(|square| ((f64::from(square).sqrt() - 4.0 * ROUNDING).max(0.0) * UNITS) as u8)
            .collect();
        let mut bounds: Vec<u8> = found.iter().map(|found| units[(found >> INDEX_BITS) as usize]).collect();
        for aabb in boxes {
            let held = [0, 1, 2].map(|axis| {
                let first = (place(axis, aabb.low()[axis]) + ROUNDING).ceil().max(0.0) as usize;
                let end = (place(axis, aabb.high()[axis]) - ROUNDING).floor().max(0.0) as usize;
                [first, end.min(size[axis]).max(first)]
            });
            for x in held[0][0]..held[0][1] {
                for y in held[1][0]..held[1][1] {
                    bounds[row_of(x, y)..][held[2][0]..held[2][1]].fill(FULL);
                }
            }
        }
        for found in &mut found {
            *found &= NO_BOX;
        }
        Self {
            low: [0, 1, 2].map(|axis| low[axis] as f32),
            scale: (1.0 / cell_m) as f32,
            size,
            bounds,
            near: found,
            unit_m: (cell_m / UNITS) as f32,
        }
    }

    /// Returns whether a point (m) is closer to a box than `reach_m` (m), as far as the grid decides it.
    #[inline(always)]
    pub fn closeness(&self, point: [f32; 3], reach_m: f32) -> Closeness {
        let Some(cell) = self.cell(point) else { return Closeness::Open };
        let bound = self.bounds[cell];
        if bound == FULL {
            return if reach_m > 0.0 { Closeness::Closer } else { Closeness::Open };
        }
        if f32::from(bound) * self.unit_m >= reach_m {
            return Closeness::Farther;
        }
        match self.near[cell] {
            NO_BOX => Closeness::Open,
            index => Closeness::AtBox(index),
        }
    }

    /// Returns false if a point (m) is certainly `reach_m` (m) or farther from all boxes.
    #[inline(always)]
    pub fn may_be_closer(&self, point: [f32; 3], reach_m: f32) -> bool {
        !matches!(self.closeness(point, reach_m), Closeness::Farther)
    }

    /// Returns the index of the cell of a point (m); `None` outside the grid.
    #[inline(always)]
    fn cell(&self, point: [f32; 3]) -> Option<usize> {
        let mut cell = 0;
        for ((value, low), size) in point.iter().zip(&self.low).zip(&self.size) {
            let place = (value - low) * self.scale;
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "the conversion saturates"
            )]
            let index = place as usize;
            let is_inside = place >= 0.0 && index < *size;
            if !is_inside {
                return None;
            }
            cell = cell * size + index;
        }
        Some(cell)
    }
}

/// Returns the side of cells that are `least_m` (m) wide times a power of two, and at least `wanted_m`; less than twice that.
fn aligned(wanted_m: f64, least_m: f64) -> f64 {
    let doublings = libm::log2(wanted_m / least_m * (1.0 - 1e-6)).ceil();
    if doublings.is_finite() { least_m * libm::exp2(doublings) } else { wanted_m }
}

/// Replaces a row, with squares of 0 where a box meets a cell, by the squared gaps between each cell and the nearest of these.
fn square_gaps(row: &mut [u32]) {
    let none = (WINDOW + 1, NO_BOX);
    let mut nearest = none;
    let mut behind = Vec::with_capacity(row.len());
    for cell in &*row {
        let (steps, index) = nearest;
        nearest = if *cell <= NO_BOX {
            (0, *cell)
        } else if steps < none.0 {
            (steps + 1, index)
        } else {
            none
        };
        behind.push(nearest);
    }
    nearest = none;
    for (cell, behind) in row.iter_mut().zip(behind).rev() {
        let (steps, index) = nearest;
        nearest = if *cell <= NO_BOX {
            (0, *cell)
        } else if steps < none.0 {
            (steps + 1, index)
        } else {
            none
        };
        let (steps, index) = if behind.0 < nearest.0 { behind } else { nearest };
        let gap = steps.saturating_sub(1);
        *cell = ((gap * gap) << INDEX_BITS) | index;
    }
}

/// Adds the squared gaps along one axis with `size` cells, `stride` apart, to each row of cells: the least sum over the near rows.
#[inline(always)]
fn spread(from: &[u32], to: &mut [u32], row: usize, size: usize, stride: usize) {
    for (index, target) in to.chunks_exact_mut(row).enumerate() {
        let start = index * row;
        let place = start / stride % size;
        target.copy_from_slice(&from[start..start + row]);
        for steps in 1..=WINDOW {
            let added = (steps - 1).pow(2) << INDEX_BITS;
            // Now and then, whether a farther row can change anything.
            if steps % 4 == 2 && target.iter().all(|found| *found < added + NO_BOX) {
                break;
            }
            let steps = steps as usize;
            let behind = (steps <= place).then(|| start - steps * stride);
            let ahead = (place + steps < size).then_some(start + steps * stride);
            for other in behind.into_iter().chain(ahead) {
                for (least, found) in target.iter_mut().zip(&from[other..other + row]) {
                    *least = (*least).min(found + added);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use cranny_spatial::{Point, Stream, Vector};
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn the_bound_is_below_the_distance_and_not_far_below(seed in any::<u64>(), count in 1_usize..300) {
            let mut random = Stream::new(seed, 0);
            let mut draw = |low: f64, high: f64| random.uniform_between(low, high);
            let boxes: Vec<Aabb> = (0..count)
                .map(|_| Aabb {
                    center: Point::new(draw(-0.5, 0.5), draw(-0.9, 0.9), draw(-0.1, 0.1)),
                    half_extents: Vector::new(draw(0.0, 0.05), draw(0.0, 0.05), draw(0.0, 0.05)),
                })
                .collect();
            let corners: Vec<Point> = boxes.iter().flat_map(|aabb| [aabb.low(), aabb.high()]).collect();
            let around = Aabb::around(&corners, 0.0);
            let are_points = seed % 2 == 0;
            let grid = FreeGrid::new(&around, (count, are_points), boxes.iter().copied());
            let cell_m = 1.0 / f64::from(grid.scale);
            for _ in 0..200 {
                let point = around.center + around.half_extents.component_mul(&Vector::new(draw(-1.1, 1.1), draw(-1.1, 1.1), draw(-1.1, 1.1)));
                let least = boxes.iter().map(|aabb| aabb.distance_to(&point)).fold(f64::INFINITY, f64::min);
                #[allow(clippy::cast_possible_truncation, reason = "as in queries")]
                let narrow = [0, 1, 2].map(|axis| point[axis] as f32);
                let units = grid.cell(narrow).map_or(0, |cell| grid.bounds[cell]);
                prop_assert!(units != FULL || least <= 0.0);
                let bound = if units == FULL { 0.0 } else { f64::from(f32::from(units) * grid.unit_m) };
                prop_assert!(bound <= least + 1e-6, "{bound} > {least}");
                let found_m = f64::from(WINDOW - 1) * cell_m;
                if around.contains(&point) {
                    prop_assert!(bound >= least.min(found_m) - 4.0 * cell_m, "{bound} << {least}, cells of {cell_m}");
                }
                // A certain answer is the true one, and a box that is named is not much farther than the nearest one.
                let reach_m = draw(0.0, 1.0);
                #[allow(clippy::cast_possible_truncation, reason = "as in queries")]
                match grid.closeness(narrow, reach_m as f32) {
                    Closeness::Closer => prop_assert!(least < reach_m),
                    Closeness::Farther => prop_assert!(least >= reach_m - 1e-6),
                    Closeness::AtBox(index) => {
                        let distance_m = boxes[index as usize].distance_to(&point);
                        prop_assert!(distance_m <= least + 4.0 * cell_m, "{distance_m} >> {least}");
                    }
                    Closeness::Open => prop_assert!(!around.contains(&point) || reach_m > found_m),
                }
            }
        }
    }
}
