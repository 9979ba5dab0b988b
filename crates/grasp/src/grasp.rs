use cranny_spatial::{Pose, PoseDifference, Rotation};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::{GraspError, LoadMeasure, RobustScore, ScoreKind};

/// Grasp of the object by the gripper.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Grasp {
    /// Pose of the gripper frame in the planning frame.
    pub world_from_gripper: Pose,
    /// Quality of the grasp, in [0, 1]; `None` for an unscored grasp, which is not a score of 0.
    pub score: Option<f64>,
    /// Width of the object between the fingers, in metres, where known.
    pub width_m: Option<f64>,
    /// Result of perturbed physics trials, if there were any.
    pub robust: Option<RobustScore>,
    /// Factor by which gravity may grow before a pad slips, if computed: [`Load::at_rest`](crate::Load::at_rest).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub load: Option<f64>,
    /// True if the grasp turned by 180° about the approach direction is another grasp, as for a tool without two equal pads: the
    /// grasp is then its own twin.
    #[serde(skip)]
    pub has_no_twin: bool,
}

impl Grasp {
    /// Grasp of which only the pose of the gripper frame is known.
    pub fn at(world_from_gripper: Pose) -> Self {
        Self { world_from_gripper, score: None, width_m: None, robust: None, load: None, has_no_twin: false }
    }

    /// Returns the grasp with the fingers exchanged: rotated by 180° about the approach direction. A grasp that
    /// [has no twin](Self::has_no_twin) is returned unchanged.
    #[must_use]
    pub fn twin(&self) -> Self {
        if self.has_no_twin {
            return *self;
        }
        let half_turn =
            Rotation::from_quaternion(cranny_spatial::nalgebra::Quaternion::new(0.0, 0.0, 0.0, 1.0));
        let mut twin = *self;
        twin.world_from_gripper.rotation *= half_turn;
        twin
    }

    /// Score of a kind, in [0, 1]; a load is any number from 0.
    pub fn score_of(&self, kind: ScoreKind) -> Option<f64> {
        match kind {
            ScoreKind::Geometric => self.score,
            ScoreKind::Physics => self.robust.map(|robust| robust.score()),
            ScoreKind::Load => self.load,
        }
    }

    /// Returns the grasp if it is valid; errors refer to it by its index `place` in its set.
    pub(crate) fn checked(self, place: usize) -> Result<Self, GraspError> {
        let pose = &self.world_from_gripper;
        if !pose.translation.vector.iter().chain(pose.rotation.coords.iter()).all(|x| x.is_finite()) {
            return Err(GraspError::NotFinite { grasp: place });
        }
        if let Some(score) = self.score.filter(|s| !(0.0..=1.0).contains(s)) {
            return Err(GraspError::Score { grasp: place, score });
        }
        if let Some(width_m) = self.width_m.filter(|w| !(w.is_finite() && *w >= 0.0)) {
            return Err(GraspError::Width { grasp: place, width_m });
        }
        if let Some(RobustScore { trials, held }) = self.robust.filter(|robust| !robust.is_sound()) {
            return Err(GraspError::Robust {
                grasp: place,
                score: held as f64 / trials as f64,
                trials: trials as f64,
            });
        }
        if let Some(load) = self.load.filter(|load| !(load.is_finite() && *load >= 0.0)) {
            return Err(GraspError::Load { grasp: place, load });
        }
        Ok(self)
    }

    /// Difference between a gripper and the grasp or its twin, whichever is nearer by the released metric.
    pub fn difference(&self, world_from_gripper: &Pose) -> PoseDifference {
        let direct = PoseDifference::between(&self.world_from_gripper, world_from_gripper);
        let turned = PoseDifference::between(&self.twin().world_from_gripper, world_from_gripper);
        if direct.rotation_rad <= turned.rotation_rad { direct } else { turned }
    }
}

/// The grasps of one object, in the order of their file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GraspSet {
    grasps: Vec<Grasp>,
}

impl GraspSet {
    /// A set of grasps.
    ///
    /// # Errors
    /// [`GraspError::NotFinite`] for a pose that is not finite, [`GraspError::Score`] for a score outside [0, 1],
    /// [`GraspError::Width`] for a negative width, [`GraspError::Robust`] for more successes than trials, [`GraspError::Load`]
    /// for a load that is negative or not finite.
    pub fn new(grasps: Vec<Grasp>) -> Result<Self, GraspError> {
        for (grasp, g) in grasps.iter().enumerate() {
            g.checked(grasp)?;
        }
        Ok(Self { grasps })
    }

    /// A set of grasps that have been checked one by one.
    pub(crate) fn of_checked(grasps: Vec<Grasp>) -> Self {
        Self { grasps }
    }

    /// Number of grasps.
    pub fn len(&self) -> usize {
        self.grasps.len()
    }

    /// Returns true if there are none.
    pub fn is_empty(&self) -> bool {
        self.grasps.is_empty()
    }

    /// All grasps.
    pub fn grasps(&self) -> &[Grasp] {
        &self.grasps
    }

    /// Returns the grasps in another frame.
    #[must_use]
    pub fn moved(&self, other_from_own: &Pose) -> Self {
        let moved =
            |grasp: &Grasp| Grasp { world_from_gripper: other_from_own * grasp.world_from_gripper, ..*grasp };
        Self { grasps: self.grasps.iter().map(moved).collect() }
    }

    /// Returns the grasps without twins, for a tool that is not symmetric under half a turn: `difference(g, g.twin()) = 0` holds
    /// because `g.twin() = g`.
    #[must_use]
    pub fn without_twins(&self) -> Self {
        Self { grasps: self.grasps.iter().map(|grasp| Grasp { has_no_twin: true, ..*grasp }).collect() }
    }

    /// Returns the grasps with their score of this kind, if any, as their [`score`](Grasp::score). A load λ becomes the
    /// score λ / (1 + λ).
    #[must_use]
    pub fn scored_by(&self, kind: ScoreKind) -> Self {
        let scored = |grasp: &Grasp| {
            let score = grasp.score_of(kind);
            let score = if kind == ScoreKind::Load { score.map(|load| load / (1.0 + load)) } else { score };
            Grasp { score, ..*grasp }
        };
        Self { grasps: self.grasps.iter().map(scored).collect() }
    }

    /// Returns the grasps with their loads, computed by a measure in the frame of their poses.
    #[must_use]
    pub fn with_loads(&self, measure: &LoadMeasure) -> Self {
        let loaded = |grasp: &Grasp| {
            let load = Some(measure.of(&grasp.world_from_gripper).at_rest);
            Grasp { load, ..*grasp }
        };
        Self { grasps: self.grasps.par_iter().map(loaded).collect() }
    }

    /// Returns the grasps at these indices, in the order of the indices.
    ///
    /// # Panics
    /// If an index is out of range.
    #[must_use]
    pub fn chosen(&self, indices: &[usize]) -> Self {
        Self { grasps: indices.iter().map(|index| self.grasps[*index]).collect() }
    }

    /// Returns the grasps without their loads: for another hand.
    #[must_use]
    pub fn without_loads(&self) -> Self {
        Self { grasps: self.grasps.iter().map(|grasp| Grasp { load: None, ..*grasp }).collect() }
    }

    /// Indices in order of descending score; unscored grasps follow in the order of the file.
    pub fn by_score(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.grasps.len()).collect();
        let rank = |index: &usize| self.grasps[*index].score.unwrap_or(-1.0);
        order.sort_by(|a, b| rank(b).total_cmp(&rank(a)));
        order
    }

    /// Index of the grasp nearest to a gripper by the released metric, and the difference; `None` if there are none.
    pub fn nearest(&self, world_from_gripper: &Pose) -> Option<(usize, PoseDifference)> {
        self.grasps
            .iter()
            .map(|grasp| grasp.difference(world_from_gripper))
            .enumerate()
            .min_by(|(_, a), (_, b)| a.paper_metric().total_cmp(&b.paper_metric()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cranny_spatial::Vector;

    fn grasp(score: Option<f64>) -> Grasp {
        let pose = Pose::new(Vector::new(0.1, 0.2, 0.3), Vector::new(0.4, -0.1, 0.9));
        Grasp { score, ..Grasp::at(pose) }
    }

    #[test]
    fn a_grasp_without_a_twin_differs_from_its_half_turn() {
        let with_twin = grasp(None);
        let half_turn = with_twin.twin().world_from_gripper;
        let set = GraspSet::new(vec![with_twin]).unwrap().without_twins();
        let alone = set.grasps()[0];
        assert_eq!(alone.twin(), alone);
        assert!(with_twin.difference(&half_turn).rotation_rad < 1e-9);
        assert!(alone.difference(&half_turn).rotation_rad > 3.1);
    }

    #[test]
    fn a_twin_is_the_same_grasp() {
        let g = grasp(None);
        let difference = g.difference(&g.twin().world_from_gripper);
        assert!(difference.translation_m < 1e-12 && difference.rotation_rad < 1e-12);
        assert!(
            PoseDifference::between(&g.world_from_gripper, &g.twin().world_from_gripper).rotation_rad > 3.1
        );
    }

    #[test]
    fn unscored_grasps_rank_after_scored_ones_in_file_order() {
        let set = GraspSet::new([None, Some(0.2), None, Some(0.9), Some(0.0)].map(grasp).to_vec()).unwrap();
        assert_eq!(set.by_score(), [3, 1, 4, 0, 2]);
    }

    #[test]
    fn physics_counts_where_a_grasp_has_a_robust_score() {
        let robust = |held| Grasp { robust: Some(RobustScore { trials: 4, held }), ..grasp(Some(0.5)) };
        let set = GraspSet::new(vec![robust(1), robust(3)]).unwrap();
        assert_eq!(set.scored_by(ScoreKind::Geometric), set);
        let scores = |set: &GraspSet| set.grasps().iter().map(|grasp| grasp.score).collect::<Vec<_>>();
        assert_eq!(scores(&set.scored_by(ScoreKind::Physics)), [Some(0.25), Some(0.75)]);
        let set = GraspSet::new(vec![robust(1), grasp(Some(0.5))]).unwrap();
        assert_eq!(scores(&set.scored_by(ScoreKind::Physics)), [Some(0.25), None]);
    }

    #[test]
    fn a_count_of_more_held_than_tried_is_refused() {
        for robust in [RobustScore { trials: 0, held: 0 }, RobustScore { trials: 2, held: 3 }] {
            let set = GraspSet::new(vec![Grasp { robust: Some(robust), ..grasp(None) }]);
            assert!(matches!(set, Err(GraspError::Robust { grasp: 0, .. })));
        }
    }

    #[test]
    fn a_score_outside_its_range_is_refused() {
        assert!(matches!(GraspSet::new(vec![grasp(Some(1.5))]), Err(GraspError::Score { grasp: 0, .. })));
    }
}
