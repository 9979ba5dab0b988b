use cranny_robot::Robot;
use cranny_solve::TaskTrajectory;
use cranny_spatial::Pose;
use serde::Serialize;

use crate::grasping::grasp_test::whole_steps;
use crate::plans::plan_motion::PlanMotion;
use crate::{Experiment, ExperimentPose, GraspTest, PlacedError, SimError};

/// Pick of a plan as a document for another engine, from the closing of the hand on (`cranny.mujoco_grasps.run_plan` in Python
/// runs it). The arm has moved the hand there without contact.
#[derive(Clone, Debug, Serialize)]
pub struct PlanExperiment {
    /// Hand, object and surroundings, with one grasp.
    #[serde(flatten)]
    pub experiment: Experiment,
    /// Pose of the hand at the end of each step of the drive after the closing, in the planning frame.
    pub held: Vec<ExperimentPose>,
    /// Pose of the hand at the end of each step after it begins to open; empty for a plan without a release.
    pub left: Vec<ExperimentPose>,
    /// Planned set-down pose of the object, if there is one, in the planning frame.
    pub world_from_planned: Option<ExperimentPose>,
    /// Tolerance of the position of a set-down object, in metres.
    pub placed_m: f64,
    /// Tolerance of its orientation, in radians.
    pub placed_rad: f64,
}

impl PlanExperiment {
    /// Creates the document of the timed path of a robot with the hand of a test; a lift follows a path that ends at the grasp.
    ///
    /// # Errors
    /// [`SimError::Figure`] for a lift out of range or a path that takes too long.
    pub fn new(
        test: &GraspTest,
        robot: &Robot,
        path: &TaskTrajectory,
        lift_m: f64,
    ) -> Result<Self, SimError> {
        let motion = PlanMotion::new(path, lift_m, (test, robot))?;
        let tip = |q: &[f64]| *robot.frames_at(q).link(robot.tip());
        let step_s = test.physics.step_s;
        let poses = |duration_s: f64, at: &dyn Fn(f64) -> Vec<f64>| -> Vec<ExperimentPose> {
            let times = (1..=whole_steps(duration_s, step_s)).map(|step| f64::from(step) * step_s);
            times.map(|time_s| (&tip(&at(time_s))).into()).collect()
        };
        let grasp: Pose = tip(&motion.held(0.0));
        Ok(Self {
            experiment: test.experiment(&[grasp]),
            held: poses(motion.held_s(), &|time_s| motion.held(time_s)),
            left: motion
                .left_s()
                .map_or_else(Vec::new, |left_s| poses(left_s, &|time_s| motion.left(time_s))),
            world_from_planned: motion.planned(test.world_from_object()).as_ref().map(Into::into),
            placed_m: PlacedError::MOST_M,
            placed_rad: PlacedError::MOST_RAD,
        })
    }
}
