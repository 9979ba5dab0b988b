use cranny_robot::{JointLimits, between, distance};

use crate::search::connector::Path;

/// Returns `count` way points at equal spacing on the straight line from `a` to `b` (m, rad; one per joint), ends included.
pub(crate) fn straight(a: &[f64], b: &[f64], count: usize) -> Path {
    let last = count.max(2) - 1;
    let point = |index: usize| match index {
        0 => a.to_vec(),
        index if index == last => b.to_vec(),
        index => between(a, b, index as f64 / last as f64).collect(),
    };
    (0..=last).map(point).collect()
}

/// Adds a smooth detour to the way points between the ends: half of `aside` (m, rad; one per joint) in the middle, nothing at the
/// ends, by a parabola.
pub(crate) fn add_detour(path: &mut Path, aside: &[f64]) {
    let last = path.len().max(2) - 1;
    for (index, q) in path.iter_mut().enumerate() {
        let share = index as f64 / last as f64;
        let height = 2.0 * share * (1.0 - share);
        for (value, aside) in q.iter_mut().zip(aside) {
            *value += height * aside;
        }
    }
}

/// Returns `count` way points at equal spacing along a path, by the plain norm of `q`, ends included.
pub(crate) fn resampled(path: &[Vec<f64>], count: usize) -> Path {
    let (Some(first), Some(end)) = (path.first(), path.last()) else { return Path::new() };
    let lengths: Vec<f64> = path.windows(2).map(|edge| distance(&edge[0], &edge[1])).collect();
    let total = lengths.iter().fold(0.0, |sum, length| sum + length);
    let last = count.max(2) - 1;
    let at = |index: usize| -> Vec<f64> {
        if index == 0 || total <= 0.0 {
            return first.clone();
        }
        let mut left = total * index as f64 / last as f64;
        for (edge, length) in path.windows(2).zip(&lengths) {
            if left <= *length && *length > 0.0 {
                return between(&edge[0], &edge[1], left / length).collect();
            }
            left -= length;
        }
        end.clone()
    };
    let mut points: Path = (0..last).map(at).collect();
    points.push(end.clone());
    points
}

/// Moves every value into the limits of its joint.
pub(crate) fn clamp(path: &mut [Vec<f64>], limits: &[JointLimits]) {
    for q in path {
        for (value, limits) in q.iter_mut().zip(limits) {
            *value = limits.clamp(*value);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_resampled_at_equal_spacing_with_its_ends() {
        let path = vec![vec![0.0, 0.0], vec![3.0, 0.0], vec![3.0, 1.0]];
        let points = resampled(&path, 5);
        assert_eq!(points, [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0], [3.0, 1.0]]);
        assert_eq!(resampled(&[vec![1.0], vec![1.0]], 3), [[1.0], [1.0], [1.0]]);
    }

    #[test]
    fn a_detour_keeps_the_ends() {
        let mut path = straight(&[0.0], &[1.0], 5);
        add_detour(&mut path, &[2.0]);
        assert_eq!((path[0][0], path[2][0], path[4][0]), (0.0, 1.5, 1.0));
    }
}
