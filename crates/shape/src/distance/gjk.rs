//! Distance of two convex cores by the algorithm of Gilbert, Johnson & Keerthi (1988, "A fast procedure for computing the
//! distance between complex objects in three-dimensional space", whole), with certified bounds: errors of the search make no
//! bound wrong by more than rounding.

use parry3d_f64::math::{Pose as ParryPose, Vector as ParryVector};
use parry3d_f64::shape::SupportMap;

use crate::Range;
use crate::distance::convex::Core;

/// Bounds of the distance of two cores: `lower_m ≤ distance ≤ upper_m`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CoreDistance {
    /// Lower bound from a plane between the two, in metres; 0 if there is none.
    pub lower_m: f64,
    /// Upper bound, the distance between a point of each core, in metres; infinite if the search ended before it found
    /// two such points.
    pub upper_m: f64,
    /// Those two points, on the first core and on the second, in the frame of the first.
    pub way: [ParryVector; 2],
}

impl CoreDistance {
    const CONTACT: Self = Self { lower_m: 0.0, upper_m: 0.0, way: [ParryVector::ZERO; 2] };
}

/// Maximum number of iterations. Polytopes take some ten; two nearly tangent curved rims take the most, some fifty.
const MOST_STEPS: usize = 200;

/// Difference of the bounds at which the search ends, in metres: a tenth of the allowance of proofs for rounding
/// ([`cranny_spatial::ROUNDING_M`]).
const ENOUGH_M: f64 = 1e-10;

/// Bounds of the distance of `a` and `b`, as exact as `range` requires.
pub(crate) fn core_distance(a: &Core, b: &Core, a_from_b: &ParryPose, range: Range) -> CoreDistance {
    let Range { beyond_m, exact_below_m } = range;
    search(a, b, a_from_b, ENOUGH_M, |lower_m, upper_m| {
        lower_m >= beyond_m || (upper_m < beyond_m && lower_m >= exact_below_m)
    })
}

/// Bounds of the distance of `a` and `b`, as exact as rounding permits, unless they show that it exceeds `beyond_m`. On curved
/// faces the direction between the two points errs by the root of the difference of the bounds.
pub(crate) fn core_points(a: &Core, b: &Core, a_from_b: &ParryPose, beyond_m: f64) -> CoreDistance {
    search(a, b, a_from_b, 0.0, |lower_m, _| lower_m >= beyond_m)
}

/// Returns true if the distance of `a` and `b` is certified to reach `distance_m` (m). Agrees with [`core_distance`], but
/// the search ends as soon as the answer is known.
pub(crate) fn core_reaches(a: &Core, b: &Core, a_from_b: &ParryPose, distance_m: f64) -> bool {
    let is_decided = |lower_m: f64, upper_m: f64| lower_m >= distance_m || upper_m < distance_m;
    search(a, b, a_from_b, ENOUGH_M, is_decided).lower_m >= distance_m
}

/// Bounds of the distance of `a` and `b`. The search ends when they differ by no more than `enough_m`, or `is_decided` accepts
/// them.
///
/// Searches the set of differences `b − a` for the point closest to the origin. The set contains the origin exactly if
/// the two cores meet.
///
/// 1. From the closest point known, takes the difference that lies farthest towards the origin. If the height of the
///    plane through it is positive, the plane separates the two: a lower bound.
/// 2. That difference and those that span the closest point are the corners of a simplex. Its point closest to the origin
///    is the next closest point, whose distance is an upper bound.
fn search(
    a: &Core,
    b: &Core,
    a_from_b: &ParryPose,
    enough_m: f64,
    is_decided: impl Fn(f64, f64) -> bool,
) -> CoreDistance {
    let b_from_a = a_from_b.rotation.inverse();
    let lowest_difference = |direction: ParryVector| {
        let on_a = a.local_support_point(direction);
        let on_b = b.local_support_point(b_from_a * -direction);
        Corner { difference: a_from_b.rotation * on_b + a_from_b.translation - on_a, on_a }
    };
    let mut found = CoreDistance { upper_m: f64::INFINITY, ..CoreDistance::CONTACT };
    let mut simplex = Simplex { corners: [Corner::default(); 4], len: 0 };
    // A guess, which need not be a point of the set.
    let mut closest = a_from_b.translation.try_normalize().unwrap_or(ParryVector::X);
    for _ in 0..MOST_STEPS {
        // 1.
        let Some(direction) = closest.try_normalize() else { return CoreDistance::CONTACT };
        let corner = lowest_difference(direction);
        found.lower_m = found.lower_m.max(direction.dot(corner.difference));
        let is_settled = found.upper_m - found.lower_m <= enough_m;
        if is_settled || is_decided(found.lower_m, found.upper_m) || simplex.has(corner) {
            break;
        }
        // 2.
        simplex.add(corner);
        let Some(next) = simplex.reduce() else { return CoreDistance::CONTACT };
        let length = next.difference.length();
        // If an iteration comes no closer, it and all later ones are only rounding.
        if length.is_nan() || length >= found.upper_m {
            break;
        }
        found.upper_m = length;
        found.way = [next.on_a, next.on_a + next.difference];
        if is_decided(found.lower_m, found.upper_m) {
            break;
        }
        closest = next.difference;
    }
    found
}

/// Difference of a point of each core, with the point of the first core.
#[derive(Clone, Copy, Debug, Default)]
struct Corner {
    difference: ParryVector,
    on_a: ParryVector,
}

/// Corners of which the closest point known is a convex combination.
struct Simplex {
    corners: [Corner; 4],
    len: usize,
}

impl Simplex {
    fn has(&self, corner: Corner) -> bool {
        self.corners[..self.len].iter().any(|known| known.difference == corner.difference)
    }

    fn add(&mut self, corner: Corner) {
        self.corners[self.len] = corner;
        self.len += 1;
    }

    /// Keeps the face that contains the point closest to the origin, and returns that point. Its weights are not
    /// negative, so it is a point of the simplex in any case. `None` if the origin lies in a tetrahedron.
    ///
    /// Evaluates all faces with the newest corner and takes the best, so that a wrong decision at one face does no harm.
    fn reduce(&mut self) -> Option<Corner> {
        if self.len == 4 && self.has_origin() {
            return None;
        }
        let newest = self.len - 1;
        let mut best = self.face([newest, 0, 0], 1, [1.0, 0.0, 0.0]);
        let mut improve = |face: Option<Face>| {
            if let Some(face) = face.filter(|face| face.distance_squared < best.distance_squared) {
                best = face;
            }
        };
        for first in 0..newest {
            improve(self.on_edge(newest, first));
            for second in first + 1..newest {
                improve(self.on_triangle(newest, first, second));
            }
        }
        let kept = best.corners.map(|corner| self.corners[corner]);
        self.corners[..best.len].copy_from_slice(&kept[..best.len]);
        self.len = best.len;
        Some(best.point)
    }

    fn difference(&self, corner: usize) -> ParryVector {
        self.corners[corner].difference
    }

    /// Point of a face with these weights; corners beyond `len` have none.
    fn face(&self, corners: [usize; 3], len: usize, weights: [f64; 3]) -> Face {
        let [a, b, c] = corners.map(|corner| self.corners[corner]);
        let mix = |[a, b, c]: [ParryVector; 3]| a * weights[0] + b * weights[1] + c * weights[2];
        let difference = mix([a.difference, b.difference, c.difference]);
        let point = Corner { difference, on_a: mix([a.on_a, b.on_a, c.on_a]) };
        Face { corners, len, point, distance_squared: difference.length_squared() }
    }

    /// Projection of the origin onto an edge, if it lies between its ends.
    fn on_edge(&self, first: usize, second: usize) -> Option<Face> {
        let (a, b) = (self.difference(first), self.difference(second));
        let along = b - a;
        let place = -a.dot(along) / along.length_squared();
        (place > 0.0 && place < 1.0).then(|| self.face([first, second, 0], 2, [1.0 - place, place, 0.0]))
    }

    /// Projection of the origin onto a triangle, if it lies within.
    fn on_triangle(&self, first: usize, second: usize, third: usize) -> Option<Face> {
        /// Sine of the narrowest angle. In a narrower triangle the projection would be rounding; its edges are as good.
        const NARROWEST: f64 = 1e-9;
        let corners = [first, second, third];
        let [a, b, c] = corners.map(|corner| self.difference(corner));
        let (ab, ac) = (b - a, c - a);
        let normal = ab.cross(ac);
        let sides_squared = ab.length_squared() * ac.length_squared();
        if normal.length_squared() <= NARROWEST * NARROWEST * sides_squared {
            return None;
        }
        // Areas of the triangles that the projection forms with each side.
        let areas = [b.cross(c).dot(normal), c.cross(a).dot(normal), a.cross(b).dot(normal)];
        let sum = areas[0] + areas[1] + areas[2];
        areas.iter().all(|area| *area > 0.0).then(|| self.face(corners, 3, areas.map(|area| area / sum)))
    }

    /// Returns true if the origin lies in the tetrahedron by more than rounding.
    fn has_origin(&self) -> bool {
        /// Rounding of a volume, relative to the product of its lengths: some ten times 10⁻¹⁶.
        const ROUNDING: f64 = 1e-14;
        let [a, b, c, d] = self.corners.map(|corner| corner.difference);
        let volume = |p: ParryVector, q: ParryVector, r: ParryVector| {
            let volume = p.dot(q.cross(r));
            let is_certain = volume.abs() > ROUNDING * p.length() * q.length() * r.length();
            if is_certain { volume } else { 0.0 }
        };
        // The origin replaces each corner in turn. It lies inside if all four tetrahedra have the same orientation.
        let signs = [volume(b, c, d), -volume(a, c, d), volume(a, b, d), -volume(a, b, c)];
        signs.iter().all(|sign| *sign > 0.0) || signs.iter().all(|sign| *sign < 0.0)
    }
}

/// A face of a simplex and its point closest to the origin.
struct Face {
    corners: [usize; 3],
    len: usize,
    point: Corner,
    distance_squared: f64,
}
