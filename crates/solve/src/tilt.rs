use cranny_collision::{ToolBound, ToolRegion};
use cranny_task::{Segment, State, StateSequence};
use serde::{Deserialize, Serialize};

/// Tilt of a held object along a whole motion, if it is limited: the angle between up and the direction in the object that
/// pointed up before the grasp.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tilt {
    /// Name of the object: if the tilt of several is limited, of the one that comes nearest to its limit.
    pub object: String,
    /// Greatest tilt along straight edges and rounded corners, in radians: a proven upper bound, to within some thousandths.
    pub greatest_rad: f64,
    /// Greatest allowed tilt, in radians.
    pub most_rad: f64,
}

/// Least slack of the tool within one of its bounds along a whole motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ToolSlack {
    /// Name of the bound.
    pub name: String,
    /// Proven lower bound, to within some thousandths, in metres; `None` for a bound on an angle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slack_m: Option<f64>,
    /// Proven lower bound in radians; `None` for a bound on a distance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slack_rad: Option<f64>,
}

impl Tilt {
    /// Computes the tilt of the object that comes nearest to its limit along segments, rounded corners included. `None` without a
    /// limit.
    pub fn of(along: &StateSequence, segments: &[Segment]) -> Option<Self> {
        let of_segment = |(state, segment): (&State, &Segment)| {
            let cell = state.cell();
            let bound = cell.tilt_bound()?;
            let ToolBound { region, .. } = cell.tool_bounds().nth(bound)?;
            let ToolRegion::Cone { most_rad, .. } = *region else { return None };
            let greatest_rad = (most_rad + greatest_excess(bound, state, segment)).max(0.0);
            Some(Self { object: segment.attached.clone()?, greatest_rad, most_rad })
        };
        let slack_rad = |tilt: &Self| tilt.most_rad - tilt.greatest_rad;
        let along = along.states.iter().zip(segments).filter_map(of_segment);
        along.min_by(|a, b| slack_rad(a).total_cmp(&slack_rad(b)))
    }
}

impl ToolSlack {
    /// Computes the slack of each tool bound, except the tilt of the held object, along segments, rounded corners included.
    pub fn all_of(along: &StateSequence, segments: &[Segment]) -> Vec<Self> {
        let Some(state) = along.states.first() else { return Vec::new() };
        let bounds = state.cell().world().tool_bounds().iter().enumerate();
        let slack = |(index, bound): (usize, &ToolBound)| {
            let along = along.states.iter().zip(segments);
            let excesses = along.map(|(state, segment)| greatest_excess(index, state, segment));
            let slack = -excesses.fold(f64::NEG_INFINITY, f64::max);
            let is_angle = bound.region.is_of_angle();
            let name = bound.name.clone();
            Self { name, slack_m: (!is_angle).then_some(slack), slack_rad: is_angle.then_some(slack) }
        };
        bounds.map(slack).collect()
    }
}

/// Returns the greatest excess over a bound along a segment that is proven to keep it.
fn greatest_excess(bound: usize, state: &State, segment: &Segment) -> f64 {
    let cell = state.cell();
    let (reach, scratch) = (cell.reach(), &mut cell.scratch());
    let edges = segment.waypoints.windows(2);
    let of_edges = edges.map(|edge| cell.greatest_excess(bound, &edge[0], &edge[1], scratch));
    let of_edges = of_edges.fold(f64::NEG_INFINITY, f64::max);
    let of_edges = match &segment.waypoints[..] {
        [only] => cell.tool_excess(bound, only, scratch),
        _ => of_edges,
    };
    let corners = segment.corners.iter().map(|corner| &corner.control_points);
    let greatest = corners
        .map(|points| cell.greatest_excess_on_curve(bound, points, &reach, scratch))
        .fold(of_edges, f64::max);
    // The proof, by a finer bisection, excludes a positive excess.
    greatest.min(0.0)
}
