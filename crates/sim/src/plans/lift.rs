use cranny_grasp::smooth_share;
use cranny_robot::{IkSettings, IkSolver, Robot};
use cranny_spatial::Vector;
use cranny_spatial::nalgebra::Translation3;

/// Configurations of a straight vertical lift.
pub(crate) struct Lift {
    rungs: Vec<Vec<f64>>,
    pub lift_m: f64,
}

/// Distance between two configurations of a lift, in metres.
const RUNG_M: f64 = 0.001;

impl Lift {
    /// Computes a lift from a configuration (m, rad; one per joint) along the unit vector `up` of the planning frame, up to
    /// `lift_m` or to a jump of the inverse kinematics.
    pub fn new(robot: &Robot, from: &[f64], up: &Vector, lift_m: f64) -> Self {
        let world_from_gripper = *robot.frames_at(from).link(robot.tip());
        let mut solver = IkSolver::new(robot, IkSettings::default());
        let mut rungs = vec![from.to_vec()];
        let mut lifted_m = 0.0;
        while lifted_m < lift_m {
            let next_m = (lifted_m + RUNG_M).min(lift_m);
            let target = Translation3::from(up * next_m) * world_from_gripper;
            let Some(next) = solver.step_from(&target, &rungs[rungs.len() - 1]) else { break };
            rungs.push(next);
            lifted_m = next_m;
        }
        Self { rungs, lift_m: lifted_m }
    }

    /// Returns the configuration (m, rad; one per joint) at a time, in seconds, of a lift that takes `lift_s` seconds.
    pub fn at(&self, time_s: f64, lift_s: f64) -> Vec<f64> {
        let along = smooth_share(time_s / lift_s) * (self.rungs.len() - 1) as f64;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "not negative, and at most as many as there are"
        )]
        let rung = (along as usize).min(self.rungs.len().saturating_sub(2));
        let next = &self.rungs[(rung + 1).min(self.rungs.len() - 1)];
        let share = along - rung as f64;
        self.rungs[rung].iter().zip(next).map(|(a, b)| a + share * (b - a)).collect()
    }
}
