//! Scenarios made from others: a body more or less, the object elsewhere.

use cranny_collision::{Body, World};
use cranny_grasp::GraspSet;
use cranny_spatial::Pose;

use crate::{Scenario, ScenarioError, TargetPhysics};

impl Scenario {
    /// The same scenario with one obstacle more. The triangles of a released export, which do not have it, are
    /// left out.
    ///
    /// # Errors
    /// [`ScenarioError::BodyName`] if there is a body of that name, [`ScenarioError::Collision`] for a pose that
    /// is none.
    pub fn with_body(&self, body: Body) -> Result<Self, ScenarioError> {
        if self.world.body_index(&body.name).is_ok() {
            return Err(ScenarioError::BodyName { name: body.name });
        }
        let mut bodies = self.world.bodies().to_vec();
        // Obstacles first, then the target, then the floor.
        let is_floor = |body: &Body| body.parts.iter().all(|part| part.solid.is_half_space());
        let behind = self.target.unwrap_or_else(|| bodies.iter().take_while(|body| !is_floor(body)).count());
        bodies.insert(behind, body);
        let target = self.target.map(|target| target + 1);
        Ok(Self { world: self.world.with_bodies(bodies)?, target, export: None, ..self.clone() })
    }

    /// The same scenario without the body of that name; without the target, there is none.
    ///
    /// # Errors
    /// [`ScenarioError::Collision`] if there is no such body.
    pub fn without_body(&self, name: &str) -> Result<Self, ScenarioError> {
        let removed = self.world.body_index(name)?;
        let mut bodies = self.world.bodies().to_vec();
        bodies.remove(removed);
        let target = self
            .target
            .filter(|&target| target != removed)
            .map(|target| if removed < target { target - 1 } else { target });
        let altered = Self { world: self.world.with_bodies(bodies)?, target, export: None, ..self.clone() };
        Ok(if target.is_some() {
            altered
        } else {
            Self { target_source: None, given_physics: TargetPhysics::default(), ..altered }
        })
    }

    /// The same scenario with the target moved by `motion`, a rigid motion of the planning frame, and all grasps
    /// with it. Known IK solutions no longer hold and are left out.
    ///
    /// # Errors
    /// [`ScenarioError::NoTarget`] if there is nothing to move, [`ScenarioError::Collision`] for a motion that
    /// leads too far away.
    pub fn with_target_moved(&self, motion: &Pose) -> Result<Self, ScenarioError> {
        let Some(target) = self.target else { return Err(ScenarioError::NoTarget { id: self.id.clone() }) };
        self.with_moved(target, motion, &self.start)
    }

    /// The scenario with a body elsewhere by a motion in the planning frame, and the robot at another start
    /// (m, rad; one per joint). The scenario's own grasps move with its target.
    ///
    /// # Errors
    /// [`ScenarioError::Collision`] for a motion that leads too far away.
    ///
    /// # Panics
    /// If the world has no body of that index.
    pub fn with_moved(&self, body: usize, motion: &Pose, start: &[f64]) -> Result<Self, ScenarioError> {
        let mut bodies = self.world.bodies().to_vec();
        for part in &mut bodies[body].parts {
            part.world_from_solid = motion * part.world_from_solid;
        }
        let is_own = self.target == Some(body);
        let grasps = if is_own { self.grasps.moved(motion) } else { self.grasps.clone() };
        let (world, start) = (self.world.with_bodies(bodies)?, start.to_vec());
        Ok(Self { world, grasps, start, ik: Vec::new(), export: None, ..self.clone() })
    }

    /// The same scenario with other grasps; known IK solutions are left out.
    #[must_use]
    pub fn with_grasps(&self, grasps: GraspSet) -> Self {
        Self { grasps, has_grasp_set: true, ik: Vec::new(), ..self.clone() }
    }

    /// The same scenario without a set of grasps: whoever plans makes a grasp of its own. Known IK solutions are left out.
    #[must_use]
    pub fn without_grasps(&self) -> Self {
        Self { has_grasp_set: false, ..self.with_grasps(GraspSet::default()) }
    }

    /// The same scenario from another start (m, rad; one value per joint).
    ///
    /// # Errors
    /// [`ScenarioError::StartCount`] if there is not one value per joint.
    pub fn with_start(&self, start: Vec<f64>) -> Result<Self, ScenarioError> {
        Self { start, ..self.clone() }.with_checked_start(&self.id)
    }

    /// The same scenario with each body where a world has the one of its name, and the robot at a configuration: `q`, one
    /// value per joint, m or rad. The scenario's own grasps move with its target.
    ///
    /// # Errors
    /// [`ScenarioError::Collision`] for a body that the scenario does not have.
    pub fn with_bodies_of(&self, world: &World, q: &[f64]) -> Result<Self, ScenarioError> {
        let mut now = self.clone();
        for body in world.bodies() {
            let own = self.world.body_index(&body.name)?;
            let first = |world: &World, index: usize| {
                world.bodies()[index].parts.first().map(|part| part.world_from_solid)
            };
            let moved = body.parts.first().map(|part| part.world_from_solid).zip(first(&self.world, own));
            if let Some((to, from)) = moved.filter(|(to, from)| to != from) {
                now = now.with_moved(own, &(to * from.inverse()), q)?;
            }
        }
        Ok(Self { start: q.to_vec(), ..now })
    }
}
