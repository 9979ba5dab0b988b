use std::cell::RefCell;
use std::sync::Arc;

use cranny_grasp::smooth_share;
use cranny_path::{Trajectory, TrajectorySample};
use cranny_robot::{IkSettings, IkSolver, LinkFrames, Robot};
use cranny_solve::{CLOSING_S, TaskTrajectory};
use cranny_spatial::{Pose, PoseDifference};
use rapier3d_f64::prelude::ColliderHandle;

use crate::grasping::grasp_test::whole_steps;
use crate::grasping::grasp_trial::{GraspTrial, Move};
use crate::gripper::Gripper;
use crate::plans::arm::{Arm, ArmModel};
use crate::plans::plan_run::{PlacedError, PlanContact, PlanRun, TrackingError};
use crate::{Disturbance, DriveSettings, GraspTest, RecordedBody, SimError};

/// A robot that does what a plan says: its joints follow the timed path, the hand closes, and the arm lifts straight up
/// what is then in it. The object lies on its support all the while.
///
/// The arm consists of the rigid bodies of its URDF, whose drives are servos within the effort limits
/// ([`DriveSettings`]); gravity pulls at all of it. Links touch where their convex pieces do. The arm does not touch
/// itself, and the object sleeps until it is touched.
#[derive(Clone, Debug)]
pub struct PlanTest {
    test: GraspTest,
    robot: Arc<Robot>,
    arm: ArmModel,
}

impl PlanTest {
    /// The robot with the hand of a test, in its surroundings.
    ///
    /// # Errors
    /// [`SimError::NoMass`] for a robot whose links weigh nothing, [`SimError::Mimic`] for a joint of the arm that follows
    /// another, [`SimError::Figure`] for drives out of their range, [`SimError::Shape`] for a link without volume.
    pub fn new(test: GraspTest, robot: Arc<Robot>, drives: DriveSettings) -> Result<Self, SimError> {
        let arm = ArmModel::new(&robot, drives)?;
        Ok(Self { test, robot, arm })
    }

    /// Follows a path to the grasp, closes the hand, and follows it on, and opens the hand where it puts the object down; a
    /// path that ends at the grasp is followed by a lift straight up, by `lift_m`.
    ///
    /// # Errors
    /// [`SimError::Figure`] for a lift out of its range or a path that takes too long.
    ///
    /// # Panics
    /// If the path is not one of the robot's joints.
    pub fn run(&self, path: &TaskTrajectory, lift_m: f64, is_recorded: bool) -> Result<PlanRun, SimError> {
        let (reach, onward, off) = (path.reach(), path.legs().get(1), path.legs().get(2));
        let lift_m = if onward.is_some() { 0.0 } else { lift_m };
        for (figure, value, range, most) in [
            ("lift", lift_m, "from 0 to 1 m", 1.0),
            ("time of the motion", path.duration_s(), "from 0 to 600 s", 600.0),
        ] {
            if !(0.0..=most).contains(&value) {
                return Err(SimError::Figure { figure, value, range });
            }
        }
        let [start, end] = [0.0, reach.duration_s()].map(|time_s| reach.sample(time_s).position);
        let mut executed = Execution::new(self, &start, is_recorded);
        executed.rest(STANDING_S);
        let world_from_resting = executed.trial.world_from_object();
        let on_the_way = executed.follow(reach);
        let at_the_end = executed.tracking_error(&end);
        let resting = executed.trial.test.object.center;
        let pushed_m = (executed.trial.world_from_object() * resting - world_from_resting * resting).norm();
        let lift = Lift::new(&self.robot, &end, lift_m);
        let Execution { trial, arm, contacts, began_steps, .. } = executed;
        let contacts = RefCell::new(contacts);
        let moving_s = onward.map_or(self.test.course.lift_s, Trajectory::duration_s);
        let aim = |trial: &mut GraspTrial<'_>, (q, velocity): (Vec<f64>, Vec<f64>)| {
            arm.aim(&q, &velocity, &mut trial.world);
            touched(self, trial, &arm, began_steps, true, &mut contacts.borrow_mut());
        };
        let of_sample = |sample: TrajectorySample| (sample.position, sample.velocity);
        let mut carry = |trial: &mut GraspTrial<'_>, time_s: f64| {
            let at = onward.map(|onward| of_sample(onward.sample(time_s)));
            aim(trial, at.unwrap_or_else(|| lift.at(time_s, moving_s)));
        };
        // Where it is put down, the hand opens before it goes.
        let opening_s = path.hand_times_s().get(1).copied().unwrap_or(CLOSING_S);
        let mut leave = |trial: &mut GraspTrial<'_>, time_s: f64| {
            let Some(off) = off else { return };
            aim(trial, of_sample(off.sample((time_s - opening_s).max(0.0))));
        };
        let held = Move { duration_s: moving_s + RESTING_S, advance: &mut carry };
        let leaving_s = off.map(|off| opening_s + off.duration_s() + RESTING_S);
        let leaving = leaving_s.map(|duration_s| Move { duration_s, advance: &mut leave });
        let grasp = trial.grasp(held, leaving);
        let contacts = contacts.into_inner();
        let world_from_tip = |q: &[f64]| *self.robot.frames_at(q).link(self.robot.tip());
        let planned = onward.filter(|_| off.is_some()).map(|onward| {
            let down = onward.sample(onward.duration_s()).position;
            world_from_tip(&down) * world_from_tip(&end).inverse() * world_from_resting
        });
        let off = |actual: &Pose| planned.map(|planned| PlacedError::between(&planned, actual, &resting));
        Ok(PlanRun {
            reach_s: reach.duration_s(),
            on_the_way,
            at_the_end,
            contacts,
            pushed_m,
            lift_m: lift.lift_m,
            world_from_resting,
            released: grasp.world_from_released.as_ref().and_then(off),
            placed: off(&grasp.world_from_object),
            grasp,
        })
    }
}

/// Before it moves, the arm stands for so long, in seconds: it sinks a little into its drives.
const STANDING_S: f64 = 0.2;
/// After the lift the arm is still for so long, in seconds.
const RESTING_S: f64 = 0.5;

/// A plan under way.
struct Execution<'a> {
    test: &'a PlanTest,
    trial: GraspTrial<'a>,
    arm: Arm,
    contacts: Vec<PlanContact>,
    /// How many steps were made before the plan began.
    began_steps: u32,
    frames: LinkFrames,
}

impl<'a> Execution<'a> {
    fn new(plan: &'a PlanTest, start: &[f64], is_recorded: bool) -> Self {
        let test = &plan.test;
        let (mut world, object) = test.world(&Disturbance::default());
        let arm = plan.arm.insert(&plan.robot, start, &mut world);
        let gripper = Gripper::mount(&test.hand, &test.physics, arm.tip(), &arm.tip_from_gripper, &mut world);
        let recorded = is_recorded.then(|| {
            let bodies = plan.arm.shapes().map(|(name, pieces)| RecordedBody::new(name, pieces));
            bodies.zip(arm.bodies.iter().copied()).collect()
        });
        let trial = GraspTrial::with(test, world, gripper, object, recorded);
        Self { test: plan, trial, arm, contacts: Vec::new(), began_steps: 0, frames: plan.robot.frames() }
    }

    /// Stands still. The object then sleeps until it is touched: without a resistance to rolling a ball wanders off.
    fn rest(&mut self, time_s: f64) {
        for _ in 0..self.steps(time_s) {
            self.trial.step_open();
        }
        self.trial.world.bodies[self.trial.object].sleep();
        self.began_steps = self.trial.steps();
    }

    /// Follows a path; with the worst of the tracking errors.
    fn follow(&mut self, path: &Trajectory) -> TrackingError {
        let mut worst = TrackingError::default();
        let steps = self.steps(path.duration_s());
        for step in 1..=steps {
            let sample = path.sample(path.duration_s() * f64::from(step) / f64::from(steps));
            self.arm.aim(&sample.position, &sample.velocity, &mut self.trial.world);
            self.trial.step_open();
            worst = worst.worst(self.tracking_error(&sample.position));
            touched(self.test, &self.trial, &self.arm, self.began_steps, false, &mut self.contacts);
        }
        worst
    }

    fn tracking_error(&mut self, q: &[f64]) -> TrackingError {
        let robot = &self.test.robot;
        let actual = self.arm.configuration(&self.trial.world);
        robot.tip_kinematics(q, &mut self.frames);
        let planned = *self.frames.link(robot.tip());
        robot.tip_kinematics(&actual, &mut self.frames);
        let difference = PoseDifference::between(&planned, self.frames.link(robot.tip()));
        TrackingError {
            translation_m: difference.translation_m,
            rotation_rad: difference.rotation_rad,
            joint: q.iter().zip(&actual).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max),
        }
    }

    fn steps(&self, time_s: f64) -> u32 {
        whole_steps(time_s, self.trial.test.physics.step_s).max(1)
    }
}

/// Adds what arm and hand touch now: before the hand closes the object too, afterwards only what stands around.
fn touched(
    plan: &PlanTest,
    trial: &GraspTrial<'_>,
    arm: &Arm,
    began_steps: u32,
    is_lifting: bool,
    contacts: &mut Vec<PlanContact>,
) {
    let world = &trial.world;
    let hand = std::iter::once(trial.gripper.palm).chain(trial.gripper.fingers.iter().copied());
    let of_hand = hand.map(|body| ("hand", body));
    let of_arm = plan.arm.shapes().map(|(name, _)| name).zip(arm.bodies.iter().copied());
    for (link, body) in of_arm.chain(of_hand) {
        for &own in world.bodies[body].colliders() {
            for pair in world.contact_pairs_with(own) {
                let other = if pair.collider1 == own { pair.collider2 } else { pair.collider1 };
                let points = pair.manifolds().iter().flat_map(|manifold| &manifold.points);
                let depth_m = -points.map(|point| point.dist).fold(f64::INFINITY, f64::min);
                let is_object = world.colliders[other].parent() == Some(trial.object);
                if depth_m <= 0.0 || (is_object && is_lifting) {
                    continue;
                }
                let body = plan.name_of(other, is_object, trial);
                let known = contacts.iter_mut().find(|contact| {
                    contact.link == link && contact.body == body && contact.is_lifting == is_lifting
                });
                if let Some(known) = known {
                    known.depth_m = known.depth_m.max(depth_m);
                    continue;
                }
                let time_s = f64::from(trial.steps() - began_steps) * plan.test.physics.step_s;
                let (link, body) = (link.to_owned(), body.to_owned());
                contacts.push(PlanContact { time_s, link, body, depth_m, is_lifting });
            }
        }
    }
}

impl PlanTest {
    fn name_of<'a>(&'a self, collider: ColliderHandle, is_object: bool, trial: &GraspTrial<'_>) -> &'a str {
        if is_object {
            return &self.test.object.name;
        }
        let body = usize::try_from(trial.world.colliders[collider].user_data).unwrap_or(usize::MAX);
        self.test.surroundings().get(body).map_or("?", |body| &body.name)
    }
}

/// Configurations on the way straight up.
struct Lift {
    rungs: Vec<Vec<f64>>,
    lift_m: f64,
}

impl Lift {
    /// From a configuration, as far as inverse kinematics go without a jump.
    fn new(robot: &Robot, from: &[f64], lift_m: f64) -> Self {
        let world_from_gripper = *robot.frames_at(from).link(robot.tip());
        let mut solver = IkSolver::new(robot, IkSettings::default());
        let mut rungs = vec![from.to_vec()];
        let mut lifted_m = 0.0;
        while lifted_m < lift_m {
            let next_m = (lifted_m + RUNG_M).min(lift_m);
            let target = Pose::translation(0.0, 0.0, next_m) * world_from_gripper;
            let Some(next) = solver.step_from(&target, &rungs[rungs.len() - 1]) else { break };
            rungs.push(next);
            lifted_m = next_m;
        }
        Self { rungs, lift_m: lifted_m }
    }

    /// Where the joints are to be, and how fast.
    fn at(&self, time_s: f64, lift_s: f64) -> (Vec<f64>, Vec<f64>) {
        let place = |time_s: f64| {
            let along = smooth_share(time_s / lift_s) * (self.rungs.len() - 1) as f64;
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "not negative, and at most as many as there are"
            )]
            let rung = (along as usize).min(self.rungs.len().saturating_sub(2));
            let next = &self.rungs[(rung + 1).min(self.rungs.len() - 1)];
            let share = along - rung as f64;
            self.rungs[rung].iter().zip(next).map(|(a, b)| a + share * (b - a)).collect::<Vec<f64>>()
        };
        const MOMENT_S: f64 = 1e-3;
        let (before, after) = (place(time_s - MOMENT_S), place(time_s + MOMENT_S));
        let velocity = after.iter().zip(&before).map(|(b, a)| (b - a) / (2.0 * MOMENT_S));
        (place(time_s), velocity.collect())
    }
}

/// Between two configurations of a lift, in metres.
const RUNG_M: f64 = 0.001;
