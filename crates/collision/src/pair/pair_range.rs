use std::collections::VecDeque;

use cranny_robot::{JointKind, LinkFrames, Robot};
use cranny_shape::{Solid, TriangleSoup, overlap};
use cranny_spatial::{CONTACT_M, Pose, ROUNDING_M, Rotation, Vector};

use crate::body::extent::is_round;
use crate::body::link_body::{LinkBody, group_separation};
use crate::proof::joint_curve::Rates;
use crate::proof::travel::{Travel, shared_joints};

/// Proven result on two links for all values of the joints between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum PairRange {
    /// They touch at every value; the depth is the least one measured (m).
    AlwaysTouching { depth_m: f64 },
    /// They touch at no value.
    NeverTouching,
    /// They are free at one value and touch, at this depth (m), or may touch, at another. If `is_at_joint`, they are proven to
    /// touch only near their joint; otherwise they may also touch elsewhere.
    Both { is_at_joint: bool, depth_m: f64 },
    /// One value refutes the property; the others were not tried.
    Refuted,
    /// The maximum number of boxes proves nothing. The links touched in the middle of every box, with at least this depth (m),
    /// or in none; in the latter case they are proven not to touch away from their joint.
    Unproven { depth_m: f64 },
}

/// Property of two links to be proven.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Question {
    /// Contact at every value: the first value at which they are free refutes it.
    AlwaysTouching,
    /// Contact at every value, or at no value.
    AlwaysAlike,
    /// Contact at no value: the first value at which they touch refutes it.
    NeverTouching,
}

/// Proofs about pairs of links over the whole range of the joints between them.
///
/// 1. A box of joint values is evaluated at its middle. Within the box, no point of either link moves farther relative to the
///    other than the travel `t` ([`Travel::between`]).
/// 2. Links farther apart than `t` touch nowhere in the box. Convex solids that penetrate each other deeper than `t` touch
///    everywhere in it: separating them takes a relative motion of more than `t`.
/// 3. Any other box is bisected across the joint that moves the links most.
///
/// Boxes are evaluated from the widest on, so a range of free values is found if it is wider than the smallest boxes: for a
/// single joint, a thousandth of its range.
pub(crate) struct PairRanges<'a> {
    robot: &'a Robot,
    bodies: &'a [LinkBody],
    frames: LinkFrames,
    travel: Travel,
    q: Vec<f64>,
    rates: Rates,
}

/// Maximum number of boxes for one pair: each takes some 10 to 200 µs.
const MOST_BOXES: usize = 20_000;

/// Maximum number of intervals of the range of a single joint: the last are less than a thousandth of it.
const MOST_PIECES: usize = 4095;

/// Fraction of the measured depth of two convex solids that counts; the search finds the depth to within a thousandth.
const BELIEVED: f64 = 0.9;

/// Box of values of the joints between two links: lower and upper limit of each.
type JointBox = Vec<[f64; 2]>;

impl<'a> PairRanges<'a> {
    pub fn new(robot: &'a Robot, bodies: &'a [LinkBody]) -> Self {
        Self {
            robot,
            bodies,
            frames: robot.frames(),
            travel: Travel::new(robot, bodies),
            q: robot.limits().iter().map(|limits| 0.5 * (limits.lower + limits.upper)).collect(),
            rates: Rates::still(robot.dof()),
        }
    }

    /// Proves a property of a pair of links over the range of their joints.
    pub fn of(&mut self, pair: (usize, usize), question: Question) -> PairRange {
        let shared = shared_joints(self.robot, self.bodies[pair.0].link, self.bodies[pair.1].link);
        let joints = self.joints_between(pair, shared);
        let whole: JointBox =
            joints.iter().map(|&joint| self.robot.limits()[joint]).map(|l| [l.lower, l.upper]).collect();
        let (mut boxes, mut is_free, mut least_depth_m) = (VecDeque::from([whole]), false, None::<f64>);
        for _ in 0..if joints.len() == 1 { MOST_PIECES } else { MOST_BOXES } {
            let Some(values) = boxes.pop_front() else {
                return match least_depth_m {
                    Some(depth_m) => PairRange::AlwaysTouching { depth_m },
                    None => PairRange::NeverTouching,
                };
            };
            let travel_m = self.travel_m(pair, shared, &joints, &values);
            let [first, second] = [pair.0, pair.1].map(|body| &self.bodies[body]);
            let enough_m = CONTACT_M + travel_m;
            let others = second.placed(&self.frames);
            let gap = group_separation(first.placed(&self.frames), &others, enough_m);
            if gap.lower_m > CONTACT_M {
                if question == Question::AlwaysTouching {
                    return PairRange::Refuted;
                }
                is_free = true;
            } else {
                if question == Question::NeverTouching {
                    return PairRange::Refuted;
                }
                let depth_m = self.deepest_m(pair);
                least_depth_m = Some(least_depth_m.map_or(depth_m, |least| least.min(depth_m)));
                if BELIEVED * depth_m > travel_m {
                    continue;
                }
            }
            if let Some(depth_m) = least_depth_m.filter(|_| is_free) {
                return PairRange::Both { is_at_joint: self.touch_at_joint_alone(pair, shared), depth_m };
            }
            if gap.lower_m < enough_m {
                boxes.extend(self.halves(pair, shared, &joints, values).into_iter().flatten());
            }
        }
        match least_depth_m {
            None if question == Question::AlwaysAlike && !self.touch_at_joint_alone(pair, shared) => {
                PairRange::Both { is_at_joint: false, depth_m: 0.0 }
            }
            depth_m => PairRange::Unproven { depth_m: depth_m.unwrap_or(0.0) },
        }
    }

    /// Returns the joints on which the relative pose of the pair depends, as indices into `q`.
    fn joints_between(&self, pair: (usize, usize), shared: usize) -> Vec<usize> {
        let chain = |body: usize| self.robot.ancestors(self.bodies[body].link).iter().skip(shared);
        let mut joints: Vec<usize> = chain(pair.0).chain(chain(pair.1)).map(|mover| mover.joint).collect();
        joints.sort_unstable();
        joints.dedup();
        joints
    }

    /// Computes the frames at the middle of a box, and bounds the relative motion of the links within it (m).
    fn travel_m(&mut self, pair: (usize, usize), shared: usize, joints: &[usize], values: &JointBox) -> f64 {
        self.rates.now.fill(0.0);
        for (&joint, [lower, upper]) in joints.iter().zip(values) {
            self.q[joint] = 0.5 * (lower + upper);
            self.rates.now[joint] = 0.5 * (upper - lower) * (1.0 + f64::EPSILON);
        }
        self.robot.forward_kinematics(&self.q, &mut self.frames);
        self.slope_travel_m(pair, shared) + ROUNDING_M
    }

    fn slope_travel_m(&mut self, pair: (usize, usize), shared: usize) -> f64 {
        self.travel.forget();
        for body in [pair.0, pair.1] {
            self.travel.know(self.robot, self.bodies, body, &self.frames, &self.rates, 1.0);
        }
        self.travel.between(pair.0, pair.1, shared)
    }

    /// Bisects a box across the joint that moves the links most; `None` at the resolution of rounding.
    fn halves(
        &mut self,
        pair: (usize, usize),
        shared: usize,
        joints: &[usize],
        values: JointBox,
    ) -> Option<[JointBox; 2]> {
        let mut most = (0.0, None);
        for (place, (&joint, [lower, upper])) in joints.iter().zip(&values).enumerate() {
            self.rates.now.fill(0.0);
            self.rates.now[joint] = 0.5 * (upper - lower);
            let travel_m = self.slope_travel_m(pair, shared);
            if travel_m > most.0 {
                most = (travel_m, Some(place));
            }
        }
        let place = most.1.filter(|_| most.0 > ROUNDING_M)?;
        let middle = 0.5 * (values[place][0] + values[place][1]);
        let mut halves = [values.clone(), values];
        halves[0][place][1] = middle;
        halves[1][place][0] = middle;
        Some(halves)
    }

    /// Returns the greatest penetration depth of two convex solids of the links, in metres.
    fn deepest_m(&self, pair: (usize, usize)) -> f64 {
        let [first, second] = [pair.0, pair.1].map(|body| &self.bodies[body]);
        let others: Vec<_> = second.placed(&self.frames).collect();
        let is_convex = |solid: &Solid| solid.support_point(&Vector::x()).is_some();
        let mut depth_m = 0.0_f64;
        for (pose_a, a) in first.placed(&self.frames).filter(|(_, solid)| is_convex(solid)) {
            for (pose_b, b) in others.iter().filter(|(_, solid)| is_convex(solid)) {
                depth_m = overlap(a, &pose_a, b, pose_b).map_or(depth_m, |found| depth_m.max(found.depth_m));
            }
        }
        depth_m
    }

    /// Returns true if two links that are free at one value of their only joint touch, at all others, only near its axis: their
    /// surfaces beyond [`Self::joint_neighbourhood_m`] are proven never to meet, so neither can penetrate the other there.
    /// Always false for a prismatic joint.
    fn touch_at_joint_alone(&self, pair: (usize, usize), shared: usize) -> bool {
        let movers = [pair.0, pair.1].map(|body| self.robot.ancestors(self.bodies[body].link).get(shared..));
        let mut movers = movers.into_iter().flatten().flatten();
        let (Some(mover), None) = (movers.next(), movers.next()) else { return false };
        if mover.kind == JointKind::Prismatic {
            return false;
        }
        let world_from_child = self.frames.link(mover.child_link);
        let radius_m = self.joint_neighbourhood_m(pair);
        let outer = |body: usize| {
            let LinkBody { link, shapes, .. } = &self.bodies[body];
            let child_from_link = world_from_child.inv_mul(self.frames.link(*link));
            let far = shapes.iter().flat_map(|(link_from_solid, solid)| {
                let pose = child_from_link * link_from_solid;
                beyond_axis(solid, &pose, &mover.axis_in_child, radius_m)
                    .into_iter()
                    .map(|surface| (*link_from_solid, surface))
            });
            LinkBody::of_shapes(*link, far.collect())
        };
        let [Some(first), Some(second)] = [pair.0, pair.1].map(outer) else { return true };
        let bodies = [first, second];
        PairRanges::new(self.robot, &bodies).of((0, 1), Question::NeverTouching) == PairRange::NeverTouching
    }

    /// Returns the distance from the axis of their joint within which two links count as being at the joint, in metres: the sum
    /// of their thicknesses.
    fn joint_neighbourhood_m(&self, pair: (usize, usize)) -> f64 {
        let thickness_m = |body: usize| 2.0 * self.bodies[body].bounds.aabb.half_extents.min();
        thickness_m(pair.0) + thickness_m(pair.1)
    }
}

/// Returns triangles around a convex solid: its tessellation, scaled from its centre until each face is outside the solid.
fn around(solid: &Solid) -> TriangleSoup {
    let mut soup = solid.tessellation().unwrap_or_default();
    if is_round(solid) {
        let growth = (0..soup.triangles.len()).filter_map(|triangle| {
            let [a, b, c] = soup.corners(triangle);
            let outwards = (b - a).cross(&(c - a)).try_normalize(0.0)?;
            Some(outwards.dot(&solid.support_point(&outwards)?.coords) / outwards.dot(&a.coords))
        });
        let growth = growth.fold(1.0, f64::max);
        soup.vertices.iter_mut().for_each(|vertex| *vertex *= growth);
    }
    soup
}

/// Number of sides of the prism that approximates a cylinder.
const SIDES: u32 = 12;

/// Returns the surface of a solid, at a pose relative to an axis through the origin, outside the prism around a cylinder about
/// that axis: one solid per side, in the frame of the solid. The surface of a round solid is circumscribed.
fn beyond_axis(solid: &Solid, pose: &Pose, axis: &Vector, radius_m: f64) -> Vec<Solid> {
    let is_mesh = solid.support_point(&Vector::x()).is_none();
    let surface =
        if is_mesh { solid.clone() } else { Solid::mesh(&around(solid)).expect("a closed surface") };
    let across = axis.cross(&Vector::ith(axis.iamin(), 1.0)).normalize();
    let sides = (0..SIDES).filter_map(|side| {
        let angle = std::f64::consts::TAU * f64::from(side) / f64::from(SIDES);
        let direction = Rotation::from_scaled_axis(axis * angle) * across;
        let height_m = radius_m - direction.dot(&pose.translation.vector);
        surface.surface_above(&(pose.rotation.inverse() * direction), height_m)
    });
    sides.collect()
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use cranny_robot::RobotOptions;
    use cranny_spatial::Stream;

    use super::*;

    /// Builds a chain of up to five links, each a box, a ball or a capsule of random size and position.
    fn chain(random: &mut Stream) -> Robot {
        let mut draw = |low: f64, high: f64| random.uniform_between(low, high);
        let mut text = String::from(r#"<robot name="chain">"#);
        for link in 0..5 {
            let (x, y, z) = (draw(0.01, 0.2), draw(0.01, 0.2), draw(0.01, 0.2));
            let shape = match draw(0.0, 3.0) {
                kind if kind < 1.0 => format!(r#"<sphere radius="{x}"/>"#),
                kind if kind < 2.0 => format!(r#"<capsule radius="{}" length="{z}"/>"#, 0.5 * x),
                _ => format!(r#"<box size="{x} {y} {z}"/>"#),
            };
            let (a, b, c) = (draw(-0.1, 0.1), draw(-0.1, 0.1), draw(-0.1, 0.1));
            let _ = write!(
                text,
                r#"<link name="l{link}"><collision><origin xyz="{a} {b} {c}" rpy="{b} {c} {a}"/><geometry>{shape}</geometry></collision></link>"#
            );
            if link > 0 {
                let kind = if draw(0.0, 1.0) < 0.8 { "revolute" } else { "prismatic" };
                let reach = if kind == "revolute" { draw(0.2, 3.0) } else { draw(0.01, 0.2) };
                let (x, y, z) = (draw(-0.15, 0.15), draw(-0.15, 0.15), draw(-0.15, 0.15));
                let _ = write!(
                    text,
                    r#"<joint name="j{link}" type="{kind}"><origin xyz="{x} {y} {z}"/><parent link="l{}"/><child link="l{link}"/>
                    <axis xyz="{} {} {}"/><limit lower="-{reach}" upper="{reach}" velocity="1" effort="1"/></joint>"#,
                    link - 1,
                    draw(-1.0, 1.0),
                    draw(-1.0, 1.0),
                    draw(0.1, 1.0)
                );
            }
        }
        Robot::from_urdf_text(&(text + "</robot>"), "chain.urdf", None, &RobotOptions::default())
            .expect("a good URDF")
    }

    #[test]
    fn triangles_around_what_is_round_leave_nothing_out() {
        for solid in [Solid::sphere(0.05), Solid::capsule(0.3, 0.05), Solid::cylinder(0.3, 0.05)] {
            let solid = solid.unwrap();
            let (soup, mut random) = (around(&solid), Stream::new(5, 0));
            for _ in 0..1000 {
                let way = Vector::from_fn(|_, _| random.uniform_between(-1.0, 1.0)).normalize();
                let point = solid.support_point(&way).unwrap();
                for triangle in 0..soup.triangles.len() {
                    let [a, b, c] = soup.corners(triangle);
                    let beyond_m = (b - a).cross(&(c - a)).normalize().dot(&(point - a));
                    assert!(beyond_m < 1e-12, "{beyond_m}");
                }
            }
            let growth = soup.vertices.iter().map(|vertex| vertex.coords.norm()).fold(0.0, f64::max)
                / solid.tessellation().unwrap().vertices.iter().map(|v| v.coords.norm()).fold(0.0, f64::max);
            assert!(growth < 1.01, "{growth}");
        }
    }

    #[test]
    fn what_is_proven_of_a_pair_holds_at_every_sample() {
        let (chains, samples) = (40, 200);
        let mut random = Stream::new(11, 0);
        let (mut always, mut never) = (0, 0);
        for _ in 0..chains {
            let robot = chain(&mut random);
            let bodies = LinkBody::all(&robot);
            let mut ranges = PairRanges::new(&robot, &bodies);
            for pair in [(0, 1), (1, 2), (3, 4), (0, 2), (1, 3), (0, 3)] {
                let range = ranges.of(pair, Question::AlwaysAlike);
                let is_touching = match range {
                    PairRange::AlwaysTouching { .. } => true,
                    PairRange::NeverTouching => false,
                    _ => continue,
                };
                *(if is_touching { &mut always } else { &mut never }) += 1;
                for _ in 0..samples {
                    let frames = robot.frames_at(&robot.random_configuration(&mut random));
                    let others = bodies[pair.1].placed(&frames);
                    let gap = group_separation(bodies[pair.0].placed(&frames), &others, 1.0);
                    assert_eq!(gap.lower_m <= CONTACT_M, is_touching, "{pair:?}: {range:?}, but {gap:?}");
                }
            }
        }
        assert!(always > 10 && never > 10, "{always} always, {never} never");
    }
}
