use cranny_robot::between;

use crate::Observer;
use crate::planners::lane_search::{EdgeRelation, Growth, LaneSearch};

/// Maximum number of steps per growth.
const MOST_STEPS: usize = 16;

/// Minimum progress of a step towards the target, as a share of the step: otherwise sliding along a bound might never end.
const LEAST_PROGRESS: f64 = 0.05;

impl LaneSearch<'_> {
    /// Variant of [`Self::grow`] for a bounded tool: single steps, each projected onto the bounds (the constrained extension of
    /// Berenson, Srinivasa & Kuffner 2011, "Task Space Regions", §5), up to the first that is not free or makes no progress.
    pub(super) fn grow_within_bounds(
        &mut self,
        side: usize,
        (from, way): (usize, EdgeRelation),
        target: &[f64],
        observer: &mut dyn Observer,
    ) -> Growth {
        let (step, looks) = (self.settings.step, self.settings.looks);
        let places: Vec<f64> = (1..=looks).map(|look| look as f64 / looks as f64).collect();
        let (mut node, mut way) = (from, way);
        for _ in 0..MOST_STEPS {
            let q = self.sides[side].q(node).to_vec();
            let far = self.sides[side].distance(&q, target);
            let share = if far > step { step / far } else { 1.0 };
            let mut next: Vec<f64> = between(&q, target, share).collect();
            let is_within = self.cell.project_to_bounds(&mut next, &mut self.scratch);
            let is_target = is_within && next == target;
            let left = self.sides[side].distance(&next, target);
            if !is_within || !(is_target || left <= far - LEAST_PROGRESS * step.min(far)) {
                return Growth { node, is_target: false, is_open: false };
            }
            let free = self.cell.free_ahead(&q, &next, &places, &mut self.scratch);
            self.statistics.collision_checks += looks as u64;
            if free < looks || !self.is_below_bound(side, node, &next) {
                return Growth { node, is_target: false, is_open: false };
            }
            node = self.add_node(side, &next, (node, way), observer);
            way = EdgeRelation::Turns;
            if is_target {
                return Growth { node, is_target: true, is_open: true };
            }
        }
        Growth { node, is_target: false, is_open: true }
    }
}
