use std::collections::BTreeSet;

use crate::anatomy::{Anatomy, is_hand_name};

/// Maximum extent of a finger from its joint, in metres.
pub(crate) const LONGEST_FINGER_M: f64 = 0.35;

/// Maximum number of rigid bodies of a finger.
const MOST_PHALANGES: usize = 6;

/// Rigid body with its fingers.
pub(crate) struct Palm {
    pub body: usize,
    pub fingers: Vec<usize>,
}

/// Returns the rigid bodies with at least `least` fingers, the best first.
pub(crate) fn palms(anatomy: &Anatomy, least: usize) -> Vec<Palm> {
    let mut palms: Vec<(bool, usize, Palm)> = Vec::new();
    for body in 0..anatomy.bodies.len() {
        let of_arm: BTreeSet<usize> = anatomy.joints_of(body).map(|mover| mover.joint).collect();
        let is_finger = |&child: &usize| {
            let driver = anatomy.bodies[child].above.map(|(_, mover)| mover.joint);
            is_finger(anatomy, child) && driver.is_some_and(|driver| !of_arm.contains(&driver))
        };
        let fingers: Vec<usize> = anatomy.bodies[body].below.iter().copied().filter(is_finger).collect();
        if fingers.len() < least {
            continue;
        }
        let is_named = fingers.iter().any(|&finger| {
            let joint = anatomy.joint_above(finger);
            joint.is_some_and(|joint| is_hand_name(&joint.name) || is_hand_name(&joint.child))
        });
        // A single moving link is usually the last one of an arm.
        if least > 1 || (is_named && fingers.len() == 1) {
            palms.push((is_named, anatomy.joints_of(body).count(), Palm { body, fingers }));
        }
    }
    palms.sort_by_key(|(is_named, depth, palm)| (!is_named, usize::MAX - depth, palm.body));
    palms.into_iter().map(|(_, _, palm)| palm).collect()
}

fn is_finger(anatomy: &Anatomy, child: usize) -> bool {
    let branch = anatomy.branch(child);
    if branch.len() > MOST_PHALANGES || branch.iter().any(|&body| anatomy.is_endless(body)) {
        return false;
    }
    let top = anatomy.bodies[child].top;
    let solids = anatomy.solids_in(&branch, top, &anatomy.robot.frames_at(&anatomy.rest()));
    if solids.is_empty() {
        return is_hand_name(anatomy.link_name(top));
    }
    let far_m = solids.iter().map(|(pose, solid)| {
        let ball = solid.ball();
        (pose * ball.center).coords.norm() + ball.radius_m
    });
    far_m.fold(0.0, f64::max) < LONGEST_FINGER_M
}

/// Returns the parent link of the joint above a finger.
pub(crate) fn palm_link(anatomy: &Anatomy, finger: usize) -> usize {
    let top = anatomy.bodies[finger].top;
    anatomy.robot.links()[top].parent.unwrap_or(0)
}

/// Returns the links with geometry of the best palm with a single finger, and of that finger.
pub(crate) fn jaw_links(anatomy: &Anatomy, palm: Option<usize>) -> Option<Vec<String>> {
    let wanted = |body: usize| palm.is_none_or(|link| anatomy.body_of[link] == body);
    let palm = palms(anatomy, 1).into_iter().find(|palm| wanted(palm.body) && palm.fingers.len() == 1)?;
    let bodies = std::iter::once(palm.body).chain(palm.fingers);
    let links = bodies.flat_map(|body| anatomy.bodies[body].links.iter().copied());
    let with_body = links.filter(|link| !anatomy.robot.links()[*link].collisions.is_empty());
    Some(with_body.map(|link| anatomy.link_name(link).to_owned()).collect())
}
