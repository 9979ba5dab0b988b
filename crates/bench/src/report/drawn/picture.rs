//! Export of drawings as SVG, PNG and PDF; the only module that uses the plotting library.

use kuva::backend::pdf::PdfBackend;
use kuva::backend::png::PngBackend;
use kuva::backend::svg::SvgBackend;
use kuva::render::color::Color;
use kuva::render::render::{PathData, Primitive, Scene, TextAnchor};

use crate::report::drawn::drawing::{Anchor, Dash, Drawing, Emphasis, Ink, Mark, Point};

/// Target of a drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Surface {
    /// Page whose style sheet defines the colours.
    Page,
    /// File with a white background.
    Sheet,
}

/// Colours of the series, distinguishable also with colour blindness: Okabe & Ito 2008, "Color universal design", whole,
/// without yellow (too light on white) and black (too strong), with a darker purple, and with grey added.
pub const SERIES: [&str; 7] = ["#0072b2", "#d55e00", "#009e73", "#aa4499", "#e69f00", "#56b4e9", "#5f5f5f"];

/// Pixels of a PNG for each pixel of a drawing: 960 wide, sharp in print at the width of a column.
const PNG_SCALE: f32 = 2.0;

/// Returns an `<svg>` element with the colours of the page (`--text`, `--quiet`, `--grid`, `--series-1` …) and a
/// description for screen readers.
pub fn page_svg(drawing: &Drawing, description: &str) -> String {
    let (w, h) = (drawing.width, drawing.height);
    let label = description.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
    format!(
        "<svg viewBox=\"0 0 {w} {h}\" role=\"img\" aria-label=\"{label}\">{}",
        body(drawing, Surface::Page)
    )
}

/// Returns an SVG file.
pub fn svg(drawing: &Drawing) -> String {
    let (w, h) = (drawing.width, drawing.height);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" width=\"{w}\" height=\"{h}\" \
         font-family=\"DejaVu Sans, Verdana, Helvetica, Arial, sans-serif\">{}",
        body(drawing, Surface::Sheet)
    )
}

/// Renders a PNG file with the font that comes with the library, so that no system font is needed.
///
/// # Errors
/// Message of the library.
pub fn png(drawing: &Drawing) -> Result<Vec<u8>, String> {
    let mut broken = drawing.clone();
    broken.marks = drawing.marks.iter().flat_map(strokes).collect();
    PngBackend::new().with_scale(PNG_SCALE).render_scene(&scene(&broken, Surface::Sheet))
}

/// Renders a PDF file of one page, as large as the drawing in points, with the required letters of the font of the library.
///
/// # Errors
/// Message of the library.
pub fn pdf(drawing: &Drawing) -> Result<Vec<u8>, String> {
    let mut scene = scene(drawing, Surface::Sheet);
    // Any other font depends on the machine, and its letters may be missing.
    scene.font_family = Some("DejaVu Sans".to_owned());
    PdfBackend::new().render_scene(&scene)
}

/// Returns the content after the opening tag, which the library writes without a view box.
fn body(drawing: &Drawing, surface: Surface) -> String {
    let text = SvgBackend::new().render_scene(&scene(drawing, surface));
    text.split_once('>').map_or_else(String::new, |(_, body)| body.to_owned())
}

fn scene(drawing: &Drawing, surface: Surface) -> Scene {
    let background = (surface == Surface::Sheet).then_some("white");
    let mut scene = Scene::new(drawing.width, drawing.height).with_background(background);
    for mark in &drawing.marks {
        scene.add(primitive(mark, surface));
    }
    scene
}

fn primitive(mark: &Mark, surface: Surface) -> Primitive {
    let text = |at: Point, text: &str, size, ink| Primitive::Text {
        x: at.0,
        y: at.1,
        // The library parses text between dollars as a formula.
        content: text.replace('$', "\\$"),
        size,
        anchor: TextAnchor::Middle,
        rotate: None,
        bold: false,
        color: Some(color(ink, surface)),
    };
    match mark {
        Mark::Line { points, ink, width, dash } => Primitive::PolyLine {
            points: points.clone(),
            stroke: color(*ink, surface),
            stroke_width: *width,
            stroke_dasharray: dash_array(*dash),
        },
        Mark::Area { points, ink, opacity } => {
            let corners: Vec<String> = points.iter().map(|(x, y)| format!("{x:.2},{y:.2}")).collect();
            Primitive::Path(Box::new(PathData {
                d: format!("M{}Z", corners.join("L")),
                fill: Some(color(*ink, surface)),
                stroke: Color::None,
                stroke_width: 0.0,
                opacity: Some(*opacity),
                stroke_dasharray: None,
            }))
        }
        Mark::Disc { center, radius, ink } => Primitive::Circle {
            cx: center.0,
            cy: center.1,
            r: *radius,
            fill: color(*ink, surface),
            fill_opacity: None,
            stroke: None,
            stroke_width: None,
        },
        Mark::Text { at, text: words, size, anchor, ink, emphasis } => {
            let mut primitive = text(*at, words, *size, *ink);
            if let Primitive::Text { anchor: place, bold, .. } = &mut primitive {
                *bold = *emphasis == Emphasis::Strong;
                *place = match anchor {
                    Anchor::Start => TextAnchor::Start,
                    Anchor::Middle => TextAnchor::Middle,
                    Anchor::End => TextAnchor::End,
                };
            }
            primitive
        }
        Mark::Upward { at, text: words, size, ink } => {
            let mut primitive = text(*at, words, *size, *ink);
            if let Primitive::Text { rotate, .. } = &mut primitive {
                *rotate = Some(-90.0);
            }
            primitive
        }
    }
}

fn dash_array(dash: Dash) -> Option<String> {
    let lengths: Vec<String> = dash.lengths().iter().map(ToString::to_string).collect();
    (!lengths.is_empty()).then(|| lengths.join(","))
}

fn color(ink: Ink, surface: Surface) -> Color {
    let (variable, sheet) = match ink {
        Ink::Text => ("var(--text)".to_owned(), "#1a1a1a"),
        Ink::Quiet => ("var(--quiet)".to_owned(), "#555555"),
        Ink::Grid => ("var(--grid)".to_owned(), "#dddddd"),
        Ink::Series(index) => {
            (format!("var(--series-{})", index % SERIES.len() + 1), SERIES[index % SERIES.len()])
        }
    };
    match surface {
        Surface::Page => Color::Css(variable.into_boxed_str()),
        Surface::Sheet => sheet.into(),
    }
}

/// Splits a dashed line into its strokes; the PNG renderer restarts the pattern at every point, which makes a curve of many
/// points appear solid. Other marks remain unchanged.
fn strokes(mark: &Mark) -> Vec<Mark> {
    let Mark::Line { points, ink, width, dash } = mark else { return vec![mark.clone()] };
    let lengths = dash.lengths();
    if lengths.is_empty() {
        return vec![mark.clone()];
    }
    let stroke = |points| Mark::Line { points, ink: *ink, width: *width, dash: Dash::Solid };
    let mut strokes = Vec::new();
    let (mut index, mut left) = (0, lengths[0]);
    let mut drawn = points.first().map_or_else(Vec::new, |&first| vec![first]);
    for pair in points.windows(2) {
        let (mut from, to) = (pair[0], pair[1]);
        loop {
            let distance = (to.0 - from.0).hypot(to.1 - from.1);
            if distance <= left {
                left -= distance;
                drawn.push(to);
                break;
            }
            let share = left / distance;
            from = (from.0 + share * (to.0 - from.0), from.1 + share * (to.1 - from.1));
            drawn.push(from);
            if index % 2 == 0 {
                strokes.push(stroke(std::mem::take(&mut drawn)));
            }
            index = (index + 1) % lengths.len();
            (left, drawn) = (lengths[index], vec![from]);
        }
    }
    if index % 2 == 0 && drawn.len() > 1 {
        strokes.push(stroke(drawn));
    }
    strokes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(dash: Dash) -> Mark {
        let points = (0..101).map(|i| (f64::from(i) * 0.5, 0.0)).collect();
        Mark::Line { points, ink: Ink::Text, width: 1.0, dash }
    }

    #[test]
    fn a_broken_line_of_many_points_keeps_its_pattern() {
        let strokes = strokes(&line(Dash::Long));
        let ends: Vec<(f64, f64)> = strokes
            .iter()
            .map(|mark| match mark {
                Mark::Line { points, .. } => (points[0].0, points[points.len() - 1].0),
                other => panic!("{other:?} is no line"),
            })
            .collect();
        assert_eq!(ends, [(0.0, 9.0), (12.0, 21.0), (24.0, 33.0), (36.0, 45.0), (48.0, 50.0)]);
    }

    #[test]
    fn pixels_are_a_png_of_twice_the_size() {
        let drawing = Drawing { width: 60.0, height: 20.0, marks: vec![line(Dash::Short)] };
        let bytes = png(&drawing).expect("it can be drawn");
        assert_eq!(&bytes[..8], b"\x89PNG\r\n\x1a\n");
        assert_eq!(bytes[16..24], [0, 0, 0, 120, 0, 0, 0, 40]);
    }

    #[test]
    fn a_pdf_holds_the_font_of_its_letters() {
        let text = |text: &str| Mark::Text {
            at: (5.0, 15.0),
            text: text.to_owned(),
            size: 12,
            anchor: Anchor::Start,
            ink: Ink::Text,
            emphasis: Emphasis::Plain,
        };
        let pdf = |marks| pdf(&Drawing { width: 60.0, height: 20.0, marks }).expect("it can be drawn");
        let bytes = pdf(vec![text("time, s")]);
        assert!(bytes.starts_with(b"%PDF-"));
        let names_font = |bytes: &[u8]| bytes.windows(10).any(|word| word == b"DejaVuSans");
        assert!(names_font(&bytes) && !names_font(&pdf(vec![line(Dash::Solid)])));
        assert_eq!(bytes, pdf(vec![text("time, s")]), "the same drawing, the same file");
    }

    #[test]
    fn a_page_names_the_colours_and_a_file_has_its_own() {
        let drawing = Drawing { width: 60.0, height: 20.0, marks: vec![line(Dash::Solid)] };
        assert!(page_svg(&drawing, "a <line> & \"more\"").contains("var(--text)"));
        assert!(page_svg(&drawing, "a <line>").contains("aria-label=\"a &lt;line>\""));
        assert!(svg(&drawing).contains("#1a1a1a") && !svg(&drawing).contains("var("));
    }
}
