use std::collections::BTreeSet;

use cranny_spatial::{Point, Vector};
use robust::{Coord, orient2d};

use crate::mesh_files::corner_tree::CornerTree;
use crate::mesh_files::side_sweep::crosses_itself;

/// Triangulates a polygon, as indices into its corners. The triangles cover exactly the polygon.
///
/// 1. Projects the polygon along the axis nearest to its normal (Newell's method). So a polygon that is not quite flat is cut
///    as its projection, as in other readers.
/// 2. Uses a fan from the first corner, if all of it lies in the polygon.
/// 3. Otherwise cuts off ears (Meisters 1975, "Polygons have ears", whole): corners whose triangle contains no other corner.
///    Exact predicates decide on which side of a line a corner lies.
///
/// Collinear corners, and bridges to holes traversed in both directions, are valid. Returns `None` for a polygon that crosses
/// itself, whose interior is undefined.
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
    if crosses_itself(&shadow.0) { None } else { shadow.ears() }
}

/// Returns true if all corners are collinear, up to rounding, or one is not finite, which is reported elsewhere.
fn is_sliver(polygon: &[Point]) -> bool {
    /// Width relative to length: rounding in single precision.
    const WIDTH: f64 = 1e-7;
    let far = polygon.iter().map(|corner| corner - polygon[0]).max_by(|a, b| a.norm().total_cmp(&b.norm()));
    let far = far.unwrap_or_default();
    polygon.iter().all(|corner| {
        let width = (corner - polygon[0]).cross(&far).norm();
        width.is_nan() || width <= WIDTH * far.norm_squared()
    })
}

/// Projection of a polygon into a plane, counterclockwise.
struct Shadow(Vec<Coord<f64>>);

impl Shadow {
    /// Projects a polygon; `None` if its area is zero although its corners are not collinear.
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

    /// Returns true if the first corner sees all others in their order within half a turn.
    fn holds_its_fan(&self) -> bool {
        let last = self.0.len() - 1;
        (1..last).all(|corner| {
            self.turn(0, corner, corner + 1) >= 0.0
                && self.turn(0, 1, corner + 1) >= 0.0
                && self.turn(0, corner, last) >= 0.0
        })
    }

    /// Triangulates by ears; `None` if no ear is found, which happens only if the polygon crosses itself.
    ///
    /// The next ear is the first one after the last cut, as if all corners were tried in turn. But a corner is tried again only
    /// after its triangle has changed, or after the corner found in it no longer blocks it.
    fn ears(&self) -> Option<Vec<[usize; 3]>> {
        let mut cut = Cut::of(self);
        let mut triangles = Vec::with_capacity(self.0.len() - 2);
        let (mut at, mut left) = (0, self.0.len());
        while left > 3 {
            // Collinear corners go last: without area they hide nothing.
            let ear = cut.next_ear(at).or_else(|| first_from(&cut.flat, cut.after[at]))?;
            triangles.push([cut.before[ear], ear, cut.after[ear]]);
            at = cut.after[ear];
            cut.cut_off(ear);
            left -= 1;
        }
        triangles.push([cut.before[at], at, cut.after[at]]);
        Some(triangles)
    }

    /// Returns true if a corner is inside a triangle, or on its side opposite the second corner, but not at its corners.
    fn hinders(&self, [a, b, c]: [usize; 3], corner: usize) -> bool {
        let place = self.0[corner];
        ![a, b, c].iter().any(|&own| own == corner || self.0[own] == place)
            && self.turn(a, b, corner) > 0.0
            && self.turn(b, c, corner) > 0.0
            && self.turn(c, a, corner) >= 0.0
    }
}

/// Remaining polygon from which ears are cut.
struct Cut<'a> {
    shadow: &'a Shadow,
    /// Next remaining corner of each corner.
    after: Vec<usize>,
    /// Previous remaining corner of each corner.
    before: Vec<usize>,
    is_left: Vec<bool>,
    /// Corners that an ear may contain; the polygon is convex at all others.
    inward: CornerTree,
    /// Corners collinear with their neighbours.
    flat: BTreeSet<usize>,
    /// Corners that may be ears and have not been tried.
    untried: BTreeSet<usize>,
    /// Candidates that each inward corner blocks; some have changed since.
    hindered: Vec<Vec<usize>>,
}

impl<'a> Cut<'a> {
    fn of(shadow: &'a Shadow) -> Self {
        let count = shadow.0.len();
        let after: Vec<usize> = (0..count).map(|corner| (corner + 1) % count).collect();
        let before: Vec<usize> = (0..count).map(|corner| (corner + count - 1) % count).collect();
        let turn = |at: usize| shadow.turn(before[at], at, after[at]);
        let inward = CornerTree::new(&shadow.0, (0..count).filter(|&at| turn(at) <= 0.0).collect());
        let (flat, untried) = (BTreeSet::new(), BTreeSet::new());
        let (is_left, hindered) = (vec![true; count], vec![Vec::new(); count]);
        let mut cut = Self { shadow, after, before, is_left, inward, flat, untried, hindered };
        (0..count).for_each(|corner| cut.sort_in(corner));
        cut
    }

    /// Updates the sets that a corner belongs to.
    fn sort_in(&mut self, corner: usize) {
        let turn = self.shadow.turn(self.before[corner], corner, self.after[corner]);
        let sort = |set: &mut BTreeSet<usize>, is_in: bool| {
            if is_in {
                set.insert(corner)
            } else {
                set.remove(&corner)
            };
        };
        sort(&mut self.untried, turn > 0.0);
        sort(&mut self.flat, turn == 0.0);
        if turn > 0.0 {
            self.hinders_no_longer(corner);
        }
    }

    fn hinders_no_longer(&mut self, corner: usize) {
        self.inward.remove(corner);
        for ear in std::mem::take(&mut self.hindered[corner]) {
            if self.is_left[ear] && self.shadow.turn(self.before[ear], ear, self.after[ear]) > 0.0 {
                self.untried.insert(ear);
            }
        }
    }

    /// First ear from a corner on.
    fn next_ear(&mut self, from: usize) -> Option<usize> {
        loop {
            let at = first_from(&self.untried, from)?;
            let triangle = [self.before[at], at, self.after[at]];
            let found = self.inward.find(triangle.map(|corner| self.shadow.0[corner]), |other| {
                self.shadow.hinders(triangle, other)
            });
            let Some(inside) = found else { return Some(at) };
            self.hindered[inside].push(at);
            self.untried.remove(&at);
        }
    }

    fn cut_off(&mut self, corner: usize) {
        let (a, c) = (self.before[corner], self.after[corner]);
        (self.after[a], self.before[c]) = (c, a);
        self.is_left[corner] = false;
        self.hinders_no_longer(corner);
        self.untried.remove(&corner);
        self.flat.remove(&corner);
        self.sort_in(a);
        self.sort_in(c);
    }
}

/// First of some corners from a corner on, around the polygon.
fn first_from(corners: &BTreeSet<usize>, from: usize) -> Option<usize> {
    corners.range(from..).next().or_else(|| corners.first()).copied()
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

    /// Tests stars with random radii, rotation and first corner. The areas of the triangles must sum to that of the
    /// polygon; they would exceed it if one of them lay outside.
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

    /// Reference for [`Shadow::ears`] that tries all corners in turn against all others.
    fn ears_tried_in_turn(shadow: &Shadow) -> Option<Vec<[usize; 3]>> {
        let count = shadow.0.len();
        let mut after: Vec<usize> = (0..count).map(|corner| (corner + 1) % count).collect();
        let mut before: Vec<usize> = (0..count).map(|corner| (corner + count - 1) % count).collect();
        let mut inward: Vec<usize> =
            (0..count).filter(|&at| shadow.turn(before[at], at, after[at]) <= 0.0).collect();
        let mut triangles = Vec::new();
        let (mut at, mut passed, mut left) = (0, 0, count);
        while left > 3 {
            let (a, c) = (before[at], after[at]);
            let turn = shadow.turn(a, at, c);
            let is_flat = turn == 0.0 && passed > left;
            let is_ear = turn > 0.0 && !inward.iter().any(|&other| shadow.hinders([a, at, c], other));
            if is_flat || is_ear {
                triangles.push([a, at, c]);
                (after[a], before[c]) = (c, a);
                (left, passed) = (left - 1, 0);
                inward.retain(|&one| one != at && shadow.turn(before[one], one, after[one]) <= 0.0);
            } else if passed > 2 * left {
                return None;
            } else {
                passed += 1;
            }
            at = c;
        }
        triangles.push([before[at], at, after[at]]);
        Some(triangles)
    }

    /// Polygons on a coarse grid have corners that are collinear, coincident or on other sides. Most cross themselves and
    /// may have no ear.
    #[test]
    fn ears_are_those_of_all_corners_tried_in_turn() {
        let mut random = Stream::new(6, 0);
        let mut found = [0; 2];
        for corners in 4..40_u32 {
            for round in 0..200 {
                let polygon: Vec<_> = (0..corners)
                    .map(|corner| {
                        let (sine, cosine) =
                            sin_cos(f64::from(corner) / f64::from(corners) * std::f64::consts::TAU);
                        let radius = 1.0 + (6.0 * random.uniform()).floor();
                        match round % 3 {
                            0 => (radius * cosine, radius * sine),
                            1 => ((radius * cosine).round(), (radius * sine).round()),
                            _ => ((5.0 * random.uniform()).floor(), (5.0 * random.uniform()).floor()),
                        }
                    })
                    .collect();
                let Some(shadow) = Shadow::of(&flat(&polygon)) else { continue };
                let expected = ears_tried_in_turn(&shadow);
                found[usize::from(expected.is_some())] += 1;
                assert_eq!(shadow.ears(), expected, "{polygon:?}");
            }
        }
        assert!(found.iter().all(|count| *count > 500), "{found:?}");
    }

    /// Guards against quadratic time, which would be hours for the search of ears and for that of crossing sides.
    #[test]
    fn many_corners_take_little_time() {
        const CORNERS: u32 = 100_000;
        let turn = |corner: u32| f64::from(corner) / f64::from(CORNERS) * std::f64::consts::TAU;
        let on_ring = |angle: f64, radius: f64| {
            let (sine, cosine) = sin_cos(angle);
            (radius * cosine, radius * sine)
        };
        let star = |inner: f64| -> Vec<_> {
            (0..CORNERS).map(|at| on_ring(turn(at), if at % 2 == 0 { 1.0 } else { inner })).collect()
        };
        let mut random = Stream::new(7, 0);
        let hedgehog = (0..CORNERS).map(|at| on_ring(turn(at), 0.1 + random.uniform())).collect();
        // An arc that faces inwards, closed by three corners outside it.
        let crescent: Vec<_> = [(3.0, 0.0), (0.0, 4.0), (-3.0, 0.0)]
            .into_iter()
            .chain((0..CORNERS).map(|at| on_ring(3.0 - 0.45 * turn(at), 1.0)))
            .collect();
        // Ten turns outwards and back, side by side.
        let spiral: Vec<_> = (0..CORNERS / 2)
            .map(|at| on_ring(20.0 * turn(at), 1.0 + turn(at)))
            .chain((0..CORNERS / 2).rev().map(|at| on_ring(20.0 * turn(at), 1.05 + turn(at))))
            .collect();
        // Slanted teeth, each beside all others in x and in y.
        let comb: Vec<_> = (0..CORNERS)
            .map(|at| (f64::from(at), if at % 2 == 0 { 0.0 } else { 1e6 }))
            .chain([(2e5, 2e6), (-1e5, 2e6), (-1e5, -1e5)])
            .map(|(x, y)| (x - 0.5 * y, y + 0.5 * x))
            .collect();
        for (name, outline) in [
            ("star", star(0.5)),
            ("saw", star(0.999)),
            ("hedgehog", hedgehog),
            ("crescent", crescent),
            ("spiral", spiral),
            ("comb", comb),
        ] {
            let polygon = flat(&outline);
            let started = std::time::Instant::now();
            let triangles = triangulate(&polygon).expect(name);
            let seconds = started.elapsed().as_secs_f64();
            let doubled: f64 = (0..outline.len())
                .map(|at| (outline[at], outline[(at + 1) % outline.len()]))
                .map(|(a, b)| a.0 * b.1 - a.1 * b.0)
                .sum();
            let (covered, exact) = (area(&polygon, &triangles), 0.5 * doubled.abs());
            assert!((covered - exact).abs() < 1e-6 * exact, "{name}: {covered} for {exact}");
            assert!(seconds < 20.0, "{name}: {seconds} s");
        }
    }

    #[test]
    fn a_convex_polygon_is_a_fan() {
        let square = flat(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)]);
        assert_eq!(triangulate(&square).expect("a square"), [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
    }

    #[test]
    fn a_hole_with_a_bridge_stays_open() {
        // A square of 4 with a square hole of 2, joined by a bridge traversed in both directions.
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
