/// Colour role of a mark; a dark page maps it to other colours than a sheet of paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ink {
    /// Main text.
    Text,
    /// Axes and secondary text.
    Quiet,
    /// Grid lines.
    Grid,
    /// Marks of the series with this index.
    Series(usize),
}

/// Alignment of a text with its position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// The text begins there.
    Start,
    /// The text is centred there.
    Middle,
    /// The text ends there.
    End,
}

/// Position in pixels, from the upper left corner.
pub type Point = (f64, f64);

/// Element of a drawing.
#[derive(Clone, Debug, PartialEq)]
pub enum Mark {
    /// Line through points.
    Line {
        /// Corners.
        points: Vec<Point>,
        /// Colour.
        ink: Ink,
        /// Width, in pixels.
        width: f64,
        /// Pattern.
        dash: Dash,
    },
    /// Translucent polygon.
    Area {
        /// Corners.
        points: Vec<Point>,
        /// Colour.
        ink: Ink,
        /// Opacity, from 0 to 1.
        opacity: f64,
    },
    /// Filled disc.
    Disc {
        /// Centre.
        center: Point,
        /// Radius, in pixels.
        radius: f64,
        /// Colour.
        ink: Ink,
    },
    /// Text on its baseline.
    Text {
        /// Position of the anchor.
        at: Point,
        /// Letters.
        text: String,
        /// Font size, in pixels.
        size: u32,
        /// Alignment.
        anchor: Anchor,
        /// Colour.
        ink: Ink,
        /// Weight.
        emphasis: Emphasis,
    },
    /// Text that reads from bottom to top, centred.
    Upward {
        /// Position of its middle.
        at: Point,
        /// Letters.
        text: String,
        /// Font size, in pixels.
        size: u32,
        /// Colour.
        ink: Ink,
    },
}

/// Weight of letters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Emphasis {
    /// Regular.
    Plain,
    /// Bold.
    Strong,
}

/// Dash pattern of a line, which distinguishes curves without their colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dash {
    /// No gaps.
    Solid,
    /// Long strokes.
    Long,
    /// Short strokes.
    Short,
    /// Dots.
    Dotted,
    /// A long stroke and a dot.
    Mixed,
}

impl Dash {
    /// Returns the pattern of the series with this index.
    pub fn of_series(index: usize) -> Self {
        [Self::Solid, Self::Long, Self::Short, Self::Mixed, Self::Dotted][index % 5]
    }

    /// Returns the lengths of strokes and gaps in turn, in pixels, as many strokes as gaps; empty if solid.
    pub fn lengths(self) -> &'static [f64] {
        match self {
            Self::Solid => &[],
            Self::Long => &[9.0, 3.0],
            Self::Short => &[4.0, 3.0],
            Self::Dotted => &[1.5, 2.5],
            Self::Mixed => &[8.0, 3.0, 1.5, 3.0],
        }
    }
}

/// Drawing with its marks.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    /// Width, in pixels.
    pub width: f64,
    /// Height, in pixels.
    pub height: f64,
    /// Marks in drawing order; later ones cover earlier ones.
    pub marks: Vec<Mark>,
}

/// Font size of ticks and legends, in pixels.
pub const SMALL: u32 = 12;

/// Estimates the width of a text in pixels: a letter is on average 0.56 of its height wide.
pub(crate) fn text_width(text: &str, size: u32) -> f64 {
    text.chars().count() as f64 * f64::from(size) * 0.56
}

/// Shortens a text to a width in pixels by replacing its middle with "…".
pub(crate) fn shortened(text: &str, size: u32, width: f64) -> String {
    let letters: Vec<char> = text.chars().collect();
    if text_width(text, size) <= width {
        return text.to_owned();
    }
    let kept = letters_within(width, size).saturating_sub(1).max(2);
    let (head, tail) = (kept.div_ceil(2), kept / 2);
    letters[..head].iter().chain(&['…']).chain(&letters[letters.len() - tail..]).collect()
}

/// Returns the maximum number of letters that fit into a width in pixels, for a font size.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small count, not negative")]
pub(crate) fn letters_within(width: f64, size: u32) -> usize {
    (width / text_width("m", size)).max(0.0) as usize
}

impl Drawing {
    /// Adds a solid line one pixel wide.
    pub fn rule(&mut self, from: Point, to: Point, ink: Ink) {
        self.marks.push(Mark::Line { points: vec![from, to], ink, width: 1.0, dash: Dash::Solid });
    }

    /// Adds small text.
    pub fn label(&mut self, at: Point, text: impl Into<String>, anchor: Anchor, ink: Ink) {
        let (text, emphasis) = (text.into(), Emphasis::Plain);
        self.marks.push(Mark::Text { at, text, size: SMALL, anchor, ink, emphasis });
    }

    /// Returns one drawing of two, `right` beside this one.
    #[must_use]
    pub fn beside(mut self, mut right: Self) -> Self {
        for mark in &mut right.marks {
            mark.shift(self.width);
        }
        self.marks.append(&mut right.marks);
        Self { width: self.width + right.width, height: self.height.max(right.height), marks: self.marks }
    }
}

impl Mark {
    fn shift(&mut self, right: f64) {
        match self {
            Self::Line { points, .. } | Self::Area { points, .. } => {
                for point in points {
                    point.0 += right;
                }
            }
            Self::Disc { center: at, .. } | Self::Text { at, .. } | Self::Upward { at, .. } => at.0 += right,
        }
    }
}
