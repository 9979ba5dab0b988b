//! Whole plans of the default planner, inverse kinematics and proof included.

mod task;

use std::time::Duration;

use cranny_plan::{Budget, Unobserved, default_planner};
use criterion::{BenchmarkId, Criterion, SamplingMode, Throughput, criterion_group, criterion_main};

/// Number of plans in one measurement: the duration of one depends on its seed.
const SEEDS: u64 = 4;

fn plans(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("plans");
    group.sampling_mode(SamplingMode::Flat).throughput(Throughput::Elements(SEEDS));
    for (id, problem) in task::all() {
        let planner = default_planner(&problem);
        group.bench_function(BenchmarkId::new("4 seeds", &id), |bencher| {
            bencher.iter(|| {
                for seed in 0..SEEDS {
                    let report = planner.plan(&problem, &Budget::default(), seed, &mut Unobserved);
                    assert!(!report.expect("a good problem").path.is_empty(), "{id}, seed {seed}");
                }
            });
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(2));
    targets = plans
}
criterion_main!(benches);
