//! Exact verdicts one at a time and in batches, and proofs of edges.

mod task;

use std::hint::black_box;
use std::time::Duration;

use cranny_robot::between;
use cranny_spatial::Stream;
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};

/// Number of uniform random configurations that are checked.
const CONFIGURATIONS: usize = 2048;

/// Length of an edge as a share of the distance between two random configurations: about a step of a tree search.
const EDGE: f64 = 0.05;

fn checks(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("checks");
    for (id, problem) in task::all() {
        let cell = problem.cell().expect("the default criterion");
        let mut random = Stream::new(0, 0);
        let configurations: Vec<f64> =
            (0..CONFIGURATIONS).flat_map(|_| cell.robot().random_configuration(&mut random)).collect();
        let dof = problem.robot().dof();
        let (mut scratch, mut verdicts) = (cell.scratch(), Vec::new());

        group.throughput(Throughput::Elements(CONFIGURATIONS as u64));
        group.bench_function(BenchmarkId::new("uniform configurations one at a time", &id), |bencher| {
            bencher.iter(|| {
                configurations.chunks(dof).filter(|q| cell.is_free(black_box(q), &mut scratch)).count()
            });
        });
        group.bench_function(BenchmarkId::new("uniform configurations in batches", &id), |bencher| {
            bencher.iter(|| cell.are_free(black_box(&configurations), &mut scratch, &mut verdicts));
        });

        let rows: Vec<&[f64]> = configurations.chunks(dof).collect();
        let edges: Vec<(&[f64], Vec<f64>)> = rows
            .windows(2)
            .map(|pair| (pair[0], between(pair[0], pair[1], EDGE).collect()))
            .filter(|(a, b): &(&[f64], Vec<f64>)| {
                cell.is_free(a, &mut scratch) && cell.is_free(b, &mut scratch)
            })
            .collect();
        group.throughput(Throughput::Elements(edges.len() as u64));
        group.bench_function(BenchmarkId::new("proofs of edges with free ends", &id), |bencher| {
            bencher.iter(|| {
                edges.iter().filter(|(a, b)| cell.motion_is_free(a, b, &mut scratch).is_proven()).count()
            });
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(2));
    targets = checks
}
criterion_main!(benches);
