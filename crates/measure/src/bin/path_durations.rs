//! Compares the delivered paths of a campaign by length and by duration:
//! `cargo run --release -p cranny-measure --bin path_durations -- RESULTS`.
//!
//! The duration is that of the time-optimal trajectory which stops at way points, under the limits of the robot in the built-in
//! scenario of the same id; the released robot states no acceleration limits. For each planner:
//! the number of scenarios in which it solved a trial, and the medians over these scenarios of its median length and duration
//! as multiples of the least of all planners in that scenario. Each scenario has the same weight.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;

use cranny_bench::{Results, TrialOutcome};
use cranny_path::{MotionLimits, TimingMethod, Trajectory, path_length};
use cranny_scenario::{OpenOptions, Scenario};

/// Lengths and durations (s) of one planner in one scenario.
type Measured = [Vec<f64>; 2];

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [results] = &words[..] else { return Err("usage: path_durations RESULTS".into()) };
    let results = Results::open(Path::new(results))?;
    let mut limits: BTreeMap<String, MotionLimits> = BTreeMap::new();
    let mut measured: BTreeMap<String, BTreeMap<String, Measured>> = BTreeMap::new();
    for stored in results.trials()? {
        let trial = &stored.record.trial;
        if stored.record.outcome != TrialOutcome::Solved {
            continue;
        }
        if !limits.contains_key(&trial.scenario) {
            let scenario = Scenario::open(&trial.scenario, &OpenOptions::default())?;
            let of_robot = MotionLimits::of(&scenario.robot, TimingMethod::TimeOptimal)?;
            limits.insert(trial.scenario.clone(), of_robot);
        }
        let path = results.path_of(stored.id)?;
        let duration_s = Trajectory::along(&path, &limits[&trial.scenario])?.duration_s();
        let of_planner = measured.entry(trial.planner.clone()).or_default();
        let [lengths, durations] = of_planner.entry(trial.scenario.clone()).or_default();
        lengths.push(path_length(&path));
        durations.push(duration_s);
    }
    let medians: BTreeMap<&str, BTreeMap<&str, [f64; 2]>> = measured
        .iter()
        .map(|(planner, scenarios)| {
            let of_scenarios = scenarios
                .iter()
                .map(|(scenario, values)| (scenario.as_str(), values.each_ref().map(|of| median(of.clone()))))
                .collect();
            (planner.as_str(), of_scenarios)
        })
        .collect();
    println!("| planner | scenarios | length / least | duration / least |\n|---|---|---|---|");
    for (planner, scenarios) in &medians {
        let ratios = [0, 1].map(|which| {
            let least = |scenario: &str| {
                let all = medians.values().filter_map(|others| others.get(scenario));
                all.map(|both| both[which]).fold(f64::INFINITY, f64::min)
            };
            median(scenarios.iter().map(|(scenario, both)| both[which] / least(scenario)).collect())
        });
        println!("| `{planner}` | {} | {:.2} | {:.2} |", scenarios.len(), ratios[0], ratios[1]);
    }
    Ok(())
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let count = values.len();
    0.5 * (values[(count - 1) / 2] + values[count / 2])
}
