//! Time and memory of merging and reporting large results: makes fictitious ones, and measures one operation on them.
//!
//! ```console
//! $ cargo run --release -p cranny-bench --example scale_results -- make FILE SCENARIOS SETTINGS RUNS [FIRST_SEED]
//! $ cargo run --release -p cranny-bench --example scale_results -- report FILE
//! $ cargo run --release -p cranny-bench --example scale_results -- merge INTO FILE
//! $ cargo run --release -p cranny-bench --example scale_results -- status FILE
//! ```

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use cranny_bench::report::{Enclosure, Summary};
use cranny_bench::{Results, RunInformation, Trial, TrialOutcome, TrialRecord};
use cranny_plan::Statistics;
use cranny_spatial::Stream;
use cranny_task::Criterion;

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let begin = Instant::now();
    let done = match words[..] {
        ["make", file, scenarios, settings, runs] => make(file, [scenarios, settings, runs, "0"])?,
        ["make", file, scenarios, settings, runs, first] => make(file, [scenarios, settings, runs, first])?,
        ["report", file] => {
            let summary = Summary::of_results(&Results::open(file.as_ref())?)?;
            let page = summary.html(&Enclosure::default());
            let (json, csv) = (serde_json::to_string(&summary)?, summary.csv());
            std::fs::write(Path::new(file).with_extension("html"), &page)?;
            format!("page {} B, JSON {} B, CSV {} B", page.len(), json.len(), csv.len())
        }
        ["merge", into, file] => {
            let (_, merged) = Results::merged(into.as_ref(), &[file.into()], false)?;
            format!("{merged:?}")
        }
        ["status", file] => format!("{} planners", Results::glance(file.as_ref())?.len()),
        _ => return Err("give make, report, merge or status with its arguments".into()),
    };
    let seconds = begin.elapsed().as_secs_f64();
    println!("{words:?}: {seconds:.2} s, {}; {done}", most_memory());
    Ok(())
}

/// Writes results of every setting of one planner on every scenario with every seed.
fn make(file: &str, numbers: [&str; 4]) -> Result<String, Box<dyn Error>> {
    let [scenarios, settings, runs, first] = numbers.map(str::parse::<u64>);
    let (scenarios, settings, runs, first) = (scenarios?, settings?, runs?, first?);
    let mut results = Results::create(file.as_ref())?;
    let run = results.begin_run(&RunInformation::here(None, "a measurement", 1))?;
    let mut random = Stream::new(first, 0);
    for seed in first..first + runs {
        for scenario in 0..scenarios {
            for setting in 0..settings {
                let time_s = 0.01 * 1.01_f64.powf(setting as f64) / (1e-3 + random.uniform());
                let is_solved = time_s < 10.0;
                let iterations = 10 + random.index(1000) as u64;
                let record = TrialRecord {
                    trial: Trial {
                        scenario: format!(
                            "{}-{scenario:05}",
                            ["shelf", "table", "gap"][(scenario % 3) as usize]
                        ),
                        scenario_hash: format!("{scenario:064x}"),
                        planner: "planner".to_owned(),
                        settings: format!("{{\"goal_bias\":0.{setting:04},\"step\":0.1}}"),
                        criterion: Criterion::Exact,
                        seed,
                        time_limit_s: 10.0,
                        iteration_limit: None,
                        goal: None,
                    },
                    outcome: if is_solved { TrialOutcome::Solved } else { TrialOutcome::BudgetExhausted },
                    detail: None,
                    statistics: Statistics {
                        iterations,
                        nodes: iterations / 2,
                        planning_time_s: time_s.min(10.0),
                        ..Statistics::default()
                    },
                    path_length: is_solved.then(|| 3.0 + random.uniform()),
                    clearance_m: is_solved.then(|| 0.01 * random.uniform()),
                    grasp: None,
                    grasp_score: is_solved.then(|| random.uniform()),
                    also_solved: None,
                    memory_bytes: Some(1_000_000),
                };
                let path = vec![vec![0.5; 9]; 20];
                results.append(run, &record, if is_solved { &path } else { &[] })?;
            }
        }
    }
    results.end_run(run)?;
    Ok(format!("{} trials", scenarios * settings * runs))
}

/// Returns the peak of the memory of this process, as Linux states it.
fn most_memory() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    peak.map_or_else(|| "memory unknown".to_owned(), |peak| format!("peak {}", peak.trim()))
}
