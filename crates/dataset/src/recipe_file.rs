#![allow(clippy::needless_pass_by_value, reason = "entries of a file are taken over by their checks")]

use std::collections::BTreeMap;
use std::path::Path;

use cranny_file::did_you_mean;
use cranny_plan::Registry;
use cranny_scenario::{BUILTIN_ROBOTS, Family, SceneScale};
use cranny_solve::MOST_HOLD;
use serde::Deserialize;
use serde_json::{Map, Value};
use serde_saphyr::{Location, Spanned};
use strum::VariantArray as _;

use crate::{DatasetError, DatasetRecipe, DemonstrationTask, FamilyRange};

/// Content of a recipe file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RecipeEntry {
    count: Spanned<u64>,
    #[serde(default)]
    seed: Option<u64>,
    #[serde(default)]
    queries_per_scene: Option<Spanned<u64>>,
    #[serde(default)]
    families: Option<Spanned<Vec<Spanned<String>>>>,
    #[serde(default)]
    ranges: BTreeMap<String, Spanned<[f64; 2]>>,
    #[serde(default)]
    robots: Option<Spanned<Vec<Spanned<String>>>>,
    #[serde(default)]
    clutter: Option<Spanned<usize>>,
    #[serde(default)]
    tasks: Option<Spanned<BTreeMap<String, f64>>>,
    #[serde(default)]
    start_spread: Option<Spanned<f64>>,
    #[serde(default)]
    planner: Option<Spanned<String>>,
    #[serde(default)]
    settings: Option<Spanned<Map<String, Value>>>,
    #[serde(default)]
    iterations: Option<Spanned<u64>>,
    #[serde(default)]
    changes: Option<Spanned<usize>>,
    #[serde(default)]
    margin_m: Option<Spanned<f64>>,
    #[serde(default)]
    grasp_margin_m: Option<Spanned<f64>>,
    #[serde(default)]
    hold: Option<Spanned<f64>>,
    #[serde(default)]
    rate_hz: Option<Spanned<f64>>,
    #[serde(default)]
    licence: Option<String>,
}

/// Greatest number of rows: beyond it, indices of rows would no longer fit every reader.
const MOST_ROWS: u64 = 1 << 40;
/// Greatest number of queries of a scene, and of clutter objects.
const MOST_QUERIES: u64 = 10_000;
const MOST_CLUTTER: u64 = 50;
/// Greatest rate of trajectories, in Hz.
const MOST_RATE_HZ: f64 = 1000.0;
/// Greatest clearance that a recipe may require, in metres: more than the width of any passage.
const MOST_MARGIN_M: f64 = 1.0;
/// Greatest limits of iterations and changes of one query.
const MOST_ITERATIONS: u64 = 10_000_000;
const MOST_CHANGES: u64 = 100_000;

/// A fault and its place in the file.
type Fault = (Location, String);

impl DatasetRecipe {
    /// Reads a recipe from a YAML file; `count` and `seed` replace those of the file if given.
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
        entry.recipe(registry).map_err(|(place, problem)| fault(place.line(), problem))
    }
}

impl RecipeEntry {
    fn recipe(self, registry: &Registry) -> Result<DatasetRecipe, Fault> {
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
            robots: names("robots", self.robots, default.robots, &robot_names())?,
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
        };
        Ok(recipe)
    }
}

fn robot_names() -> Vec<&'static str> {
    BUILTIN_ROBOTS.iter().map(|robot| robot.name).collect()
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
