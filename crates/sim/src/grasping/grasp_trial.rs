use cranny_grasp::ShakeTest;
use cranny_spatial::{FARTHEST_M, Point, Pose, Vector};
use rapier3d_f64::prelude::{Collider, PhysicsWorld, RigidBodyHandle};
use rayon::prelude::*;

use crate::compliant_pads::CompliantPads;
use crate::grasping::grasp_test::{STILL_S, whole_steps};
use crate::gripper::Gripper;
use crate::object_model::STILL_M_PER_S;
use crate::rolling::Rolling;
use crate::{Disturbance, GraspOutcome, GraspRun, GraspTest, Piece, RecordedBody, Recording, engine};

/// Additional time of the fingers beyond that of their stroke, in seconds: for pushing a heavy object.
pub(crate) const CLOSING_GRACE_S: f64 = 0.5;

/// Share of the stroke before its end from which a hand counts as closed on nothing.
pub(crate) const CLOSED_SHARE: f64 = 1e-3;

/// Displacement in the hand from which an object cannot return, in metres: fingers hold only what they touch.
pub(crate) const LOST_M: f64 = 0.15;

/// Penetration depth above which an open hand, in the object or with a finger in the surroundings, does not begin a grasp, in
/// metres. Each engine would resolve the overlap differently.
pub(crate) const BLOCKED_M: f64 = 0.001;

/// Interval of a recording, in seconds.
const RECORDED_EVERY_S: f64 = 0.02;

/// Motion of a hand with its duration, in seconds. `advance` is called before each step, with the time at the end of the step.
pub(crate) struct Move<'f, 'a> {
    pub duration_s: f64,
    pub advance: &'f mut dyn FnMut(&mut GraspTrial<'a>, f64),
}

/// Simulation of one grasp.
pub(crate) struct GraspTrial<'a> {
    pub test: &'a GraspTest,
    pub world: PhysicsWorld,
    pub gripper: Gripper<'a>,
    pub object: RigidBodyHandle,
    rolling: Rolling,
    pads: Option<CompliantPads<'a>>,
    steps: u32,
    /// Number of these steps before the hand began to close.
    steps_open: u32,
    /// Step at which the hand begins to open again, and closing of its fingers at that step, in metres.
    opens_from: Option<(u32, f64)>,
    /// Pose of the object at that step, in the planning frame.
    world_from_released: Option<Pose>,
    recording: Option<Recording>,
    /// Recorded bodies besides object and hand.
    recorded: Vec<RigidBodyHandle>,
}

impl<'a> GraspTrial<'a> {
    /// Creates a trial with the open hand at a grasp.
    pub fn new(
        test: &'a GraspTest,
        world_from_hand: &Pose,
        disturbance: &Disturbance,
        is_recorded: bool,
    ) -> Self {
        let (mut world, object) = test.world(disturbance);
        let force_n = test.hand.closing_force_n * disturbance.closing_force;
        let gripper = Gripper::insert(&test.hand, &test.physics, force_n, world_from_hand, &mut world);
        let rolling = test.object.rolling(test.physics.rolling_m, disturbance);
        Self::with(test, world, gripper, (object, rolling), is_recorded.then(Vec::new))
    }

    /// Creates a trial of a hand and an object in a world. `recorded`: further moving bodies, if the trial is recorded.
    pub fn with(
        test: &'a GraspTest,
        world: PhysicsWorld,
        gripper: Gripper<'a>,
        (object, rolling): (RigidBodyHandle, Rolling),
        recorded: Option<Vec<(RecordedBody, RigidBodyHandle)>>,
    ) -> Self {
        let object_model = &test.object;
        let pads = test.hand.pads.as_ref().map(|pads| {
            let friction =
                world.bodies[object].colliders().first().map_or(0.0, |own| world.colliders[*own].friction());
            let inertial = (rolling.mass_kg, rolling.inertia_kg_m2, rolling.center);
            CompliantPads::new(pads, (&object_model.surface, friction), inertial)
        });
        let mut trial = Self {
            test,
            world,
            gripper,
            object,
            rolling,
            pads,
            steps: 0,
            steps_open: 0,
            opens_from: None,
            world_from_released: None,
            recording: None,
            recorded: Vec::new(),
        };
        if let Some(others) = recorded {
            let part = |name: &str, pieces: &[Piece]| RecordedBody::new(name, Piece::surface_of(pieces));
            let shown = RecordedBody::new(&test.object.name, test.object.shown.clone());
            let mut bodies = vec![shown, part("palm", &test.hand.palm)];
            for (index, finger) in test.hand.fingers.iter().enumerate() {
                bodies.push(part(&format!("finger {}", index + 1), &finger.pieces));
            }
            trial.recorded = vec![object, trial.gripper.palm];
            trial.recorded.extend(&trial.gripper.fingers);
            for (other, handle) in others {
                bodies.push(other);
                trial.recorded.push(handle);
            }
            trial.recording = Some(Recording { times_s: Vec::new(), bodies });
            trial.record();
        }
        trial
    }

    /// Closes the hand and, if it holds the object, follows the motion of the shake test.
    pub fn run(self, world_from_hand: &Pose) -> GraspRun {
        if world_from_hand.translation.vector.amax() > FARTHEST_M {
            // Such a grasp is beyond any scene and beyond the number range of the engine.
            return self.ended(GraspOutcome::NeverClosed, (0.0, 0.0), 0.0, 0.0);
        }
        if let Some(outcome) = self.blocked() {
            return self.ended(outcome, (0.0, 0.0), 0.0, 0.0);
        }
        let (shake_test, up) = (self.test.shake_test, self.test.physics.up);
        let mut advance = |trial: &mut Self, time_s: f64| {
            let next = shake_test.world_from_hand(world_from_hand, &up, time_s);
            trial.world.bodies[trial.gripper.palm].set_next_kinematic_position(engine::pose(&next));
        };
        self.grasp(Move { duration_s: shake_test.duration_s(), advance: &mut advance }, None)
    }

    /// Returns the outcome if the open hand penetrates anything: it has pushed the object away on approach or cannot close.
    fn blocked(&self) -> Option<GraspOutcome> {
        let world = &self.world;
        let of_body = |body: RigidBodyHandle| {
            let own = world.bodies[body].colliders().iter().map(|&collider| &world.colliders[collider]);
            own.filter(|own| own.collision_groups() != engine::BACK)
        };
        let around =
            || world.colliders.iter().map(|(_, other)| other).filter(|other| other.parent().is_none());
        let is_in = |own: &Collider, other: &Collider| engine::depth_m(own, other) > BLOCKED_M;
        let fingers = || self.gripper.fingers.iter().copied().flat_map(of_body);
        let mut hand = of_body(self.gripper.palm).chain(fingers());
        // Of an object with a shell, its parts do not meet the hand.
        let object = || of_body(self.object).filter(|part| part.collision_groups() != engine::PARTS);
        // A shell is a surface, on which a hand deep in the object does not stand.
        let is_deep = |own: &Collider| {
            let middle = Point::from(engine::to_vector(own.compute_aabb().center()));
            let middle = self.world_from_object().inverse_transform_point(&middle);
            self.test.object.shell.as_ref().is_some_and(|shell| shell.contains(&middle))
        };
        if hand.any(|own| is_deep(own) || object().any(|other| is_in(own, other))) {
            return Some(GraspOutcome::KnockedAway);
        }
        fingers().any(|own| around().any(|other| is_in(own, other))).then_some(GraspOutcome::NeverClosed)
    }

    /// Closes the hand. If it then holds the object, follows `held`, and after that `released`, unless the object was dropped.
    pub fn grasp(mut self, held: Move<'_, 'a>, released: Option<Move<'_, 'a>>) -> GraspRun {
        let gravity = self.world.gravity;
        if !self.test.is_carried() {
            self.world.gravity = engine::vector(&Vector::zeros());
        }
        self.steps_open = self.steps;
        let world_from_resting = self.world_from_object();
        let pressed_n = self.close();
        self.world.gravity = gravity;
        if let Some(contact_force_n) = pressed_n {
            return self.carry(held, released, contact_force_n);
        }
        let error = self.error(&world_from_resting, &self.world_from_object());
        let is_there = self.is_held(error);
        let outcome = if is_there { GraspOutcome::NeverClosed } else { GraspOutcome::KnockedAway };
        self.ended(outcome, error, 0.0, 0.0)
    }

    pub fn steps(&self) -> u32 {
        self.steps
    }

    fn time_s(&self) -> f64 {
        f64::from(self.steps) * self.test.physics.step_s
    }

    /// Time since the hand began to close, in seconds.
    fn closing_s(&self) -> f64 {
        f64::from(self.steps - self.steps_open) * self.test.physics.step_s
    }

    pub fn world_from_object(&self) -> Pose {
        engine::to_pose(self.world.bodies[self.object].position())
    }

    fn hand_from_object(&self) -> Pose {
        engine::to_pose(self.world.bodies[self.gripper.palm].position()).inverse() * self.world_from_object()
    }

    /// Advances by one step with the hand open.
    pub fn step_open(&mut self) {
        self.steps_open = self.steps;
        self.step();
        self.steps_open = self.steps;
    }

    fn step(&mut self) {
        let speed = self.test.shake_test.closing_speed;
        let driven_m = match self.opens_from {
            None => speed * self.closing_s(),
            Some((step, closed_m)) => {
                (closed_m - speed * f64::from(self.steps - step) * self.test.physics.step_s).max(0.0)
            }
        };
        self.gripper.drive(&mut self.world, driven_m);
        self.world.bodies[self.object].reset_forces(true);
        self.rolling.resist(&mut self.world, self.object);
        if let Some(pads) = &mut self.pads {
            pads.press(&mut self.world, &self.gripper, self.object);
            engine::step(&mut self.world, false);
        } else {
            let are_faces = self.gripper.bears_on_faces(&self.world, self.object);
            engine::step(&mut self.world, are_faces);
        }
        self.steps += 1;
        self.record();
    }

    /// Closes the hand. Returns the mean force of the fingers at rest, in newtons; `None` if not all of them touch the object.
    fn close(&mut self) -> Option<f64> {
        let test = self.test;
        let stroke_m = test.hand.fingers.iter().map(|finger| finger.stroke_m).fold(0.0, f64::max);
        let lead_s =
            self.gripper.closing_force_n / test.physics.drive_stiffness / test.shake_test.closing_speed;
        let limit_s = stroke_m / test.shake_test.closing_speed + lead_s + CLOSING_GRACE_S;
        let [lead_steps, full_steps] =
            [lead_s, STILL_S].map(|time_s| whole_steps(time_s, test.physics.step_s).max(1));
        let (mut still_share, mut still_steps, mut pressed_n) = (0.0, 0_u32, 0.0);
        for _ in 0..whole_steps(limit_s, test.physics.step_s) {
            self.step();
            let (share, _) = self.gripper.closed(&self.world);
            let pressures = self.pressures();
            // Pads yield, so that a hand on a thin sheet may reach the end of its stroke.
            if share > 1.0 - CLOSED_SHARE && pressures.iter().all(Option::is_none) {
                return None;
            }
            // The drive has full force and the fingers rest. A contact that changes its corners from step to step makes them
            // vibrate: faster than the limit of rest, but within a few micrometres.
            let has_moved = ((share - still_share) * stroke_m).abs() > STILL_M_PER_S * STILL_S;
            let pressure_n: Option<f64> = pressures.iter().copied().sum();
            let Some(sum_n) = pressure_n.filter(|_| !has_moved && self.closing_s() > lead_s) else {
                (still_share, still_steps, pressed_n) = (share, 0, 0.0);
                continue;
            };
            still_steps += 1;
            // The drive does not have its full force while its lead grows.
            if still_steps > lead_steps {
                pressed_n += sum_n / pressures.len() as f64;
            }
            if still_steps == lead_steps + full_steps {
                return Some(pressed_n / f64::from(full_steps));
            }
        }
        None
    }

    /// Moves the hand with the held object, then releases it if `released` is given.
    fn carry(
        mut self,
        Move { duration_s, advance }: Move<'_, 'a>,
        released: Option<Move<'_, 'a>>,
        contact_force_n: f64,
    ) -> GraspRun {
        let closed_from_object = self.hand_from_object();
        let mut held_s = None;
        for step in 1..=whole_steps(duration_s, self.test.physics.step_s) {
            let time_s = f64::from(step) * self.test.physics.step_s;
            advance(&mut self, time_s);
            self.step();
            let error = self.error(&closed_from_object, &self.hand_from_object());
            if held_s.is_none() && !self.is_held(error) {
                held_s = Some(time_s);
            }
            if error.0 > LOST_M {
                return self.ended(GraspOutcome::Dropped, error, held_s.unwrap_or(time_s), contact_force_n);
            }
        }
        let error = self.error(&closed_from_object, &self.hand_from_object());
        let outcome = if !self.is_touched() {
            GraspOutcome::Dropped
        } else if self.is_held(error) {
            GraspOutcome::Held
        } else {
            GraspOutcome::Slipped
        };
        let held_s = held_s.unwrap_or(duration_s);
        if let Some(released) = released.filter(|_| outcome != GraspOutcome::Dropped) {
            self.release(released);
        }
        self.ended(outcome, error, held_s, contact_force_n)
    }

    fn is_touched(&self) -> bool {
        self.pressures().iter().any(Option::is_some)
    }

    /// Force of each finger on the object in the last step, in newtons; `None` if it does not touch it.
    fn pressures(&self) -> Vec<Option<f64>> {
        let mut pressures = self.gripper.pressures(&self.world, self.object);
        for (pressure, force) in pressures.iter_mut().zip(self.pads.iter().flat_map(|pads| pads.forces)) {
            if force.norm() > 0.0 {
                *pressure = Some(pressure.unwrap_or(0.0) + force.norm());
            }
        }
        pressures
    }

    /// Opens the hand and moves it on meanwhile.
    fn release(&mut self, Move { duration_s, advance }: Move<'_, 'a>) {
        let stroke_m = self.test.hand.fingers.iter().map(|finger| finger.stroke_m).fold(0.0, f64::max);
        self.world_from_released = Some(self.world_from_object());
        self.opens_from = Some((self.steps, self.gripper.closed(&self.world).0 * stroke_m));
        for step in 1..=whole_steps(duration_s, self.test.physics.step_s) {
            advance(self, f64::from(step) * self.test.physics.step_s);
            self.step();
        }
    }

    /// Returns the displacement of the centre of mass, in metres, and the visible rotation, in radians, between two poses.
    fn error(&self, expected: &Pose, actual: &Pose) -> (f64, f64) {
        let (center, roundness) = (self.test.object.center, self.test.object.roundness);
        let rotation_rad = roundness.angle(&expected.rotation, &actual.rotation);
        ((actual * center - expected * center).norm(), rotation_rad)
    }

    fn is_held(&self, (translation_m, rotation_rad): (f64, f64)) -> bool {
        let ShakeTest { slip_m, slip_rad, .. } = self.test.shake_test;
        translation_m <= slip_m && rotation_rad <= slip_rad
    }

    fn record(&mut self) {
        let every = whole_steps(RECORDED_EVERY_S, self.test.physics.step_s).max(1);
        let time_s = self.time_s();
        let Some(recording) = self.recording.as_mut().filter(|_| self.steps.is_multiple_of(every)) else {
            return;
        };
        recording.times_s.push(time_s);
        for (body, handle) in recording.bodies.iter_mut().zip(&self.recorded) {
            body.world_from_body.push(engine::to_pose(self.world.bodies[*handle].position()));
        }
    }

    fn ended(self, outcome: GraspOutcome, error: (f64, f64), held_s: f64, contact_force_n: f64) -> GraspRun {
        GraspRun {
            outcome,
            translation_error_m: error.0,
            rotation_error_rad: error.1,
            held_s,
            contact_force_n,
            world_from_object: self.world_from_object(),
            is_in_hand: self.is_touched(),
            world_from_released: self.world_from_released,
            simulated_s: self.time_s(),
            recording: self.recording,
        }
    }
}

impl GraspTest {
    /// Runs these grasps with their disturbances, each in its own world, on all cores; poses of the gripper in the planning
    /// frame. `on_done` is called after each; once `stop` returns true, no further run begins, and the rest are `None`.
    pub fn run_all(
        &self,
        trials: &[(Pose, Disturbance)],
        on_done: &(dyn Fn() + Sync),
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Vec<Option<GraspRun>> {
        let run = |(grasp, disturbance): &(Pose, Disturbance)| {
            if stop() {
                return None;
            }
            let run = self.run(grasp, disturbance, false);
            on_done();
            Some(run)
        };
        trials.par_iter().map(run).collect()
    }

    /// Runs one grasp, with the pose of the gripper in the planning frame.
    pub fn run(&self, world_from_grasp: &Pose, disturbance: &Disturbance, is_recorded: bool) -> GraspRun {
        let world_from_hand = world_from_grasp * disturbance.grasp_from_hand;
        GraspTrial::new(self, &world_from_hand, disturbance, is_recorded).run(&world_from_hand)
    }
}
