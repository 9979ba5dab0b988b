use std::ops::Range;

use cranny_spatial::{Pose, Stream};

use crate::ik::ik_batch::IkBatch;
use crate::{IK_BATCH, IkSettings, IkSolution, IkSolver, JointUnit, Robot};

/// Settings of an [`IkSearch`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IkSearchSettings {
    /// Settings of each attempt.
    pub ik: IkSettings,
    /// Two configurations are the same solution if no prismatic joint differs by more than this, in metres, and no revolute
    /// one by more than `distinct_rad`, modulo whole turns for an endless joint. Default 0.05 m: the base of the Panda moved by
    /// an eighth of its width.
    pub distinct_m: f64,
    /// See `distinct_m`. Default 0.1 rad, which moves an outstretched arm's hand by 0.08 m.
    pub distinct_rad: f64,
}

impl Default for IkSearchSettings {
    fn default() -> Self {
        Self { ik: IkSettings::default(), distinct_m: 0.05, distinct_rad: 0.1 }
    }
}

/// Returns up to `count` distinct solutions whose `q` (m, rad; one per joint) `accept` accepts, from at most `attempts`
/// random starts.
///
/// Stops at whichever limit is reached first. The order and, with one version of this crate, every bit of the result is a
/// function of the arguments.
pub fn solve_restarts(
    robot: &Robot,
    root_from_tip: &Pose,
    random: &mut Stream,
    settings: IkSearchSettings,
    count: usize,
    attempts: usize,
    accept: &mut dyn FnMut(&[f64]) -> bool,
) -> Vec<IkSolution> {
    let mut search = IkSearch::new(robot, root_from_tip, settings);
    while search.solutions().len() < count && search.attempts() < attempts {
        let left = attempts - search.attempts();
        search.next_solution(random, left, accept);
    }
    search.solutions
}

/// Resumable search for many solutions to one target, from random starts.
///
/// Attempts run in batches ([`IkBatch`]); further solutions of a batch are kept for the next call.
#[derive(Clone, Debug)]
pub struct IkSearch<'robot> {
    solver: IkSolver<'robot>,
    batch: IkBatch<'robot>,
    /// Attempts of the batch that have not been evaluated yet.
    waiting: Range<usize>,
    settings: IkSearchSettings,
    root_from_tip: Pose,
    solutions: Vec<IkSolution>,
    attempts: usize,
}

impl<'robot> IkSearch<'robot> {
    /// Starts a search for `root_from_tip`. Allocates; attempts do not, except for their solutions.
    pub fn new(robot: &'robot Robot, root_from_tip: &Pose, settings: IkSearchSettings) -> Self {
        Self {
            solver: IkSolver::new(robot, settings.ik),
            batch: IkBatch::new(robot, settings.ik),
            waiting: 0..0,
            settings,
            root_from_tip: *root_from_tip,
            solutions: Vec::new(),
            attempts: 0,
        }
    }

    /// Returns the next solution that is distinct from those before and whose `q` (m, rad; one per joint) `accept` accepts;
    /// `None` if at most `attempts` more random starts lead to none.
    pub fn next_solution(
        &mut self,
        random: &mut Stream,
        attempts: usize,
        accept: &mut dyn FnMut(&[f64]) -> bool,
    ) -> Option<&IkSolution> {
        let mut left = attempts;
        loop {
            while let Some(attempt) = self.waiting.next() {
                let found = self.batch.solution(attempt);
                if found.as_ref().is_some_and(|found| self.is_new(&found.q) && accept(&found.q)) {
                    self.solutions.extend(found);
                    return self.solutions.last();
                }
            }
            if left == 0 {
                return None;
            }
            let count = left.min(IK_BATCH);
            for attempt in 0..count {
                self.batch.draw(attempt, &self.root_from_tip, random);
            }
            self.batch.run(count);
            self.waiting = 0..count;
            self.attempts += count;
            left -= count;
        }
    }

    /// Makes one attempt from `start` (m, rad; one per joint), pulled towards it; it counts as an attempt, and its solution as
    /// one of this search, if it is new and `accept` accepts it.
    ///
    /// # Panics
    /// If `start` does not have one value for each joint of the group.
    pub fn next_from(
        &mut self,
        start: &[f64],
        accept: &mut dyn FnMut(&[f64]) -> bool,
    ) -> Option<&IkSolution> {
        self.attempts += 1;
        let found = self.solver.solve_from(&self.root_from_tip, start)?;
        if !self.is_new(&found.q) || !accept(&found.q) {
            return None;
        }
        self.solutions.push(found);
        self.solutions.last()
    }

    /// Solutions in the order in which they were found.
    pub fn solutions(&self) -> &[IkSolution] {
        &self.solutions
    }

    /// Number of attempts made.
    pub fn attempts(&self) -> usize {
        self.attempts
    }

    fn is_new(&self, q: &[f64]) -> bool {
        let robot = self.solver.robot();
        let differs = |known: &IkSolution| {
            (0..robot.dof()).any(|joint| {
                let least = match robot.limits()[joint].unit {
                    JointUnit::Metre => self.settings.distinct_m,
                    JointUnit::Radian => self.settings.distinct_rad,
                };
                robot.joint_difference(joint, known.q[joint], q[joint]) > least
            })
        };
        self.solutions.iter().all(differs)
    }
}
