//! Proof of one piece of a path: a Bézier curve in the joints, and for each pair a tree of intervals and planes.

use std::collections::{HashMap, HashSet};
use std::rc::Rc;

use super::interval::{
    Interval, ONE, ORIGIN, Vector, ZERO, cross, dot, length, minus, point, product, scaled, sum, times,
    transposed_times,
};
use super::scene::{Object, Pose, Scene, Shape, Span};

/// Control points of a curve, one interval for each joint.
type Curve = Vec<Vec<Interval>>;

/// Maximum number of control points of a piece, and of halvings above a plane, of which of the interval.
pub const MOST_POINTS: usize = 16;
const MOST_HALVINGS: usize = 96;
const MOST_DEPTH: u32 = 60;

/// Maximum work on a certificate, in operations of some ten nanoseconds, and number of instants that are remembered.
const MOST_WORK: u64 = 2_000_000_000;
const MOST_MOMENTS: usize = 4096;

/// Joint in the middle of an interval, with bounds along it (5).
struct JointState {
    value: Interval,
    rate: Interval,
    fastest: Interval,
    bend: Interval,
}

/// Robot in the middle of an interval: joints, and the pose of each link in its parent.
struct Moment {
    joints: Vec<JointState>,
    links: Vec<Pose>,
}

/// Part of an object along an interval, in a common frame: pose in the middle, velocity there of the point `center`, angular
/// velocity, and a bound on the acceleration of its points (6).
struct Moved {
    pose: Pose,
    center: Vector,
    velocity: Vector,
    turn: Vector,
    acceleration: Interval,
}

/// Node of a tree: interval by depth and number, and a part of each object.
struct Node {
    curve: Rc<Curve>,
    depth: u32,
    number: u64,
    spans: [Span; 2],
    halvings: usize,
}

/// Fault of a proof, in words.
type Fault = String;

fn unless(holds: bool, reason: &str) -> Result<(), Fault> {
    if holds { Ok(()) } else { Err(reason.to_owned()) }
}

/// Work that was done, and planes that were evaluated.
#[derive(Clone, Copy, Debug, Default)]
pub struct Effort {
    work: u64,
    pub planes: u64,
}

impl Effort {
    /// Counts work, and fails beyond the limit.
    pub fn add(&mut self, work: u64) -> Result<(), Fault> {
        self.work = self.work.saturating_add(work);
        unless(self.work <= MOST_WORK, "more work than a certificate may take")
    }
}

/// Solids of pairs of objects of which some plane of the path has one on either side (9).
#[derive(Default)]
pub struct Outside(HashSet<[usize; 4]>);

/// Piece of a path.
pub struct Piece<'a> {
    scene: &'a Scene,
    whole: Rc<Curve>,
    moments: HashMap<(u32, u64), Rc<Moment>>,
}

impl<'a> Piece<'a> {
    pub fn new(scene: &'a Scene, points: &[Vec<f64>]) -> Self {
        let curve = points.iter().map(|q| q.iter().map(|x| point(*x)).collect()).collect();
        Self { scene, whole: Rc::new(curve), moments: HashMap::new() }
    }

    /// Returns the pose of a link in the world at the end of the piece.
    pub fn pose_at_end(&self, link: usize) -> Pose {
        let end = self.whole.last().cloned().unwrap_or_default();
        let moment = Moment::of(self.scene, &vec![end.clone(), end]);
        let whole = Span { solids: [0, 0], faces: [0, 0] };
        self.moved(&moment, None, link, whole, true).pose
    }

    /// Checks the proof of a pair, a tree of marks in prefix order (8): `h` halves the interval, `a` and `b` one of the objects,
    /// three whole numbers are a plane, `~` the same plane as before, `=` the plane of a half-space.
    pub fn check(
        &mut self,
        ((a, b), margin): ((usize, usize), f64),
        marks: &str,
        outside: &mut Outside,
        effort: &mut Effort,
    ) -> Result<(), Fault> {
        let objects = [&self.scene.objects[a], &self.scene.objects[b]];
        let (spans, curve) = (objects.map(Object::whole), self.whole.clone());
        let mut open = vec![Node { curve, depth: 0, number: 0, spans, halvings: 0 }];
        let mut plane = None;
        for mark in marks.split(' ') {
            effort.add(10)?;
            let Some(node) = open.pop() else { return Err("more marks than the proof has nodes".to_owned()) };
            let halvings = node.halvings + 1;
            unless(halvings <= MOST_HALVINGS && node.depth <= MOST_DEPTH, "too many halvings")?;
            match mark {
                "h" => {
                    let [first, second] = halves(&node.curve).map(Rc::new);
                    let (depth, number) = (node.depth + 1, 2 * node.number);
                    open.push(Node { curve: second, depth, number: number + 1, halvings, ..node });
                    open.push(Node { curve: first, depth, number, halvings, ..node });
                }
                "a" | "b" => {
                    let side = usize::from(mark == "b");
                    let parts =
                        objects[side].halves(node.spans[side]).ok_or("a part that cannot be halved")?;
                    for part in parts.into_iter().rev() {
                        let mut spans = node.spans;
                        spans[side] = part;
                        open.push(Node { curve: node.curve.clone(), spans, halvings, ..node });
                    }
                }
                _ => {
                    if mark != "~" && mark != "=" {
                        plane = Some(normal(mark).ok_or("a mark that is none")?);
                    }
                    unless(mark == "=" || plane.is_some(), "no plane before")?;
                    let is_whole = (0..2).all(|side| objects[side].has_whole_meshes(node.spans[side]));
                    unless(margin >= 0.0 || is_whole, "an allowed overlap needs planes for whole meshes")?;
                    self.separates([a, b], margin, &node, plane.filter(|_| mark != "="), effort)?;
                    if is_whole && objects.iter().any(|object| object.has_mesh()) {
                        outside.mark([a, b], node.spans, effort)?;
                    }
                }
            }
        }
        unless(open.is_empty(), "the proof ends before it covers the piece")
    }

    /// Checks inequality (7): a plane, or that of a half-space, keeps both parts apart by the margin along the interval.
    fn separates(
        &mut self,
        [a, b]: [usize; 2],
        margin: f64,
        node: &Node,
        plane: Option<Vector>,
        effort: &mut Effort,
    ) -> Result<(), Fault> {
        let (scene, [span_a, span_b]) = (self.scene, node.spans);
        let [of_a, of_b] = [&scene.objects[a], &scene.objects[b]];
        effort.planes += 1;
        let joints = 100 * (of_a.depth + of_b.depth + 2) as u64;
        effort.add(joints + 2 * (of_a.size(span_a) + of_b.size(span_b)))?;
        let moment = self.moment(node, effort)?;
        let top = scene.common(a, b);
        let first = self.moved(&moment, top, a, span_a, false);
        let second = self.moved(&moment, top, b, span_b, false);
        let solid = &of_b.solids[span_b.solids[0]];
        let is_floor = matches!(solid.shape, Shape::HalfSpace) && span_b.solids[1] == span_b.solids[0] + 1;
        unless(plane.is_some() || is_floor, "no half-space")?;
        // The normal points from the first part to the second, so into the half-space.
        let up = solid.pose.rotation.map(|row| row[2]);
        let n = plane.unwrap_or(minus(up));
        let bend = (first.acceleration + second.acceleration) * point(0.125);
        let needed = length(n) * (point(margin) + bend);
        for s in [-0.5, 0.5].map(point) {
            let of_b = match plane {
                Some(_) => second.reach(of_b, span_b, minus(n), s),
                None => dot(up, solid.pose.translation),
            };
            let gap = -(first.reach(of_a, span_a, n, s) + of_b);
            if !(gap.lo > needed.hi) {
                let [a, b] = [a, b].map(|index| &scene.objects[index].name);
                let by = (needed.hi - gap.lo) / length(n).hi;
                return Err(format!("the plane does not keep {a} and {b} apart: {by:e} m are missing"));
            }
        }
        Ok(())
    }

    fn moment(&mut self, node: &Node, effort: &mut Effort) -> Result<Rc<Moment>, Fault> {
        let key = (node.depth, node.number);
        if !self.moments.contains_key(&key) {
            effort.add(100 * self.scene.objects.len() as u64)?;
            if self.moments.len() >= MOST_MOMENTS {
                self.moments.clear();
            }
        }
        let of = || Rc::new(Moment::of(self.scene, &node.curve));
        Ok(self.moments.entry(key).or_insert_with(of).clone())
    }

    /// Computes the motion of a part of an object relative to the link `top`, or only its pose if it is to stand still (6).
    fn moved(&self, moment: &Moment, top: Option<usize>, of: usize, span: Span, is_still: bool) -> Moved {
        let (mut pose, mut before, mut movers) = (Pose::default(), ZERO, Vec::new());
        for index in self.scene.chain(top, of) {
            pose = after(&pose, &moment.links[index]);
            if let Some(motion) = &self.scene.objects[index].motion {
                let (state, factor) = (&moment.joints[motion.joint], point(motion.factor));
                let fastest = state.fastest * factor.magnitude();
                movers.push((motion, pose, state, fastest, before));
                before = if motion.turns { before + fastest } else { before };
            }
        }
        let mut moved = Moved { pose, center: ORIGIN, velocity: ORIGIN, turn: ORIGIN, acceleration: ZERO };
        if is_still || movers.is_empty() {
            return moved;
        }
        let (center, radius) = self.scene.objects[of].ball(span);
        moved.center = sum(times(&pose.rotation, center.map(point)), pose.translation);
        let (mut beyond, two) = (ZERO, point(2.0));
        for (motion, pose, state, fastest, before) in movers.into_iter().rev() {
            let axis = times(&pose.rotation, motion.axis);
            let [rate, bend] = [state.rate * point(motion.factor), state.bend * point(motion.factor.abs())];
            if motion.turns {
                let arm = cross(axis, sum(moved.center, minus(pose.translation)));
                let reach = length(arm) + radius + point(0.5) * beyond;
                moved.velocity = sum(moved.velocity, scaled(arm, rate));
                moved.turn = sum(moved.turn, scaled(axis, rate));
                let turning = fastest * (fastest + two * before) + bend;
                moved.acceleration = moved.acceleration + reach * turning;
                beyond = beyond + fastest * reach;
            } else {
                moved.velocity = sum(moved.velocity, scaled(axis, rate));
                moved.acceleration = moved.acceleration + two * fastest * before + bend;
                beyond = beyond + fastest;
            }
        }
        moved
    }
}

impl Moved {
    /// Returns an interval whose upper end bounds n·(p + s·p') over the part (7).
    fn reach(&self, object: &Object, span: Span, n: Vector, s: Interval) -> Interval {
        let turned = scaled(cross(n, self.turn), s);
        let along = sum(n, turned);
        let local = object.support(span, transposed_times(&self.pose.rotation, along));
        point(local) + dot(along, self.pose.translation) + s * dot(n, self.velocity)
            - dot(turned, self.center)
    }
}

impl Moment {
    fn of(scene: &Scene, curve: &Curve) -> Self {
        let degree = curve.len() - 1;
        let factor = point(degree as f64);
        let factors = (factor, factor * point(degree as f64 - 1.0));
        let [left, right] = halves(curve);
        let difference = |a: &Vec<Interval>, b: &Vec<Interval>| {
            b.iter().zip(a).map(|(b, a)| *b - *a).collect::<Vec<Interval>>()
        };
        let steps: Curve = curve.windows(2).map(|pair| difference(&pair[0], &pair[1])).collect();
        let bends: Curve = steps.windows(2).map(|pair| difference(&pair[0], &pair[1])).collect();
        let rates = difference(&left[degree - 1], &right[1]);
        let most =
            |rows: &Curve, joint: usize| rows.iter().fold(ZERO, |most, row| most.max(row[joint].magnitude()));
        let state = |joint: usize| JointState {
            value: right[0][joint],
            rate: factor * rates[joint],
            fastest: factors.0 * most(&steps, joint),
            bend: factors.1 * most(&bends, joint),
        };
        let joints: Vec<JointState> = (0..rates.len()).map(state).collect();
        let links = scene.objects.iter().map(|object| local(object, &joints)).collect();
        Self { joints, links }
    }
}

impl Outside {
    /// Notes that a plane has these solids of two objects on either side.
    fn mark(&mut self, [a, b]: [usize; 2], spans: [Span; 2], effort: &mut Effort) -> Result<(), Fault> {
        let [of_a, of_b] = spans.map(|span| span.solids[0]..span.solids[1]);
        for i in of_a {
            for j in of_b.clone() {
                effort.add(if self.0.insert([a, b, i, j]) { 1000 } else { 20 })?;
            }
        }
        Ok(())
    }

    /// Fails unless each solid and each mesh that are compared are on either side of some plane of the path (9).
    pub fn check(&self, scene: &Scene, effort: &mut Effort) -> Result<(), Fault> {
        for ((a, b), _) in &scene.pairs {
            let objects = [&scene.objects[*a], &scene.objects[*b]];
            if !objects.iter().any(|object| object.has_mesh()) {
                continue;
            }
            for (i, of_a) in objects[0].solids.iter().enumerate() {
                for (j, of_b) in objects[1].solids.iter().enumerate() {
                    effort.add(1)?;
                    let is_outside = of_a.faces() + of_b.faces() == 0 || self.0.contains(&[*a, *b, i, j]);
                    unless(is_outside, "no plane shows that two objects are not inside each other")?;
                }
            }
        }
        Ok(())
    }
}

/// Returns both halves of a curve (5).
fn halves(curve: &Curve) -> [Curve; 2] {
    let mut points = curve.clone();
    let (mut first, mut second) = (Vec::new(), Vec::new());
    while let (Some(begin), Some(end)) = (points.first().cloned(), points.last().cloned()) {
        first.push(begin);
        second.push(end);
        let middle =
            |a: &[Interval], b: &[Interval]| a.iter().zip(b).map(|(a, b)| (*a + *b) * point(0.5)).collect();
        points = points.windows(2).map(|pair| middle(&pair[0], &pair[1])).collect();
    }
    second.reverse();
    [first, second]
}

/// Reads a plane: three whole numbers of 16 bits, not all zero.
fn normal(mark: &str) -> Option<Vector> {
    let whole = |x: &str| x.parse().ok().filter(|_| !x.starts_with('+'));
    let n: Vec<i16> = mark.split(',').map(whole).collect::<Option<_>>()?;
    let n: [i16; 3] = n.try_into().ok()?;
    (n != [0; 3]).then(|| n.map(|x| point(f64::from(x))))
}

fn after(first: &Pose, second: &Pose) -> Pose {
    let translation = sum(first.translation, times(&first.rotation, second.translation));
    Pose { rotation: product(&first.rotation, &second.rotation), translation }
}

/// Returns the pose of a link in its parent (3).
fn local(object: &Object, joints: &[JointState]) -> Pose {
    let Some(motion) = &object.motion else { return object.pose };
    let value = joints[motion.joint].value * point(motion.factor) + point(motion.offset);
    let [x, y, z] = motion.axis;
    let mut moved = Pose::default();
    if motion.turns {
        let [sine, cosine] = value.sin_cos();
        let rest = ONE - cosine;
        moved.rotation = [
            [cosine + rest * x * x, rest * x * y - sine * z, rest * x * z + sine * y],
            [rest * x * y + sine * z, cosine + rest * y * y, rest * y * z - sine * x],
            [rest * x * z - sine * y, rest * y * z + sine * x, cosine + rest * z * z],
        ];
    } else {
        moved.translation = scaled(motion.axis, value);
    }
    after(&object.pose, &moved)
}
