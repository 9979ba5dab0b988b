//! Proof of one piece of a path: for each pair a tree of intervals and planes, for each bound one of intervals.

use std::collections::{HashMap, HashSet};
use std::rc::Rc;

use super::interval::{ORIGIN, Vector, ZERO, dot, length, minus, point};
use super::lines::{Checked, Lines, unless};
use super::motion::{Curve, Moment, halves};
use super::scene::{Bound, Pair, Pose, Scene};
use super::solid::{Object, Span};

/// Maximum number of halvings above a leaf.
pub const MOST_HALVINGS: u32 = 96;

/// Maximum work on a certificate, in operations of some ten nanoseconds; it limits the memory too.
const MOST_WORK: usize = 2_000_000_000;

/// Work that was done, and pairs of solids of which some plane of the path has one on either side (9).
#[derive(Default)]
pub struct Ledger {
    work: usize,
    pub outside: HashSet<[usize; 4]>,
}

/// Piece of a path.
pub struct Piece<'a> {
    scene: &'a Scene<'a>,
    whole: Rc<Curve>,
    moments: HashMap<u128, Rc<Moment<'a>>>,
    ledger: &'a mut Ledger,
}

/// Node of a tree: interval, with the number 1 for the whole piece and 2k and 2k + 1 for the halves of k; and a part of each
/// object.
struct Node {
    curve: Rc<Curve>,
    number: u128,
    spans: [Span; 2],
    halvings: u32,
}

impl Ledger {
    /// Counts work, and fails beyond the limit.
    pub fn work(&mut self, work: usize) -> Checked {
        self.work = self.work.saturating_add(work);
        unless(self.work <= MOST_WORK, "more work than a certificate may take")
    }
}

impl<'a> Piece<'a> {
    pub fn new(scene: &'a Scene<'a>, points: &[Vec<f64>], ledger: &'a mut Ledger) -> Self {
        let curve = points.iter().map(|q| q.iter().map(|x| point(*x)).collect()).collect();
        Self { scene, whole: Rc::new(curve), moments: HashMap::new(), ledger }
    }

    /// Returns the pose of a link in the world.
    pub fn pose_in_middle(&mut self, link: usize) -> Checked<Pose> {
        self.ledger.work(100 * self.scene.objects.len())?;
        Ok(Moment::of(self.scene, &self.whole).moved(None, link, (ORIGIN, ZERO)).pose)
    }

    /// Checks the proof of a pair. Leaves are three whole numbers for a plane, `~` for the plane before, `=` for that of a
    /// half-space.
    pub fn check_pair(&mut self, pair: &Pair, marks: &mut Lines<'_>) -> Checked {
        let objects = pair.objects.map(|index| &self.scene.objects[index]);
        let mut plane = None;
        self.check_tree(objects, marks, |piece, node, mark| {
            if mark != "~" && mark != "=" {
                plane = Some(normal(mark).ok_or("a mark that is none")?);
            }
            unless(mark == "=" || plane.is_some(), "no plane before")?;
            let is_whole = (0..2).all(|side| objects[side].has_whole_meshes(node.spans[side]));
            unless(pair.distance >= 0.0 || is_whole, "an allowed overlap needs planes for whole meshes")?;
            piece.separates(pair, node, plane.filter(|_| mark != "="))?;
            let ([a, b], [of_a, of_b]) =
                (pair.objects, node.spans.map(|span| span.solids[0]..span.solids[1]));
            piece.ledger.work(100 * of_a.len() * of_b.len())?;
            let solids = of_a.flat_map(|i| of_b.clone().map(move |j| [a, b, i, j]));
            piece.ledger.outside.extend(solids.filter(|_| is_whole));
            Ok(())
        })
    }

    /// Checks that a bound is kept. Leaves are `.`.
    pub fn check_bound(&mut self, bound: &Bound, marks: &mut Lines<'_>) -> Checked {
        let link = &self.scene.objects[bound.link];
        self.check_tree([link, link], marks, |piece, node, mark| {
            unless(mark == ".", "a mark that is none")?;
            piece.ledger.work(100 * (link.depth + 2))?;
            unless(bound.holds(&*piece.moment(node)?), "a bound is not shown to be kept")
        })
    }

    /// Walks through a tree of marks in prefix order (8): `h` halves the interval, `a` and `b` a part of one of the objects.
    fn check_tree(
        &mut self,
        objects: [&Object<'_>; 2],
        marks: &mut Lines<'_>,
        mut check_leaf: impl FnMut(&mut Self, &Node, &str) -> Checked,
    ) -> Checked {
        let spans = objects.map(|object| object.span(0, object.solids.len()));
        let mut open = vec![Node { curve: self.whole.clone(), number: 1, spans, halvings: 0 }];
        while let Some(node) = open.pop() {
            unless(node.halvings <= MOST_HALVINGS, "too many halvings")?;
            let halvings = node.halvings + 1;
            self.ledger.work(10)?;
            match marks.word()? {
                "h" => {
                    self.ledger.work(node.curve.len().pow(2) * self.scene.joints.len())?;
                    let ([first, second], number) = (halves(&node.curve).map(Rc::new), 2 * node.number);
                    open.push(Node { curve: second, number: number + 1, halvings, ..node });
                    open.push(Node { curve: first, number, halvings, ..node });
                }
                mark @ ("a" | "b") => {
                    let side = usize::from(mark == "b");
                    let parts =
                        objects[side].halves(node.spans[side]).ok_or("a part that cannot be halved")?;
                    for part in parts.into_iter().rev() {
                        let mut spans = node.spans;
                        spans[side] = part;
                        open.push(Node { curve: node.curve.clone(), spans, halvings, ..node });
                    }
                }
                mark => check_leaf(self, &node, mark)?,
            }
        }
        Ok(())
    }

    /// Checks inequality (7): a plane, or that of a half-space, keeps both parts apart by the distance along the interval.
    fn separates(&mut self, pair: &Pair, node: &Node, plane: Option<Vector>) -> Checked {
        let [of_a, of_b] = pair.objects.map(|index| &self.scene.objects[index]);
        let [span_a, span_b] = node.spans;
        let sizes = of_a.size(span_a) + of_b.size(span_b);
        self.ledger.work(100 * (of_a.depth + of_b.depth + 2) + 2 * sizes)?;
        let moment = self.moment(node)?;
        let [first, second] = [0, 1].map(|side| {
            let of = pair.objects[side];
            moment.moved(pair.top, of, self.scene.objects[of].ball(node.spans[side]))
        });
        let solid = &of_b.solids[span_b.solids[0]];
        let is_floor = solid.is_half_space && span_b.solids[1] == span_b.solids[0] + 1;
        unless(plane.is_some() || is_floor, "no half-space")?;
        // The normal points from the first part to the second, so into the half-space.
        let up = solid.pose.rotation.map(|row| row[2]);
        let n = plane.unwrap_or(minus(up));
        let bend = (first.acceleration + second.acceleration) * point(0.125);
        let needed = length(n) * (point(pair.distance) + bend);
        for s in [-0.5, 0.5].map(point) {
            let of_b = match plane {
                Some(_) => second.reach(of_b, span_b, minus(n), s),
                None => dot(up, solid.pose.translation),
            };
            let gap = -(first.reach(of_a, span_a, n, s) + of_b);
            let by = (needed.hi - gap.lo) / length(n).hi;
            let fault = || format!("the plane does not keep both parts apart: {by:e} m are missing");
            (gap.lo > needed.hi).then_some(()).ok_or_else(fault)?;
        }
        Ok(())
    }

    fn moment(&mut self, node: &Node) -> Checked<Rc<Moment<'a>>> {
        if !self.moments.contains_key(&node.number) {
            let of_curve = node.curve.len().pow(2) * self.scene.joints.len();
            self.ledger.work(500 * self.scene.objects.len() + 10 * of_curve)?;
        }
        let of = || Rc::new(Moment::of(self.scene, &node.curve));
        Ok(self.moments.entry(node.number).or_insert_with(of).clone())
    }
}

/// Reads a plane: three whole numbers of 16 bits, not all zero, each in its shortest form.
fn normal(mark: &str) -> Option<Vector> {
    let whole = |x: &str| x.parse().ok().filter(|number: &i16| number.to_string() == x);
    let n: Vec<i16> = mark.split(',').map(whole).collect::<Option<_>>()?;
    let n: [i16; 3] = n.try_into().ok()?;
    (n != [0; 3]).then(|| n.map(|x| point(f64::from(x))))
}
