//! Robot, bodies, pairs, bounds, start and goals of a certificate.

use std::collections::{HashMap, HashSet};

use super::digest::sha256;
use super::interval::{IDENTITY, Interval, Matrix, ONE, ORIGIN, Vector, length, minus, point, scaled};
use super::interval::{sum, times, transposed_times};
use super::lines::{Checked, LARGEST, Lines, has_size, unless};
use super::solid::{Object, Solid};

/// Point or direction with given coordinates.
pub type Point = [f64; 3];

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
    /// Returns a point of the own frame in the other one.
    pub fn of_point(&self, p: Vector) -> Vector {
        sum(times(&self.rotation, p), self.translation)
    }

    /// Returns a point of the other frame in the own one.
    pub fn to_own(&self, p: Vector) -> Vector {
        transposed_times(&self.rotation, sum(p, minus(self.translation)))
    }
}

/// Returns the rotation of a quaternion (w, x, y, z), which is scaled to length 1 (3).
pub fn rotation([w, a, b, c]: [Interval; 4]) -> Matrix {
    let square = w.square() + a.square() + b.square() + c.square();
    let twice = |x: Interval| (x + x).over(square);
    let diagonal = |p: Interval, q: Interval| ONE - twice(p.square() + q.square());
    [
        [diagonal(b, c), twice(a * b - c * w), twice(a * c + b * w)],
        [twice(a * b + c * w), diagonal(a, c), twice(b * c - a * w)],
        [twice(a * c - b * w), twice(b * c + a * w), diagonal(a, b)],
    ]
}

/// Motion of a link by the value `factor · q[joint] + offset`, about or along a unit vector in its own frame.
pub struct Motion {
    pub turns: bool,
    pub joint: usize,
    pub factor: f64,
    pub offset: f64,
    pub axis: Vector,
}

/// Objects that are compared, the first one a link; the lowest link above both; and the distance demanded.
pub struct Pair {
    pub objects: [usize; 2],
    pub top: Option<usize>,
    pub distance: f64,
}

/// Bound on a point of a link, or on a direction of length 1, along the whole path: it stays in a box around a pose, and within
/// a distance of it (12).
#[derive(Default)]
pub struct Bound {
    pub link: usize,
    pub is_direction: bool,
    pub point: Vector,
    pub pose: Pose,
    pub half: Point,
    pub radius: f64,
}

#[derive(Default)]
pub struct Scene<'a> {
    pub name: &'a str,
    pub hash: String,
    /// Name and limits of each joint.
    pub joints: Vec<(&'a str, [f64; 2])>,
    pub objects: Vec<Object<'a>>,
    pub margin: f64,
    /// Pairs that must be proven.
    pub pairs: Vec<Pair>,
    /// Pairs with a distance of their own, or none.
    distances: HashMap<[usize; 2], Option<f64>>,
    /// Lines of these pairs, of bounds and goals, with the names of objects.
    pub rules: Vec<String>,
    pub bounds: Vec<Bound>,
    pub start: Vec<f64>,
    pub tip: usize,
    pub goals: Vec<Pose>,
}

impl<'a> Scene<'a> {
    /// Reads the lines of a scene, in their order, and compares its hash.
    pub fn read(lines: &mut Lines<'a>) -> Checked<Self> {
        let (mut scene, begin) = (Self::default(), lines.at());
        scene.name = lines.read("scene", Lines::word)?;
        while lines.is("joint") {
            let joint = |line: &mut Lines<'a>| Ok((line.word()?, [line.real()?, line.real()?]));
            scene.joints.push(lines.read("joint", joint)?);
        }
        while lines.is("link") || lines.is("body") {
            scene.read_object(lines)?;
        }
        let names: HashSet<&str> = scene.objects.iter().map(|object| object.name).collect();
        unless(names.len() == scene.objects.len(), "two objects have the same name")?;
        scene.margin = lines.read("margin", Lines::size)?;
        while lines.is("keep") || lines.is("skip") {
            scene.read_exception(lines)?;
        }
        while let Some(kind) = ["cone", "inside", "near"].into_iter().find(|kind| lines.is(kind)) {
            scene.read_bound(kind, lines)?;
        }
        scene.start = lines.read("start", |line| line.values(scene.joints.len()))?;
        scene.tip = lines.read("tip", |line| line.index(scene.objects.len()))?;
        let is_usable = !scene.joints.is_empty() && !scene.objects[scene.tip].is_body;
        unless(is_usable, "no joint, or the tip is no link")?;
        let goals = lines.at();
        while scene.goals.is_empty() || lines.is("goal") {
            scene.goals.push(lines.read("goal", |line| line.word().and_then(|_| line.pose()))?);
        }
        scene.rules.extend(lines.since(goals).lines().map(str::to_owned));
        scene.hash = sha256(lines.since(begin).as_bytes());
        unless(lines.read("hash", Lines::word)? == scene.hash, &format!("the hash is {}", scene.hash))?;
        Ok(scene)
    }

    fn read_object(&mut self, lines: &mut Lines<'a>) -> Checked {
        let begin = lines.at();
        let body = |name| Object { is_body: true, name, ..Object::default() };
        let mut object = match lines.is("link") {
            true => lines.read("link", |line| self.link(line))?,
            false => body(lines.read("body", Lines::word)?),
        };
        object.title = self.with_names(&lines.since(begin), &[2]);
        let solids = lines.at();
        while let Some(solid) = Solid::read(lines, object.is_body)? {
            object.solids.push(solid);
        }
        let above = object.parent.map_or("-", |parent| &self.objects[parent].key);
        object.key = sha256(format!("{above}\n{}\n{}", object.title, lines.since(solids)).as_bytes());
        self.objects.push(object);
        unless(self.objects.len() <= 4096, "more work than a certificate may take")
    }

    /// Returns a line with the names of objects in place of their numbers, which are these words of it.
    fn with_names(&self, line: &str, numbers: &[usize]) -> String {
        let name = |word: &str| word.parse().map_or("-", |index: usize| self.objects[index].name);
        let named = |(at, word)| if numbers.contains(&at) { name(word) } else { word };
        line.trim_end().split(' ').enumerate().map(named).collect::<Vec<_>>().join(" ")
    }

    fn link(&self, line: &mut Lines<'a>) -> Checked<Object<'a>> {
        let mut link = Object { name: line.word()?, ..Object::default() };
        if self.objects.is_empty() {
            unless(line.word()? == "-", "the first link is the root, with the parent `-`")?;
        } else {
            let parent = line.index(self.objects.len())?;
            (link.parent, link.depth) = (Some(parent), self.objects[parent].depth + 1);
        }
        unless(!self.objects.iter().any(|known| known.is_body), "links come before bodies")?;
        link.pose = line.pose()?;
        let kind = line.word()?;
        if kind != "fixed" {
            unless(kind == "turn" || kind == "slide", "a motion that is none")?;
            let (joint, factor, offset) = (line.index(self.joints.len())?, line.real()?, line.real()?);
            let is_small = |limit: f64| (factor * limit).abs() + offset.abs() <= LARGEST;
            unless(self.joints[joint].1.into_iter().all(is_small), "a link can turn or slide too far")?;
            let axis = unit(line.point()?.map(point))?;
            link.motion = Some(Motion { turns: kind == "turn", joint, factor, offset, axis });
        }
        Ok(link)
    }

    fn read_exception(&mut self, lines: &mut Lines<'a>) -> Checked {
        let (begin, objects, is_kept) = (lines.at(), self.objects.len(), lines.is("keep"));
        let (pair, distance) = lines.read(if is_kept { "keep" } else { "skip" }, |line| {
            let pair = [line.index(objects)?, line.index(objects)?];
            Ok((pair, if is_kept { Some(line.real()?) } else { line.word().map(|_| None)? }))
        })?;
        let is_new = self.distances.insert(pair, distance).is_none();
        unless(pair[0] < pair[1] && is_new, "each pair once, the lower index first")?;
        self.rules.push(self.with_names(&lines.since(begin), &[1, 2]));
        Ok(())
    }

    fn read_bound(&mut self, kind: &str, lines: &mut Lines<'a>) -> Checked {
        let (begin, objects) = (lines.at(), self.objects.len());
        let bound = lines.read(kind, |line| {
            let mut bound = Bound { half: [f64::INFINITY; 3], radius: f64::INFINITY, ..Bound::default() };
            (bound.is_direction, bound.link) =
                (kind == "cone", line.word().and_then(|_| line.index(objects))?);
            bound.point = line.point()?.map(point);
            if kind == "inside" {
                (bound.pose, bound.half) = (line.pose()?, line.point()?);
                return Ok(bound);
            }
            (bound.pose.translation, bound.radius) = (line.point()?.map(point), line.size()?);
            if bound.is_direction {
                (bound.point, bound.pose.translation) = (unit(bound.point)?, unit(bound.pose.translation)?);
                unless(bound.radius <= 3.1, "an angle out of range")?;
                bound.radius = 2.0 * point(0.5 * bound.radius).sin_cos()[0].lo;
            }
            Ok(bound)
        })?;
        unless(!self.objects[bound.link].is_body, "a bound is of a link")?;
        self.bounds.push(bound);
        self.rules.push(self.with_names(&lines.since(begin), &[2]));
        Ok(())
    }

    /// Returns the links from the one below `top` (from the root for `None`) down to `of`, the topmost first.
    pub fn chain(&self, top: Option<usize>, of: usize) -> Vec<usize> {
        let lowest = Some(of).filter(|of| !self.objects[*of].is_body);
        let upwards = std::iter::successors(lowest, |index| self.objects[*index].parent);
        let mut chain: Vec<usize> = upwards.take_while(|index| Some(*index) != top).collect();
        chain.reverse();
        chain
    }

    /// Lists the objects that only one of two scenes has, each with its first line. This one must have the robot of the other,
    /// and start at the end of its last path (13).
    pub fn changes_since(&self, (before, end): &(Self, Vec<f64>)) -> Checked<Vec<String>> {
        unless(self.start == *end, "the scene does not start where the path before it ends")?;
        let robot = |scene: &Self| (scene.joints.clone(), scene.objects[scene.tip].key.clone());
        unless(robot(self) == robot(before), "joints, or links down to the tip, are not those before (13)")?;
        let mut changes = Vec::new();
        for (sign, new, old) in [('-', before, self), ('+', self, before)] {
            let known: HashSet<&String> = old.objects.iter().map(|object| &object.key).collect();
            let tip = new.chain(None, new.tip);
            for (index, object) in new.objects.iter().enumerate().filter(|new| !known.contains(&new.1.key)) {
                let may_change = object.is_body || !new.common(&tip, index).1;
                unless(may_change, "a link that differs is moved against the tip by a joint (13)")?;
                changes.push(format!("{sign} {}", object.title));
            }
        }
        Ok(changes)
    }

    /// Returns the lowest link above an object, or equal to it, among those down to another one; and true if a joint moves both
    /// objects against each other.
    fn common(&self, above_a: &[usize], b: usize) -> (Option<usize>, bool) {
        let above_b = self.chain(None, b);
        let common = above_a.iter().zip(&above_b).take_while(|(x, y)| x == y).count();
        let mut apart = above_a[common..].iter().chain(&above_b[common..]);
        let moves = apart.any(|index| self.objects[*index].motion.is_some());
        (common.checked_sub(1).map(|last| above_a[last]), moves)
    }

    /// Lists the pairs that must be proven: all of a link and another object that a joint moves against each other.
    pub fn list_pairs(&self) -> Vec<Pair> {
        let is_solid = |index: &usize| !self.objects[*index].solids.is_empty();
        let mut pairs = Vec::new();
        for a in (0..self.objects.len()).filter(|a| is_solid(a) && !self.objects[*a].is_body) {
            let above_a = self.chain(None, a);
            for b in (a + 1..self.objects.len()).filter(is_solid) {
                let (top, moves) = self.common(&above_a, b);
                let distance = self.distances.get(&[a, b]).copied().unwrap_or(Some(self.margin));
                let pair = |distance| Pair { objects: [a, b], top, distance };
                pairs.extend(distance.filter(|_| moves).map(pair));
            }
        }
        pairs
    }
}

/// Returns the unit vector of this direction (3).
fn unit(v: Vector) -> Checked<Vector> {
    has_size(&v.map(Interval::middle)).map(|()| scaled(v, ONE.over(length(v))))
}
