//! Success and time over the difficulty dial of an environment.

use cranny_chart::{Axis, Dash, Entry, Frame, Ink, Mark};

use crate::report::drawn::plot::{Plot, Scope};
use crate::report::row::Row;

/// Value with its interval.
struct Reading {
    low: f64,
    value: f64,
    /// Upper end; of an open interval, that of the axis.
    high: f64,
    is_open: bool,
}

/// Distance of the intervals of planners at one difficulty, and half the width of their ends, in pixels …
const BESIDE: f64 = 5.0;
const CAP: f64 = 3.0;
/// … and the greatest distance of the outermost ones, so that they do not reach the next difficulty.
const MOST_BESIDE: f64 = 30.0;

pub fn plots(scope: Scope) -> Vec<Plot> {
    let mut dials: Vec<f64> = scope.rows().filter_map(|row| row.dial_m).collect();
    dials.sort_by(f64::total_cmp);
    dials.dedup();
    let (Some(&low), Some(&high)) = (dials.first(), dials.last()) else { return Vec::new() };
    if dials.len() < 2 {
        return Vec::new();
    }
    let success = |row: &Row| {
        let (low, high) = (row.success_low, row.success_high);
        Some(Reading { low, value: row.success_rate, high, is_open: false })
    };
    let median = |row: &Row| {
        Some(Reading {
            low: row.median_low_s.or(row.median_s)?,
            value: row.median_s?,
            high: row.median_high_s.unwrap_or(row.time_limit_s),
            is_open: row.median_high_s.is_none(),
        })
    };
    // This margin keeps the discs at both ends within the axes.
    let room = 0.04 * (high - low);
    let dial = scope.rows().find_map(|row| row.dial).unwrap_or("dial");
    let x = || Axis::linear(&format!("{dial}, m"), low - room, high + room);
    let title = |what: &str| scope.title(format!("{}: {what} over {dial}", scope.name()));
    let mut plots = vec![scope.plot(
        title("success"),
        &["difficulty", "success"],
        drawing(scope, &title("success"), x(), Axis::share("solved, %"), &success),
    )];
    if scope.rows().any(|row| median(row).is_some()) {
        let time = scope.time_axis("median time, s").with_room();
        let drawing = drawing(scope, &title("median time"), x(), time, &median);
        plots.push(scope.plot(title("median time"), &["difficulty", "time"], drawing));
    }
    plots
}

fn drawing(
    scope: Scope,
    title: &str,
    x: Axis,
    y: Axis,
    reading: &dyn Fn(&Row) -> Option<Reading>,
) -> cranny_chart::Drawing {
    let planners = scope.planners();
    let legend: Vec<Entry> =
        planners.iter().map(|&(series, name)| Entry { name: name.to_owned(), series }).collect();
    let mut frame = Frame::new(title, x, y, &legend);
    let last = planners.len().saturating_sub(1) as f64;
    let beside = if last > 0.0 { BESIDE.min(MOST_BESIDE / last) } else { 0.0 };
    for (turn, (series, name)) in planners.into_iter().enumerate() {
        // The intervals of planners at one difficulty lie beside each other.
        let shift = beside * (turn as f64 - 0.5 * last);
        let of_planner = scope.rows().filter(|row| row.planner_name == name);
        let mut readings: Vec<(f64, Option<Reading>)> =
            of_planner.filter_map(|row| Some((row.dial_m?, reading(row)))).collect();
        readings.sort_by(|a, b| a.0.total_cmp(&b.0));
        let ink = Ink::Series(series);
        // The line is broken at missing values.
        for piece in readings.split(|(_, reading)| reading.is_none()) {
            let mut places = Vec::new();
            for (dial_m, reading) in
                piece.iter().filter_map(|(dial_m, reading)| Some((*dial_m, reading.as_ref()?)))
            {
                let place = |value: f64| {
                    let (x, y) = frame.place(dial_m, value);
                    (x + shift, y)
                };
                let [low, center, high] = [reading.low, reading.value, reading.high].map(place);
                // An arrow, without an end, where the interval is open.
                let end = if reading.is_open { 2.0 * CAP } else { 0.0 };
                for points in [
                    vec![low, high],
                    vec![(low.0 - CAP, low.1), (low.0 + CAP, low.1)],
                    vec![(high.0 - CAP, high.1 + end), high, (high.0 + CAP, high.1 + end)],
                ] {
                    frame.draw(Mark::Line { points, ink, width: 1.0, dash: Dash::Solid });
                }
                frame.draw(Mark::Disc { center, radius: 3.5, ink });
                places.push(center);
            }
            if places.len() > 1 {
                frame.draw(Mark::Line { points: places, ink, width: 2.0, dash: Dash::of_series(series) });
            }
        }
    }
    frame.finish()
}
