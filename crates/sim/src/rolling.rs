use cranny_spatial::nalgebra::{Matrix3, Rotation3};
use cranny_spatial::{Point, Vector};
use rapier3d_f64::prelude::{PhysicsWorld, RigidBodyHandle};

use crate::engine;

/// Rolling resistance of an object on its surroundings, which the engine does not model.
///
/// The yielding support carries a ball slightly ahead of its middle: the normal force N on an arm of `arm_m` resists rotation
/// with the torque N · `arm_m` (Lynch & Park 2017, "Modern Robotics", section 12.2.1).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rolling {
    pub arm_m: f64,
    pub mass_kg: f64,
    /// Inertia in the frame of the object, about the centre of mass.
    pub inertia_kg_m2: Matrix3<f64>,
    pub center: Point,
}

impl Rolling {
    /// Sets the torque on the object for the next step, from the contact forces of the last one.
    pub fn resist(&self, world: &mut PhysicsWorld, object: RigidBodyHandle) {
        world.bodies[object].reset_torques(false);
        if self.arm_m <= 0.0 || world.bodies[object].is_sleeping() {
            return;
        }
        let step_s = world.integration_parameters.dt;
        let (mut pressed, mut at, mut borne) = (Vector::zeros(), Vector::zeros(), 0.0);
        for &own in world.bodies[object].colliders() {
            for pair in world.contact_pairs_with(own) {
                let is_first = pair.collider1 == own;
                let other = if is_first { pair.collider2 } else { pair.collider1 };
                if world.colliders[other].parent().is_some() {
                    continue;
                }
                pressed += engine::normal_impulse(pair) / step_s;
                for point in pair.manifolds().iter().flat_map(|manifold| &manifold.points) {
                    let local = if is_first { point.local_p1 } else { point.local_p2 };
                    let place = world.colliders[own].position().transform_point(local);
                    at += engine::to_vector(place) * point.data.impulse;
                    borne += point.data.impulse;
                }
            }
        }
        let body = &mut world.bodies[object];
        let (pose, turning) = (engine::to_pose(body.position()), engine::to_vector(body.angvel()));
        let Some(normal) = pressed.try_normalize(0.0) else { return };
        let rolling = turning - normal * turning.dot(&normal);
        let Some(axis) = rolling.try_normalize(LEAST_RAD_PER_S) else { return };
        let arm = if borne > 0.0 { at / borne - (pose * self.center).coords } else { Vector::zeros() };
        let world_from_body: Rotation3<f64> = pose.rotation.to_rotation_matrix();
        let inertia = world_from_body.matrix() * self.inertia_kg_m2 * world_from_body.matrix().transpose();
        // This inertia is about the contact point.
        let inertia = axis.dot(&(inertia * axis)) + self.mass_kg * axis.cross(&arm).norm_squared();
        let torque = (self.arm_m * pressed.norm()).min(rolling.norm() * inertia / step_s);
        body.add_torque(engine::vector(&(axis * -torque)), false);
    }
}

/// Minimum angular velocity of rolling, in rad/s.
const LEAST_RAD_PER_S: f64 = 1e-9;
