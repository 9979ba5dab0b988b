use kuva::backend::svg::SvgBackend;
use kuva::plot::{LinePlot, ScatterPlot};
use kuva::render::figure::Figure;
use kuva::render::layout::Layout;
use kuva::render::plots::Plot;

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

/// Colours that colour-blind readers can distinguish (Okabe & Ito 2008, "Color universal design", whole).
const COLORS: [&str; 4] = ["#0072B2", "#D55E00", "#009E73", "#CC79A7"];

pub fn svg(panels: &[Panel]) -> String {
    let plots: Vec<Vec<Plot>> = panels.iter().map(curves).collect();
    let layout = |(panel, plots): (&Panel, &Vec<Plot>)| {
        Layout::auto_from_plots(plots)
            .with_log_scale()
            .with_title(panel.title)
            .with_x_label("boxes")
            .with_y_label(panel.unit)
    };
    let layouts = panels.iter().zip(&plots).map(layout).collect();
    let figure = Figure::new(1, panels.len()).with_plots(plots).with_layouts(layouts);
    SvgBackend.render_scene(&figure.with_cell_size(560.0, 400.0).render())
}

fn curves(panel: &Panel) -> Vec<Plot> {
    let of_series = |(series, color): (&Series, &&str)| {
        let points = series.points.iter().copied();
        let line = LinePlot::new().with_data(points.clone()).with_color(*color).with_legend(series.name);
        let marks = ScatterPlot::new().with_data(points).with_color(*color).with_size(4.0);
        [Plot::Line(line), Plot::Scatter(marks)]
    };
    panel.series.iter().zip(&COLORS).flat_map(of_series).collect()
}
