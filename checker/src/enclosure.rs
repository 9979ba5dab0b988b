//! Check that no motion leads from the start to a goal (14): boxes of joint values in which two objects touch, and the reach of
//! the arm from those boxes that are left.

use super::certificate::{GOAL_TOLERANCE_M, START_TOLERANCE};
use super::interval::{Interval, ORIGIN, ZERO, length, minus, point, scaled, sum};
use super::lines::{Checked, Lines, unless};
use super::motion::Moment;
use super::proof::{Ledger, MOST_HALVINGS};
use super::scene::{Pose, Scene};

/// Maximum number of boxes that are left open, times that of joints: it limits the memory.
const MOST_VALUES: usize = 2_000_000;

/// Interval of each joint.
type Values = Vec<Interval>;

/// Reads the link from which the reach counts and the tree of boxes: returns the number of boxes that are not excluded, and of
/// those of them that the start is connected with.
pub fn enclosure(lines: &mut Lines<'_>, scene: &Scene<'_>, ledger: &mut Ledger) -> Checked<[usize; 2]> {
    let (link, reach) = lines.read("none", |line| {
        let link = line.index(scene.objects.len())?;
        Ok((link, reach(scene, link, line)?))
    })?;
    let whole = scene.joints.iter().map(|(_, [lo, hi])| Interval { lo: *lo, hi: *hi }).collect();
    let mut open = lines.read("boxes", |marks| open_boxes(scene, whole, marks, ledger))?;
    let count = open.len();
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
        unless(scene.goals.iter().all(is_far), "a goal may be within reach")?;
    }
    Ok([count, inside.len() - 1])
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
            let words: Vec<&str> = mark.split(',').collect();
            let [a, i, b, k, at @ ..] = &words[..] else { return Err("a mark that is none".to_owned()) };
            let [a, b] = [Lines::whole(a, scene.objects.len())?, Lines::whole(b, scene.objects.len())?];
            let demanded = scene.pairs.iter().find(|pair| pair.objects == [a.min(b), a.max(b)]);
            unless(demanded.is_some_and(|pair| pair.distance >= 0.0), "a pair that may touch")?;
            let at: Vec<Interval> = at.iter().map(|x| Lines::parsed(x).map(point)).collect::<Checked<_>>()?;
            let at = at.try_into().map_err(|_| "a mark that is none")?;
            let of_a = &scene.objects[a].solids[Lines::whole(i, scene.objects[a].solids.len())?];
            let of_b = &scene.objects[b].solids[Lines::whole(k, scene.objects[b].solids.len())?];
            slides_alone(scene, Some(a))?;
            slides_alone(scene, Some(b))?;
            let in_world = pose(scene, &values, a, ledger)?.of_point(at);
            let in_b = pose(scene, &values, b, ledger)?.to_own(in_world);
            unless(of_a.contains(at) && of_b.contains(in_b), "two objects that are not shown to touch")?;
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
