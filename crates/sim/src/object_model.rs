use cranny_scenario::{Friction, ObjectType};
use cranny_shape::{Roundness, Surface, TriangleSoup};
use cranny_spatial::nalgebra::Matrix3;
use cranny_spatial::{Point, Pose};
use rapier3d_f64::prelude::{Collider, MassProperties, PhysicsWorld, RigidBodyBuilder, RigidBodyHandle};

use crate::rolling::Rolling;
use crate::shell::Shell;
use crate::{Disturbance, Piece, SimError, engine};

/// Object in the form of the engine.
#[derive(Clone, Debug)]
pub(crate) struct ObjectModel {
    pub name: String,
    pub pieces: Vec<Piece>,
    /// Exact surface, which pads meet.
    pub surface: Surface,
    /// Surface for display.
    pub shown: TriangleSoup,
    /// Surface that a hand with pads meets instead of the pieces; `None` if these are accurate.
    pub shell: Option<Shell>,
    /// Centre of mass.
    pub center: Point,
    pub mass_kg: f64,
    pub inertia_kg_m2: Matrix3<f64>,
    pub friction: Friction,
    pub roundness: Roundness,
    colliders: Vec<Collider>,
    mass_properties: MassProperties,
}

impl ObjectModel {
    pub fn new(object: &ObjectType) -> Result<Self, SimError> {
        let exact = object.solids.iter().map(|(pose, solid)| Piece::of_solid(&object.name, pose, solid));
        let pieces = match exact.collect::<Result<Vec<_>, _>>()?.concat() {
            none if none.is_empty() => Piece::of_hulls(&Pose::identity(), object.parts.parts.iter().cloned()),
            exact => exact,
        };
        let shown = if object.solids.is_empty() { object.mesh.clone() } else { Piece::surface_of(&pieces) };
        let shape = |reason| SimError::Shape { of: object.name.clone(), reason };
        let surface = Surface::new(&shown).map_err(shape)?;
        Ok(Self {
            shell: Shell::of(object, &surface),
            surface,
            shown,
            name: object.name.clone(),
            center: object.center_of_mass,
            mass_kg: object.mass_kg,
            inertia_kg_m2: object.inertia_kg_m2,
            friction: object.friction,
            roundness: object.roundness,
            colliders: engine::colliders(&object.name, &pieces, object.friction.low, engine::OBJECT)?,
            pieces,
            mass_properties: engine::mass_properties(
                object.mass_kg,
                &object.center_of_mass,
                &object.inertia_kg_m2,
            ),
        })
    }

    /// Returns the resistance to rolling, with this arm (m).
    pub fn rolling(&self, arm_m: f64, disturbance: &Disturbance) -> Rolling {
        Rolling {
            arm_m,
            mass_kg: self.mass_kg * disturbance.mass,
            inertia_kg_m2: self.inertia_kg_m2 * disturbance.mass,
            center: self.center,
        }
    }

    /// Inserts the object into a world, free to move: its pieces, which everything meets.
    pub fn insert(
        &self,
        world_from_object: &Pose,
        disturbance: &Disturbance,
        world: &mut PhysicsWorld,
    ) -> RigidBodyHandle {
        self.insert_with(None, world_from_object, disturbance, world)
    }

    /// Inserts the object into a world with a hand with pads, free to move: its shell, if it has one, meets the hand.
    pub fn insert_for_pads(
        &self,
        world_from_object: &Pose,
        disturbance: &Disturbance,
        world: &mut PhysicsWorld,
    ) -> RigidBodyHandle {
        self.insert_with(self.shell.as_ref(), world_from_object, disturbance, world)
    }

    fn insert_with(
        &self,
        shell: Option<&Shell>,
        world_from_object: &Pose,
        disturbance: &Disturbance,
        world: &mut PhysicsWorld,
    ) -> RigidBodyHandle {
        let mut mass_properties = self.mass_properties;
        mass_properties.set_mass(mass_properties.mass() * disturbance.mass, true);
        let body = RigidBodyBuilder::dynamic()
            .pose(engine::pose(world_from_object))
            .can_sleep(false)
            .additional_mass_properties(mass_properties);
        let object = world.insert_body(body);
        for collider in self.colliders.iter().chain(shell.map(|shell| &shell.collider)) {
            let mut collider = collider.clone();
            if shell.is_some() && collider.collision_groups() == engine::OBJECT {
                collider.set_collision_groups(engine::PARTS);
            }
            collider.set_friction(disturbance.friction_of(&self.friction));
            world.insert_collider(collider, Some(object));
        }
        object
    }
}

/// Simulates until an object with rolling resistance has not moved for `still_s`, or until `limit_s`. Returns its final pose,
/// and true if it is still.
pub(crate) fn come_to_rest(
    world: &mut PhysicsWorld,
    (body, rolling): (RigidBodyHandle, &Rolling),
    still_s: f64,
    limit_s: f64,
) -> (Pose, bool) {
    let step_s = world.integration_parameters.dt;
    let (mut passed_s, mut since_s) = (0.0, 0.0);
    while passed_s < limit_s && since_s < still_s {
        rolling.resist(world, body);
        engine::step(world, false);
        passed_s += step_s;
        let body = &world.bodies[body];
        let is_still = body.linvel().length() < STILL_M_PER_S && body.angvel().length() < STILL_RAD_PER_S;
        since_s = if is_still { since_s + step_s } else { 0.0 };
    }
    (engine::to_pose(world.bodies[body].position()), since_s >= still_s)
}

/// Speeds below which an object is at rest: its motion within a tenth of a second is insignificant.
pub(crate) const STILL_M_PER_S: f64 = 1e-3;
const STILL_RAD_PER_S: f64 = 1e-2;
