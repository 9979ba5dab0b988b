use std::sync::Arc;

use cranny_collision::Cell;
use cranny_solve::{Mode, TaskCells};

/// Robot and world along one step of a plan.
#[derive(Clone, Debug)]
pub struct StepCells {
    /// On the way to the grasp, the hand empty.
    pub reach: Arc<Cell>,
    /// From when the hand has closed, if it does.
    pub task: Option<TaskCells>,
}

impl StepCells {
    /// Robot and world in a mode; `None` for one that the step does not have.
    pub fn cell(&self, mode: Mode) -> Option<&Arc<Cell>> {
        if mode == Mode::Reach { Some(&self.reach) } else { self.task.as_ref()?.cell(mode) }
    }
}
