use std::fmt::Write as _;

use cranny_collision::Cell;
use cranny_robot::{JointKind, LinkFrames};
use cranny_spatial::{EXACT_ROTATION_RAD, EXACT_TRANSLATION_M, Point, Pose, Vector};

use crate::common_point::{common_point, is_deep};
use crate::gap::Gap;
use crate::model::Model;
use crate::moment::Moment;
use crate::scene_text::decimal;
use crate::span::Shape;

/// Maximum distance of the start of a path from that of the problem, in m or rad; a checker allows the same.
pub(crate) const START_TOLERANCE: f64 = 1e-5;

/// Edge length below which a box is not divided, in metres.
const FINEST_M: f64 = 2e-4;

/// Maximum number of boxes.
const MOST_BOXES: usize = 5000;

/// Slack of each inequality, in metres: a thousand times the rounding of a checker.
const SLACK_M: f64 = 1e-9;

/// Intervals of the slides.
type Values = Vec<[f64; 2]>;

/// Slides on which the arm of a robot stands, and pairs of objects that no other joint moves.
pub(crate) struct Base<'a> {
    pub cell: &'a Cell,
    pub model: &'a Model,
    pub start: &'a [f64],
    /// Indices of the slides in `q`.
    slides: Vec<usize>,
    /// Link whose origin only the slides move.
    pub link: usize,
    /// For each link from there to the tip that turns, the point of its axis that gives the least bound of the reach, in metres.
    pub axis_points: Vec<f64>,
    /// Bound of the distance of the tip from that origin.
    reach_m: f64,
    pairs: Vec<(usize, usize)>,
    /// Pairs of a link that no joint moves against the tip, and of an object that none moves at all.
    hand_pairs: Vec<[usize; 2]>,
}

/// Point that two solids have in common.
enum Common {
    /// Vertex of the first one.
    Vertex(usize),
    /// In the world.
    Point(Point),
}

/// Returns the mark of a point of a solid, in the frame of its object, that is in another one: object and solid of both.
fn mark([first, i, second, k]: [usize; 4], at: &Point) -> String {
    format!("{first},{i},{second},{k},{},{},{}", decimal(at.x), decimal(at.y), decimal(at.z))
}

/// Node of the tree of boxes.
enum Node {
    /// Halves of the interval of a slide.
    Split {
        slide: usize,
        halves: [usize; 2],
    },
    /// Two objects touch in the whole box; the mark.
    Blocked(String),
    /// Nothing that only the slides move touches anything in the whole box.
    Free,
    Undecided,
}

/// Tree of boxes.
pub(crate) struct Boxes {
    nodes: Vec<(Values, Node)>,
}

impl<'a> Base<'a> {
    /// Returns the slides above the first joint that turns, if any, and the reach from there, with `start` (m, rad; one per joint).
    pub fn new(cell: &'a Cell, model: &'a Model, start: &'a [f64]) -> Option<Self> {
        let chain = model.chain(None, cell.robot().tip());
        let joint = |link: usize| model.objects[link].motion.as_ref().and_then(|motion| motion.joint);
        let turns = |link: &usize| joint(*link).is_some_and(|joint| joint.kind == JointKind::Revolute);
        let first = chain.iter().position(turns).unwrap_or(chain.len() - 1);
        let mut slides: Vec<usize> =
            chain[..first].iter().filter_map(|link| Some(joint(*link)?.joint)).collect();
        slides.sort_unstable();
        slides.dedup();
        let arm = &chain[first + 1..];
        let mut axis_points = vec![0.0; arm.iter().filter(|link| turns(link)).count()];
        shorten(&mut axis_points, &|points| reach_m(cell, model, arm, points));
        let reach_m = reach_m(cell, model, arm, &axis_points);
        // A link that turns with a slide, by a rack, is not moved by slides alone.
        let only_slides = |object: usize| {
            let mut joints = model.chain(None, object).into_iter().filter_map(joint);
            joints.all(|joint| joint.kind == JointKind::Prismatic && slides.contains(&joint.joint))
        };
        let is_of_base = |((a, b), margin_m): &((usize, usize), f64)| {
            *margin_m >= 0.0 && only_slides(*a) && only_slides(*b)
        };
        let pairs = model.pairs.iter().filter(|pair| is_of_base(pair)).map(|(pair, _)| *pair).collect();
        let is_of_hand = |object: &usize| {
            let beyond = |of: usize, other: usize| {
                let other = model.chain(None, other);
                model
                    .chain(None, of)
                    .into_iter()
                    .filter(|link| !other.contains(link))
                    .any(|link| joint(link).is_some())
            };
            let tip = cell.robot().tip();
            model.objects[*object].motion.is_some() && !beyond(*object, tip) && !beyond(tip, *object)
        };
        let stands =
            |object: &usize| model.chain(None, *object).into_iter().all(|link| joint(link).is_none());
        let demanded = model.pairs.iter().filter(|(_, margin_m)| *margin_m >= 0.0);
        let both = demanded.flat_map(|((a, b), _)| [[*a, *b], [*b, *a]]);
        let hand_pairs = both.filter(|[of, other]| is_of_hand(of) && stands(other)).collect();
        let is_finite = slides.iter().all(|slide| {
            let limits = cell.robot().limits()[*slide];
            (limits.upper - limits.lower).is_finite()
        });
        is_finite.then_some(Self {
            cell,
            model,
            start,
            slides,
            link: chain[first],
            axis_points,
            reach_m,
            pairs,
            hand_pairs,
        })
    }

    /// Returns the mark of a point that the hand and the world have in common wherever the tip is within the tolerance of a goal, a
    /// pose in the planning frame, if one is found.
    pub fn blocked_at(&self, goal: &Pose) -> Option<String> {
        let frames = self.middle(&Vec::new()).frames;
        let tip_from_world = frames.link(self.cell.robot().tip()).inverse();
        let place = |object: usize| {
            let is_link = self.model.objects[object].motion.is_some();
            if is_link { *frames.link(object) } else { Pose::identity() }
        };
        self.hand_pairs.iter().find_map(|&[of, other]| {
            let obstacles = &self.model.objects[other].solids;
            let solids = self.model.objects[of].solids.iter().enumerate();
            let pairs =
                solids.flat_map(|own| obstacles.iter().enumerate().map(move |obstacle| (own, obstacle)));
            pairs.into_iter().find_map(|((i, own), (k, obstacle))| {
                let tip_from_solid = tip_from_world * place(of) * own.pose;
                let own = (&own.shape, goal * tip_from_solid);
                let point = Self::common_at(
                    goal,
                    (own, &tip_from_solid),
                    (&obstacle.shape, place(other) * obstacle.pose),
                )?;
                let solids = [of, i, other, k];
                Some(match point {
                    Common::Vertex(vertex) => format!("{of},{i},{other},{k},v{vertex}"),
                    Common::Point(at) => {
                        mark(solids, &(goal * tip_from_world * place(of)).inverse_transform_point(&at))
                    }
                })
            })
        })
    }

    /// Returns a point that a solid of the hand and another one have in common wherever the tip is within the tolerance of a goal.
    fn common_at(
        goal: &Pose,
        (own, tip_from_solid): ((&Shape, Pose), &Pose),
        obstacle: (&Shape, Pose),
    ) -> Option<Common> {
        let moved_m = |most_m: f64| EXACT_TRANSLATION_M + 2.0 * libm::sin(0.5 * EXACT_ROTATION_RAD) * most_m;
        let vertices = |points: &[Vector], is_known: &dyn Fn(usize) -> bool| {
            let is_inside = |vertex: &usize| {
                let in_tip = tip_from_solid * Point::from(points[*vertex]);
                is_deep(obstacle, &(goal * in_tip), moved_m(in_tip.coords.norm())) && is_known(*vertex)
            };
            (0..points.len()).find(is_inside).map(Common::Vertex)
        };
        match own.0 {
            Shape::Hull { points, .. } => vertices(points, &|_| true),
            Shape::Mesh { points, faces } => {
                vertices(points, &|vertex| faces.iter().flatten().any(|corner| *corner == vertex))
            }
            _ => {
                let apart_m = (own.1.translation.vector - obstacle.1.translation.vector).norm();
                if apart_m > own.0.radius_m() + obstacle.0.radius_m() {
                    return None;
                }
                // A point nearer to the tip is moved less.
                let most_m = tip_from_solid.translation.vector.norm() + own.0.radius_m();
                [1.0, 0.8, 0.6, 0.4, 0.2].into_iter().find_map(|share| {
                    let at = common_point(obstacle, own, &[], moved_m(share * most_m))?;
                    let is_near = (at - Point::from(goal.translation.vector)).norm() <= share * most_m;
                    is_near.then_some(Common::Point(at))
                })
            }
        }
    }

    /// Returns true if a point is beyond reach from everywhere.
    pub fn is_beyond_all(&self, point: &Point) -> bool {
        let limits = self.cell.robot().limits();
        let whole = self.slides.iter().map(|slide| [limits[*slide].lower, limits[*slide].upper]).collect();
        self.beyond_m(&whole, std::slice::from_ref(point))[0] > 0.0
    }

    /// Returns the robot at rest with the slides in the middle of a box.
    fn middle(&self, values: &Values) -> Moment {
        let mut q = self.start.to_vec();
        self.slides.iter().zip(values).for_each(|(slide, [lower, upper])| q[*slide] = 0.5 * (lower + upper));
        Moment::of(self.cell.robot(), self.cell.frames(), &vec![q; 2])
    }

    /// Returns the motion of an object, in the world, from the middle of a box to its upper end in each slide.
    fn ways(&self, frames: &LinkFrames, object: usize, values: &Values) -> Vec<Vector> {
        let way = |(slide, [lower, upper]): (&usize, &[f64; 2])| {
            let links = self.model.chain(None, object).into_iter();
            let moved = links.filter_map(|link| {
                let joint = self.model.objects[link].motion.as_ref()?.joint?;
                (joint.joint == *slide)
                    .then(|| frames.link(link).rotation * joint.axis_in_link * joint.multiplier)
            });
            moved.sum::<Vector>() * (0.5 * (upper - lower))
        };
        self.slides.iter().zip(values).map(way).collect()
    }

    /// Decides a box by the first pair that touches in all of it.
    fn decide(&self, values: &Values) -> Node {
        let moment = self.middle(values);
        let frames = &moment.frames;
        let place = |object: usize| {
            let is_link = self.model.objects[object].motion.is_some();
            if is_link { *frames.link(object) } else { Pose::identity() }
        };
        let mut is_free = true;
        for &(a, b) in &self.pairs {
            let [of_a, of_b] = [a, b].map(|object| self.ways(frames, object, values));
            let ways: Vec<Vector> = of_a.iter().zip(&of_b).map(|(a, b)| a - b).collect();
            for i in 0..self.model.objects[a].solids.len() {
                for k in 0..self.model.objects[b].solids.len() {
                    if self.stay_apart(&moment, [(a, i), (b, k)], &ways) {
                        continue;
                    }
                    is_free = false;
                    for [(first, i), (second, k)] in [[(a, i), (b, k)], [(b, k), (a, i)]] {
                        let solid = |object: usize, index: usize| {
                            let solid = &self.model.objects[object].solids[index];
                            (&solid.shape, place(object) * solid.pose)
                        };
                        if let Some(p) = common_point(solid(first, i), solid(second, k), &ways, 0.0) {
                            let own: Point = place(first).inverse_transform_point(&p);
                            return Node::Blocked(mark([first, i, second, k], &own));
                        }
                    }
                }
            }
        }
        if is_free { Node::Free } else { Node::Undecided }
    }

    /// Returns true if two solids stay apart when they move against each other by a sum of up to ± each way.
    fn stay_apart(&self, moment: &Moment, [(a, i), (b, k)]: [(usize, usize); 2], ways: &[Vector]) -> bool {
        let objects = [&self.model.objects[a], &self.model.objects[b]];
        let spans = [objects[0].span(i, i + 1), objects[1].span(k, k + 1)];
        let moved = [(a, 0), (b, 1)]
            .map(|(of, side)| moment.moved(self.model, None, of, objects[side].ball(spans[side])));
        let (distance_m, n) = if let Some(floor) = objects[1].half_space(spans[1]) {
            let up = floor.rotation * Vector::z();
            let lowest = moved[0].farthest(objects[0], spans[0], &-up, 0.0);
            (up.dot(&(lowest - floor.translation.vector)), up)
        } else {
            Gap { objects, spans, moved, needed_m: 0.0 }.still()
        };
        distance_m > ways.iter().map(|way| way.dot(&n).abs()).sum::<f64>() + SLACK_M
    }

    /// Returns the distance of the nearest of some points from everything within reach from a box, in metres, at least; and that
    /// from its middle.
    fn beyond_m(&self, values: &Values, goals: &[Point]) -> [f64; 2] {
        let frames = &self.middle(values).frames;
        let origin = frames.link(self.link).translation.vector;
        let half =
            self.ways(frames, self.link, values).iter().fold(Vector::zeros(), |sum, way| sum + way.abs());
        let off = |goal: &Point| (goal.coords - origin).abs();
        let reach_m = self.reach_m + EXACT_TRANSLATION_M + SLACK_M;
        let nearest = |half: Vector| {
            let all = goals.iter().map(|goal| (off(goal) - half).sup(&Vector::zeros()).norm());
            all.fold(f64::INFINITY, f64::min) - reach_m
        };
        [nearest(half), nearest(Vector::zeros())]
    }
}

/// Returns a bound of the distance of the tip from the origin of the link before some links: the sum of the distances of one point
/// on the axis of each that turns from that of the one before.
fn reach_m(cell: &Cell, model: &Model, arm: &[usize], axis_points: &[f64]) -> f64 {
    let mut axis_points = axis_points.iter();
    let (mut sum_m, mut at) = (0.0, Point::origin());
    for motion in arm.iter().filter_map(|link| model.objects[*link].motion.as_ref()) {
        let pose = &motion.parent_from_link;
        let Some(joint) = motion.joint else {
            at = pose.inverse_transform_point(&at);
            continue;
        };
        let next = match joint.kind {
            JointKind::Revolute => {
                Point::from(joint.axis_in_link * axis_points.next().copied().unwrap_or(0.0))
            }
            JointKind::Prismatic => {
                let limits = cell.robot().limits()[joint.joint];
                let end = |q: f64| (joint.multiplier * q + joint.offset).abs();
                sum_m += end(limits.lower).max(end(limits.upper));
                Point::origin()
            }
        };
        sum_m += (pose * next - at).norm();
        at = next;
    }
    sum_m + at.coords.norm()
}

/// Reduces a convex function of some numbers, one after the other, by golden sections (Kiefer 1953, whole).
fn shorten(values: &mut [f64], of: &impl Fn(&[f64]) -> f64) {
    const SWEEPS: usize = 20;
    const SECTIONS: usize = 40;
    /// Greatest magnitude of a value, in metres.
    const MOST_M: f64 = 3.0;
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    for place in (0..values.len()).cycle().take(SWEEPS * values.len()) {
        let at = |values: &mut [f64], x: f64| {
            values[place] = x;
            of(values)
        };
        let [mut low, mut high] = [-MOST_M, MOST_M];
        for _ in 0..SECTIONS {
            let [a, b] = [high - ratio * (high - low), low + ratio * (high - low)];
            if at(values, a) < at(values, b) { high = b } else { low = a }
        }
        values[place] = 0.5 * (low + high);
    }
}

impl Boxes {
    /// Creates the tree of one box, of all values of the slides.
    pub fn whole(base: &Base<'_>) -> Self {
        let limits = base.cell.robot().limits();
        let whole = base.slides.iter().map(|slide| [limits[*slide].lower, limits[*slide].upper]).collect();
        Self { nodes: vec![(whole, Node::Undecided)] }
    }

    /// Divides the ranges of the slides until no point is in reach from any box that the start is connected with; `None` if that
    /// is not so, or remains undecided.
    pub fn around(base: &Base<'_>, goals: &[Point]) -> Option<Self> {
        let limits = base.cell.robot().limits();
        let whole: Values =
            base.slides.iter().map(|slide| [limits[*slide].lower, limits[*slide].upper]).collect();
        let mut boxes = Self { nodes: Vec::new() };
        boxes.add(base, whole);
        loop {
            let region = boxes.connected(base);
            let reaches: Vec<[f64; 2]> =
                region.iter().map(|index| base.beyond_m(&boxes.nodes[*index].0, goals)).collect();
            if region.is_empty() || reaches.iter().all(|[all, _]| *all > 0.0) {
                return (!region.is_empty()).then_some(boxes);
            }
            let is_unclear = |(index, [all, middle]): (&usize, &[f64; 2])| {
                let is_undecided = matches!(boxes.nodes[*index].1, Node::Undecided);
                is_undecided || (*all <= 0.0 && *middle > 0.0)
            };
            let unclear = region.iter().zip(&reaches).filter(|both| is_unclear(*both));
            let unclear: Vec<usize> = unclear.map(|(index, _)| *index).collect();
            let count = boxes.nodes.len();
            for index in unclear {
                boxes.split(base, index);
            }
            if boxes.nodes.len() == count || boxes.nodes.len() > MOST_BOXES {
                return None;
            }
        }
    }

    fn add(&mut self, base: &Base<'_>, values: Values) -> usize {
        let node = base.decide(&values);
        self.nodes.push((values, node));
        self.nodes.len() - 1
    }

    fn split(&mut self, base: &Base<'_>, index: usize) {
        let values = self.nodes[index].0.clone();
        let long = |slide: &usize| values[*slide][1] - values[*slide][0];
        let Some(slide) = (0..values.len()).max_by(|a, b| long(a).total_cmp(&long(b))) else { return };
        let [lower, upper] = values[slide];
        if upper - lower < FINEST_M {
            return;
        }
        let middle = 0.5 * (lower + upper);
        let halves = [[lower, middle], [middle, upper]].map(|half| {
            let mut values = values.clone();
            values[slide] = half;
            self.add(base, values)
        });
        self.nodes[index].1 = Node::Split { slide, halves };
    }

    /// Returns the boxes that are not blocked and that the start is connected with.
    fn connected(&self, base: &Base<'_>) -> Vec<usize> {
        let is_open = |index: &usize| matches!(self.nodes[*index].1, Node::Free | Node::Undecided);
        let mut rest: Vec<usize> = (0..self.nodes.len()).filter(is_open).collect();
        let meet = |a: &Values, b: &Values| a.iter().zip(b).all(|(a, b)| a[0] <= b[1] && b[0] <= a[1]);
        let start = base.slides.iter().map(|slide| base.start[*slide]);
        let start: Values = start.map(|value| [value - START_TOLERANCE, value + START_TOLERANCE]).collect();
        let mut found: Vec<usize> =
            rest.extract_if(.., |index| meet(&start, &self.nodes[*index].0)).collect();
        let mut next = 0;
        while next < found.len() {
            let values = &self.nodes[found[next]].0;
            found.extend(rest.extract_if(.., |index| meet(values, &self.nodes[*index].0)));
            next += 1;
        }
        found
    }

    /// Returns the tree in prefix order.
    pub fn marks(&self, base: &Base<'_>) -> String {
        let (mut marks, mut open) = (String::new(), vec![0]);
        while let Some(index) = open.pop() {
            match &self.nodes[index].1 {
                Node::Split { slide, halves: [first, second] } => {
                    let _ = write!(marks, " s{}", base.slides[*slide]);
                    open.extend([*second, *first]);
                }
                Node::Blocked(mark) => {
                    let _ = write!(marks, " {mark}");
                }
                Node::Free | Node::Undecided => marks.push_str(" ."),
            }
        }
        marks
    }
}
