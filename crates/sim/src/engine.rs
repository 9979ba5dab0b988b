//! Conversions between `rapier`'s types and those of this project; worlds and colliders.

mod polyhedron;

use std::f64::consts::FRAC_PI_2;

use cranny_shape::{ShapeError, TriangleSoup};
use cranny_spatial::nalgebra::{Matrix3, Quaternion, UnitQuaternion};
use cranny_spatial::{Point, Pose, Vector};
use rapier3d_f64::math::{Matrix, Pose as RapierPose, Rotation as RapierRotation, Vector as RapierVector};
use rapier3d_f64::parry::bounding_volume::BoundingVolume;
use rapier3d_f64::parry::query;
use rapier3d_f64::prelude::{
    ActiveHooks, CoefficientCombineRule, Collider, ColliderBuilder, ContactPair, FrictionModel, Group,
    InteractionGroups, InteractionTestMode, MassProperties, PhysicsWorld, SharedShape, SolverContactGeneric,
    SpringCoefficients, TriMeshFlags,
};

use crate::bounding_ball::{BoundingBall, PREDICTION_M};
use crate::contact_patch::ContactPatch;
use crate::{Physics, Piece, PieceShape, SimError};

/// Collision groups: hand, object and surroundings each do not collide with themselves. The front of
/// a finger with a pad meets the surroundings, and its back, behind the springs of the pad, the object.
pub(crate) const HAND: InteractionGroups =
    InteractionGroups::new(Group::GROUP_1, Group::GROUP_2.union(Group::GROUP_3), InteractionTestMode::And);
pub(crate) const FRONT: InteractionGroups =
    InteractionGroups::new(Group::GROUP_1, Group::GROUP_3, InteractionTestMode::And);
pub(crate) const BACK: InteractionGroups =
    InteractionGroups::new(Group::GROUP_1, Group::GROUP_2, InteractionTestMode::And);
pub(crate) const OBJECT: InteractionGroups =
    InteractionGroups::new(Group::GROUP_2, Group::ALL, InteractionTestMode::And);
/// An object with a shell: its convex parts meet the surroundings, and its shell the hand.
pub(crate) const PARTS: InteractionGroups =
    InteractionGroups::new(Group::GROUP_2, Group::GROUP_3, InteractionTestMode::And);
pub(crate) const SHELL: InteractionGroups =
    InteractionGroups::new(Group::GROUP_2, Group::GROUP_1, InteractionTestMode::And);
pub(crate) const SURROUNDINGS: InteractionGroups =
    InteractionGroups::new(Group::GROUP_3, Group::ALL, InteractionTestMode::And);

pub(crate) fn vector(v: &Vector) -> RapierVector {
    RapierVector::new(v.x, v.y, v.z)
}

pub(crate) fn to_vector(v: RapierVector) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

pub(crate) fn pose(pose: &Pose) -> RapierPose {
    let q = pose.rotation.coords;
    RapierPose {
        rotation: RapierRotation::from_xyzw(q.x, q.y, q.z, q.w),
        translation: vector(&pose.translation.vector),
    }
}

pub(crate) fn to_pose(pose: &RapierPose) -> Pose {
    let q = pose.rotation;
    // The engine keeps quaternions normalized; no further rounding occurs.
    let rotation = UnitQuaternion::new_unchecked(Quaternion::new(q.w, q.x, q.y, q.z));
    Pose::from_parts(to_vector(pose.translation).into(), rotation)
}

/// Creates an empty world.
pub(crate) fn world(physics: &Physics) -> PhysicsWorld {
    let mut world = PhysicsWorld::new();
    world.gravity = vector(&(physics.up * -physics.gravity));
    let parameters = &mut world.integration_parameters;
    parameters.dt = physics.step_s;
    parameters.num_solver_iterations = physics.solver_iterations;
    let softness = SpringCoefficients::new(physics.contact_frequency_hz, physics.contact_damping_ratio);
    parameters.contact_softness = softness;
    parameters.static_contact_softness = softness;
    // This model begins to slip at μ N to within 1 %, the other one at 0.94 μ N (see `friction_tests.rs`).
    parameters.friction_model = FrictionModel::Simplified;
    parameters.friction_in_bias_pass = true;
    // These options save time with thousands of bodies, but cost accuracy with three.
    parameters.contact_recycling = false;
    parameters.contact_clustering = false;
    parameters.normalized_prediction_distance = PREDICTION_M;
    // Penetration that is not corrected, in metres.
    parameters.normalized_allowed_linear_error = 1e-5;
    parameters.max_ccd_substeps = 0;
    world
}

/// Advances a world by one step. With face contacts, more stabilization iterations are needed: with one, a long held object
/// creeps by millimetres per second. With edge contacts, more iterations would exceed the limit of friction (see
/// `friction_tests.rs`).
pub(crate) fn step(world: &mut PhysicsWorld, are_faces: bool) {
    world.integration_parameters.num_internal_stabilization_iterations = if are_faces { 4 } else { 1 };
    let step_s = world.integration_parameters.dt;
    world.step_with_events(&ContactPatch { step_s }, &());
}

/// Creates colliders without mass; the greater of two friction coefficients in contact applies.
pub(crate) fn colliders(
    of: &str,
    pieces: &[Piece],
    friction: f64,
    groups: InteractionGroups,
) -> Result<Vec<Collider>, SimError> {
    // Surroundings keep the engine's contacts: some come and go in every step, and with the hook the support would vanish too.
    let hooks = if groups == HAND || groups == BACK {
        ActiveHooks::MODIFY_SOLVER_CONTACTS | ActiveHooks::FILTER_CONTACT_PAIRS
    } else {
        ActiveHooks::empty()
    };
    let collider = |piece: &Piece| {
        let (place, shape) = shape(piece).ok_or_else(|| SimError::Shape {
            of: of.to_owned(),
            reason: ShapeError::NoVolume { volume_m3: 0.0 },
        })?;
        let bounds = BoundingBall::of(&*shape).map_or(0, BoundingBall::into_bits);
        Ok(ColliderBuilder::new(shape)
            .user_data(bounds)
            .position(place)
            .density(0.0)
            .friction(friction)
            .friction_combine_rule(CoefficientCombineRule::Max)
            .restitution(0.0)
            .collision_groups(groups)
            .active_hooks(hooks)
            .build())
    };
    pieces.iter().map(collider).collect()
}

/// Creates a collider of the surface of a closed mesh; `None` if it has no triangles.
pub(crate) fn shell(mesh: &TriangleSoup) -> Option<Collider> {
    let corners = mesh.vertices.iter().map(|vertex| vector(&vertex.coords)).collect();
    let flags = TriMeshFlags::FIX_INTERNAL_EDGES;
    let shape = SharedShape::trimesh_with_flags(corners, mesh.triangles.clone(), flags).ok()?;
    let shell = ColliderBuilder::new(shape).density(0.0).restitution(0.0).collision_groups(SHELL);
    Some(shell.friction_combine_rule(CoefficientCombineRule::Max).build())
}

fn shape(piece: &Piece) -> Option<(RapierPose, SharedShape)> {
    let place = pose(&piece.body_from_piece);
    // The cylinders of the engine have their axis along y.
    let along_z = place
        * RapierPose {
            rotation: RapierRotation::from_rotation_x(FRAC_PI_2),
            translation: RapierVector::ZERO,
        };
    Some(match &piece.shape {
        PieceShape::Cuboid([x, y, z]) => (place, SharedShape::cuboid(*x, *y, *z)),
        PieceShape::Ball(radius_m) => (place, SharedShape::ball(*radius_m)),
        PieceShape::Capsule(half_m, radius_m) => (along_z, SharedShape::capsule_y(*half_m, *radius_m)),
        PieceShape::Cylinder(half_m, radius_m) => (along_z, SharedShape::cylinder(*half_m, *radius_m)),
        PieceShape::Hull(hull) => {
            let corners: Vec<RapierVector> = hull.vertices.iter().map(|p| vector(&p.coords)).collect();
            (place, polyhedron::convex_hull(&corners)?)
        }
        PieceShape::HalfSpace => (place, SharedShape::halfspace(RapierVector::Z)),
    })
}

/// Penetration depth of two colliders, in metres; 0 if they do not overlap. Only `other` may be a half-space.
pub(crate) fn depth_m(own: &Collider, other: &Collider) -> f64 {
    if !own.compute_aabb().intersects(&other.compute_aabb()) {
        return 0.0;
    }
    // The order matters: the engine treats a half-space as second shape from the wrong side.
    let contact = query::contact(other.position(), other.shape(), own.position(), own.shape(), 0.0);
    contact.ok().flatten().map_or(0.0, |contact| -contact.dist)
}

/// Converts mass, centre of mass, and inertia about it.
pub(crate) fn mass_properties(mass_kg: f64, center: &Point, inertia_kg_m2: &Matrix3<f64>) -> MassProperties {
    let columns = [0, 1, 2].map(|column| vector(&inertia_kg_m2.column(column).into_owned()));
    MassProperties::with_inertia_matrix(
        vector(&center.coords),
        mass_kg,
        Matrix::from_cols(columns[0], columns[1], columns[2]),
    )
}

/// Normal impulse of the first of two bodies on the second in the last step, in N s. The engine's own sum also counts points
/// that it has dropped since they last bore load.
pub(crate) fn normal_impulse(pair: &ContactPair) -> Vector {
    let mut sum = Vector::zeros();
    for manifold in pair.manifolds() {
        let solved = manifold.data.solver_contacts.iter().flat_map(SolverContactGeneric::contact_indices);
        let points = solved.filter_map(|index| manifold.points.get(usize::try_from(index).ok()?));
        let impulse: f64 = points.map(|point| point.data.impulse).sum();
        sum += to_vector(manifold.data.normal) * impulse;
    }
    sum
}
