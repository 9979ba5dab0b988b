use std::sync::Arc;

use cranny_collision::Cell;
use cranny_plan::{Carrier, CarryEnd, Grip, Placed, Placer, PlanError};
use cranny_spatial::Pose;

use crate::{Mode, Segment};

/// Robot and world in each mode of a task: what the hand holds, and where the object stands once it is put down.
#[derive(Clone, Debug)]
pub struct TaskCells {
    /// The object in the hand.
    pub grip: Grip,
    /// The same near what the object is put down on, and what follows.
    put_down: Option<(Grip, Placed)>,
}

impl TaskCells {
    /// Of segments that follow each other; `None` where the hand does not close on the object, or what is put down is so
    /// nowhere.
    ///
    /// # Errors
    /// As [`Placer::new`].
    pub fn of(
        carrier: &Carrier,
        segments: &[Segment],
        end: Option<&CarryEnd>,
    ) -> Result<Option<Self>, PlanError> {
        let last_of = |mode| {
            let of_mode = segments.iter().rfind(|segment| segment.mode == mode);
            of_mode.and_then(|segment| segment.waypoints.last())
        };
        let Some(grip) = last_of(Mode::Reach).and_then(|grasp| carrier.close(grasp).ok()) else {
            return Ok(None);
        };
        let (Some(down), Some(CarryEnd::Place(settings))) = (last_of(Mode::SetDown), end) else {
            return Ok(Some(Self { grip, put_down: None }));
        };
        let placer = Placer::new(carrier, settings.clone())?;
        let near = placer.grip_at(&grip, down)?;
        let placed = placer.open(&grip, down).ok();
        Ok(placed.map(|placed| Self { grip, put_down: Some((near, placed)) }))
    }

    /// Pose of the first solid of the object where it was put down, if it was.
    pub fn placed(&self) -> Option<&Pose> {
        self.put_down.as_ref().map(|(_, placed)| &placed.world_from_held)
    }

    /// Robot and world in a mode; `None` for the way to the grasp, which is that of the problem.
    pub fn cell(&self, mode: Mode) -> Option<&Arc<Cell>> {
        let [lifting, carrying] = self.grip.cells();
        match mode {
            Mode::Reach => None,
            Mode::LiftOff => Some(lifting),
            Mode::Carry => Some(carrying),
            Mode::SetDown => self.put_down.as_ref().map(|(near, _)| near.cells()[0]),
            Mode::Retreat | Mode::Return => self.put_down.as_ref().map(|(_, placed)| placed.cell()),
        }
    }
}
