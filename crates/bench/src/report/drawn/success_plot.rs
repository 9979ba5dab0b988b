//! Share of solved runs over time or iterations: as in the paper's figures, one plot for each environment and planner with
//! one curve for each scenario; the planners compared on each scenario, and on all together.

use cranny_chart::{Axis, Dash, Entry, Frame, Ink, Mark};

use crate::report::drawn::plot::{Plot, Scope};
use crate::report::drawn::success_curve::{Measure, SuccessCurve};
use crate::report::number_text::percent;

/// Maximum number of curves whose overlapping bands are distinguishable.
const FEW: usize = 3;
const BAND_OPACITY: f64 = 0.14;
/// Opacity of the bands of more curves, reduced so that the curves stay visible.
const CROWDED_OPACITY: f64 = 0.06;

/// Curve with the index of its colour and its name in the legend.
struct Shown<'a> {
    curve: &'a SuccessCurve,
    series: usize,
    name: &'a str,
}

pub fn plots(scope: Scope) -> Vec<Plot> {
    let mut plots = Vec::new();
    let (planners, scenarios) = (scope.planners(), scope.scenarios());
    if curves(scope).any(|curve| curve.scenario_name.is_none()) {
        for over in [Measure::Time, Measure::Iterations] {
            let of = |&(series, name): &(usize, _)| {
                let found = curves(scope).find(|curve| curve.over == over && curve.planner_name == name);
                found.map(|curve| Shown { curve, series, name })
            };
            let shown: Vec<Shown> = planners.iter().filter_map(of).collect();
            let title = scope.title(format!("{}: all {} scenarios", scope.name(), scenarios.len()));
            plots.extend(plot(scope, &title, &["all"], over, &shown));
        }
        return plots;
    }
    for (_, planner) in &planners {
        for over in [Measure::Time, Measure::Iterations] {
            let numbered = scenarios.iter().copied().enumerate();
            let shown: Vec<Shown> = numbered
                .filter_map(|(series, name)| shown(scope, name, planner, over, series, name))
                .collect();
            plots.extend(plot(scope, &format!("{}: {planner}", scope.name()), &[planner], over, &shown));
        }
    }
    if planners.len() > 1 {
        for scenario in &scenarios {
            let of = |&(series, name): &(usize, _)| shown(scope, scenario, name, Measure::Time, series, name);
            let shown: Vec<Shown> = planners.iter().filter_map(of).collect();
            if shown.len() > 1 {
                let title = scope.title(format!("{scenario}: the planners"));
                let plot = plot(scope, &title, &[scenario], Measure::Time, &shown);
                plots.extend(plot.map(|plot| plot.of_scenario(scenario)));
            }
        }
    }
    plots
}

/// Compares the planners by the means of their curves over all shared scenarios.
pub fn overall(scope: Scope) -> Option<Plot> {
    let of = |(series, name)| {
        curves(scope).find(|curve| curve.planner_name == name).map(|curve| Shown { curve, series, name })
    };
    let shown: Vec<Shown> = scope.planners().into_iter().filter_map(of).collect();
    let count = scope.summary.overall.iter().find(|overall| overall.criterion == scope.criterion)?.scenarios;
    let title = scope.title(format!("{count} scenarios together"));
    plot(scope, &title, &["together"], Measure::Time, &shown)
}

fn curves(scope: Scope<'_>) -> impl Iterator<Item = &SuccessCurve> {
    scope.summary.curves.iter().filter(move |curve| {
        curve.criterion == scope.criterion && curve.environment.as_deref() == scope.environment
    })
}

fn shown<'a>(
    scope: Scope<'a>,
    scenario: &str,
    planner: &str,
    over: Measure,
    series: usize,
    name: &'a str,
) -> Option<Shown<'a>> {
    let fits = |curve: &&SuccessCurve| {
        curve.over == over
            && curve.planner_name == planner
            && curve.scenario_name.as_deref() == Some(scenario)
    };
    curves(scope).find(fits).map(|curve| Shown { curve, series, name })
}

fn plot(scope: Scope, title: &str, subject: &[&str], over: Measure, shown: &[Shown]) -> Option<Plot> {
    if shown.is_empty() {
        return None;
    }
    let (word, axis) = match over {
        Measure::Time => ("time", scope.time_axis("planning time, s")),
        Measure::Iterations => ("iterations", scope.iteration_axis("iterations")),
    };
    let entry = |shown: &Shown| {
        let end = percent(*shown.curve.success.last().unwrap_or(&0.0));
        // Over iterations the end is no success rate: a slow machine makes fewer iterations within the limit.
        let end = if over == Measure::Time { format!(" ({end} %)") } else { String::new() };
        Entry { name: format!("{}{end}", shown.name), series: shown.series }
    };
    let legend: Vec<Entry> = shown.iter().map(entry).collect();
    let title = format!("{title}, solved over {word}");
    let mut frame = Frame::new(&title, axis.with_room(), Axis::share("solved, %"), &legend);
    let opacity = if shown.len() > FEW { CROWDED_OPACITY } else { BAND_OPACITY };
    for shown in shown {
        draw_band(&mut frame, shown, opacity);
    }
    for shown in shown {
        draw_curve(&mut frame, shown);
    }
    let subject: Vec<&str> = subject.iter().copied().chain([word]).collect();
    Some(scope.plot(title, &subject, frame.finish()))
}

fn draw_curve(frame: &mut Frame, shown: &Shown) {
    let curve = shown.curve;
    let points = staircase(frame, curve, &curve.success, 0.0);
    let (ink, dash) = (Ink::Series(shown.series), Dash::of_series(shown.series));
    frame.draw(Mark::Line { points, ink, width: 2.0, dash });
}

fn draw_band(frame: &mut Frame, shown: &Shown, opacity: f64) {
    let curve = shown.curve;
    let Some(&first) = curve.high.first() else { return };
    let mut points = staircase(frame, curve, &curve.high, first);
    let low = staircase(frame, curve, &curve.low, 0.0);
    // The width of the band is undefined before the first jump.
    let start = frame.place(curve.at[0], 0.0).0;
    points.retain(|point| point.0 >= start);
    points.extend(low.into_iter().rev().filter(|point| point.0 >= start));
    frame.draw(Mark::Area { points, ink: Ink::Series(shown.series), opacity });
}

/// Distance in pixels below which jumps are drawn as one.
const FINEST: f64 = 0.3;

/// Returns the corners of a piecewise constant curve that starts at `before`, up to the end of the longest run, or to the end
/// of the axis if all runs are solved.
fn staircase(frame: &Frame, curve: &SuccessCurve, values: &[f64], before: f64) -> Vec<(f64, f64)> {
    let mut level = frame.place(0.0, before);
    let mut points = vec![level];
    for (&at, &value) in curve.at.iter().zip(values) {
        let place = frame.place(at, value);
        if place.0 - level.0 > FINEST {
            points.push((place.0, level.1));
            points.push(place);
            level = place;
        } else {
            level.1 = place.1;
            points.push((level.0, place.1));
        }
    }
    let all_solved = curve.success.last().is_some_and(|&success| success >= 1.0);
    let end = if all_solved { f64::INFINITY } else { curve.until };
    points.push((frame.place(end, 0.0).0, level.1));
    points
}
