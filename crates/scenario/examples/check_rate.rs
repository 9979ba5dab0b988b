//! Exact verdicts a second on uniform random configurations:
//! `cargo run --release -p cranny-scenario --example check_rate -- SCENARIO…`

use std::time::Instant;

use cranny_plan::Validity;
use cranny_scenario::{Demands, OpenOptions, Scenario};
use cranny_spatial::Stream;

fn main() {
    for id in std::env::args().skip(1) {
        let scenario = Scenario::open(&id, &OpenOptions::default()).expect("a scenario");
        let problem = scenario.problem(&Demands::default()).expect("a problem");
        let Validity::Exact(cell) = &problem.validity else { panic!("the exact criterion is the default") };
        let mut random = Stream::new(0, 0);
        let configurations: Vec<Vec<f64>> = (0..20_000)
            .map(|_| {
                let draw = |l: &cranny_robot::JointLimits| random.uniform_between(l.lower, l.upper);
                problem.robot.limits().iter().map(draw).collect()
            })
            .collect();
        let mut scratch = cell.scratch();
        let begin = Instant::now();
        let free = configurations.iter().filter(|q| cell.is_free(q, &mut scratch)).count();
        let rate = configurations.len() as f64 / begin.elapsed().as_secs_f64();
        println!("{id}: {rate:.0} verdicts/s, {free} of {} free", configurations.len());
    }
}
