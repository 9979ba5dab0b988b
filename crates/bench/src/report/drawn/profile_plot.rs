//! Share of trials in which each planner is within a factor of the fastest: performance profiles (Dolan & Moré 2002, §2).

use cranny_chart::{Axis, Dash, Entry, Frame, Ink, Mark, Point};

use crate::report::Overall;
use crate::report::drawn::plot::{Plot, Scope};
use crate::report::number_text::percent;

/// Draws the profiles of all planners of a criterion; `None` for a single one, which is always the fastest.
pub fn plot(scope: Scope) -> Option<Plot> {
    let profiles = profiles(scope);
    let count = profiles.first()?.scenarios;
    if profiles.len() < 2 {
        return None;
    }
    let series =
        |name: &str| scope.planners().iter().find(|(_, own)| *own == name).map_or(0, |(series, _)| *series);
    let entry = |profile: &&Overall| Entry {
        name: format!("{} (fastest on {} %)", profile.planner_name, percent(profile.best)),
        series: series(&profile.planner_name),
    };
    let legend: Vec<Entry> = profiles.iter().map(entry).collect();
    let greatest =
        profiles.iter().filter_map(|profile| profile.profile_at.last()).copied().fold(1.0, f64::max);
    // The axis extends past the greatest ratio to show the constant end of the profiles.
    let x =
        Axis::decades("median time over that of the fastest planner", Some(1.0), (2.0 * greatest).max(10.0));
    let title = scope.title(format!("Performance profile over {count} scenarios"));
    let mut frame = Frame::new(&title, x, Axis::share("scenarios, %"), &legend);
    for (profile, entry) in profiles.iter().zip(&legend) {
        let points = staircase(&frame, profile);
        let (ink, dash) = (Ink::Series(entry.series), Dash::of_series(entry.series));
        frame.draw(Mark::Line { points, ink, width: 2.0, dash });
    }
    Some(scope.plot(title, &["profile"], frame.finish()))
}

fn profiles(scope: Scope<'_>) -> Vec<&Overall> {
    let is_drawn = |overall: &&Overall| {
        overall.criterion == scope.criterion && scope.drawn.binary_search(&&*overall.planner_name).is_ok()
    };
    scope.summary.overall.iter().filter(is_drawn).collect()
}

/// Returns the corners of a profile, from the ratio 1 to the end of the axis.
fn staircase(frame: &Frame, profile: &Overall) -> Vec<Point> {
    let mut share = 0.0;
    let mut points = Vec::new();
    for (&at, &next) in profile.profile_at.iter().zip(&profile.profile_share) {
        points.extend([frame.place(at, share), frame.place(at, next)]);
        share = next;
    }
    if points.is_empty() {
        points.push(frame.place(1.0, 0.0));
    }
    points.push(frame.place(f64::INFINITY, share));
    points
}
