/// A path as a curve `q(s)`: straight lines along its edges, and between two of them either a stop or a
/// parabola that cuts the corner.
///
/// On a line `q' = dq/ds` is such that the slowest joint moves at its limit of velocity at `ṡ = 1`; `s` is
/// thus in seconds at full speed. It counts from the last stop.
#[derive(Clone, Debug)]
pub(crate) struct PathCurve {
    pub pieces: Vec<Piece>,
    /// For each way point the piece where it is passed, and at which `s`.
    pub waypoints: Vec<(usize, f64)>,
}

/// A line or a parabola: `q(s) = origin + slope·σ + ½·curvature·σ²` with `σ = s − begin` in [0, `length`].
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    /// Whether the robot rests where the piece begins; `begin` is 0 then.
    pub after_stop: bool,
    pub begin: f64,
    pub length: f64,
    pub origin: Vec<f64>,
    pub end: Vec<f64>,
    pub slope: Vec<f64>,
    /// `None` on a line.
    pub curvature: Option<Vec<f64>>,
}

/// Directions that differ by less, as a part of the joint's limit of velocity, are one: way points on a
/// straight line differ from it by rounding, about 1e-15 of the length of an edge.
const SAME_DIRECTION: f64 = 1e-9;

/// A parabola begins and ends this far before the middle of an edge at most, as a part of the edge, so that
/// some of every edge is a line.
const LARGEST_BLEND: f64 = 0.49;

struct Edge {
    from: usize,
    to: usize,
    length: f64,
    slope: Vec<f64>,
}

impl PathCurve {
    /// The curve along `path`, at least one way point (m, rad; one value per joint), by the limits `velocity` of the
    /// joints (m/s, rad/s; one per joint). At a way point k where the direction changes there is a stop, or, with
    /// `blends[k] = r > 0`, a parabola from r before it to r after it (as `s`, at most 0.49 of either edge); a
    /// missing blend is 0.
    pub fn along(path: &[Vec<f64>], velocity: &[f64], blends: &[f64]) -> Self {
        let edges = edges(path, velocity);
        // The blend at the end of edge e, 0 for none.
        let blend = |e: usize| match (edges.get(e), edges.get(e + 1)) {
            (Some(edge), Some(next)) if !is_straight_on(edge, next, velocity) => {
                let wanted = blends.get(edge.to).copied().unwrap_or(0.0);
                wanted.min(LARGEST_BLEND * edge.length.min(next.length)).max(0.0)
            }
            _ => 0.0,
        };
        let mut pieces: Vec<Piece> = Vec::new();
        let mut waypoints = vec![(0, 0.0); path.len()];
        let mut s = 0.0;
        for (index, edge) in edges.iter().enumerate() {
            let before = if index == 0 { 0.0 } else { blend(index - 1) };
            let after = blend(index);
            let after_stop =
                index == 0 || (before <= 0.0 && !is_straight_on(&edges[index - 1], edge, velocity));
            if after_stop {
                s = 0.0;
            }
            if before <= 0.0 {
                waypoints[edge.from..edge.to].fill((pieces.len(), s));
            }
            let corner = &path[edge.to];
            let end = if after > 0.0 { moved(corner, &edge.slope, -after) } else { corner.clone() };
            let origin = match pieces.last() {
                Some(blend) if before > 0.0 => blend.end.clone(),
                _ => path[edge.from].clone(),
            };
            let length = edge.length - before - after;
            let slope = edge.slope.clone();
            pieces.push(Piece { after_stop, begin: s, length, origin, end, slope, curvature: None });
            s += length;
            waypoints[edge.to..].fill((pieces.len() - 1, s));
            if after > 0.0 {
                waypoints[edge.to..edges[index + 1].to].fill((pieces.len(), s + after));
                pieces.push(parabola(corner, &edge.slope, &edges[index + 1].slope, after, s));
                s += 2.0 * after;
            }
        }
        Self { pieces, waypoints }
    }

    /// The blends that [`Self::along`] takes along `path` (m, rad; one value per joint) under `velocity` (m/s, rad/s;
    /// one per joint): one per way point, in seconds as `s` is, each the greatest that `proven` allows:
    /// `proven(corner, (slope before, slope after), greatest)`.
    pub fn blends(
        path: &[Vec<f64>],
        velocity: &[f64],
        mut proven: impl FnMut(&[f64], (&[f64], &[f64]), f64) -> f64,
    ) -> Vec<f64> {
        let mut blends = vec![0.0; path.len()];
        for pair in edges(path, velocity).windows(2) {
            let [edge, next] = pair else { continue };
            if !is_straight_on(edge, next, velocity) {
                let greatest = LARGEST_BLEND * edge.length.min(next.length);
                blends[edge.to] = proven(&path[edge.to], (&edge.slope, &next.slope), greatest);
            }
        }
        blends
    }

    /// The ranges of pieces from one stop to the next.
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

    /// `q(s)` (m, rad; one per joint); exactly `end` at the end of the piece.
    pub fn position(&self, s: f64) -> Vec<f64> {
        let sigma = (s - self.begin).clamp(0.0, self.length);
        if sigma >= self.length {
            return self.end.clone();
        }
        let ratio = sigma / self.length;
        match &self.curvature {
            // Rounding must not lead past an end, which may lie at a limit of the joint.
            None => (self.origin.iter().zip(&self.end))
                .map(|(a, b)| (a + (b - a) * ratio).clamp(a.min(*b), a.max(*b)))
                .collect(),
            Some(curvature) => (self.origin.iter().zip(&self.slope).zip(curvature))
                .map(|((q, slope), bend)| q + sigma * (slope + 0.5 * bend * sigma))
                .collect(),
        }
    }

    /// `dq/ds` and `d²q/ds²` of one joint at `s`.
    pub fn derivatives(&self, joint: usize, s: f64) -> (f64, f64) {
        let bend = self.curvature.as_ref().map_or(0.0, |c| c[joint]);
        let sigma = (s - self.begin).clamp(0.0, self.length);
        (self.slope[joint] + bend * sigma, bend)
    }
}

/// The edges that have a length.
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

/// The quadratic Bézier curve of `corner − r·before`, `corner`, `corner + r·after`, run through in `2r`.
fn parabola(corner: &[f64], before: &[f64], after: &[f64], r: f64, begin: f64) -> Piece {
    Piece {
        after_stop: false,
        begin,
        length: 2.0 * r,
        origin: moved(corner, before, -r),
        end: moved(corner, after, r),
        slope: before.to_vec(),
        curvature: Some(before.iter().zip(after).map(|(a, b)| (b - a) / (2.0 * r)).collect()),
    }
}

pub(crate) fn moved(q: &[f64], slope: &[f64], by: f64) -> Vec<f64> {
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
    fn a_blend_is_smooth_and_ends_on_the_edges() {
        let curve = PathCurve::along(&corner(), &[1.0, 1.0], &[0.0, 0.5, 0.5, 0.25, 0.0]);
        assert_eq!(curve.runs().first(), Some(&(0..4)));
        assert_eq!(curve.waypoints[3], (2, 2.0));
        let blend = &curve.pieces[2];
        assert_eq!((&blend.origin, &blend.end), (&vec![1.75, 0.0], &vec![2.0, 0.25]));
        for pair in curve.pieces.windows(2) {
            let s = pair[0].end_s();
            assert_eq!(pair[0].end, pair[1].origin);
            for joint in 0..2 {
                let (before, after) = (pair[0].derivatives(joint, s), pair[1].derivatives(joint, s));
                assert!((before.0 - after.0).abs() < 1e-12);
            }
        }
        // The parabola passes a quarter of the way from the corner to the middle of its chord's ends.
        let middle = blend.position(2.0);
        assert!((middle[0] - 1.9375).abs() < 1e-12 && (middle[1] - 0.0625).abs() < 1e-12);
    }
}
