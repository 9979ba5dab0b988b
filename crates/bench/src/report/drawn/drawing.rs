//! A drawing in a few kinds of marks, its colours named by what they mean.

/// What a mark is drawn with; a page in the dark has other colours for it than a sheet of paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ink {
    /// Letters, and what must be read.
    Text,
    /// Axes, and letters that step back.
    Quiet,
    /// Lines of the grid.
    Grid,
    /// What belongs to the series of that index.
    Series(usize),
}

/// Side of a place that its text lies on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// The text begins there.
    Start,
    /// Its middle is there.
    Middle,
    /// It ends there.
    End,
}

/// A place in pixels, from the upper left corner.
pub type Point = (f64, f64);

/// One thing in a drawing.
#[derive(Clone, Debug, PartialEq)]
pub enum Mark {
    /// A line through points.
    Line { points: Vec<Point>, ink: Ink, width: f64, dash: Dash },
    /// A translucent area within points.
    Area { points: Vec<Point>, ink: Ink, opacity: f64 },
    /// A disc.
    Disc { center: Point, radius: f64, ink: Ink },
    /// A word or more, on its baseline.
    Text { at: Point, text: String, size: u32, anchor: Anchor, ink: Ink, emphasis: Emphasis },
    /// A word or more that is read from below upwards.
    Upward { at: Point, text: String, size: u32, ink: Ink },
}

/// Weight of letters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Emphasis {
    /// Regular.
    Plain,
    /// Bold.
    Strong,
}

/// How a line is broken, so that curves can be told apart without their colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dash {
    /// Not at all.
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
    /// That of the series of that index.
    pub fn of_series(index: usize) -> Self {
        [Self::Solid, Self::Long, Self::Short, Self::Mixed, Self::Dotted][index % 5]
    }

    /// Lengths of strokes and gaps in turn, in pixels, as many strokes as gaps; none if it is solid.
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

/// A drawing.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    /// In pixels.
    pub width: f64,
    /// In pixels.
    pub height: f64,
    /// Marks in the order in which they cover each other.
    pub marks: Vec<Mark>,
}

/// Letters of ticks and legends, in pixels.
pub const SMALL: u32 = 12;

/// Width of text, for leaving room: a letter is about 0.56 of its height wide, in the mean of words.
pub fn text_width(text: &str, size: u32) -> f64 {
    text.chars().count() as f64 * f64::from(size) * 0.56
}

/// Text that is at most so wide: its middle gives way to "…".
pub fn shortened(text: &str, size: u32, width: f64) -> String {
    let letters: Vec<char> = text.chars().collect();
    if text_width(text, size) <= width {
        return text.to_owned();
    }
    let kept = letters_within(width, size).saturating_sub(1).max(2);
    let (head, tail) = (kept.div_ceil(2), kept / 2);
    letters[..head].iter().chain(&['…']).chain(&letters[letters.len() - tail..]).collect()
}

/// Greatest number of letters that fit into a width, of a font size.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small count, not negative")]
pub fn letters_within(width: f64, size: u32) -> usize {
    (width / text_width("m", size)).max(0.0) as usize
}

impl Drawing {
    /// A line of a pixel, unbroken.
    pub fn rule(&mut self, from: Point, to: Point, ink: Ink) {
        self.marks.push(Mark::Line { points: vec![from, to], ink, width: 1.0, dash: Dash::Solid });
    }

    /// Small text.
    pub fn label(&mut self, at: Point, text: impl Into<String>, anchor: Anchor, ink: Ink) {
        let (text, emphasis) = (text.into(), Emphasis::Plain);
        self.marks.push(Mark::Text { at, text, size: SMALL, anchor, ink, emphasis });
    }
}
