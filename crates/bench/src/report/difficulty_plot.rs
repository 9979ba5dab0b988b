//! How success and time change with the dial of an environment.

use crate::report::axis::Axis;
use crate::report::drawing::{Dash, Ink, Mark};
use crate::report::frame::{Entry, Frame};
use crate::report::plot::{Plot, Scope};
use crate::report::row::Row;

/// A value and its interval above one place of the dial.
struct Reading {
    dial_m: f64,
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
    let success = |row: &Row| {
        Some(Reading {
            dial_m: row.dial_m?,
            low: row.success_low,
            value: row.success_rate,
            high: row.success_high,
        })
    };
    let limit_s = scope.rows().map(|row| row.time_limit_s).fold(0.0, f64::max);
    let median = |row: &Row| {
        Some(Reading {
            dial_m: row.dial_m?,
            low: row.median_low_s.or(row.median_s)?,
            value: row.median_s?,
            high: row.median_high_s.unwrap_or(row.time_limit_s),
        })
    };
    // Room for the discs at both ends.
    let room = 0.04 * (high - low);
    let dial = scope.rows().find_map(|row| row.dial).unwrap_or("dial");
    let x = || Axis::linear(&format!("{dial}, m"), low - room, high + room);
    let medians = scope.rows().filter_map(median).flat_map(|reading| [reading.low, reading.high]);
    let time = Axis::amounts("median time, s", medians.collect::<Vec<_>>().into_iter(), 0.0).with_room();
    let title = |what: &str| format!("{}: {what} over {dial}", scope.environment);
    let mut plots = vec![scope.plot(
        title("success"),
        &["difficulty", "success"],
        drawing(scope, &title("success"), x(), Axis::share(), &success),
    )];
    if limit_s > 0.0 && scope.rows().any(|row| median(row).is_some()) {
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
) -> crate::report::drawing::Drawing {
    let planners = scope.planners();
    let legend: Vec<Entry> =
        planners.iter().map(|&(series, name)| Entry { name: name.to_owned(), series }).collect();
    let mut frame = Frame::new(title, x, y, &legend);
    for (series, name) in planners {
        let mut readings: Vec<Reading> =
            scope.rows().filter(|row| row.planner_name == name).filter_map(reading).collect();
        readings.sort_by(|a, b| a.dial_m.total_cmp(&b.dial_m));
        let ink = Ink::Series(series);
        for reading in &readings {
            let points =
                vec![frame.place(reading.dial_m, reading.low), frame.place(reading.dial_m, reading.high)];
            frame.draw(Mark::Line { points, ink, width: 1.0, dash: Dash::Solid });
        }
        let places: Vec<_> =
            readings.iter().map(|reading| frame.place(reading.dial_m, reading.value)).collect();
        for &center in &places {
            frame.draw(Mark::Disc { center, radius: 3.5, ink });
        }
        frame.draw(Mark::Line { points: places, ink, width: 2.0, dash: Dash::of_series(series) });
    }
    frame.finish()
}
