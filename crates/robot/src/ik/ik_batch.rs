use cranny_spatial::{LANES, Pose, Stream};

use crate::chain::moving_base::Base;
use crate::ik::ik_lanes::IkLanes;
use crate::{IkSettings, IkSolution, IkSolver, Robot};

/// Number of attempts that run in parallel in an [`IkBatch`].
pub const IK_BATCH: usize = LANES;

/// Attempts of inverse kinematics from random starts, up to [`IK_BATCH`] at once, each with its own target.
///
/// They run in parallel SIMD lanes and single precision. The results are then evaluated and, if necessary, corrected in
/// double precision, so a solution is as accurate as one of [`IkSolver`]. An attempt of a batch costs a tenth of a
/// single one, but is given up earlier.
///
/// Starts are uniform within limits, except for the prismatic joints between the root and the first revolute joint (a
/// moving base): these are drawn such that the target is within the arm's reach, if possible.
#[derive(Clone, Debug)]
pub struct IkBatch<'robot> {
    solver: IkSolver<'robot>,
    lanes: IkLanes,
    base: Option<Base>,
    targets: [Pose; IK_BATCH],
    start: Vec<f64>,
}

impl<'robot> IkBatch<'robot> {
    /// Returns a batch for the tip of `robot`; `settings.pull` is ignored. Allocates; attempts allocate only their solutions.
    pub fn new(robot: &'robot Robot, settings: IkSettings) -> Self {
        Self {
            solver: IkSolver::new(robot, settings),
            lanes: IkLanes::new(robot, &settings),
            base: Base::of(robot),
            targets: [Pose::identity(); IK_BATCH],
            start: vec![0.0; robot.dof()],
        }
    }

    /// Sets the target of this attempt of the next run, and draws its start.
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

    /// Sets the target and the start (m, rad; within limits) of this attempt of the next run; its solution tends to be near
    /// the start.
    ///
    /// # Panics
    /// If `attempt` is not below [`IK_BATCH`], or `start` does not have one value per joint.
    pub fn begin_at(&mut self, attempt: usize, root_from_tip: &Pose, start: &[f64]) {
        assert_eq!(start.len(), self.start.len(), "one value per joint");
        self.targets[attempt] = *root_from_tip;
        self.lanes.set(attempt, root_from_tip, start);
    }

    /// Runs attempts 0 to `count` − 1.
    ///
    /// # Panics
    /// If `count` is above [`IK_BATCH`].
    pub fn run(&mut self, count: usize) {
        assert!(count <= IK_BATCH, "no more attempts than lanes");
        self.lanes.run(count);
    }

    /// Returns the solution of this attempt of the last run; `None` if it did not converge, which does not prove that no
    /// solution exists.
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
