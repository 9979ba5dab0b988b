use cranny_spatial::{Pose, Vector};
use cranny_task::Segment;

/// Control points of a Bézier curve in the joints: two for a straight edge (m, rad; one value per joint each).
pub(crate) type JointCurve = Vec<Vec<f64>>;

/// Middle of a curve with a parameter from 0 to 1.
pub(crate) struct Middle {
    pub q: Vec<f64>,
    /// Derivative there.
    pub rate: Vec<f64>,
    /// Bounds on first and second derivative along the curve.
    pub fastest: Vec<f64>,
    pub most_bend: Vec<f64>,
}

/// Returns both halves of a curve (de Casteljau).
pub(crate) fn halves(curve: &JointCurve) -> [JointCurve; 2] {
    let mut points = curve.clone();
    let (mut first, mut second) = (Vec::new(), Vec::new());
    while let (Some(begin), Some(end)) = (points.first().cloned(), points.last().cloned()) {
        first.push(begin);
        second.push(end);
        let middle = |pair: &[Vec<f64>]| pair[0].iter().zip(&pair[1]).map(|(a, b)| 0.5 * (a + b)).collect();
        points = points.windows(2).map(middle).collect();
    }
    second.reverse();
    [first, second]
}

impl Middle {
    pub fn of(curve: &JointCurve) -> Self {
        let degree = (curve.len() - 1) as f64;
        let [left, right] = halves(curve);
        let (before, after) = (&left[left.len() - 2], &right[1]);
        let difference = |a: &[f64], b: &[f64]| b.iter().zip(a).map(|(b, a)| b - a).collect::<Vec<f64>>();
        let steps: Vec<Vec<f64>> = curve.windows(2).map(|pair| difference(&pair[0], &pair[1])).collect();
        let bends: Vec<Vec<f64>> = steps.windows(2).map(|pair| difference(&pair[0], &pair[1])).collect();
        let most = |values: &[Vec<f64>], factor: f64| {
            let most =
                |joint: usize| values.iter().fold(0.0, |most: f64, value| most.max(value[joint].abs()));
            (0..right[0].len()).map(|joint| factor * most(joint)).collect()
        };
        Self {
            rate: difference(before, after).into_iter().map(|x| degree * x).collect(),
            fastest: most(&steps, degree),
            most_bend: most(&bends, degree * (degree - 1.0)),
            q: right[0].clone(),
        }
    }
}

/// Coordinates of a pose as a certificate has them: translation, then quaternion with the scalar first.
pub(crate) fn pose_numbers(pose: &Pose) -> [f64; 7] {
    let (t, q): (Vector, _) = (pose.translation.vector, pose.rotation.coords);
    [t.x, t.y, t.z, q.w, q.x, q.y, q.z]
}

/// Pieces of the motion along segments, each with the index of the segment in whose cell it is.
pub(crate) struct Course {
    /// Straight edges between the way points.
    pub way_points: Vec<(usize, JointCurve)>,
    /// Curves of rounded corners, and the straight edges between them.
    pub rounded: Vec<(usize, JointCurve)>,
}

impl Course {
    pub fn of(segments: &[Segment]) -> Self {
        let mut course = Self { way_points: Vec::new(), rounded: Vec::new() };
        // End of the piece before.
        let mut at: Option<Vec<f64>> = None;
        for (index, segment) in segments.iter().enumerate() {
            for edge in segment.waypoints.windows(2) {
                course.way_points.push((index, edge.to_vec()));
            }
            let next = segments.get(index + 1).map(|next| &next.corners[..]).unwrap_or_default();
            let last = segment.waypoints.len() - 1;
            for (place, q) in segment.waypoints.iter().enumerate() {
                // The first way point is the last one of the segment before, where its corner was passed.
                if place == 0 && index > 0 {
                    continue;
                }
                let own = segment.corners.iter().find(|corner| corner.waypoint == place);
                let of_next = next.iter().find(|corner| place == last && corner.waypoint == 0);
                let corner = own.map(|corner| (index, corner)).or(of_next.map(|corner| (index + 1, corner)));
                let ends = |point: usize| {
                    corner.map_or_else(|| q.clone(), |(_, corner)| corner.control_points[point].clone())
                };
                let (enter, leave) = (ends(0), ends(4));
                if let Some(from) = at.replace(leave).filter(|from| *from != enter) {
                    course.rounded.push((index, vec![from, enter]));
                }
                course.rounded.extend(corner.map(|(of, corner)| (of, corner.control_points.to_vec())));
            }
        }
        course
    }
}
