use cranny_scenario::{Scenario, TargetObject, TargetPhysics};
use cranny_spatial::Pose;

use crate::object_model::ObjectModel;
use crate::{Disturbance, Physics, Piece, SimError, engine};

/// Motion of the target of a scenario by itself within 2 s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rest {
    /// Displacement of the centre of mass, in metres.
    pub moved_m: f64,
    /// Visible rotation, in radians.
    pub turned_rad: f64,
    /// Pose in the planning frame after that time.
    pub world_from_object: Pose,
}

/// Duration of the observation of a target, in seconds.
const WATCHED_S: f64 = 2.0;
/// Default for an unknown mass, in kilograms: rest does not depend on it.
const ANY_MASS_KG: f64 = 0.2;

impl Rest {
    /// Maximum displacement of a resting target, in metres: more than it sinks into its support.
    pub const MOST_M: f64 = 5e-4;
    /// Maximum rotation of a resting target, in radians.
    pub const MOST_RAD: f64 = 5e-3;

    /// Simulates the target of a scenario; `None` without a target, a direction of gravity or a possible support.
    ///
    /// # Errors
    /// [`SimError::Shape`] for a body without volume.
    pub fn of_target(scenario: &Scenario) -> Result<Option<Self>, SimError> {
        let physics = scenario.target_physics();
        let instead = TargetPhysics { mass_kg: physics.mass_kg.or(Some(ANY_MASS_KG)), ..physics };
        let (Some(target), Some(found)) = (scenario.target, scenario.target_object(&instead)?) else {
            return Ok(None);
        };
        let bodies = scenario.world.bodies().iter().enumerate().filter(|(body, _)| *body != target);
        let TargetObject { object, world_from_object } = found;
        let model = ObjectModel::new(&object)?;
        let mut world = engine::world(&Physics { up: scenario.world.up(), ..Physics::default() });
        let mut is_any = false;
        for (_, body) in bodies {
            for collider in engine::colliders(&body.name, &Piece::of_body(body)?, 0.0, engine::SURROUNDINGS)?
            {
                world.insert_collider(collider, None);
                is_any = true;
            }
        }
        if !is_any {
            return Ok(None);
        }
        let nominal = Disturbance::default();
        let body = model.insert(&world_from_object, &nominal, &mut world);
        let rolling = model.rolling(physics.rolling_m.unwrap_or_default(), &nominal);
        let step_s = world.integration_parameters.dt;
        let mut passed_s = 0.0;
        while passed_s < WATCHED_S {
            rolling.resist(&mut world, body);
            engine::step(&mut world, false);
            passed_s += step_s;
        }
        let after = engine::to_pose(world.bodies[body].position());
        Ok(Some(Self {
            moved_m: (after * object.center_of_mass - world_from_object * object.center_of_mass).norm(),
            turned_rad: object.roundness.angle(&world_from_object.rotation, &after.rotation),
            world_from_object: after,
        }))
    }

    /// Returns true if the target stays at its pose.
    pub fn is_at_rest(&self) -> bool {
        self.moved_m <= Self::MOST_M && self.turned_rad <= Self::MOST_RAD
    }
}
