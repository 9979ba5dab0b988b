use cranny_spatial::{Point, Vector};

use crate::{JointKind, Robot};

/// Outer bound on the reachable positions of the tip: a ball whose centre moves with the slides of the base.
///
/// A point farther than the radius from every possible centre is unreachable; so are most points inside the bound.
#[derive(Clone, Debug, PartialEq)]
pub struct ReachBound {
    /// Centre of the ball with every slide of the base in the middle of its range, in the root frame.
    middle: Point,
    /// Half the stroke of each slide, mutually perpendicular.
    half_ways: Vec<Vector>,
    radius_m: f64,
}

/// Upper bound on the accumulated rounding of kinematics, in metres.
const ROUNDING_M: f64 = 1e-9;

/// Maximum cosine between the directions of two slides that count as perpendicular.
const RIGHT_ANGLE: f64 = 1e-9;

/// Number of rounds in which the points on the axes are moved in turn: for the dozen joints of an arm, the sum changes by less
/// than a millimetre after a dozen rounds. The bound is valid for any number of rounds.
const ROUNDS: usize = 24;

impl Robot {
    /// Bounds the positions of the tip within the joint limits.
    ///
    /// Law: `reach_bound().beyond_m(tip at q) = 0` for every q within limits (`no_tip_is_ever_beyond_the_bound`).
    ///
    /// 1. The slides before the first revolute joint translate the arm without turning it.
    /// 2. A revolute joint leaves the points on its axis fixed in both links that it connects. The distance between a point
    ///    on one axis and one on the next is therefore constant, and the sum of these distances along the arm bounds the
    ///    distance of the tip from the first of them. A slide adds half its stroke.
    /// 3. The points on the axes minimise that sum, which is convex in each of them.
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
        // 2. Pairs of neighbouring points at a constant distance.
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

/// Point that two neighbouring links of the arm share, at `q = 0`.
struct Axis {
    /// Position fixed to the link before it.
    before: Vector,
    /// Position fixed to the link behind it; equal to `before` except for a slide.
    after: Vector,
    /// Direction in which the point may be moved.
    along: Option<Vector>,
}

impl Axis {
    fn turning(point: Vector, along: Vector) -> Self {
        Self { before: point, after: point, along: Some(along) }
    }

    /// Moves the point along its axis to minimise the sum of its distances to both neighbours.
    fn shorten(&mut self, before: Option<Vector>, after: Option<Vector>) {
        let Some(along) = self.along else { return };
        let seen = |point: Vector| {
            let from = point - self.before;
            let way_m = from.dot(&along);
            (way_m, (from - along * way_m).norm())
        };
        let way_m = match (before.map(seen), after.map(seen)) {
            // Reflection principle: the point divides the distance along the axis in the ratio of the distances from the axis.
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
    /// Maximum distance of the tip from the centre of the ball, in metres.
    pub fn radius_m(&self) -> f64 {
        self.radius_m
    }

    /// Centre of the ball with every slide of the base in the middle of its range, in the root frame.
    pub fn middle(&self) -> &Point {
        &self.middle
    }

    /// Lower bound on the distance of the tip from `point_in_root`, in metres; 0 if the point is inside the bound.
    pub fn beyond_m(&self, point_in_root: &Point) -> f64 {
        let mut offset = point_in_root - self.middle;
        for half_way in &self.half_ways {
            let share = offset.dot(half_way) / half_way.norm_squared();
            offset -= half_way * share.clamp(-1.0, 1.0);
        }
        (offset.norm() - self.radius_m).max(0.0)
    }
}
