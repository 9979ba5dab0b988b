use cranny_spatial::{Point, Vector};

/// A point of a plane, in metres along its two axes.
pub(crate) type PlanePoint = [f64; 2];

/// A plane across a direction, with two axes in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Across {
    direction: Vector,
    axes: [Vector; 2],
}

/// Polygons of the supporting surface of less than this, twice their area (m²), are edges or sides of it.
const LEAST_AREA_M2: f64 = 1e-14;

impl Across {
    /// Across a unit vector.
    pub fn new(direction: &Vector) -> Self {
        let other = Vector::ith(direction.iamin(), 1.0);
        let first = direction.cross(&other).normalize();
        Self { direction: *direction, axes: [first, direction.cross(&first)] }
    }

    /// A point seen along the direction.
    pub fn seen(&self, point: &Point) -> PlanePoint {
        self.axes.map(|axis| axis.dot(&point.coords))
    }

    /// The point that is seen there, at a height (m) along the direction.
    pub fn point(&self, [x, y]: PlanePoint, height_m: f64) -> Point {
        (self.axes[0] * x + self.axes[1] * y + self.direction * height_m).into()
    }

    /// Part of a triangle between two heights (m) along the direction, projected along it: a convex polygon, in the
    /// order of the triangle's corners; empty if no part lies there.
    pub fn slice(&self, triangle: &[Point; 3], [low_m, high_m]: [f64; 2]) -> Vec<PlanePoint> {
        let height = |point: &Point| self.direction.dot(&point.coords);
        let above = clipped(triangle, |point| height(point) - low_m);
        let between = clipped(&above, |point| high_m - height(point));
        between.iter().map(|point| self.seen(point)).collect()
    }
}

/// Part of a convex polygon whose height is not negative.
fn clipped(polygon: &[Point], height: impl Fn(&Point) -> f64) -> Vec<Point> {
    let mut kept = Vec::new();
    for (index, a) in polygon.iter().enumerate() {
        let b = &polygon[(index + 1) % polygon.len()];
        let (of_a, of_b) = (height(a), height(b));
        if of_a >= 0.0 {
            kept.push(*a);
        }
        if (of_a >= 0.0) != (of_b >= 0.0) {
            kept.push(a + (b - a) * (of_a / (of_a - of_b)));
        }
    }
    kept
}

/// The corners of all that any of some convex polygons shares with any of others, which count if they have an area, seen
/// anticlockwise.
pub(crate) fn all_shared(first: &[Vec<PlanePoint>], second: &[Vec<PlanePoint>]) -> Vec<PlanePoint> {
    let second: Vec<_> = second.iter().filter(|polygon| area_m2(polygon) >= LEAST_AREA_M2).collect();
    let boxes: Vec<_> = second.iter().map(|polygon| corners_of_box(polygon)).collect();
    let mut corners = Vec::new();
    for polygon in first {
        let [low, high] = corners_of_box(polygon);
        for (other, [other_low, other_high]) in second.iter().zip(&boxes) {
            if (0..2).all(|axis| low[axis] <= other_high[axis] && other_low[axis] <= high[axis]) {
                corners.extend(shared(polygon, other));
            }
        }
    }
    corners
}

fn corners_of_box(polygon: &[PlanePoint]) -> [PlanePoint; 2] {
    let bound = |start: f64, of: fn(f64, f64) -> f64| {
        [0, 1].map(|axis| polygon.iter().map(|point| point[axis]).fold(start, of))
    };
    [bound(f64::INFINITY, f64::min), bound(f64::NEG_INFINITY, f64::max)]
}

/// Twice the area of a convex polygon, positive if it is anticlockwise.
fn area_m2(polygon: &[PlanePoint]) -> f64 {
    (2..polygon.len()).map(|last| turn(polygon[0], polygon[last - 1], polygon[last])).sum()
}

/// The corners of what two convex polygons share (Sutherland & Hodgman 1974), the second anticlockwise.
fn shared(first: &[PlanePoint], second: &[PlanePoint]) -> Vec<PlanePoint> {
    let corner = |index: usize| second[index % second.len()];
    let mut rest = first.to_vec();
    for index in 0..second.len() {
        let (from, to) = (corner(index), corner(index + 1));
        let mut kept = Vec::new();
        for (at, &a) in rest.iter().enumerate() {
            let b = rest[(at + 1) % rest.len()];
            let (of_a, of_b) = (turn(from, to, a), turn(from, to, b));
            if of_a >= 0.0 {
                kept.push(a);
            }
            if (of_a >= 0.0) != (of_b >= 0.0) {
                let share = of_a / (of_a - of_b);
                kept.push([0, 1].map(|axis| a[axis] + share * (b[axis] - a[axis])));
            }
        }
        rest = kept;
    }
    rest
}

/// Distance of a point from the convex hull of others, in metres: 0 inside it, infinite if there are no others.
pub(crate) fn distance_to_hull(points: &[PlanePoint], point: PlanePoint) -> f64 {
    let corners = hull(points);
    let edges = || (0..corners.len()).map(|index| (corners[index], corners[(index + 1) % corners.len()]));
    if corners.len() > 2 && edges().all(|(a, b)| turn(a, b, point) >= 0.0) {
        return 0.0;
    }
    edges().map(|(a, b)| distance_to_edge(a, b, point)).fold(f64::INFINITY, f64::min)
}

/// The corners of the convex hull, anticlockwise (Andrew 1979).
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

/// Twice the area of a triangle, positive if it is anticlockwise.
fn turn(o: PlanePoint, a: PlanePoint, b: PlanePoint) -> f64 {
    (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn triangle() -> impl Strategy<Value = Vec<PlanePoint>> {
        proptest::collection::vec(proptest::array::uniform2(-1.0..1.0_f64), 3).prop_map(|mut corners| {
            if turn(corners[0], corners[1], corners[2]) < 0.0 {
                corners.reverse();
            }
            corners
        })
    }

    proptest! {
        /// A point lies in what two triangles share if it lies in both.
        #[test]
        fn what_is_shared_is_what_lies_in_both(a in triangle(), b in triangle(), point in proptest::array::uniform2(-1.0..1.0_f64)) {
            let off = [distance_to_hull(&a, point), distance_to_hull(&b, point)];
            let both = distance_to_hull(&shared(&a, &b), point);
            prop_assert!(both >= off[0].max(off[1]) - 1e-9);
            prop_assert_eq!(off == [0.0, 0.0], both < 1e-9, "{:?} {}", off, both);
        }
    }

    #[test]
    fn a_slice_is_seen_along_its_direction() {
        let across = Across::new(&Vector::z());
        let corners = [Point::new(0.0, 0.0, 0.0), Point::new(1.0, 0.0, 2.0), Point::new(0.0, 1.0, 2.0)];
        let slice = across.slice(&corners, [1.0, 3.0]);
        assert_eq!(slice.len(), 4);
        let of = |x: f64, y: f64| distance_to_hull(&slice, across.seen(&Point::new(x, y, 0.0)));
        assert!(of(0.5, 0.4) < 1e-12 && of(0.3, 0.3) < 1e-12);
        assert!((of(0.0, 0.0) - 0.5 * 0.5_f64.sqrt()).abs() < 1e-12);
        assert!(across.slice(&corners, [3.0, 4.0]).is_empty());
        assert!(distance_to_hull(&[], [0.0, 0.0]).is_infinite());
    }
}
