use std::collections::HashSet;
use std::time::Duration;

use cranny_file::visible_line;
use cranny_grasp::ScoreKind;
use cranny_plan::{Budget, Registry, Unobserved};
use cranny_scenario::Recipe;
use cranny_solve::MOST_HOLD;
use cranny_task::{Carrier, Criterion, Goal, LiftOffSettings, Problem, Stage};

use crate::asked::scenario_choice::{choose_scenarios, matches};
use crate::running::opened_scenario::OpenedScenario;
use crate::{BenchError, PathDemand, PlannerCall, Question, ScenarioSource, Trial, TrialOutcome};

/// Maximum number of trials of a campaign. Each takes about a kilobyte of memory before the first one runs.
pub const MOST_TRIALS: u64 = 1_000_000;

/// Maximum time limit of a trial, in seconds (116 days). No clock overflows below it.
pub const MOST_TIME_LIMIT_S: f64 = 1e7;

/// Maximum memory limit of a search, in MB (17 TB). It exceeds any machine, and its bytes still fit the counter.
pub const MOST_MEMORY_MB: u64 = 1 << 24;

/// Bytes in an MB of a campaign, of its results and its reports.
pub const MEGABYTE: u64 = 1_000_000;

/// Campaign: every scenario by every planner under every criterion with every seed.
#[derive(Clone, Debug, PartialEq)]
pub struct Campaign {
    /// Words that select the scenarios; see [`choose_scenarios`].
    pub scenarios: Vec<String>,
    /// The planners.
    pub planners: Vec<CampaignPlanner>,
    /// Criteria for a solved trial. Default: `exact` alone.
    pub criteria: Vec<Criterion>,
    /// Number of seeds. Default 100, as in the paper.
    pub runs: u64,
    /// The first seed; each further run uses the next one. Default 0.
    pub first_seed: u64,
    /// Time limit of a trial, in seconds. Default 120, as in the paper.
    pub time_limit_s: f64,
    /// Iteration limit of a trial. Default: `None`, only time counts.
    pub iteration_limit: Option<u64>,
    /// Memory limit of a search beyond the scenario itself, in bytes. Default 4 GiB.
    pub memory_limit_bytes: u64,
    /// True if each path is also judged under the other criterion. Default: false.
    pub judge_both: bool,
    /// True if the minimum clearance along each path is measured, at most a tenth too low, in some additional milliseconds.
    /// Default: true.
    pub measure_clearance: bool,
    /// Demands on each path beyond its criterion. Default: none.
    pub demand: PathDemand,
    /// Exceptions from the time limits.
    pub exceptions: Vec<Exception>,
}

/// A planner of a campaign.
#[derive(Clone, Debug, PartialEq)]
pub struct CampaignPlanner {
    /// Name in reports.
    pub name: String,
    /// Call of the planner.
    pub call: PlannerCall,
    /// True if the planner aims at each goal configuration of a scenario in a separate trial, not at all grasps together.
    pub each_goal: bool,
    /// Number of seeds, if it differs from that of the campaign.
    pub runs: Option<u64>,
    /// Time limit of this planner, in seconds.
    pub time_limit_s: Option<f64>,
}

/// Time limit of one planner in some scenarios; it overrides all others.
#[derive(Clone, Debug, PartialEq)]
pub struct Exception {
    /// Id or pattern of ids.
    pub scenario: String,
    /// The planner's name.
    pub planner: String,
    /// The limit, in seconds.
    pub time_limit_s: f64,
}

impl Default for Campaign {
    fn default() -> Self {
        Self {
            scenarios: Vec::new(),
            planners: Vec::new(),
            criteria: vec![Criterion::Exact],
            runs: 100,
            first_seed: 0,
            time_limit_s: 120.0,
            iteration_limit: None,
            memory_limit_bytes: 4096 * MEGABYTE,
            judge_both: false,
            measure_clearance: true,
            demand: PathDemand::default(),
            exceptions: Vec::new(),
        }
    }
}

/// All trials of a campaign.
#[derive(Clone, Debug, PartialEq)]
pub struct Schedule {
    /// All trials, ordered by seed: an interrupted campaign has run every planner equally often.
    pub questions: Vec<Question>,
    /// Sources of the scenarios.
    pub scenarios: Vec<ScenarioSource>,
    /// Notes for the user before the first trial, such as trials whose outcome is certain already.
    pub notes: Vec<String>,
}

impl CampaignPlanner {
    /// Creates a planner with default options, for all grasps together.
    pub fn new(call: PlannerCall) -> Self {
        Self { name: call.name(), call, each_goal: false, runs: None, time_limit_s: None }
    }
}

/// Maximum length of the name of a planner, in characters: a report repeats it in every row.
const LONGEST_NAME: usize = 200;

impl Campaign {
    /// Returns the paper's Table I: J⁺-RRT for all grasps, IK-RRT for each goal configuration by itself, 100 runs of 120 s
    /// (900 s for J⁺-RRT in 045) under the `paper` criterion, in the twenty built-in scenarios.
    ///
    /// IK-RRT keeps searching for its one goal until the time limit.
    ///
    /// # Errors
    /// None in a correct build: [`BenchError::Plan`] would mean that a planner is missing.
    pub fn paper() -> Result<Self, BenchError> {
        let call = |planner: &str, settings: serde_json::Value| {
            let settings = settings.as_object().cloned().unwrap_or_default();
            PlannerCall::BuiltIn {
                planner: planner.to_owned(),
                settings,
                score: ScoreKind::default(),
                min_score: None,
            }
            .checked(&Registry::default())
        };
        let j_plus_rrt = CampaignPlanner::new(call("j-plus-rrt", serde_json::json!({}))?);
        /// Exceeds the iterations possible within any time limit.
        const ENDLESS: u64 = 1_000_000_000_000;
        let ik_rrt = CampaignPlanner {
            each_goal: true,
            ..CampaignPlanner::new(call("ik-rrt", serde_json::json!({"goal_iterations": ENDLESS}))?)
        };
        let longer =
            Exception { scenario: "045".into(), planner: j_plus_rrt.name.clone(), time_limit_s: 900.0 };
        Ok(Self {
            scenarios: vec!["all".into()],
            planners: vec![j_plus_rrt, ik_rrt],
            criteria: vec![Criterion::Paper],
            exceptions: vec![longer],
            ..Self::default()
        })
    }

    /// Lists every trial of the campaign once. Opens the scenarios and checks that the planners accept them, so that errors
    /// of later trials appear before the first trial.
    ///
    /// # Errors
    /// [`BenchError`] for scenarios that do not open, duplicate or invisible planner names, a planner that refuses a scenario, an empty
    /// campaign, and numbers out of range.
    pub fn schedule(&self, registry: &Registry) -> Result<Schedule, BenchError> {
        self.check()?;
        let criteria = self.distinct_criteria();
        let chosen = choose_scenarios(&self.scenarios)?;
        // This early check avoids opening many scenarios in vain. The numbers of goals are known later.
        self.check_size(&chosen.iter().map(|_| 1))?;
        let (mut scenarios, mut notes) = (Vec::new(), Vec::new());
        for chosen in chosen {
            let mut source = ScenarioSource {
                scenario: chosen.identity.id,
                scenario_hash: chosen.identity.sha256,
                source: chosen.source,
                goals: None,
            };
            for criterion in &criteria {
                let opened = OpenedScenario::open(&source.source, *criterion, &self.demand)?;
                if source.goals.is_none() && self.planners.iter().any(|planner| planner.each_goal) {
                    source.goals = Some(opened.goals()?.len());
                }
                notes.extend(self.try_out(&opened, registry)?);
            }
            scenarios.push(source);
        }
        self.check_size(&scenarios.iter().map(|scenario| scenario.goals.unwrap_or(0) as u64))?;
        for Exception { scenario, planner, .. } in &self.exceptions {
            if !scenarios.iter().any(|source| matches(scenario, &source.scenario)) {
                notes.push(format!(
                    "the exception of planner '{planner}' in '{scenario}' matches no scenario of the campaign"
                ));
            }
        }
        // All settings of its planner identify a trial, including the defaults, regardless of who created the call.
        let settings_of = |planner: &CampaignPlanner| {
            Ok(self.demand.among(planner.call.clone().checked(registry)?.settings()))
        };
        let settings: Vec<String> =
            self.planners.iter().map(settings_of).collect::<Result<_, BenchError>>()?;
        let most_runs =
            self.planners.iter().map(|planner| planner.runs.unwrap_or(self.runs)).max().unwrap_or(0);
        let mut questions = Vec::new();
        for run in 0..most_runs {
            for scenario in &scenarios {
                for (planner, settings) in self.planners.iter().zip(&settings) {
                    if run >= planner.runs.unwrap_or(self.runs) {
                        continue;
                    }
                    let goals: Vec<Option<usize>> = if planner.each_goal {
                        (0..scenario.goals.unwrap_or(0)).map(Some).collect()
                    } else {
                        vec![None]
                    };
                    for (criterion, goal) in
                        criteria.iter().flat_map(|c| goals.iter().map(move |goal| (*c, *goal)))
                    {
                        let trial = Trial {
                            scenario: scenario.scenario.clone(),
                            scenario_hash: scenario.scenario_hash.clone(),
                            planner: planner.name.clone(),
                            settings: settings.clone(),
                            criterion,
                            seed: self.first_seed + run,
                            time_limit_s: self.time_limit(scenario, planner),
                            iteration_limit: self.iteration_limit,
                            goal,
                        };
                        questions.push(Question {
                            trial,
                            source: scenario.source.clone(),
                            call: planner.call.clone(),
                            judge_both: self.judge_both,
                            measure_clearance: self.measure_clearance,
                        });
                    }
                }
            }
        }
        if questions.is_empty() {
            return Err(BenchError::Empty { what: "trials (no scenario has a goal configuration)" });
        }
        Ok(Schedule { questions, scenarios, notes })
    }

    fn time_limit(&self, scenario: &ScenarioSource, planner: &CampaignPlanner) -> f64 {
        let holds = |exception: &&Exception| {
            exception.planner == planner.name && matches(&exception.scenario, &scenario.scenario)
        };
        let exception = self.exceptions.iter().find(holds).map(|exception| exception.time_limit_s);
        exception.or(planner.time_limit_s).unwrap_or(self.time_limit_s)
    }

    /// Checks that every planner accepts a scenario. Returns a note if the start is not free, which ends each trial at once.
    fn try_out(&self, opened: &OpenedScenario, registry: &Registry) -> Result<Option<String>, BenchError> {
        let (scenario, problem) = (&opened.scenario, &opened.problem);
        for planner in &self.planners {
            self.ask(planner, opened, registry).map_err(|reason| BenchError::Refused {
                scenario: scenario.id.clone(),
                planner: planner.name.clone(),
                reason: reason.to_string(),
            })?;
        }
        let is_free = problem.start_is_free();
        let (criterion, outcome) = (problem.criterion().name(), TrialOutcome::StartInvalid.name());
        Ok((!is_free).then(|| {
            let id = &scenario.id;
            format!(
                "the start of {id} is not free under {criterion}: every trial there will end as {outcome}"
            )
        }))
    }

    /// Runs a planner with zero iterations, which reveals every objection to the scenario.
    fn ask(
        &self,
        planner: &CampaignPlanner,
        opened: &OpenedScenario,
        registry: &Registry,
    ) -> Result<(), BenchError> {
        let PlannerCall::BuiltIn { planner: name, settings, score, min_score } = &planner.call else {
            // An external program receives the scenario as files.
            return Ok(Recipe::of_scenario(&opened.scenario).map(drop)?);
        };
        let aimed: Problem;
        let problem = if planner.each_goal {
            // Without a goal there is no trial.
            let Some(goal) = opened.goals()?.first() else { return Ok(()) };
            aimed = opened.problem.with_goal(Goal::Configurations(vec![goal.clone()]))?;
            &aimed
        } else {
            &opened.problem
        };
        let stages = self.demand.stages_in(&opened.scenario)?;
        let asked = cranny_solve::Request {
            registry: registry.clone(),
            planner: Some(name.clone()),
            score: Some(*score),
            min_score: *min_score,
            stages: stages.clone(),
            ..cranny_solve::Request::default()
        };
        asked.check(problem)?;
        if stages.len() > 1 && stages[0] == Stage::pick() {
            Carrier::new(problem, LiftOffSettings::default())?;
        }
        let nothing = Budget { iterations: 0, time: Duration::ZERO };
        let planner = registry.planner_with(name, settings)?;
        Ok(planner.plan(problem, &nothing, self.first_seed, &mut Unobserved).map(drop)?)
    }

    /// Returns the criteria without duplicates.
    fn distinct_criteria(&self) -> Vec<Criterion> {
        let mut distinct = Vec::new();
        for criterion in &self.criteria {
            if !distinct.contains(criterion) {
                distinct.push(*criterion);
            }
        }
        distinct
    }

    /// Rejects a campaign with too many trials; `goals` is the number of goals of each scenario.
    fn check_size(&self, goals: &(impl Iterator<Item = u64> + Clone)) -> Result<(), BenchError> {
        let of_planner = |planner: &CampaignPlanner| {
            let per_run: u64 = goals.clone().map(|goals| if planner.each_goal { goals } else { 1 }).sum();
            planner.runs.unwrap_or(self.runs).saturating_mul(per_run)
        };
        let trials = self.planners.iter().map(of_planner).fold(0, u64::saturating_add);
        let trials = trials.saturating_mul(self.distinct_criteria().len() as u64);
        if trials > MOST_TRIALS {
            Err(BenchError::TooManyTrials { trials, most: MOST_TRIALS })
        } else {
            Ok(())
        }
    }

    fn check(&self) -> Result<(), BenchError> {
        for (what, is_empty) in
            [("planners", self.planners.is_empty()), ("criteria", self.criteria.is_empty())]
        {
            if is_empty {
                return Err(BenchError::Empty { what });
            }
        }
        if self.demand.without_grasp_set {
            let needing = [
                ("each_goal", self.planners.iter().any(|planner| planner.each_goal)),
                ("judge_both", self.judge_both),
                ("criterion paper", self.criteria.contains(&Criterion::Paper)),
            ];
            if let Some((what, _)) = needing.into_iter().find(|(_, is_asked)| *is_asked) {
                return Err(BenchError::NeedsGraspSet { what });
            }
        }
        let is_shown = |name: &str| {
            // Another blank looks like none, or like a plain one.
            let is_other_blank = |c: char| c != ' ' && (c.is_whitespace() || c == '\u{2800}');
            !name.is_empty()
                && name.trim() == name
                && name.chars().count() <= LONGEST_NAME
                && visible_line(name) == name
                && !name.contains(is_other_blank)
        };
        if let Some(planner) = self.planners.iter().find(|planner| !is_shown(&planner.name)) {
            return Err(BenchError::PlannerLetters { name: planner.name.clone() });
        }
        let mut names = HashSet::new();
        if let Some(planner) = self.planners.iter().find(|planner| !names.insert(&planner.name)) {
            return Err(BenchError::PlannerName { name: planner.name.clone() });
        }
        let own = self.planners.iter().filter_map(|planner| planner.time_limit_s);
        let exceptions = self.exceptions.iter().map(|exception| exception.time_limit_s);
        for value in std::iter::once(self.time_limit_s).chain(own).chain(exceptions) {
            checked_time_limit(value)?;
        }
        let most_runs = self.planners.iter().map(|planner| planner.runs.unwrap_or(self.runs)).max();
        if most_runs == Some(0) {
            return Err(BenchError::Range { what: "the number of runs", value: 0.0, range: "at least 1" });
        }
        for value in [self.demand.margins.margin_m, self.demand.margins.grasp_margin_m] {
            checked_margin(value)?;
        }
        if let Some(error) = self.demand.robust {
            checked_margin(error.translation_m)?;
            checked_turn(error.rotation_rad)?;
        }
        if let Some(hold) = self.demand.hold {
            checked_hold(hold)?;
        }
        if let Some(most) = self.demand.try_in_physics {
            checked_tries(most)?;
        }
        // A results file can store only values below 2^63.
        let last_seed = self.first_seed.checked_add(most_runs.unwrap_or(0));
        if last_seed.is_none_or(|seed| i64::try_from(seed).is_err()) {
            let value = self.first_seed as f64 + most_runs.unwrap_or(0) as f64;
            return Err(BenchError::Range { what: "the last seed", value, range: "below 2^63" });
        }
        if let Some(limit) = self.iteration_limit.filter(|limit| i64::try_from(*limit).is_err()) {
            let range = "below 2^63";
            return Err(BenchError::Range { what: "the iteration limit", value: limit as f64, range });
        }
        let memory_mb = self.memory_limit_bytes / MEGABYTE;
        if !(1..=MOST_MEMORY_MB).contains(&memory_mb) {
            let range = "at least 1 and at most 16777216 MB";
            return Err(BenchError::Range { what: "the memory limit", value: memory_mb as f64, range });
        }
        Ok(())
    }
}

/// Validates a time limit, in seconds.
pub(crate) fn checked_time_limit(value: f64) -> Result<f64, BenchError> {
    if value > 0.0 && value <= MOST_TIME_LIMIT_S {
        return Ok(value);
    }
    Err(BenchError::Range { what: "a time limit", value, range: "above 0 and at most 10000000 s" })
}

/// Validates a rotation angle, in radians.
pub(crate) fn checked_turn(value: f64) -> Result<f64, BenchError> {
    if (0.0..=std::f64::consts::PI).contains(&value) {
        return Ok(value);
    }
    Err(BenchError::Range { what: "a turn", value, range: "from 0 to π" })
}

/// Validates the demanded factor of the grip.
pub(crate) fn checked_hold(value: f64) -> Result<f64, BenchError> {
    if (0.0..=MOST_HOLD).contains(&value) {
        return Ok(value);
    }
    Err(BenchError::Range { what: "a hold", value, range: "from 0 to 100" })
}

/// Validates the maximum number of plans that are executed in physics.
pub(crate) fn checked_tries(value: u64) -> Result<u64, BenchError> {
    /// Each takes a second or so.
    const MOST: u64 = 1000;
    if (1..=MOST).contains(&value) {
        return Ok(value);
    }
    let range = "from 1 to 1000";
    Err(BenchError::Range { what: "the number of plans tried in physics", value: value as f64, range })
}

/// Validates a demanded clearance, in metres.
pub(crate) fn checked_margin(value: f64) -> Result<f64, BenchError> {
    /// Exceeds the clearances within any cell.
    const MOST_M: f64 = 1.0;
    if (0.0..=MOST_M).contains(&value) {
        return Ok(value);
    }
    Err(BenchError::Range { what: "a margin", value, range: "from 0 to 1 m" })
}
