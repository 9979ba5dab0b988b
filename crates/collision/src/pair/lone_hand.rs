use cranny_shape::{Solid, overlap};
use cranny_spatial::{Pose, Vector};

use crate::body::link_body::group_separation;
use crate::cell::{Cell, Scratch};
use crate::lane::lane_scratch::as_index;
use crate::pair::pairs::{Other, Pair};
use crate::touch::contact::{Collider, Contact};

/// Upper bound of the error of a computed depth, in metres.
const DEPTH_ERROR_M: f64 = 1e-6;

impl Cell {
    /// Returns true if the hand alone ([`hand_links`](cranny_robot::Robot::hand_links)), with the gripper frame of the robot's tip at `world_from_tip`,
    /// keeps its distance from every body of the world. If not, every configuration with that tip pose is in collision.
    pub fn hand_is_free(&self, world_from_tip: &Pose, scratch: &mut Scratch) -> bool {
        self.hand_contact(world_from_tip, scratch).is_none()
    }

    /// Returns the first contact of the hand alone at `world_from_tip`, if any ([`Self::hand_is_free`]).
    pub fn hand_contact(&self, world_from_tip: &Pose, scratch: &mut Scratch) -> Option<Contact> {
        self.pairs_near_hand(*world_from_tip, scratch).find_map(|(pair, world_from_link)| {
            let body = &self.bodies[pair.first];
            let Other::Part(index) = pair.second else { return None };
            let (body_index, part) = &self.around.parts[index];
            if body.quick_bound_to(&world_from_link, part, pair.required_m) > pair.required_m {
                return None;
            }
            let shapes = body.shapes.iter().map(|(pose, solid)| (world_from_link * pose, solid));
            let placed = std::iter::once((part.world_from_solid, &part.solid));
            let gap = group_separation(shapes, &placed, pair.required_m);
            (gap.lower_m < pair.required_m).then_some(Contact {
                first: Collider::Link(body.link),
                second: Collider::Body(*body_index),
                clearance_m: gap.lower_m,
                required_m: pair.required_m,
                depth_m: 0.0,
                point: None,
            })
        })
    }

    /// Returns the pairs of links of the hand and parts of the world that are near, with the poses of the links.
    fn pairs_near_hand<'a>(
        &'a self,
        world_from_tip: Pose,
        scratch: &'a mut Scratch,
    ) -> impl Iterator<Item = (Pair, Pose)> + 'a {
        // The links of the hand are rigidly connected to the tip, so their relative poses are the same in any configuration.
        scratch.q.fill(0.0);
        self.robot.forward_kinematics(&scratch.q, &mut scratch.frames);
        let frames = &scratch.frames;
        let tip_from_root = frames.link(self.robot.tip()).inverse();
        let of_hand = self.pairs.with_parts().filter(|pairs| pairs.is_of_hand);
        of_hand.flat_map(move |pairs| {
            let world_from_link =
                world_from_tip * (tip_from_root * frames.link(self.bodies[pairs.body].link));
            let near = self.near_parts(pairs, &world_from_link, 0.0);
            near.map(move |pair| (self.pairs.get(as_index(pair)), world_from_link))
        })
    }

    /// Returns true if it is proven that the hand alone touches the world at every pose of the tip within a translation (m) and a
    /// rotation (rad) of `world_from_tip`. False decides nothing.
    ///
    /// If two convex solids overlap by a depth, each plane has points of one on the side of the other at least that deep. A motion in
    /// which no point of one moves farther than the depth therefore leaves an overlap.
    pub fn hand_is_blocked_near(
        &self,
        world_from_tip: &Pose,
        (translation_m, rotation_rad): (f64, f64),
        scratch: &mut Scratch,
    ) -> bool {
        let is_convex = |solid: &Solid| solid.support_point(&Vector::z()).is_some();
        self.pairs_near_hand(*world_from_tip, scratch).any(|(pair, world_from_link)| {
            let Other::Part(index) = pair.second else { return false };
            let (_, part) = &self.parts()[index];
            let is_deep = |(link_from_solid, solid): &(Pose, Solid)| {
                let world_from_solid = world_from_link * link_from_solid;
                let ball = solid.ball();
                let centre = world_from_solid * ball.center;
                let farthest_m = (centre.coords - world_from_tip.translation.vector).norm() + ball.radius_m;
                let motion_m = translation_m + rotation_rad * farthest_m + DEPTH_ERROR_M;
                overlap(solid, &world_from_solid, &part.solid, &part.world_from_solid)
                    .is_some_and(|overlap| overlap.depth_m > motion_m)
            };
            let is_comparable = part.solid.is_half_space() || is_convex(&part.solid);
            is_comparable
                && self.bodies[pair.first].shapes.iter().filter(|(_, solid)| is_convex(solid)).any(is_deep)
        })
    }
}
