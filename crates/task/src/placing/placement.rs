use std::sync::Arc;

use cranny_collision::{Cell, Contact, Resting};
use cranny_robot::Hold;
use cranny_spatial::Pose;

use crate::placing::placed::Placed;
use crate::{Carrier, FailureReason, Grip, TaskError};

/// An object at rest at a pose.
#[derive(Clone, Debug)]
pub struct Placement {
    /// Pose of the first solid of the object in the planning frame.
    pub world_from_held: Pose,
    pub(crate) resting: Resting,
    /// Cell in which the object may touch its support; its pose in the hand is not set yet.
    near: Arc<Cell>,
}

impl Carrier {
    /// Creates the placement of the object with its first solid at a pose in the planning frame, with its supports there.
    pub(crate) fn placement(&self, world_from_held: &Pose) -> Placement {
        self.placement_among(std::iter::empty(), world_from_held)
    }

    /// Creates a placement that shares the cell of a known one with the same supports, if there is one.
    pub(crate) fn placement_among<'a>(
        &self,
        mut known: impl Iterator<Item = &'a Placement>,
        world_from_held: &Pose,
    ) -> Placement {
        let cell = self.hand().holding();
        let resting = cell.resting_at(self.hand().target(), self.resting().extent(), world_from_held);
        let near = match known.find(|known| known.resting.is_spared_alike(&resting)) {
            Some(known) => known.near.clone(),
            None => Arc::new(cell.with_allowed_contacts(&resting)),
        };
        Placement { world_from_held: *world_from_held, resting, near }
    }

    /// Returns the pose of the first solid of the object in the planning frame, with the arm at `q` (m, rad; one per joint).
    pub fn held_at(&self, grip: &Grip, q: &[f64]) -> Pose {
        self.gripper(q) * grip.hold.tip_from_held
    }

    /// Computes the set-down path of way points (m, rad; one value per joint): from a configuration with the object off its
    /// support down to the arm at `q`, the mirror of a lift-off.
    ///
    /// # Errors
    /// The obstacle that blocks the set-down, or the reach of the arm.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn set_down(
        &self,
        grip: &Grip,
        placement: &Placement,
        q: &[f64],
    ) -> Result<Vec<Vec<f64>>, FailureReason> {
        let near = placement.grip_near(grip).map_err(|_| FailureReason::NoPlace)?;
        let way = self.way_off(&near, &placement.resting, q).map_err(|blocked| match blocked {
            Some([first, second]) => FailureReason::SetDownBlocked { first, second },
            None => FailureReason::SetDownOutOfReach,
        })?;
        Ok(way.into_iter().rev().collect())
    }

    /// Checks that the hand can open at `q` (m, rad; one per joint), apart from contacts with the object that it releases.
    ///
    /// # Errors
    /// The contact of the fingers.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn opens(&self, grip: &Grip, q: &[f64]) -> Result<(), FailureReason> {
        let [_, carrying] = grip.cells();
        let contact = carrying.closing_contact(q, &mut carrying.scratch());
        contact.map_or(Ok(()), |contact| {
            let [first, second] = contact.names(carrying);
            Err(FailureReason::OpeningCollides { first, second })
        })
    }

    /// Opens the hand at `q` (m, rad; one per joint), where it has put the object down.
    ///
    /// # Errors
    /// The contact of the fingers.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn open(&self, grip: &Grip, q: &[f64]) -> Result<Placed, FailureReason> {
        self.opens(grip, q)?;
        let (world_from_held, target) = (self.held_at(grip, q), self.hand().target());
        let after = self.cell().with_body_at(target, &world_from_held).map_err(|_| FailureReason::NoPlace)?;
        Ok(Placed { world_from_held, target, after: Arc::new(after) })
    }
}

impl Placement {
    /// Returns the first contact of the open hand around the object at this placement, and the cell of the contact.
    pub(crate) fn hand_contact(&self, tip_from_held: Pose) -> Result<Option<(Contact, Cell)>, TaskError> {
        let cell = self.near.with_hold(Hold { tip_from_held, closing: 0.0 })?;
        let contact = cell.hand_contact(&self.world_from_tip(&tip_from_held), &mut cell.scratch());
        Ok(contact.map(|contact| (contact, cell)))
    }

    /// Returns the pose of the tip in the planning frame at this placement.
    pub(crate) fn world_from_tip(&self, tip_from_held: &Pose) -> Pose {
        self.world_from_held * tip_from_held.inverse()
    }

    /// Returns a grip with the object near its support at this placement.
    ///
    /// # Errors
    /// [`TaskError::Collision`] for an invalid hold.
    pub fn grip_near(&self, grip: &Grip) -> Result<Grip, TaskError> {
        Ok(grip.near(&self.near)?)
    }
}
