//! Times the queries of a cloud of points: `cargo run --release -p cranny-measure --bin cloud_queries`.
//!
//! The points lie on the walls of a room of random boxes, as a depth camera sees them. A query asks whether a ball, of the size of
//! the balls of a robot (1 to 8 cm), meets a point. "free" and "hit" are the queries with these answers. The last lines are the filter of
//! 10⁵ points by voxels.

use std::time::Instant;

use cranny_sense::PointCloud;
use cranny_shape::BoxUnion;
use cranny_spatial::{Stream, simd_level};
use fearless_simd::dispatch;

fn main() {
    println!(
        "{:>9} {:>10} {:>8} | {:>9} {:>9} {:>9}",
        "points", "build ms", "hits", "ns/query", "free", "hit"
    );
    for count in [1_000, 5_000, 20_000, 100_000, 1_000_000] {
        let mut random = Stream::new(count, 0);
        let points: Vec<[f32; 3]> = (0..count).map(|_| on_a_box(&mut random)).collect();
        let begin = Instant::now();
        let Ok(cloud) = BoxUnion::of_points(&points, 0.005) else { continue };
        let build_ms = begin.elapsed().as_secs_f64() * 1e3;
        let balls: Vec<([f32; 3], f32)> = (0..200_000)
            .map(|_| {
                (
                    [0; 3].map(|_| narrow(random.uniform_between(-1.0, 1.0))),
                    narrow(random.uniform_between(0.01, 0.08)),
                )
            })
            .collect();
        let is_hit: Vec<bool> =
            balls.iter().map(|ball| hits(&cloud, std::slice::from_ref(ball)) > 0).collect();
        let of = |wanted: bool| -> Vec<([f32; 3], f32)> {
            balls.iter().zip(&is_hit).filter(|(_, hit)| **hit == wanted).map(|(ball, _)| *ball).collect()
        };
        let [all, free, hit] = [balls.clone(), of(false), of(true)].map(|balls| {
            let mut least = f64::INFINITY;
            for _ in 0..9 {
                let begin = Instant::now();
                std::hint::black_box(hits(&cloud, &balls));
                least = least.min(begin.elapsed().as_secs_f64());
            }
            1e9 * least / balls.len() as f64
        });
        let share = 100 * is_hit.iter().filter(|hit| **hit).count() / is_hit.len();
        println!("{count:>9} {build_ms:>10.2} {share:>7}% | {all:>9.1} {free:>9.1} {hit:>9.1}");
    }
    let mut random = Stream::new(1, 0);
    let cloud = PointCloud::of((0..100_000).map(|_| on_a_box(&mut random)).collect());
    for side_m in [0.002, 0.005, 0.01, 0.02, 0.05] {
        let (mut least_ms, mut kept) = (f64::INFINITY, 0);
        for _ in 0..21 {
            let begin = Instant::now();
            let thinned = cloud.thinned(side_m);
            least_ms = least_ms.min(begin.elapsed().as_secs_f64() * 1e3);
            kept = thinned.map_or(0, |thinned| thinned.points.len());
        }
        println!("100000 points, voxels of {side_m} m: {least_ms:.2} ms, {kept} kept");
    }
}

fn hits(cloud: &BoxUnion, balls: &[([f32; 3], f32)]) -> usize {
    dispatch!(simd_level(), simd => {
        let mut hits = 0;
        for (center, radius) in balls {
            hits += usize::from(cloud.is_closer(simd, *center, *radius));
        }
        hits
    })
}

/// Returns a point on one of twelve boxes, which fill a room of 2 m.
fn on_a_box(random: &mut Stream) -> [f32; 3] {
    let number = f64::from(u32::try_from(random.index(12)).unwrap_or(0));
    let center =
        [0.7 * libm::sin(number * 1.7), 0.7 * libm::cos(number * 2.9), 0.7 * libm::sin(number * 0.6)];
    let half = [0.1 + 0.02 * number, 0.3, 0.05 + 0.01 * number];
    let face = random.index(6);
    std::array::from_fn(|axis| {
        let place = if face / 2 == axis { [-1.0, 1.0][face % 2] } else { random.uniform_between(-1.0, 1.0) };
        narrow(center[axis] + half[axis] * place)
    })
}

#[allow(clippy::cast_possible_truncation, reason = "single precision is what is meant")]
fn narrow(x: f64) -> f32 {
    x as f32
}
