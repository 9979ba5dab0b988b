//! Reading of a certificate, line by line. Nothing is allocated by a count that the file states.

use super::digest::sha256;
use super::interval::{Interval, ZERO, dot, minus, point, sum};
use super::proof::{Effort, MOST_POINTS, Outside, Piece};
use super::scene::{
    Joint, MOST_DEPTH, MOST_JOINTS, MOST_OBJECTS, Motion, Object, Pose, Scene, Shape, Solid, unit,
};

/// Content of a certificate that holds.
#[derive(Debug, Default)]
pub struct Certified {
    pub scenes: Vec<CertifiedScene>,
    /// Number of planes that were evaluated.
    pub planes: u64,
    effort: Effort,
}

/// Scene, with the numbers of its paths, of their pieces, and of the pairs that are compared.
#[derive(Debug)]
pub struct CertifiedScene {
    pub name: String,
    pub hash: String,
    pub margin_m: f64,
    pub paths: usize,
    pub pieces: usize,
    pub pairs: usize,
    /// Pairs that are not compared, those with a distance of their own, and objects that differ from the scene before.
    pub exceptions: Vec<String>,
}

/// First line at which a certificate fails, from 1.
#[derive(Clone, Debug)]
pub struct Refusal {
    pub line: usize,
    pub reason: String,
    /// True if the line is not of the format; false if it is, and does not hold.
    pub is_malformed: bool,
}

/// Greatest magnitude of a number, and tolerances: start of a path in each joint, and position of the tip at its end.
const LARGEST: f64 = 1e6;
const START_TOLERANCE: f64 = 1e-5;
const GOAL_TOLERANCE_M: f64 = 1e-3;
/// Trace of a rotation by one degree, 1 + 2 cos 1°, rounded up.
const GOAL_TRACE: f64 = 2.999695390312783;

/// Fault of a line: its reason, and whether it is malformed.
struct Fault(String, bool);

type Checked<T = ()> = Result<T, Fault>;

/// A claim that does not hold.
impl From<String> for Fault {
    fn from(reason: String) -> Self {
        Self(reason, false)
    }
}

fn malformed(reason: &str) -> Fault {
    Fault(reason.to_owned(), true)
}

fn unless(holds: bool, reason: &str) -> Checked {
    if holds { Ok(()) } else { Err(malformed(reason)) }
}

/// Checks a certificate: returns its content, or the first line that fails.
///
/// # Errors
/// [`Refusal`] for a certificate that is malformed or does not hold.
pub fn check(text: &str) -> Result<Certified, Refusal> {
    let mut line = 0;
    let refusal = |(Fault(reason, is_malformed), line)| Refusal { line, reason, is_malformed };
    certified(text, &mut line).map_err(|fault| refusal((fault, line.max(1))))
}

/// Reads scenes, each with its paths. `number` is the line that is being read.
fn certified(text: &str, number: &mut usize) -> Checked<Certified> {
    let mut read = 0;
    let mut lines = text.split_inclusive('\n').map(|line| {
        *number += 1;
        read += line.len();
        line.strip_suffix('\n')
            .map(|words| (words, read - line.len()))
            .ok_or(malformed("a line without an end"))
    });
    let ended = || malformed("the certificate ends before its `end`");
    let mut next = || -> Checked<(&str, usize)> { lines.next().ok_or_else(ended)? };
    unless(next()?.0 == "cranny-certificate/1", "the format is not `cranny-certificate/1`")?;
    let mut found = Certified::default();
    let mut before: Option<(Scene, Vec<f64>)> = None;
    let (mut line, mut begin) = next()?;
    loop {
        let mut draft = Draft::default();
        let hash = loop {
            draft.line(line)?;
            let at;
            (line, at) = next()?;
            if let Some(stated) = line.strip_prefix("hash ") {
                let hash = sha256(&text.as_bytes()[begin..at]);
                if stated != hash {
                    return Err(format!("the scene has the hash {hash}").into());
                }
                break hash;
            }
        };
        // Pairs are listed.
        found.effort.add(50 * (draft.scene.objects.len() as u64).pow(2))?;
        let (scene, mut exceptions) = draft.finished()?;
        if let Some((before, end)) = &before {
            unless(scene.start == *end, "the scene does not start where the path before it ends")?;
            exceptions.extend(scene.changes_since(before));
        }
        let mut along = Along { effort: found.effort, ..Along::new(&scene) };
        loop {
            (line, begin) = next()?;
            if line == "end" || line.starts_with("scene ") {
                break;
            }
            along.line(line)?;
        }
        along.end_path()?;
        unless(along.paths > 0, "no path")?;
        let Along { paths, pieces, effort, last, .. } = along;
        let (name, pairs, margin_m) = (scene.name.clone(), scene.pairs.len(), scene.margin);
        found.scenes.push(CertifiedScene { name, hash, margin_m, paths, pieces, pairs, exceptions });
        (found.effort, before) = (effort, Some((scene, last)));
        if line == "end" {
            break;
        }
    }
    unless(text.len() == begin + "end\n".len(), "a line after the end")?;
    found.planes = found.effort.planes;
    Ok(found)
}

fn number(word: &str) -> Checked<f64> {
    let number = word.parse::<f64>().ok().filter(|x| x.abs() <= LARGEST && word.len() <= 32);
    number.ok_or(malformed("a number that is none, or too large"))
}

fn numbers<const N: usize>(words: &[&str]) -> Checked<[f64; N]> {
    let numbers = words.iter().map(|word| number(word)).collect::<Checked<Vec<f64>>>()?;
    numbers.try_into().map_err(|_| malformed("another count of numbers is expected"))
}

fn index(word: &str, below: usize) -> Checked<usize> {
    let is_whole = word.len() <= 9 && word.bytes().all(|byte| byte.is_ascii_digit());
    let index = word.parse().ok().filter(|index| *index < below && is_whole);
    index.ok_or(malformed("an index out of range"))
}

fn pose(words: &[&str]) -> Checked<Pose> {
    Pose::of(numbers(words)?).ok_or(malformed("a quaternion must have a length near 1"))
}

/// Scene that is being read.
#[derive(Default)]
struct Draft {
    scene: Scene,
    margin: Option<f64>,
    tip: Option<usize>,
    /// Solid whose points and faces are being read.
    open: Option<(Pose, Shape)>,
    exceptions: Vec<String>,
}

impl Draft {
    fn line(&mut self, line: &str) -> Checked {
        let (kind, rest) = line.split_once(' ').unwrap_or((line, ""));
        let words: Vec<&str> = rest.split(' ').collect();
        if let (Some(object), "v" | "f") = (self.scene.objects.last_mut(), kind) {
            object.text.push_str(line);
        }
        match (kind, &mut self.open) {
            ("v", Some((_, Shape::Hull { points, .. }))) => return Ok(points.push(numbers(&words)?)),
            ("v", Some((_, Shape::Mesh { points, faces }))) => {
                unless(faces.is_empty(), "a vertex after a face")?;
                return Ok(points.push(numbers(&words)?));
            }
            ("f", Some((_, Shape::Mesh { points, faces }))) => {
                unless(words.len() == 3, "a face has three vertices")?;
                let [a, b, c] = [0, 1, 2].map(|i| index(words[i], points.len()));
                return Ok(faces.push([a?, b?, c?]));
            }
            _ => self.end_solid()?,
        }
        let (count, objects, is_rule) = (words.len(), self.scene.objects.len(), self.margin.is_some());
        match kind {
            "scene" if count == 1 && self.scene.name.is_empty() => self.scene.name = rest.to_owned(),
            _ if self.scene.name.is_empty() => return Err(malformed("a scene begins with its name")),
            "joint" if count == 3 && objects == 0 && self.scene.joints.len() < MOST_JOINTS => {
                let [lower, upper] = numbers(&words[1..])?;
                self.scene.joints.push(Joint { name: words[0].to_owned(), lower, upper });
            }
            "link" if count >= 10 && !is_rule && objects < MOST_OBJECTS => self.link(&words)?,
            "body" if count == 1 && !is_rule && objects < MOST_OBJECTS => {
                self.scene.objects.push(Object { name: rest.to_owned(), is_body: true, ..Object::default() });
            }
            "box" | "ball" | "capsule" | "cylinder" | "half" | "hull" | "mesh" => {
                unless(!is_rule && count >= 7, "a solid has a pose")?;
                self.open = Some((pose(&words[..7])?, shape(kind, &words[7..])?));
            }
            "margin" if count == 1 && !is_rule => {
                self.scene.margin = number(rest)?;
                unless(self.scene.margin >= 0.0, "a margin is not negative")?;
                self.margin = Some(self.scene.margin);
            }
            "keep" | "skip" if count == 3 && is_rule => {
                let (a, b) = (index(words[0], objects)?, index(words[1], objects)?);
                let distance = if kind == "keep" { Some(number(words[2])?) } else { None };
                let is_new = self.scene.exceptions.insert((a, b), distance).is_none();
                unless(a < b && is_new, "each pair once, the lower index first")?;
                let [a, b] = [a, b].map(|index| &self.scene.objects[index].name);
                self.exceptions.push(format!("{kind} {a} {b} {}", words[2]));
            }
            "start" if count == self.scene.joints.len() && self.scene.start.is_empty() => {
                self.scene.start = words.iter().map(|word| number(word)).collect::<Checked<_>>()?;
            }
            "tip" if is_rule && self.tip.is_none() => self.tip = Some(index(rest, objects)?),
            "goal" if count == 8 && is_rule => self.scene.goals.push(pose(&words[1..])?),
            _ => return Err(malformed("a line of no known kind, or not at this place")),
        }
        if let Some(object) = self.scene.objects.last_mut().filter(|_| !is_rule) {
            object.text.push_str(line);
        }
        Ok(())
    }

    fn link(&mut self, words: &[&str]) -> Checked {
        let (objects, joints) = (&self.scene.objects, self.scene.joints.len());
        let parent = if words[1] == "-" { None } else { Some(index(words[1], objects.len())?) };
        let depth = parent.map_or(0, |parent| objects[parent].depth + 1);
        let is_first = objects.is_empty();
        unless(!objects.iter().any(|known| known.is_body), "links come before bodies")?;
        unless(depth < MOST_DEPTH && parent.is_none() == is_first, "one root, and not too deep a tree")?;
        let motion = match (words[9], &words[10..]) {
            ("fixed", []) => None,
            (kind @ ("turn" | "slide"), [joint, rest @ ..]) => {
                let [factor, offset, x, y, z] = numbers(rest)?;
                let axis = unit([x, y, z]).ok_or(malformed("an axis must have a length near 1"))?;
                Some(Motion { turns: kind == "turn", joint: index(joint, joints)?, factor, offset, axis })
            }
            _ => return Err(malformed("a motion that is none")),
        };
        let (name, pose) = (words[0].to_owned(), pose(&words[2..9])?);
        self.scene.objects.push(Object { name, parent, depth, pose, motion, ..Object::default() });
        Ok(())
    }

    fn end_solid(&mut self) -> Checked {
        let Some((pose, shape)) = self.open.take() else { return Ok(()) };
        let Some(object) = self.scene.objects.last_mut() else {
            return Err(malformed("a solid of no object"));
        };
        unless(object.add(Solid::new(pose, shape)), "a solid that is empty, too large, too many or on a link")
    }

    fn finished(mut self) -> Checked<(Scene, Vec<String>)> {
        self.end_solid()?;
        let Scene { joints, start, goals, objects, .. } = &self.scene;
        let is_whole = !joints.is_empty() && start.len() == joints.len() && !goals.is_empty();
        let Some(tip) = self.tip.filter(|tip| is_whole && !objects[*tip].is_body) else {
            return Err(malformed("no joint, start, tip or goal before the hash"));
        };
        self.scene.tip = tip;
        self.scene.list_pairs();
        Ok((self.scene, self.exceptions))
    }
}

/// Reads the sizes of a solid, which must be positive.
fn shape(kind: &str, words: &[&str]) -> Checked<Shape> {
    let shape = match kind {
        "box" => Shape::Box(numbers(words)?),
        "ball" => Shape::Capsule([0.0, numbers::<1>(words)?[0]]),
        "capsule" => Shape::Capsule(numbers(words)?),
        "cylinder" => Shape::Cylinder(numbers(words)?),
        "hull" => Shape::Hull { radius: numbers::<1>(words)?[0], points: Vec::new() },
        "half" if words.is_empty() => Shape::HalfSpace,
        "mesh" if words.is_empty() => Shape::Mesh { points: Vec::new(), faces: Vec::new() },
        _ => return Err(malformed("sizes that the solid does not have")),
    };
    let is_size = |word: &&str| number(word).is_ok_and(|size| size > 0.0 || (size == 0.0 && kind == "hull"));
    unless(words.iter().all(is_size), "a size must be positive")?;
    Ok(shape)
}

/// Paths that are being read.
struct Along<'a> {
    scene: &'a Scene,
    effort: Effort,
    outside: Outside,
    /// Control points of the piece, its proof once the first pair is read, and the number of the next pair.
    points: Vec<Vec<f64>>,
    piece: Option<Piece<'a>>,
    next: usize,
    /// End of the previous piece, `None` before the first.
    end: Option<Vec<f64>>,
    /// End of the last path.
    last: Vec<f64>,
    paths: usize,
    pieces: usize,
}

impl<'a> Along<'a> {
    fn new(scene: &'a Scene) -> Self {
        let (effort, outside, points) = (Effort::default(), Outside::default(), Vec::new());
        Self {
            scene,
            effort,
            outside,
            points,
            piece: None,
            next: 0,
            end: None,
            last: Vec::new(),
            paths: 0,
            pieces: 0,
        }
    }

    fn line(&mut self, line: &str) -> Checked {
        let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
        match word {
            "path" => {
                self.end_path()?;
                self.paths += 1;
            }
            "piece" if rest.is_empty() && self.paths > 0 => {
                if self.end.is_some() || !self.points.is_empty() {
                    self.end_piece()?;
                }
                self.pieces += 1;
            }
            "q" if self.pieces > 0 && self.next == 0 && self.points.len() < MOST_POINTS => {
                let q = rest.split(' ').map(number).collect::<Checked<Vec<f64>>>()?;
                unless(q.len() == self.scene.joints.len(), "one value for each joint")?;
                let mut within = self.scene.joints.iter().zip(&q);
                if let Some((joint, _)) =
                    within.find(|(joint, x)| !(joint.lower <= **x && **x <= joint.upper))
                {
                    return Err(format!("{} is outside its limits", joint.name).into());
                }
                if self.points.is_empty() {
                    self.check_begin(&q)?;
                }
                self.points.push(q);
            }
            "p" if self.points.len() >= 2 => {
                let mut words = rest.splitn(3, ' ');
                let mut object = || index(words.next().unwrap_or_default(), self.scene.objects.len());
                let stated = (object()?, object()?);
                let Some(pair) = self.scene.pairs.get(self.next).filter(|pair| pair.0 == stated) else {
                    return Err("the proof of another pair is missing".to_owned().into());
                };
                let piece = self.piece.get_or_insert_with(|| Piece::new(self.scene, &self.points));
                let marks = words.next().unwrap_or_default();
                piece.check(*pair, marks, &mut self.outside, &mut self.effort)?;
                self.next += 1;
            }
            _ => return Err(malformed("a line of no known kind, or not at this place")),
        }
        Ok(())
    }

    /// Checks that a piece begins where the last one ends, and the first one at the start (10).
    fn check_begin(&self, q: &[f64]) -> Checked {
        let known = self.end.as_ref().map(|end| (end, 0.0));
        let (from, tolerance) = known.unwrap_or((&self.scene.start, START_TOLERANCE));
        let off = |(a, b): (&f64, &f64)| (point(*a) - point(*b)).magnitude().hi;
        let is_there = q.iter().zip(from).map(off).all(|off| off <= tolerance);
        if is_there { Ok(()) } else { Err("the piece does not begin where the path is".to_owned().into()) }
    }

    fn end_piece(&mut self) -> Checked {
        unless(self.points.len() >= 2, "a piece without two control points")?;
        if self.next < self.scene.pairs.len() {
            return Err("the proof of a pair is missing".to_owned().into());
        }
        self.end = self.points.pop();
        (self.piece, self.next) = (None, 0);
        self.points.clear();
        Ok(())
    }

    /// Checks the end of a path: the tip is at a goal (11), and no solid is inside a mesh (9).
    fn end_path(&mut self) -> Checked {
        if self.paths == 0 {
            return Ok(());
        }
        unless(self.points.len() >= 2, "a path without a piece")?;
        self.effort.add(100 * self.scene.objects.len() as u64)?;
        let tip = Piece::new(self.scene, &self.points).pose_at_end(self.scene.tip);
        self.end_piece()?;
        let is_there = |goal: &Pose| {
            let off = sum(tip.translation, minus(goal.translation));
            let add_row = |trace: Interval, i: usize| trace + dot(tip.rotation[i], goal.rotation[i]);
            let is_near = dot(off, off).hi <= GOAL_TOLERANCE_M * GOAL_TOLERANCE_M;
            is_near && (0..3).fold(ZERO, add_row).lo >= GOAL_TRACE
        };
        if !self.scene.goals.iter().any(is_there) {
            return Err("the path ends at no goal".to_owned().into());
        }
        std::mem::take(&mut self.outside).check(self.scene, &mut self.effort)?;
        self.last = self.end.take().unwrap_or_default();
        Ok(())
    }
}
