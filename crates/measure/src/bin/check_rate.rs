//! Exact checks per second of uniform random configurations, singly and in batches:
//! `cargo run --release -p cranny-measure --bin check_rate -- SCENARIO…`

use std::time::Instant;

use cranny_collision::Margins;
use cranny_scenario::{OpenOptions, Scenario};
use cranny_spatial::Stream;

fn main() {
    for id in std::env::args().skip(1) {
        let scenario = Scenario::open(&id, &OpenOptions::default()).expect("a scenario");
        let begin = Instant::now();
        let problem = scenario.problem(Margins::default()).expect("a problem");
        let preparation_ms = begin.elapsed().as_secs_f64() * 1e3;
        let cell = problem.cell().expect("the exact criterion is the default");
        let mut random = Stream::new(0, 0);
        const COUNT: usize = 100_000;
        let limits = problem.robot().limits();
        let configurations: Vec<f64> = (0..COUNT * limits.len())
            .map(|index| {
                let l = &limits[index % limits.len()];
                random.uniform_between(l.lower, l.upper)
            })
            .collect();
        let mut scratch = cell.scratch();
        let begin = Instant::now();
        let single: Vec<bool> =
            configurations.chunks(limits.len()).map(|q| cell.is_free(q, &mut scratch)).collect();
        let single_rate = COUNT as f64 / begin.elapsed().as_secs_f64();
        let mut batch = Vec::new();
        let mut batch_rate = 0.0_f64;
        /// Number of rounds, of which the fastest is reported: other programs share the machine.
        const ROUNDS: usize = 20;
        for _ in 0..ROUNDS {
            let begin = Instant::now();
            cell.are_free(&configurations, &mut scratch, &mut batch);
            batch_rate = batch_rate.max(COUNT as f64 / begin.elapsed().as_secs_f64());
        }
        let free = single.iter().filter(|free| **free).count();
        let differ = single.iter().zip(&batch).filter(|(a, b)| a != b).count();
        println!(
            "{id}: {single_rate:.0} verdicts/s one at a time, {batch_rate:.0} in batches; {free} of {COUNT} free, \
             {differ} differ; {preparation_ms:.0} ms to prepare"
        );
    }
}
