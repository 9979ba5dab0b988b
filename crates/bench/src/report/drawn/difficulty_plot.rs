//! Success and time over the difficulty dial of an environment.

use cranny_chart::{Axis, Dash, Entry, Frame, Ink, Mark};

use crate::report::drawn::plot::{Plot, Scope};
use crate::report::row::Row;

/// Value with its interval.
struct Reading {
    low: f64,
    value: f64,
    high: f64,
}

pub fn plots(scope: Scope) -> Vec<Plot> {
    let mut dials: Vec<f64> = scope.rows().filter_map(|row| row.dial_m).collect();
    dials.sort_by(f64::total_cmp);
    dials.dedup();
    let (Some(&low), Some(&high)) = (dials.first(), dials.last()) else { return Vec::new() };
    if dials.len() < 2 {
        return Vec::new();
    }
    let success =
        |row: &Row| Some(Reading { low: row.success_low, value: row.success_rate, high: row.success_high });
    let median = |row: &Row| {
        Some(Reading {
            low: row.median_low_s.or(row.median_s)?,
            value: row.median_s?,
            high: row.median_high_s.unwrap_or(row.time_limit_s),
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
    for (series, name) in planners {
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
                let points = vec![frame.place(dial_m, reading.low), frame.place(dial_m, reading.high)];
                frame.draw(Mark::Line { points, ink, width: 1.0, dash: Dash::Solid });
                let center = frame.place(dial_m, reading.value);
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
