use std::fmt::{self, Write as _};

use crate::{Anchor, Drawing, Emphasis, Ink, Mark, Point};

/// Returns the colour of an ink on a surface.
type Palette = fn(Ink) -> String;

impl Drawing {
    /// Returns an `<svg>` element with the colours of the page (`--text`, `--quiet`, `--grid`, `--series-1` …) and a
    /// description for screen readers.
    pub fn page_svg(&self, description: &str) -> String {
        let (w, h) = (self.width, self.height);
        let label = escaped(description);
        let open = format!("<svg viewBox=\"0 0 {w} {h}\" role=\"img\" aria-label=\"{label}\">");
        self.with_marks(open, Ink::in_page)
    }

    /// Returns an SVG file (Scalable Vector Graphics 1.1, whole) with a white background.
    pub fn svg(&self) -> String {
        let (w, h) = (self.width, self.height);
        let open = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" width=\"{w}\" height=\"{h}\" \
             font-family=\"DejaVu Sans, Verdana, Helvetica, Arial, sans-serif\">\
             <rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>"
        );
        self.with_marks(open, |ink| ink.on_white().to_owned())
    }

    fn with_marks(&self, mut svg: String, palette: Palette) -> String {
        for mark in &self.marks {
            // Writing to a string cannot fail.
            let _ = write_mark(&mut svg, mark, palette);
        }
        svg.push_str("</svg>");
        svg
    }
}

fn write_mark(svg: &mut String, mark: &Mark, palette: Palette) -> fmt::Result {
    match mark {
        Mark::Line { points, ink, width, dash } => {
            write!(svg, "<polyline points=\"{}\" fill=\"none\"", listed(points))?;
            write!(svg, " stroke=\"{}\" stroke-width=\"{width}\"", palette(*ink))?;
            let lengths: Vec<String> = dash.lengths().iter().map(ToString::to_string).collect();
            if !lengths.is_empty() {
                write!(svg, " stroke-dasharray=\"{}\"", lengths.join(","))?;
            }
            svg.write_str("/>")
        }
        Mark::Area { points, ink, opacity } => {
            let (points, fill) = (listed(points), palette(*ink));
            write!(svg, "<polygon points=\"{points}\" fill=\"{fill}\" fill-opacity=\"{opacity}\"/>")
        }
        Mark::Disc { center: (x, y), radius, ink } => {
            write!(svg, "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{radius}\" fill=\"{}\"/>", palette(*ink))
        }
        Mark::Text { at: (x, y), text, size, anchor, ink, emphasis } => {
            let anchor = match anchor {
                Anchor::Start => "start",
                Anchor::Middle => "middle",
                Anchor::End => "end",
            };
            let weight = if *emphasis == Emphasis::Strong { " font-weight=\"bold\"" } else { "" };
            write!(
                svg,
                "<text x=\"{x:.2}\" y=\"{y:.2}\" font-size=\"{size}\" text-anchor=\"{anchor}\"{weight}"
            )?;
            write!(svg, " fill=\"{}\">{}</text>", palette(*ink), escaped(text))
        }
        Mark::Upward { at: (x, y), text, size, ink } => {
            write!(svg, "<text transform=\"translate({x:.2},{y:.2}) rotate(-90)\" font-size=\"{size}\"")?;
            write!(svg, " text-anchor=\"middle\" fill=\"{}\">{}</text>", palette(*ink), escaped(text))
        }
    }
}

fn listed(points: &[Point]) -> String {
    let points: Vec<String> = points.iter().map(|(x, y)| format!("{x:.2},{y:.2}")).collect();
    points.join(" ")
}

/// Replaces the characters that end a text or an attribute, and those that XML 1.0, §2.2, does not allow.
fn escaped(text: &str) -> String {
    let allowed =
        text.chars().map(|c| if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') { ' ' } else { c });
    let text: String = allowed.collect();
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Dash;

    fn drawing() -> Drawing {
        let mut drawing = Drawing { width: 60.0, height: 20.0, marks: Vec::new() };
        let points = vec![(0.0, 1.0), (2.5, 1.0 / 3.0)];
        drawing.marks.push(Mark::Line { points, ink: Ink::Series(1), width: 2.0, dash: Dash::Long });
        drawing.label((5.0, 6.0), "a <b> & \"$c\"\u{7}", Anchor::End, Ink::Text);
        drawing
    }

    #[test]
    fn a_page_names_the_colours_and_a_file_has_its_own() {
        let page = drawing().page_svg("a <line> & \"more\"");
        assert!(page.contains("aria-label=\"a &lt;line&gt; &amp; &quot;more&quot;\""), "{page}");
        assert!(page.contains("var(--text)") && page.contains("var(--series-2)"), "{page}");
        let file = drawing().svg();
        assert!(file.contains("#1a1a1a") && file.contains("#d55e00") && !file.contains("var("), "{file}");
    }

    #[test]
    fn marks_are_elements_and_texts_are_escaped() {
        let line = "<polyline points=\"0.00,1.00 2.50,0.33\" fill=\"none\" stroke=\"#d55e00\" stroke-width=\"2\" \
                    stroke-dasharray=\"9,3\"/>";
        let text = "<text x=\"5.00\" y=\"6.00\" font-size=\"12\" text-anchor=\"end\" fill=\"#1a1a1a\">\
                    a &lt;b&gt; &amp; &quot;$c&quot; </text></svg>";
        let svg = drawing().svg();
        assert!(svg.contains(line) && svg.ends_with(text), "{svg}");
    }
}
