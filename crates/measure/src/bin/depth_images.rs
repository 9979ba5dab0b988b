//! Times depth images and point clouds: `cargo run --release -p cranny-measure --bin depth_images`.
//!
//! For each of the paper's twenty tasks: an exact render and a noisy measurement of 320 × 240 pixels from the first default camera,
//! with the robot at its start, and the choice of four cameras. Then the filter by voxels of 10⁵ points of these scenes.

use std::hint::black_box;
use std::time::Instant;

use cranny_scenario::{OpenOptions, Scenario, ScenarioError, catalogue};
use cranny_sense::{Noise, PointCloud, sample_surfaces};

fn main() -> Result<(), ScenarioError> {
    println!("{:>4} {:>10} {:>11} {:>11}", "id", "render ms", "measure ms", "cameras ms");
    let mut renders_ms = Vec::new();
    for entry in catalogue() {
        let id = entry.id;
        let scenario = Scenario::open(id, &OpenOptions::default())?;
        let scene = scenario.sensed()?;
        let begin = Instant::now();
        let placed = scenario.default_cameras(&scene, 4)?.swap_remove(0);
        let cameras_ms = begin.elapsed().as_secs_f64() * 1e3;
        let render_ms = least_ms(|| drop(black_box(scene.render(&placed.camera))));
        let mut fault = None;
        let measure_ms = least_ms(|| {
            fault = scene.measure(&placed.camera, &placed.sensor, &Noise::default()).err();
        });
        if let Some(fault) = fault {
            return Err(fault.into());
        }
        println!("{id:>4} {render_ms:>10.2} {measure_ms:>11.2} {cameras_ms:>11.1}");
        renders_ms.push(render_ms);
    }
    renders_ms.sort_by(f64::total_cmp);
    println!(
        "render: median {:.2} ms, greatest {:.2} ms",
        renders_ms[renders_ms.len() / 2],
        renders_ms[renders_ms.len() - 1]
    );
    let scenario = Scenario::open("011", &OpenOptions::default())?;
    let parts = scenario.world.bodies().iter().flat_map(|body| &body.parts);
    let solids = parts.map(|part| (part.world_from_solid, &part.solid));
    let cloud: PointCloud = sample_surfaces(solids, 100_000, 1)?;
    for side_m in [0.002, 0.005, 0.01, 0.02] {
        let kept = cloud.thinned(side_m)?.points.len();
        let ms = least_ms(|| drop(black_box(cloud.thinned(side_m))));
        println!("100000 points, voxels of {side_m} m: {ms:.2} ms, {kept} kept");
    }
    Ok(())
}

/// Returns the least time of nine runs, in milliseconds.
fn least_ms(mut work: impl FnMut()) -> f64 {
    let time = |_| {
        let begin = Instant::now();
        work();
        begin.elapsed().as_secs_f64() * 1e3
    };
    (0..9).map(time).fold(f64::INFINITY, f64::min)
}
