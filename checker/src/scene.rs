//! Robot, bodies, pairs, bounds, start and goals of a certificate.

use std::collections::{HashMap, HashSet};

use super::digest::sha256;
use super::interval::{IDENTITY, Interval, Matrix, ONE, ORIGIN, Vector, length, point, scaled};
use super::lines::{Checked, Lines, unless};
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
    /// Limits of each joint.
    pub limits: Vec<[f64; 2]>,
    pub objects: Vec<Object<'a>>,
    pub margin: f64,
    /// Pairs that must be proven.
    pub pairs: Vec<Pair>,
    /// Pairs with a distance of their own, or none; and their lines with names.
    distances: HashMap<[usize; 2], Option<f64>>,
    pub exceptions: Vec<String>,
    pub bounds: Vec<Bound>,
    pub start: Vec<f64>,
    pub tip: usize,
    pub goals: Vec<Pose>,
}

impl<'a> Scene<'a> {
    /// Reads the lines of a scene, in their order, and compares its hash.
    pub fn read(lines: &mut Lines<'a>) -> Checked<Self> {
        let (mut scene, begin) = (Self::default(), lines.begin);
        scene.name = lines.read("scene", Lines::word)?;
        while lines.is("joint") {
            let limits =
                |line: &mut Lines<'a>| line.word().and_then(|_| Ok([line.number()?, line.number()?]));
            scene.limits.push(lines.read("joint", limits)?);
        }
        while lines.is("link") || lines.is("body") {
            scene.read_object(lines)?;
        }
        scene.margin = lines.read("margin", Lines::size)?;
        while lines.is("keep") || lines.is("skip") {
            scene.read_exception(lines)?;
        }
        while let Some(kind) = ["cone", "inside", "near"].into_iter().find(|kind| lines.is(kind)) {
            scene.read_bound(kind, lines)?;
        }
        scene.start = lines.read("start", |line| line.values(scene.limits.len()))?;
        scene.tip = lines.read("tip", |line| line.index(scene.objects.len()))?;
        let is_usable = !scene.limits.is_empty() && !scene.objects[scene.tip].is_body;
        unless(is_usable, "no joint, or the tip is no link")?;
        while scene.goals.is_empty() || lines.is("goal") {
            let goal = |line: &mut Lines<'a>| line.word().and_then(|_| line.pose());
            scene.goals.push(lines.read("goal", goal)?);
        }
        scene.hash = sha256(lines.since(begin).as_bytes());
        let stated = lines.read("hash", Lines::word)?;
        unless(stated == scene.hash, &format!("the scene has the hash {}", scene.hash))?;
        Ok(scene)
    }

    fn read_object(&mut self, lines: &mut Lines<'a>) -> Checked {
        let begin = lines.begin;
        let mut object = if lines.is("link") {
            lines.read("link", |line| self.link(line))?
        } else {
            Object { is_body: true, name: lines.read("body", Lines::word)?, ..Object::default() }
        };
        while let Some(solid) = Solid::read(lines, object.is_body)? {
            object.solids.push(solid);
        }
        object.text = lines.since(begin);
        self.objects.push(object);
        Ok(())
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
            let (joint, factor, offset) = (line.index(self.limits.len())?, line.number()?, line.number()?);
            let axis = unit(line.point()?.map(point))?;
            link.motion = Some(Motion { turns: kind == "turn", joint, factor, offset, axis });
        }
        Ok(link)
    }

    fn read_exception(&mut self, lines: &mut Lines<'a>) -> Checked {
        let (begin, objects, is_kept) = (lines.begin, self.objects.len(), lines.is("keep"));
        let (pair, distance) = lines.read(if is_kept { "keep" } else { "skip" }, |line| {
            let pair = [line.index(objects)?, line.index(objects)?];
            Ok((pair, if is_kept { Some(line.number()?) } else { line.word().map(|_| None)? }))
        })?;
        let is_new = self.distances.insert(pair, distance).is_none();
        unless(pair[0] < pair[1] && is_new, "each pair once, the lower index first")?;
        let words: Vec<&str> = lines.since(begin).trim_end().split(' ').collect();
        let [a, b] = pair.map(|index| self.objects[index].name);
        self.exceptions.push(format!("{} {a} {b} {}", words[0], words[3]));
        Ok(())
    }

    fn read_bound(&mut self, kind: &str, lines: &mut Lines<'a>) -> Checked {
        let (begin, objects) = (lines.begin, self.objects.len());
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
        self.exceptions.push(lines.since(begin).trim_end().to_owned());
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

    /// Lists the objects that another scene has not, or with other lines.
    pub fn changes_since(&self, before: &Self) -> Vec<String> {
        let new = |new: &Self, old: &Self, sign: char| {
            let lines: HashSet<&str> = old.objects.iter().map(|object| object.text).collect();
            let is_new = |object: &&Object<'_>| !lines.contains(object.text);
            let named = |object: &Object<'_>| format!("{sign} {}", object.name);
            new.objects.iter().filter(is_new).map(named).collect::<Vec<_>>()
        };
        [new(before, self, '-'), new(self, before, '+')].concat()
    }

    /// Lists the pairs that must be proven: all of a link and another object that a joint moves against each other.
    pub fn list_pairs(&self) -> Vec<Pair> {
        let is_solid = |index: &usize| !self.objects[*index].solids.is_empty();
        let is_moved = |index: &usize| self.objects[*index].motion.is_some();
        let mut pairs = Vec::new();
        for a in (0..self.objects.len()).filter(|a| is_solid(a) && !self.objects[*a].is_body) {
            let above_a = self.chain(None, a);
            for b in (a + 1..self.objects.len()).filter(is_solid) {
                let above_b = self.chain(None, b);
                let common = above_a.iter().zip(&above_b).take_while(|(x, y)| x == y).count();
                let top = common.checked_sub(1).map(|last| above_a[last]);
                let moves = above_a[common..].iter().chain(&above_b[common..]).any(is_moved);
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
    let long = length(v);
    unless(long.lo > 1e-3 && long.hi < 1e3, "an axis has a length near 1")?;
    Ok(scaled(v, ONE.over(long)))
}
