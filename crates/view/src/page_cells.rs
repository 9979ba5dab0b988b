use std::sync::Arc;

use cranny_collision::Cell;
use cranny_solve::Mode;

use crate::{PagePlan, StepCells};

/// What a server judges postures in.
#[derive(Clone, Debug)]
pub struct PageCells {
    empty: Arc<Cell>,
    /// By plan, then by step.
    plans: Vec<Vec<StepCells>>,
}

impl PageCells {
    /// The cell in which the robot starts, and those along plans.
    pub fn of(empty: Arc<Cell>, plans: &[PagePlan]) -> Self {
        Self { empty, plans: plans.iter().map(|plan| plan.steps.clone()).collect() }
    }

    /// Before anything has moved, the hand open and empty.
    pub(crate) fn empty(&self) -> &Cell {
        &self.empty
    }

    /// While a step of a plan does something; `None` for what there is not.
    pub(crate) fn during(&self, plan: usize, step: usize, mode: Mode) -> Option<&Cell> {
        self.plans.get(plan)?.get(step)?.cell(mode).map(Arc::as_ref)
    }
}
