use crate::seen::pixel_window::lesser;

/// Least values of an image in squares of 1, 2, 4, … pixels, so that the least in any rectangle is that of four squares at most.
#[derive(Clone, Debug)]
pub(crate) struct LeastTable {
    width: usize,
    /// For each level the least of the square of 2^level pixels whose first corner is the pixel, row by row.
    levels: Vec<Vec<f32>>,
}

/// Rectangle of pixels: first and last column, first and last row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PixelRect {
    pub columns: [usize; 2],
    pub rows: [usize; 2],
}

impl LeastTable {
    /// Creates the table of an image of this width, row by row. Squares of at most a quarter of the lesser side are kept; larger
    /// rectangles are covered by more of them.
    pub fn new(width: usize, image: Vec<f32>) -> Self {
        let height = image.len() / width;
        let mut levels = vec![image];
        while 4 << levels.len() <= width.min(height) {
            let half = 1 << (levels.len() - 1);
            let Some(finer) = levels.last() else { break };
            let mut next = finer.clone();
            for row in 0..height {
                // Rows and columns beyond the border repeat the last ones.
                let other = (row + half).min(height - 1);
                let (here, below) =
                    (&finer[row * width..(row + 1) * width], &finer[other * width..(other + 1) * width]);
                let target = &mut next[row * width..(row + 1) * width];
                let least_of_two = |one: &[f32], other: &[f32], target: &mut [f32]| {
                    for ((least, a), b) in target.iter_mut().zip(one).zip(other) {
                        *least = lesser(lesser(*least, *a), *b);
                    }
                };
                least_of_two(below, &here[half..], target);
                least_of_two(below, &below[half..], target);
                let (here, below) = (here[width - 1], below[width - 1]);
                for least in &mut target[width - half..] {
                    *least = least.min(here).min(below);
                }
            }
            levels.push(next);
        }
        Self { width, levels }
    }

    /// Returns the values of all pixels, row by row.
    pub fn image(&self) -> &[f32] {
        &self.levels[0]
    }

    /// Returns the values of the pixels of a rectangle within the image.
    pub fn pixels(&self, rect: &PixelRect) -> impl Iterator<Item = f32> {
        let [[left, right], [top, bottom]] = [rect.columns, rect.rows];
        let row = move |row: usize| self.levels[0][row * self.width + left..=row * self.width + right].iter();
        (top..=bottom).flat_map(row).copied()
    }

    /// Returns the least value in a rectangle within the image.
    pub fn least(&self, rect: &PixelRect) -> f32 {
        let [[left, right], [top, bottom]] = [rect.columns, rect.rows];
        let shorter = (right - left).min(bottom - top) + 1;
        let level = (shorter.ilog2() as usize).min(self.levels.len() - 1);
        let (side, table) = (1 << level, &self.levels[level]);
        let mut least = f32::INFINITY;
        for row in starts(top, bottom, side) {
            for column in starts(left, right, side) {
                least = least.min(table[row * self.width + column]);
            }
        }
        least
    }
}

/// Returns the first pixels of squares of this side that cover a range, the last one flush with its end.
fn starts(first: usize, last: usize, side: usize) -> impl Iterator<Item = usize> {
    let flush = last + 1 - side;
    (first..flush).step_by(side).chain(std::iter::once(flush))
}

#[cfg(test)]
mod tests {
    use cranny_spatial::Stream;
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn the_least_of_a_rectangle_is_that_of_its_pixels(seed in any::<u64>(), width in 1_usize..40, height in 1_usize..40) {
            let mut random = Stream::new(seed, 0);
            #[allow(clippy::cast_possible_truncation, reason = "pixels")]
            let image: Vec<f32> = (0..width * height).map(|_| random.uniform() as f32).collect();
            let table = LeastTable::new(width, image.clone());
            for _ in 0..50 {
                let mut range = |size: usize| {
                    let (a, b) = (random.index(size), random.index(size));
                    [a.min(b), a.max(b)]
                };
                let rect = PixelRect { columns: range(width), rows: range(height) };
                let mut slow = f32::INFINITY;
                for row in rect.rows[0]..=rect.rows[1] {
                    for column in rect.columns[0]..=rect.columns[1] {
                        slow = slow.min(image[row * width + column]);
                    }
                }
                prop_assert!((table.least(&rect) - slow).abs() <= 0.0);
            }
        }
    }
}
