use cranny_collision::{Cell, Closing, Contact, Scratch};
use cranny_robot::{Hold, Robot};
use cranny_spatial::Pose;

use crate::{FailureReason, TaskError};

/// The hand of a robot and the target of a problem, on which it closes.
#[derive(Clone, Debug)]
pub struct ClosingHand {
    target: usize,
    world_from_target: Pose,
    /// The target in the open hand, anywhere in it.
    holding: Cell,
}

/// A hand that has closed.
#[derive(Clone, Debug)]
pub struct ClosedHand {
    /// How it holds the target.
    pub hold: Hold,
    /// How far the fingers are apart, in metres.
    pub opening_m: f64,
    /// How much farther the finger that touches last has to go than the first, in metres.
    pub uneven_m: f64,
    /// Share of its travel, from 0, open, to 1, at which each finger touches.
    pub touching: Vec<f64>,
}

impl ClosingHand {
    /// Of a cell, which is given back, and the body to close on; `lacking` says what the error is if it lacks something.
    ///
    /// # Errors
    /// That of `lacking` without a cell (under `paper`), without a target, or for a robot whose hand cannot close;
    /// [`TaskError::Collision`] for a target that has no end.
    pub fn new(
        cell: Option<&Cell>,
        target: Option<usize>,
        lacking: fn(&'static str) -> TaskError,
    ) -> Result<(Self, &Cell), TaskError> {
        let cell = cell.ok_or_else(|| lacking("the exact criterion"))?;
        let target = target.ok_or_else(|| lacking("a target"))?;
        if cell.robot().hand().is_none_or(|hand| hand.fingers == 0) {
            return Err(lacking("a hand that can close (a robot.yaml beside the URDF names its fingers)"));
        }
        let world_from_target = first_pose(cell, target);
        let nowhere = Hold { tip_from_held: Pose::identity(), closing: 0.0 };
        Ok((Self { target, world_from_target, holding: cell.holding(target, nowhere)? }, cell))
    }

    /// The same hand and body, in the surroundings of another cell.
    #[must_use]
    pub fn amid(&self, cell: &Cell) -> Self {
        let holding = self.holding.amid(cell);
        Self { world_from_target: first_pose(cell, self.target), holding, ..*self }
    }

    /// Which body of the world the target is.
    pub fn target(&self) -> usize {
        self.target
    }

    /// The target in the open hand, anywhere in it.
    pub fn holding(&self) -> &Cell {
        &self.holding
    }

    /// Pose in the tip's frame of the target, which has not moved, at a configuration (m, rad; one per joint).
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn tip_from_held(&self, q: &[f64]) -> Pose {
        let robot: &Robot = self.holding.robot();
        robot.frames_at(q).link(robot.tip()).inverse() * self.world_from_target
    }

    /// Where the target stands.
    pub fn world_from_target(&self) -> Pose {
        self.world_from_target
    }

    /// Closes the fingers at a configuration (m, rad; one per joint), until the first touches the target, and proves
    /// that they meet nothing else. `scratch` is that of [`Self::holding`].
    ///
    /// # Errors
    /// Why the hand does not hold the target then: a finger touches nothing, or meets something else on its way.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn close(&self, q: &[f64], scratch: &mut Scratch) -> Result<ClosedHand, FailureReason> {
        self.closed(q, |closed, _| closed.closing_contact(q, scratch))
    }

    /// The same at `q` (m, rad; one per joint) with every finger until it touches the target itself, which stays
    /// where it is, and a proof for each up to there.
    ///
    /// # Errors
    /// As [`Self::close`].
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn close_each(&self, q: &[f64], scratch: &mut Scratch) -> Result<ClosedHand, FailureReason> {
        self.closed(q, |closed, touching| closed.closing_contact_each(q, touching, scratch))
    }

    /// The hand closed until the first finger touches, unless `met` finds a contact.
    fn closed(
        &self,
        q: &[f64],
        met: impl FnOnce(&Cell, &[f64]) -> Option<Contact>,
    ) -> Result<ClosedHand, FailureReason> {
        let tip_from_held = self.tip_from_held(q);
        let held = |closing| {
            let hold = Hold { tip_from_held, closing };
            self.holding.with_hold(hold).map_err(|_| FailureReason::ClosesOnNothing)
        };
        let Closing { closing, uneven_m, touching } =
            held(0.0)?.close_on_held().ok_or(FailureReason::ClosesOnNothing)?;
        let closed = held(closing)?;
        if let Some(contact) = met(&closed, &touching) {
            let [first, second] = contact.names(&closed);
            return Err(FailureReason::ClosingCollides { first, second });
        }
        let hand = self.holding.robot().hand();
        let opening_m = hand.map_or(0.0, |hand| hand.pads.opening_m(closing));
        Ok(ClosedHand { hold: Hold { tip_from_held, closing }, opening_m, uneven_m, touching })
    }
}

/// Pose of the first solid of a body.
fn first_pose(cell: &Cell, body: usize) -> Pose {
    cell.world().bodies()[body].parts.first().map_or_else(Pose::identity, |part| part.world_from_solid)
}
