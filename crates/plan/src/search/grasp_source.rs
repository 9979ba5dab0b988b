use cranny_collision::Margins;
use cranny_grasp::{FirstApproach, Grasp, GraspSampler, SampledGrasp, SamplerSettings, TooWide};
use cranny_path::GraspJudge;
use cranny_spatial::{Pose, Stream};
use cranny_task::{GraspMeasure, TaskError};

use crate::PlanError;

/// Maximum number of first contacts drawn per batch of inverse kinematics: about 1 ms if the hand nearly always collides.
const DRAWS_PER_BATCH: usize = 128;

/// Factor of the required score beyond the minimum after a batch without a goal, so that soon any grasp is accepted.
const LEFT_PER_BATCH: f64 = 0.95;

/// Grasps sampled on the target as a search needs them.
pub(crate) struct GraspSource<'a> {
    sampler: GraspSampler<'a>,
    measure: &'a GraspMeasure,
    judge: GraspJudge<'a>,
    /// Currently required score beyond [`GraspMeasure::LEAST_SCORE`].
    score_beyond: f64,
    /// Draws left in the batch.
    left: usize,
    /// Number of goals at the beginning of the batch.
    goals: u64,
}

impl<'a> GraspSource<'a> {
    /// Creates a source of grasps with at least this score, in [0, 1], at first. The required score decreases to
    /// [`GraspMeasure::LEAST_SCORE`] while they lead to no goals.
    ///
    /// # Errors
    /// [`TaskError::NoGraspMeasure`] for a surface on which no grasp can be sampled.
    pub fn new(measure: &'a GraspMeasure, first_score: f64) -> Result<Self, PlanError> {
        let sampler = Self::sampler(measure)?;
        let score_beyond = (first_score - GraspMeasure::LEAST_SCORE).max(0.0);
        let judge = GraspJudge::new(measure);
        Ok(Self { sampler, measure, judge, score_beyond, left: 0, goals: 0 })
    }

    /// Returns the sampler of grasps with at least [`GraspMeasure::LEAST_SCORE`].
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn sampler(measure: &'a GraspMeasure) -> Result<GraspSampler<'a>, TaskError> {
        GraspSampler::new(measure.surface_in_world(), &Self::settings(measure))
            .map_err(|_| TaskError::NoGraspMeasure { needs: "a target on which grasps can be sampled" })
    }

    /// Returns the excess width of the target over the hand opening, including the required margins, if it is too wide.
    pub fn too_wide(measure: &GraspMeasure, margins: Margins) -> Option<TooWide> {
        TooWide::of(measure.surface_in_world(), &Self::settings(measure), margins.of_grasp_m())
    }

    fn settings(measure: &GraspMeasure) -> SamplerSettings {
        SamplerSettings {
            // Grasps that need no more friction than this have the minimum score.
            friction: (1.0 - GraspMeasure::LEAST_SCORE) * measure.friction(),
            opening_m: measure.opening_m(),
            closed_gap_m: measure.closed_gap_m(),
            first_approach: FirstApproach::Random,
            ..SamplerSettings::default()
        }
    }

    /// Begins a new batch, with `goals` goals found before.
    pub fn begin_batch(&mut self, goals: u64) {
        if goals == self.goals {
            self.score_beyond *= LEFT_PER_BATCH;
        }
        (self.goals, self.left) = (goals, DRAWS_PER_BATCH);
    }

    /// Draws one more grasp; `None` if the batch has no draws left.
    pub fn draw(&mut self, random: &mut Stream) -> Option<Grasp> {
        while self.left > 0 {
            self.left -= 1;
            let mut found = None;
            self.sampler.draw(random, &mut |SampledGrasp { grasp, .. }| found = Some(grasp));
            // Pads from outside may touch other contacts than the sampler found, as at a hole or the far side of a ring.
            let least = GraspMeasure::LEAST_SCORE + self.score_beyond;
            let is_good = |pose: &Pose| self.measure.score(pose).is_some_and(|score| score >= least);
            let good = found.filter(|grasp: &Grasp| is_good(&grasp.world_from_gripper));
            if good.is_some() {
                return good;
            }
        }
        None
    }

    /// Returns true if the hand holds the target at a configuration (m, rad; one per joint).
    pub fn holds(&mut self, q: &[f64]) -> bool {
        self.judge.grasp_at(q).is_ok()
    }
}
