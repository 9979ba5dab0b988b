use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::{Arc, Mutex};

use cranny_collision::{Margins, World};
use cranny_scenario::{GraspChoice, OpenOptions, Recipe, RecipeRobot, SetMaker};
use cranny_task::{Carrier, LiftOffSettings, Pick, Problem, State};
use rayon::prelude::*;

use crate::scene_row::SceneRow;
use crate::{DatasetError, DatasetRecipe};

/// Source of the scenes of a data set: the makers of all families for all robots, with grasps that are sampled once.
#[derive(Debug)]
pub struct SceneSource {
    recipe: DatasetRecipe,
    makers: Vec<SetMaker>,
    /// Robot of each maker, with its files.
    robots: Vec<RecipeRobot>,
    /// Carriers of the object in the first scene of each kind and number of bodies, made at their first use.
    carriers: Mutex<Carriers>,
}

/// Carriers by kind of scene and index of the target; `None` for a robot whose hand cannot close.
type Carriers = BTreeMap<(usize, usize), Option<Arc<Carrier>>>;

impl SceneSource {
    /// Samples the grasps of all objects, which takes about a second.
    ///
    /// # Errors
    /// Unknown families or robots, two robots of one name, and ranges that exceed those of a family.
    pub fn new(recipe: &DatasetRecipe) -> Result<Self, DatasetError> {
        let kinds = recipe.kinds()?;
        let robots: Vec<RecipeRobot> = kinds.iter().map(|(robot, ..)| robot.clone()).collect();
        let mut names = BTreeSet::new();
        for (path, kinds) in recipe.robots.iter().zip(robots.chunks(recipe.families.len().max(1))) {
            let name = kinds.first().map_or("", |robot| robot.robot.name());
            if !names.insert(name) {
                let problem =
                    format!("another robot of the recipe has the name '{name}' too; rows name robots");
                return Err(DatasetError::Content { path: path.into(), problem });
            }
        }
        let make = |(robot, family, settings)| {
            SetMaker::new(family, robot, settings, |problem| {
                cranny_plan::is_reached(problem).map_err(|fault| fault.to_string())
            })
        };
        let makers: Result<Vec<SetMaker>, _> = kinds.into_par_iter().map(make).collect();
        let makers = makers?;
        Ok(Self { recipe: recipe.clone(), makers, robots, carriers: Mutex::default() })
    }

    /// Returns the robot of the recipe of a scene, with the files that a folder of the scenario needs.
    pub(crate) fn robot_with_files(&self, scene: u64, recipe: &Recipe) -> RecipeRobot {
        let mut robot = self.robots[self.recipe.kind_of(scene)].clone();
        robot.scene_from_root = recipe.robot.scene_from_root;
        robot
    }

    /// Recipe of the data set.
    pub fn recipe(&self) -> &DatasetRecipe {
        &self.recipe
    }

    /// Returns the names of the joints of each robot.
    pub(crate) fn joint_names(&self) -> Vec<(String, Vec<String>)> {
        let mut names: Vec<(String, Vec<String>)> = Vec::new();
        for maker in &self.makers {
            let robot = &maker.family().robot().robot;
            if names.iter().all(|(name, _)| name != robot.name()) {
                names.push((robot.name().to_owned(), robot.joint_names().to_vec()));
            }
        }
        names
    }

    /// Draws a scene; without a sound draw, the row has no scenario.
    pub(crate) fn draw(&self, scene: u64) -> Result<(SceneRow, Option<Recipe>), DatasetError> {
        let maker = &self.makers[self.recipe.kind_of(scene)];
        let (member, rejected) = maker.member(scene)?;
        let (family, rejected) = (maker.family().family.name(), rejected.total() as u64);
        if let Some(member) = member {
            let row = SceneRow { rejected, ..SceneRow::of(scene, family, &member) };
            return Ok((row, Some(member.recipe)));
        }
        let robot = maker.family().robot().robot.name().to_owned();
        let (parameter_m, family) = (f64::NAN, family.to_owned());
        Ok((SceneRow { scene, family, robot, parameter_m, rejected, ..SceneRow::default() }, None))
    }

    /// Returns the carrier of the object of a scene; `None` for a robot whose hand cannot close.
    ///
    /// It is that of the first scene of the same kind with as many bodies, in the surroundings of this one, which is much faster
    /// than a new one. As it never comes from any other scene, the rows of a scene do not depend on those before.
    pub(crate) fn carrier(
        &self,
        scene: u64,
        problem: &Problem,
    ) -> Result<Option<Arc<Carrier>>, DatasetError> {
        let Some(target) = problem.target() else { return Ok(None) };
        let kind = self.recipe.kind_of(scene);
        let key = (kind, target);
        let known = self.carriers.lock().ok().and_then(|carriers| carriers.get(&key).cloned());
        let first = if let Some(first) = known {
            first
        } else {
            let made = self.first_carrier(kind as u64, target)?;
            if let Ok(mut carriers) = self.carriers.lock() {
                carriers.insert(key, made.clone());
            }
            made
        };
        let Some(first) = first else { return new_carrier(problem).map(|made| made.map(Arc::new)) };
        Ok(Some(Arc::new(first.with_surroundings_of(problem.exact_cell("dataset")?)?)))
    }

    /// Makes the carrier in the first scene of a kind whose target has this index; `None` if there is none among many.
    fn first_carrier(&self, kind: u64, target: usize) -> Result<Option<Arc<Carrier>>, DatasetError> {
        /// Number of scenes that are drawn: the numbers of clutter objects are about equally frequent.
        const MOST_SCENES: u64 = 1000;
        let kinds = self.makers.len() as u64;
        for scene in (0..MOST_SCENES).map(|turn| kind + turn * kinds) {
            let (_, recipe) = self.draw(scene)?;
            if let Some(recipe) = recipe.filter(|recipe| recipe.obstacles.len() == target) {
                let made = new_carrier(&problem_of(&recipe, self.recipe.margins())?)?;
                return Ok(made.map(Arc::new));
            }
        }
        Ok(None)
    }

    /// Makes the scenario of a row again from its values, without a random draw; `None` for a damaged row, or one without a
    /// scene.
    ///
    /// # Errors
    /// Values that no scene has.
    pub fn rebuild(&self, row: &SceneRow) -> Result<Option<Recipe>, DatasetError> {
        let maker = &self.makers[self.recipe.kind_of(row.scene)];
        let (Some(placement), Some(clutter)) = (row.place(), row.clutter_bodies()) else { return Ok(None) };
        if !row.is_drawn() || maker.family().family.name() != row.family {
            return Ok(None);
        }
        Ok(Some(maker.family().scenario(row.parameter_m, &placement, clutter, GraspChoice::Few)?))
    }
}

fn new_carrier(problem: &Problem) -> Result<Option<Carrier>, DatasetError> {
    let Some(start) = State::start(problem) else { return Ok(None) };
    let picking = start.picking(problem, &Pick::default())?;
    Ok(Some(Carrier::new(&picking, LiftOffSettings::default())?))
}

/// Returns the problem of a recipe, with these clearances.
pub(crate) fn problem_of(recipe: &Recipe, margins: Margins) -> Result<Problem, DatasetError> {
    Ok(recipe.scenario("scene", &OpenOptions::default())?.problem(margins)?)
}

/// Returns the name of the target of a problem.
pub(crate) fn target_name(problem: &Problem) -> String {
    let name = |world: &World| Some(world.bodies().get(problem.target()?)?.name.clone());
    problem.cell().and_then(|cell| name(cell.world())).unwrap_or_default()
}

/// Returns the name of a folder, for the id of a scenario in it.
pub(crate) fn folder_name(folder: &Path) -> String {
    folder.file_name().unwrap_or(folder.as_os_str()).to_string_lossy().into_owned()
}
