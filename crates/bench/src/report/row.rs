use std::collections::BTreeMap;

use cranny_file::visible_line;
use serde::Serialize;
use serde_json::Value;

use crate::report::configuration::{Configuration, Names};
use crate::report::follow_up;
use crate::report::scenario_class::ScenarioClass;
use crate::statistics::{FiveNumbers, Followed, KaplanMeier, SampleMoments, median_interval, wilson};
use crate::{StoredTrial, TrialOutcome, TrialRecord};

/// All runs of one planner, with one set of settings and limits, on one scenario under one criterion. If each run aims at
/// one goal, the figures are those of the best goal, as in the paper's table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Id of the scenario.
    pub scenario: String,
    /// Unique name of the scenario: its id, with a prefix of the hash if two scenarios have the same id.
    pub scenario_name: String,
    /// SHA-256 over the files of the scenario.
    pub scenario_hash: String,
    /// The environment, family or set of the scenario.
    pub environment: String,
    /// Name of the dial of that environment, if known.
    pub dial: Option<&'static str>,
    /// Value of the dial, in metres.
    pub dial_m: Option<f64>,
    /// Name of the planner.
    pub planner: String,
    /// Unique name of the planner: its name, with its differences from others of that name.
    pub planner_name: String,
    /// Settings of the planner.
    pub settings: Value,
    /// Criterion for a solved trial.
    pub criterion: String,
    /// Time limit of each run, in seconds.
    pub time_limit_s: f64,
    /// Iteration limit of each run.
    pub iteration_limit: Option<u64>,
    /// Index of the best goal, if each run aims at one.
    pub goal: Option<usize>,
    /// Number of goals aimed at.
    pub goals: Option<usize>,
    /// Number of goals solved at least once.
    pub goals_solved: Option<usize>,
    /// Number of runs.
    pub runs: usize,
    /// Number of runs that the judge found solved.
    pub solved: usize,
    /// Number of runs whose planner claimed a path that the proof refused.
    pub claimed: usize,
    /// Number of paths also judged under the other criterion.
    pub also_judged: usize,
    /// Number of paths that also meet the other criterion.
    pub also_solved: usize,
    /// Success rate, `solved / runs`.
    pub success_rate: f64,
    /// Lower end of the Wilson interval of the success rate.
    pub success_low: f64,
    /// Upper end of the Wilson interval of the success rate.
    pub success_high: f64,
    /// Mean time in seconds, where a failure counts with its limit: the paper's convention.
    pub mean_s: f64,
    /// Sample standard deviation of these times, in seconds; `None` for one run.
    pub std_s: Option<f64>,
    /// Shortest time of a solved run, in seconds; `None` if there is none.
    pub least_s: Option<f64>,
    /// Lower quartile of the time (Kaplan–Meier), in seconds; `None` if fewer runs are solved.
    pub lower_quartile_s: Option<f64>,
    /// Median time (Kaplan–Meier), in seconds; `None` if fewer than half of the runs are solved.
    pub median_s: Option<f64>,
    /// Lower end of its interval, by order statistics, in seconds; `None` for fewer than six runs.
    pub median_low_s: Option<f64>,
    /// Upper end of its interval, in seconds; also `None` if it is past the limit.
    pub median_high_s: Option<f64>,
    /// Upper quartile of the time (Kaplan–Meier), in seconds; `None` if fewer runs are solved.
    pub upper_quartile_s: Option<f64>,
    /// Longest time of a solved run, in seconds.
    pub greatest_s: Option<f64>,
    /// Restricted mean time, in seconds.
    pub restricted_mean_s: Option<f64>,
    /// Standard error of the restricted mean, in seconds; `None` if no time varies, as for one run.
    pub restricted_mean_error_s: Option<f64>,
    /// Horizon of the restricted mean, in seconds.
    pub restricted_to_s: f64,
    /// Median number of iterations (Kaplan–Meier); `None` if fewer than half of the runs are solved, or if none are counted.
    pub median_iterations: Option<f64>,
    /// Lower end of the interval of the median iterations.
    pub median_iterations_low: Option<f64>,
    /// Upper end of the interval of the median iterations.
    pub median_iterations_high: Option<f64>,
    /// Number of runs by outcome.
    pub outcomes: BTreeMap<&'static str, usize>,
    /// Iterations of the solved runs; `None` if all are 0, as of a planner that counts none.
    pub iterations: Option<FiveNumbers>,
    /// Nodes of the search trees of the solved runs; `None` if all are 0, as of a planner that counts none.
    pub nodes: Option<FiveNumbers>,
    /// Lengths of the paths.
    pub path_length: Option<FiveNumbers>,
    /// Proven clearances of the paths, in metres.
    pub clearance_m: Option<FiveNumbers>,
    /// Scores of the grasps at the ends of the paths.
    pub grasp_score: Option<FiveNumbers>,
    /// Memory of the searches, solved or not, in bytes; `None` if it was not measured or all values are zero.
    pub memory_bytes: Option<FiveNumbers>,
}

/// All runs of one planner that aim at one goal of a scenario.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GoalRow {
    /// Name of the scenario, as in [`Row::scenario_name`].
    pub scenario_name: String,
    /// Name of the planner, as in [`Row::planner_name`].
    pub planner_name: String,
    /// Criterion for a solved trial.
    pub criterion: String,
    /// Index of the goal.
    pub goal: usize,
    /// True if the row shows the figures of this goal.
    pub best: bool,
    /// Number of runs.
    pub runs: usize,
    /// Number of solved runs.
    pub solved: usize,
    /// Success rate, `solved / runs`.
    pub success_rate: f64,
    /// Lower end of the Wilson interval of the success rate.
    pub success_low: f64,
    /// Upper end of the Wilson interval of the success rate.
    pub success_high: f64,
    /// Mean time in seconds, where a failure counts with its limit.
    pub mean_s: f64,
    /// Sample standard deviation of these times, in seconds.
    pub std_s: Option<f64>,
}

/// Row with its runs, from which curves and comparisons are computed.
pub struct Group<'a> {
    pub row: Row,
    pub goals: Vec<GoalRow>,
    /// The runs of the row.
    pub runs: Vec<&'a StoredTrial>,
}

/// Success rate and times in the paper's convention, for some runs.
struct Figures {
    solved: usize,
    success_low: f64,
    success_high: f64,
    mean_s: f64,
    std_s: Option<f64>,
}

impl Figures {
    /// Computes the figures; `runs` must not be empty.
    fn of(runs: &[&StoredTrial]) -> Self {
        let solved = runs.iter().filter(|run| run.record.is_solved()).count();
        let times: Vec<f64> = runs.iter().map(|run| follow_up::paper_time_s(&run.record)).collect();
        let interval = wilson(solved, runs.len());
        let moments = SampleMoments::of(&times);
        Self {
            solved,
            success_low: interval.map_or(0.0, |interval| interval.low),
            success_high: interval.map_or(1.0, |interval| interval.high),
            mean_s: moments.map_or(0.0, |moments| moments.mean),
            std_s: moments.and_then(|moments| moments.standard_deviation),
        }
    }
}

impl<'a> Group<'a> {
    /// Groups `runs`, which are all those of `configuration`, at least one.
    pub fn of(configuration: &Configuration, names: &Names, runs: Vec<&'a StoredTrial>) -> Self {
        let goals = goal_rows(configuration, names, &runs);
        let best = goals.iter().find(|row| row.best).map(|row| row.goal);
        let runs = match best {
            Some(best) => runs.into_iter().filter(|run| run.record.trial.goal == Some(best)).collect(),
            None => runs,
        };
        Self { row: row(configuration, names, &goals, &runs), goals, runs }
    }

    pub fn over_time(&self) -> Vec<Followed> {
        self.runs.iter().map(|run| follow_up::over_time(&run.record)).collect()
    }

    /// Returns the follow-up over iterations; empty if the planner counts none, or is a program that states them.
    pub fn over_iterations(&self) -> Vec<Followed> {
        over_iterations(&self.runs)
    }
}

fn over_iterations(runs: &[&StoredTrial]) -> Vec<Followed> {
    let most = runs.iter().map(|run| run.record.statistics.iterations).max().unwrap_or(0);
    if most == 0 || !runs.iter().all(|run| run.record.trial.is_built_in()) {
        return Vec::new();
    }
    let all = runs.iter().map(|run| follow_up::over_iterations(&run.record, most));
    follow_up::while_half_are_followed(all.collect())
}

/// Returns one row for each goal, with the best one marked: most often solved, then fastest, then first.
fn goal_rows(configuration: &Configuration, names: &Names, runs: &[&StoredTrial]) -> Vec<GoalRow> {
    let mut by_goal: BTreeMap<usize, Vec<&StoredTrial>> = BTreeMap::new();
    for &run in runs {
        if let Some(goal) = run.record.trial.goal {
            by_goal.entry(goal).or_default().push(run);
        }
    }
    let row = |(goal, runs): (usize, Vec<&StoredTrial>)| {
        let figures = Figures::of(&runs);
        GoalRow {
            scenario_name: names.scenario(configuration).to_owned(),
            planner_name: names.planner(configuration).to_owned(),
            criterion: configuration.criterion.to_owned(),
            goal,
            best: false,
            runs: runs.len(),
            solved: figures.solved,
            success_rate: figures.solved as f64 / runs.len() as f64,
            success_low: figures.success_low,
            success_high: figures.success_high,
            mean_s: figures.mean_s,
            std_s: figures.std_s,
        }
    };
    let mut rows: Vec<GoalRow> = by_goal.into_iter().map(row).collect();
    let rank = |row: &GoalRow| (-row.success_rate, row.mean_s);
    if let Some(best) = rows.iter_mut().min_by(|a, b| {
        let (a, b) = (rank(a), rank(b));
        a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
    }) {
        best.best = true;
    }
    rows
}

fn row(configuration: &Configuration, names: &Names, goals: &[GoalRow], runs: &[&StoredTrial]) -> Row {
    let figures = Figures::of(runs);
    let place = ScenarioClass::of(&configuration.scenario);
    let followed: Vec<Followed> = runs.iter().map(|run| follow_up::over_time(&run.record)).collect();
    let time = KaplanMeier::of(&followed);
    let iterations = KaplanMeier::of(&over_iterations(runs));
    let median_of_times = median_interval(&followed);
    let median_of_iterations = median_interval(&over_iterations(runs));
    let restricted_to_s = horizon_s(&time, configuration.time_limit_s());
    let restricted_mean = time.restricted_mean(restricted_to_s);
    let mut outcomes = BTreeMap::new();
    for run in runs {
        *outcomes.entry(run.record.outcome.name()).or_default() += 1;
    }
    let of_solved = |figure: fn(&TrialRecord) -> Option<f64>| {
        let solved = runs.iter().map(|run| &run.record).filter(|record| record.is_solved());
        FiveNumbers::of(solved.filter_map(figure))
    };
    let goal_count = |count: usize| (!goals.is_empty()).then_some(count);
    Row {
        scenario: configuration.scenario.clone(),
        scenario_name: names.scenario(configuration).to_owned(),
        scenario_hash: configuration.scenario_hash.clone(),
        environment: visible_line(&place.environment),
        dial: place.dial,
        dial_m: place.dial_m,
        planner: configuration.planner.clone(),
        planner_name: names.planner(configuration).to_owned(),
        settings: serde_json::from_str(&configuration.settings)
            .unwrap_or_else(|_| Value::String(configuration.settings.clone())),
        criterion: configuration.criterion.to_owned(),
        time_limit_s: configuration.time_limit_s(),
        iteration_limit: configuration.iteration_limit,
        goal: goals.iter().find(|row| row.best).map(|row| row.goal),
        goals: goal_count(goals.len()),
        goals_solved: goal_count(goals.iter().filter(|row| row.solved > 0).count()),
        runs: runs.len(),
        solved: figures.solved,
        claimed: runs.iter().filter(|run| run.record.outcome == TrialOutcome::ClaimedNotProven).count(),
        also_judged: runs.iter().filter(|run| run.record.also_solved.is_some()).count(),
        also_solved: runs.iter().filter(|run| run.record.also_solved == Some(true)).count(),
        success_rate: figures.solved as f64 / runs.len() as f64,
        success_low: figures.success_low,
        success_high: figures.success_high,
        mean_s: figures.mean_s,
        std_s: figures.std_s,
        least_s: time.steps().first().map(|step| step.at),
        lower_quartile_s: time.quantile(0.25),
        median_s: time.median(),
        median_low_s: median_of_times.map(|(low, _)| low),
        median_high_s: median_of_times.and_then(|(_, high)| high),
        upper_quartile_s: time.quantile(0.75),
        greatest_s: time.steps().last().map(|step| step.at),
        restricted_mean_s: restricted_mean.map(|mean| mean.mean),
        restricted_mean_error_s: restricted_mean.and_then(|mean| mean.standard_error),
        restricted_to_s,
        median_iterations: iterations.median(),
        median_iterations_low: median_of_iterations.map(|(low, _)| low),
        median_iterations_high: median_of_iterations.and_then(|(_, high)| high),
        outcomes,
        iterations: told(of_solved(|record| Some(record.statistics.iterations as f64))),
        nodes: told(of_solved(|record| Some(record.statistics.nodes as f64))),
        path_length: of_solved(|record| record.path_length),
        clearance_m: of_solved(|record| record.clearance_m),
        grasp_score: of_solved(|record| record.grasp_score),
        memory_bytes: FiveNumbers::of(
            runs.iter().filter_map(|run| run.record.memory_bytes).map(|bytes| bytes as f64),
        )
        // Zero means that all searches reused memory of earlier ones, so that nothing was measured.
        .filter(|spread| spread.greatest > 0.0),
    }
}

/// Returns counts, or `None` if all are zero: their planner does not report them.
fn told(counts: Option<FiveNumbers>) -> Option<FiveNumbers> {
    counts.filter(|counts| counts.greatest > 0.0)
}

/// Returns the time limit, or the longest follow-up if the iteration limit ended all runs before.
pub fn horizon_s(curve: &KaplanMeier, limit_s: f64) -> f64 {
    if curve.restricted_mean(limit_s).is_some() { limit_s } else { curve.last() }
}
