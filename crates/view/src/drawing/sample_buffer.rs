use crate::drawing::draw_list::{DrawList, DrawPoint, DrawVector, Lens, NEAR_M};
use crate::drawing::scan::{SampleGrid, ScreenCorner, spans};

/// What is nearest to the eye at each sample of a picture.
pub(crate) struct SampleBuffer {
    pub width: usize,
    pub height: usize,
    /// Where the sample lies in each row of a point.
    pub offsets: &'static [f32],
    /// One over how far ahead; 0 for nothing.
    pub nearness: Vec<f32>,
    /// Index of the triangle, or [`NOTHING`].
    pub triangle: Vec<u32>,
}

/// No triangle: the floor or what is behind it.
pub(crate) const NOTHING: u32 = u32::MAX;

/// Offsets for one, four and eight samples a point, each in a column of its own.
const ONE: [f32; 1] = [0.5];
const FOUR: [f32; 4] = [0.375, 0.875, 0.125, 0.625];
const EIGHT: [f32; 8] = [0.0625, 0.5625, 0.3125, 0.8125, 0.1875, 0.6875, 0.4375, 0.9375];

impl SampleBuffer {
    /// Nothing anywhere. Samples a point: 1, 4 or 8, or the next that there is.
    pub fn new(width: usize, height: usize, samples: usize) -> Self {
        let offsets: &[f32] = match samples {
            0 | 1 => &ONE,
            2..=4 => &FOUR,
            _ => &EIGHT,
        };
        let count = width * height * offsets.len();
        Self { width, height, offsets, nearness: vec![0.0; count], triangle: vec![NOTHING; count] }
    }

    /// Takes over how near things are from elsewhere, and forgets which they are. They count as a little nearer,
    /// so that what is drawn in the same place as one of them stays hidden.
    pub fn restart(&mut self, nearness: &[f32]) {
        /// 3 mm at 3 m.
        const NEARER: f32 = 1.001;
        for (own, given) in self.nearness.iter_mut().zip(nearness) {
            *own = given * NEARER;
        }
        self.triangle.fill(NOTHING);
    }

    /// Puts the floor there: `nearness` at the upper left corner, and its steps to the right and down.
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

    /// Draws what is nearer than what is there. Returns the rows and columns of points that it touches.
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

/// Rows and columns of points.
#[derive(Clone, Debug)]
pub(crate) struct Region {
    pub rows: std::ops::Range<usize>,
    pub columns: std::ops::Range<usize>,
}

impl Region {
    fn none(buffer: &SampleBuffer) -> Self {
        Self { rows: buffer.height..0, columns: buffer.width..0 }
    }

    fn include(&mut self, row: usize, columns: &std::ops::Range<usize>) {
        self.rows = self.rows.start.min(row)..self.rows.end.max(row + 1);
        self.columns = self.columns.start.min(columns.start)..self.columns.end.max(columns.end);
    }
}

/// The part of a triangle that lies before the eye (Sutherland & Hodgman 1974, "Reentrant polygon clipping", whole, for
/// one plane).
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

/// The point at which a ray meets a triangle, as weights of its corners (Möller & Trumbore 1997, "Fast, minimum storage ray/triangle
/// intersection", whole): the nearest place of the triangle where it passes by, as a sample at the very edge may, and
/// its middle if it is seen from the edge.
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
