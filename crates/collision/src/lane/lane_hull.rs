use cranny_shape::{CoarseHull, Solid};
use cranny_spatial::{LANES, LaneArray, Pose};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};

use crate::lane::lane_bits::bits;
use crate::lane::lane_solid::LaneSolid;
use crate::lane::lane_vector::{dot, lanes, minus, narrow};
use crate::lane::single_frame::{Bars, SingleFrame, Verdict};

/// Coarse hull of a convex solid, in the frame of a link or the planning frame; its corners are compared in lanes.
#[derive(Clone, Debug)]
pub(crate) struct LaneHull {
    /// Corners, coordinate by coordinate; the last chunk is filled with the first corner. Empty for a box of a union.
    chunks: Vec<[LaneArray; 3]>,
    /// The solid, if it is a box: its farthest corner needs no search.
    pub cuboid: Option<LaneSolid>,
    /// Radius by which the hull of the corners is rounded, in metres.
    radius: f32,
    /// Maximum distance by which the solid protrudes from that rounded hull, in metres.
    bulge: f32,
}

/// Maximum number of corners. With a quarter of them, more is left to the exact check and a verdict takes a fifth longer; more
/// corners bring no gain.
const MOST_CORNERS: usize = 4 * LANES;

/// Maximum number of iterations of a distance search; few searches take more than five.
const MOST_STEPS: usize = 10;

/// Rounding of a face's distance from the origin, relative to the distance of its corners. A normal is the cross product of two
/// sides, each off by u = 6·10⁻⁸ of its corners: about 6 u with the rounding of the product, in a triangle whose sides span an
/// angle of at least [`NARROWEST`].
const PLANE_ROUNDING: f32 = 6.0 * f32::EPSILON / NARROWEST;

/// Sine of the least angle of a usable triangle: in a narrower one, rounding would turn the normal by more than
/// [`PLANE_ROUNDING`] allows for.
const NARROWEST: f32 = 0.02;

type Vec3 = [f32; 3];

impl LaneHull {
    /// Returns the coarse hull of a solid; `None` if the solid has none.
    pub fn coarse(solid: &Solid) -> Option<CoarseHull> {
        CoarseHull::of(solid, MOST_CORNERS)
    }

    /// Creates the coarse hull of a solid at this pose.
    pub fn of(frame_from_solid: &Pose, solid: &Solid, coarse: &CoarseHull) -> Self {
        let CoarseHull { corners, radius_m, bulge_m } = coarse;
        let corners: Vec<Vec3> =
            corners.iter().map(|corner| lanes(&(frame_from_solid * corner).coords)).collect();
        let chunk = |chunk: &[Vec3]| -> [LaneArray; 3] {
            let corner = |lane: usize| chunk.get(lane).copied().unwrap_or(corners[0]);
            std::array::from_fn(|axis| std::array::from_fn(|lane| corner(lane)[axis]))
        };
        Self {
            chunks: corners.chunks(LANES).map(chunk).collect(),
            cuboid: solid.as_cuboid().map(|_| LaneSolid::of(frame_from_solid, solid)),
            radius: narrow(*radius_m),
            bulge: narrow(*bulge_m),
        }
    }

    /// Creates the hull of a box along the axes of its frame, by its centre and half extents (m), rounded by a radius (m).
    pub fn of_box(narrow_box: [Vec3; 2], radius: f32) -> Self {
        Self { chunks: Vec::new(), cuboid: Some(LaneSolid::straight_box(narrow_box)), radius, bulge: 0.0 }
    }

    /// Returns the maximum distance between the hull and the solid, in metres.
    pub fn bulge_m(&self) -> f64 {
        f64::from(self.bulge)
    }

    /// Returns lower and upper bounds of the least coordinate of the solid at `frame` along a unit vector, in metres.
    #[inline(always)]
    pub fn least_along<S: Simd>(&self, simd: S, frame: &SingleFrame, direction: Vec3) -> [f32; 2] {
        let corner = self.farthest(simd, frame, direction.map(|d| -d));
        let least = dot(corner, direction) - self.radius;
        [least - self.bulge, least]
    }

    /// Returns the corner farthest along a direction, both in the root frame.
    #[inline(always)]
    fn farthest<S: Simd>(&self, simd: S, frame: &SingleFrame, direction: Vec3) -> Vec3 {
        let direction = frame.turned_back(direction);
        if let Some(corner) = self.cuboid.as_ref().and_then(|cuboid| cuboid.farthest_corner(direction)) {
            return frame.point(corner);
        }
        let [dx, dy, dz] = direction.map(|d| f32x16::splat(simd, d));
        let reach = |[x, y, z]: &[LaneArray; 3]| {
            f32x16::from_slice(simd, x) * dx
                + f32x16::from_slice(simd, y) * dy
                + f32x16::from_slice(simd, z) * dz
        };
        let [first, others @ ..] = &self.chunks[..] else { return frame.point([0.0; 3]) };
        let mut best = reach(first);
        let mut chunks = i32x16::splat(simd, 0);
        let mut number = 0;
        for chunk in others {
            number += 1;
            let reach = reach(chunk);
            let is_farther = reach.simd_gt(best);
            best = is_farther.select(reach, best);
            chunks = is_farther.select(i32x16::splat(simd, number), chunks);
        }
        let mut numbers = [0; LANES];
        chunks.store_slice(&mut numbers);
        let is_best = bits(best.simd_ge(f32x16::splat(simd, best.reduce_max())));
        let lane = is_best.trailing_zeros() as usize % LANES;
        let [x, y, z] = usize::try_from(numbers[lane]).map_or(first, |chunk| &self.chunks[chunk]);
        frame.point([x[lane], y[lane], z[lane]])
    }

    /// Compares two hulls, each in its own frame, by the algorithm of Gilbert, Johnson & Keerthi (1988, whole; in the form of
    /// Ericson 2005, §9.5); `apart` is a guess of the shortest vector from the second to the first.
    ///
    /// No verdict depends on the convergence of the search: "free" follows from a plane between the two solids, "contact" from
    /// points of both, or from a tetrahedron of their differences that contains the origin at a depth above its rounding.
    #[inline(never)]
    pub fn against<S: Simd>(
        &self,
        simd: S,
        frame: &SingleFrame,
        other: &Self,
        other_frame: &SingleFrame,
        apart: Vec3,
        bars: Bars,
    ) -> Verdict {
        simd.vectorize(
            #[inline(always)]
            || {
                let rounding = self.radius + other.radius;
                let outer = rounding + self.bulge + other.bulge;
                let mut closest = apart;
                let mut simplex = Simplex { points: [[0.0; 3]; 4], len: 0 };
                for _ in 0..MOST_STEPS {
                    let corner = self.farthest(simd, frame, closest.map(|x| -x));
                    let difference = minus(corner, other.farthest(simd, other_frame, closest));
                    let length = dot(closest, closest).sqrt();
                    let gap = dot(closest, difference) / length;
                    if gap - outer >= bars.free_m {
                        return Verdict::Free;
                    }
                    // The first direction is a guess, not a point of the Minkowski difference.
                    if simplex.len > 0 {
                        if length - rounding < bars.contact_m {
                            return Verdict::Contact;
                        }
                        /// Progress below this, relative to the distance, is rounding.
                        const STALLED: f32 = 1e-4;
                        let is_moving = length - gap > STALLED * length;
                        if !is_moving {
                            return Verdict::Doubt;
                        }
                    }
                    simplex.points[simplex.len] = difference;
                    simplex.len += 1;
                    let Some(point) = simplex.reduce() else {
                        let needed = (-bars.contact_m).max(0.0) + PLANE_ROUNDING * simplex.farthest();
                        return if simplex.depth() > needed { Verdict::Contact } else { Verdict::Doubt };
                    };
                    closest = point;
                }
                Verdict::Doubt
            },
        )
    }
}

/// Simplex of up to four points.
struct Simplex {
    points: [Vec3; 4],
    len: usize,
}

impl Simplex {
    /// Reduces the simplex to the feature closest to the origin, and returns its closest point; `None` if the origin lies in a
    /// tetrahedron (Ericson 2005, §5.1 and §9.5).
    #[inline(always)]
    fn reduce(&mut self) -> Option<Vec3> {
        match self.len {
            1 => Some(self.points[0]),
            2 => Some(self.closest_on_segment()),
            3 => Some(self.closest_on_triangle()),
            _ => self.closest_on_tetrahedron(),
        }
    }

    fn keep<const N: usize>(&mut self, points: [Vec3; N]) {
        self.points[..N].copy_from_slice(&points);
        self.len = N;
    }

    #[inline(always)]
    fn closest_on_segment(&mut self) -> Vec3 {
        let [a, b, ..] = self.points;
        let along = minus(b, a);
        let place = -dot(a, along);
        let length_squared = dot(along, along);
        if place <= 0.0 {
            self.keep([a]);
            return a;
        }
        if place >= length_squared {
            self.keep([b]);
            return b;
        }
        plus(a, scaled(along, place / length_squared))
    }

    #[inline(always)]
    fn closest_on_triangle(&mut self) -> Vec3 {
        let [a, b, c, _] = self.points;
        let (ab, ac) = (minus(b, a), minus(c, a));
        let (d1, d2) = (-dot(ab, a), -dot(ac, a));
        if d1 <= 0.0 && d2 <= 0.0 {
            self.keep([a]);
            return a;
        }
        let (d3, d4) = (-dot(ab, b), -dot(ac, b));
        if d3 >= 0.0 && d4 <= d3 {
            self.keep([b]);
            return b;
        }
        let beyond_ab = d1 * d4 - d3 * d2;
        if beyond_ab <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
            self.keep([a, b]);
            return plus(a, scaled(ab, d1 / (d1 - d3)));
        }
        let (d5, d6) = (-dot(ab, c), -dot(ac, c));
        if d6 >= 0.0 && d5 <= d6 {
            self.keep([c]);
            return c;
        }
        let beyond_ac = d5 * d2 - d1 * d6;
        if beyond_ac <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
            self.keep([a, c]);
            return plus(a, scaled(ac, d2 / (d2 - d6)));
        }
        let beyond_bc = d3 * d6 - d5 * d4;
        if beyond_bc <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
            self.keep([b, c]);
            return plus(b, scaled(minus(c, b), (d4 - d3) / ((d4 - d3) + (d5 - d6))));
        }
        // Clamped weights keep the point on the triangle despite rounding.
        let [at_a, at_b, at_c] = [beyond_bc, beyond_ac, beyond_ab].map(|weight| weight.max(0.0));
        let sum = at_a + at_b + at_c;
        plus(a, plus(scaled(ab, at_b / sum), scaled(ac, at_c / sum)))
    }

    fn closest_on_tetrahedron(&mut self) -> Option<Vec3> {
        let points = self.points;
        let mut best: Option<(f32, Self, Vec3)> = None;
        // The origin cannot lie beyond the first face, because the search came from there.
        for [a, b, c, d] in FACES[1..].iter().copied() {
            let [a, b, c, d] = [points[a], points[b], points[c], points[d]];
            let normal = cross(minus(b, a), minus(c, a));
            let (own, opposite) = (-dot(normal, a), dot(normal, minus(d, a)));
            if own * opposite >= 0.0 {
                continue;
            }
            let mut face = Self { points: [a, b, c, d], len: 3 };
            let point = face.closest_on_triangle();
            let distance = dot(point, point);
            if best.as_ref().is_none_or(|(least, ..)| distance < *least) {
                best = Some((distance, face, point));
            }
        }
        let (_, face, point) = best?;
        *self = face;
        Some(point)
    }

    /// Returns the distance of the farthest corner from the origin, in metres.
    fn farthest(&self) -> f32 {
        self.points.iter().map(|point| dot(*point, *point)).fold(0.0, f32::max).sqrt()
    }

    /// Returns the depth of the origin below all faces of the tetrahedron, in metres; at most 0 if it lies outside.
    fn depth(&self) -> f32 {
        let mut least = f32::INFINITY;
        for face in FACES {
            let [a, b, c, d] = face.map(|corner| self.points[corner]);
            let (ab, ac) = (minus(b, a), minus(c, a));
            let normal = cross(ab, ac);
            let area = dot(normal, normal).sqrt();
            let is_wide = area > NARROWEST * (dot(ab, ab) * dot(ac, ac)).sqrt();
            if !is_wide {
                return 0.0;
            }
            let (height, origin) = (dot(normal, minus(d, a)) / area, -dot(normal, a) / area);
            least = least.min(0.5 * height.abs()).min(origin * height.signum());
        }
        least
    }
}

/// Faces of a tetrahedron, each followed by the opposite corner.
const FACES: [[usize; 4]; 4] = [[0, 1, 2, 3], [0, 1, 3, 2], [0, 2, 3, 1], [1, 2, 3, 0]];

#[inline(always)]
fn plus(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
fn scaled(a: Vec3, factor: f32) -> Vec3 {
    a.map(|x| x * factor)
}

#[inline(always)]
fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use cranny_shape::separation;
    use cranny_spatial::{Point, Stream, Vector, simd_level};
    use fearless_simd::dispatch;
    use proptest::prelude::*;

    use super::*;

    fn random_hull(random: &mut Stream, corners: usize) -> Solid {
        let mut draw = || random.uniform_between(-0.2, 0.2);
        let points: Vec<Point> = (0..corners).map(|_| Point::new(draw(), draw(), draw())).collect();
        Solid::hull(&points).expect("points in general position")
    }

    proptest! {
        /// Compares the verdicts, from deep contact to far apart, with `f64` distances of another algorithm.
        #[test]
        fn what_hulls_are_certain_of_is_true(seed in any::<u64>(), corners in 4_usize..80, margin_m in prop_oneof![Just(0.0), 0.0..0.05]) {
            /// Allowance of the lanes for rounding in this test, in metres.
            const SLACK_M: f32 = 2e-6;
            let mut random = Stream::new(seed, 0);
            let solids = [random_hull(&mut random, corners), random_hull(&mut random, corners)];
            for _ in 0..50 {
                let mut draw = |range: f64| random.uniform_between(-range, range);
                let poses: [Pose; 2] = std::array::from_fn(|_| {
                    Pose::new(Vector::new(draw(0.3), draw(0.3), draw(0.3)), Vector::new(draw(3.0), draw(3.0), draw(3.0)))
                });
                let [a, b] = [0, 1].map(|i| LaneHull::of(&poses[i], &solids[i], &LaneHull::coarse(&solids[i]).expect("a hull")));
                let truth = separation(&solids[0], &poses[0], &solids[1], &poses[1], f64::MAX);
                let bars = Bars { free_m: narrow(margin_m) + SLACK_M, contact_m: narrow(margin_m) - SLACK_M };
                let apart = lanes(&(poses[0].translation.vector - poses[1].translation.vector));
                let verdict = dispatch!(simd_level(), simd => a.against(simd, &SingleFrame::ROOT, &b, &SingleFrame::ROOT, apart, bars));
                match verdict {
                    Verdict::Free => prop_assert!(truth.upper_m >= margin_m, "{truth:?}"),
                    Verdict::Contact => prop_assert!(truth.lower_m <= margin_m, "{truth:?}"),
                    Verdict::Doubt => {
                        let band_m = 0.02 + 0.1 * margin_m;
                        prop_assert!(truth.lower_m <= margin_m + band_m, "in doubt at {truth:?}");
                    }
                }
            }
        }
    }
}
