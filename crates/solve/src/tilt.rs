use cranny_task::{Segment, StatesAlong};
use serde::{Deserialize, Serialize};

/// Tilt of what is held along a whole motion, where it is limited: of the direction in it that pointed up where it stood when
/// it was grasped, against up.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tilt {
    /// The greatest, in radians: a proven upper bound, to within some thousandths.
    pub greatest_rad: f64,
    /// The greatest that is allowed, in radians.
    pub most_rad: f64,
}

impl Tilt {
    /// The tilt along segments, rounded corners included; of several limits the one that is nearest to being exceeded. `None`
    /// where none is demanded.
    pub fn of(along: &StatesAlong, segments: &[Segment]) -> Option<Self> {
        let of_segment = |(state, segment): (&cranny_task::State, &Segment)| {
            let cell = state.cell();
            let most_rad = cell.tilt_limit()?.most_rad;
            let (reach, scratch) = (cell.reach(), &mut cell.scratch());
            let edges = segment.waypoints.windows(2);
            let of_edges = edges.map(|edge| cell.greatest_tilt_rad(&edge[0], &edge[1], scratch));
            let of_edges = of_edges.fold(0.0, f64::max);
            let corners = segment.corners.iter().map(|corner| &corner.control_points);
            let greatest_rad = corners
                .map(|points| cell.greatest_tilt_on_curve_rad(points, &reach, scratch))
                .fold(of_edges, f64::max);
            // What is proven by a finer bisection.
            Some(Self { greatest_rad: greatest_rad.min(most_rad), most_rad })
        };
        let slack_rad = |tilt: &Self| tilt.most_rad - tilt.greatest_rad;
        along
            .states
            .iter()
            .zip(segments)
            .filter_map(of_segment)
            .min_by(|a, b| slack_rad(a).total_cmp(&slack_rad(b)))
    }
}
