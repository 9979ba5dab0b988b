//! Robot, bodies, pairs, start and goals of a certificate, and the supports of its solids.

use std::collections::{HashMap, HashSet};

use super::interval::{
    IDENTITY, Interval, Matrix, ONE, ORIGIN, Vector, dot, length, point, scaled, transposed_times,
};

/// Point or direction with given coordinates.
pub type Point = [f64; 3];

/// Maximum numbers of joints, of links and bodies together, of solids of one of them, and of links in a chain.
pub const MOST_JOINTS: usize = 256;
pub const MOST_OBJECTS: usize = 1024;
pub const MOST_SOLIDS: usize = 1024;
pub const MOST_DEPTH: usize = 128;

pub struct Joint {
    pub name: String,
    pub lower: f64,
    pub upper: f64,
}

/// Pose of one frame in another.
#[derive(Clone, Copy)]
pub struct Pose {
    pub rotation: Matrix,
    pub translation: Vector,
}

impl Default for Pose {
    fn default() -> Self {
        Self { rotation: IDENTITY, translation: ORIGIN }
    }
}

impl Pose {
    /// Returns the pose of a translation and a quaternion (w, x, y, z), which is scaled to length 1 (3).
    pub fn of([x, y, z, w, a, b, c]: [f64; 7]) -> Option<Self> {
        let [w, a, b, c] = [w, a, b, c].map(point);
        let square = w.square() + a.square() + b.square() + c.square();
        let twice = |x: Interval| (point(2.0) * x).over(square);
        let diagonal = |p: Interval, q: Interval| ONE - twice(p.square() + q.square());
        let rotation = [
            [diagonal(b, c), twice(a * b - c * w), twice(a * c + b * w)],
            [twice(a * b + c * w), diagonal(a, c), twice(b * c - a * w)],
            [twice(a * c - b * w), twice(b * c + a * w), diagonal(a, b)],
        ];
        let is_near_1 = square.lo > 1e-6 && square.hi < 1e6;
        is_near_1.then_some(Self { rotation, translation: [x, y, z].map(point) })
    }
}

/// Motion of a link by the value `factor · q[joint] + offset`, about or along a unit vector in its own frame.
pub struct Motion {
    pub turns: bool,
    pub joint: usize,
    pub factor: f64,
    pub offset: f64,
    pub axis: Vector,
}

pub enum Shape {
    Box(Point),
    /// Half length along z, and radius.
    Capsule([f64; 2]),
    Cylinder([f64; 2]),
    HalfSpace,
    /// Convex hull of the points, grown by the radius.
    Hull {
        points: Vec<Point>,
        radius: f64,
    },
    /// Surface of triangles, and all that it seals off.
    Mesh {
        points: Vec<Point>,
        faces: Vec<[usize; 3]>,
    },
}

pub struct Solid {
    pub pose: Pose,
    pub shape: Shape,
    /// Greatest magnitude of each coordinate of the points.
    largest: Point,
}

/// A link, or a body of the world.
#[derive(Default)]
pub struct Object {
    pub name: String,
    pub is_body: bool,
    /// For a link: its parent, how many are above it, its pose in the parent, and its motion.
    pub parent: Option<usize>,
    pub depth: usize,
    pub pose: Pose,
    pub motion: Option<Motion>,
    /// Its lines.
    pub text: String,
    pub solids: Vec<Solid>,
    /// For each solid a box around it, its lower and upper corner.
    pub boxes: Vec<[Point; 2]>,
}

/// Consecutive solids of an object, or consecutive faces of one mesh.
#[derive(Clone, Copy, PartialEq)]
pub struct Span {
    pub solids: [usize; 2],
    pub faces: [usize; 2],
}

#[derive(Default)]
pub struct Scene {
    pub name: String,
    pub joints: Vec<Joint>,
    pub objects: Vec<Object>,
    pub margin: f64,
    /// Pairs with a distance of their own, or none.
    pub exceptions: HashMap<(usize, usize), Option<f64>>,
    pub start: Vec<f64>,
    pub tip: usize,
    pub goals: Vec<Pose>,
    /// Pairs that are compared, in order, with the distance demanded.
    pub pairs: Vec<((usize, usize), f64)>,
}

impl Solid {
    pub fn new(pose: Pose, shape: Shape) -> Self {
        let mut solid = Self { pose, shape, largest: [0.0; 3] };
        let most = |i: usize| solid.points().iter().fold(0.0, |most: f64, p| most.max(p[i].abs()));
        solid.largest = [most(0), most(1), most(2)];
        solid
    }

    fn points(&self) -> &[Point] {
        if let Shape::Hull { points, .. } | Shape::Mesh { points, .. } = &self.shape { points } else { &[] }
    }

    pub fn faces(&self) -> usize {
        if let Shape::Mesh { faces, .. } = &self.shape { faces.len() } else { 0 }
    }

    /// Returns an upper bound of the greatest n·p over the solid, or these faces of it, in the frame of the object (4).
    fn support(&self, n: Vector, faces: [usize; 2]) -> f64 {
        let m = transposed_times(&self.pose.rotation, n);
        let local = match &self.shape {
            Shape::Box([x, y, z]) => dot(m.map(Interval::magnitude), [*x, *y, *z].map(point)),
            Shape::Capsule([half, radius]) => m[2].magnitude() * point(*half) + length(m) * point(*radius),
            Shape::Cylinder([half, radius]) => {
                let across = length([m[0], m[1], point(0.0)]);
                m[2].magnitude() * point(*half) + across * point(*radius)
            }
            Shape::HalfSpace => return f64::INFINITY,
            Shape::Hull { points, radius } => self.farthest(m, points.iter()) + length(m) * point(*radius),
            Shape::Mesh { points, faces: all } if faces == [0, all.len()] => self.farthest(m, points.iter()),
            Shape::Mesh { points, faces: all } => {
                self.farthest(m, all[faces[0]..faces[1]].iter().flatten().map(|index| &points[*index]))
            }
        };
        (local + dot(n, self.pose.translation)).hi
    }

    /// Returns a number that is at least m·p for each of the points: the greatest value in plain `f64`, and its error (4), which
    /// is unknown if m is.
    fn farthest<'a>(&self, m: Vector, points: impl Iterator<Item = &'a Point>) -> Interval {
        let middle = m.map(Interval::middle);
        let along = |p: &Point| middle[0] * p[0] + middle[1] * p[1] + middle[2] * p[2];
        let mut most = f64::NEG_INFINITY;
        for value in points.map(along) {
            most = most.max(value);
        }
        let error = |i: usize| {
            let off = (m[i] - point(middle[i])).magnitude();
            (off + point(middle[i].abs()) * point(2.0 * f64::EPSILON)) * point(self.largest[i])
        };
        point(most) + error(0) + error(1) + error(2) + point(1e-300)
    }
}

impl Object {
    pub fn has_mesh(&self) -> bool {
        self.solids.iter().any(|solid| solid.faces() > 0)
    }

    pub fn whole(&self) -> Span {
        self.span(0, self.solids.len())
    }

    fn span(&self, begin: usize, end: usize) -> Span {
        let faces = if end == begin + 1 { self.solids[begin].faces() } else { 0 };
        Span { solids: [begin, end], faces: [0, faces] }
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
    pub fn size(&self, span: Span) -> u64 {
        let size = |solid: &Solid| 4 + solid.points().len() + solid.faces();
        self.solids[span.solids[0]..span.solids[1]].iter().map(size).sum::<usize>() as u64
    }

    pub fn support(&self, span: Span, n: Vector) -> f64 {
        let [begin, end] = span.solids;
        let support = |solid: &Solid| {
            let support = solid.support(n, if end == begin + 1 { span.faces } else { [0, solid.faces()] });
            if support.is_nan() { f64::INFINITY } else { support }
        };
        self.solids[begin..end].iter().map(support).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Returns a point and a radius such that all points of the span are within it (4).
    pub fn ball(&self, span: Span) -> (Point, Interval) {
        let [mut low, mut high] = self.boxes[span.solids[0]];
        for [l, h] in &self.boxes[span.solids[0]..span.solids[1]] {
            low = std::array::from_fn(|i| low[i].min(l[i]));
            high = std::array::from_fn(|i| high[i].max(h[i]));
        }
        let center: Point = std::array::from_fn(|i| 0.5 * (low[i] + high[i]));
        let off = |i: usize, end: f64| (point(end) - point(center[i])).magnitude();
        (center, length(std::array::from_fn(|i| off(i, low[i]).max(off(i, high[i])))))
    }

    /// Adds a solid and the box around it, and returns true; false if it is not allowed.
    pub fn add(&mut self, solid: Solid) -> bool {
        let corner = |sign: f64| {
            let axis = |i: usize| std::array::from_fn(|j| point(if i == j { sign } else { 0.0 }));
            std::array::from_fn(|i| sign * solid.support(axis(i), [0, solid.faces()]))
        };
        let corners: [Point; 2] = [corner(-1.0), corner(1.0)];
        let is_bounded = corners.iter().flatten().all(|x| x.abs() <= 1e9);
        let is_floor = matches!(solid.shape, Shape::HalfSpace) && self.is_body;
        let is_mesh = matches!(solid.shape, Shape::Mesh { .. });
        let is_allowed = (is_bounded || is_floor) && is_mesh == (solid.faces() > 0);
        if is_allowed && self.solids.len() < MOST_SOLIDS {
            self.solids.push(solid);
            self.boxes.push(corners);
            return true;
        }
        false
    }
}

impl Scene {
    /// Returns the links from the one below `top` (from the root for `None`) down to `of`, the topmost first.
    pub fn chain(&self, top: Option<usize>, of: usize) -> Vec<usize> {
        let mut chain = Vec::new();
        let mut next = Some(of).filter(|of| !self.objects[*of].is_body);
        while let Some(index) = next.filter(|_| next != top) {
            chain.push(index);
            next = self.objects[index].parent;
        }
        chain.reverse();
        chain
    }

    /// Returns the lowest link above both or equal to one of them; `None` for the world.
    pub fn common(&self, a: usize, b: usize) -> Option<usize> {
        let (a, b) = (self.chain(None, a), self.chain(None, b));
        a.iter().zip(&b).take_while(|(x, y)| x == y).last().map(|(x, _)| *x)
    }

    /// Lists the objects that another scene has not, or with other lines.
    pub fn changes_since(&self, before: &Self) -> Vec<String> {
        let new = |new: &Self, old: &Self, sign: char| {
            let lines: HashSet<&str> = old.objects.iter().map(|object| &object.text[..]).collect();
            let is_new = |object: &&Object| !lines.contains(&object.text[..]);
            new.objects
                .iter()
                .filter(is_new)
                .map(|object| format!("{sign} {}", object.name))
                .collect::<Vec<_>>()
        };
        [new(before, self, '-'), new(self, before, '+')].concat()
    }

    /// Lists the pairs that must be proven: all of a link and another object that a joint moves against each other.
    pub fn list_pairs(&mut self) {
        for a in (0..self.objects.len()).filter(|a| !self.objects[*a].is_body) {
            for b in a + 1..self.objects.len() {
                let top = self.common(a, b);
                let is_moved =
                    |end: &usize| self.chain(top, *end).iter().any(|i| self.objects[*i].motion.is_some());
                let has_solids = |end: &usize| !self.objects[*end].solids.is_empty();
                let distance = self.exceptions.get(&(a, b)).copied().unwrap_or(Some(self.margin));
                if let Some(distance) =
                    distance.filter(|_| [a, b].iter().all(has_solids) && [a, b].iter().any(is_moved))
                {
                    self.pairs.push(((a, b), distance));
                }
            }
        }
    }
}

/// Returns the unit vector of this direction (3).
pub fn unit(direction: Point) -> Option<Vector> {
    let v = direction.map(point);
    let long = length(v);
    (long.lo > 1e-3 && long.hi < 1e3).then(|| scaled(v, ONE.over(long)))
}
