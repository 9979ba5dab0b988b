use cranny_collision::{Bubble, Cell, Motion, ReleasedCheck, ReleasedScratch, Scratch};
use cranny_grasp::GraspSet;
use cranny_robot::LinkFrames;
use cranny_spatial::Pose;
use cranny_task::{Problem, Validity, gripper_poses, open_gripper_poses};

/// Check, with its scratch, for planners that grow by steps or burs, some of them under either criterion.
pub(crate) enum BaselineCheck<'a> {
    Exact(&'a Cell, Box<Scratch>),
    Paper { check: &'a ReleasedCheck, scratch: Box<ReleasedScratch>, distances: Box<(&'a Cell, Scratch)> },
}

impl<'a> BaselineCheck<'a> {
    pub fn of(problem: &'a Problem) -> Self {
        match problem.validity() {
            Validity::Exact(cell) => Self::Exact(cell, Box::new(cell.scratch())),
            Validity::Paper { check, distances, .. } => Self::Paper {
                check,
                scratch: Box::new(check.scratch()),
                distances: Box::new((distances, distances.scratch())),
            },
        }
    }

    /// Returns true if a configuration (m, rad; one per joint) is free.
    pub fn is_free(&mut self, q: &[f64]) -> bool {
        match self {
            Self::Exact(cell, scratch) => cell.is_free(q, scratch),
            Self::Paper { check, scratch, .. } => check.is_free(q, scratch),
        }
    }

    /// Returns true if goals are checked; the released planners do not check them.
    pub fn checks_goals(&self) -> bool {
        matches!(self, Self::Exact(..))
    }

    /// Returns true if a tree may grow from `a`, which is free, to `b`, both (m, rad; one per joint): under `exact` if the
    /// whole motion is proven, under `paper` if `b` is free.
    pub fn edge_is_free(&mut self, a: &[f64], b: &[f64]) -> bool {
        match self {
            // A blocked end is the most frequent reason, and cheaper to find than the whole proof.
            Self::Exact(cell, scratch) => {
                cell.is_free(b, scratch) && matches!(cell.motion_is_free(a, b, scratch), Motion::Proven)
            }
            Self::Paper { check, scratch, .. } => check.is_free(b, scratch),
        }
    }

    /// Returns [`Self::edge_is_free`] from `a` to `b` (m, rad; one per joint), given the link frames at `b`.
    pub fn edge_to_frames_is_free(&mut self, a: &[f64], b: &[f64], frames_at_b: &LinkFrames) -> bool {
        match self {
            Self::Exact(..) => self.edge_is_free(a, b),
            Self::Paper { check, .. } => check.robot().within_limits(b) && check.holds(frames_at_b),
        }
    }

    /// Returns [`Cell::bubble`] about `q` (m, rad; one per joint).
    pub fn bubble(&mut self, q: &[f64], critical_m: f64) -> Option<Bubble> {
        match self {
            Self::Exact(cell, scratch) => cell.bubble(q, critical_m, scratch),
            Self::Paper { distances, .. } => distances.0.bubble(q, critical_m, &mut distances.1),
        }
    }

    /// Returns [`Cell::free_share`] towards `target` (m, rad; one per joint): under `exact` the proven share; under `paper` the
    /// maximum length of a spine.
    pub fn free_share(&mut self, bubble: &Bubble, target: &[f64]) -> f64 {
        match self {
            Self::Exact(cell, scratch) => cell.free_share(bubble, target, scratch),
            Self::Paper { distances, .. } => distances.0.free_share(bubble, target, &mut distances.1),
        }
    }

    /// Returns true if a bubble proves everything in it. Under `paper` each way point is checked instead, and no two are
    /// farther apart than a step.
    pub fn is_proven_by_bubbles(&self) -> bool {
        matches!(self, Self::Exact(..))
    }

    /// Returns the poses `world_from_gripper` of grasps, from the highest score down, that are free for the hand alone
    /// (`exact`), or all (`paper`).
    pub fn open_poses(&mut self, grasps: &GraspSet) -> Vec<(usize, Pose)> {
        match self {
            Self::Exact(cell, scratch) => open_gripper_poses(cell, grasps, scratch),
            Self::Paper { .. } => {
                let both = |grasp: usize| gripper_poses(&grasps.grasps()[grasp]).map(|pose| (grasp, pose));
                grasps.by_score().into_iter().flat_map(both).collect()
            }
        }
    }
}
