use cranny_grasp::{Hand, Pads};
use cranny_spatial::{Point, Pose, Vector};
use rapier3d_f64::math::Matrix;
use rapier3d_f64::prelude::{
    Collider, ColliderHandle, ContactManifold, ContactPair, MassProperties, PhysicsWorld, PrismaticJoint,
    PrismaticJointBuilder, RigidBodyBuilder, RigidBodyHandle,
};

use crate::spring_tip::DEEPEST_M;
use crate::{Physics, Piece, PieceShape, SimError, engine};

/// Hand in the form of the engine: a palm with prescribed motion, and fingers that slide on it.
#[derive(Clone, Debug)]
pub(crate) struct HandModel {
    /// Convex pieces of the palm, in the gripper frame.
    pub palm: Vec<Piece>,
    pub fingers: Vec<FingerModel>,
    pub closing_force_n: f64,
    /// Pads that yield; `None` for a hand without two flat pads.
    pub pads: Option<Pads>,
    palm_colliders: Vec<Collider>,
}

/// Finger, in the gripper frame while the hand is open.
#[derive(Clone, Debug)]
pub(crate) struct FingerModel {
    pub pieces: Vec<Piece>,
    /// Pieces behind the springs of a pad, which meet the object instead; none for a rigid finger.
    pub behind_springs: Vec<Piece>,
    /// Closing direction, a unit vector.
    pub axis: Vector,
    pub stroke_m: f64,
    /// Mean of the centres of its pieces.
    pub center: Point,
    colliders: Vec<Collider>,
}

impl HandModel {
    pub fn new(hand: &Hand) -> Result<Self, SimError> {
        Self::with_pads(hand, Pads::of(hand))
    }

    /// Creates the model of a hand with these pads; `None`: with rigid fingers.
    pub fn with_pads(hand: &Hand, pads: Option<Pads>) -> Result<Self, SimError> {
        let name = || hand.name.clone();
        if hand.fingers.is_empty() {
            return Err(SimError::NoFingers { hand: name() });
        }
        let force_n = hand.closing_force_n;
        if !(force_n.is_finite() && force_n > 0.0) {
            return Err(SimError::ClosingForce { hand: name(), force_n });
        }
        let pieces_of = |parts: &mut dyn Iterator<Item = usize>| -> Result<Vec<Piece>, SimError> {
            let mut pieces = Vec::new();
            for part in parts {
                let (pose, solid) = &hand.parts[part];
                pieces.extend(Piece::of_solid(&hand.name, pose, solid)?);
            }
            Ok(pieces)
        };
        // The greater of two friction coefficients in contact applies, which is that of the object.
        let colliders = |pieces: &[Piece]| engine::colliders(&hand.name, pieces, 0.0, engine::HAND);
        let is_of_finger = |part: &usize| hand.fingers.iter().any(|finger| finger.parts.contains(part));
        let palm = pieces_of(&mut (0..hand.parts.len()).filter(|part| !is_of_finger(part)))?;
        let mut fingers = Vec::new();
        for (index, finger) in hand.fingers.iter().enumerate() {
            let stroke_m = finger.stroke_m.norm();
            let pieces = pieces_of(&mut finger.parts.clone())?;
            if pieces.is_empty() || stroke_m < LEAST_STROKE_M {
                return Err(SimError::NoStroke { hand: name(), finger: index + 1 });
            }
            let sum: Vector = hand.parts[finger.parts.clone()]
                .iter()
                .map(|(pose, solid)| (pose * solid.ball().center).coords)
                .sum();
            fingers.push(FingerModel {
                axis: finger.stroke_m / stroke_m,
                stroke_m,
                center: Point::from(sum / finger.parts.len() as f64),
                colliders: colliders(&pieces)?,
                pieces,
                behind_springs: Vec::new(),
            });
        }
        for (finger, face_m) in fingers.iter_mut().zip(pads.iter().flat_map(|pads| pads.faces_m)) {
            finger.behind_springs = finger.behind(face_m, DEEPEST_M);
        }
        if let Some(pads) = pads.filter(|_| hand.pads.is_some()) {
            for (finger, face_m) in fingers.iter_mut().zip(pads.faces_m) {
                // The finger behind a pad, in particular an edge of an inclined finger, does not bear load.
                finger.pieces = finger.behind(face_m, BEHIND_M);
                finger.pieces.push(pad(&pads, face_m));
            }
        }
        for finger in fingers.iter_mut().filter(|_| pads.is_some()) {
            // The springs of the pads meet the object, and the fingers only what is behind these.
            let around = engine::colliders(&hand.name, &finger.pieces, 0.0, engine::FRONT)?;
            let back = engine::colliders(&hand.name, &finger.behind_springs, 0.0, engine::BACK)?;
            finger.colliders = [around, back].concat();
        }
        Ok(Self { palm_colliders: colliders(&palm)?, palm, fingers, closing_force_n: force_n, pads })
    }
}

/// Returns a flat pad whose face is at `face_m` along y, in metres.
fn pad(pads: &Pads, face_m: f64) -> Piece {
    let [x, z] = pads.middle_m;
    let y = face_m + face_m.signum() * HALF_PAD_M;
    let half = [pads.half_m[0], HALF_PAD_M, pads.half_m[1]];
    Piece { body_from_piece: Pose::translation(x, y, z), shape: PieceShape::Cuboid(half) }
}

/// Half the thickness of a pad, in metres.
const HALF_PAD_M: f64 = 5e-4;
/// Distance of a finger behind the face of its pad for the surroundings, in metres; for the object it is [`DEEPEST_M`].
const BEHIND_M: f64 = 3e-4;

impl FingerModel {
    /// Pieces with their fronts moved to `depth_m` behind a face at `face_m` along y, by at most that; both in metres.
    fn behind(&self, face_m: f64, depth_m: f64) -> Vec<Piece> {
        let outward = Vector::y() * face_m.signum();
        self.pieces.iter().map(|piece| piece.thinned(&outward, face_m.abs() + depth_m, depth_m)).collect()
    }

    fn joint(&self) -> PrismaticJoint {
        let center = engine::vector(&self.center.coords);
        PrismaticJointBuilder::new(engine::vector(&self.axis))
            .local_anchor1(center)
            .local_anchor2(center)
            .limits([0.0, self.stroke_m])
            .contacts_enabled(false)
            .build()
    }
}

/// Minimum stroke of a finger, in metres.
const LEAST_STROKE_M: f64 = 1e-4;

/// Hand in a world of the engine.
pub(crate) struct Gripper<'a> {
    model: &'a HandModel,
    physics: &'a Physics,
    pub closing_force_n: f64,
    pub palm: RigidBodyHandle,
    pub fingers: Vec<RigidBodyHandle>,
}

impl<'a> Gripper<'a> {
    /// Inserts a hand whose palm has a prescribed motion.
    pub fn insert(
        model: &'a HandModel,
        physics: &'a Physics,
        closing_force_n: f64,
        world_from_hand: &Pose,
        world: &mut PhysicsWorld,
    ) -> Self {
        let palm = RigidBodyBuilder::kinematic_position_based();
        let palm = world.insert_body(palm.pose(engine::pose(world_from_hand)).can_sleep(false));
        for collider in &model.palm_colliders {
            world.insert_collider(collider.clone(), Some(palm));
        }
        let mut hand = Self { model, physics, closing_force_n, palm, fingers: Vec::new() };
        for finger in &model.fingers {
            // The finger has the inertia of the drive alone; the joint prevents rotation, so any rotational inertia is valid.
            let body = hand.insert_finger(finger, world_from_hand, world);
            world.insert_impulse_joint(hand.palm, body, finger.joint());
        }
        hand
    }

    fn insert_finger(
        &mut self,
        finger: &FingerModel,
        world_from_hand: &Pose,
        world: &mut PhysicsWorld,
    ) -> RigidBodyHandle {
        let mass_kg = self.physics.finger_inertia_kg;
        let center = engine::vector(&finger.center.coords);
        let inertia =
            Matrix::from_diagonal(rapier3d_f64::math::Vector::splat(mass_kg * FINGER_RADIUS_M.powi(2)));
        let body = RigidBodyBuilder::dynamic()
            .pose(engine::pose(world_from_hand))
            .can_sleep(false)
            .gravity_scale(0.0)
            .additional_mass_properties(MassProperties::with_inertia_matrix(center, mass_kg, inertia));
        let body = world.insert_body(body);
        for collider in &finger.colliders {
            world.insert_collider(collider.clone(), Some(body));
        }
        self.fingers.push(body);
        body
    }

    /// Returns the closing of each finger and its rate (1/s), as shares of its stroke.
    fn shares(&self, world: &PhysicsWorld) -> Vec<(f64, f64)> {
        let palm = &world.bodies[self.palm];
        let share = |(model, finger): (&FingerModel, &RigidBodyHandle)| {
            let body = &world.bodies[*finger];
            let at_center = body.position().transform_point(engine::vector(&model.center.coords));
            let axis = palm.position().rotation * engine::vector(&model.axis);
            let moved = at_center - palm.position().transform_point(engine::vector(&model.center.coords));
            let velocity = body.velocity_at_point(at_center) - palm.velocity_at_point(at_center);
            (moved.dot(axis) / model.stroke_m, velocity.dot(axis) / model.stroke_m)
        };
        self.model.fingers.iter().zip(&self.fingers).map(share).collect()
    }

    /// Returns the closing of the hand, from 0 to 1, and its rate (1/s).
    pub fn closed(&self, world: &PhysicsWorld) -> (f64, f64) {
        let shares = self.shares(world);
        let count = shares.len() as f64;
        let sum = shares.iter().fold((0.0, 0.0), |sum, share| (sum.0 + share.0, sum.1 + share.1));
        (sum.0 / count, sum.1 / count)
    }

    /// Direction of the stroke of a finger, in the gripper frame.
    pub fn axis(&self, finger: usize) -> Vector {
        self.model.fingers[finger].axis
    }

    /// Returns the closing of each finger, in metres; one per finger.
    pub fn closed_m(&self, world: &PhysicsWorld) -> Vec<f64> {
        let strokes = self.model.fingers.iter().map(|finger| finger.stroke_m);
        self.shares(world).into_iter().zip(strokes).map(|((share, _), stroke_m)| share * stroke_m).collect()
    }

    /// Returns the rate of each finger on its stroke (m/s), the force on it along the stroke (N), and its inertia (kg).
    pub fn fingers_along(&self, world: &PhysicsWorld) -> Vec<(f64, f64, f64)> {
        let palm = world.bodies[self.palm].position().rotation;
        let finger = |((model, body), (_, rate)): ((&FingerModel, &RigidBodyHandle), (f64, f64))| {
            let force_n = world.bodies[*body].user_force().dot(palm * engine::vector(&model.axis));
            (rate * model.stroke_m, force_n, self.physics.finger_inertia_kg)
        };
        self.model.fingers.iter().zip(&self.fingers).zip(self.shares(world)).map(finger).collect()
    }

    /// Returns the prescribed motion of the palm in the next step of `dt` seconds.
    pub fn palm_motion(&self, world: &PhysicsWorld, dt: f64) -> PalmMotion {
        let palm = &world.bodies[self.palm];
        let [from, to] = [palm.position(), palm.next_position()].map(engine::to_pose);
        PalmMotion {
            linear: (to.translation.vector - from.translation.vector) / dt,
            angular: (to.rotation * from.rotation.inverse()).scaled_axis() / dt,
            at: from.translation.vector,
        }
    }

    /// Sets the drive forces of the next step. All fingers follow a target that moves from open to closed, `driven_m` metres
    /// from open, with at most the closing force, and follow each other.
    pub fn drive(&self, world: &mut PhysicsWorld, driven_m: f64) {
        let shares = self.shares(world);
        let (share, rate) = self.closed(world);
        let Physics { drive_stiffness, drive_damping, .. } = *self.physics;
        for ((model, finger), (own_share, own_rate)) in
            self.model.fingers.iter().zip(&self.fingers).zip(shares)
        {
            // The target moves beyond the end of the stroke until the force is complete.
            let lead_m = driven_m.min(model.stroke_m + self.closing_force_n / drive_stiffness)
                - share * model.stroke_m;
            let drive_n = (drive_stiffness * lead_m - drive_damping * rate * model.stroke_m)
                .clamp(-self.closing_force_n, self.closing_force_n);
            let coupling_n =
                model.stroke_m * (drive_stiffness * (share - own_share) + drive_damping * (rate - own_rate));
            let force = world.bodies[self.palm].position().rotation
                * engine::vector(&model.axis)
                * (drive_n + coupling_n);
            let body = &mut world.bodies[*finger];
            body.reset_forces(true);
            body.add_force(force, true);
        }
    }

    /// Returns true if each finger bore on another rigid body with a face in the last step: three corners of a contact overlap.
    pub fn bears_on_faces(&self, world: &PhysicsWorld, other: RigidBodyHandle) -> bool {
        let is_face = |manifold: &ContactManifold| {
            manifold.points.iter().filter(|point| point.dist <= 0.0).count() >= FACE_CORNERS
        };
        self.fingers.iter().all(|&finger| {
            contacts(world, finger, other).any(|(pair, _)| pair.manifolds().iter().any(is_face))
        })
    }

    /// Returns the force of each finger on another rigid body in the last step, in newtons; `None` if it does not touch it.
    pub fn pressures(&self, world: &PhysicsWorld, other: RigidBodyHandle) -> Vec<Option<f64>> {
        let pressure = |&finger: &RigidBodyHandle| {
            contacts(world, finger, other)
                .filter(|(pair, _)| pair.has_any_active_contact())
                .map(|(pair, side)| engine::normal_impulse(pair) * side)
                .reduce(|a, b| a + b)
                .map(|impulse| impulse.norm() / self.physics.step_s)
        };
        self.fingers.iter().map(pressure).collect()
    }
}

/// Velocity of a palm: of its origin (m/s), and of its rotation (rad/s).
pub(crate) struct PalmMotion {
    pub linear: Vector,
    pub angular: Vector,
    /// Position of the origin, in metres.
    pub at: Vector,
}

impl PalmMotion {
    /// Velocity of a point that moves with the palm, in m/s.
    pub fn at_point(&self, point: &Vector) -> Vector {
        self.linear + self.angular.cross(&(point - self.at))
    }
}

/// Returns the contacts of a finger with another rigid body, with 1 if the finger is the first of the pair, otherwise −1.
fn contacts(
    world: &PhysicsWorld,
    finger: RigidBodyHandle,
    other: RigidBodyHandle,
) -> impl Iterator<Item = (&ContactPair, f64)> {
    let is_of = move |collider: ColliderHandle| world.colliders[collider].parent() == Some(finger);
    let pairs = world.bodies[other].colliders().iter().flat_map(|&own| world.contact_pairs_with(own));
    pairs.filter_map(move |pair| match (is_of(pair.collider1), is_of(pair.collider2)) {
        (false, false) => None,
        (true, _) => Some((pair, 1.0)),
        (false, true) => Some((pair, -1.0)),
    })
}

/// Minimum number of overlapping corners of a face.
const FACE_CORNERS: usize = 3;

/// Radius of gyration of a finger, in metres: about its size.
pub(crate) const FINGER_RADIUS_M: f64 = 0.02;
