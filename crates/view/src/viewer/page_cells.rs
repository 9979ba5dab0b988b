use std::sync::Arc;

use cranny_collision::Cell;

use crate::PagePlan;

/// Cells in which a server checks configurations.
#[derive(Clone, Debug)]
pub struct PageCells {
    empty: Arc<Cell>,
    /// Cells by plan, then by segment.
    plans: Vec<Vec<Arc<Cell>>>,
}

impl PageCells {
    /// Collects the cell of the start state and those along plans.
    pub fn of(empty: Arc<Cell>, plans: &[PagePlan]) -> Self {
        let cells = |plan: &PagePlan| plan.states.iter().map(|state| state.cell().clone()).collect();
        Self { empty, plans: plans.iter().map(cells).collect() }
    }

    /// Cell before any motion, with the hand open and empty.
    pub(crate) fn empty(&self) -> &Cell {
        &self.empty
    }

    /// Returns the cell along a segment of a plan; `None` if there is no such segment.
    pub(crate) fn during(&self, plan: usize, segment: usize) -> Option<&Cell> {
        self.plans.get(plan)?.get(segment).map(Arc::as_ref)
    }
}
