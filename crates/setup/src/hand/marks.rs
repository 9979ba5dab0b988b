use cranny_shape::{Solid, separation};
use cranny_spatial::Pose;

use crate::anatomy::Anatomy;
use crate::hand::hand_guess::HandGuess;
use crate::hand::posture::Posture;

/// Returns the links that are marks of the grasp point: small solids that float between the pads, where all grasps would
/// collide with them.
pub(crate) fn marks(anatomy: &Anatomy, guess: &HandGuess) -> Vec<usize> {
    /// Maximum size of a mark, in metres, and its minimum distance from all other links.
    const LARGEST_M: f64 = 0.02;
    const APART_M: f64 = 3e-3;
    let mut q = anatomy.rest();
    for (joint, value) in q.iter_mut().enumerate() {
        *value = guess.fingers.get(&anatomy.robot.joint_names()[joint]).map_or(*value, |range| range.open);
    }
    let posture = Posture::at(anatomy, guess.palm, &q);
    let body = anatomy.body_of[guess.palm];
    let placed = |link: usize| -> Vec<(Pose, Solid)> {
        let palm_from_link = posture.frames.link(guess.palm).inverse() * posture.frames.link(link);
        let shapes = anatomy.robot.links()[link].collisions.iter();
        shapes.map(|shape| (palm_from_link * shape.link_from_shape, shape.solid.clone())).collect()
    };
    let origin = guess.palm_from_frame.translation.vector;
    let is_mark = |&link: &usize| {
        let own = placed(link);
        let is_small = own.iter().all(|(pose, solid)| {
            let ball = solid.ball();
            let from_frame_m = ((pose * ball.center).coords - origin).norm();
            ball.radius_m < LARGEST_M && from_frame_m < 0.5 * guess.opening_m + ball.radius_m
        });
        let branch = anatomy.branch(body).into_iter().flat_map(|body| &anatomy.bodies[body].links);
        let mut others = branch.filter(|other| **other != link).flat_map(|&other| placed(other));
        let is_apart = others.all(|(pose_b, b)| {
            own.iter().all(|(pose_a, a)| separation(a, pose_a, &b, &pose_b, APART_M).lower_m >= APART_M)
        });
        !own.is_empty() && is_small && is_apart
    };
    anatomy.bodies[body].links.iter().copied().filter(is_mark).collect()
}
