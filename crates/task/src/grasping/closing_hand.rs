use cranny_collision::{Cell, Closing, Contact, Scratch};
use cranny_robot::{Hold, Robot};
use cranny_spatial::Pose;

use crate::{FailureReason, TaskError};

/// The hand of a robot and the target of a problem on which it closes.
#[derive(Clone, Debug)]
pub struct ClosingHand {
    target: usize,
    world_from_target: Pose,
    holding: Cell,
}

/// A hand that has closed.
#[derive(Clone, Debug)]
pub struct ClosedHand {
    /// Pose of the target in the tip's frame and closing of the fingers.
    pub hold: Hold,
    /// Distance between the fingers, in metres.
    pub opening_m: f64,
    /// Travel of the pad of the finger that touches last, after the first one touches, in metres.
    pub uneven_m: f64,
    /// Share of its travel at which each finger touches, from 0 (open) to 1.
    pub touching: Vec<f64>,
}

impl ClosingHand {
    /// Creates the hand for a target body, and returns it with its cell; `lacking` makes the error for a missing item.
    ///
    /// # Errors
    /// That of `lacking` without a cell (under `paper`), without a target, or for a robot whose hand cannot close;
    /// [`TaskError::Collision`] for an unbounded target.
    pub fn new(
        cell: Option<&Cell>,
        target: Option<usize>,
        lacking: fn(&'static str) -> TaskError,
    ) -> Result<(Self, &Cell), TaskError> {
        let cell = cell.ok_or_else(|| lacking("the exact criterion"))?;
        let target = target.ok_or_else(|| lacking("a target"))?;
        if cell.robot().tool().is_some() {
            return Err(lacking(
                "a hand with pads that close, but its robot has a tool, which only reaches grasps",
            ));
        }
        if cell.robot().hand().is_none_or(|hand| hand.fingers == 0) {
            return Err(lacking("a hand that can close (a robot.yaml beside the URDF names its fingers)"));
        }
        let world_from_target = first_pose(cell, target);
        let nowhere = Hold { tip_from_held: Pose::identity(), closing: 0.0 };
        Ok((Self { target, world_from_target, holding: cell.holding(target, nowhere)? }, cell))
    }

    /// Returns this hand and target in the surroundings of another cell.
    #[must_use]
    pub fn with_surroundings_of(&self, cell: &Cell) -> Self {
        let holding = self.holding.with_surroundings_of(cell);
        Self { world_from_target: first_pose(cell, self.target), holding, ..*self }
    }

    /// Index of the target among the bodies of the world.
    pub fn target(&self) -> usize {
        self.target
    }

    /// Cell with the target attached to the open hand, at any pose.
    pub fn holding(&self) -> &Cell {
        &self.holding
    }

    /// Returns the pose in the tip's frame of the target, which has not moved, at a configuration (m, rad; one per joint).
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn tip_from_held(&self, q: &[f64]) -> Pose {
        let robot: &Robot = self.holding.robot();
        robot.frames_at(q).link(robot.tip()).inverse() * self.world_from_target
    }

    /// Pose of the target in the planning frame before it is grasped.
    pub fn world_from_target(&self) -> Pose {
        self.world_from_target
    }

    /// Closes the fingers at a configuration (m, rad; one per joint) until the first touches the target, and proves that they
    /// touch nothing else. `scratch` is that of [`Self::holding`].
    ///
    /// # Errors
    /// The reason why the hand does not hold the target: a finger touches nothing, or touches it beside its pad, or meets something
    /// else while closing.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn close(&self, q: &[f64], scratch: &mut Scratch) -> Result<ClosedHand, FailureReason> {
        self.closed(q, |closed, _| closed.closing_contact(q, scratch))
    }

    /// Closes each finger at `q` (m, rad; one per joint) until it touches the target, which does not move, and proves the
    /// motion of each finger up to its contact.
    ///
    /// # Errors
    /// As [`Self::close`].
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn close_each(&self, q: &[f64], scratch: &mut Scratch) -> Result<ClosedHand, FailureReason> {
        self.closed(q, |closed, touching| closed.closing_contact_each(q, touching, scratch))
    }

    /// Closes the hand until the first finger touches. Fails if `met` returns a contact of the fingers with something else.
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
        let Closing { closing, uneven_m, touching, beside } =
            held(0.0)?.close_on_held().ok_or(FailureReason::ClosesOnNothing)?;
        if let Some(link) = beside {
            let link = self.holding.robot().links()[link].name.clone();
            return Err(FailureReason::TouchesBesidePads { link });
        }
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
