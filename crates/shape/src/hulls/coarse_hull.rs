use std::collections::BinaryHeap;

use cranny_spatial::{Point, Pose};

use crate::distance::convex::Core;
use crate::solid::Kind;
use crate::{Separation, Solid, separation};

/// Convex solid with few corners: their convex hull, rounded by `radius_m`, lies in the solid, and the solid protrudes
/// from it by at most `bulge_m`.
#[derive(Clone, Debug, PartialEq)]
pub struct CoarseHull {
    /// Corners in the solid's frame, at least one.
    pub corners: Vec<Point>,
    /// Rounding radius, in metres.
    pub radius_m: f64,
    /// Bound on how far the solid protrudes from the rounded hull, in metres.
    pub bulge_m: f64,
}

impl CoarseHull {
    /// Coarse hull of a convex solid with at most `most` corners, chosen greedily: always the corner that protrudes farthest.
    /// `None` for a mesh, a half-space, or a hull so small or flat that its corners cannot be distinguished.
    ///
    /// # Panics
    /// If `most` is less than 32, the number of corners of the prism in a cylinder.
    pub fn of(solid: &Solid, most: usize) -> Option<Self> {
        assert!(most >= 2 * SIDES, "at least {} corners", 2 * SIDES);
        let Kind::Convex(convex) = solid.kind() else { return None };
        let radius_m = convex.radius_m;
        match &convex.core {
            Core::Cylinder { half_length, radius } => {
                let turn = std::f64::consts::TAU / SIDES as f64;
                let corners = (0..SIDES).flat_map(|side| {
                    let (sin, cos) = cranny_spatial::sin_cos(turn * side as f64);
                    [-1.0, 1.0].map(|end| Point::new(radius * cos, radius * sin, end * half_length))
                });
                let bulge_m = radius * (1.0 - libm::cos(0.5 * turn)) + ROUNDING_M;
                Some(Self { corners: corners.collect(), radius_m, bulge_m })
            }
            Core::Hull(points) => {
                let (corners, bulge_m) = chosen(&points.iter().collect::<Vec<_>>(), most)?;
                Some(Self { corners, radius_m, bulge_m })
            }
            // The bounding points of these are their corners, which lie in the solid.
            Core::Point | Core::Segment { .. } | Core::Cuboid { .. } | Core::Triangle(_) => {
                Some(Self { corners: convex.bounding_points(), radius_m, bulge_m: 0.0 })
            }
        }
    }
}

/// Sides of the prism that approximates a cylinder.
const SIDES: usize = 16;

/// Bound on the displacement of a corner by rounding, in metres.
const ROUNDING_M: f64 = 1e-9;

/// Chooses some corners of a hull, and returns the maximum protrusion of the others from the hull of these, in metres.
pub(crate) fn chosen(corners: &[Point], most: usize) -> Option<(Vec<Point>, f64)> {
    if corners.len() <= most {
        return Some((corners.to_vec(), 0.0));
    }
    // A corner that has not been measured yet counts as infinitely far.
    let mut left: Vec<(f64, Point)> = corners.iter().map(|corner| (f64::INFINITY, *corner)).collect();
    let mut chosen = Vec::with_capacity(most);
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let along = |(_, corner): &(f64, Point)| side * corner[axis];
            let farthest = (0..left.len()).max_by(|&a, &b| along(&left[a]).total_cmp(&along(&left[b])))?;
            chosen.push(left.swap_remove(farthest).1);
        }
    }
    let mut hull = Solid::hull(&chosen).ok()?;
    // Added corners only reduce the protrusion of the others, so only the corner that protruded farthest at its last
    // measurement is measured again. Ties go to the last corner. Outdated queue entries, of corners that were measured again or
    // moved, are skipped.
    let mut queue: BinaryHeap<(i64, usize)> =
        left.iter().enumerate().map(|(index, (far_m, _))| (rank(*far_m), index)).collect();
    let mut measured = vec![0; left.len()];
    loop {
        let (far, farthest) = queue.pop()?;
        if left.get(farthest).is_none_or(|(known_m, _)| far != rank(*known_m)) {
            continue;
        }
        if measured[farthest] < chosen.len() {
            left[farthest].0 = standing_out_m(&left[farthest].1, &hull)?;
            measured[farthest] = chosen.len();
            queue.push((rank(left[farthest].0), farthest));
            continue;
        }
        if chosen.len() == most {
            return Some((chosen, left[farthest].0));
        }
        chosen.push(left.swap_remove(farthest).1);
        measured.swap_remove(farthest);
        if let Some((moved_m, _)) = left.get(farthest) {
            queue.push((rank(*moved_m), farthest));
        }
        hull = Solid::hull(&chosen).ok()?;
    }
}

/// Integer with the order of [`f64::total_cmp`].
fn rank(distance_m: f64) -> i64 {
    let bits = distance_m.to_bits().cast_signed();
    bits ^ ((bits >> 63).cast_unsigned() >> 1).cast_signed()
}

/// Upper bound of the distance of a point from a hull, in metres; never less than the true distance.
fn standing_out_m(point: &Point, hull: &Solid) -> Option<f64> {
    /// Radius of the ball that represents the point, in metres.
    const SPECK_M: f64 = 1e-7;
    let speck = Solid::sphere(SPECK_M).ok()?;
    let place = Pose::from_parts(point.coords.into(), cranny_spatial::Rotation::identity());
    let Separation { upper_m, .. } = separation(&speck, &place, hull, &Pose::identity(), f64::MAX);
    (upper_m + SPECK_M).is_finite().then_some(upper_m + SPECK_M)
}

#[cfg(test)]
mod tests {
    use cranny_spatial::{Stream, Vector};
    use proptest::prelude::*;

    use super::*;

    /// Reference for [`chosen`] that scans all corners for each choice.
    fn chosen_one_by_one(corners: &[Point], most: usize) -> (Vec<Point>, f64) {
        let mut left: Vec<(f64, Point)> = corners.iter().map(|corner| (f64::INFINITY, *corner)).collect();
        let mut chosen = Vec::new();
        for axis in 0..3 {
            for side in [-1.0, 1.0] {
                let along = |(_, corner): &(f64, Point)| side * corner[axis];
                let farthest = (0..left.len()).max_by(|&a, &b| along(&left[a]).total_cmp(&along(&left[b])));
                chosen.push(left.swap_remove(farthest.unwrap()).1);
            }
        }
        loop {
            let hull = Solid::hull(&chosen).unwrap();
            let mut fresh = vec![false; left.len()];
            let farthest = loop {
                let farthest = (0..left.len()).max_by(|&a, &b| left[a].0.total_cmp(&left[b].0)).unwrap();
                if fresh[farthest] {
                    break farthest;
                }
                left[farthest].0 = standing_out_m(&left[farthest].1, &hull).unwrap();
                fresh[farthest] = true;
            };
            if chosen.len() == most {
                return (chosen, left[farthest].0);
            }
            chosen.push(left.swap_remove(farthest).1);
        }
    }

    #[test]
    fn of_many_corners_the_same_are_chosen_whether_one_looks_at_all_or_at_the_next() {
        let mut random = Stream::new(5, 0);
        let scattered = (0..300).map(|_| Point::from(random.rotation() * Vector::x() * 0.1)).collect();
        // Many corners are equally far.
        let grid =
            (0..343).map(|k| Point::new(f64::from(k % 7), f64::from(k / 7 % 7), f64::from(k / 49))).collect();
        let prism = (0..96).map(|k| {
            let (sin, cos) = cranny_spatial::sin_cos(f64::from(k / 2) * std::f64::consts::TAU / 48.0);
            Point::new(cos, sin, f64::from(k % 2))
        });
        for corners in [scattered, grid, prism.collect::<Vec<Point>>()] {
            assert_eq!(chosen(&corners, 40).unwrap(), chosen_one_by_one(&corners, 40));
        }
    }
    proptest! {
        #[test]
        fn a_coarse_hull_lies_in_the_solid_and_the_solid_not_far_out_of_it(seed in any::<u64>()) {
            let mut random = Stream::new(seed, 0);
            let mut draw = |low: f64, high: f64| random.uniform_between(low, high);
            let size = Vector::new(draw(0.01, 0.3), draw(0.01, 0.3), draw(0.01, 0.3));
            let points: Vec<Point> = (0..120)
                .map(|_| {
                    let direction = Vector::new(draw(-1.0, 1.0), draw(-1.0, 1.0), draw(-1.0, 1.0));
                    Point::from(direction.normalize().component_mul(&size))
                })
                .collect();
            let solids = [
                Solid::hull(&points),
                Solid::cylinder(draw(0.01, 0.3), draw(0.01, 0.3)),
                Solid::cuboid(size),
                Solid::capsule(draw(0.01, 0.3), draw(0.01, 0.3)),
                Solid::sphere(draw(0.01, 0.3)),
            ];
            for solid in solids {
                let solid = solid.expect("positive sizes");
                let coarse = CoarseHull::of(&solid, 32).expect("a convex solid");
                prop_assert!(coarse.corners.len() <= 32);
                for _ in 0..100 {
                    let direction = Vector::new(draw(-1.0, 1.0), draw(-1.0, 1.0), draw(-1.0, 1.0)).normalize();
                    let reach = solid.support_point(&direction).expect("a convex solid").coords.dot(&direction);
                    let corners = coarse.corners.iter().map(|corner| corner.coords.dot(&direction));
                    let own = corners.fold(f64::MIN, f64::max) + coarse.radius_m;
                    prop_assert!(own <= reach + 1e-9, "{own} beyond {reach}");
                    prop_assert!(reach <= own + coarse.bulge_m + 1e-9, "{reach} beyond {own} by more than the bulge");
                }
            }
        }
    }
}
