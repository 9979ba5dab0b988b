//! Quartiles of times, path lengths and clearances, by scenario and planner.

use crate::report::axis::{Axis, Scale};
use crate::report::drawing::{Dash, Ink, Mark};
use crate::report::frame::{Entry, Frame};
use crate::report::plot::{Plot, Scope};
use crate::report::row::Row;
use crate::report::success_curve::MOST_CURVES;
use crate::statistics::Spread;

/// What is shown, and from which part of a row.
struct Quantity {
    word: &'static str,
    label: &'static str,
    title: &'static str,
    of: fn(&Row) -> Option<Spread>,
}

const QUANTITIES: [Quantity; 3] = [
    Quantity {
        word: "times",
        label: "planning time, s",
        title: "planning time, a failure counted as the limit",
        of: |row| row.time_s,
    },
    Quantity {
        word: "lengths",
        label: "path length (m and rad alike)",
        title: "path length of the solved runs",
        of: |row| row.path_length,
    },
    Quantity {
        word: "clearances",
        label: "clearance, mm",
        title: "least clearance of the solved runs",
        of: |row| row.clearance_m.map(millimetres),
    },
];

pub fn plots(scope: Scope) -> Vec<Plot> {
    if scope.scenarios().len() > MOST_CURVES {
        return Vec::new();
    }
    QUANTITIES.iter().filter_map(|quantity| plot(scope, quantity)).collect()
}

fn plot(scope: Scope, quantity: &Quantity) -> Option<Plot> {
    let spreads = || scope.rows().filter_map(quantity.of);
    spreads().next()?;
    let (scenarios, planners) = (scope.scenarios(), scope.planners());
    let x = Axis {
        label: String::new(),
        low: 0.0,
        high: scenarios.len() as f64,
        scale: Scale::Linear,
        ticks: scenarios.iter().enumerate().map(|(i, name)| (i as f64 + 0.5, (*name).to_owned())).collect(),
    };
    let values = spreads().flat_map(|spread| [spread.least, spread.greatest]);
    let lowest = values.clone().fold(f64::INFINITY, f64::min);
    let y = if lowest < 0.0 {
        Axis::linear(quantity.label, lowest, values.clone().fold(0.0, f64::max))
    } else {
        Axis::amounts(quantity.label, values, 0.0)
    }
    .with_room();
    let legend: Vec<Entry> =
        planners.iter().map(|&(series, name)| Entry { name: name.to_owned(), series }).collect();
    let title = format!("{}: {}", scope.environment, quantity.title);
    let mut frame = Frame::new(&title, x, y, &legend);
    // Boxes of one scenario stand beside each other in the middle three quarters of its place.
    let width = 0.75 / planners.len() as f64;
    for row in scope.rows() {
        let slot = scenarios.iter().position(|name| *name == row.scenario_name);
        let turn = planners.iter().position(|(_, name)| *name == row.planner_name);
        if let (Some(slot), Some(turn), Some(spread)) = (slot, turn, (quantity.of)(row)) {
            let middle = slot as f64 + 0.125 + width * (turn as f64 + 0.5);
            draw_box(&mut frame, &spread, middle, 0.4 * width.min(0.4), planners[turn].0);
        }
    }
    Some(scope.plot(title, &[quantity.word], frame.finish()))
}

/// Of what is within a box: the grid is seen through it.
const FILL_OPACITY: f64 = 0.15;

/// A box from quartile to quartile with the median across, whiskers to the least and the greatest value.
fn draw_box(frame: &mut Frame, spread: &Spread, middle: f64, half: f64, series: usize) {
    let ink = Ink::Series(series);
    let (left, right) = (middle - half, middle + half);
    let corners: Vec<(f64, f64)> = [
        (left, spread.lower_quartile),
        (right, spread.lower_quartile),
        (right, spread.upper_quartile),
        (left, spread.upper_quartile),
        (left, spread.lower_quartile),
    ]
    .map(|(x, y)| frame.place(x, y))
    .to_vec();
    frame.draw(Mark::Area { points: corners.clone(), ink, opacity: FILL_OPACITY });
    let mut line = |points, width| frame.draw(Mark::Line { points, ink, width, dash: Dash::Solid });
    line(corners, 1.5);
    let across = |frame: &Frame, from: (f64, f64), to: (f64, f64)| {
        vec![frame.place(from.0, from.1), frame.place(to.0, to.1)]
    };
    let cap = half / 2.0;
    for (from, to, width) in [
        ((left, spread.median), (right, spread.median), 3.0),
        ((middle, spread.upper_quartile), (middle, spread.greatest), 1.5),
        ((middle, spread.lower_quartile), (middle, spread.least), 1.5),
        ((middle - cap, spread.greatest), (middle + cap, spread.greatest), 1.5),
        ((middle - cap, spread.least), (middle + cap, spread.least), 1.5),
    ] {
        let points = across(frame, from, to);
        frame.draw(Mark::Line { points, ink, width, dash: Dash::Solid });
    }
}

fn millimetres(spread: Spread) -> Spread {
    Spread {
        count: spread.count,
        least: spread.least * 1e3,
        lower_quartile: spread.lower_quartile * 1e3,
        median: spread.median * 1e3,
        upper_quartile: spread.upper_quartile * 1e3,
        greatest: spread.greatest * 1e3,
    }
}
