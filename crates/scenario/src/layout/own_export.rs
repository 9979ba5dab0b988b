//! Scenarios as folders of Cranny's own layout.

use std::path::Path;

use cranny_task::Criterion;

use crate::files::atomic_file::write_into;
use crate::layout::own;
use crate::{Recipe, Scenario, ScenarioError, write_whole_folder};

impl Scenario {
    /// Writes the scenario as a new folder in Cranny's layout, which [`Scenario::open`] reads back; it contains the files of
    /// the robot unless that is built in.
    ///
    /// # Errors
    /// [`ScenarioError::Exists`] if the path exists already, [`ScenarioError::OtherRobot`] if the robot's files do not define
    /// it completely, [`ScenarioError::OtherFloor`] unless the floor is at the ground of the robot,
    /// [`ScenarioError::Unwritable`], [`ScenarioError::ShapeFile`].
    pub fn write_folder(&self, folder: &Path) -> Result<(), ScenarioError> {
        let recipe = Recipe::of_scenario(self)?;
        let mut heights =
            self.world.bodies().iter().filter(|body| body.is_floor()).flat_map(|body| &body.parts);
        let has_floor = heights.next().is_some_and(|part| {
            let scene_from_floor = recipe.robot.scene_from_root * part.world_from_solid;
            (scene_from_floor.translation.z).abs() < SAME_FLOOR_M
        });
        if !has_floor || heights.next().is_some() {
            return Err(ScenarioError::OtherFloor { height_m: -recipe.robot.scene_from_root.translation.z });
        }
        write_whole_folder(folder, |folder| {
            recipe.write_folder(folder)?;
            if self.criterion == Criterion::Paper {
                let text = format!("{}criterion: {}\n", recipe.yaml(), self.criterion.name());
                write_into(folder, own::FILE, &text)?;
            }
            Ok(())
        })
    }
}

/// Maximum difference between the heights of equal floors, in metres: rounding.
const SAME_FLOOR_M: f64 = 1e-9;
