use cranny_spatial::{Point, Vector};
use robust::{Coord, orient2d};

/// Cuts a polygon into triangles, as indices into its corners, that cover it and nothing beside it.
///
/// 1. The polygon is seen along the axis that its normal is nearest to (Newell's method), so that a polygon that is not
///    quite flat is cut where its shadow is, as other readers do.
/// 2. A fan from the first corner, if all of it lies in the polygon.
/// 3. Else ears are cut off (Meisters 1975): corners whose triangle holds no other corner. Which side of a line a corner
///    is on is decided exactly.
///
/// Corners on one line, and bridges to holes that run there and back, are no fault. Returns `None` for a polygon that
/// crosses itself: what it encloses is not defined.
pub(crate) fn triangulate(polygon: &[Point]) -> Option<Vec<[usize; 3]>> {
    let fan = || (2..polygon.len()).map(|corner| [0, corner - 1, corner]).collect();
    if polygon.len() <= 3 || is_sliver(polygon) {
        return Some(fan());
    }
    // 1.
    let shadow = Shadow::of(polygon)?;
    // 2.
    if shadow.holds_its_fan() {
        return Some(fan());
    }
    // 3.
    if shadow.crosses_itself() { None } else { shadow.ears() }
}

/// Returns whether all corners lie on one line, up to rounding, or one is not finite, which is reported elsewhere.
fn is_sliver(polygon: &[Point]) -> bool {
    /// Width by length: rounding in single precision.
    const WIDTH: f64 = 1e-7;
    let far = polygon.iter().map(|corner| corner - polygon[0]).max_by(|a, b| a.norm().total_cmp(&b.norm()));
    let far = far.unwrap_or_default();
    polygon.iter().all(|corner| {
        let width = (corner - polygon[0]).cross(&far).norm();
        width.is_nan() || width <= WIDTH * far.norm_squared()
    })
}

/// A polygon in a plane, counterclockwise.
struct Shadow(Vec<Coord<f64>>);

impl Shadow {
    /// `None` for a polygon whose area is zero though its corners are not on one line.
    fn of(polygon: &[Point]) -> Option<Self> {
        let next = |index: usize| (index + 1) % polygon.len();
        let normal: Vector = (0..polygon.len())
            .map(|at| (polygon[at] - polygon[0]).cross(&(polygon[next(at)] - polygon[0])))
            .sum();
        let away = normal.iamax();
        let (mut x, mut y) = ((away + 1) % 3, (away + 2) % 3);
        if normal[away] < 0.0 {
            std::mem::swap(&mut x, &mut y);
        }
        let corners = polygon.iter().map(|corner| Coord { x: corner[x], y: corner[y] }).collect();
        (normal[away] != 0.0).then_some(Self(corners))
    }

    /// Positive where `a`, `b`, `c` turn left; only the sign is exact.
    fn turn(&self, a: usize, b: usize, c: usize) -> f64 {
        orient2d(self.0[a], self.0[b], self.0[c])
    }

    /// Returns whether the first corner sees all others in their order within half a turn.
    fn holds_its_fan(&self) -> bool {
        let last = self.0.len() - 1;
        (1..last).all(|corner| {
            self.turn(0, corner, corner + 1) >= 0.0
                && self.turn(0, 1, corner + 1) >= 0.0
                && self.turn(0, corner, last) >= 0.0
        })
    }

    /// Returns whether two sides cross at a point that is inside both.
    fn crosses_itself(&self) -> bool {
        let count = self.0.len();
        let low = |side: usize| self.0[side].x.min(self.0[(side + 1) % count].x);
        let high = |side: usize| self.0[side].x.max(self.0[(side + 1) % count].x);
        let cross = |one: usize, two: usize| {
            let (a, b, c, d) = (one, (one + 1) % count, two, (two + 1) % count);
            let apart = |s: f64, t: f64| (s > 0.0 && t < 0.0) || (s < 0.0 && t > 0.0);
            apart(self.turn(a, b, c), self.turn(a, b, d)) && apart(self.turn(c, d, a), self.turn(c, d, b))
        };
        let mut sides: Vec<usize> = (0..count).collect();
        sides.sort_by(|&one, &two| low(one).total_cmp(&low(two)));
        (0..count).any(|first| {
            let near = sides[first + 1..].iter().take_while(|&&side| low(side) <= high(sides[first]));
            near.into_iter().any(|&side| cross(sides[first], side))
        })
    }

    /// `None` if at some time there is no ear, which no polygon has that does not cross itself.
    fn ears(&self) -> Option<Vec<[usize; 3]>> {
        let count = self.0.len();
        let mut after: Vec<usize> = (0..count).map(|corner| (corner + 1) % count).collect();
        let mut before: Vec<usize> = (0..count).map(|corner| (corner + count - 1) % count).collect();
        // What an ear may hold is one of these: around other corners the polygon is convex.
        let mut inward: Vec<usize> =
            (0..count).filter(|&at| self.turn(before[at], at, after[at]) <= 0.0).collect();
        let mut triangles = Vec::with_capacity(count - 2);
        let (mut at, mut passed, mut left) = (0, 0, count);
        while left > 3 {
            let (a, c) = (before[at], after[at]);
            let turn = self.turn(a, at, c);
            // Corners on one line go last: without area they hide nothing.
            let is_flat = turn == 0.0 && passed > left;
            let is_ear = turn > 0.0 && !inward.iter().any(|&other| self.hinders([a, at, c], other));
            if !is_flat && !is_ear {
                (at, passed) = (c, passed + 1);
                if passed > 2 * left + 1 {
                    return None;
                }
                continue;
            }
            triangles.push([a, at, c]);
            (after[a], before[c]) = (c, a);
            (left, passed) = (left - 1, 0);
            inward.retain(|&corner| corner != at && self.turn(before[corner], corner, after[corner]) <= 0.0);
            at = c;
        }
        triangles.push([before[at], at, after[at]]);
        Some(triangles)
    }

    /// Returns whether a corner is inside a triangle, or on its side opposite the second corner, but not at one of its
    /// corners.
    fn hinders(&self, [a, b, c]: [usize; 3], corner: usize) -> bool {
        let place = self.0[corner];
        ![a, b, c].iter().any(|&own| own == corner || self.0[own] == place)
            && self.turn(a, b, corner) > 0.0
            && self.turn(b, c, corner) > 0.0
            && self.turn(c, a, corner) >= 0.0
    }
}

#[cfg(test)]
mod tests {
    use cranny_spatial::{Rotation, Stream, sin_cos};

    use super::*;

    fn area(polygon: &[Point], triangles: &[[usize; 3]]) -> f64 {
        triangles
            .iter()
            .map(|t| 0.5 * (polygon[t[1]] - polygon[t[0]]).cross(&(polygon[t[2]] - polygon[t[0]])).norm())
            .sum()
    }

    fn flat(corners: &[(f64, f64)]) -> Vec<Point> {
        corners.iter().map(|&(x, y)| Point::new(x, y, 0.3)).collect()
    }

    /// Stars with random radii, turned anyhow and begun anywhere: the areas of the triangles add up to that of the
    /// polygon, which they would exceed if one of them lay outside.
    #[test]
    fn triangles_cover_a_polygon_and_nothing_beside_it() {
        let mut random = Stream::new(5, 0);
        for corners in 4..60 {
            for _ in 0..20 {
                let angle = |corner: u32| f64::from(corner) / f64::from(corners) * std::f64::consts::TAU;
                let star: Vec<_> = (0..corners)
                    .map(|corner| {
                        let radius = 0.1 + random.uniform();
                        let (sine, cosine) = sin_cos(angle(corner));
                        (radius * cosine, radius * sine)
                    })
                    .collect();
                let exact: f64 = (0..star.len())
                    .map(|at| (star[at], star[(at + 1) % star.len()]))
                    .map(|(a, b)| 0.5 * (a.0 * b.1 - a.1 * b.0))
                    .sum();
                let turn = Rotation::from_euler_angles(random.uniform(), random.uniform(), random.uniform());
                let polygon: Vec<Point> = flat(&star).iter().map(|corner| turn * corner).collect();
                let triangles = triangulate(&polygon).expect("it does not cross itself");
                assert_eq!(triangles.len(), polygon.len() - 2);
                let covered = area(&polygon, &triangles);
                assert!((covered - exact).abs() < 1e-9 * exact, "{covered} for {exact}");
            }
        }
    }

    #[test]
    fn a_convex_polygon_is_a_fan() {
        let square = flat(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)]);
        assert_eq!(triangulate(&square).expect("a square"), [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
    }

    #[test]
    fn a_hole_with_a_bridge_stays_open() {
        // A square of 4 with a square hole of 2, both joined by a bridge there and back.
        let outer = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0), (0.0, 0.0)];
        let hole = [(1.0, 1.0), (1.0, 3.0), (3.0, 3.0), (3.0, 1.0), (1.0, 1.0)];
        let polygon = flat(&[&outer[..], &hole[..]].concat());
        let triangles = triangulate(&polygon).expect("it does not cross itself");
        assert!((area(&polygon, &triangles) - 12.0).abs() < 1e-12);
        let middle = Point::new(2.0, 2.0, 0.3);
        let is_over = |t: &[usize; 3]| {
            (0..3).all(|i| {
                let (a, b) = (polygon[t[i]], polygon[t[(i + 1) % 3]]);
                (b - a).cross(&(middle - a)).z > 0.0
            })
        };
        assert!(!triangles.iter().any(is_over));
    }

    #[test]
    fn a_polygon_that_crosses_itself_is_none() {
        let bow = [(0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 1.0)];
        let pentagram = [(0.0, 1.0), (-0.6, -0.8), (0.95, 0.3), (-0.95, 0.3), (0.6, -0.8)];
        for crossing in [&bow[..], &pentagram[..], &[(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)]] {
            assert_eq!(triangulate(&flat(crossing)), None);
        }
    }

    #[test]
    fn corners_on_one_line_are_kept_without_area() {
        let line = flat(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (3.0, 0.0), (1.5, 0.0)]);
        assert_eq!(triangulate(&line).map(|triangles| triangles.len()), Some(3));
        let doubled = flat(&[(0.0, 0.0), (0.0, 0.0), (1.0, 0.0), (0.1, 0.1), (0.0, 1.0)]);
        let triangles = triangulate(&doubled).expect("it does not cross itself");
        assert!((area(&doubled, &triangles) - 0.1).abs() < 1e-12);
    }
}
