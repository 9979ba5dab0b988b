//! Check that no motion leads from the start to a goal: boxes of joint values in which two objects touch, the reach of the arm from
//! those boxes that are left (14), and goals at which the hand touches the world (15).

use super::certificate::{GOAL_TOLERANCE_M, START_TOLERANCE};
use super::interval::{Interval, ORIGIN, Vector, ZERO, length, minus, point, scaled, sum};
use super::lines::{Checked, Lines, unless};
use super::motion::Moment;
use super::proof::{Ledger, MOST_HALVINGS};
use super::scene::{Pose, Scene};
use super::solid::Solid;

/// Maximum number of boxes that are left open, times that of joints: it limits the memory.
const MOST_VALUES: usize = 2_000_000;

/// Interval of each joint.
type Values = Vec<Interval>;

/// Greatest displacement of a point, per distance from the tip, by a turn of one degree: 2 sin ½°, rounded up.
const GOAL_TURN: f64 = 0.0174530709968;

/// Reads the link from which the reach counts, the tree of boxes and the goals that are blocked: returns the number of boxes that are
/// not excluded, of those of them that the start is connected with, and of the goals that are blocked.
pub fn enclosure(lines: &mut Lines<'_>, scene: &Scene<'_>, ledger: &mut Ledger) -> Checked<[usize; 3]> {
    let (link, reach) = lines.read("none", |line| {
        let link = line.index(scene.objects.len())?;
        Ok((link, reach(scene, link, line)?))
    })?;
    let whole = scene.joints.iter().map(|(_, [lo, hi])| Interval { lo: *lo, hi: *hi }).collect();
    let mut open = lines.read("boxes", |marks| open_boxes(scene, whole, marks, ledger))?;
    let count = open.len();
    let mut is_left = vec![true; scene.goals.len()];
    while lines.is("blocked") {
        is_left[lines.read("blocked", |line| blocked_goal(scene, line, ledger))?] = false;
    }
    // Closed boxes: a path can only go from one to another that it has a point in common with.
    let meet = |a: &Values, b: &Values| a.iter().zip(b).all(|(a, b)| a.lo <= b.hi && b.lo <= a.hi);
    let start =
        scene.start.iter().map(|x| point(*x) + Interval { lo: -START_TOLERANCE, hi: START_TOLERANCE });
    let mut next: Vec<Values> = vec![start.collect()];
    let mut inside: Vec<Values> = Vec::new();
    while let Some(values) = next.pop() {
        ledger.work(10 * open.len() * values.len())?;
        let (near, far) = open.into_iter().partition(|other| meet(&values, other));
        next.extend::<Vec<_>>(near);
        open = far;
        inside.push(values);
    }
    unless(inside.len() > 1, "no box has the start in it")?;
    // Its own turning leaves its origin in place.
    let above = scene.objects[link].parent;
    slides_alone(scene, above)?;
    for values in &inside[1..] {
        ledger.work(100 * scene.goals.len())?;
        let origin = pose(scene, values, link, ledger)?.translation;
        let is_far = |goal: &Pose| length(sum(origin, minus(goal.translation))).lo > reach.hi;
        let mut left = scene.goals.iter().zip(&is_left).filter(|(_, is_left)| **is_left);
        unless(left.all(|(goal, _)| is_far(goal)), "a goal may be within reach")?;
    }
    Ok([count, inside.len() - 1, is_left.iter().filter(|is_left| !**is_left).count()])
}

/// Reads a goal and a point of an object that no joint moves against the tip: with the tip at the goal, a ball around the point is in
/// the object, and its middle in one that does not move; or a vertex of the object, and a ball around it is in the other (15). Returns
/// the goal.
fn blocked_goal(scene: &Scene<'_>, line: &mut Lines<'_>, ledger: &mut Ledger) -> Checked<usize> {
    let goal = line.index(scene.goals.len())?;
    let touch = Touch::read(scene, line.word()?, ledger)?;
    let [a, b] = touch.objects;
    let [to_a, to_b, to_tip] = [a, b, scene.tip].map(|of| scene.chain(None, of));
    ledger.work(1000 + 100 * (to_a.len() + to_b.len() + to_tip.len()))?;
    let shared = to_a.iter().zip(&to_tip).take_while(|(a, b)| a == b).count();
    let (to_a, to_tip) = (&to_a[shared..], &to_tip[shared..]);
    let is_still = |of: &usize| scene.objects[*of].motion.is_none();
    let is_rigid = to_a.iter().chain(to_tip).chain(&to_b).all(is_still);
    unless(is_rigid, "a joint moves the hand against the tip, or the other object")?;
    let to_own = |at, of: &usize| scene.objects[*of].pose.to_own(at);
    let in_shared = to_a.iter().rev().fold(touch.at, |at, of| scene.objects[*of].pose.of_point(at));
    let in_tip = to_tip.iter().fold(in_shared, to_own);
    let in_b = to_b.iter().fold(scene.goals[goal].of_point(in_tip), to_own);
    let moved = point(GOAL_TOLERANCE_M) + point(GOAL_TURN) * length(in_tip);
    touch.check(in_b, if touch.is_vertex { [ZERO, moved] } else { [moved, ZERO] }).map(|()| goal)
}

/// A mark `A,I,B,K,X,Y,Z`: solid I of object A, solid K of object B, of a pair that must not touch, and a point in the frame of A; or
/// `A,I,B,K,vN` with a vertex of a hull or a mesh.
struct Touch<'a> {
    objects: [usize; 2],
    solids: [&'a Solid; 2],
    at: Vector,
    is_vertex: bool,
}

impl<'a> Touch<'a> {
    fn read(scene: &'a Scene<'_>, mark: &str, ledger: &mut Ledger) -> Checked<Self> {
        let words: Vec<&str> = mark.split(',').collect();
        let [a, i, b, k, at @ ..] = &words[..] else { return Err("a mark that is none".to_owned()) };
        let objects = [Lines::whole(a, scene.objects.len())?, Lines::whole(b, scene.objects.len())?];
        let [a, b] = objects;
        let demanded = scene.pairs.binary_search_by_key(&[a.min(b), a.max(b)], |pair| pair.objects);
        unless(demanded.is_ok_and(|pair| scene.pairs[pair].distance >= 0.0), "a pair that may touch")?;
        let solid = |of: usize, index| {
            let solids = &scene.objects[of].solids;
            Lines::whole(index, solids.len()).map(|index| &solids[index])
        };
        let solids = [solid(a, i)?, solid(b, k)?];
        if let [Some(vertex)] = at.iter().map(|word| word.strip_prefix('v')).collect::<Vec<_>>()[..] {
            ledger.work(solids[0].faces())?;
            let at = solids[0].vertex(Lines::whole(vertex, solids[0].vertices())?)?;
            return Ok(Self { objects, solids, at, is_vertex: true });
        }
        let at: Vec<Interval> = at.iter().map(|x| Lines::parsed(x).map(point)).collect::<Checked<_>>()?;
        let at = at.try_into().map_err(|_| "a mark that is none")?;
        Ok(Self { objects, solids, at, is_vertex: false })
    }

    /// Checks that balls of these radii around the point, given in the frame of B, are in the solids.
    fn check(&self, in_b: Vector, radii: [Interval; 2]) -> Checked {
        let [of_a, of_b] = self.solids;
        let touch = (self.is_vertex || of_a.contains(self.at, radii[0])) && of_b.contains(in_b, radii[1]);
        unless(touch, "two objects that are not shown to touch")
    }
}

/// Bounds the distance of the tip from the origin of a link above it, and adds the tolerance of goals: the sum of the distances of
/// one point, for each link below that turns, on its axis from that of the one before.
fn reach(scene: &Scene<'_>, link: usize, line: &mut Lines<'_>) -> Checked<Interval> {
    let chain = scene.chain(None, scene.tip);
    let above = chain.iter().position(|index| *index == link).ok_or("the tip is not moved by this link")?;
    let (mut most, mut at) = (point(GOAL_TOLERANCE_M), ORIGIN);
    for object in chain[above + 1..].iter().map(|index| &scene.objects[*index]) {
        let Some(motion) = &object.motion else {
            at = object.pose.to_own(at);
            continue;
        };
        let mut next = ORIGIN;
        if motion.turns {
            next = scaled(motion.axis, point(line.real()?));
        } else {
            let end = |x| (point(motion.factor) * point(x) + point(motion.offset)).magnitude();
            let [lower, upper] = scene.joints[motion.joint].1;
            most = most + end(lower).max(end(upper));
        }
        most = most + length(sum(object.pose.of_point(next), minus(at)));
        at = next;
    }
    Ok(most + length(at))
}

/// Walks through a tree of boxes in prefix order: `sJ` halves the interval of the joint J, `.` leaves a box open, and
/// `A,I,B,K,X,Y,Z` excludes it, since a point of the solid I of object A is in the solid K of object B.
fn open_boxes(
    scene: &Scene<'_>,
    whole: Values,
    marks: &mut Lines<'_>,
    ledger: &mut Ledger,
) -> Checked<Vec<Values>> {
    let (mut stack, mut open) = (vec![(whole, 0)], Vec::new());
    while let Some((values, halvings)) = stack.pop() {
        unless(halvings <= MOST_HALVINGS, "too many halvings")?;
        ledger.work(10 + values.len())?;
        let mark = marks.word()?;
        if let Some(joint) = mark.strip_prefix('s') {
            let joint = Lines::whole(joint, values.len())?;
            let [mut first, mut second] = [values.clone(), values];
            let middle = first[joint].middle();
            (first[joint].hi, second[joint].lo) = (middle, middle);
            stack.extend([(second, halvings + 1), (first, halvings + 1)]);
        } else if mark == "." {
            open.push(values);
            unless(open.len() * scene.joints.len() <= MOST_VALUES, "more boxes than a certificate may have")?;
        } else {
            let touch = Touch::read(scene, mark, ledger)?;
            let [a, b] = touch.objects;
            slides_alone(scene, Some(a))?;
            slides_alone(scene, Some(b))?;
            let in_world = pose(scene, &values, a, ledger)?.of_point(touch.at);
            let in_b = pose(scene, &values, b, ledger)?.to_own(in_world);
            touch.check(in_b, [ZERO; 2])?;
        }
    }
    Ok(open)
}

/// Checks that no joint turns an object: both checkers then enclose its pose in the same way.
fn slides_alone(scene: &Scene<'_>, of: Option<usize>) -> Checked {
    let turns = |index: usize| scene.objects[index].motion.as_ref().is_some_and(|motion| motion.turns);
    let is_turned = of.is_some_and(|of| scene.chain(None, of).into_iter().any(turns));
    unless(!is_turned, "a joint turns what only slides may move")
}

/// Encloses the pose of an object in the world wherever the joints are in a box.
fn pose(scene: &Scene<'_>, values: &Values, of: usize, ledger: &mut Ledger) -> Checked<Pose> {
    ledger.work(500 * scene.objects.len() + 20 * values.len())?;
    Ok(Moment::of(scene, &vec![values.clone(); 2]).moved(None, of, (ORIGIN, ZERO)).pose)
}
