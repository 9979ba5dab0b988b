use cranny_path::CurvedPath;
use cranny_robot::Robot;
use cranny_task::{RoundedCorner, Segment, StatesAlong, are_joined, joined};

use crate::Timing;
use crate::task_trajectory::edge_paces;

/// Rounds the corners of segments, each as far as its curve is proven free in the state along its segment and serves the
/// time ([`CurvedPath::rounded`]); where none is proven, and where a motion must end, the stop stays. Segments that follow
/// each other are joined where [`are_joined`] allows it. A robot without the limits for a trajectory has none rounded.
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
        let mut provers: Vec<Option<_>> = leg.iter().map(|_| None).collect();
        let curved = CurvedPath { paces: &paces, robot: Some(robot), ..CurvedPath::stopping(&way) };
        let corners = curved.rounded(&limits, |at, control_points| {
            let Some(&(index, at)) = places.get(at).filter(|place| may_be_rounded(**place)) else {
                return false;
            };
            let Some(cell) = states.get(index).map(cranny_task::State::cell) else { return false };
            let (reach, scratch) = provers[index].get_or_insert_with(|| (cell.reach(), cell.scratch()));
            let is_own = at > 0 || index > 0;
            is_own && cell.curve_is_free(control_points, reach, scratch).is_proven()
        });
        for corner in corners {
            let (index, waypoint) = places[corner.waypoint];
            leg[index].corners.push(RoundedCorner { waypoint, ..corner });
        }
    }
}
