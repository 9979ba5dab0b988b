use cranny_task::RoundedCorner;

use crate::PathError;

/// Path as a curve `q(s)`: straight lines along its edges, joined by either a stop or a rounded corner ([`RoundedCorner`]).
///
/// On the first line after a stop `q' = dq/ds` is scaled so that the slowest joint moves at its velocity limit at `ṡ = 1`; `s`
/// is thus in seconds at full speed. It counts from the last stop. In a rounded corner `q'` changes smoothly from that of one
/// line to that of the next, so that no joint is faster there than on both lines. If the corner cuts off more of one edge than
/// of the other, `q'` on the two lines differs by that ratio: at constant `ṡ` the robot changes speed in the corner.
#[derive(Clone, Debug)]
pub(crate) struct PathCurve {
    pub pieces: Vec<Piece>,
    /// Piece on which each way point is passed, and the value of `s` there.
    pub waypoints: Vec<(usize, f64)>,
}

/// A line or a rounded corner: `q(s) = origin + slope·σ + turn·length·τ³(1 − τ/2)` with `σ = s − begin = τ·length` in [0,
/// `length`].
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    /// True if the robot rests at the beginning of the piece; `begin` is 0 then.
    pub after_stop: bool,
    pub begin: f64,
    pub length: f64,
    pub origin: Vec<f64>,
    pub end: Vec<f64>,
    /// Slope at the beginning.
    pub slope: Vec<f64>,
    /// Change of the slope from beginning to end; `None` on a line.
    pub turn: Option<Vec<f64>>,
    /// Edges of the path that it lies on; both equal for a line.
    pub edges: [usize; 2],
}

/// First three derivatives of a joint with respect to `s`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Derivatives {
    pub first: f64,
    pub second: f64,
    pub third: f64,
}

/// Maximum difference, relative to the velocity limit of a joint, of directions that count as equal. Way points on a straight
/// line deviate from it by rounding, about 1e-15 of the length of an edge.
const SAME_DIRECTION: f64 = 1e-9;

/// Maximum share of an edge that rounded corners take, so that a line remains on every edge.
pub(crate) const LARGEST_SHARE: f64 = 0.98;

/// Maximum ratio of the lengths that a corner cuts off its two edges.
pub(crate) const MOST_UNEVEN: f64 = 32.0;

/// Lengths that a corner cuts off the edges before and after it, in seconds at full speed.
pub(crate) type Cuts = [f64; 2];

/// A way point at which the direction of a path changes.
#[derive(Clone, Debug)]
pub(crate) struct Corner {
    pub waypoint: usize,
    pub point: Vec<f64>,
    /// Velocities of the joints before and after it, at full speed.
    pub slopes: [Vec<f64>; 2],
    /// Lengths of the edges before and after it, in seconds at full speed.
    pub lengths: [f64; 2],
}

impl Corner {
    /// Returns the corner that cuts these lengths off its edges.
    pub fn rounded(&self, [before, after]: Cuts) -> RoundedCorner {
        let [from, to] =
            [moved(&self.point, &self.slopes[0], -before), moved(&self.point, &self.slopes[1], after)];
        RoundedCorner::new(self.waypoint, [&from, &self.point, &to])
    }
}

struct Edge {
    from: usize,
    to: usize,
    length: f64,
    slope: Vec<f64>,
}

impl PathCurve {
    /// Creates the curve along `path`, at least one way point (m, rad; one value per joint), with the velocity limits
    /// `velocity` of the joints (m/s, rad/s; one per joint). A way point k where the direction changes is a stop, or, with
    /// `cuts[k]` above 0, a rounded corner that cuts these lengths off its edges; missing cuts are 0.
    pub fn along(path: &[Vec<f64>], velocity: &[f64], cuts: &[Cuts]) -> Self {
        let edges = edges(path, velocity);
        // The cuts at the end of edge e, 0 for none.
        let cuts_after = |e: usize| match (edges.get(e), edges.get(e + 1)) {
            (Some(edge), Some(next)) if !is_straight_on(edge, next, velocity) => {
                cuts.get(edge.to).copied().unwrap_or_default()
            }
            _ => [0.0; 2],
        };
        let mut pieces: Vec<Piece> = Vec::new();
        let mut waypoints = vec![(0, 0.0); path.len()];
        let (mut s, mut scale) = (0.0, 1.0);
        for (index, edge) in edges.iter().enumerate() {
            let [_, before] = if index == 0 { [0.0; 2] } else { cuts_after(index - 1) };
            let [after, beyond] = cuts_after(index);
            let after_stop =
                index == 0 || (before <= 0.0 && !is_straight_on(&edges[index - 1], edge, velocity));
            if after_stop {
                (s, scale) = (0.0, 1.0);
            }
            if before <= 0.0 {
                waypoints[edge.from..edge.to].fill((pieces.len(), s));
            }
            let corner = &path[edge.to];
            let end = if after > 0.0 { moved(corner, &edge.slope, -after) } else { corner.clone() };
            let origin = match pieces.last() {
                Some(rounded) if before > 0.0 => rounded.end.clone(),
                _ => path[edge.from].clone(),
            };
            let length = ((edge.length - before - after) / scale).max(0.0);
            let slope = scaled(&edge.slope, scale);
            let of_edge = [edge.to - 1; 2];
            pieces.push(Piece {
                after_stop,
                begin: s,
                length,
                origin,
                end,
                slope,
                turn: None,
                edges: of_edge,
            });
            s += length;
            waypoints[edge.to..].fill((pieces.len() - 1, s));
            if after > 0.0 {
                let half = after / scale;
                waypoints[edge.to..edges[index + 1].to].fill((pieces.len(), s + half));
                let next = &edges[index + 1];
                let slope = scaled(&edge.slope, scale);
                scale *= beyond / after;
                let next_slope = scaled(&next.slope, scale);
                pieces.push(Piece {
                    after_stop: false,
                    begin: s,
                    length: 2.0 * half,
                    origin: moved(corner, &edge.slope, -after),
                    end: moved(corner, &next.slope, beyond),
                    turn: Some(slope.iter().zip(&next_slope).map(|(a, b)| b - a).collect()),
                    slope,
                    edges: [edge.to - 1, next.to - 1],
                });
                s += 2.0 * half;
            }
        }
        Self { pieces, waypoints }
    }

    /// Returns the corners of `path` (m, rad; one value per joint) that may be rounded, with the velocity limits `velocity` of
    /// the joints (m/s, rad/s; one per joint).
    pub fn corners(path: &[Vec<f64>], velocity: &[f64]) -> Vec<Corner> {
        let corner = |[edge, next]: [&Edge; 2]| {
            let is_one = next.from + 1 == next.to && edge.from + 1 == edge.to;
            (is_one && !is_straight_on(edge, next, velocity)).then(|| Corner {
                waypoint: edge.to,
                point: path[edge.to].clone(),
                slopes: [edge.slope.clone(), next.slope.clone()],
                lengths: [edge.length, next.length],
            })
        };
        edges(path, velocity).windows(2).filter_map(|pair| corner([&pair[0], &pair[1]])).collect()
    }

    /// Returns the cuts of rounded corners of a path (m, rad; one value per joint), one per way point, with the velocity limits
    /// of the joints (m/s, rad/s; one per joint).
    ///
    /// # Errors
    /// [`PathError::NoCorner`] for a rounded corner that is not at a corner of the path.
    pub fn cuts_of(
        path: &[Vec<f64>],
        velocity: &[f64],
        rounded: &[RoundedCorner],
    ) -> Result<Vec<Cuts>, PathError> {
        let mut cuts = vec![[0.0; 2]; path.len()];
        let corners = Self::corners(path, velocity);
        for rounded in rounded {
            let waypoint = rounded.waypoint;
            let found = corners.iter().find(|corner| corner.waypoint == waypoint);
            let corner = found.ok_or(PathError::NoCorner { waypoint })?;
            let of = [
                corner.lengths[0] * rounded.share_before(&path[waypoint - 1], &corner.point),
                corner.lengths[1] * rounded.share_after(&corner.point, &path[waypoint + 1]),
            ];
            if !of.iter().all(|cut| *cut > 0.0) {
                return Err(PathError::NoCorner { waypoint });
            }
            cuts[waypoint] = of;
        }
        Ok(cuts)
    }

    /// Returns the ranges of pieces from one stop to the next.
    pub fn runs(&self) -> Vec<std::ops::Range<usize>> {
        let mut starts: Vec<usize> = (0..self.pieces.len()).filter(|&i| self.pieces[i].after_stop).collect();
        starts.push(self.pieces.len());
        starts.windows(2).map(|pair| pair[0]..pair[1]).collect()
    }
}

impl Piece {
    pub fn end_s(&self) -> f64 {
        self.begin + self.length
    }

    /// Returns `q(s)` (m, rad; one per joint); exactly `end` at the end of the piece.
    pub fn position(&self, s: f64) -> Vec<f64> {
        let sigma = (s - self.begin).clamp(0.0, self.length);
        if sigma >= self.length {
            return self.end.clone();
        }
        let ratio = sigma / self.length;
        match &self.turn {
            // Rounding must not lead beyond an end, which may lie at a joint limit.
            None => (self.origin.iter().zip(&self.end))
                .map(|(a, b)| (a + (b - a) * ratio).clamp(a.min(*b), a.max(*b)))
                .collect(),
            Some(turn) => {
                let turned = self.length * ratio * ratio * ratio * (1.0 - 0.5 * ratio);
                (self.origin.iter().zip(&self.slope).zip(turn))
                    .map(|((q, slope), turn)| q + sigma * slope + turned * turn)
                    .collect()
            }
        }
    }

    /// Returns the derivatives of one joint at `s`.
    pub fn derivatives(&self, joint: usize, s: f64) -> Derivatives {
        let slope = self.slope[joint];
        let Some(turn) = self.turn.as_ref().map(|turn| turn[joint]) else {
            return Derivatives { first: slope, ..Derivatives::default() };
        };
        let ratio = ((s - self.begin) / self.length).clamp(0.0, 1.0);
        let rest = 1.0 - ratio;
        Derivatives {
            first: slope + turn * ratio * ratio * (3.0 - 2.0 * ratio),
            second: turn * 6.0 * ratio * rest / self.length,
            third: turn * 6.0 * (1.0 - 2.0 * ratio) / (self.length * self.length),
        }
    }

    /// Returns tight bounds of the absolute derivatives of one joint along the piece.
    pub fn greatest(&self, joint: usize) -> Derivatives {
        let first = self.slope[joint].abs();
        let Some(turn) = self.turn.as_ref().map(|turn| turn[joint]) else {
            return Derivatives { first, ..Derivatives::default() };
        };
        Derivatives {
            first: first.max((self.slope[joint] + turn).abs()),
            second: 1.5 * turn.abs() / self.length,
            third: 6.0 * turn.abs() / (self.length * self.length),
        }
    }
}

/// Returns the edges of non-zero length.
fn edges(path: &[Vec<f64>], velocity: &[f64]) -> Vec<Edge> {
    let mut edges = Vec::new();
    let mut from = 0;
    for to in 1..path.len() {
        let difference: Vec<f64> = path[from].iter().zip(&path[to]).map(|(a, b)| b - a).collect();
        let length = difference.iter().zip(velocity).map(|(d, v)| d.abs() / v).fold(0.0, f64::max);
        if length > 0.0 {
            let slope = difference.iter().map(|d| d / length).collect();
            edges.push(Edge { from, to, length, slope });
            from = to;
        }
    }
    edges
}

fn is_straight_on(edge: &Edge, next: &Edge, velocity: &[f64]) -> bool {
    let slopes = edge.slope.iter().zip(&next.slope);
    slopes.zip(velocity).all(|((a, b), v)| (a - b).abs() <= SAME_DIRECTION * v)
}

fn scaled(slope: &[f64], by: f64) -> Vec<f64> {
    slope.iter().map(|slope| slope * by).collect()
}

fn moved(q: &[f64], slope: &[f64], by: f64) -> Vec<f64> {
    q.iter().zip(slope).map(|(q, slope)| q + slope * by).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner() -> Vec<Vec<f64>> {
        vec![vec![0.0, 0.0], vec![1.0, 0.0], vec![1.0, 0.0], vec![2.0, 0.0], vec![2.0, 3.0]]
    }

    #[test]
    fn there_is_a_stop_exactly_where_the_direction_changes() {
        let curve = PathCurve::along(&corner(), &[1.0, 1.0], &[]);
        assert_eq!(curve.runs(), [0..2, 2..3]);
        assert_eq!(curve.waypoints, [(0, 0.0), (1, 1.0), (1, 1.0), (2, 0.0), (2, 3.0)]);
        let back = PathCurve::along(&[vec![0.0], vec![1.0], vec![0.5]], &[1.0], &[]);
        assert_eq!(back.runs(), [0..1, 1..2]);
        assert_eq!(PathCurve::along(&[vec![0.0], vec![0.0]], &[1.0], &[]).pieces.len(), 0);
    }

    #[test]
    fn a_rounded_corner_has_two_continuous_derivatives_and_is_its_bezier_curve() {
        let path = corner();
        let curve =
            PathCurve::along(&path, &[1.0, 1.0], &[[0.0; 2], [0.5; 2], [0.5; 2], [0.25, 0.75], [0.0; 2]]);
        assert_eq!(curve.runs().first(), Some(&(0..4)));
        assert_eq!(curve.waypoints[3], (2, 2.0));
        let rounded = &curve.pieces[2];
        assert_eq!((&rounded.origin, &rounded.end), (&vec![1.75, 0.0], &vec![2.0, 0.75]));
        for pair in curve.pieces.windows(2) {
            let s = pair[0].end_s();
            assert_eq!(pair[0].end, pair[1].origin);
            for joint in 0..2 {
                let (before, after) = (pair[0].derivatives(joint, s), pair[1].derivatives(joint, s));
                assert!((before.first - after.first).abs() < 1e-12);
                assert!((before.second - after.second).abs() < 1e-12);
            }
        }
        let points = RoundedCorner::new(3, [&rounded.origin, &path[3], &rounded.end]).control_points;
        for k in 0..=20 {
            let t = f64::from(k) / 20.0;
            let s = rounded.begin + t * rounded.length;
            let weights = [1.0, 4.0, 6.0, 4.0, 1.0];
            for (joint, position) in rounded.position(s).into_iter().enumerate() {
                let bezier: f64 = (0..)
                    .zip(weights.iter().zip(&points))
                    .map(|(i, (weight, point))| weight * t.powi(i) * (1.0 - t).powi(4 - i) * point[joint])
                    .sum();
                assert!((position - bezier).abs() < 1e-12);
                let step = 1e-4;
                let at = |s: f64| rounded.derivatives(joint, s);
                let inner = s.clamp(rounded.begin + step, rounded.end_s() - step);
                let (before, after, now) = (at(inner - step), at(inner + step), at(inner));
                assert!(((after.first - before.first) / (2.0 * step) - now.second).abs() < 1e-4);
                assert!(((after.second - before.second) / (2.0 * step) - now.third).abs() < 1e-4);
                let most = rounded.greatest(joint);
                assert!(now.first.abs() <= most.first && now.second.abs() <= most.second + 1e-12);
                assert!(now.third.abs() <= most.third + 1e-12);
            }
        }
    }

    #[test]
    fn cuts_are_those_of_the_control_points_under_any_limits_of_velocity() {
        let path = vec![vec![0.0, 0.0], vec![1.0, 0.0], vec![2.0, 3.0]];
        let corner = PathCurve::corners(&path, &[1.0, 2.0]).remove(0);
        assert_eq!((corner.waypoint, corner.lengths), (1, [1.0, 1.5]));
        let rounded = [corner.rounded([0.5, 0.9])];
        assert!(rounded[0].rounds([&path[0], &path[1], &path[2]]));
        let cuts = |velocity: &[f64]| PathCurve::cuts_of(&path, velocity, &rounded).expect("a corner")[1];
        let is_near = |a: Cuts, b: Cuts| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(is_near(cuts(&[1.0, 2.0]), [0.5, 0.9]) && is_near(cuts(&[0.5, 0.5]), [1.0, 3.6]));
        let straight = [path[0].clone(), path[1].clone(), vec![2.0, 0.0]];
        let none = PathCurve::cuts_of(&straight, &[1.0, 2.0], &rounded);
        assert!(matches!(none, Err(PathError::NoCorner { waypoint: 1 })));
    }
}
