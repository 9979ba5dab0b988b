#![allow(clippy::needless_pass_by_value, reason = "entries of a file are taken over by their checks")]

use std::collections::BTreeMap;
use std::path::Path;

use cranny_file::did_you_mean;
use cranny_plan::Registry;
use cranny_scenario::{BUILTIN_ROBOTS, Family, RecipeRobot, SceneScale};
use cranny_solve::MOST_HOLD;
use schemars::{JsonSchema, schema_for};
use serde::Deserialize;
use serde_json::{Map, Value};
use serde_saphyr::{Location, Spanned};
use strum::VariantArray as _;

use crate::recipe::cameras::DatasetCameras;
use crate::recipe::is_built_in;
use crate::recipe::limits::{
    MOST_CAMERAS, MOST_CHANGES, MOST_CLUTTER, MOST_ITERATIONS, MOST_MARGIN_M, MOST_QUERIES, MOST_RATE_HZ,
    MOST_ROWS,
};
use crate::{DatasetError, DatasetRecipe, DemonstrationTask, FamilyRange, GraspReasons};

/// Recipe of a data set. Everything but `count` has a default.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct RecipeEntry {
    /// Number of rows, each a query with its answer.
    #[schemars(with = "u64")]
    count: Spanned<u64>,
    /// Seed of all random numbers. Default 0.
    #[serde(default)]
    seed: Option<u64>,
    /// Number of rows of each scene. Default 10.
    #[serde(default)]
    #[schemars(with = "Option<u64>")]
    queries_per_scene: Option<Spanned<u64>>,
    /// Families of the scenes: shelf, table, gap, gate. Default: all.
    #[serde(default)]
    #[schemars(with = "Option<Vec<String>>")]
    families: Option<Spanned<Vec<Spanned<String>>>>,
    /// Range of the parameter of a family, in metres. Default: the usual one.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, [f64; 2]>")]
    ranges: BTreeMap<String, Spanned<[f64; 2]>>,
    /// Built-in robots, and paths of others relative to this file. Default `panda_mobile`.
    #[serde(default)]
    #[schemars(with = "Option<Vec<String>>")]
    robots: Option<Spanned<Vec<Spanned<String>>>>,
    /// Maximum number of clutter objects. Default 3.
    #[serde(default)]
    #[schemars(with = "Option<usize>")]
    clutter: Option<Spanned<usize>>,
    /// Relative frequencies of reach, carry and place. Default: reach alone.
    #[serde(default)]
    #[schemars(with = "Option<BTreeMap<String, f64>>")]
    tasks: Option<Spanned<BTreeMap<String, f64>>>,
    /// Random starts about the robot's own, as a share of the joint ranges. Default 0.3.
    #[serde(default)]
    #[schemars(with = "Option<f64>")]
    start_spread: Option<Spanned<f64>>,
    /// Planner. Default `reach`.
    #[serde(default)]
    #[schemars(with = "Option<String>")]
    planner: Option<Spanned<String>>,
    /// Settings of the planner.
    #[serde(default)]
    #[schemars(with = "Option<Map<String, Value>>")]
    settings: Option<Spanned<Map<String, Value>>>,
    /// Iteration limit of each search. Default 2000.
    #[serde(default)]
    #[schemars(with = "Option<u64>")]
    iterations: Option<Spanned<u64>>,
    /// Number of changes tried to shorten a path. Default 15.
    #[serde(default)]
    #[schemars(with = "Option<usize>")]
    changes: Option<Spanned<usize>>,
    /// Required clearance of every motion, in metres. Default 0.
    #[serde(default)]
    #[schemars(with = "Option<f64>")]
    margin_m: Option<Spanned<f64>>,
    /// Required clearance between the hand and the target, in metres. Default 0.
    #[serde(default)]
    #[schemars(with = "Option<f64>")]
    grasp_margin_m: Option<Spanned<f64>>,
    /// Required factor of the hold on a carried object. Default: not checked.
    #[serde(default)]
    #[schemars(with = "Option<f64>")]
    hold: Option<Spanned<f64>>,
    /// Rate of the trajectories in exports, in Hz. Default 20.
    #[serde(default)]
    #[schemars(with = "Option<f64>")]
    rate_hz: Option<Spanned<f64>>,
    /// Licence of the data, an SPDX expression. Default CC-BY-4.0.
    #[serde(default)]
    licence: Option<String>,
    /// `tried`: results at the grasps that came up; `all`: at all grasps of each scene. Default `tried`.
    #[serde(default)]
    reasons: Option<GraspReasons>,
    /// Cameras that take pictures of each scene: a file of cameras relative to this one, or {default: N} for N around the
    /// target. Default: no pictures.
    #[serde(default)]
    #[schemars(with = "Option<CamerasEntry>")]
    cameras: Option<Spanned<Value>>,
}

/// Cameras of a recipe: the name of a file, or a number of default ones.
#[derive(JsonSchema)]
#[serde(untagged)]
#[allow(dead_code, reason = "for the schema alone")]
enum CamerasEntry {
    File(String),
    Default { default: u8 },
}

/// Returns the JSON Schema of recipe files.
pub fn recipe_schema() -> String {
    let mut schema = schema_for!(RecipeEntry);
    schema.insert("title".into(), "Cranny recipe of a data set".into());
    let mut text = serde_json::to_string_pretty(&schema).unwrap_or_default();
    text.push('\n');
    text
}

/// A fault and its place in the file.
type Fault = (Location, String);

impl DatasetRecipe {
    /// Reads a recipe from a YAML file. Robots that are not built in and cameras are files relative to it.
    ///
    /// # Errors
    /// [`DatasetError::Unreadable`]; [`DatasetError::Recipe`] with the line.
    pub fn read(path: &Path, registry: &Registry) -> Result<Self, DatasetError> {
        let text = cranny_file::TEXT
            .text(path)
            .map_err(|reason| DatasetError::Unreadable { path: path.to_owned(), reason })?;
        let fault = |line: u64, problem: String| DatasetError::Recipe {
            path: path.to_owned(),
            line: line.max(1),
            problem,
        };
        let entry: RecipeEntry =
            cranny_file::yaml(&text).map_err(|reason| fault(reason.line as u64, reason.problem))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        entry.recipe(registry, folder).map_err(|(place, problem)| fault(place.line(), problem))
    }
}

impl RecipeEntry {
    fn recipe(self, registry: &Registry, folder: &Path) -> Result<DatasetRecipe, Fault> {
        let default = DatasetRecipe::default();
        let tasks = self.tasks.map_or(Ok(default.tasks), weights)?;
        let planner = match self.planner {
            Some(planner) => {
                let settings =
                    self.settings.as_ref().map(|settings| settings.value.clone()).unwrap_or_default();
                registry
                    .planner_with(&planner.value, &settings)
                    .map_err(|fault| (planner.referenced, fault.to_string()))?;
                planner.value
            }
            None => default.planner,
        };
        let settings = self.settings.map(|settings| settings.value).unwrap_or_default();
        let recipe = DatasetRecipe {
            count: whole("count", Some(self.count), 1, [1, MOST_ROWS])?,
            seed: self.seed.unwrap_or(default.seed),
            queries_per_scene: whole(
                "queries_per_scene",
                self.queries_per_scene,
                default.queries_per_scene,
                [1, MOST_QUERIES],
            )?,
            robots: robots(self.robots, default.robots, folder)?,
            families: families(self.families, self.ranges, default.families)?,
            clutter: small("clutter", self.clutter, default.clutter, MOST_CLUTTER)?,
            tasks,
            start_spread: number("start_spread", self.start_spread, default.start_spread, [0.0, 1.0])?,
            planner,
            settings,
            iterations: whole("iterations", self.iterations, default.iterations, [1, MOST_ITERATIONS])?,
            changes: small("changes", self.changes, default.changes, MOST_CHANGES)?,
            margin_m: number("margin_m", self.margin_m, default.margin_m, [0.0, MOST_MARGIN_M])?,
            grasp_margin_m: number(
                "grasp_margin_m",
                self.grasp_margin_m,
                default.grasp_margin_m,
                [0.0, MOST_MARGIN_M],
            )?,
            hold: self.hold.map(|hold| number("hold", Some(hold), 0.0, [0.0, MOST_HOLD])).transpose()?,
            rate_hz: number("rate_hz", self.rate_hz, default.rate_hz, [1.0, MOST_RATE_HZ])?,
            licence: self.licence.unwrap_or(default.licence),
            reasons: self.reasons.unwrap_or_default(),
            cameras: self.cameras.map(|given| cameras(given, folder)).transpose()?,
        };
        Ok(recipe)
    }
}

/// Returns names of built-in robots, and paths of others, which are loaded once to see that they can be.
fn robots(
    given: Option<Spanned<Vec<Spanned<String>>>>,
    default: Vec<String>,
    folder: &Path,
) -> Result<Vec<String>, Fault> {
    let known: Vec<&str> = BUILTIN_ROBOTS.iter().map(|robot| robot.name).collect();
    let is_path = |name: &str| !is_built_in(name) && folder.join(name).exists();
    let listed = given.as_ref().into_iter().flat_map(|given| &given.value);
    let paths: Vec<&str> = listed.map(|name| &name.value[..]).filter(|name| is_path(name)).collect();
    let known: Vec<String> = known.into_iter().chain(paths).map(str::to_owned).collect();
    let known: Vec<&str> = known.iter().map(String::as_str).collect();
    let places: Vec<Location> =
        given.as_ref().into_iter().flat_map(|given| &given.value).map(|name| name.referenced).collect();
    let mut robots = names("robots", given, default, &known)?;
    for (robot, place) in robots.iter_mut().zip(places) {
        if !is_built_in(robot) {
            let path = folder.join(&robot[..]);
            RecipeRobot::load(&path).map_err(|fault| (place, fault.to_string()))?;
            *robot = path.display().to_string();
        }
    }
    Ok(robots)
}

fn cameras(given: Spanned<Value>, folder: &Path) -> Result<DatasetCameras, Fault> {
    let Spanned { value, referenced, .. } = given;
    if let Value::String(file) = &value {
        return DatasetCameras::read(&folder.join(file)).map_err(|fault| (referenced, fault.to_string()));
    }
    let count = value.as_object().filter(|entry| entry.len() == 1).and_then(|entry| entry.get("default"));
    let count = count.and_then(Value::as_u64).filter(|count| (1..=MOST_CAMERAS).contains(count));
    let problem = || {
        format!(
            "`cameras` is {value}, but must be a file of cameras, or {{default: N}} with N from 1 to {MOST_CAMERAS}"
        )
    };
    let count = count.and_then(|count| usize::try_from(count).ok()).ok_or_else(|| (referenced, problem()))?;
    Ok(DatasetCameras::Default(count))
}

fn whole(
    name: &str,
    given: Option<Spanned<u64>>,
    default: u64,
    [least, most]: [u64; 2],
) -> Result<u64, Fault> {
    let Some(Spanned { value, referenced, .. }) = given else { return Ok(default) };
    let fits = (least..=most).contains(&value);
    let problem = || format!("`{name}` is {value}, but must be a whole number from {least} to {most}");
    if fits { Ok(value) } else { Err((referenced, problem())) }
}

fn small(name: &str, given: Option<Spanned<usize>>, default: usize, most: u64) -> Result<usize, Fault> {
    let Some(Spanned { value, referenced, .. }) = given else { return Ok(default) };
    let problem = || format!("`{name}` is {value}, but must be a whole number from 0 to {most}");
    if value as u64 <= most { Ok(value) } else { Err((referenced, problem())) }
}

fn number(
    name: &str,
    given: Option<Spanned<f64>>,
    default: f64,
    [least, most]: [f64; 2],
) -> Result<f64, Fault> {
    let Some(Spanned { value, referenced, .. }) = given else { return Ok(default) };
    let problem = || format!("`{name}` is {value}, but must be a number from {least} to {most}");
    if (least..=most).contains(&value) { Ok(value) } else { Err((referenced, problem())) }
}

/// Returns the names of a list, each one of those that are known.
fn names(
    key: &str,
    given: Option<Spanned<Vec<Spanned<String>>>>,
    default: Vec<String>,
    known: &[&str],
) -> Result<Vec<String>, Fault> {
    let Some(Spanned { value: list, referenced, .. }) = given else { return Ok(default) };
    if list.is_empty() {
        return Err((referenced, format!("`{key}` is empty; known: {}", known.join(", "))));
    }
    let mut names: Vec<String> = Vec::new();
    for Spanned { value: name, referenced, .. } in list {
        if !known.contains(&&name[..]) {
            let hint = did_you_mean(&name, known.iter().copied());
            let problem = format!("unknown name '{name}' in `{key}` (known: {}){hint}", known.join(", "));
            return Err((referenced, problem));
        }
        if names.contains(&name) {
            return Err((referenced, format!("'{name}' is in `{key}` twice")));
        }
        names.push(name);
    }
    Ok(names)
}

fn families(
    given: Option<Spanned<Vec<Spanned<String>>>>,
    mut ranges: BTreeMap<String, Spanned<[f64; 2]>>,
    default: Vec<FamilyRange>,
) -> Result<Vec<FamilyRange>, Fault> {
    let known: Vec<&str> = Family::VARIANTS.iter().map(|family| family.name()).collect();
    let default = default.into_iter().map(|known| known.family).collect();
    let mut families = Vec::new();
    for family in names("families", given, default, &known)? {
        let range = ranges.remove(&family);
        let parameter_m = range.map(|range| checked_range(&family, range)).transpose()?;
        families.push(FamilyRange { family, parameter_m });
    }
    match ranges.into_iter().next() {
        Some((family, range)) => Err((
            range.referenced,
            format!("`ranges` has '{family}', which is not in `families`{}", did_you_mean(&family, known)),
        )),
        None => Ok(families),
    }
}

fn checked_range(family: &str, range: Spanned<[f64; 2]>) -> Result<[f64; 2], Fault> {
    let Spanned { value: [from, to], referenced, .. } = range;
    if from.partial_cmp(&to).is_none_or(std::cmp::Ordering::is_gt) {
        let problem =
            format!("the range of '{family}', from {from} to {to}, is empty: give the smaller end first");
        return Err((referenced, problem));
    }
    let known = Family::of_name(family).map_err(|fault| (referenced, fault.to_string()))?;
    for end in [from, to] {
        known.checked(end, &SceneScale::PAPER).map_err(|fault| (referenced, fault.to_string()))?;
    }
    Ok([from, to])
}

fn weights(given: Spanned<BTreeMap<String, f64>>) -> Result<BTreeMap<DemonstrationTask, f64>, Fault> {
    let Spanned { value, referenced, .. } = given;
    let known: Vec<&str> = DemonstrationTask::VARIANTS.iter().map(|task| task.name()).collect();
    let mut weights = BTreeMap::new();
    for (name, weight) in value {
        let Some(task) = DemonstrationTask::of_name(&name) else {
            let hint = did_you_mean(&name, known.iter().copied());
            let problem = format!("unknown task '{name}' (known: {}){hint}", known.join(", "));
            return Err((referenced, problem));
        };
        if !(weight.is_finite() && weight >= 0.0) {
            return Err((
                referenced,
                format!("the weight of '{name}' is {weight}, but must be a number from 0"),
            ));
        }
        weights.insert(task, weight);
    }
    if weights.values().sum::<f64>() > 0.0 {
        return Ok(weights);
    }
    Err((referenced, "`tasks` has no task with a weight above 0, as in {reach: 8, carry: 1}".to_owned()))
}
