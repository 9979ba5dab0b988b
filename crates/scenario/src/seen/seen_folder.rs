use std::collections::BTreeMap;
use std::path::Path;

use crate::files::atomic_file::write_into;
use crate::layout::own;
use crate::seen::seen_space::SeenOptions;
use crate::{Recipe, Scenario, ScenarioError};

impl SeenOptions {
    /// Writes what is known of a scenario beside views in this folder: robot, start, target, grasps and floor, with the views as
    /// obstacles.
    ///
    /// # Errors
    /// As [`Scenario::write_folder`].
    pub fn write_scenario(&self, scenario: &Scenario, folder: &Path) -> Result<(), ScenarioError> {
        let hidden = scenario.with_known_bodies_only()?;
        let mut recipe = Recipe::of_scenario(&hidden)?;
        recipe.title = format!("scenario {} as cameras see it", scenario.id);
        recipe.write_folder(folder)?;
        write_into(folder, own::FILE, format!("{}{}", recipe.yaml(), self.yaml()))
    }
}

impl Scenario {
    /// Returns the scenario without its obstacles, and without what refers to them: tasks, places and known configurations.
    ///
    /// # Errors
    /// [`ScenarioError::Collision`] for an invalid pose.
    pub fn with_known_bodies_only(&self) -> Result<Self, ScenarioError> {
        let is_floor =
            |body: usize| self.world.bodies()[body].parts.iter().all(|part| part.solid.is_half_space());
        let is_known = |body: &usize| self.target == Some(*body) || is_floor(*body);
        let kept = (0..self.world.bodies().len()).filter(is_known);
        let bodies = kept.map(|body| self.world.bodies()[body].clone()).collect();
        Ok(Self {
            world: self.world.with_bodies(bodies)?,
            target: self.target.map(|_| 0),
            ik: Vec::new(),
            places: Vec::new(),
            tasks: Vec::new(),
            physics: BTreeMap::new(),
            export: None,
            seen: None,
            clouds: Vec::new(),
            ..self.clone()
        })
    }
}
