use std::sync::Arc;

use cranny_collision::Cell;

use crate::PagePlan;

/// Cells in which a server judges postures.
#[derive(Clone, Debug)]
pub struct PageCells {
    empty: Arc<Cell>,
    /// By plan, then by segment.
    plans: Vec<Vec<Arc<Cell>>>,
}

impl PageCells {
    /// The cell in which the robot starts, and those along plans.
    pub fn of(empty: Arc<Cell>, plans: &[PagePlan]) -> Self {
        let cells = |plan: &PagePlan| plan.states.iter().map(|state| state.cell().clone()).collect();
        Self { empty, plans: plans.iter().map(cells).collect() }
    }

    /// Before anything has moved, the hand open and empty.
    pub(crate) fn empty(&self) -> &Cell {
        &self.empty
    }

    /// Along a segment of a plan; `None` for one that it does not have.
    pub(crate) fn during(&self, plan: usize, segment: usize) -> Option<&Cell> {
        self.plans.get(plan)?.get(segment).map(Arc::as_ref)
    }
}
