use cranny_collision::Scratch;
use cranny_grasp::rows_of_pose;
use cranny_task::{ClosedHand, FailureReason, FoundGrasp, GraspMeasure};

use crate::Cause;

/// Judge that decides whether the hand holds the target at a configuration, shared by the audit and the planners.
#[derive(Debug)]
pub struct GraspJudge<'a> {
    measure: &'a GraspMeasure,
    scratch: Scratch,
}

impl<'a> GraspJudge<'a> {
    /// Creates a judge that scores grasps with `measure`.
    pub fn new(measure: &'a GraspMeasure) -> Self {
        Self { measure, scratch: measure.hand().holding().scratch() }
    }

    /// Returns the grasp that the hand takes at a configuration (m, rad; one per joint).
    ///
    /// 1. Each finger closes on the stationary target until it touches. This motion is proven free of other contacts.
    /// 2. The contacts of the pads with the target are in force closure, with a score of at least
    ///    [`GraspMeasure::LEAST_SCORE`].
    ///
    /// # Errors
    /// The cause of the rejection.
    ///
    /// # Panics
    /// If `q` does not have one value per joint.
    pub fn grasp_at(&mut self, q: &[f64]) -> Result<FoundGrasp, Cause> {
        let grip = |reason| Cause::Grip { reason };
        // 1.
        let robot = self.measure.hand().holding().robot();
        let world_from_gripper = *robot.frames_at(q).link(robot.tip());
        let ClosedHand { opening_m, uneven_m, touching, .. } =
            self.measure.hand().close_each(q, &mut self.scratch).map_err(grip)?;
        // 2.
        let score = self
            .measure
            .pad_score(&world_from_gripper, &touching)
            .ok_or_else(|| grip(FailureReason::ClosesOnNothing))?;
        if score < GraspMeasure::LEAST_SCORE {
            return Err(Cause::WeakGrasp { score, required: GraspMeasure::LEAST_SCORE });
        }
        let rows = rows_of_pose(&world_from_gripper);
        let row = |row: usize| std::array::from_fn(|column| rows[4 * row + column]);
        let uneven_m = Some(uneven_m);
        Ok(FoundGrasp { world_from_gripper: std::array::from_fn(row), opening_m, score, uneven_m })
    }
}
