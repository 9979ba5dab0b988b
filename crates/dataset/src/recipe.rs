pub(crate) mod cameras;
pub(crate) mod limits;
pub(crate) mod recipe_file;

use std::collections::BTreeMap;
use std::path::Path;

use cranny_collision::Margins;
use cranny_scenario::{BUILTIN_ROBOTS, Family, RecipeRobot, SetSettings};
use cranny_solve::MOST_HOLD;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use strum::{IntoStaticStr, VariantArray};

use crate::DatasetError;
use crate::recipe::cameras::DatasetCameras;
use crate::recipe::limits::{
    MOST_CHANGES, MOST_CLUTTER, MOST_ITERATIONS, MOST_MARGIN_M, MOST_QUERIES, MOST_RATE_HZ, MOST_ROWS,
};

/// Recipe of a data set: with the version of Cranny it determines every byte of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DatasetRecipe {
    /// Number of rows, each a query with its answer.
    pub count: u64,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Number of rows of each scene, at least 1.
    pub queries_per_scene: u64,
    /// Families of the scenes, in turn.
    pub families: Vec<FamilyRange>,
    /// Names of built-in robots, and paths of others; the families of all scenes are run through for each in turn. In the
    /// description of a set, a path is below its folder.
    pub robots: Vec<String>,
    /// Maximum number of clutter objects in a scene.
    pub clutter: usize,
    /// Relative frequency of each task; those of the weight 0 are left out.
    pub tasks: BTreeMap<DemonstrationTask, f64>,
    /// Range of the joints of a random start about the robot's own, as a share of their ranges, in [0, 1]. The first query of
    /// a scene begins at the robot's own start, as do all for 0.
    pub start_spread: f64,
    /// Name of the planner.
    pub planner: String,
    /// Settings of the planner that differ from the defaults.
    pub settings: Map<String, Value>,
    /// Iteration limit of each search.
    pub iterations: u64,
    /// Number of changes that are tried to shorten a path.
    pub changes: usize,
    /// Required clearance of every motion, in metres.
    pub margin_m: f64,
    /// Required clearance between the hand and the target, in metres.
    pub grasp_margin_m: f64,
    /// Required factor of the hold on a carried object; `None`: the hold is not checked.
    pub hold: Option<f64>,
    /// Rate of the trajectories in exports, in Hz.
    pub rate_hz: f64,
    /// Licence of the data, an SPDX expression, for the data card.
    pub licence: String,
    /// Extent of the results at the grasps of a scene.
    #[serde(default, skip_serializing_if = "GraspReasons::is_tried")]
    pub reasons: GraspReasons,
    /// Cameras that take a picture of each scene; `None`: there are no pictures.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cameras: Option<DatasetCameras>,
}

/// Grasps of a scene whose result is determined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum GraspReasons {
    /// Those that came up until there were enough goal configurations; the others are `not-tried`.
    #[default]
    Tried,
    /// All of them, by some attempts of inverse kinematics at each.
    All,
}

impl GraspReasons {
    #[allow(clippy::trivially_copy_pass_by_ref, reason = "serde asks for it")]
    fn is_tried(&self) -> bool {
        *self == Self::Tried
    }
}

/// Family of scenes with the range of its parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FamilyRange {
    /// Name of the family.
    pub family: String,
    /// Range of its difficulty parameter, in metres; `None`: the usual one, in the scale that suits the robot.
    pub parameter_m: Option<[f64; 2]>,
}

/// Tasks of demonstrations.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, IntoStaticStr, VariantArray,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum DemonstrationTask {
    /// A path to a grasp.
    Reach,
    /// Reach, and the way back to the start with the object in the hand.
    Carry,
    /// Reach, and the object put down outside of the narrow space.
    Place,
}

impl DemonstrationTask {
    /// Name in recipes and rows.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// Returns the task of that name.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::VARIANTS.iter().copied().find(|task| task.name() == name)
    }
}

impl Default for DatasetRecipe {
    fn default() -> Self {
        let family = |name: &str| FamilyRange { family: name.to_owned(), parameter_m: None };
        Self {
            count: 1000,
            seed: 0,
            queries_per_scene: 10,
            families: ["shelf", "table", "gap", "gate"].map(family).to_vec(),
            robots: vec!["panda_mobile".to_owned()],
            clutter: 3,
            tasks: BTreeMap::from([(DemonstrationTask::Reach, 1.0)]),
            start_spread: 0.3,
            planner: "reach".to_owned(),
            settings: Map::new(),
            iterations: 2000,
            changes: 15,
            margin_m: 0.0,
            grasp_margin_m: 0.0,
            hold: None,
            rate_hz: 20.0,
            licence: "CC-BY-4.0".to_owned(),
            reasons: GraspReasons::Tried,
            cameras: None,
        }
    }
}

impl DatasetRecipe {
    /// Number of scenes.
    pub fn scenes(&self) -> u64 {
        self.count.div_ceil(self.queries_per_scene.max(1))
    }

    /// Returns a sentence on the first value that no recipe file may state.
    pub(crate) fn fault(&self) -> Option<String> {
        for (key, value, most) in [
            ("count", self.count, MOST_ROWS),
            ("queries_per_scene", self.queries_per_scene, MOST_QUERIES),
            ("iterations", self.iterations, MOST_ITERATIONS),
            ("changes", self.changes as u64 + 1, MOST_CHANGES + 1),
            ("clutter", self.clutter as u64 + 1, MOST_CLUTTER + 1),
        ] {
            if !(1..=most).contains(&value) {
                return Some(format!("`{key}` is out of its range"));
            }
        }
        for (key, value, [least, most]) in [
            ("margin_m", self.margin_m, [0.0, MOST_MARGIN_M]),
            ("grasp_margin_m", self.grasp_margin_m, [0.0, MOST_MARGIN_M]),
            ("hold", self.hold.unwrap_or(0.0), [0.0, MOST_HOLD]),
            ("rate_hz", self.rate_hz, [1.0, MOST_RATE_HZ]),
            ("start_spread", self.start_spread, [0.0, 1.0]),
        ] {
            if !(least..=most).contains(&value) {
                return Some(format!("`{key}` is {value}, but must be from {least} to {most}"));
            }
        }
        if self.families.is_empty() || self.robots.is_empty() || self.tasks.is_empty() {
            return Some("`families`, `robots` and `tasks` must not be empty".to_owned());
        }
        if self.tasks.values().any(|weight| !(*weight >= 0.0 && weight.is_finite())) {
            return Some("the weights of `tasks` must not be negative".to_owned());
        }
        self.cameras.as_ref().and_then(DatasetCameras::fault)
    }

    /// Required clearances.
    pub fn margins(&self) -> Margins {
        Margins { margin_m: self.margin_m, grasp_margin_m: self.grasp_margin_m, ..Margins::default() }
    }

    /// Returns the robot and the family of a scene.
    pub(crate) fn kind_of(&self, scene: u64) -> usize {
        let kinds = self.families.len() * self.robots.len();
        usize::try_from(scene % kinds.max(1) as u64).unwrap_or(0)
    }

    /// Returns robot, family and settings of each kind of scene.
    ///
    /// # Errors
    /// Unknown families and robots.
    pub(crate) fn kinds(&self) -> Result<Vec<(RecipeRobot, Family, SetSettings)>, DatasetError> {
        let mut kinds = Vec::new();
        for robot in &self.robots {
            let robot = RecipeRobot::load(Path::new(robot))?;
            for FamilyRange { family, parameter_m } in &self.families {
                let family = Family::of_name(family)?;
                let mut settings = SetSettings::new(family, &robot, self.seed);
                settings.parameter_m = parameter_m.unwrap_or(settings.parameter_m);
                settings.most_clutter = self.clutter;
                kinds.push((robot.clone(), family, settings));
            }
        }
        Ok(kinds)
    }

    /// Returns this recipe with the paths of robots that are not built in changed by a function.
    pub(crate) fn with_robots(&self, path_of: impl Fn(&Path) -> String) -> Self {
        let change = |name: &String| if is_built_in(name) { name.clone() } else { path_of(Path::new(name)) };
        Self { robots: self.robots.iter().map(change).collect(), ..self.clone() }
    }
}

/// Returns true for the name of a built-in robot.
pub(crate) fn is_built_in(name: &str) -> bool {
    BUILTIN_ROBOTS.iter().any(|robot| robot.name == name)
}
