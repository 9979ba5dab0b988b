use std::cell::RefCell;
use std::sync::Arc;

use cranny_path::Trajectory;
use cranny_robot::Robot;
use cranny_solve::TaskTrajectory;
use cranny_spatial::Pose;
use rapier3d_f64::prelude::{ColliderHandle, RigidBodyHandle};

use crate::grasping::grasp_test::whole_steps;
use crate::grasping::grasp_trial::{GraspTrial, Move};
use crate::gripper::Gripper;
use crate::plans::arm::{ArmModel, see_all_contacts};
use crate::plans::plan_motion::PlanMotion;
use crate::plans::plan_run::{ContactPhase, PlacedError, PlanContact, PlanRun};
use crate::{Disturbance, GraspTest, Piece, RecordedBody, SimError, engine};

/// Robot that executes a plan: its joints follow the timed path, the hand closes with its closing force, and the arm moves on
/// with the object.
///
/// Arm and palm have prescribed motions; contacts push and pull fingers and object. Contacts of links are those of their convex
/// pieces. The arm does not collide with itself, and the object sleeps until it is touched.
#[derive(Clone, Debug)]
pub struct PlanTest {
    test: GraspTest,
    robot: Arc<Robot>,
    arm: ArmModel,
}

impl PlanTest {
    /// Creates a test of the robot with the hand of a grasp test, in its surroundings.
    ///
    /// # Errors
    /// [`SimError::Shape`] for a link without volume.
    pub fn new(test: GraspTest, robot: Arc<Robot>) -> Result<Self, SimError> {
        let arm = ArmModel::new(&robot)?;
        Ok(Self { test, robot, arm })
    }

    /// Follows a path to the grasp, closes the hand, follows it on, and opens the hand at the set-down. After a path that ends
    /// at the grasp it lifts straight up by `lift_m` metres. The object is then observed: 0.5 s in the hand, 2 s after a
    /// set-down.
    ///
    /// # Errors
    /// [`SimError::Figure`] for a lift out of range or a path that takes too long.
    ///
    /// # Panics
    /// If the path does not have the joints of the robot.
    pub fn run(
        &self,
        path: &TaskTrajectory,
        lift_m: f64,
        disturbance: &Disturbance,
        is_recorded: bool,
    ) -> Result<PlanRun, SimError> {
        let motion = PlanMotion::new(path, lift_m, (&self.test, &self.robot))?;
        let start = motion.reach.sample(0.0).position;
        let mut executed = Execution::new(self, &start, disturbance, is_recorded);
        let world_from_resting = executed.trial.world_from_object();
        executed.follow(motion.reach);
        let center = executed.trial.test.object.center;
        let pushed_m = (executed.trial.world_from_object() * center - world_from_resting * center).norm();
        let Execution { trial, hand, contacts, began_steps, .. } = executed;
        let contacts = RefCell::new(contacts);
        let aim = |trial: &mut GraspTrial<'_>, q: &[f64], phase: ContactPhase| {
            hand.aim(self, q, trial);
            touched(self, trial, &hand.arm, began_steps, phase, &mut contacts.borrow_mut());
        };
        let mut carry =
            |trial: &mut GraspTrial<'_>, time_s: f64| aim(trial, &motion.held(time_s), ContactPhase::Hold);
        let mut leave = |trial: &mut GraspTrial<'_>, time_s: f64| {
            let phase = if motion.has_opened(time_s) { ContactPhase::Release } else { ContactPhase::Hold };
            aim(trial, &motion.left(time_s), phase);
        };
        let held = Move { duration_s: motion.held_s(), advance: &mut carry };
        let leaving = motion.left_s().map(|duration_s| Move { duration_s, advance: &mut leave });
        let grasp = trial.grasp(held, leaving);
        let contacts = contacts.into_inner();
        let planned = motion.planned(&world_from_resting);
        let off =
            |actual: &Pose| planned.map(|planned| PlacedError::between(&planned, actual, &self.test.object));
        Ok(PlanRun {
            reach_s: motion.reach.duration_s(),
            contacts,
            pushed_m,
            lift_m: motion.lift.lift_m,
            rose_m: {
                let [ended, began] = [&grasp.world_from_object, &world_from_resting];
                (ended.translation.vector - began.translation.vector).dot(&self.test.physics.up)
            },
            world_from_resting,
            released: grasp.world_from_released.as_ref().and_then(off),
            placed: grasp.world_from_released.and_then(|_| off(&grasp.world_from_object)),
            grasp,
        })
    }
}

/// Duration of the pause of the arm before it moves, in seconds.
const STANDING_S: f64 = 0.02;

/// Arm and palm with prescribed motions.
struct Prescribed {
    arm: Vec<RigidBodyHandle>,
    tip_from_hand: Pose,
}

impl Prescribed {
    /// Sets the target of the next step: arm and hand at a configuration (m, rad; one per joint).
    fn aim(&self, plan: &PlanTest, q: &[f64], trial: &mut GraspTrial<'_>) {
        let palm = trial.gripper.palm;
        let world_from_hand = plan.arm.aim(&plan.robot, q, &self.arm, &mut trial.world) * self.tip_from_hand;
        trial.world.bodies[palm].set_next_kinematic_position(engine::pose(&world_from_hand));
    }
}

struct Execution<'a> {
    test: &'a PlanTest,
    trial: GraspTrial<'a>,
    hand: Prescribed,
    contacts: Vec<PlanContact>,
    /// Number of steps before the plan began.
    began_steps: u32,
}

impl<'a> Execution<'a> {
    fn new(plan: &'a PlanTest, start: &[f64], disturbance: &Disturbance, is_recorded: bool) -> Self {
        let test = &plan.test;
        let (mut world, object) = test.world(disturbance);
        let arm = plan.arm.insert(&plan.robot, start, &mut world);
        let hand = Prescribed { arm, tip_from_hand: disturbance.grasp_from_hand };
        let force_n = test.hand.closing_force_n * disturbance.closing_force;
        let world_from_hand =
            plan.robot.frames_at(start).link(plan.robot.tip()) * disturbance.grasp_from_hand;
        let gripper = Gripper::insert(&test.hand, &test.physics, force_n, &world_from_hand, &mut world);
        see_all_contacts(&mut world, gripper.palm);
        let recorded = is_recorded.then(|| {
            let bodies =
                plan.arm.shapes().map(|(name, pieces)| RecordedBody::new(name, Piece::surface_of(pieces)));
            bodies.zip(hand.arm.iter().copied()).collect()
        });
        let rolling = test.object.rolling(test.physics.rolling_m, disturbance);
        let mut trial = GraspTrial::with(test, world, gripper, (object, rolling), recorded);
        for _ in 0..whole_steps(STANDING_S, test.physics.step_s) {
            trial.step_open();
        }
        // The object sleeps until it is touched, so that it does not creep while it rests.
        trial.world.bodies[object].sleep();
        let began_steps = trial.steps();
        Self { test: plan, trial, hand, contacts: Vec::new(), began_steps }
    }

    fn follow(&mut self, path: &Trajectory) {
        let steps = whole_steps(path.duration_s(), self.trial.test.physics.step_s).max(1);
        for step in 1..=steps {
            let sample = path.sample(path.duration_s() * f64::from(step) / f64::from(steps));
            self.hand.aim(self.test, &sample.position, &mut self.trial);
            self.trial.step_open();
            touched(
                self.test,
                &self.trial,
                &self.hand.arm,
                self.began_steps,
                ContactPhase::Reach,
                &mut self.contacts,
            );
        }
    }
}

/// Adds the current contacts of arm and hand with the surroundings, and with the object unless the hand holds it.
fn touched(
    plan: &PlanTest,
    trial: &GraspTrial<'_>,
    arm: &[RigidBodyHandle],
    began_steps: u32,
    phase: ContactPhase,
    contacts: &mut Vec<PlanContact>,
) {
    let world = &trial.world;
    let hand = std::iter::once(trial.gripper.palm).chain(trial.gripper.fingers.iter().copied());
    let of_hand = hand.map(|body| ("hand", body));
    let of_arm = plan.arm.shapes().map(|(name, _)| name).zip(arm.iter().copied());
    for (link, body) in of_arm.chain(of_hand) {
        for &own in world.bodies[body].colliders() {
            for pair in world.contact_pairs_with(own) {
                let other = if pair.collider1 == own { pair.collider2 } else { pair.collider1 };
                let points = pair.manifolds().iter().flat_map(|manifold| &manifold.points);
                let depth_m = -points.map(|point| point.dist).fold(f64::INFINITY, f64::min);
                let is_object = world.colliders[other].parent() == Some(trial.object);
                // An object that is pushed away need not overlap at the end of a step.
                let is_touched = depth_m > 0.0 || engine::normal_impulse(pair).norm() > 0.0;
                if !is_touched || (is_object && phase == ContactPhase::Hold) {
                    continue;
                }
                let depth_m = depth_m.max(0.0);
                let body = plan.name_of(other, is_object, trial);
                let known = contacts
                    .iter_mut()
                    .find(|contact| contact.link == link && contact.body == body && contact.phase == phase);
                if let Some(known) = known {
                    known.depth_m = known.depth_m.max(depth_m);
                    continue;
                }
                let time_s = f64::from(trial.steps() - began_steps) * plan.test.physics.step_s;
                let (link, body) = (link.to_owned(), body.to_owned());
                contacts.push(PlanContact { time_s, link, body, depth_m, phase });
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
