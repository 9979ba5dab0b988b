use cranny_spatial::Vector;

use crate::moment::Moved;
use crate::span::{Object, Span};

/// Two parts in the middle of an interval.
pub(crate) struct Gap<'a> {
    pub objects: [&'a Object; 2],
    pub spans: [Span; 2],
    pub moved: [Moved; 2],
    /// Distance that both must keep to first order, in metres.
    pub needed_m: f64,
}

/// Amount by which each plane exceeds the inequality of the checker, in metres: a thousand times the rounding of either.
const SLACK_M: f64 = 1e-9;

/// Maximum number of steps of the search for a plane.
const MOST_STEPS: usize = 40;

/// Difference of the two bounds of a distance at which the search ends, in metres.
const ENOUGH_M: f64 = 1e-8;

/// Magnitudes of the greatest component of a plane: the coarser one is shorter.
const GRIDS: [f64; 4] = [9.0, 99.0, 999.0, 32767.0];

impl Gap<'_> {
    /// Returns the least n·(b − a) of two points at these parameters, and that difference.
    fn least(&self, n: &Vector, instants: &[f64]) -> (f64, Vector) {
        let at = |s: &f64| {
            let [a, b] = &self.moved;
            let difference = b.farthest(self.objects[1], self.spans[1], &-n, *s)
                - a.farthest(self.objects[0], self.spans[0], n, *s);
            (n.dot(&difference), difference)
        };
        let all = instants.iter().map(at);
        all.fold((f64::INFINITY, Vector::zeros()), |least, next| if next.0 < least.0 { next } else { least })
    }

    /// Returns true if this plane satisfies the inequality of the checker.
    pub fn is_apart(&self, n: &Vector) -> bool {
        self.least(n, &[-0.5, 0.5]).0 > (self.needed_m + SLACK_M) * n.norm()
    }

    /// Returns a plane that keeps both parts apart along the interval, if there is one.
    ///
    /// 1. Gilbert's search for the point nearest to the origin in the hull of all differences of two points, at both ends of the
    ///    interval (Gilbert, Johnson & Keerthi 1988, whole).
    /// 2. As soon as its direction is good enough, round it, coarsely first.
    pub fn plane(&self) -> Option<[i16; 3]> {
        let [a, b] = &self.moved;
        let mut v = b.center - a.center;
        let mut simplex: Vec<Vector> = Vec::new();
        let needed_m = self.needed_m + SLACK_M;
        for step in 0..MOST_STEPS {
            let long = v.norm();
            if long <= 0.0 || (step > 0 && long <= needed_m) {
                break;
            }
            let (along, point) = self.least(&v, &[-0.5, 0.5]);
            if along > needed_m * long
                && let Some(plane) = GRIDS.iter().find_map(|grid| self.rounded(&v, *grid))
            {
                return Some(plane);
            }
            if step > 0 && long - along / long < ENOUGH_M {
                break;
            }
            simplex.push(point);
            v = nearest(&mut simplex);
        }
        // Parts that may overlap a little have a plane only along a face.
        let normals = |side: usize| {
            let normals = self.objects[side].face_normals(self.spans[side]);
            normals.into_iter().map(move |n| self.moved[side].pose.rotation * n)
        };
        let given = normals(0).chain(normals(1)).chain([Vector::z(), -Vector::z()]).collect::<Vec<_>>();
        given.iter().filter(|n| self.is_apart(n)).find_map(|n| self.rounded(n, GRIDS[3]))
    }

    fn rounded(&self, v: &Vector, grid: f64) -> Option<[i16; 3]> {
        let scaled = (v * (grid / v.amax())).map(f64::round);
        #[allow(clippy::cast_possible_truncation, reason = "at most the grid")]
        self.is_apart(&scaled).then(|| [scaled.x as i16, scaled.y as i16, scaled.z as i16])
    }

    /// Returns the distance of the hulls of both parts in the middle of the interval, in metres, approximately.
    pub fn still_m(&self) -> f64 {
        self.still().0
    }

    /// Returns a lower bound of the distance of the hulls of both parts in the middle of the interval, in metres, close to it, and
    /// the direction in which they are that far apart.
    pub fn still(&self) -> (f64, Vector) {
        let [a, b] = &self.moved;
        let mut v = b.center - a.center;
        let mut simplex: Vec<Vector> = Vec::new();
        let mut below = (0.0, Vector::zeros());
        for step in 0..MOST_STEPS {
            let long = v.norm();
            if long <= ENOUGH_M {
                return (0.0, Vector::zeros());
            }
            let (along, point) = self.least(&v, &[0.0]);
            if along / long > below.0 {
                below = (along / long, v / long);
            }
            if step > 0 && long - along / long < 0.05 * below.0.max(ENOUGH_M) {
                break;
            }
            simplex.push(point);
            v = nearest(&mut simplex);
        }
        below
    }
}

/// Returns the point nearest to the origin in the hull of at most four points, and keeps only those that define it.
fn nearest(simplex: &mut Vec<Vector>) -> Vector {
    let mut best: Option<(f64, Vector, Vec<Vector>)> = None;
    for subset in 1..1_u32 << simplex.len() {
        let chosen: Vec<Vector> = simplex
            .iter()
            .enumerate()
            .filter(|(index, _)| subset >> index & 1 == 1)
            .map(|(_, p)| *p)
            .collect();
        if let Some(point) = nearest_inside(&chosen) {
            let square = point.norm_squared();
            if best.as_ref().is_none_or(|known| square < known.0) {
                best = Some((square, point, chosen));
            }
        }
    }
    let Some((_, point, mut chosen)) = best else { return simplex[0] };
    if chosen.len() > 3 {
        chosen.remove(0);
    }
    *simplex = chosen;
    point
}

/// Returns the point nearest to the origin in the plane, line or space of some points, if it is within their hull.
fn nearest_inside(points: &[Vector]) -> Option<Vector> {
    let edge = |index: usize| points[index] - points[0];
    let p = points[0];
    match points.len() {
        1 => Some(p),
        2 => {
            let e = edge(1);
            let square = e.norm_squared();
            let share = -e.dot(&p) / square;
            (square > 0.0 && (0.0..=1.0).contains(&share)).then(|| p + e * share)
        }
        3 => {
            let (e, f) = (edge(1), edge(2));
            let (ee, ef, ff) = (e.norm_squared(), e.dot(&f), f.norm_squared());
            let determinant = ee * ff - ef * ef;
            let (ep, fp) = (-e.dot(&p), -f.dot(&p));
            let (x, y) = ((ff * ep - ef * fp) / determinant, (ee * fp - ef * ep) / determinant);
            (determinant > 0.0 && x >= 0.0 && y >= 0.0 && x + y <= 1.0).then(|| p + e * x + f * y)
        }
        _ => {
            let (e, f, g) = (edge(1), edge(2), edge(3));
            let determinant = e.dot(&f.cross(&g));
            let of = |a: &Vector, b: &Vector| -p.dot(&a.cross(b)) / determinant;
            let (x, y, z) = (of(&f, &g), of(&g, &e), of(&e, &f));
            (determinant != 0.0 && x >= 0.0 && y >= 0.0 && z >= 0.0 && x + y + z <= 1.0).then(Vector::zeros)
        }
    }
}
