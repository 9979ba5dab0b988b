use std::sync::Arc;

use cranny_collision::Cell;
use cranny_plan::Grip;
use cranny_solve::Mode;

use crate::PagePlan;

/// What a server judges postures in.
#[derive(Clone, Debug)]
pub struct PageCells {
    empty: Arc<Cell>,
    /// By plan.
    grips: Vec<Option<Grip>>,
}

impl PageCells {
    /// The cell of the open, empty hand, and what the hand holds along plans.
    pub fn of(empty: Arc<Cell>, plans: &[PagePlan]) -> Self {
        Self { empty, grips: plans.iter().map(|plan| plan.grip.clone()).collect() }
    }

    /// While the hand is empty.
    pub(crate) fn empty(&self) -> &Cell {
        &self.empty
    }

    /// While a plan does something with the object in the hand; `None` where it has none there.
    pub(crate) fn held(&self, plan: usize, mode: Mode) -> Option<&Cell> {
        let [lifting, carrying] = self.grips.get(plan)?.as_ref()?.cells();
        match mode {
            Mode::Reach => None,
            Mode::LiftOff => Some(lifting),
            Mode::Carry => Some(carrying),
        }
    }
}
