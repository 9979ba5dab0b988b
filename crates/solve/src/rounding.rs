use cranny_collision::{Reach, Scratch};
use cranny_path::{CurveProof, CurvedPath};
use cranny_robot::Robot;
use cranny_task::{Mode, RoundedCorner, Segment, State, StateSequence, are_joined, joined};

use crate::Timing;
use crate::task_trajectory::edge_paces;

/// Share of the least clearance of the edges of a leg that its rounded corners keep.
const KEPT_SHARE: f64 = 0.8;

/// Smooths segments for a fast motion: rounds their corners and, if `may_move`, moves the way points of segments with a free
/// course where that saves time ([`CurvedPath::refined`]).
///
/// Every change is proven in the state along its segment, and keeps [`KEPT_SHARE`] of the clearance of the edges. The stop at a
/// way point remains where no rounding is proven, and where a motion must end. Consecutive segments are joined where
/// [`are_joined`] allows it. A robot without the limits for a trajectory gets no rounded corners.
pub(crate) fn smooth(
    robot: &Robot,
    along: &StateSequence,
    segments: &mut [Segment],
    (timing, may_move): (Timing, bool),
) {
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
        let mut proof = LegProof::new(leg, states);
        let curved = CurvedPath { paces: &paces, robot: Some(robot), ..CurvedPath::stopping(&way) };
        let is_free = |at: usize| {
            let (index, at) = proof.places[at];
            // With a limit on tool speed, a longer path of the tool may take longer although the joints are faster.
            let pace = leg[index].pace;
            let is_slow = pace.tool_m_s.is_some() || pace.turn_rad_s.is_some();
            may_move && at > 0 && FREE.contains(&leg[index].mode) && !is_slow
        };
        let movable: Vec<bool> = (0..proof.places.len()).map(is_free).collect();
        let refined = curved.refined(&limits, |at| movable[at], &mut proof);
        let places = proof.places;
        for (at, (index, within)) in places.iter().enumerate().filter(|(at, _)| movable[*at]) {
            leg[*index].waypoints[*within].clone_from(&refined.waypoints[at]);
        }
        for corner in refined.corners {
            let (index, waypoint) = places[corner.waypoint];
            leg[index].corners.push(RoundedCorner { waypoint, ..corner });
        }
    }
}

/// Modes whose path between its ends is free to choose; paths of other modes are straight on purpose.
const FREE: [Mode; 3] = [Mode::REACH, Mode::CARRY, Mode::RETURN];

/// Proofs for the segments of a leg, along which the fingers do not move.
struct LegProof<'a> {
    states: &'a [State],
    /// Segment of each way point of the leg but the last, and index of the way point in that segment.
    places: Vec<(usize, usize)>,
    /// For each of these way points, true if its corner may be rounded.
    may_be_rounded: Vec<bool>,
    kept_m: f64,
    provers: Vec<Option<(Reach, Scratch)>>,
}

impl<'a> LegProof<'a> {
    fn new(leg: &[Segment], states: &'a [State]) -> Self {
        let places: Vec<(usize, usize)> = (0..leg.len())
            .flat_map(|index| (0..leg[index].waypoints.len().saturating_sub(1)).map(move |at| (index, at)))
            .collect();
        let may_be_rounded = |(index, at): &(usize, usize)| {
            leg[*index].mode.rests_at.is_none()
                && (*at > 0 || *index > 0 && are_joined(&leg[index - 1], &leg[*index]))
        };
        Self {
            states,
            may_be_rounded: places.iter().map(may_be_rounded).collect(),
            places,
            kept_m: KEPT_SHARE * least_clearance_m(leg, states),
            provers: leg.iter().map(|_| None).collect(),
        }
    }

    /// Returns true if a curve (control points: m, rad; one value per joint each) in a segment keeps the clearance.
    fn keeps(&mut self, segment: usize, control_points: &[Vec<f64>]) -> bool {
        let Some(cell) = self.states.get(segment).map(State::cell) else { return false };
        let (reach, scratch) = self.provers[segment].get_or_insert_with(|| (cell.reach(), cell.scratch()));
        let margins = cell.margins();
        let beyond_m = (self.kept_m - margins.margin_m.min(margins.grasp_margin_m)).max(0.0);
        cell.curve_keeps(beyond_m, control_points, reach, scratch)
    }
}

impl CurveProof for LegProof<'_> {
    fn edge(&mut self, edge: usize, ends: [&[f64]; 2]) -> bool {
        self.places
            .get(edge)
            .copied()
            .is_some_and(|(segment, _)| self.keeps(segment, &ends.map(<[f64]>::to_vec)))
    }

    fn corner(&mut self, waypoint: usize, control_points: &[Vec<f64>; 5]) -> bool {
        self.may_be_rounded.get(waypoint) == Some(&true)
            && self
                .places
                .get(waypoint)
                .copied()
                .is_some_and(|(segment, _)| self.keeps(segment, control_points))
    }
}

/// Returns a lower bound of the least clearance, in metres, of the edges of segments without contact with a support, tight
/// enough to take a share of it; 0 if there is nothing to touch.
fn least_clearance_m(leg: &[Segment], states: &[State]) -> f64 {
    const SHARE: f64 = 0.04;
    let free = leg.iter().zip(states).filter(|(segment, _)| segment.mode.rests_at.is_none());
    let of_segment = |(segment, state): (&Segment, &State)| {
        let cell = state.cell();
        cell.path_clearance(&segment.waypoints, SHARE, &mut cell.scratch())
    };
    let least_m = free.map(of_segment).fold(f64::INFINITY, f64::min);
    if least_m.is_finite() { least_m } else { 0.0 }
}
