//! Rasterization of triangles: one span for each row of samples.

/// Corner on the screen: right and down in pixels, then a depth that is linear across the screen.
pub(crate) type ScreenCorner = [f32; 3];

/// Positions of the samples: each pixel has a row of samples for each offset, with one sample at this offset from its left
/// edge. Offsets that all differ resolve vertical edges as finely as horizontal ones.
#[derive(Clone, Copy)]
pub(crate) struct SampleGrid<'a> {
    /// Width in pixels.
    pub width: usize,
    /// Number of rows of samples.
    pub rows: usize,
    pub offsets: &'a [f32],
}

/// Span of samples: row, range of columns, depth at the first sample and its increment.
pub(crate) struct Span {
    pub row: usize,
    pub columns: std::ops::Range<usize>,
    pub depth: f32,
    pub step: f32,
}

/// Calls `visit` with each span of a triangle. A sample on an edge between two triangles belongs to exactly one of them.
pub(crate) fn spans(corners: &[ScreenCorner; 3], grid: &SampleGrid<'_>, mut visit: impl FnMut(Span)) {
    let per_point = grid.offsets.len() as f32;
    let row_below = |y: f32| ceiling(y * per_point - 0.5, grid.rows);
    let [a, b, c] = corners.map(|corner| corner[1]);
    let (first, beyond) = (row_below(a.min(b).min(c)), row_below(a.max(b).max(c)));
    // Most small triangles lie between two rows; they end here.
    if first >= beyond {
        return;
    }
    let mut sorted = *corners;
    sorted.sort_by(|a, b| a[1].total_cmp(&b[1]));
    let [top, middle, bottom] = sorted;
    let (e1, e2) = (difference(&middle, &top), difference(&bottom, &top));
    let area = e1[0] * e2[1] - e1[1] * e2[0];
    if area == 0.0 {
        return;
    }
    let step = (e1[2] * e2[1] - e2[2] * e1[1]) / area;
    let slope = (e2[2] * e1[0] - e1[2] * e2[0]) / area;
    let (long, above, below) = (Edge::of(&top, &bottom), Edge::of(&top, &middle), Edge::of(&middle, &bottom));
    for row in first..beyond {
        let y = (row as f32 + 0.5) / per_point;
        let long = long.at(y);
        let short = if y < middle[1] { above.at(y) } else { below.at(y) };
        let offset = grid.offsets[row % grid.offsets.len()];
        let left = ceiling(long.min(short) - offset, grid.width);
        let right = ceiling(long.max(short) - offset, grid.width);
        if left < right {
            let depth = top[2] + (left as f32 + offset - top[0]) * step + (y - top[1]) * slope;
            visit(Span { row, columns: left..right, depth, step });
        }
    }
}

/// Returns the least integer not below `value`, clamped to 0 and `most`, by conversion: on machines without the instruction,
/// rounding would be a function call for each row of each triangle.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a count that is not negative and small"
)]
pub(crate) fn ceiling(value: f32, most: usize) -> usize {
    let inside = value.clamp(0.0, most as f32);
    let below = inside as usize;
    below + usize::from((below as f32) < inside)
}

/// Edge of a triangle from its upper to its lower end, so that both adjacent triangles get identical bits.
struct Edge {
    x: f32,
    y: f32,
    /// Increment to the right per unit down.
    slope: f32,
}

impl Edge {
    fn of(upper: &ScreenCorner, lower: &ScreenCorner) -> Self {
        let slope = (lower[0] - upper[0]) / (lower[1] - upper[1]);
        Self { x: upper[0], y: upper[1], slope }
    }

    /// Horizontal position of the edge at height `y`.
    fn at(&self, y: f32) -> f32 {
        self.x + (y - self.y) * self.slope
    }
}

fn difference(a: &ScreenCorner, b: &ScreenCorner) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_of_a_fan_belongs_to_one_triangle() {
        let grid = SampleGrid { width: 20, rows: 80, offsets: &[0.375, 0.875, 0.125, 0.625] };
        let around: Vec<ScreenCorner> = [(1.3, 2.0), (17.9, 0.7), (19.2, 13.37), (11.0, 19.5), (0.2, 15.0)]
            .map(|(x, y)| [x, y, 1.0])
            .into();
        let mut hits = vec![0; 20 * 80];
        for index in 0..around.len() {
            let triangle = [[9.7, 8.1, 1.0], around[index], around[(index + 1) % around.len()]];
            spans(&triangle, &grid, |span| {
                for column in span.columns {
                    hits[span.row * 20 + column] += 1;
                }
            });
        }
        assert!(hits.iter().all(|&count| count <= 1));
        // Area of the polygon by the shoelace formula.
        let area: f32 = (0..around.len())
            .map(|i| (around[i], around[(i + 1) % around.len()]))
            .map(|(a, b)| 0.5 * (a[0] * b[1] - a[1] * b[0]))
            .sum();
        let covered = hits.iter().sum::<i32>() as f32 / 4.0;
        assert!((covered / area - 1.0).abs() < 0.01, "{covered} of {area}");
    }

    #[test]
    fn the_ceiling_is_that_of_the_library() {
        for value in [-1e9, -0.5, -0.0, 0.0, 1e-30, 0.5, 1.0, 1.5, 6.999_999_5, 7.0, 7.5, 1e9] {
            let expected = f32::ceil(value).clamp(0.0, 7.0);
            assert!((ceiling(value, 7) as f32 - expected).abs() < f32::EPSILON, "{value}");
        }
        assert_eq!(ceiling(f32::NAN, 7), 0);
    }

    #[test]
    fn depth_is_that_of_the_plane() {
        let grid = SampleGrid { width: 8, rows: 8, offsets: &[0.5] };
        let depth = |x: f32, y: f32| 3.0 + 0.25 * x - 0.5 * y;
        let corners = [(0.0, 0.0), (8.0, 1.0), (3.0, 8.0)].map(|(x, y)| [x, y, depth(x, y)]);
        spans(&corners, &grid, |span| {
            let expected = depth(span.columns.start as f32 + 0.5, span.row as f32 + 0.5);
            assert!((span.depth - expected).abs() < 1e-5 && (span.step - 0.25).abs() < 1e-6);
        });
    }
}
