//! Time of one batch of verdicts on 10⁶ uniform random configurations, with a digest of the verdicts:
//! `cargo run --release -p cranny-measure --bin batch_verdicts -- SCENARIO`. `benchmarks/cpp_is_free.py` compares it with C++.

use std::time::Instant;

use cranny_collision::Margins;
use cranny_scenario::{OpenOptions, Scenario};
use cranny_spatial::Stream;

/// Configurations of the batch.
const COUNT: usize = 1_000_000;

fn main() {
    let id = std::env::args().nth(1).expect("a scenario");
    let scenario = Scenario::open(&id, &OpenOptions::default()).expect("a scenario");
    let problem = scenario.problem(Margins::default()).expect("a problem");
    let cell = problem.cell().expect("the exact criterion is the default");
    let mut random = Stream::new(0, 0);
    let q: Vec<f64> = (0..COUNT).flat_map(|_| scenario.robot.random_configuration(&mut random)).collect();
    let (mut scratch, mut verdicts) = (cell.scratch(), Vec::new());
    // The first round warms caches and pages.
    cell.are_free(&q, &mut scratch, &mut verdicts);
    let begin = Instant::now();
    cell.are_free(&q, &mut scratch, &mut verdicts);
    let seconds = begin.elapsed().as_secs_f64();
    // FNV-1a, 64 bits.
    let mix = |digest: u64, free: &bool| (digest ^ u64::from(*free)).wrapping_mul(0x100_0000_01b3);
    let digest = verdicts.iter().fold(0xcbf2_9ce4_8422_2325, mix);
    let free = verdicts.iter().filter(|free| **free).count();
    println!("{seconds:.6} {free} {digest:016x}");
}
