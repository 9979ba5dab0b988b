use serde::{Deserialize, Serialize};

/// A rounded corner of a path: a curve that leaves one edge before a way point and joins the next one after it.
///
/// The curve is a Bézier curve of degree 4 with control points `P_0 … P_4`: `P_2` is the way point, `P_0` lies on the edge
/// before it, `P_4` on the edge after it, `P_1` and `P_3` halfway. Its slope changes from `u = 2(P_2 − P_0)` to
/// `v = 2(P_4 − P_2)` as `u + h(τ)·(v − u)`, `h(τ) = τ²(3 − 2τ)`: first and second derivative are continuous.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RoundedCorner {
    /// Index of the way point in its segment, never the last. Index 0 is also the end of the previous segment.
    pub waypoint: usize,
    /// Control points: one value per joint each (m, rad).
    pub control_points: [Vec<f64>; 5],
}

/// Difference up to which control points count as equal (m, rad): the rounding of numbers of some metres.
const SAME: f64 = 1e-9;

impl RoundedCorner {
    /// Creates the corner at a way point between two points of its edges (m, rad; one value per joint each).
    pub fn new(waypoint: usize, [before, corner, after]: [&[f64]; 3]) -> Self {
        let middle = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| 0.5 * (a + b)).collect();
        let control_points =
            [before.to_vec(), middle(before, corner), corner.to_vec(), middle(corner, after), after.to_vec()];
        Self { waypoint, control_points }
    }

    /// Returns true if the control points form a corner between the edges of these three way points (m, rad; one value per
    /// joint each).
    pub fn rounds(&self, [from, corner, to]: [&[f64]; 3]) -> bool {
        let joints = corner.len();
        if self.control_points.iter().any(|point| point.len() != joints) {
            return false;
        }
        let [before, _, _, _, after] = &self.control_points;
        let is_same = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= SAME);
        let made = Self::new(self.waypoint, [before, corner, after]);
        let has_form = made.control_points.iter().zip(&self.control_points).all(|(a, b)| is_same(a, b));
        has_form
            && [(from, before), (to, after)].into_iter().all(|(end, point)| {
                let share = share_on(corner, end, point);
                let on_edge: Vec<f64> = corner.iter().zip(end).map(|(c, e)| c + share * (e - c)).collect();
                share > 0.0 && share <= 1.0 && is_same(&on_edge, point)
            })
    }

    /// Share of the edge from the previous way point that the corner cuts off; way points in m and rad, one value per joint.
    pub fn share_before(&self, from: &[f64], corner: &[f64]) -> f64 {
        share_on(corner, from, &self.control_points[0])
    }

    /// Share of the edge to the next way point that the corner cuts off; way points in m and rad, one value per joint.
    pub fn share_after(&self, corner: &[f64], to: &[f64]) -> f64 {
        share_on(corner, to, &self.control_points[4])
    }
}

/// Returns the share of the line from `corner` to `end` at which its point nearest to `point` lies.
fn share_on(corner: &[f64], end: &[f64], point: &[f64]) -> f64 {
    let products =
        corner.iter().zip(end).zip(point).map(|((c, e), p)| ((e - c) * (p - c), (e - c) * (e - c)));
    let (along, length2) = products.fold((0.0, 0.0), |sum, product| (sum.0 + product.0, sum.1 + product.1));
    if length2 > 0.0 { along / length2 } else { 0.0 }
}
