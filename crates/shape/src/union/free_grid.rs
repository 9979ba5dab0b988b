use crate::Aabb;

/// Lower bounds of the distance to a union of boxes, on a grid: most queries of a tree need no more.
#[derive(Clone, Debug)]
pub(crate) struct FreeGrid {
    low: [f32; 3],
    /// Cells per metre.
    scale: f32,
    size: [usize; 3],
    /// For each cell the square of a lower bound of the distance of its points from the boxes (m²).
    free_m2: Vec<f32>,
}

/// Maximum number of cells along the longest side.
const MOST_CELLS: f64 = 40.0;

impl FreeGrid {
    /// Creates the grid of `boxes` in the box around all of them, with about four cells per box, fewer for many boxes.
    ///
    /// The square of the distance between two cells is a sum over the axes, so that three passes, one along each axis, find the
    /// nearest cell that a box meets (Felzenszwalb & Huttenlocher 2012, §2.1, by exhaustive search in each row).
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "bounds are rounded outwards by a whole cell"
    )]
    pub fn new(around: &Aabb, count: usize, boxes: impl Iterator<Item = Aabb>) -> Self {
        let longest_m = 2.0 * around.half_extents.max();
        let cells = (2.0 * libm::cbrt(count as f64)).clamp(1.0, MOST_CELLS);
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
        Self {
            low: [0, 1, 2].map(|axis| low[axis] as f32),
            scale: (1.0 / cell_m) as f32,
            size,
            free_m2: free,
        }
    }

    /// Returns the square of a lower bound of the distance of a point (m) from the boxes, in m²; 0 outside the grid.
    #[inline(always)]
    pub fn at(&self, point: [f32; 3]) -> f32 {
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
                return 0.0;
            }
            cell = cell * size + index;
        }
        self.free_m2.get(cell).copied().unwrap_or(0.0)
    }
}

/// Adds the squares of the gaps along one axis: for each cell the least sum over the cells of its row.
fn spread(from: &[f32], to: &mut [f32], size: usize, stride: usize, cell_m: f32) {
    #[allow(clippy::cast_precision_loss, reason = "at most a hundred cells")]
    let gap = |steps: usize| (cell_m * steps.saturating_sub(1) as f32).powi(2);
    to.fill(f32::INFINITY);
    if stride == 1 {
        // Cells of a row are neighbours: all of them at once.
        let gaps: Vec<f32> = (0..2 * size).map(|place| gap(place.abs_diff(size))).collect();
        for (row, target) in from.chunks_exact(size).zip(to.chunks_exact_mut(size)) {
            for (other, value) in row.iter().enumerate().filter(|(_, value)| value.is_finite()) {
                for (least, gap) in target.iter_mut().zip(&gaps[size - other..]) {
                    *least = least.min(value + gap);
                }
            }
        }
        return;
    }
    for (block, target) in from.chunks_exact(size * stride).zip(to.chunks_exact_mut(size * stride)) {
        for (cell, target) in target.chunks_exact_mut(stride).enumerate() {
            for (other, row) in block.chunks_exact(stride).enumerate() {
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
            let grid = FreeGrid::new(&around, count, boxes.iter().copied());
            let cell_m = 1.0 / f64::from(grid.scale);
            for _ in 0..200 {
                let point = around.center + around.half_extents.component_mul(&Vector::new(draw(-1.1, 1.1), draw(-1.1, 1.1), draw(-1.1, 1.1)));
                let least = boxes.iter().map(|aabb| aabb.distance_to(&point)).fold(f64::INFINITY, f64::min);
                #[allow(clippy::cast_possible_truncation, reason = "as in queries")]
                let bound = f64::from(grid.at([0, 1, 2].map(|axis| point[axis] as f32))).sqrt();
                prop_assert!(bound <= least + 1e-6, "{bound} > {least}");
                if around.contains(&point) {
                    prop_assert!(bound >= least - 4.0 * cell_m, "{bound} << {least}, cells of {cell_m}");
                }
            }
        }
    }
}
