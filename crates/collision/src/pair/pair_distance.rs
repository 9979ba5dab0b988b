use cranny_robot::{JointKind, LinkFrames, Robot};
use cranny_shape::signed_distance;
use cranny_spatial::{Point, Vector};

use crate::cell::{Cell, Scratch};
use crate::pair::pairs::Pair;
use crate::touch::contact::Collider;

/// Signed distance of a pair, for methods that follow its gradient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairDistance {
    /// Index of the link.
    pub link: usize,
    /// Another link, or a body of the world.
    pub second: Collider,
    /// Least distance of the two that counts as free, in metres.
    pub required_m: f64,
    /// True for a link of the hand and the body to be grasped, or its support.
    pub is_of_grasp: bool,
    /// Distance, in metres: a certified lower bound, or minus the penetration depth.
    pub distance_m: f64,
    /// Closest point of the link, in the planning frame.
    pub on_link: Point,
    /// Closest point of the other, in the planning frame.
    pub on_second: Point,
    /// Unit vector from the other to the link, in the planning frame.
    pub normal: Vector,
}

impl PairDistance {
    /// Adds `weight · ∂distance/∂q` to `gradient` (metres per m or rad; one per joint), for the configuration at which `frames` were computed.
    ///
    /// Law: the gradient is the limit of finite differences of `distance_m` (test `gradients_are_those_of_finite_differences`).
    ///
    /// # Panics
    /// If `gradient` has not one value per joint.
    pub fn add_gradient(&self, robot: &Robot, frames: &LinkFrames, weight: f64, gradient: &mut [f64]) {
        self.add_motion(robot, frames, &(self.normal * weight), gradient);
    }

    /// Adds the product of `direction`, in the planning frame, with the motion of the closest point of the link relative to that
    /// of the other, per unit of each joint, to `row` (metres per m or rad; one per joint).
    ///
    /// # Panics
    /// If `row` has not one value per joint.
    pub fn add_motion(&self, robot: &Robot, frames: &LinkFrames, direction: &Vector, row: &mut [f64]) {
        let mut add = |link: usize, point: &Point, sign: f64| {
            for mover in robot.ancestors(link) {
                let world_from_child = frames.link(mover.child_link);
                let axis = world_from_child.rotation * mover.axis_in_child;
                let velocity = match mover.kind {
                    JointKind::Prismatic => axis,
                    JointKind::Revolute => axis.cross(&(point.coords - world_from_child.translation.vector)),
                };
                row[mover.joint] += sign * mover.multiplier * velocity.dot(direction);
            }
        };
        add(self.link, &self.on_link, 1.0);
        if let Collider::Link(second) = self.second {
            add(second, &self.on_second, -1.0);
        }
    }
}

impl Cell {
    /// Writes to `found` the signed distance of every pair at `q` (m, rad; one per joint) that is nearer than demanded plus
    /// `within_m` (m), in the order of the pairs. Leaves out pairs whose distance no joint changes, such as a base above the
    /// floor. The frames of `scratch` are then those of `q` ([`Scratch::frames`]).
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn pair_distances(
        &self,
        q: &[f64],
        within_m: f64,
        scratch: &mut Scratch,
        found: &mut Vec<PairDistance>,
    ) {
        found.clear();
        self.robot.forward_kinematics(q, &mut scratch.frames);
        let frames = &scratch.frames;
        for index in self.near_pairs(frames, |_| within_m) {
            let pair = self.pairs.get(index);
            let beyond_m = pair.required_m + within_m;
            if pair.is_exempt()
                || self.quick_bound(&pair, frames, beyond_m) > beyond_m
                || self.is_constant(&pair, frames)
            {
                continue;
            }
            found.extend(self.pair_distance(&pair, frames, beyond_m));
        }
    }

    fn pair_distance(&self, pair: &Pair, frames: &LinkFrames, beyond_m: f64) -> Option<PairDistance> {
        let mut nearest: Option<cranny_shape::SignedDistance> = None;
        for (pose_a, a) in self.placed(pair.first, frames) {
            for (pose_b, b) in self.placed_other(pair, frames) {
                let reach_m = nearest.map_or(beyond_m, |nearest| nearest.distance_m);
                if reach_m > 0.0 && cranny_shape::quick_lower_bound(a, &pose_a, b, &pose_b, reach_m) > reach_m
                {
                    continue;
                }
                let distance = signed_distance(a, &pose_a, b, &pose_b, reach_m.max(0.0));
                if let Some(nearer) = distance.filter(|distance| distance.distance_m < reach_m) {
                    nearest = Some(nearer);
                }
            }
        }
        let nearest = nearest?;
        let (link, second) = (self.bodies[pair.first].link, self.other(pair));
        let is_of_grasp = matches!(second, Collider::Body(body) if self.grasp_bodies.contains(&body))
            && self.robot.hand_links().contains(&link);
        Some(PairDistance {
            link,
            second,
            required_m: pair.required_m,
            is_of_grasp,
            distance_m: nearest.distance_m,
            on_link: nearest.on_a,
            on_second: nearest.on_b,
            normal: nearest.normal,
        })
    }
}

impl Scratch {
    /// Frames of all links at the configuration of the last call.
    pub fn frames(&self) -> &LinkFrames {
        &self.frames
    }
}
