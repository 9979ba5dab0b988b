//! Times a planner over seeds: for each scenario the number of solved and verified plans, and the median, 95th percentile and
//! maximum of `planning_time_s`, then medians for the path after shortcuts ("apart": distance between its ends, the lower bound
//! on its length); one thread.
//!
//! `cargo run --release -p cranny-measure --bin campaign -- PLANNER SEEDS MARGIN_MM GRASP_MARGIN_MM SCENARIO…`, PLANNER
//! with optional settings, such as `reach:{"detour": 0.8}`.

use std::time::Duration;

use cranny_collision::Margins;
use cranny_path::{ShortcutSettings, audit, path_length, shortcut};
use cranny_plan::{Budget, Outcome, Registry, Unobserved};
use cranny_scenario::{OpenOptions, Scenario};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [planner, seeds, margin, grasp_margin, scenarios @ ..] = &arguments[..] else {
        eprintln!("usage: campaign PLANNER SEEDS MARGIN_MM GRASP_MARGIN_MM SCENARIO…");
        std::process::exit(2);
    };
    let number = |text: &String| text.parse::<f64>().expect("a number of millimetres") / 1000.0;
    let demands =
        Margins { margin_m: number(margin), grasp_margin_m: number(grasp_margin), ..Margins::default() };
    let seeds: u64 = seeds.parse().expect("a number of seeds");
    let (name, settings) = planner.split_once(':').unwrap_or((planner, "{}"));
    let settings = serde_json::from_str(settings).expect("settings of the planner as JSON");
    let planner = Registry::default().planner_with(name, &settings).expect("a planner");
    let budget = Budget { time: Duration::from_secs(10), ..Budget::default() };
    println!(
        "| scenario | solved | verified | median ms | p95 ms | max ms | length | shortened | apart | shortcut ms | clearance mm |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    for id in scenarios {
        let scenario = Scenario::open(id, &OpenOptions::default()).expect("a scenario");
        let problem = scenario.problem(demands).expect("a problem");
        let (mut times, mut lengths, mut clearances) = (Vec::new(), Vec::new(), Vec::new());
        let (mut shortened, mut apart, mut shortcut_times) = (Vec::new(), Vec::new(), Vec::new());
        let (mut solved, mut verified) = (0, 0);
        for seed in 0..seeds {
            let report = planner.plan(&problem, &budget, seed, &mut Unobserved).expect("a good problem");
            times.push(report.statistics.planning_time_s * 1e3);
            if report.outcome == Outcome::Solved {
                solved += 1;
                lengths.push(path_length(&report.path));
                let settings = ShortcutSettings { seed, ..Default::default() };
                let short = shortcut(&problem, &report.path, settings).expect("the criterion is exact");
                shortened.push(path_length(&short.path));
                let ends =
                    [short.path.first(), short.path.last()].map(|end| end.cloned().unwrap_or_default());
                apart.push(path_length(&ends));
                shortcut_times.push(short.time_s * 1e3);
                let verdict = audit(&problem, &short.path).expect("a path of this robot");
                verified += usize::from(verdict.valid);
                clearances.push(verdict.clearance_m.unwrap_or(f64::INFINITY) * 1e3);
            }
        }
        println!(
            "| {} | {solved}/{seeds} | {verified} | {:.1} | {:.1} | {:.1} | {:.2} | {:.2} | {:.2} | {:.1} | {:.2} |",
            scenario.id,
            quantile(&mut times, 0.5),
            quantile(&mut times, 0.95),
            quantile(&mut times, 1.0),
            quantile(&mut lengths, 0.5),
            quantile(&mut shortened, 0.5),
            quantile(&mut apart, 0.5),
            quantile(&mut shortcut_times, 0.5),
            quantile(&mut clearances, 0.5),
        );
    }
}

/// Returns the nearest-rank quantile; NaN for no values.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a count that is not negative and small"
)]
fn quantile(values: &mut [f64], fraction: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let rank = (fraction * values.len() as f64).ceil().max(1.0) as usize;
    values.get(rank - 1).copied().unwrap_or(f64::NAN)
}
