//! Scenarios derived from others: a body added, removed or moved.

use std::mem::take;

use cranny_collision::{Body, World};
use cranny_grasp::GraspSet;
use cranny_spatial::Pose;
use cranny_task::{Pick, PlaceAt, PlaceGoal, PlaceRegion, Stage};

use crate::{NamedTask, Scenario, ScenarioError};

impl Scenario {
    /// Returns the scenario with an additional obstacle. The triangles of a released export do not contain it and are dropped.
    ///
    /// # Errors
    /// [`ScenarioError::BodyName`] if the name is in use, [`ScenarioError::Collision`] for an invalid pose.
    pub fn with_body(&self, body: Body) -> Result<Self, ScenarioError> {
        if self.world.body_index(&body.name).is_ok() {
            return Err(ScenarioError::BodyName { name: body.name });
        }
        let mut bodies = self.world.bodies().to_vec();
        // Obstacles first, then the target, then the floor.
        let behind = self.target.unwrap_or_else(|| bodies.iter().take_while(|body| !body.is_floor()).count());
        bodies.insert(behind, body);
        let target = self.target.map(|target| target + 1);
        Ok(Self { world: self.world.with_bodies(bodies)?, target, export: None, ..self.clone() })
    }

    /// Returns the scenario without the places on bodies that are not, or no longer, its obstacles, without poses to place a target that it
    /// does not have, and without the tasks that name such a place or such a body.
    #[must_use]
    pub fn without_lost_places(mut self) -> Self {
        let (mut places, mut tasks) = (take(&mut self.places), take(&mut self.tasks));
        let Self { world, target, .. } = &self;
        let is_obstacle = |name: &str| world.body_index(name).is_ok_and(|body| Some(body) != *target);
        places.retain(|place: &PlaceGoal| match &place.spot {
            PlaceRegion::Surface { on, .. } => is_obstacle(on),
            PlaceRegion::Target(_) => target.is_some(),
        });
        let is_known = |stage: &Stage| match stage {
            Stage::Pick(Pick { object: Some(object), .. }) => world.body_index(object).is_ok(),
            Stage::Place(PlaceAt { place, .. }) => places.iter().any(|known| known.name == *place),
            Stage::Pick(_) | Stage::Move(_) => true,
        };
        tasks.retain(|task: &NamedTask| task.stages.iter().all(is_known));
        Self { places, tasks, ..self }
    }

    /// Returns the scenario without the named body; without the target, it has no target.
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
        let (mut sources, mut physics) = (self.sources.clone(), self.physics.clone());
        sources.remove(name);
        physics.remove(name);
        let given_physics = target.map(|_| self.given_physics).unwrap_or_default();
        let world = self.world.with_bodies(bodies)?;
        Ok(Self { world, target, sources, physics, given_physics, export: None, ..self.clone() })
    }

    /// Returns the scenario with the target moved by `motion`, a rigid motion in the planning frame, and all grasps with it.
    /// Known IK solutions become invalid and are dropped.
    ///
    /// # Errors
    /// [`ScenarioError::NoTarget`] if there is no target, [`ScenarioError::Collision`] for a motion that leads too far away.
    pub fn with_target_moved(&self, motion: &Pose) -> Result<Self, ScenarioError> {
        let Some(target) = self.target else { return Err(ScenarioError::NoTarget { id: self.id.clone() }) };
        self.with_moved(target, motion, &self.start)
    }

    /// Returns the scenario with a body moved by `motion`, in the planning frame, and with another start (m, rad; one per
    /// joint). The scenario's own grasps move with its target.
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

    /// Returns the scenario with other grasps; known IK solutions are dropped.
    #[must_use]
    pub fn with_grasps(&self, grasps: GraspSet) -> Self {
        Self { grasps, has_grasp_set: true, ik: Vec::new(), ..self.clone() }.with_own_twins()
    }

    /// Returns the scenario without a set of grasps: planners compute their own. Known IK solutions are dropped.
    #[must_use]
    pub fn without_grasps(&self) -> Self {
        Self { has_grasp_set: false, ..self.with_grasps(GraspSet::default()) }
    }

    /// Returns the scenario with another start (m, rad; one value per joint).
    ///
    /// # Errors
    /// [`ScenarioError::StartCount`] if there is not one value per joint.
    pub fn with_start(&self, start: Vec<f64>) -> Result<Self, ScenarioError> {
        Self { start, ..self.clone() }.with_checked_start(&self.id)
    }

    /// Returns the scenario with each body at the pose that the body of the same name has in `world`, and with the start `q`
    /// (m, rad; one value per joint). The scenario's own grasps move with its target.
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
