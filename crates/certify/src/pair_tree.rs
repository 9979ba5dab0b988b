use std::collections::HashMap;
use std::fmt::Write as _;
use std::rc::Rc;

use cranny_collision::Cell;
use cranny_robot::LinkFrames;
use cranny_spatial::Vector;

use crate::bound_gap::is_kept;
use crate::gap::Gap;
use crate::joint_curve::{JointCurve, halves};
use crate::link_bound::LinkBound;
use crate::model::Model;
use crate::moment::Moment;
use crate::span::Span;

/// Maximum number of halvings of an interval: 1e-7 of an edge, in which nothing moves by more than a micrometre.
const MOST_DEPTH: u32 = 24;

/// Maximum number of nodes of the tree of one pair on one edge: a hundred times what a tight edge takes.
const MOST_NODES: usize = 20_000;

/// Proof of a piece of a path, with the middles of its intervals.
pub(crate) struct PieceProof<'a> {
    cell: &'a Cell,
    frames: LinkFrames,
    model: &'a Model,
    whole: Rc<JointCurve>,
    moments: HashMap<(u32, u64), Rc<Moment>>,
}

/// Interval of the curve and spans of both objects.
#[derive(Clone)]
struct Node {
    curve: Rc<JointCurve>,
    depth: u32,
    number: u64,
    spans: [Span; 2],
}

impl Node {
    fn middle(&self) -> f64 {
        (self.number as f64 + 0.5) / f64::from(self.depth).exp2()
    }

    /// Puts the nodes of both halves of the interval on a stack, the first one on top.
    fn push_halves(self, open: &mut Vec<Self>) {
        let [first, second] = halves(&self.curve).map(Rc::new);
        let (depth, number) = (self.depth + 1, 2 * self.number);
        open.push(Self { curve: second, depth, number: number + 1, ..self });
        open.push(Self { curve: first, depth, number, ..self });
    }
}

/// Pair that is not proven near this parameter of the piece.
pub(crate) struct Stuck {
    pub at: f64,
}

/// Proof of a pair along a piece: its marks, and the pairs of solids that some plane has on either side.
pub(crate) struct PairTree {
    pub marks: String,
    pub outside: Vec<(usize, usize)>,
}

impl<'a> PieceProof<'a> {
    pub fn new(cell: &'a Cell, model: &'a Model, curve: &JointCurve) -> Self {
        Self { cell, frames: cell.frames(), model, whole: Rc::new(curve.clone()), moments: HashMap::new() }
    }

    /// Proves that the two objects of a pair keep their distance along the piece:
    ///
    /// 1. The plane before may hold.
    /// 2. Otherwise a new one is searched for.
    /// 3. If there is none, a part is halved if that brings its halves away from the other part, else the interval.
    ///
    /// # Errors
    /// [`Stuck`] where the parts are too close.
    pub fn prove(&mut self, ((a, b), margin_m): ((usize, usize), f64)) -> Result<PairTree, Stuck> {
        let model = self.model;
        let objects = [&model.objects[a], &model.objects[b]];
        let top = model.common(a, b);
        let spans = objects.map(crate::span::Object::whole);
        let mut open = vec![Node { curve: self.whole.clone(), depth: 0, number: 0, spans }];
        let mut tree = PairTree { marks: String::new(), outside: Vec::new() };
        let mut last: Option<[i16; 3]> = None;
        let mut nodes = 0;
        while let Some(node) = open.pop() {
            nodes += 1;
            let stuck = Stuck { at: node.middle() };
            if nodes > MOST_NODES {
                return Err(stuck);
            }
            let moment = self.moment(&node);
            let gap_of = |spans: [Span; 2]| {
                let moved = [(a, 0), (b, 1)]
                    .map(|(of, side)| moment.moved(model, top, of, objects[side].ball(spans[side])));
                let needed_m = margin_m + 0.125 * (moved[0].acceleration + moved[1].acceleration);
                Gap { objects, spans, moved, needed_m }
            };
            let gap = gap_of(node.spans);
            if !tree.marks.is_empty() {
                tree.marks.push(' ');
            }
            let is_whole = |side: usize| objects[side].has_whole_meshes(node.spans[side]);
            let floor = objects[1].half_space(node.spans[1]);
            let mark = if let Some(floor) = floor {
                let up = floor.rotation * Vector::z();
                let lowest = [-0.5, 0.5].map(|s| {
                    gap.moved[0].farthest(objects[0], node.spans[0], &-up, s).dot(&up)
                        - floor.translation.vector.dot(&up)
                });
                (lowest[0].min(lowest[1]) > gap.needed_m + 1e-9).then(|| "=".to_owned())
            } else if last.is_some_and(|plane| gap.is_apart(&Vector::from(plane.map(f64::from)))) {
                Some("~".to_owned())
            } else {
                let plane = gap.plane();
                last = plane.or(last);
                plane.map(|[x, y, z]| format!("{x},{y},{z}"))
            };
            if let Some(mark) = mark {
                tree.marks.push_str(&mark);
                if is_whole(0) && is_whole(1) {
                    let [of_a, of_b] = node.spans.map(|span| span.solids);
                    tree.outside
                        .extend((of_a[0]..of_a[1]).flat_map(|i| (of_b[0]..of_b[1]).map(move |j| (i, j))));
                }
                continue;
            }
            // The support of the whole above a plane is as near as that of its nearest part.
            let parts = if floor.is_some() { None } else { Self::halved(&node, margin_m, &gap, &gap_of) };
            match parts {
                Some((side, parts)) => {
                    let _ = write!(tree.marks, "{}", if side == 0 { 'a' } else { 'b' });
                    for part in parts.into_iter().rev() {
                        let mut spans = node.spans;
                        spans[side] = part;
                        open.push(Node { spans, ..node.clone() });
                    }
                }
                None if node.depth >= MOST_DEPTH => return Err(stuck),
                None => {
                    tree.marks.push('h');
                    node.push_halves(&mut open);
                }
            }
        }
        Ok(tree)
    }

    /// Proves that a bound of a link is kept along the piece: its marks.
    ///
    /// # Errors
    /// [`Stuck`] where the bound is nearly reached.
    pub fn prove_bound(&mut self, bound: &LinkBound) -> Result<String, Stuck> {
        let object = &self.model.objects[bound.link];
        let spans = [object.whole(); 2];
        let mut open = vec![Node { curve: self.whole.clone(), depth: 0, number: 0, spans }];
        let mut marks: Vec<&str> = Vec::new();
        while let Some(node) = open.pop() {
            let moment = self.moment(&node);
            if is_kept(bound, &moment.moved(self.model, None, bound.link, (bound.point_in_link(), 0.0))) {
                marks.push(".");
                continue;
            }
            if node.depth >= MOST_DEPTH || marks.len() > MOST_NODES {
                return Err(Stuck { at: node.middle() });
            }
            marks.push("h");
            node.push_halves(&mut open);
        }
        Ok(marks.join(" "))
    }

    /// Returns the halves of the part to divide, and its side; `None` if the interval is to be halved.
    fn halved<'g>(
        node: &Node,
        margin_m: f64,
        gap: &Gap<'_>,
        gap_of: &impl Fn([Span; 2]) -> Gap<'g>,
    ) -> Option<(usize, [Span; 2])> {
        let sides = [0, 1].map(|side| gap.objects[side].halves(node.spans[side]));
        let radius = |side: usize| if sides[side].is_some() { gap.moved[side].radius_m } else { -1.0 };
        let side = usize::from(radius(1) > radius(0));
        let parts = sides[side]?;
        if margin_m < 0.0 {
            // Each solid has a plane of its own, and a mesh is not divided.
            let [begin, end] = node.spans[side].solids;
            return (end > begin + 1).then_some((side, parts));
        }
        // In a short interval only the shapes can be in the way.
        let still_m = gap.still_m() - margin_m;
        let motion_m = gap.moved[0].most_m() + gap.moved[1].most_m();
        if still_m <= 1e-6 || motion_m < 0.1 * still_m {
            return Some((side, parts));
        }
        let with = |part: Span| {
            let mut spans = node.spans;
            spans[side] = part;
            gap_of(spans).still_m() - margin_m
        };
        (with(parts[0]).min(with(parts[1])) > 2.0 * still_m).then_some((side, parts))
    }

    fn moment(&mut self, node: &Node) -> Rc<Moment> {
        let of = || Rc::new(Moment::of(self.cell.robot(), self.frames.clone(), &node.curve));
        self.moments.entry((node.depth, node.number)).or_insert_with(of).clone()
    }
}
