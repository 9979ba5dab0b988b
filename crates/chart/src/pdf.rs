use std::fmt::{self, Write as _};
use std::io::Write as _;

use flate2::Compression;
use flate2::write::ZlibEncoder;

use crate::letters::Step;
use crate::{ChartError, Drawing, Ink, Mark, Point};

/// Distance of the control points of a quarter circle, as a share of its radius: error of the radius below 3·10⁻⁴
/// (Riškus 2006, "Approximation of a cubic Bezier curve by circular arcs and vice versa", §3).
const QUARTER: f64 = 0.5523;

impl Drawing {
    /// Returns a PDF file of one page (ISO 32000-1, §7 and §8), as large as the drawing in points. Letters are outlines, so that
    /// no font is needed.
    ///
    /// # Errors
    /// [`ChartError::Font`].
    pub fn pdf(&self) -> Result<Vec<u8>, ChartError> {
        let mut content =
            format!("1 0 0 -1 0 {h} cm\n1 1 1 rg 0 0 {w} {h} re f\n", w = self.width, h = self.height);
        let mut opacities = Vec::new();
        for mark in &self.marks {
            let outline = mark.text_line().map(|line| line.outline()).transpose()?;
            // Writing to a string cannot fail.
            let _ = write_mark(&mut content, mark, &outline.unwrap_or_default(), &mut opacities);
        }
        Ok(file(self, &compressed(content.as_bytes()), &opacities))
    }
}

/// Writes the operators of a mark (ISO 32000-1, §8.5).
fn write_mark(content: &mut String, mark: &Mark, outline: &[Step], opacities: &mut Vec<f64>) -> fmt::Result {
    match mark {
        Mark::Line { points, ink, width, dash } => {
            let lengths: Vec<String> = dash.lengths().iter().map(ToString::to_string).collect();
            let dash = lengths.join(" ");
            writeln!(content, "{} RG {width} w [{dash}] 0 d", color(*ink))?;
            write_corners(content, points)?;
            writeln!(content, "S")
        }
        Mark::Area { points, ink, opacity } => {
            let known = opacities.iter().position(|other| other.total_cmp(opacity).is_eq());
            let state = known.unwrap_or_else(|| {
                opacities.push(*opacity);
                opacities.len() - 1
            });
            writeln!(content, "q /O{state} gs {} rg", color(*ink))?;
            write_corners(content, points)?;
            writeln!(content, "f Q")
        }
        Mark::Disc { center: (x, y), radius: r, ink } => {
            let c = QUARTER * r;
            writeln!(content, "{} rg {:.3} {y:.3} m", color(*ink), x + r)?;
            // Clockwise, from the right.
            for u in [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)] {
                let v: Point = (-u.1, u.0);
                let first = (x + r * u.0 + c * v.0, y + r * u.1 + c * v.1);
                let second = (x + r * v.0 + c * u.0, y + r * v.1 + c * u.1);
                write_curve(content, first, second, (x + r * v.0, y + r * v.1))?;
            }
            writeln!(content, "f")
        }
        Mark::Text { ink, .. } | Mark::Upward { ink, .. } => {
            writeln!(content, "{} rg", color(*ink))?;
            for step in outline {
                match *step {
                    Step::Move((x, y)) => writeln!(content, "{x:.3} {y:.3} m")?,
                    Step::Line((x, y)) => writeln!(content, "{x:.3} {y:.3} l")?,
                    Step::Curve(first, second, end) => write_curve(content, first, second, end)?,
                }
            }
            writeln!(content, "{}", if outline.is_empty() { "" } else { "f" })
        }
    }
}

fn write_corners(content: &mut String, points: &[Point]) -> fmt::Result {
    for (index, (x, y)) in points.iter().enumerate() {
        writeln!(content, "{x:.3} {y:.3} {}", if index == 0 { "m" } else { "l" })?;
    }
    Ok(())
}

fn write_curve(content: &mut String, first: Point, second: Point, end: Point) -> fmt::Result {
    let [(a, b), (c, d), (e, f)] = [first, second, end];
    writeln!(content, "{a:.3} {b:.3} {c:.3} {d:.3} {e:.3} {f:.3} c")
}

fn color(ink: Ink) -> String {
    let [red, green, blue] = ink.rgb().map(|level| f64::from(level) / 255.0);
    format!("{red:.4} {green:.4} {blue:.4}")
}

fn compressed(content: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    // Writing to memory cannot fail.
    let _ = encoder.write_all(content);
    encoder.finish().unwrap_or_default()
}

/// Assembles the file: objects, the table of their positions, and the trailer (ISO 32000-1, §7.5).
fn file(drawing: &Drawing, content: &[u8], opacities: &[f64]) -> Vec<u8> {
    let states: Vec<String> =
        opacities.iter().enumerate().map(|(state, opacity)| format!("/O{state} <</ca {opacity}>>")).collect();
    let states = states.join(" ");
    let page = format!(
        "<</Type /Page /Parent 2 0 R /MediaBox [0 0 {} {}] /Resources <</ExtGState <<{states}>>>> /Contents 4 0 R>>",
        drawing.width, drawing.height
    );
    let head = format!("<</Length {} /Filter /FlateDecode>>\nstream\n", content.len());
    let objects = [
        b"<</Type /Catalog /Pages 2 0 R>>".to_vec(),
        b"<</Type /Pages /Kids [3 0 R] /Count 1>>".to_vec(),
        page.into_bytes(),
        [head.as_bytes(), content, b"\nendstream"].concat(),
    ];
    // Bytes above 127 in a comment mark the file as binary.
    let mut file = b"%PDF-1.4\n%\xe2\xe3\xcf\xd3\n".to_vec();
    let mut table = format!("xref\n0 {}\n0000000000 65535 f \n", objects.len() + 1);
    for (index, object) in objects.iter().enumerate() {
        let _ = writeln!(table, "{:010} 00000 n ", file.len());
        file.extend_from_slice(format!("{} 0 obj\n", index + 1).as_bytes());
        file.extend_from_slice(object);
        file.extend_from_slice(b"\nendobj\n");
    }
    let (start, size) = (file.len(), objects.len() + 1);
    let trailer = format!("trailer\n<</Size {size} /Root 1 0 R>>\nstartxref\n{start}\n%%EOF\n");
    [file, table.into_bytes(), trailer.into_bytes()].concat()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Anchor;

    #[test]
    fn the_table_of_a_pdf_gives_the_position_of_each_object() {
        let mut drawing = Drawing { width: 60.0, height: 20.0, marks: Vec::new() };
        drawing.rule((0.0, 0.0), (60.0, 20.0), Ink::Grid);
        drawing.label((5.0, 15.0), "time, s", Anchor::Start, Ink::Text);
        drawing.marks.push(Mark::Area {
            points: vec![(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)],
            ink: Ink::Series(0),
            opacity: 0.5,
        });
        drawing.marks.push(Mark::Disc { center: (1.0, 1.0), radius: 2.0, ink: Ink::Series(1) });
        let bytes = drawing.pdf().expect("it can be drawn");
        assert!(bytes.starts_with(b"%PDF-") && bytes.ends_with(b"%%EOF\n"));
        let text: String = bytes.iter().map(|&byte| char::from(byte)).collect();
        let start = text.rsplit("startxref\n").next().and_then(|end| end.lines().next()).expect("a position");
        let table =
            &text[text.char_indices().nth(start.parse().expect("a number")).expect("within the file").0..];
        let positions: Vec<usize> =
            table.lines().filter_map(|line| line.strip_suffix(" 00000 n ")?.parse().ok()).collect();
        assert_eq!(positions.len(), 4);
        for (index, position) in positions.into_iter().enumerate() {
            assert!(bytes[position..].starts_with(format!("{} 0 obj\n", index + 1).as_bytes()));
        }
        assert_eq!(bytes, drawing.pdf().expect("it can be drawn"), "the same drawing, the same file");
    }
}
