use cranny_spatial::Point;

use crate::{JointKind, LinkFrames, Robot};

impl Robot {
    /// Bounds the distance of a point fixed to a link from the axis of each joint that moves it, in the order of
    /// [`Self::ancestors`], for all joint values (m, rad) within their limits: metres for a revolute joint, so metres per
    /// radian; 1 for a prismatic one; one value per joint that moves the link. `point_in_link` is in metres; `frames` are at
    /// `q = 0`, with held objects attached.
    ///
    /// The distances between consecutive joint frames add up, with prismatic joints fully extended.
    ///
    /// # Panics
    /// If there is no such link.
    pub fn link_arms_m(&self, frames: &LinkFrames, link: usize, point_in_link: &Point) -> Vec<f64> {
        let mut after = (frames.link(link) * point_in_link).coords;
        let (mut arm_m, mut arms_m) = (0.0, Vec::new());
        for mover in self.ancestors(link).iter().rev() {
            let here = frames.link(mover.child_link).translation.vector;
            arm_m += (after - here).norm();
            after = here;
            match mover.kind {
                JointKind::Revolute => arms_m.push(arm_m),
                JointKind::Prismatic => {
                    let limits = self.limits()[mover.joint];
                    arm_m += mover.multiplier.abs() * limits.lower.abs().max(limits.upper.abs());
                    arms_m.push(1.0);
                }
            }
        }
        arms_m.reverse();
        arms_m
    }
}
