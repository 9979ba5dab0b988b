use cranny_collision::Body;
use cranny_grasp::{Hand, LoadMeasure, LoadState, Pads, ShakeTest};
use cranny_scenario::ObjectType;
use cranny_spatial::Pose;
use rapier3d_f64::prelude::{Collider, PhysicsWorld, RigidBodyHandle};

use crate::grasping::shake_test_check::check_shake_test;
use crate::gripper::HandModel;
use crate::object_model::{ObjectModel, come_to_rest};
use crate::{Disturbance, Physics, Piece, SimError, engine};

/// Common setup of the tests of grasps: a hand, an object and its surroundings.
///
/// A test has these phases:
/// 1. The object comes to rest without the hand; without a support, it floats until the hand has closed.
/// 2. The open hand starts at the grasp, unless it would penetrate anything by more than 1 mm, which ends the test. It closes
///    with at most its closing force, until the fingers are still.
/// 3. The hand follows its [`ShakeTest`] with the object, driven at the palm. Surroundings stop fingers and object, not the palm.
/// 4. The outcome depends on the object in the hand at the end.
#[derive(Clone, Debug)]
pub struct GraspTest {
    pub(crate) hand: HandModel,
    pub(crate) object: ObjectModel,
    bodies: Vec<Body>,
    /// Convex pieces of the bodies.
    pub(crate) surroundings: Vec<Piece>,
    surroundings_colliders: Vec<Collider>,
    world_from_object: Pose,
    pub(crate) physics: Physics,
    pub(crate) shake_test: ShakeTest,
    /// Load measure, in the frame of the object; `None` for a hand without two flat pads.
    pub(crate) load: Option<LoadMeasure>,
}

impl GraspTest {
    /// Creates a test of an object at a pose in the planning frame among `surroundings`; the object comes to rest.
    ///
    /// # Errors
    /// [`SimError::NoFingers`], [`SimError::NoStroke`] and [`SimError::ClosingForce`] for a hand that cannot close,
    /// [`SimError::Shape`] for a shape without volume, [`SimError::Figure`] for parameters out of range.
    pub fn new(
        hand: &Hand,
        object: &ObjectType,
        world_from_object: Pose,
        surroundings: &[Body],
        physics: Physics,
        shake_test: ShakeTest,
    ) -> Result<Self, SimError> {
        physics.check()?;
        check_shake_test(&shake_test)?;
        let (held, pads) = (object.held(), Pads::of(hand));
        let object = ObjectModel::new(object)?;
        let (mut around, mut colliders) = (Vec::new(), Vec::new());
        for (index, body) in surroundings.iter().enumerate() {
            let pieces = Piece::of_body(body)?;
            let first = colliders.len();
            colliders.extend(engine::colliders(&body.name, &pieces, 0.0, engine::SURROUNDINGS)?);
            for collider in &mut colliders[first..] {
                collider.user_data = index as u128;
            }
            around.extend(pieces);
        }
        let closing_force_n = hand.closing_force_n;
        let hand = HandModel::new(hand)?;
        let mut test = Self {
            hand,
            object,
            bodies: surroundings.to_vec(),
            surroundings: around,
            surroundings_colliders: colliders,
            world_from_object,
            physics,
            shake_test,
            load: None,
        };
        test.settle();
        let up = test.world_from_object.rotation.inverse() * test.physics.up;
        let states = LoadState::along(&test.shake_test);
        test.load =
            held.zip(pads).map(|(held, pads)| LoadMeasure::new(held, pads, closing_force_n, up, states));
        Ok(test)
    }

    /// Resting pose of the object, in the planning frame.
    pub fn world_from_object(&self) -> &Pose {
        &self.world_from_object
    }

    /// Surrounding bodies, in the planning frame.
    pub fn surroundings(&self) -> &[Body] {
        &self.bodies
    }

    /// Returns true if anything can support the object.
    pub(crate) fn is_carried(&self) -> bool {
        !self.surroundings.is_empty()
    }

    /// Creates a world with surroundings and object.
    pub(crate) fn world(&self, disturbance: &Disturbance) -> (PhysicsWorld, RigidBodyHandle) {
        let mut world = engine::world(&self.physics);
        for collider in &self.surroundings_colliders {
            world.insert_collider(collider.clone(), None);
        }
        let insert =
            if self.hand.pads.is_some() { ObjectModel::insert_for_pads } else { ObjectModel::insert };
        let object = insert(&self.object, &self.world_from_object, disturbance, &mut world);
        (world, object)
    }

    /// Lets the object come to rest if anything can support it.
    fn settle(&mut self) {
        if !self.is_carried() {
            return;
        }
        let (mut world, object) = self.world(&Disturbance::default());
        let body = &mut world.bodies[object];
        body.set_linear_damping(SETTLING_DAMPING);
        body.set_angular_damping(SETTLING_DAMPING);
        let rolling = self.object.rolling(self.physics.rolling_m, &Disturbance::default());
        (self.world_from_object, _) = come_to_rest(&mut world, (object, &rolling), STILL_S, SETTLING_S);
    }
}

/// Time within which a supported object comes to rest, in seconds.
const SETTLING_S: f64 = 2.0;

/// Damping while an object settles, in 1/s, as if in oil: an object placed slightly too high does not drift.
const SETTLING_DAMPING: f64 = 20.0;

/// Duration without motion after which the object is at rest, in seconds.
pub(crate) const STILL_S: f64 = 0.04;

/// Returns the number of steps of a time, rounded.
pub(crate) fn whole_steps(time_s: f64, step_s: f64) -> u32 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most 60 s of 1 µs")]
    let steps = (time_s / step_s).round() as u32;
    steps
}
