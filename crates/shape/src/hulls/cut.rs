//! Halving of a convex polyhedron that is given by its corners alone.

use cranny_spatial::Point;

/// Both halves of the convex hull of some points, each as the points that span it.
///
/// Law: together the halves contain the hull, up to rounding of 10⁻⁹ m (`no_point_of_a_hull_is_lost_between_its_halves`).
pub(crate) struct Cut {
    /// Points that span the half below the middle of the longest side of the box around the points.
    pub low: Vec<Point>,
    /// Points that span the half above it.
    pub high: Vec<Point>,
}

/// Distance from the outline of a cut above which outer points are kept, in metres: rounding excluded them from the outline.
/// All other points off the outline are dropped.
const ROUNDING_M: f64 = 1e-9;

/// A point of the plane of a cut.
type PlanePoint = [f64; 2];

impl Cut {
    /// Cuts the hull of `corners` across the longest side of the box around them; `None` if that side is too short.
    ///
    /// The plane meets the hull in the hull of its intersections with all segments from a corner below to one above, so no
    /// faces are needed, which are hard to determine where a hull is thin. If rounding moves an intersection along its segment,
    /// nothing is lost, because both halves get the same point.
    pub fn across(corners: &[Point]) -> Option<Self> {
        /// Minimum length of the longest side, in metres: protrusions of smaller pieces are negligible.
        const SHORTEST_M: f64 = 1e-4;
        let (axis, low, high) = longest_side(corners);
        if high - low < SHORTEST_M {
            return None;
        }
        let middle = 0.5 * (low + high);
        let height = |point: &Point| point[axis] - middle;
        let (above, below): (Vec<Point>, Vec<Point>) = corners.iter().partition(|point| height(point) > 0.0);
        let mut rim = Vec::new();
        for a in below.iter().filter(|point| height(point) < 0.0) {
            for b in &above {
                let mut crossing = a + (b - a) * (height(a) / (height(a) - height(b)));
                crossing[axis] = middle;
                rim.push(crossing);
            }
        }
        let on_plane = below.iter().filter(|point| height(point) >= 0.0);
        rim.extend(on_plane);
        let rim = outermost(&rim, axis);
        let with_rim = |half: Vec<Point>| [half, rim.clone()].concat();
        let strictly_below = below.into_iter().filter(|point| height(point) < 0.0).collect();
        Some(Self { low: with_rim(strictly_below), high: with_rim(above) })
    }
}

/// Axis along which the points extend farthest, with their least and greatest coordinate along it.
pub(crate) fn longest_side(points: &[Point]) -> (usize, f64, f64) {
    let side = |axis: usize| {
        let range = |(low, high): (f64, f64), p: &Point| (low.min(p[axis]), high.max(p[axis]));
        let (low, high) = points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), range);
        (axis, low, high)
    };
    let longer = |a: (usize, f64, f64), b: (usize, f64, f64)| if b.2 - b.1 > a.2 - a.1 { b } else { a };
    longer(longer(side(0), side(1)), side(2))
}

/// Points in a plane across `axis` that are needed for their convex hull: its corners, and all points outside it.
fn outermost(points: &[Point], axis: usize) -> Vec<Point> {
    let flat = |point: &Point| [point[(axis + 1) % 3], point[(axis + 2) % 3]];
    let mut sorted: Vec<(PlanePoint, &Point)> = points.iter().map(|point| (flat(point), point)).collect();
    sorted.sort_by(|(a, _), (b, _)| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    sorted.dedup_by_key(|(point, _)| point.map(f64::to_bits));
    let outline = outline(&sorted.iter().map(|(point, _)| *point).collect::<Vec<_>>());
    let corners: Vec<PlanePoint> = outline.iter().map(|&corner| sorted[corner].0).collect();
    let mut is_kept = vec![false; sorted.len()];
    for &corner in &outline {
        is_kept[corner] = true;
    }
    let kept = sorted.iter().zip(is_kept).filter(|((point, _), kept)| *kept || is_outside(point, &corners));
    kept.map(|((_, point), _)| **point).collect()
}

/// Indices of the corners of the convex hull of sorted points, anticlockwise (Andrew 1979, "Another efficient algorithm
/// for convex hulls in two dimensions", whole).
fn outline(points: &[PlanePoint]) -> Vec<usize> {
    if points.len() < 3 {
        return (0..points.len()).collect();
    }
    let turn = |o: usize, a: usize, b: usize| cross(points[o], points[a], points[b]);
    let mut corners: Vec<usize> = Vec::new();
    let half = |corners: &mut Vec<usize>, order: &mut dyn Iterator<Item = usize>| {
        let first = corners.len();
        for point in order {
            while corners.len() > first + 1
                && turn(corners[corners.len() - 2], corners[corners.len() - 1], point) <= 0.0
            {
                corners.pop();
            }
            corners.push(point);
        }
        // The other half begins with this corner.
        corners.pop();
    };
    half(&mut corners, &mut (0..points.len()));
    half(&mut corners, &mut (0..points.len()).rev());
    corners
}

/// Returns true if a point lies outside a polygon, given anticlockwise, by more than [`ROUNDING_M`].
fn is_outside(point: &PlanePoint, corners: &[PlanePoint]) -> bool {
    corners.iter().enumerate().any(|(index, a)| {
        let b = &corners[(index + 1) % corners.len()];
        let length = libm::hypot(b[0] - a[0], b[1] - a[1]);
        cross(*a, *b, *point) < -ROUNDING_M * length
    })
}

/// Twice the area of a triangle, positive if it is anticlockwise.
fn cross(o: PlanePoint, a: PlanePoint, b: PlanePoint) -> f64 {
    (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])
}

#[cfg(test)]
mod tests {
    use cranny_spatial::Pose;
    use proptest::prelude::*;

    use super::*;
    use crate::{Solid, separation};

    proptest! {
        #[test]
        fn no_point_of_a_hull_is_lost_between_its_halves(
            corners in proptest::collection::vec(proptest::array::uniform3(-1.0..1.0_f64), 5..20),
            shares in proptest::collection::vec(0.0..1.0_f64, 20),
        ) {
            let corners: Vec<Point> = corners.into_iter().map(Point::from).collect();
            let sum: f64 = shares.iter().zip(&corners).map(|(share, _)| share).sum();
            prop_assume!(sum > 1e-3);
            let weighted = shares.iter().zip(&corners).map(|(share, corner)| corner.coords * (share / sum));
            let inside = Pose::from_parts(weighted.sum::<cranny_spatial::Vector>().into(), Pose::identity().rotation);
            let Some(cut) = Cut::across(&corners) else { return Ok(()) };
            let halves = [Solid::hull(&cut.low), Solid::hull(&cut.high)];
            prop_assume!(halves.iter().all(Result::is_ok));
            let speck = Solid::sphere(1e-12).expect("a positive radius");
            let distance = |half: &Solid| separation(&speck, &inside, half, &Pose::identity(), f64::MAX).lower_m;
            let least_m = halves.iter().flatten().map(distance).fold(f64::INFINITY, f64::min);
            prop_assert!(least_m < 1e-7, "{} m", least_m);
        }
    }
}
