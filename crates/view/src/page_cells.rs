use std::sync::Arc;

use cranny_collision::Cell;
use cranny_solve::{Mode, TaskCells};

use crate::PagePlan;

/// Robot and world along one step of a plan.
#[derive(Clone, Debug)]
pub struct StepCells {
    /// On the way to the grasp, the hand empty.
    pub reach: Arc<Cell>,
    /// From when the hand has closed.
    pub task: TaskCells,
}

impl StepCells {
    /// Robot and world in a mode; `None` for one that the step does not have.
    pub fn cell(&self, mode: Mode) -> Option<&Arc<Cell>> {
        if mode == Mode::Reach { Some(&self.reach) } else { self.task.cell(mode) }
    }
}

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
