use std::sync::Arc;

use cranny_collision::Cell;
use cranny_solve::{Mode, TaskCells};

use crate::PagePlan;

/// What a server judges postures in.
#[derive(Clone, Debug)]
pub struct PageCells {
    empty: Arc<Cell>,
    /// By plan.
    tasks: Vec<Option<TaskCells>>,
}

impl PageCells {
    /// The cell of the open, empty hand, and what the hand holds along plans.
    pub fn of(empty: Arc<Cell>, plans: &[PagePlan]) -> Self {
        Self { empty, tasks: plans.iter().map(|plan| plan.cells.clone()).collect() }
    }

    /// While the hand is empty.
    pub(crate) fn empty(&self) -> &Cell {
        &self.empty
    }

    /// While a plan does something with the object in the hand; `None` where it has none there.
    pub(crate) fn held(&self, plan: usize, mode: Mode) -> Option<&Cell> {
        self.tasks.get(plan)?.as_ref()?.cell(mode).map(Arc::as_ref)
    }
}
