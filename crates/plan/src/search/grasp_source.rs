use cranny_collision::Margins;
use cranny_grasp::{FirstApproach, GraspSampler, SampledGrasp, SamplerSettings, TooWide};
use cranny_path::GraspJudge;
use cranny_spatial::{Pose, Stream};
use cranny_task::{GraspMeasure, TaskError, gripper_poses};

use crate::PlanError;

/// First contacts that are drawn for one batch of inverse kinematics, at most: a millisecond or so, where the hand collides
/// almost everywhere.
const DRAWS_PER_BATCH: usize = 128;

/// What is left, after a batch without a goal, of the score that is asked beyond the least: a search that finds nothing
/// soon takes what there is.
const LEFT_PER_BATCH: f64 = 0.95;

/// Grasps that are sampled on the target while a search wants them.
pub(crate) struct GraspSource<'a> {
    sampler: GraspSampler<'a>,
    measure: &'a GraspMeasure,
    judge: GraspJudge<'a>,
    /// How much more than [`GraspMeasure::LEAST_SCORE`] is asked of a grasp by now.
    score_beyond: f64,
    /// Draws that are left to the batch.
    left: usize,
    /// Goals that there were when the batch began.
    goals: u64,
}

impl<'a> GraspSource<'a> {
    /// Of grasps with at least this score, in [0, 1], at first, and with less and less down to
    /// [`GraspMeasure::LEAST_SCORE`] where they lead to no goals.
    ///
    /// # Errors
    /// [`TaskError::NoGraspMeasure`] for a surface on which no grasp can be sampled: there is none with a measure.
    pub fn new(measure: &'a GraspMeasure, first_score: f64) -> Result<Self, PlanError> {
        let sampler = Self::sampler(measure)?;
        let score_beyond = (first_score - GraspMeasure::LEAST_SCORE).max(0.0);
        let judge = GraspJudge::new(measure);
        Ok(Self { sampler, measure, judge, score_beyond, left: 0, goals: 0 })
    }

    /// The sampler of grasps of at least [`GraspMeasure::LEAST_SCORE`].
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn sampler(measure: &'a GraspMeasure) -> Result<GraspSampler<'a>, TaskError> {
        GraspSampler::new(measure.surface_in_world(), &Self::settings(measure))
            .map_err(|_| TaskError::NoGraspMeasure { needs: "a target on which grasps can be sampled" })
    }

    /// By how much the target is too wide for the hand with what is demanded between them, if it is.
    pub fn too_wide(measure: &GraspMeasure, margins: Margins) -> Option<TooWide> {
        TooWide::of(measure.surface_in_world(), &Self::settings(measure), margins.of_grasp_m())
    }

    fn settings(measure: &GraspMeasure) -> SamplerSettings {
        SamplerSettings {
            // Whatever needs no more friction than this has the least score.
            friction: (1.0 - GraspMeasure::LEAST_SCORE) * measure.friction(),
            opening_m: measure.opening_m(),
            first_approach: FirstApproach::Random,
            ..SamplerSettings::default()
        }
    }

    /// A new batch begins, so many goals being found.
    pub fn begin_batch(&mut self, goals: u64) {
        if goals == self.goals {
            self.score_beyond *= LEFT_PER_BATCH;
        }
        (self.goals, self.left) = (goals, DRAWS_PER_BATCH);
    }

    /// One more grasp and its twin, as `world_from_gripper`; `None` where the batch has drawn enough.
    pub fn draw(&mut self, random: &mut Stream) -> Option<[Pose; 2]> {
        while self.left > 0 {
            self.left -= 1;
            let mut found = None;
            self.sampler.draw(random, &mut |SampledGrasp { grasp, .. }| found = Some(grasp));
            // Pads from outside may meet another pair of contacts than the sampler did: a hole, the far side of a ring.
            let least = GraspMeasure::LEAST_SCORE + self.score_beyond;
            let is_good = |pose: &Pose| self.measure.score(pose).is_some_and(|score| score >= least);
            if let Some(grasp) = found.filter(|grasp| is_good(&grasp.world_from_gripper)) {
                return Some(gripper_poses(&grasp));
            }
        }
        None
    }

    /// Whether the hand holds the target at a configuration (m, rad; one per joint).
    pub fn holds(&mut self, q: &[f64]) -> bool {
        self.judge.grasp_at(q).is_ok()
    }
}
