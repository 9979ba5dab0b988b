//! Outlines of text, in the font of the program.

use ttf_parser::{Face, GlyphId, OutlineBuilder};

use crate::{Anchor, ChartError, Emphasis, Mark, Point};

/// Step of an outline; contours are closed at their first point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Step {
    /// Beginning of a contour.
    Move(Point),
    Line(Point),
    /// Cubic Bézier curve with two control points and its end.
    Curve(Point, Point, Point),
}

/// Text to be drawn.
pub(crate) struct TextLine<'a> {
    pub text: &'a str,
    pub at: Point,
    /// Height of the letters, in pixels.
    pub size: u32,
    pub anchor: Anchor,
    pub emphasis: Emphasis,
    /// True if the text reads from bottom to top.
    pub is_upward: bool,
}

impl Mark {
    /// Returns the text of the mark; `None` if it is none.
    pub(crate) fn text_line(&self) -> Option<TextLine<'_>> {
        match self {
            Self::Text { at, text, size, anchor, emphasis, ink: _ } => {
                let (at, size, anchor, emphasis) = (*at, *size, *anchor, *emphasis);
                Some(TextLine { text, at, size, anchor, emphasis, is_upward: false })
            }
            Self::Upward { at, text, size, ink: _ } => {
                let (anchor, emphasis) = (Anchor::Middle, Emphasis::Plain);
                Some(TextLine { text, at: *at, size: *size, anchor, emphasis, is_upward: true })
            }
            Self::Line { .. } | Self::Area { .. } | Self::Disc { .. } => None,
        }
    }
}

impl TextLine<'_> {
    /// Returns the outlines of the letters, to be filled by the non-zero winding rule. A letter that the font lacks is a box.
    ///
    /// # Errors
    /// [`ChartError::Font`].
    pub(crate) fn outline(&self) -> Result<Vec<Step>, ChartError> {
        let data = match self.emphasis {
            Emphasis::Plain => dejavu::sans::regular(),
            Emphasis::Strong => dejavu::sans::bold(),
        };
        let face = Face::parse(data, 0).map_err(|reason| ChartError::Font { reason })?;
        let scale = f64::from(self.size) / f64::from(face.units_per_em());
        let glyphs: Vec<GlyphId> =
            self.text.chars().map(|letter| face.glyph_index(letter).unwrap_or_default()).collect();
        let advance = |glyph: GlyphId| f64::from(face.glyph_hor_advance(glyph).unwrap_or_default());
        let width: f64 = glyphs.iter().map(|&glyph| advance(glyph)).sum();
        let begin = match self.anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => -0.5 * width,
            Anchor::End => -width,
        };
        let mut pen = Pen { line: self, scale, offset: begin, last: (0.0, 0.0), steps: Vec::new() };
        for glyph in glyphs {
            // Letters without an outline, such as blanks, only advance.
            let _ = face.outline_glyph(glyph, &mut pen);
            pen.offset += advance(glyph);
        }
        Ok(pen.steps)
    }
}

/// Receiver of the outlines of one text, in units of the font.
struct Pen<'a> {
    line: &'a TextLine<'a>,
    /// Pixels for each unit of the font.
    scale: f64,
    /// Start of the current letter on the base line.
    offset: f64,
    last: (f64, f64),
    steps: Vec<Step>,
}

impl Pen<'_> {
    fn placed(&self, (x, y): (f64, f64)) -> Point {
        let (along, up) = ((self.offset + x) * self.scale, y * self.scale);
        let (left, top) = self.line.at;
        if self.line.is_upward { (left - up, top - along) } else { (left + along, top - up) }
    }

    fn curve(&mut self, first: (f64, f64), second: (f64, f64), end: (f64, f64)) {
        self.steps.push(Step::Curve(self.placed(first), self.placed(second), self.placed(end)));
        self.last = end;
    }
}

impl OutlineBuilder for Pen<'_> {
    fn move_to(&mut self, x: f32, y: f32) {
        self.last = (x.into(), y.into());
        self.steps.push(Step::Move(self.placed(self.last)));
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.last = (x.into(), y.into());
        self.steps.push(Step::Line(self.placed(self.last)));
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let (start, control, end) = (self.last, (f64::from(x1), f64::from(y1)), (f64::from(x), f64::from(y)));
        // The same parabola as a cubic curve: its control points lie two thirds of the way to the only one.
        let towards = |from: (f64, f64)| {
            (from.0 + 2.0 / 3.0 * (control.0 - from.0), from.1 + 2.0 / 3.0 * (control.1 - from.1))
        };
        self.curve(towards(start), towards(end), end);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        self.curve((x1.into(), y1.into()), (x2.into(), y2.into()), (x.into(), y.into()));
    }

    fn close(&mut self) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bounds(line: &TextLine) -> (Point, Point) {
        let steps = line.outline().expect("the font is part of the program");
        let ends = steps.iter().map(|step| match *step {
            Step::Move(at) | Step::Line(at) | Step::Curve(_, _, at) => at,
        });
        let infinite = ((f64::INFINITY, f64::INFINITY), (f64::NEG_INFINITY, f64::NEG_INFINITY));
        ends.fold(infinite, |(low, high), (x, y)| {
            ((low.0.min(x), low.1.min(y)), (high.0.max(x), high.1.max(y)))
        })
    }

    #[test]
    fn text_stands_at_its_anchor_and_turns_with_its_direction() {
        let line = |anchor, is_upward| {
            let (at, emphasis) = ((100.0, 50.0), Emphasis::Plain);
            bounds(&TextLine { text: "HHHH", at, size: 10, anchor, emphasis, is_upward })
        };
        let ((left, top), (right, bottom)) = line(Anchor::Start, false);
        // DejaVu Sans: an H is 0.752 of the size wide with its bearings, and 0.729 high.
        assert!(left > 100.0 && right < 130.1 && right > 128.0, "{left} to {right}");
        assert!((bottom - 50.0).abs() < 1e-9 && (top - 42.71).abs() < 0.01, "{top} to {bottom}");
        let ((left, _), (right, _)) = line(Anchor::Middle, false);
        assert!((left + right - 200.0).abs() < 0.1, "{left} to {right}");
        let ((_, top), (right, bottom)) = line(Anchor::End, true);
        assert!(top > 50.0 && bottom < 80.1 && (right - 100.0).abs() < 1e-9, "{top} to {bottom}, {right}");
    }
}
