use cranny_spatial::{Point, Vector};

/// A point of a plane, in metres along its two axes.
pub(crate) type PlanePoint = [f64; 2];

/// A plane perpendicular to a direction, with two axes in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Across {
    direction: Vector,
    axes: [Vector; 2],
}

/// Projection of a triangle along a direction, anticlockwise, with the height of each corner along the direction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen {
    corners: [PlanePoint; 3],
    heights_m: [f64; 3],
}

/// Region in which a triangle of a body is above a triangle of a possible support, by the corners of a convex polygon, which
/// may degenerate to a line or a point.
#[derive(Clone, Debug, Default)]
pub(crate) struct Overlap {
    pub corners: Vec<OverlapCorner>,
}

/// A corner of an [`Overlap`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct OverlapCorner {
    pub at: PlanePoint,
    /// Height of the surface below, in metres.
    pub surface_m: f64,
    /// Height of the body above that surface, in metres; negative for the penetration depth.
    pub gap_m: f64,
}

/// Twice the projected area (m²) below which a triangle is seen edge-on: its boundary also belongs to other triangles.
const LEAST_AREA_M2: f64 = 1e-14;

impl Across {
    /// Creates the plane perpendicular to a unit vector.
    pub fn new(direction: &Vector) -> Self {
        let other = Vector::ith(direction.iamin(), 1.0);
        let first = direction.cross(&other).normalize();
        Self { direction: *direction, axes: [first, direction.cross(&first)] }
    }

    /// Projects a point along the direction.
    pub fn seen(&self, point: &Point) -> PlanePoint {
        self.axes.map(|axis| axis.dot(&point.coords))
    }

    /// Returns the point with this projection, at a height (m) along the direction.
    pub fn point(&self, [x, y]: PlanePoint, height_m: f64) -> Point {
        (self.axes[0] * x + self.axes[1] * y + self.direction * height_m).into()
    }

    /// Projects a triangle raised by a height (m); `None` if it is seen edge-on.
    pub fn triangle(&self, corners: &[Point; 3], raised_m: f64) -> Option<Seen> {
        let heights_m = corners.map(|corner| self.direction.dot(&corner.coords) + raised_m);
        let corners = corners.map(|corner| self.seen(&corner));
        let [a, b, c] = corners;
        let area_m2 = turn(a, b, c);
        if area_m2.abs() < LEAST_AREA_M2 {
            return None;
        }
        let seen = Seen { corners, heights_m };
        Some(if area_m2 > 0.0 { seen } else { seen.turned() })
    }
}

impl Seen {
    fn turned(self) -> Self {
        let ([a, b, c], [i, j, k]) = (self.corners, self.heights_m);
        Self { corners: [a, c, b], heights_m: [i, k, j] }
    }

    /// Returns the least and the greatest height of the corners, in metres.
    pub fn heights_m(&self) -> [f64; 2] {
        let [a, b, c] = self.heights_m;
        [a.min(b).min(c), a.max(b).max(c)]
    }

    /// Returns the bounding box in the plane.
    pub fn around(&self) -> [PlanePoint; 2] {
        let bound = |of: fn(f64, f64) -> f64| {
            [0, 1].map(|axis| {
                self.corners.map(|corner| corner[axis]).into_iter().fold(self.corners[0][axis], of)
            })
        };
        [bound(f64::min), bound(f64::max)]
    }

    /// Returns the height of the triangle's plane at a projected point, in metres.
    fn height_at(&self, point: PlanePoint) -> f64 {
        let ([a, b, c], [i, j, k]) = (self.corners, self.heights_m);
        let area = turn(a, b, c);
        let (of_b, of_c) = (turn(a, point, c) / area, turn(a, b, point) / area);
        i + of_b * (j - i) + of_c * (k - i)
    }

    /// Returns the region in which this triangle is above another one, lower than `ceiling_m`, with the gap in a range (m).
    pub fn above(&self, surface: &Self, ceiling_m: f64, gaps_m: [f64; 2]) -> Overlap {
        let corner = |index: usize| surface.corners[index % 3];
        let mut rest: Vec<[f64; 3]> =
            self.corners.iter().zip(self.heights_m).map(|(at, height_m)| [at[0], at[1], height_m]).collect();
        for index in 0..3 {
            let (from, to) = (corner(index), corner(index + 1));
            rest = clipped(&rest, |[x, y, _]| turn(from, to, [*x, *y]), mixed);
        }
        let corners = rest.into_iter().map(|[x, y, height_m]| {
            let surface_m = surface.height_at([x, y]);
            OverlapCorner { at: [x, y], surface_m, gap_m: height_m - surface_m }
        });
        let overlap = Overlap { corners: corners.collect() };
        overlap
            .part(|corner| ceiling_m - corner.surface_m)
            .part(|corner| corner.gap_m - gaps_m[0])
            .within(gaps_m[1])
    }

    /// Returns the region in which this triangle is above a plane at a height, with the gap in a range, all in metres.
    pub fn above_plane(&self, height_m: f64, gaps_m: [f64; 2]) -> Overlap {
        let corners = self.corners.iter().zip(self.heights_m).map(|(at, of_corner_m)| OverlapCorner {
            at: *at,
            surface_m: height_m,
            gap_m: of_corner_m - height_m,
        });
        Overlap { corners: corners.collect() }.part(|corner| corner.gap_m - gaps_m[0]).within(gaps_m[1])
    }
}

impl Overlap {
    /// Returns the region in which the gap is at most `gap_m`, in metres.
    pub fn within(&self, gap_m: f64) -> Self {
        self.part(|corner| gap_m - corner.gap_m)
    }

    /// Returns the region in which a linear function is not negative.
    pub fn part(&self, height: impl Fn(&OverlapCorner) -> f64) -> Self {
        let between = |a: &OverlapCorner, b: &OverlapCorner, share: f64| {
            let mix = |a: f64, b: f64| a + share * (b - a);
            OverlapCorner {
                at: [0, 1].map(|axis| mix(a.at[axis], b.at[axis])),
                surface_m: mix(a.surface_m, b.surface_m),
                gap_m: mix(a.gap_m, b.gap_m),
            }
        };
        Self { corners: clipped(&self.corners, height, between) }
    }
}

fn mixed(a: &[f64; 3], b: &[f64; 3], share: f64) -> [f64; 3] {
    [0, 1, 2].map(|axis| a[axis] + share * (b[axis] - a[axis]))
}

/// Clips a convex polygon to the region in which the height is not negative (Sutherland & Hodgman 1974, "Reentrant polygon
/// clipping", whole, for one plane).
fn clipped<T: Copy>(polygon: &[T], height: impl Fn(&T) -> f64, between: impl Fn(&T, &T, f64) -> T) -> Vec<T> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (index, a) in polygon.iter().enumerate() {
        let b = &polygon[(index + 1) % polygon.len()];
        let (of_a, of_b) = (height(a), height(b));
        if of_a >= 0.0 {
            kept.push(*a);
        }
        if (of_a >= 0.0) != (of_b >= 0.0) {
            kept.push(between(a, b, of_a / (of_a - of_b)));
        }
    }
    kept
}

/// Returns the distance of a point from the convex hull of others, in metres: negative for its depth inside, infinite if there
/// are no others.
pub(crate) fn distance_to_hull(points: &[PlanePoint], point: PlanePoint) -> f64 {
    let corners = hull(points);
    let edges = || (0..corners.len()).map(|index| (corners[index], corners[(index + 1) % corners.len()]));
    let nearest_m = edges().map(|(a, b)| distance_to_edge(a, b, point)).fold(f64::INFINITY, f64::min);
    let is_inside = corners.len() > 2 && edges().all(|(a, b)| turn(a, b, point) >= 0.0);
    if is_inside { -nearest_m } else { nearest_m }
}

/// Returns the corners of the convex hull, anticlockwise (Andrew 1979, "Another efficient algorithm for convex hulls in two
/// dimensions", whole).
fn hull(points: &[PlanePoint]) -> Vec<PlanePoint> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    sorted.dedup();
    if sorted.len() < 3 {
        return sorted;
    }
    let mut corners: Vec<PlanePoint> = Vec::new();
    let mut half = |order: &mut dyn Iterator<Item = &PlanePoint>| {
        let first = corners.len();
        for &point in order {
            while corners.len() > first + 1
                && turn(corners[corners.len() - 2], corners[corners.len() - 1], point) <= 0.0
            {
                corners.pop();
            }
            corners.push(point);
        }
        corners.pop();
    };
    half(&mut sorted.iter());
    half(&mut sorted.iter().rev());
    corners
}

fn distance_to_edge(a: PlanePoint, b: PlanePoint, point: PlanePoint) -> f64 {
    let [along, to] = [[b[0] - a[0], b[1] - a[1]], [point[0] - a[0], point[1] - a[1]]];
    let length_squared = along[0] * along[0] + along[1] * along[1];
    let share = (to[0] * along[0] + to[1] * along[1]) / length_squared;
    let share = if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) };
    let [x, y] = [to[0] - share * along[0], to[1] - share * along[1]];
    (x * x + y * y).sqrt()
}

/// Returns twice the signed area of a triangle, positive if it is anticlockwise.
fn turn(o: PlanePoint, a: PlanePoint, b: PlanePoint) -> f64 {
    (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn triangle() -> impl Strategy<Value = [Point; 3]> {
        let corner = || proptest::array::uniform3(-1.0..1.0_f64).prop_map(|[x, y, z]| Point::new(x, y, z));
        [corner(), corner(), corner()]
    }

    /// Returns the height of a triangle at a point projected along z, by barycentric coordinates; `None` outside it.
    fn height_m(triangle: &[Point; 3], [x, y]: PlanePoint) -> Option<f64> {
        let [a, b, c] = triangle;
        let columns = [b - a, c - a].map(|edge| edge.xy());
        let shares = cranny_spatial::nalgebra::Matrix2::from_columns(&columns).try_inverse()?
            * (cranny_spatial::nalgebra::Vector2::new(x, y) - a.coords.xy());
        let (s, t) = (shares.x, shares.y);
        (s >= 0.0 && t >= 0.0 && s + t <= 1.0).then(|| a.z + s * (b.z - a.z) + t * (c.z - a.z))
    }

    proptest! {
        /// A point lies in an overlap if it lies in both triangles and the gap there is in the range.
        #[test]
        fn an_overlap_is_where_both_are_and_the_gap_is_in_range(
            a in triangle(), b in triangle(), point in proptest::array::uniform2(-1.0..1.0_f64),
        ) {
            let across = Across { direction: Vector::z(), axes: [Vector::x(), Vector::y()] };
            let (Some(upper), Some(lower)) = (across.triangle(&a, 0.1), across.triangle(&b, 0.0)) else {
                return Ok(());
            };
            let overlap = upper.above(&lower, 0.5, [-0.2, 0.6]);
            let corners: Vec<_> = overlap.corners.iter().map(|corner| corner.at).collect();
            let is_in = distance_to_hull(&corners, point) < 1e-12;
            let heights = height_m(&a, point).zip(height_m(&b, point));
            let expected =
                heights.is_some_and(|(a, b)| b <= 0.5 && (-0.2..=0.6).contains(&(a + 0.1 - b)));
            prop_assert_eq!(is_in, expected);
            for corner in &overlap.corners {
                prop_assert!(corner.surface_m <= 0.5 + 1e-9 && (-0.2 - 1e-9..=0.6 + 1e-9).contains(&corner.gap_m));
            }
        }
    }

    #[test]
    fn a_triangle_seen_from_its_edge_is_none() {
        let across = Across::new(&Vector::z());
        let upright = [Point::origin(), Point::new(1.0, 0.0, 0.0), Point::new(0.0, 0.0, 1.0)];
        assert!(across.triangle(&upright, 0.0).is_none());
        assert!(distance_to_hull(&[], [0.0, 0.0]).is_infinite());
    }
}
