use crate::Aabb;

/// Bounds of the distance to a union of boxes, on a grid: most queries of a tree need no more.
#[derive(Clone, Debug)]
pub(crate) struct FreeGrid {
    low: [f32; 3],
    /// Cells per metre.
    scale: f32,
    size: [usize; 3],
    /// For each cell the square of a lower bound of the distance of its points from the boxes (m²).
    free_m2: Vec<f32>,
    /// Square of the distance up to which boxes are found (m²).
    found_m2: f32,
    /// Excess of the greatest distance of a point of a cell from the boxes over that bound, in metres.
    excess_m: f32,
}

/// Maximum number of cells along the longest side, for points and for boxes with an extent: the cells of a map of space surround
/// most queries, and take longer to build than the few milliseconds of a cloud.
const MOST_CELLS: [f64; 2] = [40.0, 72.0];

/// Number of cells along the longest side per cube root of the number of points or boxes.
const CELLS_EACH: [f64; 2] = [2.0, 4.0];

/// Number of cells in each direction within which boxes are found.
const WINDOW: usize = 24;

/// Greatest distance of points of two cells over the least one, in cells, rounded up: twice the diagonal.
const EXCESS: f64 = 3.5;

impl FreeGrid {
    /// Creates the grid of `boxes` in the box around all of them; `are_points`: none of them has an extent.
    ///
    /// The square of the distance between two cells is a sum over the axes, so that three passes, one along each axis, find the
    /// nearest cell that a box meets (Felzenszwalb & Huttenlocher 2012, §2.1, by exhaustive search in a part of each row).
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "bounds are rounded outwards by a whole cell"
    )]
    pub fn new(around: &Aabb, (count, are_points): (usize, bool), boxes: impl Iterator<Item = Aabb>) -> Self {
        let longest_m = 2.0 * around.half_extents.max();
        let kind = usize::from(!are_points);
        let cells = (CELLS_EACH[kind] * libm::cbrt(count as f64)).clamp(1.0, MOST_CELLS[kind]);
        // The grid is a little larger than the box around all boxes, so that rounding moves none of them out of it.
        let cell_m = (longest_m / cells).max(1e-3) * (1.0 + 1e-4);
        let low = around.low() - around.half_extents * 1e-5;
        let size = [0, 1, 2].map(|axis| (2.0 * around.half_extents[axis] / cell_m) as usize + 1);
        let mut free = vec![f32::INFINITY; size.iter().product()];
        let last = |axis: usize| size[axis] - 1;
        for aabb in boxes {
            // A cell more on each side, since boxes and queries are rounded.
            let range = [0, 1, 2].map(|axis| {
                let cell = |value: f64| (((value - low[axis]) / cell_m).max(0.0) as usize).min(last(axis));
                [cell(aabb.low()[axis] - 1e-3 * cell_m), cell(aabb.high()[axis] + 1e-3 * cell_m)]
            });
            for x in range[0][0]..=range[0][1] {
                for y in range[1][0]..=range[1][1] {
                    let row = (x * size[1] + y) * size[2];
                    free[row + range[2][0]..=row + range[2][1]].fill(0.0);
                }
            }
        }
        let strides = [size[1] * size[2], size[2], 1];
        let mut next = free.clone();
        for axis in [2, 1, 0] {
            spread(&free, &mut next, size[axis], strides[axis], cell_m as f32);
            std::mem::swap(&mut free, &mut next);
        }
        // Boxes outside the window are at least this distant.
        let found_m2 = ((WINDOW as f64 * cell_m).powi(2) * (1.0 - 1e-6)) as f32;
        for free in &mut free {
            *free = free.min(found_m2);
        }
        Self {
            low: [0, 1, 2].map(|axis| low[axis] as f32),
            scale: (1.0 / cell_m) as f32,
            size,
            free_m2: free,
            found_m2,
            excess_m: (EXCESS * cell_m) as f32,
        }
    }

    /// Returns true if a point (m) is certainly closer to a box than `reach_m` (m), false if it certainly is not, and otherwise `None`.
    #[inline(always)]
    pub fn is_closer(&self, point: [f32; 3], reach_m: f32) -> Option<bool> {
        let free_m2 = self.at(point)?;
        if free_m2 >= reach_m * reach_m {
            return Some(false);
        }
        let sure_m = reach_m - self.excess_m;
        (sure_m > 0.0 && free_m2 < sure_m * sure_m && free_m2 < self.found_m2).then_some(true)
    }

    /// Returns the square of a lower bound of the distance of a point (m) from the boxes, in m²; `None` outside the grid.
    #[inline(always)]
    fn at(&self, point: [f32; 3]) -> Option<f32> {
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
        self.free_m2.get(cell).copied()
    }
}

/// Adds the squares of the gaps along one axis: for each cell the least sum over the near cells of its row.
fn spread(from: &[f32], to: &mut [f32], size: usize, stride: usize, cell_m: f32) {
    #[allow(clippy::cast_precision_loss, reason = "at most a hundred cells")]
    let gap = |steps: usize| (cell_m * steps.saturating_sub(1) as f32).powi(2);
    to.fill(f32::INFINITY);
    if stride == 1 {
        // Cells of a row are neighbours: all of them at once.
        let gaps: Vec<f32> = (0..2 * size).map(|place| gap(place.abs_diff(size))).collect();
        for (row, target) in from.chunks_exact(size).zip(to.chunks_exact_mut(size)) {
            for (other, value) in row.iter().enumerate().filter(|(_, value)| value.is_finite()) {
                let near = other.saturating_sub(WINDOW)..(other + WINDOW + 1).min(size);
                let gaps = &gaps[size - other + near.start..];
                for (least, gap) in target[near].iter_mut().zip(gaps) {
                    *least = least.min(value + gap);
                }
            }
        }
        return;
    }
    for (block, target) in from.chunks_exact(size * stride).zip(to.chunks_exact_mut(size * stride)) {
        for (cell, target) in target.chunks_exact_mut(stride).enumerate() {
            let near = cell.saturating_sub(WINDOW)..(cell + WINDOW + 1).min(size);
            for (other, row) in near.clone().zip(block.chunks_exact(stride).skip(near.start)) {
                let added = gap(cell.abs_diff(other));
                for (least, value) in target.iter_mut().zip(row) {
                    *least = least.min(value + added);
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
                let bound = grid.at(narrow).map_or(0.0, |bound_m2| f64::from(bound_m2).sqrt());
                prop_assert!(bound <= least + 1e-6, "{bound} > {least}");
                let found_m = f64::from(grid.found_m2).sqrt();
                if around.contains(&point) {
                    prop_assert!(bound >= least.min(found_m) - 4.0 * cell_m, "{bound} << {least}, cells of {cell_m}");
                }
                // A certain answer is the true one, and far from the surface there is one.
                let reach_m = draw(0.0, 1.0);
                #[allow(clippy::cast_possible_truncation, reason = "as in queries")]
                let answer = grid.is_closer(narrow, reach_m as f32);
                prop_assert!(answer.is_none_or(|is_closer| is_closer == (least < reach_m)), "{answer:?}: {least} {reach_m}");
                let is_clear = (least - reach_m).abs() > 4.0 * cell_m && reach_m < found_m - 4.0 * cell_m;
                prop_assert!(answer.is_some() || !is_clear || !around.contains(&point), "{least} {reach_m}");
            }
        }
    }
}
