use crate::drawing::draw_list::{DrawList, DrawPoint, DrawVector, Lens, NEAR_M};
use crate::drawing::scan::{SampleGrid, ScreenCorner, spans};

/// Depth buffer: the triangle nearest to the eye at each sample of a picture.
pub(crate) struct SampleBuffer {
    pub width: usize,
    pub height: usize,
    /// Horizontal offset of the sample in each row of a pixel.
    pub offsets: &'static [f32],
    /// Reciprocal of the depth; 0 if the sample is empty.
    pub nearness: Vec<f32>,
    /// Index of the triangle, or [`NOTHING`].
    pub triangle: Vec<u32>,
}

/// Marks a sample without a triangle: the floor or the background.
pub(crate) const NOTHING: u32 = u32::MAX;

/// Offsets for one, four and eight samples per pixel, each sample in its own column.
const ONE: [f32; 1] = [0.5];
const FOUR: [f32; 4] = [0.375, 0.875, 0.125, 0.625];
const EIGHT: [f32; 8] = [0.0625, 0.5625, 0.3125, 0.8125, 0.1875, 0.6875, 0.4375, 0.9375];

impl SampleBuffer {
    /// Creates an empty buffer with 1, 4 or 8 samples per pixel; other numbers are rounded up.
    pub fn new(width: usize, height: usize, samples: usize) -> Self {
        let offsets: &[f32] = match samples {
            0 | 1 => &ONE,
            2..=4 => &FOUR,
            _ => &EIGHT,
        };
        let count = width * height * offsets.len();
        Self { width, height, offsets, nearness: vec![0.0; count], triangle: vec![NOTHING; count] }
    }

    /// Copies the depths of another buffer in a region without its triangles, slightly reduced, so that coincident things stay
    /// hidden.
    pub fn restart(&mut self, nearness: &[f32], region: &Region) {
        /// Factor of the reciprocal depth: 3 mm at 3 m.
        const NEARER: f32 = 1.001;
        let samples = self.offsets.len();
        for row in region.rows.start * samples..region.rows.end * samples {
            let range = row * self.width + region.columns.start..row * self.width + region.columns.end;
            for (own, given) in self.nearness[range.clone()].iter_mut().zip(&nearness[range.clone()]) {
                *own = given * NEARER;
            }
            self.triangle[range].fill(NOTHING);
        }
    }

    /// Draws the floor from its reciprocal depth at the upper left corner and its increments to the right and down.
    pub fn draw_floor(&mut self, [first, right, down]: [f32; 3]) {
        let samples = self.offsets.len();
        for (row, values) in self.nearness.chunks_exact_mut(self.width).enumerate() {
            let begin =
                first + down * ((row as f32 + 0.5) / samples as f32) + right * self.offsets[row % samples];
            for (column, value) in values.iter_mut().enumerate() {
                *value = value.max(begin + right * column as f32);
            }
        }
    }

    /// Draws the samples that are nearer than those present. Returns the rows and columns of the affected pixels.
    pub fn draw(&mut self, list: &DrawList, lens: &Lens) -> Region {
        let seen: Vec<DrawVector> = list.positions.iter().map(|place| lens.seen(place)).collect();
        let screen: Vec<ScreenCorner> = seen.iter().map(|seen| lens.on_screen(seen)).collect();
        let mut region = Region::none(self);
        for (index, triangle) in (0_u32..).zip(&list.triangles) {
            let corners = triangle.corners.map(|corner| corner as usize);
            let ahead = corners.map(|corner| seen[corner].z > NEAR_M);
            if ahead == [true; 3] {
                self.fill(&corners.map(|corner| screen[corner]), index, &mut region);
            } else if ahead != [false; 3] {
                let clipped = before_eye(&corners.map(|corner| seen[corner]));
                let on_screen: Vec<ScreenCorner> = clipped.iter().map(|seen| lens.on_screen(seen)).collect();
                for other in 2..on_screen.len() {
                    self.fill(&[on_screen[0], on_screen[other - 1], on_screen[other]], index, &mut region);
                }
            }
        }
        region
    }

    fn fill(&mut self, corners: &[ScreenCorner; 3], index: u32, region: &mut Region) {
        let samples = self.offsets.len();
        let rows = self.height * samples;
        let grid = SampleGrid { width: self.width, rows, offsets: self.offsets };
        let (width, nearness, triangle) = (self.width, &mut self.nearness, &mut self.triangle);
        spans(corners, &grid, |span| {
            region.include(span.row / samples, &span.columns);
            let range = span.row * width + span.columns.start..span.row * width + span.columns.end;
            let mut depth = span.depth;
            for (near, owner) in nearness[range.clone()].iter_mut().zip(&mut triangle[range]) {
                if depth > *near {
                    *near = depth;
                    *owner = index;
                }
                depth += span.step;
            }
        });
    }
}

/// Range of rows and columns of pixels.
#[derive(Clone, Debug)]
pub(crate) struct Region {
    pub rows: std::ops::Range<usize>,
    pub columns: std::ops::Range<usize>,
}

impl Region {
    /// Returns the region of all pixels.
    pub fn whole(buffer: &SampleBuffer) -> Self {
        Self { rows: 0..buffer.height, columns: 0..buffer.width }
    }

    fn none(buffer: &SampleBuffer) -> Self {
        Self { rows: buffer.height..0, columns: buffer.width..0 }
    }

    fn include(&mut self, row: usize, columns: &std::ops::Range<usize>) {
        self.rows = self.rows.start.min(row)..self.rows.end.max(row + 1);
        self.columns = self.columns.start.min(columns.start)..self.columns.end.max(columns.end);
    }
}

/// Clips a triangle at the near plane (Sutherland & Hodgman 1974, "Reentrant polygon clipping", whole, for one plane).
fn before_eye(corners: &[DrawVector; 3]) -> Vec<DrawVector> {
    let mut kept = Vec::with_capacity(4);
    for (index, here) in corners.iter().enumerate() {
        let next = &corners[(index + 1) % 3];
        if here.z > NEAR_M {
            kept.push(*here);
        }
        if (here.z > NEAR_M) != (next.z > NEAR_M) {
            kept.push(here + (next - here) * ((NEAR_M - here.z) / (next.z - here.z)));
        }
    }
    kept
}

/// Intersects a ray with a triangle and returns the weights of the corners (Möller & Trumbore 1997, "Fast, minimum storage
/// ray/triangle intersection", whole): clamped to the triangle if the ray misses, as for samples on an edge; those of the
/// centroid if it is parallel.
pub(crate) fn weights(eye: &DrawPoint, ray: &DrawVector, [a, b, c]: [&DrawPoint; 3]) -> [f32; 3] {
    let (e1, e2) = (b - a, c - a);
    let p = ray.cross(&e2);
    let determinant = e1.dot(&p);
    let from_a = eye - a;
    let (second, third) = (from_a.dot(&p) / determinant, ray.dot(&from_a.cross(&e1)) / determinant);
    if !(second.is_finite() && third.is_finite()) {
        return [1.0 / 3.0; 3];
    }
    let second = second.clamp(0.0, 1.0);
    let third = third.clamp(0.0, 1.0 - second);
    [1.0 - second - third, second, third]
}
