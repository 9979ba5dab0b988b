use cranny_collision::Body;
use cranny_grasp::Hand;
use cranny_scenario::ObjectType;
use cranny_spatial::nalgebra::Matrix3;
use cranny_spatial::{Point, Pose};
use rapier3d_f64::prelude::{Collider, MassProperties, PhysicsWorld, RigidBodyBuilder, RigidBodyHandle};
use rayon::prelude::*;

use crate::grasp_trial::GraspTrial;
use crate::gripper::HandModel;
use crate::{Course, Disturbance, GraspRun, Physics, Piece, SimError, engine};

/// A hand, an object and what stands around it: everything that the tests of its grasps have in common.
///
/// A test has these steps:
/// 1. The object comes to rest where it stands, without the hand; where nothing carries it, it floats until the hand has
///    closed.
/// 2. The open hand is at the grasp, and closes: with its closing force at most, until the fingers are still.
/// 3. It takes its [`Course`] with the object, palm first: what stands around stops fingers and object, not the palm.
/// 4. The outcome is what is then in the hand.
#[derive(Clone, Debug)]
pub struct GraspTest {
    pub(crate) hand: HandModel,
    pub(crate) object: ObjectModel,
    pub(crate) surroundings: Vec<Piece>,
    surroundings_colliders: Vec<Collider>,
    world_from_object: Pose,
    pub(crate) physics: Physics,
    pub(crate) course: Course,
}

#[derive(Clone, Debug)]
pub(crate) struct ObjectModel {
    pub name: String,
    pub pieces: Vec<Piece>,
    pub center: Point,
    pub mass_kg: f64,
    pub inertia_kg_m2: Matrix3<f64>,
    pub friction: f64,
    colliders: Vec<Collider>,
    mass_properties: MassProperties,
}

impl GraspTest {
    /// The object at a pose in the planning frame, whose z points up, among `surroundings`; the object comes to rest.
    ///
    /// # Errors
    /// [`SimError::NoFingers`], [`SimError::NoStroke`] and [`SimError::ClosingForce`] for a hand that cannot close,
    /// [`SimError::Shape`] for a shape without volume, [`SimError::Figure`] for constants out of their range.
    pub fn new(
        hand: &Hand,
        object: &ObjectType,
        world_from_object: Pose,
        surroundings: &[Body],
        physics: Physics,
        course: Course,
    ) -> Result<Self, SimError> {
        physics.check()?;
        course.check()?;
        let pieces = Piece::of_hulls(&Pose::identity(), object.parts.parts.iter().cloned());
        let object = ObjectModel {
            name: object.name.clone(),
            center: object.center_of_mass,
            mass_kg: object.mass_kg,
            inertia_kg_m2: object.inertia_kg_m2,
            friction: object.friction,
            colliders: engine::colliders(&object.name, &pieces, object.friction, engine::OBJECT)?,
            pieces,
            mass_properties: engine::mass_properties(object),
        };
        let (mut around, mut colliders) = (Vec::new(), Vec::new());
        for body in surroundings {
            let pieces = Piece::of_body(body)?;
            colliders.extend(engine::colliders(&body.name, &pieces, 0.0, engine::SURROUNDINGS)?);
            around.extend(pieces);
        }
        let hand = HandModel::new(hand)?;
        let mut test = Self {
            hand,
            object,
            surroundings: around,
            surroundings_colliders: colliders,
            world_from_object,
            physics,
            course,
        };
        test.settle();
        Ok(test)
    }

    /// Where the object rests, in the planning frame.
    pub fn world_from_object(&self) -> &Pose {
        &self.world_from_object
    }

    /// All of these grasps, each in a world of its own, on all cores; poses of the gripper in the planning frame.
    pub fn run_all(&self, grasps: &[Pose], disturbance: &Disturbance) -> Vec<GraspRun> {
        grasps.par_iter().map(|grasp| self.run(grasp, disturbance, false)).collect()
    }

    /// One grasp; the pose of the gripper in the planning frame.
    pub fn run(&self, world_from_grasp: &Pose, disturbance: &Disturbance, is_recorded: bool) -> GraspRun {
        let world_from_hand = world_from_grasp * disturbance.grasp_from_hand;
        GraspTrial::new(self, &world_from_hand, disturbance, is_recorded).run(&world_from_hand)
    }

    /// Whether anything can carry the object.
    pub(crate) fn is_carried(&self) -> bool {
        !self.surroundings.is_empty()
    }

    /// A world with surroundings and object.
    pub(crate) fn world(&self, disturbance: &Disturbance) -> (PhysicsWorld, RigidBodyHandle) {
        let mut world = engine::world(&self.physics);
        for collider in &self.surroundings_colliders {
            world.insert_collider(collider.clone(), None);
        }
        let mut mass_properties = self.object.mass_properties;
        mass_properties.set_mass(mass_properties.mass() * disturbance.mass, true);
        let body = RigidBodyBuilder::dynamic()
            .pose(engine::pose(&self.world_from_object))
            .can_sleep(false)
            .additional_mass_properties(mass_properties);
        let object = world.insert_body(body);
        for collider in &self.object.colliders {
            let mut collider = collider.clone();
            collider.set_friction(collider.friction() * disturbance.friction);
            world.insert_collider(collider, Some(object));
        }
        (world, object)
    }

    /// Lets the object come to rest, if anything can carry it.
    fn settle(&mut self) {
        if !self.is_carried() {
            return;
        }
        let (mut world, object) = self.world(&Disturbance::default());
        let mut still_s = 0.0;
        for _ in 0..whole_steps(SETTLING_S, self.physics.step_s) {
            world.step();
            let body = &world.bodies[object];
            let is_still = body.linvel().length() < STILL_M_PER_S && body.angvel().length() < STILL_RAD_PER_S;
            still_s = if is_still { still_s + self.physics.step_s } else { 0.0 };
            if still_s > STILL_S {
                break;
            }
        }
        self.world_from_object = engine::to_pose(world.bodies[object].position());
    }
}

/// An object that lies is still within this time, in seconds.
const SETTLING_S: f64 = 2.0;

/// What is slower for [`STILL_S`] is at rest: where it would be in a tenth of a second is not to be told from where it is.
pub(crate) const STILL_M_PER_S: f64 = 1e-3;
const STILL_RAD_PER_S: f64 = 1e-2;
pub(crate) const STILL_S: f64 = 0.04;

/// Steps of a time, rounded.
pub(crate) fn whole_steps(time_s: f64, step_s: f64) -> u32 {
    // At most 60 s of 1 µs.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let steps = (time_s / step_s).round() as u32;
    steps
}
