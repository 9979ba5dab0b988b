//! Motion of the links along an interval of a curve in the joints, with bounds on velocity and acceleration.

use super::interval::{Interval, ONE, ORIGIN, Vector, ZERO, cross, dot, length, minus, point};
use super::interval::{product, scaled, sum, times, transposed_times};
use super::scene::{Bound, Pose, Scene, rotation};
use super::solid::{Object, Span};

/// Control points of a curve, one interval for each joint.
pub type Curve = Vec<Vec<Interval>>;

/// Robot in the middle of an interval.
pub struct Moment<'a> {
    scene: &'a Scene<'a>,
    /// Value and rate of each joint, and the greatest magnitudes of its rate and second derivative along the interval (5).
    joints: Vec<[Interval; 4]>,
    /// Pose of each link in its parent.
    links: Vec<Pose>,
}

/// Part of an object along an interval, in a common frame: pose in the middle, velocity there of the point `center`, angular
/// velocity, and bounds on the acceleration of its points (6) and of its directions of length 1 (12).
pub struct Moved {
    pub pose: Pose,
    center: Vector,
    velocity: Vector,
    turn: Vector,
    pub acceleration: Interval,
    swing: Interval,
}

/// Returns both halves of a curve (5).
pub fn halves(curve: &Curve) -> [Curve; 2] {
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

fn differences(curve: &[Vec<Interval>]) -> Curve {
    let difference = |pair: &[Vec<Interval>]| pair[0].iter().zip(&pair[1]).map(|(a, b)| *b - *a).collect();
    curve.windows(2).map(difference).collect()
}

impl<'a> Moment<'a> {
    pub fn of(scene: &'a Scene<'a>, curve: &Curve) -> Self {
        let degree = curve.len() - 1;
        let [left, right] = halves(curve);
        let steps = differences(curve);
        let bends = differences(&steps);
        let rates = &differences(&[left[degree - 1].clone(), right[1].clone()])[0];
        let most = |rows: &Curve, j: usize| rows.iter().fold(ZERO, |most, row| most.max(row[j].magnitude()));
        let factor = point(degree as f64);
        let joint = |j: usize| {
            let bend = factor * (factor - ONE) * most(&bends, j);
            [right[0][j], factor * rates[j], factor * most(&steps, j), bend]
        };
        let joints: Vec<[Interval; 4]> = (0..rates.len()).map(joint).collect();
        let links = scene.objects.iter().map(|object| local(object, &joints)).collect();
        Self { scene, joints, links }
    }

    /// Computes the motion relative to the link `top` of a part of an object that is in a ball, given by its centre and radius
    /// (6).
    pub fn moved(&self, top: Option<usize>, of: usize, (center, radius): (Vector, Interval)) -> Moved {
        let (mut pose, mut before, mut movers) = (Pose::default(), ZERO, Vec::new());
        for index in self.scene.chain(top, of) {
            pose = after(&pose, &self.links[index]);
            if let Some(motion) = &self.scene.objects[index].motion {
                let factor = point(motion.factor);
                let [_, rate, fastest, bend] = self.joints[motion.joint].map(|x| x * factor);
                movers.push((motion, pose, rate, fastest.magnitude(), bend.magnitude(), before));
                before = if motion.turns { before + fastest.magnitude() } else { before };
            }
        }
        let center = sum(times(&pose.rotation, center), pose.translation);
        let mut moved =
            Moved { pose, center, velocity: ORIGIN, turn: ORIGIN, acceleration: ZERO, swing: ZERO };
        let mut beyond = ZERO;
        for (motion, pose, rate, fastest, bend, before) in movers.into_iter().rev() {
            let axis = times(&pose.rotation, motion.axis);
            let (mut arm, mut reach, mut bend) = (axis, ONE, bend + point(2.0) * fastest * before);
            if motion.turns {
                arm = cross(axis, sum(moved.center, minus(pose.translation)));
                reach = length(arm) + radius + point(0.5) * beyond;
                bend = bend + fastest.square();
                moved.turn = sum(moved.turn, scaled(axis, rate));
                moved.swing = moved.swing + bend;
            }
            moved.velocity = sum(moved.velocity, scaled(arm, rate));
            moved.acceleration = moved.acceleration + reach * bend;
            beyond = beyond + fastest * reach;
        }
        moved
    }
}

impl Moved {
    /// Returns an interval whose upper end bounds n·(p + s·p') over the part (7).
    pub fn reach(&self, object: &Object<'_>, span: Span, n: Vector, s: Interval) -> Interval {
        let turned = scaled(cross(n, self.turn), s);
        let along = sum(n, turned);
        let local = object.support(span, transposed_times(&self.pose.rotation, along));
        point(local) + dot(along, self.pose.translation) + s * dot(n, self.velocity)
            - dot(turned, self.center)
    }
}

impl Bound {
    /// Returns true if the bound is kept along the interval (12).
    pub fn holds(&self, moment: &Moment<'_>) -> bool {
        let moved = moment.moved(None, self.link, (self.point, ZERO));
        let along = times(&moved.pose.rotation, self.point);
        let (at, velocity, bend) = match self.is_direction {
            true => (along, cross(moved.turn, along), moved.swing),
            false => (moved.center, moved.velocity, moved.acceleration),
        };
        let most = |far: Interval| (far + bend * point(0.125)).hi;
        [-0.5, 0.5].map(point).into_iter().all(|s| {
            let off = sum(sum(at, minus(self.pose.translation)), scaled(velocity, s));
            let in_box = transposed_times(&self.pose.rotation, off).map(Interval::magnitude);
            most(length(off)) < self.radius && (0..3).all(|i| most(in_box[i]) < self.half[i])
        })
    }
}

fn after(first: &Pose, second: &Pose) -> Pose {
    let translation = sum(first.translation, times(&first.rotation, second.translation));
    Pose { rotation: product(&first.rotation, &second.rotation), translation }
}

/// Returns the pose of a link in its parent (3).
fn local(object: &Object<'_>, joints: &[[Interval; 4]]) -> Pose {
    let Some(motion) = &object.motion else { return object.pose };
    let value = joints[motion.joint][0] * point(motion.factor) + point(motion.offset);
    let moved = if motion.turns {
        let [sine, cosine] = (value * point(0.5)).sin_cos();
        let [x, y, z] = scaled(motion.axis, sine);
        Pose { rotation: rotation([cosine, x, y, z]), ..Pose::default() }
    } else {
        Pose { translation: scaled(motion.axis, value), ..Pose::default() }
    };
    after(&object.pose, &moved)
}
