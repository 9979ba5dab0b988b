use cranny_spatial::Point;

use crate::{JointKind, LinkFrames, Robot};

impl Robot {
    /// Bounds on the distance of a point that is fixed to a link from the axis of each joint that moves it, in the order of
    /// [`Self::ancestors`], whatever the joints (m, rad) do within their limits: metres for a joint that turns, so metres per
    /// radian; 1 for one that slides; one value per joint that moves the link. `point_in_link`: metres; `frames` at zero, with
    /// what is held where it is.
    ///
    /// The distances between the frames of the joints add up, slides drawn out as far as they go.
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
