use cranny_spatial::{Point, Vector};

use crate::{JointKind, Robot};

/// Where the tip of a robot can be at most: within a ball whose middle slides with the base.
///
/// A point farther than that from everywhere the middle can be is out of reach, whatever the joints do; most
/// points within are out of reach too.
#[derive(Clone, Debug, PartialEq)]
pub struct ReachBound {
    /// The middle of the ball while every slide of the base stands half way, in the root frame.
    middle: Point,
    /// Half the way of each slide, at right angles to each other.
    half_ways: Vec<Vector>,
    radius_m: f64,
}

/// More than the rounding of kinematics adds up to, in metres.
const ROUNDING_M: f64 = 1e-9;

/// Slides whose directions have a greater cosine are not at right angles.
const RIGHT_ANGLE: f64 = 1e-9;

/// How often the points on the axes are moved in turn: arms have a dozen joints at most, and after a dozen
/// rounds the sum changes by less than a millimetre. However often, the bound holds.
const ROUNDS: usize = 24;

impl Robot {
    /// A bound of where the tip can be within the joint limits.
    ///
    /// Law: `reach_bound().beyond_m(tip at q) = 0` for every q within limits
    /// (`no_tip_is_ever_beyond_the_bound`).
    ///
    /// 1. The slides before the first joint that turns shift the arm without turning it.
    /// 2. A joint that turns leaves the points on its axis where they are, on both sides of it. So the
    ///    distance between a point on one axis and one on the next never changes, and their sum along the arm
    ///    bounds how far the tip gets from the first of them. A slide adds half its way.
    /// 3. The points on the axes are those of the least sum; it is convex in each of them.
    pub fn reach_bound(&self) -> ReachBound {
        let movers = self.ancestors(self.tip());
        let frames = self.frames();
        let origin = |link: usize| frames.link(link).translation.vector;
        let axis_of = |link: usize, axis: &Vector| frames.link(link).rotation * axis;
        let way_of = |joint: usize, multiplier: f64| {
            let limits = self.limits()[joint];
            [
                0.5 * multiplier * (limits.lower + limits.upper),
                0.5 * (multiplier * (limits.upper - limits.lower)).abs(),
            ]
        };
        // 1.
        let slides = movers.iter().take_while(|mover| mover.kind == JointKind::Prismatic).count();
        let (mut shift, mut half_ways, mut radius_m) = (Vector::zeros(), Vec::<Vector>::new(), ROUNDING_M);
        for mover in &movers[..slides] {
            let axis = axis_of(mover.child_link, &mover.axis_in_child);
            let [half_way_m, reach_m] = way_of(mover.joint, mover.multiplier);
            shift += axis * half_way_m;
            if half_ways.iter().all(|other| other.normalize().dot(&axis).abs() < RIGHT_ANGLE) && reach_m > 0.0
            {
                half_ways.push(axis * reach_m);
            } else {
                radius_m += reach_m;
            }
        }
        // 2. Pairs of neighbouring points that keep their distance.
        let mut axes: Vec<Axis> = Vec::new();
        for mover in &movers[slides..] {
            let axis_in_root = axis_of(mover.child_link, &mover.axis_in_child);
            let origin = origin(mover.child_link);
            axes.push(match mover.kind {
                JointKind::Revolute => Axis::turning(origin, axis_in_root),
                JointKind::Prismatic => {
                    let [half_way_m, reach_m] = way_of(mover.joint, mover.multiplier);
                    radius_m += reach_m;
                    Axis { before: origin + axis_in_root * half_way_m, after: origin, along: None }
                }
            });
        }
        let tip = origin(self.tip());
        axes.push(Axis { before: tip, after: tip, along: None });
        // 3.
        for _ in 0..ROUNDS {
            for index in 0..axes.len() {
                let before = index.checked_sub(1).map(|before| axes[before].after);
                let after = axes.get(index + 1).map(|after| after.before);
                axes[index].shorten(before, after);
            }
        }
        radius_m += axes.windows(2).map(|pair| (pair[1].before - pair[0].after).norm()).sum::<f64>();
        ReachBound { middle: Point::from(axes[0].before + shift), half_ways, radius_m }
    }
}

/// A point that two neighbouring parts of the arm share, at `q = 0`.
struct Axis {
    /// As the part before it has it.
    before: Vector,
    /// As the part behind it has it: the same, but for a slide.
    after: Vector,
    /// The direction in which the point may be moved.
    along: Option<Vector>,
}

impl Axis {
    fn turning(point: Vector, along: Vector) -> Self {
        Self { before: point, after: point, along: Some(along) }
    }

    /// Moves the point to where the way from one neighbour to the other over it is shortest.
    fn shorten(&mut self, before: Option<Vector>, after: Option<Vector>) {
        let Some(along) = self.along else { return };
        let seen = |point: Vector| {
            let from = point - self.before;
            let way_m = from.dot(&along);
            (way_m, (from - along * way_m).norm())
        };
        let way_m = match (before.map(seen), after.map(seen)) {
            // Like light in a mirror: the point divides the way as the distances from the axis do.
            (Some((a, from_a)), Some((b, from_b))) if from_a + from_b > ROUNDING_M => {
                (a * from_b + b * from_a) / (from_a + from_b)
            }
            (Some((way_m, _)), _) | (None, Some((way_m, _))) => way_m,
            (None, None) => return,
        };
        self.before += along * way_m;
        self.after = self.before;
    }
}

impl ReachBound {
    /// The greatest distance of the tip from the ball's middle, in metres.
    pub fn radius_m(&self) -> f64 {
        self.radius_m
    }

    /// How far, at least, the tip stays from `point_in_root`, in metres; 0 where it may get there.
    pub fn beyond_m(&self, point_in_root: &Point) -> f64 {
        let mut offset = point_in_root - self.middle;
        for half_way in &self.half_ways {
            let share = offset.dot(half_way) / half_way.norm_squared();
            offset -= half_way * share.clamp(-1.0, 1.0);
        }
        (offset.norm() - self.radius_m).max(0.0)
    }
}
