//! Solids and objects of a certificate: their supports, and the parts into which they are divided.

use super::interval::{IDENTITY, Interval, Vector, ZERO, dot, length, point, scaled, transposed_times};
use super::lines::{Checked, Lines, unless};
use super::scene::{Motion, Point, Pose};

/// Words that begin a solid.
const KINDS: [&str; 7] = ["box", "ball", "capsule", "cylinder", "half", "hull", "mesh"];

/// Sum of a box, a disc across z, a ball and the convex hull of points, of which most have one or two; or the surface of a mesh
/// and all that it seals off; or a half-space.
#[derive(Default)]
pub struct Solid {
    pub pose: Pose,
    half: Point,
    disc: f64,
    ball: f64,
    points: Vec<Point>,
    faces: Vec<[usize; 3]>,
    pub is_half_space: bool,
    /// Greatest magnitude of each coordinate of the points.
    largest: Point,
    /// Lower and upper corner of a box around it, in the frame of the object.
    corners: [Point; 2],
}

/// A link, or a body of the world.
#[derive(Default)]
pub struct Object<'a> {
    pub name: &'a str,
    pub is_body: bool,
    /// For a link: its parent, how many are above it, its pose in the parent, and its motion.
    pub parent: Option<usize>,
    pub depth: usize,
    pub pose: Pose,
    pub motion: Option<Motion>,
    /// Its first line with the name of its parent, and a hash of all its lines and of those of all links above it.
    pub title: String,
    pub key: String,
    pub solids: Vec<Solid>,
}

/// Consecutive solids of an object, or consecutive faces of one mesh.
#[derive(Clone, Copy, PartialEq)]
pub struct Span {
    pub solids: [usize; 2],
    faces: [usize; 2],
}

impl Solid {
    /// Reads a solid, if the present line begins one.
    pub fn read(lines: &mut Lines<'_>, is_of_body: bool) -> Checked<Option<Self>> {
        let Some(kind) = KINDS.into_iter().find(|kind| lines.is(kind)) else { return Ok(None) };
        let mut solid = Self::default();
        lines.read(kind, |line| {
            solid.pose = line.pose()?;
            match kind {
                "box" => solid.half = [line.size()?, line.size()?, line.size()?],
                "ball" | "hull" => solid.ball = line.size()?,
                "capsule" => (solid.half[2], solid.ball) = (line.size()?, line.size()?),
                "cylinder" => (solid.half[2], solid.disc) = (line.size()?, line.size()?),
                _ => solid.is_half_space = kind == "half",
            }
            unless(is_of_body || !solid.is_half_space, "a link cannot be a half-space")
        })?;
        while ["hull", "mesh"].contains(&kind) && lines.is("v") {
            solid.points.push(lines.read("v", Lines::point)?);
        }
        let count = solid.points.len();
        while kind == "mesh" && lines.is("f") {
            let corners =
                |line: &mut Lines<'_>| Ok([line.index(count)?, line.index(count)?, line.index(count)?]);
            solid.faces.push(lines.read("f", corners)?);
        }
        let is_empty = (kind == "hull" && count == 0) || (kind == "mesh" && solid.faces.is_empty());
        unless(!is_empty, "a hull without points, or a mesh without faces")?;
        solid.largest = [0, 1, 2].map(|i| solid.points.iter().fold(0.0, |most: f64, p| most.max(p[i].abs())));
        let along = |i: usize, sign| solid.support(scaled(IDENTITY[i], point(sign)), [0, solid.faces.len()]);
        let corner = |sign: f64| std::array::from_fn(|i| sign * along(i, sign));
        solid.corners = [corner(-1.0), corner(1.0)];
        Ok(Some(solid))
    }

    /// Returns an upper bound of the greatest n·p over the solid, or these faces of it, in the frame of the object (4).
    fn support(&self, n: Vector, faces: [usize; 2]) -> f64 {
        if self.is_half_space {
            return f64::INFINITY;
        }
        let m = transposed_times(&self.pose.rotation, n);
        let disc = length([m[0], m[1], ZERO]) * point(self.disc);
        let round = disc + length(m) * point(self.ball);
        let center = dot(n, self.pose.translation) + dot(m.map(Interval::magnitude), self.half.map(point));
        let corners = self.faces[faces[0]..faces[1]].iter().flatten();
        let farthest = match faces == [0, self.faces.len()] {
            true => self.farthest(m, self.points.iter()),
            false => self.farthest(m, corners.map(|index| &self.points[*index])),
        };
        (center + round + farthest).hi
    }

    /// Returns true if a ball, in the frame of the object, is in the solid; always false for hulls and meshes (14, 15).
    pub fn contains(&self, center: Vector, radius: Interval) -> bool {
        let local = self.pose.to_own(center);
        if self.is_half_space || !self.points.is_empty() {
            return self.is_half_space && (local[2] + radius).hi <= 0.0;
        }
        let beyond =
            |x: Interval, by: Interval, most: f64| point((x.magnitude() + by - point(most)).hi.max(0.0));
        // A round solid holds balls around the points that are deep enough in its outermost ball, others those deep enough in the rest.
        let [outer, inner] = if self.ball > 0.0 { [radius, ZERO] } else { [ZERO, radius] };
        let sides = if self.disc > 0.0 { ZERO } else { inner };
        let [x, y] = [0, 1].map(|i| beyond(local[i], sides, self.half[i]));
        let z = beyond(local[2], inner, self.half[2]);
        let is_across = x == ZERO && y == ZERO && self.disc <= 0.0;
        let across = if is_across { ZERO } else { beyond(length([x, y, ZERO]), inner, self.disc) };
        let is_in_core = across == ZERO && z == ZERO && outer == ZERO;
        is_in_core || (length([across, ZERO, z]) + outer).hi <= self.ball
    }

    pub fn vertices(&self) -> usize {
        self.points.len()
    }

    pub fn faces(&self) -> usize {
        self.faces.len()
    }

    /// Returns a vertex in the frame of the object: of a mesh, only one that a face has.
    pub fn vertex(&self, index: usize) -> Checked<Vector> {
        let is_known = self.faces.is_empty() || self.faces.iter().flatten().any(|corner| *corner == index);
        unless(is_known, "a vertex of no face").map(|()| self.pose.of_point(self.points[index].map(point)))
    }

    /// Encloses the greatest m·p over some points, 0 for none (4).
    fn farthest<'p>(&self, m: Vector, points: impl Iterator<Item = &'p Point>) -> Interval {
        let middle = m.map(Interval::middle);
        let along = |p: &Point| middle[0] * p[0] + middle[1] * p[1] + middle[2] * p[2];
        let most = points.map(along).reduce(f64::max).unwrap_or_default();
        let error = |i: usize| {
            let off = (m[i] - point(middle[i])).magnitude();
            (off + point(middle[i].abs()) * point(2.0 * f64::EPSILON)) * point(self.largest[i])
        };
        point(most) + error(0) + error(1) + error(2) + point(1e-300)
    }
}

impl Object<'_> {
    /// Returns these consecutive solids.
    pub fn span(&self, begin: usize, end: usize) -> Span {
        let faces = if end == begin + 1 { [0, self.solids[begin].faces.len()] } else { [0, 0] };
        Span { solids: [begin, end], faces }
    }

    /// Returns the halves of a span; `None` for a convex solid and a single face.
    pub fn halves(&self, Span { solids: [begin, end], faces: [first, last] }: Span) -> Option<[Span; 2]> {
        if end > begin + 1 {
            let middle = begin + (end - begin) / 2;
            return Some([self.span(begin, middle), self.span(middle, end)]);
        }
        let middle = first + (last - first) / 2;
        let of = |faces| Span { solids: [begin, end], faces };
        (last > first + 1).then(|| [of([first, middle]), of([middle, last])])
    }

    /// Returns true if the span has all faces of its meshes.
    pub fn has_whole_meshes(&self, span: Span) -> bool {
        span == self.span(span.solids[0], span.solids[1])
    }

    /// Returns a measure of the work on a span.
    pub fn size(&self, span: Span) -> usize {
        let size = |solid: &Solid| 4 + solid.points.len() + solid.faces.len();
        self.solids[span.solids[0]..span.solids[1]].iter().map(size).sum()
    }

    /// Returns an upper bound of the greatest n·p over the span, in the frame of the object (4).
    pub fn support(&self, span: Span, n: Vector) -> f64 {
        let [begin, end] = span.solids;
        let faces = |solid: &Solid| if end == begin + 1 { span.faces } else { [0, solid.faces.len()] };
        let supports = self.solids[begin..end].iter().map(|solid| solid.support(n, faces(solid)));
        supports.fold(f64::NEG_INFINITY, |most, x| if x.is_nan() { f64::INFINITY } else { most.max(x) })
    }

    /// Returns a point and a radius such that all points of the span are within it (4).
    pub fn ball(&self, span: Span) -> (Vector, Interval) {
        let corners = self.solids[span.solids[0]..span.solids[1]].iter().map(|solid| solid.corners);
        let wider = |[low, high]: [Point; 2], [l, h]: [Point; 2]| {
            [std::array::from_fn(|i| low[i].min(l[i])), std::array::from_fn(|i| high[i].max(h[i]))]
        };
        let [low, high] = corners.reduce(wider).unwrap_or_default().map(|corner| corner.map(point));
        let center: Vector = std::array::from_fn(|i| point((low[i] + high[i]).middle() * 0.5));
        let off = |i: usize| (low[i] - center[i]).magnitude().max((high[i] - center[i]).magnitude());
        (center, length(std::array::from_fn(off)))
    }
}
