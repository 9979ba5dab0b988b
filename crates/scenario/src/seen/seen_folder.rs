use std::collections::BTreeMap;
use std::path::Path;

use cranny_sense::SeenMap;

use crate::files::atomic_file::write_into;
use crate::layout::own;
use crate::seen::seen_space::SeenOptions;
use crate::{Recipe, Scenario, ScenarioError};

impl SeenOptions {
    /// Writes what is known of a scenario beside views in this folder: robot, start, target, grasps, floor and these obstacles, with the
    /// views as further obstacles.
    ///
    /// # Errors
    /// As [`Scenario::with_known_bodies_only`] and [`Scenario::write_folder`].
    pub fn write_scenario(
        &self,
        scenario: &Scenario,
        known: &[String],
        folder: &Path,
    ) -> Result<(), ScenarioError> {
        let hidden = scenario.with_known_bodies_only(known)?;
        let mut recipe = Recipe::of_scenario(&hidden)?;
        recipe.title = format!("scenario {} as cameras see it", scenario.id);
        recipe.write_folder(folder)?;
        write_into(folder, own::FILE, format!("{}{}", recipe.yaml(), self.yaml()))
    }
}

impl Scenario {
    /// Returns the scenario without its obstacles, except for those with these names and the floor, and without what refers to the
    /// others: tasks, places and known configurations.
    ///
    /// # Errors
    /// [`ScenarioError::Collision`] for a name of no body or an invalid pose.
    pub fn with_known_bodies_only(&self, known: &[String]) -> Result<Self, ScenarioError> {
        for name in known {
            self.world.body_index(name)?;
        }
        let bodies = self.world.bodies();
        let is_kept = |index: &usize| {
            let body = &bodies[*index];
            self.target != Some(*index) && (body.is_floor() || known.contains(&body.name))
        };
        // The target first, so that its index is known.
        let others = (0..bodies.len()).filter(is_kept);
        let kept = self.target.into_iter().chain(others).map(|index| bodies[index].clone()).collect();
        Ok(Self {
            world: self.world.with_bodies(kept)?,
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

    /// Returns the scenario without the bodies that stand for a map of seen space, and as [`Self::with_known_bodies_only`].
    ///
    /// # Errors
    /// [`ScenarioError::Collision`] for an invalid pose.
    pub fn without_map(&self) -> Result<Self, ScenarioError> {
        let names = self.world.bodies().iter().map(|body| &body.name);
        let stated = names.filter(|name| !SeenMap::is_name_of_map(name));
        self.with_known_bodies_only(&stated.cloned().collect::<Vec<_>>())
    }
}
