//! Box plots of times, path lengths and clearances, and peak memory, by scenario and planner.

use cranny_chart::{Axis, Dash, Entry, Frame, Ink, Mark, Point};

use crate::report::drawn::plot::{Plot, Scope};
use crate::report::drawn::success_curve::MOST_CURVES;
use crate::report::row::Row;
use crate::statistics::FiveNumbers;

/// Quantity of a plot, with its source in a row.
struct Quantity {
    word: &'static str,
    label: &'static str,
    title: &'static str,
    of: fn(&Row) -> Option<Quartiles>,
}

const TIMES: &str = "times";

const QUANTITIES: [Quantity; 4] = [
    Quantity { word: TIMES, label: "planning time, s", title: "planning time", of: times },
    Quantity {
        word: "lengths",
        label: "path length (m and rad alike)",
        title: "path length of the solved runs",
        of: |row| Some(Quartiles::of(row.path_length?, 1.0)),
    },
    Quantity {
        word: "clearances",
        label: "clearance, mm",
        title: "least clearance of the solved runs",
        of: |row| Some(Quartiles::of(row.clearance_m?, 1e3)),
    },
    Quantity { word: "memory", label: "memory, MB", title: "most memory of a search", of: most_memory },
];

/// Values of a box; infinite if the corresponding share of runs was not solved.
struct Quartiles {
    least: f64,
    lower: f64,
    median: f64,
    upper: f64,
    greatest: f64,
}

impl Quartiles {
    fn of(spread: FiveNumbers, scale: f64) -> Self {
        Self {
            least: scale * spread.least,
            lower: scale * spread.lower_quartile,
            median: scale * spread.median,
            upper: scale * spread.upper_quartile,
            greatest: scale * spread.greatest,
        }
    }

    fn values(&self) -> impl Iterator<Item = f64> + Clone + use<> {
        [self.least, self.lower, self.median, self.upper, self.greatest]
            .into_iter()
            .filter(|value| value.is_finite())
    }
}

/// Returns the quartiles of the Kaplan–Meier estimate, so that the median is that of the tables.
fn times(row: &Row) -> Option<Quartiles> {
    let beyond = |quantile: Option<f64>| quantile.unwrap_or(f64::INFINITY);
    Some(Quartiles {
        least: row.least_s?,
        lower: beyond(row.lower_quartile_s),
        median: beyond(row.median_s),
        upper: beyond(row.upper_quartile_s),
        greatest: beyond(row.greatest_s.filter(|_| row.solved == row.runs)),
    })
}

/// Returns the maximum alone: for most searches of built-in planners, less memory is recorded than they take.
fn most_memory(row: &Row) -> Option<Quartiles> {
    let most = 1e-6 * row.memory_bytes?.greatest;
    Some(Quartiles { least: most, lower: most, median: most, upper: most, greatest: most })
}

pub fn plots(scope: Scope) -> Vec<Plot> {
    if scope.scenarios().len() > MOST_CURVES {
        return Vec::new();
    }
    QUANTITIES.iter().filter_map(|quantity| plot(scope, quantity)).collect()
}

fn plot(scope: Scope, quantity: &Quantity) -> Option<Plot> {
    let values: Vec<f64> = scope.rows().filter_map(quantity.of).flat_map(|own| own.values()).collect();
    let lowest = values.iter().copied().min_by(f64::total_cmp)?;
    let (scenarios, planners) = (scope.scenarios(), scope.planners());
    let values = values.into_iter();
    let y = if quantity.word == TIMES {
        scope.time_axis(quantity.label)
    } else if lowest < 0.0 {
        Axis::linear(quantity.label, lowest, values.fold(0.0, f64::max))
    } else {
        Axis::amounts(quantity.label, values, 0.0)
    }
    .with_room();
    let legend: Vec<Entry> =
        planners.iter().map(|&(series, name)| Entry { name: name.to_owned(), series }).collect();
    let title = scope.title(format!("{}: {}", scope.name(), quantity.title));
    let mut frame = Frame::new(&title, Axis::names(&scenarios), y, &legend);
    // Boxes of one scenario stand beside each other in the middle three quarters of its slot.
    let width = 0.75 / planners.len() as f64;
    for row in scope.rows() {
        let slot = scenarios.iter().position(|name| *name == row.scenario_name);
        let turn = planners.iter().position(|(_, name)| *name == row.planner_name);
        if let (Some(slot), Some(turn), Some(quartiles)) = (slot, turn, (quantity.of)(row)) {
            let middle = slot as f64 + 0.125 + width * (turn as f64 + 0.5);
            draw_box(&mut frame, &quartiles, middle, 0.4 * width.min(0.4), planners[turn].0);
        }
    }
    Some(scope.plot(title, &[quantity.word], frame.finish()))
}

/// Opacity of the fill of a box; the grid remains visible.
const FILL_OPACITY: f64 = 0.15;

/// Height of a box below which it has a disc as well, and the radius of the disc, in pixels.
const LEAST_HEIGHT: f64 = 3.5;

/// Draws a box between the quartiles with the median across, and whiskers to the least and greatest values. Infinite values
/// are omitted: the box, or its upper whisker, then extends to the end of the axis and is open there.
fn draw_box(frame: &mut Frame, quartiles: &Quartiles, middle: f64, half: f64, series: usize) {
    let ink = Ink::Series(series);
    let Quartiles { least, lower, median, upper, greatest } = *quartiles;
    let (left, right, cap) = (middle - half, middle + half, half / 2.0);
    let place = |points: &[Point]| points.iter().map(|&(x, y)| frame.place(x, y)).collect::<Vec<_>>();
    let mut marks = Vec::new();
    let mut line = |points: &[Point], width| {
        marks.push(Mark::Line { points: place(points), ink, width, dash: Dash::Solid });
    };
    if lower.is_finite() {
        line(&[(left, upper), (left, lower), (right, lower), (right, upper)], 1.5);
    }
    for (height, half, width) in
        [(median, half, 3.0), (upper, half, 1.5), (greatest, cap, 1.5), (least, cap, 1.5)]
    {
        if height.is_finite() {
            line(&[(middle - half, height), (middle + half, height)], width);
        }
    }
    line(&[(middle, least), (middle, lower)], 1.5);
    if upper.is_finite() {
        line(&[(middle, upper), (middle, greatest)], 1.5);
    }
    if lower.is_finite() {
        let points = place(&[(left, lower), (right, lower), (right, upper), (left, upper)]);
        marks.insert(0, Mark::Area { points, ink, opacity: FILL_OPACITY });
    }
    // A box that is no more than a line, perhaps below the axis, has a disc.
    let center = frame.place(middle, median);
    let height = (frame.place(middle, greatest).1 - frame.place(middle, least).1).abs();
    if height < LEAST_HEIGHT && median.is_finite() {
        marks.push(Mark::Disc { center, radius: LEAST_HEIGHT, ink });
    }
    for mark in marks {
        frame.draw(mark);
    }
}
