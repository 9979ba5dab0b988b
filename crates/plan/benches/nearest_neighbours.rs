//! Benchmark of one addition to and one query of nearest neighbours, with uniform random points in nine dimensions.

use std::hint::black_box;
use std::time::Duration;

use cranny_plan::NearestNeighbours;
use cranny_spatial::Stream;
use criterion::{BatchSize, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};

const DIMENSIONS: usize = 9;

/// Number of additions and queries per copy of a tree, few enough to keep its size.
const CALLS: usize = 64;

fn grow(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("nearest neighbours");
    group.throughput(Throughput::Elements(CALLS as u64));
    for size in [1_000, 10_000, 100_000] {
        let mut random = Stream::new(0, 0);
        let mut point =
            || -> [f64; DIMENSIONS] { std::array::from_fn(|_| random.uniform_between(-1.0, 1.0)) };
        let mut tree = NearestNeighbours::new(DIMENSIONS);
        for _ in 0..size {
            tree.add(&point());
        }
        let points: Vec<[f64; DIMENSIONS]> = (0..CALLS).map(|_| point()).collect();
        let name = format!("{CALLS} additions and questions, points");
        group.bench_function(BenchmarkId::new(name, size), |bencher| {
            let add_and_ask = |tree: &mut NearestNeighbours| {
                for point in &points {
                    black_box(tree.nearest(point));
                    tree.add(point);
                }
            };
            bencher.iter_batched_ref(|| tree.clone(), add_and_ask, BatchSize::PerIteration);
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(2));
    targets = grow
}
criterion_main!(benches);
