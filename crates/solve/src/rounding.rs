use cranny_collision::Measuring;
use cranny_path::CurvedPath;
use cranny_robot::Robot;
use cranny_task::{RoundedCorner, Segment, State, StatesAlong, are_joined, joined};

use crate::Timing;
use crate::task_trajectory::edge_paces;

/// Share of the least clearance of the edges of a leg that its rounded corners keep.
const KEPT_SHARE: f64 = 0.8;

/// Rounds the corners of segments, each as far as its curve is proven free in the state along its segment, keeps
/// [`KEPT_SHARE`] of the clearance of their edges, and serves the time ([`CurvedPath::rounded`]); where none is proven, and
/// where a motion must end, the stop stays. Segments that follow each other are joined where [`are_joined`] allows it. A robot
/// without the limits for a trajectory has none rounded.
pub(crate) fn round_corners(robot: &Robot, along: &StatesAlong, segments: &mut [Segment], timing: Timing) {
    let Ok(limits) = timing.limits(robot) else { return };
    let mut first = 0;
    while first < segments.len() {
        let holds = segments[first].mode.holds;
        let count = segments[first..].iter().take_while(|segment| segment.mode.holds == holds).count();
        let leg = &mut segments[first..first + count];
        let states = along.states.get(first..).unwrap_or_default();
        first += count;
        for segment in leg.iter_mut() {
            segment.corners.clear();
        }
        let (way, paces) = (joined(leg), edge_paces(leg));
        // The segment of each way point, and its index there.
        let places: Vec<(usize, usize)> = (0..leg.len())
            .flat_map(|index| (0..leg[index].waypoints.len().saturating_sub(1)).map(move |at| (index, at)))
            .collect();
        let may_be_rounded = |(index, at): (usize, usize)| {
            leg[index].mode.rests_at.is_none()
                && (at > 0 || index > 0 && are_joined(&leg[index - 1], &leg[index]))
        };
        let kept_m = KEPT_SHARE * least_clearance_m(leg, states);
        let mut provers: Vec<Option<_>> = leg.iter().map(|_| None).collect();
        let curved = CurvedPath { paces: &paces, robot: Some(robot), ..CurvedPath::stopping(&way) };
        let corners = curved.rounded(&limits, |at, control_points| {
            let Some(&(index, at)) = places.get(at).filter(|place| may_be_rounded(**place)) else {
                return false;
            };
            let Some(cell) = states.get(index).map(State::cell) else { return false };
            let (reach, scratch) = provers[index].get_or_insert_with(|| (cell.reach(), cell.scratch()));
            let is_own = at > 0 || index > 0;
            let margins = cell.margins();
            let beyond_m = (kept_m - margins.margin_m.min(margins.grasp_margin_m)).max(0.0);
            is_own && cell.curve_keeps(beyond_m, control_points, reach, scratch)
        });
        for corner in corners {
            let (index, waypoint) = places[corner.waypoint];
            leg[index].corners.push(RoundedCorner { waypoint, ..corner });
        }
    }
}

/// A lower bound of the least clearance of the edges of segments on which nothing may touch what carries it, in metres, near
/// enough to the truth for a share of it to count; 0 where there is nothing to touch.
fn least_clearance_m(leg: &[Segment], states: &[State]) -> f64 {
    const SHARE: f64 = 0.02;
    let mut least_m = f64::INFINITY;
    for (segment, state) in leg.iter().zip(states).filter(|(segment, _)| segment.mode.rests_at.is_none()) {
        let (cell, scratch) = (state.cell(), &mut state.cell().scratch());
        for edge in segment.waypoints.windows(2) {
            let measuring = Measuring { share: SHARE, below_m: least_m, ..Measuring::default() };
            least_m = least_m.min(cell.measure_motion([&edge[0], &edge[1]], measuring, scratch).least_m);
        }
    }
    if least_m.is_finite() { least_m } else { 0.0 }
}
