use cranny_chart::{Axis, Dash, Drawing, Entry, Frame, Ink, Mark};

/// Curves over the number of boxes, both axes logarithmic.
pub struct Panel {
    pub title: &'static str,
    /// Unit of the y axis.
    pub unit: &'static str,
    pub series: Vec<Series>,
}

pub struct Series {
    pub name: &'static str,
    pub points: Vec<(f64, f64)>,
}

/// Returns the panels beside each other, as an SVG file.
pub fn svg(panels: &[Panel]) -> String {
    let row = panels.iter().map(drawing).reduce(Drawing::beside);
    row.map_or_else(String::new, |row| row.svg())
}

fn drawing(panel: &Panel) -> Drawing {
    let points = || panel.series.iter().flat_map(|series| &series.points);
    let axis = |label, value: fn(&(f64, f64)) -> f64| {
        let least = points().map(value).min_by(f64::total_cmp);
        Axis::decades(label, least, points().map(value).fold(0.0, f64::max)).with_room()
    };
    let names = panel.series.iter().enumerate();
    let legend: Vec<Entry> = names.map(|(series, own)| Entry { name: own.name.to_owned(), series }).collect();
    let mut frame =
        Frame::new(panel.title, axis("boxes", |point| point.0), axis(panel.unit, |point| point.1), &legend);
    for (index, series) in panel.series.iter().enumerate() {
        let (ink, dash) = (Ink::Series(index), Dash::of_series(index));
        let points: Vec<_> = series.points.iter().map(|&(x, y)| frame.place(x, y)).collect();
        for &center in &points {
            frame.draw(Mark::Disc { center, radius: 3.0, ink });
        }
        frame.draw(Mark::Line { points, ink, width: 2.0, dash });
    }
    frame.finish()
}
