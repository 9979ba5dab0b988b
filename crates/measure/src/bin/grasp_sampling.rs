//! Samples grasps on the scans of the released scenarios and compares them with the released grasps; prints a Markdown table.
//!
//! Usage: `cargo run --release -p cranny-measure --bin grasp_sampling -- $CRANNY_DATA/jogramop [seed]`

use std::path::Path;
use std::time::Instant;

use cranny_grasp::{
    COVERAGE_THRESHOLD, Grasp, SamplerSettings, coverage, covering_subset, farthest_subset, random_subset,
    sample_grasps,
};
use cranny_shape::Surface;
use released_object::{CANDIDATES, Failure, KEPT, ReleasedObject};

#[path = "../../../scenario/tests/released_object.rs"]
mod released_object;

fn main() -> Result<(), Failure> {
    let mut arguments = std::env::args().skip(1);
    let data = arguments.next().ok_or("which folder holds the released data?")?;
    let seed = arguments.next().map_or(Ok(0), |seed| seed.parse())?;
    println!(
        "| object | scenario | 2000: time | 20 000: time | covering 2000 of them: time | **covering** | holdable | \
         farthest | random | without the palm rule |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    for environment in 1..=4 {
        for level in 1..=5 {
            println!("{}", row(Path::new(&data), &format!("0{environment}{level}"), seed)?);
        }
    }
    Ok(())
}

fn row(data: &Path, id: &str, seed: u64) -> Result<String, Failure> {
    let released = ReleasedObject::open(data, id)?;
    let begin = Instant::now();
    let surface = Surface::new(&released.mesh)?;
    let sample = |settings: &SamplerSettings| -> Result<Vec<Grasp>, Failure> {
        let found = sample_grasps(&surface, settings, &|_| true, &mut |_| true)?;
        Ok(found.grasps.iter().map(|sampled| sampled.grasp).collect())
    };
    let like_released = released.settings(CANDIDATES, seed);
    sample(&SamplerSettings { count: KEPT, ..like_released.clone() })?;
    let few_s = begin.elapsed().as_secs_f64();

    let begin = Instant::now();
    let all = sample(&like_released)?;
    let many_s = begin.elapsed().as_secs_f64();
    let begin = Instant::now();
    let covering = covering_subset(&all, KEPT, COVERAGE_THRESHOLD);
    let choosing_s = begin.elapsed().as_secs_f64();

    let cover = |reference: &[Grasp], all: &[Grasp], chosen: Vec<usize>| {
        let chosen: Vec<Grasp> = chosen.into_iter().map(|index| all[index]).collect();
        coverage(reference, &chosen, COVERAGE_THRESHOLD)
    };
    let of_all = |settings: &SamplerSettings| -> Result<f64, Failure> {
        let all = sample(settings)?;
        Ok(cover(&released.grasps, &all, covering_subset(&all, KEPT, COVERAGE_THRESHOLD)))
    };
    let without_palm = SamplerSettings { finger_depth_m: None, ..like_released.clone() };
    let holdable: Vec<Grasp> = released
        .grasps
        .iter()
        .filter(|grasp| is_holdable(&surface, grasp, like_released.opening_m))
        .copied()
        .collect();
    Ok(format!(
        "| {} | {id} | {few_s:.3} s | {many_s:.3} s | {choosing_s:.3} s | **{:.3}** | {:.3} of {} | {:.3} | {:.3} | \
         {:.3} |",
        released.object,
        cover(&released.grasps, &all, covering.clone()),
        cover(&holdable, &all, covering),
        holdable.len(),
        cover(&released.grasps, &all, farthest_subset(&all, KEPT, seed)),
        cover(&released.grasps, &all, random_subset(all.len(), KEPT, seed)),
        of_all(&without_palm)?,
    ))
}

/// Returns true if the object between the pads is nowhere wider than the gripper opening: along the closing axis from an
/// open pad, the object begins no sooner than at the pad.
fn is_holdable(surface: &Surface, grasp: &Grasp, opening_m: f64) -> bool {
    use cranny_spatial::{Point, Vector};
    let pose = grasp.world_from_gripper;
    let y = pose.rotation * Vector::y();
    let middle = Point::from(pose.translation.vector);
    let hits = surface.ray_hits(&(middle - y * opening_m), &y, 2.0 * opening_m);
    // The chord through the centre ends at the last entry before it and the first exit behind it.
    let entered = hits.iter().rfind(|hit| hit.distance_m < opening_m && hit.normal.dot(&y) < 0.0);
    let left = hits.iter().find(|hit| hit.distance_m > opening_m && hit.normal.dot(&y) > 0.0);
    match (entered, left) {
        (Some(entered), Some(left)) => left.distance_m - entered.distance_m <= opening_m,
        _ => false,
    }
}
