use std::sync::Arc;

use cranny_collision::{Cell, Margins, Motion, ReleasedCheck, ReleasedScratch, Scratch, World};
use cranny_grasp::GraspSet;
use cranny_robot::{LinkFrames, Robot};
use cranny_spatial::PoseDifference;

use crate::{NotChecked, PlanError};

/// What a path must do, and what makes it valid.
#[derive(Clone, Debug)]
pub struct Problem {
    /// The robot; its root frame is the planning frame.
    pub robot: Arc<Robot>,
    /// Which body of the world is to be grasped and may later be carried, by index.
    pub target: Option<usize>,
    /// The configuration to start from (m, rad; one value per joint).
    pub start: Vec<f64>,
    /// Where to go.
    pub goal: Goal,
    /// What counts as free.
    pub validity: Validity,
}

/// Where a path must end.
#[derive(Clone, Debug)]
pub enum Goal {
    /// At any of these grasps.
    Grasps(GraspSet),
    /// At any of these configurations.
    Configurations(Vec<Vec<f64>>),
}

/// When a problem counts as solved (DESIGN, "What solved means").
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Criterion {
    /// Within 1 mm and 1° of a grasp, the real geometry, the whole path proven.
    #[default]
    Exact,
    /// The released planners' own measure, for comparison only: within `d < 50`, way points only.
    Paper,
}

impl Criterion {
    /// What files and flags call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Paper => "paper",
        }
    }
}

/// What counts as free, with the geometry that decides it.
#[derive(Clone, Debug)]
pub enum Validity {
    /// Exact shapes, and proofs of whole motions.
    Exact(Arc<Cell>),
    /// The released check of single configurations.
    Paper {
        /// The check.
        check: Arc<ReleasedCheck>,
        /// The gripper has arrived where `d = ½·mm + ½·deg` is below this; [`PAPER_THRESHOLD`] in the paper,
        /// 0 for a search that never arrives.
        threshold: f64,
    },
}

/// Room for a [`Validity`] to compute in.
#[derive(Clone, Debug)]
pub enum ValidityScratch {
    /// For the exact check.
    Exact(Box<Scratch>),
    /// For the released check.
    Paper(Box<ReleasedScratch>),
}

impl Validity {
    /// The criterion that this is the validity of.
    pub fn criterion(&self) -> Criterion {
        match self {
            Self::Exact(_) => Criterion::Exact,
            Self::Paper { .. } => Criterion::Paper,
        }
    }

    /// Room to compute in.
    pub fn scratch(&self) -> ValidityScratch {
        match self {
            Self::Exact(cell) => ValidityScratch::Exact(Box::new(cell.scratch())),
            Self::Paper { check, .. } => ValidityScratch::Paper(Box::new(check.scratch())),
        }
    }

    /// Whether a single configuration is free.
    ///
    /// # Panics
    /// If `q` has not one value per joint, or the scratch was made by another kind of validity.
    pub fn is_free(&self, q: &[f64], scratch: &mut ValidityScratch) -> bool {
        match (self, scratch) {
            (Self::Exact(cell), ValidityScratch::Exact(scratch)) => cell.is_free(q, scratch),
            (Self::Paper { check, .. }, ValidityScratch::Paper(scratch)) => check.is_free(q, scratch),
            _ => panic!("the scratch belongs to another kind of validity"),
        }
    }

    /// Whether a tree may grow from `a`, which is free, to `b`: under `exact` if the whole motion is
    /// proven, under `paper` if `b` alone is free.
    ///
    /// # Panics
    /// As [`Self::is_free`].
    pub fn edge_is_free(&self, a: &[f64], b: &[f64], scratch: &mut ValidityScratch) -> bool {
        match (self, scratch) {
            // A blocked end is the usual reason, and cheaper to find than the whole proof.
            (Self::Exact(cell), ValidityScratch::Exact(scratch)) => {
                cell.is_free(b, scratch) && matches!(cell.motion_is_free(a, b, scratch), Motion::Proven)
            }
            (Self::Paper { check, .. }, ValidityScratch::Paper(scratch)) => check.is_free(b, scratch),
            _ => panic!("the scratch belongs to another kind of validity"),
        }
    }

    /// [`Self::edge_is_free`] for one who knows the link frames at `b` already.
    pub(crate) fn edge_to_frames_is_free(
        &self,
        a: &[f64],
        b: &[f64],
        frames_at_b: &LinkFrames,
        scratch: &mut ValidityScratch,
    ) -> bool {
        match self {
            Self::Exact(_) => self.edge_is_free(a, b, scratch),
            Self::Paper { check, .. } => check.robot().within_limits(b) && check.holds(frames_at_b),
        }
    }

    /// Whether a gripper this far from a grasp has arrived.
    pub fn is_arrival(&self, difference: &PoseDifference) -> bool {
        match self {
            Self::Exact(_) => difference.is_exact(),
            Self::Paper { threshold, .. } => difference.paper_metric() < *threshold,
        }
    }
}

impl ValidityScratch {
    /// The link frames of the configuration that was asked about last. After a proof of a motion that is
    /// some configuration of the motion.
    pub fn frames(&self) -> &LinkFrames {
        match self {
            Self::Exact(scratch) => scratch.frames(),
            Self::Paper(scratch) => scratch.frames(),
        }
    }
}

/// The released planners stop below this value of `d = ½·mm + ½·deg`.
pub const PAPER_THRESHOLD: f64 = 50.0;

impl Problem {
    /// A problem under the `exact` criterion. Pairs of links that touch in every sample are not checked
    /// ([`Cell::unchecked`]), but those that are free at the start or at a goal configuration are.
    ///
    /// # Errors
    /// [`PlanError::JointCount`] or [`PlanError::NotFinite`] for a start or goal configuration that does not
    /// fit the robot, [`PlanError::Collision`] for a negative margin.
    pub fn exact(
        robot: Arc<Robot>,
        world: World,
        target: Option<usize>,
        start: Vec<f64>,
        goal: Goal,
        mut margins: Margins,
    ) -> Result<Self, PlanError> {
        if let Some(target) = target {
            margins = margins.for_target(&world, target);
        }
        let cell = Cell::new(robot.clone(), world, margins)?;
        let mut problem =
            Self { robot, target, start, goal, validity: Validity::Exact(Arc::new(cell)) }.checked()?;
        if let Validity::Exact(cell) = &problem.validity {
            let known = std::iter::once(&problem.start).chain(problem.goal_configurations());
            problem.validity = Validity::Exact(cell.with_pairs_free_at(known.map(Vec::as_slice)));
        }
        Ok(problem)
    }

    /// A problem under the `paper` criterion.
    ///
    /// # Errors
    /// [`PlanError::JointCount`] or [`PlanError::NotFinite`] for a start or goal configuration that does not
    /// fit the robot.
    pub fn paper(check: ReleasedCheck, start: Vec<f64>, goal: Goal) -> Result<Self, PlanError> {
        let robot = check.robot().clone();
        let validity = Validity::Paper { check: Arc::new(check), threshold: PAPER_THRESHOLD };
        Self { robot, target: None, start, goal, validity }.checked()
    }

    /// The criterion that decides.
    pub fn criterion(&self) -> Criterion {
        self.validity.criterion()
    }

    /// The same problem with one goal configuration instead of its grasps.
    ///
    /// # Errors
    /// [`PlanError::JointCount`] or [`PlanError::NotFinite`] if it does not fit the robot.
    pub fn with_goal(&self, q: Vec<f64>) -> Result<Self, PlanError> {
        Self { goal: Goal::Configurations(vec![q]), ..self.clone() }.checked()
    }

    /// The same problem with all pairs of links checked but those that are exempt by declaration.
    #[must_use]
    pub fn checking_all_pairs(mut self) -> Self {
        if let Validity::Exact(cell) = &self.validity
            && !cell.unchecked().is_empty()
        {
            self.validity = Validity::Exact(Arc::new(cell.with_all_pairs()));
        }
        self
    }

    /// What touches and is not checked, under `exact`.
    pub fn not_checked(&self) -> Vec<NotChecked> {
        match &self.validity {
            Validity::Exact(cell) => NotChecked::of(cell),
            Validity::Paper { .. } => Vec::new(),
        }
    }

    fn goal_configurations(&self) -> &[Vec<f64>] {
        match &self.goal {
            Goal::Grasps(_) => &[],
            Goal::Configurations(goals) => goals,
        }
    }

    fn checked(self) -> Result<Self, PlanError> {
        let goals = self.goal_configurations();
        for (what, q) in std::iter::once(("start", &self.start)).chain(goals.iter().map(|q| ("goal", q))) {
            self.check_configuration(what, q)?;
        }
        Ok(self)
    }

    pub(crate) fn check_configuration(&self, what: &'static str, q: &[f64]) -> Result<(), PlanError> {
        if q.len() != self.robot.dof() {
            return Err(PlanError::JointCount { what, expected: self.robot.dof(), actual: q.len() });
        }
        match q.iter().position(|x| !x.is_finite()) {
            Some(joint) => Err(PlanError::NotFinite { what, joint: self.robot.joint_names()[joint].clone() }),
            None => Ok(()),
        }
    }
}
