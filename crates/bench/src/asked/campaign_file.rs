use std::path::Path;

use cranny_collision::Margins;
use cranny_file::did_you_mean;
use cranny_grasp::ScoreKind;
use cranny_plan::Registry;
use cranny_scenario::built_in;
use cranny_solve::PoseRadius;
use cranny_task::Criterion;
use serde::Deserialize;
use serde_json::{Map, Value};
use serde_saphyr::{Location, Spanned};

use crate::asked::campaign::{checked_hold, checked_margin, checked_time_limit, checked_tries, checked_turn};
use crate::asked::scenario_choice::matches;
use crate::{BenchError, Campaign, CampaignPlanner, CarryTo, Exception, MEGABYTE, PathDemand, PlannerCall};

/// Content of a campaign file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CampaignEntry {
    scenarios: Vec<String>,
    planners: Vec<Spanned<PlannerEntry>>,
    #[serde(default)]
    criteria: Option<Vec<Criterion>>,
    #[serde(default)]
    runs: Option<u64>,
    #[serde(default)]
    first_seed: Option<u64>,
    #[serde(default)]
    time_limit_s: Option<Spanned<f64>>,
    #[serde(default)]
    iteration_limit: Option<u64>,
    #[serde(default)]
    memory_limit_mb: Option<u64>,
    #[serde(default)]
    judge_both: Option<bool>,
    #[serde(default)]
    measure_clearance: Option<bool>,
    #[serde(default)]
    carry: Option<CarryTo>,
    #[serde(default)]
    task: Option<String>,
    #[serde(default)]
    grasps: Option<GraspsEntry>,
    #[serde(default)]
    margin_m: Option<Spanned<f64>>,
    #[serde(default)]
    grasp_margin_m: Option<Spanned<f64>>,
    #[serde(default)]
    robust_m: Option<Spanned<f64>>,
    #[serde(default)]
    robust_rad: Option<Spanned<f64>>,
    #[serde(default)]
    hold: Option<Spanned<f64>>,
    #[serde(default)]
    try_in_physics: Option<Spanned<u64>>,
    #[serde(default)]
    exceptions: Vec<Spanned<ExceptionEntry>>,
}

/// The only value of `grasps`: a campaign uses the grasps of its scenarios or none.
#[derive(Deserialize)]
#[serde(rename_all = "kebab-case")]
enum GraspsEntry {
    None,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PlannerEntry {
    #[serde(default)]
    name: Option<String>,
    #[serde(default)]
    planner: Option<String>,
    #[serde(default)]
    settings: Map<String, Value>,
    #[serde(default)]
    score: Option<ScoreKind>,
    #[serde(default)]
    min_score: Option<f64>,
    #[serde(default)]
    exec: Option<Vec<String>>,
    #[serde(default)]
    released: Option<Vec<String>>,
    #[serde(default)]
    each_goal: bool,
    #[serde(default)]
    runs: Option<u64>,
    #[serde(default)]
    time_limit_s: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ExceptionEntry {
    scenario: String,
    planner: String,
    time_limit_s: f64,
}

impl Campaign {
    /// Reads a campaign from a YAML file, with planners of a registry and external programs. Relative paths in it start at
    /// the folder of the file.
    ///
    /// # Errors
    /// [`BenchError::Unreadable`]; [`BenchError::CampaignFile`] with the line.
    pub fn read(path: &Path, registry: &Registry) -> Result<Self, BenchError> {
        let text = cranny_file::TEXT
            .text(path)
            .map_err(|reason| BenchError::Unreadable { path: path.to_owned(), reason })?;
        let fault = |location: Location, problem: String| BenchError::CampaignFile {
            path: path.to_owned(),
            line: location.line().max(1),
            problem,
        };
        let entry: CampaignEntry = cranny_file::yaml(&text).map_err(|reason| BenchError::CampaignFile {
            path: path.to_owned(),
            line: reason.line as u64,
            problem: reason.problem,
        })?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut planners = Vec::new();
        for Spanned { value: planner, referenced, .. } in entry.planners {
            planners.push(planner.read(folder, registry).map_err(|problem| fault(referenced, problem))?);
        }
        let checked =
            |given: Option<Spanned<f64>>, default: f64, check: fn(f64) -> Result<f64, BenchError>| {
                let Some(given) = given else { return Ok(default) };
                check(given.value).map_err(|problem| fault(given.referenced, problem.to_string()))
            };
        let default = Self::default();
        let margins = Margins {
            margin_m: checked(entry.margin_m, 0.0, checked_margin)?,
            grasp_margin_m: checked(entry.grasp_margin_m, 0.0, checked_margin)?,
            ..Margins::default()
        };
        let robust = (entry.robust_m.is_some() || entry.robust_rad.is_some()).then_some(PoseRadius {
            translation_m: checked(entry.robust_m, 0.0, checked_margin)?,
            rotation_rad: checked(entry.robust_rad, 0.0, checked_turn)?,
        });
        let hold = entry.hold.map(|hold| checked(Some(hold), 0.0, checked_hold)).transpose()?;
        let try_in_physics = entry.try_in_physics.map(|most| {
            checked_tries(most.value).map_err(|problem| fault(most.referenced, problem.to_string()))
        });
        let mut exceptions = Vec::new();
        for Spanned { value: ExceptionEntry { scenario, planner, time_limit_s }, referenced, .. } in
            entry.exceptions
        {
            if !planners.iter().any(|known: &CampaignPlanner| known.name == planner) {
                let names: Vec<&str> = planners.iter().map(|known| known.name.as_str()).collect();
                let problem = format!(
                    "unknown planner '{planner}' in an exception (known: {}){}",
                    names.join(", "),
                    did_you_mean(&planner, names.iter().copied())
                );
                return Err(fault(referenced, problem));
            }
            checked_time_limit(time_limit_s).map_err(|problem| fault(referenced, problem.to_string()))?;
            exceptions.push(Exception { scenario, planner, time_limit_s });
        }
        Ok(Self {
            scenarios: entry.scenarios.iter().map(|word| scenario_beside(folder, word)).collect(),
            planners,
            criteria: entry.criteria.unwrap_or(default.criteria),
            runs: entry.runs.unwrap_or(default.runs),
            first_seed: entry.first_seed.unwrap_or(default.first_seed),
            time_limit_s: checked(entry.time_limit_s, default.time_limit_s, checked_time_limit)?,
            iteration_limit: entry.iteration_limit,
            memory_limit_bytes: entry
                .memory_limit_mb
                .map_or(default.memory_limit_bytes, |mb| mb.saturating_mul(MEGABYTE)),
            judge_both: entry.judge_both.unwrap_or(default.judge_both),
            measure_clearance: entry.measure_clearance.unwrap_or(default.measure_clearance),
            demand: PathDemand {
                carry: entry.carry,
                task: entry.task,
                margins,
                robust,
                hold,
                try_in_physics: try_in_physics.transpose()?,
                without_grasp_set: entry.grasps.is_some(),
            },
            exceptions,
        })
    }
}

impl PlannerEntry {
    fn read(self, folder: &Path, registry: &Registry) -> Result<CampaignPlanner, String> {
        let Self { name, planner, settings, score, min_score, exec, released, each_goal, runs, time_limit_s } =
            self;
        let words = |words: Vec<String>| words.iter().map(|word| beside(folder, word)).collect::<Vec<_>>();
        let has_settings = !settings.is_empty();
        let call = match (planner, exec, released) {
            (Some(planner), None, None) => {
                let (most, range) = match score {
                    Some(ScoreKind::Load) => (f64::MAX, "a load is a number from 0"),
                    _ => (1.0, "a score is from 0 to 1"),
                };
                if let Some(wrong) = min_score.filter(|least| !(0.0..=most).contains(least)) {
                    return Err(format!("`min_score` is {wrong}, but {range}"));
                }
                PlannerCall::BuiltIn { planner, settings, score: score.unwrap_or_default(), min_score }
            }
            (None, Some(_), None) | (None, None, Some(_)) if score.is_some() || min_score.is_some() => {
                return Err(
                    "`score` and `min_score` apply to a built-in `planner` only; a program gets all grasps \
                     with the geometric score"
                        .to_owned(),
                );
            }
            (None, Some(_), None) | (None, None, Some(_)) if has_settings => {
                return Err(
                    "`settings` apply to a built-in `planner` only; give a program arguments instead"
                        .to_owned(),
                );
            }
            (None, Some(command), None) => PlannerCall::Exec { command: words(command) },
            (None, None, Some(command)) => {
                let mut words = words(command).into_iter();
                PlannerCall::Released {
                    program: words.next().unwrap_or_default(),
                    arguments: words.collect(),
                }
            }
            _ => return Err("give one of `planner`, `exec` and `released`".to_owned()),
        };
        let call = call.checked(registry).map_err(|fault| fault.to_string())?;
        if let Some(limit) = time_limit_s {
            checked_time_limit(limit).map_err(|fault| fault.to_string())?;
        }
        Ok(CampaignPlanner { name: name.unwrap_or_else(|| call.name()), call, each_goal, runs, time_limit_s })
    }
}

/// Resolves the word of a scenario: an id takes precedence over a folder of the same name.
fn scenario_beside(folder: &Path, word: &str) -> String {
    let is_id = built_in().any(|entry| matches(word, entry.id));
    if is_id { word.to_owned() } else { beside(folder, word) }
}

/// Returns a word as a path from `folder` if such a file or folder exists, otherwise unchanged.
fn beside(folder: &Path, word: &str) -> String {
    let path = folder.join(word);
    if path.exists() && !word.is_empty() {
        // A slash marks it as a path, even in the current folder.
        let path = if path.components().count() == 1 { Path::new(".").join(path) } else { path };
        path.display().to_string()
    } else {
        word.to_owned()
    }
}
