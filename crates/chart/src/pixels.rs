use std::ops::Range;

use crate::letters::Step;
use crate::strokes::{disc, outlines, strokes};
use crate::{ChartError, Drawing, Ink, Mark, Point};

/// Pixels of a PNG for each pixel of a drawing: sharp in print at the width of a column.
const SCALE: f64 = 2.0;

/// Rows of samples in each row of pixels; along a row the coverage is exact.
const SAMPLES: u32 = 8;

/// Straight pieces of a curve of a letter, whose size is a few pixels.
const PIECES: u32 = 6;

impl Drawing {
    /// Returns a PNG file, twice as wide and high in pixels as the drawing, with a white background.
    ///
    /// # Errors
    /// [`ChartError::Font`], [`ChartError::Encoding`].
    pub fn png(&self) -> Result<Vec<u8>, ChartError> {
        let mut sheet = Sheet::white(self.width * SCALE, self.height * SCALE);
        for mark in &self.marks {
            let (polygons, ink, opacity) = polygons(mark)?;
            sheet.fill(&polygons, ink, opacity);
        }
        sheet.encoded().map_err(|reason| ChartError::Encoding { reason })
    }
}

/// Returns the polygons of a mark, to be filled by the non-zero winding rule, its ink and its opacity.
fn polygons(mark: &Mark) -> Result<(Vec<Vec<Point>>, Ink, f64), ChartError> {
    Ok(match mark {
        Mark::Line { points, ink, width, dash } => {
            let strokes = strokes(points, *dash);
            (strokes.iter().flat_map(|stroke| outlines(stroke, *width)).collect(), *ink, 1.0)
        }
        Mark::Area { points, ink, opacity } => (vec![points.clone()], *ink, *opacity),
        Mark::Disc { center, radius, ink } => (vec![disc(*center, *radius)], *ink, 1.0),
        Mark::Text { ink, .. } | Mark::Upward { ink, .. } => {
            let outline = mark.text_line().map(|line| line.outline()).transpose()?;
            (flattened(&outline.unwrap_or_default()), *ink, 1.0)
        }
    })
}

/// Returns the contours of an outline as polygons.
fn flattened(outline: &[Step]) -> Vec<Vec<Point>> {
    let mut contours: Vec<Vec<Point>> = Vec::new();
    for step in outline {
        match *step {
            Step::Move(at) => contours.push(vec![at]),
            Step::Line(at) => contours.last_mut().into_iter().for_each(|contour| contour.push(at)),
            Step::Curve(b, c, d) => {
                let Some(contour) = contours.last_mut() else { continue };
                let a = contour[contour.len() - 1];
                contour.extend((1..=PIECES).map(|piece| {
                    let t = f64::from(piece) / f64::from(PIECES);
                    let s = 1.0 - t;
                    let along = |a, b, c, d| {
                        s * s * s * a + 3.0 * s * s * t * b + 3.0 * s * t * t * c + t * t * t * d
                    };
                    (along(a.0, b.0, c.0, d.0), along(a.1, b.1, c.1, d.1))
                }));
            }
        }
    }
    contours
}

/// Picture of three bytes for each pixel, row by row.
struct Sheet {
    width: u32,
    height: u32,
    bytes: Vec<u8>,
}

impl Sheet {
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a size of some hundred pixels"
    )]
    fn white(width: f64, height: f64) -> Self {
        let (width, height) = (width.ceil() as u32, height.ceil() as u32);
        Self { width, height, bytes: vec![255; 3 * width as usize * height as usize] }
    }

    /// Fills the union of polygons, given in pixels of the drawing. Each row of samples finds where it is inside, by the
    /// winding number at its crossings with the edges.
    fn fill(&mut self, polygons: &[Vec<Point>], ink: Ink, opacity: f64) {
        let scaled = |&(x, y): &Point| (x * SCALE, y * SCALE);
        let edges: Vec<(Point, Point)> = polygons
            .iter()
            .flat_map(|polygon| polygon.iter().zip(polygon.iter().cycle().skip(1)))
            .map(|(from, to)| (scaled(from), scaled(to)))
            .collect();
        let rows = pixels(edges.iter().map(|edge| edge.0.1), self.height);
        let columns = pixels(edges.iter().map(|edge| edge.0.0), self.width);
        let mut coverage = vec![0.0; self.width as usize];
        let mut crossings: Vec<(f64, i32)> = Vec::new();
        for row in rows {
            coverage[columns.clone()].fill(0.0);
            for sample in 0..SAMPLES {
                let y = row as f64 + (f64::from(sample) + 0.5) / f64::from(SAMPLES);
                crossings.clear();
                crossings.extend(edges.iter().filter_map(|&(from, to)| crossing(from, to, y)));
                crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
                let mut winding = 0;
                for pair in crossings.windows(2) {
                    winding += pair[0].1;
                    if winding != 0 {
                        cover(&mut coverage, pair[0].0, pair[1].0);
                    }
                }
            }
            let weight = opacity / f64::from(SAMPLES);
            self.blend(row, columns.clone(), &coverage, ink, weight);
        }
    }

    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a level from 0 to 255")]
    fn blend(&mut self, row: usize, columns: Range<usize>, coverage: &[f64], ink: Ink, weight: f64) {
        let (rgb, begin) = (ink.rgb().map(f64::from), 3 * row * self.width as usize);
        let pixels = &mut self.bytes[begin + 3 * columns.start..begin + 3 * columns.end];
        for (pixel, covered) in pixels.chunks_exact_mut(3).zip(&coverage[columns]) {
            let share = (covered * weight).min(1.0);
            for (level, wanted) in pixel.iter_mut().zip(rgb) {
                *level = (f64::from(*level) * (1.0 - share) + wanted * share).round() as u8;
            }
        }
    }

    fn encoded(&self) -> Result<Vec<u8>, png::EncodingError> {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, self.width, self.height);
        encoder.set_color(png::ColorType::Rgb);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.bytes)?;
        writer.finish()?;
        Ok(file)
    }
}

/// Returns the rows or columns of pixels that cover these positions, within a picture of `size` pixels.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "rows and columns within the picture"
)]
fn pixels(positions: impl Iterator<Item = f64>, size: u32) -> Range<usize> {
    let outside = (f64::INFINITY, f64::NEG_INFINITY);
    let (low, high) = positions.fold(outside, |(low, high), at| (low.min(at), high.max(at)));
    let within = |position: f64| position.clamp(0.0, f64::from(size));
    within(low.floor()) as usize..within(high.ceil()) as usize
}

/// Returns where an edge crosses a horizontal line, with its direction, down or up; `None` if it does not.
fn crossing(from: Point, to: Point, y: f64) -> Option<(f64, i32)> {
    let direction = if from.1 <= y && y < to.1 {
        1
    } else if to.1 <= y && y < from.1 {
        -1
    } else {
        return None;
    };
    Some((from.0 + (y - from.1) / (to.1 - from.1) * (to.0 - from.0), direction))
}

/// Adds the covered share of each pixel of a row between two positions.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "columns within the picture")]
fn cover(row: &mut [f64], from: f64, to: f64) {
    let end = row.len() as f64;
    let (from, to) = (from.clamp(0.0, end), to.clamp(0.0, end));
    for (column, covered) in row.iter_mut().enumerate().take(to.ceil() as usize).skip(from as usize) {
        let left = column as f64;
        *covered += to.min(left + 1.0) - from.max(left);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Anchor, Dash};

    fn drawing(mark: Mark) -> Drawing {
        Drawing { width: 60.0, height: 20.0, marks: vec![mark] }
    }

    #[test]
    fn pixels_are_a_png_of_twice_the_size() {
        let points = vec![(0.0, 0.0), (60.0, 20.0)];
        let bytes = drawing(Mark::Line { points, ink: Ink::Text, width: 1.0, dash: Dash::Short }).png();
        let bytes = bytes.expect("it can be drawn");
        assert_eq!(&bytes[..8], b"\x89PNG\r\n\x1a\n");
        assert_eq!(bytes[16..24], [0, 0, 0, 120, 0, 0, 0, 40]);
    }

    /// Sum of the darkness of all pixels in units of pixels of the drawing, for black on white.
    fn dark_area(mark: &Mark) -> f64 {
        let (polygons, ink, opacity) = polygons(mark).expect("it can be drawn");
        let mut sheet = Sheet::white(120.0, 40.0);
        sheet.fill(&polygons, ink, opacity);
        let black = f64::from(255 - ink.rgb()[0]);
        sheet.bytes.chunks(3).map(|pixel| f64::from(255 - pixel[0]) / black).sum::<f64>() / (SCALE * SCALE)
    }

    #[test]
    fn marks_cover_their_area() {
        let ink = Ink::Text;
        let disc = dark_area(&Mark::Disc { center: (30.3, 10.1), radius: 5.0, ink });
        assert!((disc - 25.0 * std::f64::consts::PI).abs() < 0.5, "{disc}");
        let points = vec![(5.0, 5.0), (25.0, 5.0), (25.0, 15.0)];
        let bend = dark_area(&Mark::Line { points: points.clone(), ink, width: 2.0, dash: Dash::Solid });
        // The disc at the bend adds a quarter of its area and no more; the pieces overlap in one square.
        let expected = 40.0 + 20.0 - 1.0 + 0.25 * std::f64::consts::PI;
        assert!((bend - expected).abs() < 0.1, "{bend} instead of {expected}");
        let half = dark_area(&Mark::Area { points, ink, opacity: 0.5 });
        assert!((half - 50.0).abs() < 0.5, "{half}");
    }

    #[test]
    fn marks_outside_are_cut_off() {
        let points = vec![(-10.0, -10.0), (70.0, -10.0), (70.0, 30.0), (-10.0, 30.0)];
        let all = dark_area(&Mark::Area { points, ink: Ink::Text, opacity: 1.0 });
        assert!((all - 1200.0).abs() < 1e-6, "{all}");
        let mut drawing = Drawing { width: 60.0, height: 20.0, marks: Vec::new() };
        drawing.label((500.0, 10.0), "far away", Anchor::Start, Ink::Text);
        assert!(drawing.png().is_ok());
    }
}
