use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::report::{Configuration, Names, ScenarioClass, SummarySource};
use crate::{BenchError, StoredTrial, TrialOutcome};

/// Benchmark log of OMPL, which the statistics script of the `ompl` Python package converts to a database for Planner Arena.
///
/// A log contains one experiment. A failed run has no length and no clearance, and its time is the time spent; seeds are those
/// of the trials.
///
/// Source: `readBenchmarkLog` of `ompl/_benchmark_statistics.py`, OMPL 2.0.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OmplLog {
    /// Name of the experiment: small letters, digits, dots and hyphens.
    pub name: String,
    /// Text of the log.
    pub text: String,
}

/// Names of the values of `status`, 0 to 9, as in OMPL's own logs.
const STATUS: &str = "status|Unknown status|Invalid start|Invalid goal|Unrecognized goal type|Timeout|\
                      Approximate solution|Exact solution|Crash|Unknown status|Unknown status";

/// Properties of each run, with their types.
const PROPERTIES: [&str; 14] = [
    "time REAL",
    "memory REAL",
    "status ENUM",
    "solved BOOLEAN",
    "solution length REAL",
    "solution clearance REAL",
    "correct solution BOOLEAN",
    "graph states INTEGER",
    "iterations INTEGER",
    "collision checks INTEGER",
    "ik attempts INTEGER",
    "grasp score REAL",
    "goal INTEGER",
    "seed INTEGER",
];

/// Bytes in an MB of OMPL, whose logs are compared with these; an MB of Cranny's own is [`crate::MEGABYTE`].
const MEBIBYTE: f64 = (1_u64 << 20) as f64;

/// Content of an experiment: all trials, or those of one scenario under one criterion.
struct Experiment<'a> {
    name: String,
    /// Names and values of its properties, of type `VARCHAR(512)` or `REAL`.
    properties: Vec<(&'static str, &'static str, String)>,
    planners: Vec<(String, &'a Configuration, Vec<&'a StoredTrial>)>,
}

impl OmplLog {
    /// Converts all trials to one experiment. With several scenarios or criteria, each planner appears once for each, as
    /// `planner @ scenario`.
    ///
    /// # Errors
    /// [`BenchError::NoTrials`].
    pub fn of_all(source: &SummarySource) -> Result<Self, BenchError> {
        let grouped = grouped(source)?;
        let names = Names::of(grouped.keys());
        let experiments = experiments(&grouped, &names);
        let name = match &experiments[..] {
            [only] => only.name.clone(),
            _ => "cranny".to_owned(),
        };
        let several = experiments.len() > 1;
        let properties = if several { Vec::new() } else { experiments[0].properties.clone() };
        let mut planners = Vec::new();
        for (planner, configuration, runs) in
            experiments.into_iter().flat_map(|experiment| experiment.planners)
        {
            let name = if several {
                format!("{planner} @ {} {}", names.scenario(configuration), configuration.criterion)
            } else {
                planner
            };
            planners.push((name, configuration, runs));
        }
        Ok(log(&Experiment { name, properties, planners }, source))
    }

    /// Converts the trials to one experiment for each scenario and criterion, which suits Planner Arena.
    ///
    /// # Errors
    /// [`BenchError::NoTrials`].
    pub fn of_each(source: &SummarySource) -> Result<Vec<Self>, BenchError> {
        let grouped = grouped(source)?;
        let names = Names::of(grouped.keys());
        Ok(experiments(&grouped, &names).iter().map(|experiment| log(experiment, source)).collect())
    }
}

fn grouped<'a>(
    source: &SummarySource<'a>,
) -> Result<BTreeMap<Configuration, Vec<&'a StoredTrial>>, BenchError> {
    if source.trials.is_empty() {
        return Err(BenchError::NoTrials { results: source.results.to_owned() });
    }
    let mut grouped: BTreeMap<Configuration, Vec<&StoredTrial>> = BTreeMap::new();
    for trial in source.trials {
        grouped.entry(Configuration::of(&trial.record.trial)).or_default().push(trial);
    }
    for runs in grouped.values_mut() {
        runs.sort_by_key(|run| run.id);
    }
    Ok(grouped)
}

fn experiments<'a>(
    grouped: &'a BTreeMap<Configuration, Vec<&'a StoredTrial>>,
    names: &Names,
) -> Vec<Experiment<'a>> {
    let mut experiments: BTreeMap<(&str, &str), Experiment> = BTreeMap::new();
    for (configuration, runs) in grouped {
        let scenario = names.scenario(configuration);
        let experiment =
            experiments.entry((configuration.criterion, scenario)).or_insert_with(|| Experiment {
                name: word(&format!("{scenario}-{}", configuration.criterion)),
                properties: properties(configuration),
                planners: Vec::new(),
            });
        let name = names.planner(configuration).to_owned();
        experiment.planners.push((name, configuration, runs.clone()));
    }
    experiments.into_values().collect()
}

/// Returns the problem parameters for Planner Arena.
fn properties(configuration: &Configuration) -> Vec<(&'static str, &'static str, String)> {
    let place = ScenarioClass::of(&configuration.scenario);
    let mut properties = vec![
        ("scenario", "VARCHAR(512)", configuration.scenario.clone()),
        ("environment", "VARCHAR(512)", place.environment),
        ("criterion", "VARCHAR(512)", configuration.criterion.to_owned()),
    ];
    if let Some(dial_m) = place.dial_m {
        properties.push(("dial_m", "REAL", dial_m.to_string()));
    }
    properties
}

fn log(experiment: &Experiment, source: &SummarySource) -> OmplLog {
    let trials = || experiment.planners.iter().flat_map(|(_, _, runs)| runs.iter());
    let run = trials().next().and_then(|trial| source.runs.iter().find(|run| run.id == trial.run));
    let information = run.map(|run| &run.information);
    let limit_s = trials().map(|trial| trial.record.trial.time_limit_s).fold(0.0, f64::max);
    let spent_s: f64 = trials().map(|trial| trial.record.statistics.planning_time_s).sum();
    let seed = trials().map(|trial| trial.record.trial.seed).min().unwrap_or(0);
    let most = experiment.planners.iter().map(|(_, _, runs)| runs.len()).max().unwrap_or(0);

    // 0 stands for an unknown limit.
    let memory_bytes = information.and_then(|information| information.memory_limit_bytes).unwrap_or(0);
    let memory_mb = memory_bytes as f64 / MEBIBYTE;
    let mut text = format!("Cranny version {}\n", env!("CARGO_PKG_VERSION"));
    let _ = writeln!(text, "Experiment {}", experiment.name);
    let _ = writeln!(text, "{} experiment properties", experiment.properties.len());
    for (name, kind, value) in &experiment.properties {
        let _ = writeln!(text, "{name} {kind} = {}", line(value));
    }
    let machine = information.map_or("unknown", |information| &information.machine);
    let _ = writeln!(text, "Running on {}", word(machine));
    let _ = writeln!(text, "Starting at {}", run.map_or("unknown", |run| &run.began));
    let command = information.map_or("unknown", |information| &information.command);
    let processor = information.map_or("unknown", |information| &information.processor);
    for block in [format!("results {}\ncommand {}", line(source.results), line(command)), line(processor)] {
        let _ = writeln!(text, "<<<|\n{block}\n|>>>");
    }
    let _ = writeln!(text, "{seed} is the random seed\n{limit_s} seconds per run\n{memory_mb} MB per run");
    let _ = writeln!(text, "{most} runs per planner\n{spent_s} seconds spent to collect the data");
    let _ = writeln!(text, "1 enum type\n{STATUS}\n{} planners", experiment.planners.len());
    for (name, configuration, runs) in &experiment.planners {
        planner(&mut text, name, configuration, runs);
    }
    OmplLog { name: experiment.name.clone(), text }
}

fn planner(text: &mut String, name: &str, configuration: &Configuration, runs: &[&StoredTrial]) {
    let mut settings = vec![
        ("planner".to_owned(), configuration.planner.clone()),
        ("criterion".to_owned(), configuration.criterion.to_owned()),
        ("time limit".to_owned(), configuration.time_limit_s().to_string()),
    ];
    if let Some(iterations) = configuration.iteration_limit {
        settings.push(("iteration limit".to_owned(), iterations.to_string()));
    }
    match serde_json::from_str(&configuration.settings) {
        Ok(serde_json::Value::Object(own)) => {
            settings.extend(own.into_iter().map(|(key, value)| (key, value.to_string())));
        }
        _ => settings.push(("settings".to_owned(), configuration.settings.clone())),
    }
    let _ = writeln!(text, "{}\n{} common properties", line(name), settings.len());
    for (key, value) in &settings {
        let _ = writeln!(text, "{} = {}", line(key), line(value));
    }
    let _ = writeln!(text, "{} properties for each run\n{}", PROPERTIES.len(), PROPERTIES.join("\n"));
    let _ = writeln!(text, "{} runs", runs.len());
    for run in runs {
        let _ = writeln!(text, "{}; ", values(run).join("; "));
    }
    text.push_str(".\n");
}

/// Returns the values in the order of [`PROPERTIES`]; an unknown value is empty.
fn values(run: &StoredTrial) -> [String; 14] {
    let record = &run.record;
    let statistics = &record.statistics;
    let real = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
    let flag = |value: bool| u8::from(value).to_string();
    let correct = match record.outcome {
        TrialOutcome::Solved => "1",
        TrialOutcome::Rejected | TrialOutcome::ClaimedNotProven => "0",
        _ => "",
    };
    [
        statistics.planning_time_s.to_string(),
        real(record.memory_bytes.map(|bytes| bytes as f64 / MEBIBYTE)),
        status(record.outcome).to_string(),
        flag(record.is_solved()),
        real(record.path_length),
        real(record.clearance_m),
        correct.to_owned(),
        statistics.nodes.to_string(),
        statistics.iterations.to_string(),
        statistics.collision_checks.to_string(),
        statistics.ik_attempts.to_string(),
        real(record.grasp_score),
        record.trial.goal.map_or_else(String::new, |goal| goal.to_string()),
        record.trial.seed.to_string(),
    ]
}

/// Returns the corresponding value of OMPL's `PlannerStatus`.
fn status(outcome: TrialOutcome) -> u8 {
    match outcome {
        TrialOutcome::Rejected
        | TrialOutcome::ClaimedNotProven
        | TrialOutcome::Garbled
        | TrialOutcome::Undecided
        | TrialOutcome::GaveUp => 0,
        TrialOutcome::StartInvalid => 1,
        TrialOutcome::GoalsInvalid => 2,
        TrialOutcome::BudgetExhausted => 4,
        TrialOutcome::Solved => 6,
        TrialOutcome::Crashed => 7,
        TrialOutcome::Hung | TrialOutcome::OutOfMemory | TrialOutcome::Cancelled | TrialOutcome::Killed => 8,
        TrialOutcome::NoReachableGrasp => 9,
    }
}

/// Converts to one line without separators of fields or entries, which the format cannot escape.
fn line(text: &str) -> String {
    let text = text.replace(|c: char| c.is_control(), " ").replace("; ", ", ").replace(" = ", "=");
    // Bars are marks of entries.
    let text = text.replace('|', "/");
    if text.trim().is_empty() { "none".to_owned() } else { text }
}

/// Converts to one word: the parser keeps the last of several.
fn word(text: &str) -> String {
    let letter = |c: char| if c.is_ascii_alphanumeric() || c == '.' { c.to_ascii_lowercase() } else { '-' };
    let word: String = text.chars().map(letter).collect();
    let parts: Vec<&str> = word.split('-').filter(|part| !part.is_empty()).collect();
    if parts.is_empty() { "unknown".to_owned() } else { parts.join("-") }
}
