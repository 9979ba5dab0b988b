//! Time per check, per proof and per plan against the number of obstacles, as a table on standard output and as a plot;
//! one thread.
//!
//! `cargo run --release -p cranny-measure --bin scaling -- PLOT.svg [BOXES…]`

mod chart;
mod clutter;

use std::hint::black_box;
use std::time::{Duration, Instant};

use cranny_collision::{Cell, Scratch};
use cranny_path::audit;
use cranny_plan::{Budget, Outcome, Unobserved};
use cranny_robot::between;
use cranny_spatial::Stream;
use cranny_task::Problem;

use crate::chart::{Panel, Series};
use crate::clutter::Clutter;

/// Default numbers of boxes.
const BOXES: [usize; 5] = [10, 32, 100, 316, 1000];

/// Number of worlds for each number of boxes.
const WORLDS: u64 = 5;

/// Number of plans in each world, each with its own seed.
const SEEDS: u64 = 10;

/// Number of uniform random configurations checked in each world.
const CONFIGURATIONS: usize = 8000;

/// Number of rounds, of which the fastest counts: other programs can only slow them down.
const ROUNDS: usize = 5;

/// Length of the proven edges, as a share of the edge from a free configuration to a random one.
const EDGE: f64 = 0.05;

fn main() {
    let mut arguments = std::env::args().skip(1);
    let Some(plot) = arguments.next() else {
        eprintln!("usage: scaling PLOT.svg [BOXES…]");
        std::process::exit(2);
    };
    let mut counts: Vec<usize> = arguments.map(|count| count.parse().expect("a number of boxes")).collect();
    if counts.is_empty() {
        counts = BOXES.to_vec();
    }
    let most = counts.iter().copied().max().unwrap_or_default();
    let worlds: Vec<Clutter> = (0..WORLDS).map(|seed| Clutter::draw(seed, most)).collect();
    println!(
        "| boxes | free | check, one at a time µs | in batches µs | free ones one at a time µs | free ones in batches µs | proof of an edge µs | solved | median plan ms | p90 ms |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    let rows: Vec<Row> = counts.iter().map(|count| measured(&worlds, *count)).collect();
    let points = |value: fn(&Row) -> f64| rows.iter().map(|row| (row.boxes as f64, value(row))).collect();
    let series = |name, value| Series { name, points: points(value) };
    let checks = Panel {
        title: "Checks and proofs",
        unit: "µs",
        series: vec![
            series("proof of an edge", |row| row.proof_us),
            series("check, one at a time", |row| row.single_us),
            series("check, in batches", |row| row.batch_us),
            series("in batches, free ones", |row| row.free_batch_us),
        ],
    };
    let plans = Panel {
        title: "Plans, proof included",
        unit: "ms",
        series: vec![
            series("90th percentile", |row| row.plan_p90_ms),
            series("median", |row| row.plan_median_ms),
        ],
    };
    std::fs::write(&plot, chart::svg(&[checks, plans])).expect("a file that can be written");
}

/// Measurements for one number of boxes: medians over worlds and plans.
struct Row {
    boxes: usize,
    single_us: f64,
    batch_us: f64,
    free_batch_us: f64,
    proof_us: f64,
    plan_median_ms: f64,
    plan_p90_ms: f64,
}

fn measured(worlds: &[Clutter], boxes: usize) -> Row {
    let [mut shares, mut singles, mut batches, mut free_singles, mut free_batches, mut proofs, mut plans] =
        [const { Vec::new() }; 7];
    let (mut solved, mut verified) = (0, 0);
    for world in worlds {
        let problem = world.problem(boxes);
        let cell = problem.cell().expect("the criterion is exact");
        let (mut scratch, mut verdicts) = (cell.scratch(), Vec::new());
        let all = random_configurations(cell, CONFIGURATIONS);
        cell.are_free(&all, &mut scratch, &mut verdicts);
        let dof = problem.robot().dof();
        let free: Vec<f64> =
            all.chunks(dof).zip(&verdicts).filter(|(_, free)| **free).flat_map(|(q, _)| q.to_vec()).collect();
        shares.push(free.len() as f64 / all.len() as f64);
        singles.push(best_us(all.len() / dof, || one_at_a_time(cell, &all, &mut scratch)));
        batches.push(best_us(all.len() / dof, || cell.are_free(&all, &mut scratch, &mut verdicts)));
        if !free.is_empty() {
            free_singles.push(best_us(free.len() / dof, || one_at_a_time(cell, &free, &mut scratch)));
            free_batches
                .push(best_us(free.len() / dof, || cell.are_free(&free, &mut scratch, &mut verdicts)));
        }
        proofs.extend(proof_us(cell, &free, &mut scratch));
        for seed in 0..SEEDS {
            let (time_ms, outcome) = planned(&problem, seed);
            plans.push(time_ms);
            solved += u64::from(outcome.is_some());
            verified += u64::from(outcome == Some(true));
        }
    }
    assert_eq!(solved, verified, "a plan was refuted");
    let row = Row {
        boxes,
        single_us: quantile(&mut singles, 0.5),
        batch_us: quantile(&mut batches, 0.5),
        free_batch_us: quantile(&mut free_batches, 0.5),
        proof_us: quantile(&mut proofs, 0.5),
        plan_median_ms: quantile(&mut plans, 0.5),
        plan_p90_ms: quantile(&mut plans, 0.9),
    };
    println!(
        "| {boxes} | {:.0} % | {:.2} | {:.2} | {:.2} | {:.2} | {:.1} | {solved}/{} | {:.1} | {:.1} |",
        100.0 * quantile(&mut shares, 0.5),
        row.single_us,
        row.batch_us,
        quantile(&mut free_singles, 0.5),
        row.free_batch_us,
        row.proof_us,
        plans.len(),
        row.plan_median_ms,
        row.plan_p90_ms,
    );
    row
}

fn random_configurations(cell: &Cell, count: usize) -> Vec<f64> {
    let mut random = Stream::new(0, 0);
    (0..count).flat_map(|_| cell.robot().random_configuration(&mut random)).collect()
}

fn one_at_a_time(cell: &Cell, configurations: &[f64], scratch: &mut Scratch) {
    for q in configurations.chunks(cell.robot().dof()) {
        black_box(cell.is_free(q, scratch));
    }
}

/// Returns the microseconds per proof of an edge with free ends; `None` if there are no such edges.
fn proof_us(cell: &Cell, free: &[f64], scratch: &mut Scratch) -> Option<f64> {
    let dof = cell.robot().dof();
    let towards = random_configurations(cell, CONFIGURATIONS);
    let edges: Vec<(&[f64], Vec<f64>)> = free
        .chunks(dof)
        .zip(towards.chunks(dof).rev())
        .map(|(a, target)| (a, between(a, target, EDGE).collect()))
        .filter(|(_, b): &(_, Vec<f64>)| cell.is_free(b, scratch))
        .take(1000)
        .collect();
    let prove_all = || {
        for (a, b) in &edges {
            black_box(cell.motion_is_free(a, b, scratch));
        }
    };
    (!edges.is_empty()).then(|| best_us(edges.len(), prove_all))
}

/// Returns the planning time (ms), and true if the plan is verified, `None` if there is no plan.
fn planned(problem: &Problem, seed: u64) -> (f64, Option<bool>) {
    let planner = cranny_plan::default_planner(problem);
    let budget = Budget { time: Duration::from_secs(10), ..Budget::default() };
    let report = planner.plan(problem, &budget, seed, &mut Unobserved).expect("a good problem");
    let is_valid = || audit(problem, &report.path).expect("a path of this robot").valid;
    (report.statistics.planning_time_s * 1e3, (report.outcome == Outcome::Solved).then(is_valid))
}

fn best_us(count: usize, mut action: impl FnMut()) -> f64 {
    let times = (0..ROUNDS).map(|_| {
        let begin = Instant::now();
        action();
        begin.elapsed().as_secs_f64()
    });
    times.fold(f64::INFINITY, f64::min) / count as f64 * 1e6
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
