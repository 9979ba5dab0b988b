//! Time to open each built-in scenario: the minimum and the median of 21 times, in milliseconds.

use std::time::Instant;

use cranny_scenario::{OpenOptions, Scenario, catalogue};

fn main() {
    for entry in catalogue() {
        let mut times_ms: Vec<f64> = (0..21)
            .map(|_| {
                let begin = Instant::now();
                let scenario =
                    Scenario::open(entry.id, &OpenOptions::default()).expect("a built-in scenario");
                assert_eq!(scenario.grasps.len(), 200);
                begin.elapsed().as_secs_f64() * 1e3
            })
            .collect();
        times_ms.sort_by(f64::total_cmp);
        println!("{}  {:.2}  {:.2}", entry.id, times_ms[0], times_ms[10]);
    }
}
