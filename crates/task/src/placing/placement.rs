use std::sync::Arc;

use cranny_collision::{Cell, Contact, Resting};
use cranny_robot::Hold;
use cranny_spatial::Pose;

use crate::placing::placed::Placed;
use crate::{Carrier, FailureReason, Grip, TaskError};

/// An object at rest at a pose.
#[derive(Clone, Debug)]
pub struct Placement {
    /// Pose of the first solid of the object.
    pub world_from_held: Pose,
    pub(crate) resting: Resting,
    /// In which the object may touch what it then rests on, anywhere in the hand.
    near: Arc<Cell>,
}

impl Carrier {
    /// The object at a pose of its first solid, and its supports there.
    pub(crate) fn placement(&self, world_from_held: &Pose) -> Placement {
        self.placement_among(std::iter::empty(), world_from_held)
    }

    /// The same, with the cell of a known placement that has the same supports, if there is one.
    pub(crate) fn placement_among<'a>(
        &self,
        mut known: impl Iterator<Item = &'a Placement>,
        world_from_held: &Pose,
    ) -> Placement {
        let cell = self.hand().holding();
        let resting = cell.resting_at(self.hand().target(), self.resting().extent(), world_from_held);
        let near = match known.find(|known| known.resting.is_spared_alike(&resting)) {
            Some(known) => known.near.clone(),
            None => Arc::new(cell.sparing(&resting)),
        };
        Placement { world_from_held: *world_from_held, resting, near }
    }

    /// Pose of the first solid of the object in the planning frame, with the arm at `q` (m, rad; one per joint).
    pub fn held_at(&self, grip: &Grip, q: &[f64]) -> Pose {
        self.gripper(q) * grip.hold.tip_from_held
    }

    /// The path of way points (m, rad; one value per joint) down to a placement, from where the object is off what it
    /// is put down on, to where the arm stands at `q`: the mirror of a lift-off.
    ///
    /// # Errors
    /// What is in the way.
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

    /// Checks that the hand can open there, the arm at `q` (m, rad; one per joint), but for what it then leaves.
    ///
    /// # Errors
    /// What the fingers meet.
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
    /// What the fingers meet.
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
    /// What the open hand touches that has the object there, held so, in the cell in which it does.
    pub(crate) fn hand_contact(&self, tip_from_held: Pose) -> Result<Option<(Contact, Cell)>, TaskError> {
        let cell = self.near.with_hold(Hold { tip_from_held, closing: 0.0 })?;
        let contact = cell.hand_contact(&self.world_from_tip(&tip_from_held), &mut cell.scratch());
        Ok(contact.map(|contact| (contact, cell)))
    }

    /// Where the tip is then.
    pub(crate) fn world_from_tip(&self, tip_from_held: &Pose) -> Pose {
        self.world_from_held * tip_from_held.inverse()
    }

    /// A grip with the object near what it rests on there.
    ///
    /// # Errors
    /// [`TaskError::Collision`] for a hold that is none.
    pub fn grip_near(&self, grip: &Grip) -> Result<Grip, TaskError> {
        Ok(grip.near(&self.near)?)
    }
}
