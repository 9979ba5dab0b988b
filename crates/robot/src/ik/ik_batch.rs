use cranny_spatial::{LANES, Pose, Stream};

use crate::chain::moving_base::Base;
use crate::ik::ik_lanes::IkLanes;
use crate::{IkSettings, IkSolution, IkSolver, Robot};

/// How many attempts run side by side in an [`IkBatch`].
pub const IK_BATCH: usize = LANES;

/// Attempts of inverse kinematics from random starts, up to [`IK_BATCH`] at once, each with a target of its
/// own.
///
/// They run side by side in vector lanes and single precision; what they reach is then measured, and if need
/// be corrected, in double precision, so that a solution is as good as one of [`IkSolver`]. An attempt of a
/// batch costs a tenth of one alone, but is given up earlier.
///
/// A start is uniform within limits, but for the prismatic joints between the root and the first joint that
/// turns (a moving base): these are drawn such that the target is within the arm's reach, if they can be.
#[derive(Clone, Debug)]
pub struct IkBatch<'robot> {
    solver: IkSolver<'robot>,
    lanes: IkLanes,
    base: Option<Base>,
    targets: [Pose; IK_BATCH],
    start: Vec<f64>,
}

impl<'robot> IkBatch<'robot> {
    /// A batch for the tip of `robot`; `settings.pull` has no part in it. This allocates; attempts do not,
    /// but for the solutions that they find.
    pub fn new(robot: &'robot Robot, settings: IkSettings) -> Self {
        Self {
            solver: IkSolver::new(robot, settings),
            lanes: IkLanes::new(robot, &settings),
            base: Base::of(robot),
            targets: [Pose::identity(); IK_BATCH],
            start: vec![0.0; robot.dof()],
        }
    }

    /// Gives this attempt of the next run a target, and draws where it starts.
    ///
    /// # Panics
    /// If `attempt` is not below [`IK_BATCH`].
    pub fn draw(&mut self, attempt: usize, root_from_tip: &Pose, random: &mut Stream) {
        let robot = self.solver.robot();
        for (value, limits) in self.start.iter_mut().zip(robot.limits()) {
            *value = random.uniform_between(limits.lower, limits.upper);
        }
        if let Some(base) = &self.base {
            base.draw_near(robot, &root_from_tip.translation.vector, random, &mut self.start);
        }
        self.targets[attempt] = *root_from_tip;
        self.lanes.set(attempt, root_from_tip, &self.start);
    }

    /// Gives this attempt of the next run a target, and where it starts (m, rad; within limits): what it reaches is near
    /// there.
    ///
    /// # Panics
    /// If `attempt` is not below [`IK_BATCH`], or `start` has not one value per joint.
    pub fn begin_at(&mut self, attempt: usize, root_from_tip: &Pose, start: &[f64]) {
        assert_eq!(start.len(), self.start.len(), "one value per joint");
        self.targets[attempt] = *root_from_tip;
        self.lanes.set(attempt, root_from_tip, start);
    }

    /// Runs attempts 0 to `count` − 1 from where they were drawn.
    ///
    /// # Panics
    /// If `count` is above [`IK_BATCH`].
    pub fn run(&mut self, count: usize) {
        assert!(count <= IK_BATCH, "no more attempts than lanes");
        self.lanes.run(count);
    }

    /// The solution of this attempt of the last run; None if it got stuck, which does not prove that there
    /// is none.
    ///
    /// # Panics
    /// If `attempt` is not below [`IK_BATCH`].
    pub fn solution(&mut self, attempt: usize) -> Option<IkSolution> {
        assert!(attempt < IK_BATCH, "an attempt of the batch");
        if !self.lanes.is_reached(attempt) {
            return None;
        }
        let reached = self.lanes.q(attempt);
        let found = self.solver.solve_from_drawn(&self.targets[attempt], |q| {
            q.iter_mut().zip(reached).for_each(|(value, reached)| *value = reached);
        });
        found.map(|found| IkSolution {
            iterations: found.iterations + self.lanes.iterations(attempt),
            ..found
        })
    }
}
