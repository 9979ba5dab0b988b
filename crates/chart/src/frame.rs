use crate::drawing::{letters_within, shortened, text_width};
use crate::{Anchor, Axis, Dash, Drawing, Emphasis, Ink, Mark, Point, SMALL};

/// Plot frame: two axes with a grid, a title above and a legend below the plot.
#[derive(Clone, Debug)]
pub struct Frame {
    x: Axis,
    y: Axis,
    drawing: Drawing,
}

/// Entry of a legend.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Name of the series.
    pub name: String,
    /// Index of its series.
    pub series: usize,
}

/// Width of every plot in pixels: a page shows two beside each other, a phone shows one.
const WIDTH: f64 = 480.0;
const LEFT: f64 = 64.0;
const RIGHT: f64 = 14.0;
const TOP: f64 = 36.0;
/// Height within the axes, in pixels.
const HEIGHT: f64 = 230.0;
/// Height of the ticks and the label of the horizontal axis, in pixels.
const BELOW: f64 = 46.0;
const LEGEND_LINE: f64 = 19.0;
/// Length of a minor tick, in pixels.
const MINOR_TICK: f64 = 4.0;
/// Length of the line sample in a legend, in pixels.
const SAMPLE: f64 = 26.0;

impl Frame {
    /// Creates an empty frame.
    pub fn new(title: &str, x: Axis, y: Axis, legend: &[Entry]) -> Self {
        let lines = legend_lines(legend);
        let height = TOP + HEIGHT + BELOW + LEGEND_LINE * lines.len() as f64 + 4.0;
        let mut frame = Self { x, y, drawing: Drawing { width: WIDTH, height, marks: Vec::new() } };
        frame.draw_title(title);
        frame.draw_grid();
        frame.draw_legend(&lines);
        frame
    }

    /// Returns the position of a pair of values.
    pub fn place(&self, x: f64, y: f64) -> Point {
        (LEFT + self.x.share_of(x) * (WIDTH - LEFT - RIGHT), TOP + (1.0 - self.y.share_of(y)) * HEIGHT)
    }

    /// Adds a mark, above the earlier ones.
    pub fn draw(&mut self, mark: Mark) {
        self.drawing.marks.push(mark);
    }

    /// Returns the drawing, with the axes above everything else.
    pub fn finish(mut self) -> Drawing {
        let (left, right, bottom) = (LEFT, WIDTH - RIGHT, TOP + HEIGHT);
        self.drawing.rule((left, bottom), (right, bottom), Ink::Quiet);
        self.drawing.rule((left, TOP), (left, bottom), Ink::Quiet);
        self.drawing
    }

    fn draw_title(&mut self, title: &str) {
        // A long title gets a smaller font down to the limit of legibility, and is shortened only then.
        let size = (10..=14).rev().find(|&size| text_width(title, size) < WIDTH - 12.0).unwrap_or(10);
        self.draw(Mark::Text {
            at: (8.0, 20.0),
            text: shortened(title, size, WIDTH - 12.0),
            size,
            anchor: Anchor::Start,
            ink: Ink::Text,
            emphasis: Emphasis::Strong,
        });
    }

    fn draw_grid(&mut self) {
        let bottom = TOP + HEIGHT;
        let spacing = (WIDTH - LEFT - RIGHT) / self.x.ticks.len().max(1) as f64;
        for (value, text) in self.x.ticks.clone() {
            let (x, _) = self.place(value, self.y.low);
            self.drawing.rule((x, TOP), (x, bottom), Ink::Grid);
            // Numbers are short, but names of scenarios may be paths.
            let is_name = text.chars().any(char::is_alphabetic);
            let text = if is_name { shortened(&text, SMALL, spacing - 4.0) } else { text };
            self.drawing.label((x, bottom + 16.0), text, Anchor::Middle, Ink::Quiet);
        }
        for (value, text) in self.y.ticks.clone() {
            let (_, y) = self.place(self.x.low, value);
            self.drawing.rule((LEFT, y), (WIDTH - RIGHT, y), Ink::Grid);
            self.drawing.label((LEFT - 6.0, y + 4.0), text, Anchor::End, Ink::Quiet);
        }
        for value in self.x.minor_ticks.clone() {
            let (x, _) = self.place(value, self.y.low);
            self.drawing.rule((x, bottom - MINOR_TICK), (x, bottom), Ink::Quiet);
        }
        for value in self.y.minor_ticks.clone() {
            let (_, y) = self.place(self.x.low, value);
            self.drawing.rule((LEFT, y), (LEFT + MINOR_TICK, y), Ink::Quiet);
        }
        let middle = (LEFT + WIDTH - RIGHT) / 2.0;
        self.drawing.label((middle, bottom + 35.0), self.x.label.clone(), Anchor::Middle, Ink::Text);
        let (at, text) = ((13.0, TOP + HEIGHT / 2.0), self.y.label.clone());
        self.draw(Mark::Upward { at, text, size: SMALL, ink: Ink::Text });
    }

    fn draw_legend(&mut self, lines: &[Vec<LegendText>]) {
        for (index, line) in lines.iter().enumerate() {
            let y = TOP + HEIGHT + BELOW + LEGEND_LINE * (index as f64 + 0.5);
            for &LegendText { x, ref text, series } in line {
                if let Some(series) = series {
                    let (ink, dash) = (Ink::Series(series), Dash::of_series(series));
                    let points = vec![(x, y - 4.0), (x + SAMPLE, y - 4.0)];
                    self.draw(Mark::Line { points, ink, width: 2.5, dash });
                }
                self.drawing.label((x + SAMPLE + 6.0, y), text.clone(), Anchor::Start, Ink::Text);
            }
        }
    }
}

/// Text of a legend with its horizontal position.
struct LegendText {
    x: f64,
    text: String,
    /// Series of the text; `None` if it continues the line above.
    series: Option<usize>,
}

/// Arranges the entries in columns of one width, as many as fit; names too long for a line continue on the next.
fn legend_lines(legend: &[Entry]) -> Vec<Vec<LegendText>> {
    let widest = legend.iter().map(|entry| text_width(&entry.name, SMALL)).fold(0.0, f64::max);
    let column = SAMPLE + 6.0 + widest + 14.0;
    let mut columns = 1;
    while column * (columns + 1) as f64 <= WIDTH - LEFT && columns < legend.len() {
        columns += 1;
    }
    let most = letters_within(WIDTH - LEFT - SAMPLE - 6.0 - RIGHT, SMALL);
    let mut lines = Vec::new();
    for entries in legend.chunks(columns) {
        let of_entry = |(index, entry): (usize, &Entry)| {
            let (x, letters) = (LEFT + column * index as f64, entry.name.chars().collect::<Vec<_>>());
            let text = letters.chunks(most).map(|letters| letters.iter().collect::<String>());
            let text = text.enumerate().map(|(part, text)| (text, (part == 0).then_some(entry.series)));
            text.map(|(text, series)| LegendText { x, text, series }).collect::<Vec<_>>()
        };
        let texts = entries.iter().enumerate().map(of_entry);
        // In several columns every name fits on one line.
        if columns > 1 {
            lines.push(texts.flatten().collect());
        } else {
            lines.extend(texts.flatten().map(|text| vec![text]));
        }
    }
    lines
}
