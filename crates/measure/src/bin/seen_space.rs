//! Plans in the space that cameras have seen, and checks each plan against the true scene:
//! `cargo run --release -p cranny-measure --bin seen_space -- CAMERAS SEEDS solid|free none|support|all SCENARIO…`.
//!
//! For each scenario, CAMERAS default cameras (320 × 240 pixels, errors of up to 1 mm + 0.5 % and half a pixel) see it once per seed.
//! The places of no obstacle, of the target's support or of all obstacles are known. Prints the number of maps, the median times in
//! milliseconds of the map (without rendering) and of planning with its proof, the numbers of solved plans, of those that meet a true
//! obstacle, and of maps of which no grasp is reachable.

use std::error::Error;
use std::time::{Duration, Instant};

use cranny_collision::Margins;
use cranny_measure::known_bodies::known_bodies;
use cranny_plan::{Budget, Outcome, Unobserved};
use cranny_scenario::{OpenOptions, Scenario, SeenOptions};
use cranny_sense::{Noise, Unseen, View};
use cranny_solve::{Request, solve};
use cranny_spatial::other_seed;

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [cameras, seeds, unseen, known, scenarios @ ..] = &words[..] else {
        return Err("usage: seen_space CAMERAS SEEDS solid|free none|support|all SCENARIO…".into());
    };
    let unseen = match unseen.as_str() {
        "solid" => Unseen::Solid,
        "free" => Unseen::Free,
        _ => return Err("unseen space is 'solid' or 'free'".into()),
    };
    let (cameras, seeds): (usize, u64) = (cameras.parse()?, seeds.parse()?);
    println!(
        "| scenario | maps | free m³ | map ms | plan ms | 95 % | solved | collide | outcomes of the others |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    let mut total = Tally::default();
    for id in scenarios {
        let mut tally = Tally::default();
        let truth = Scenario::open(id, &OpenOptions::default())?;
        let known = known_bodies(&truth, known)?;
        measure(&truth, &known, cameras, seeds, unseen, &mut tally)?;
        println!("| {id} {}", tally.row());
        total.add(tally);
    }
    println!("| all {}", total.row());
    Ok(())
}

#[derive(Default)]
struct Tally {
    map_ms: Vec<f64>,
    plan_ms: Vec<f64>,
    free_m3: Vec<f64>,
    solved: usize,
    collide: usize,
    others: Vec<String>,
}

impl Tally {
    fn add(&mut self, other: Self) {
        self.map_ms.extend(other.map_ms);
        self.plan_ms.extend(other.plan_ms);
        self.free_m3.extend(other.free_m3);
        self.solved += other.solved;
        self.collide += other.collide;
        self.others.extend(other.others);
    }

    fn row(&self) -> String {
        let mut others = self.others.clone();
        others.sort();
        let counted = others.chunk_by(|a, b| a == b).map(|run| format!("{} {}", run.len(), run[0]));
        format!(
            "| {} | {:.2} | {:.1} | {:.1} | {:.1} | {} | {} | {} |",
            self.map_ms.len(),
            quantile(&self.free_m3, 0.5),
            quantile(&self.map_ms, 0.5),
            quantile(&self.plan_ms, 0.5),
            quantile(&self.plan_ms, 0.95),
            self.solved,
            self.collide,
            counted.collect::<Vec<_>>().join(", ")
        )
    }
}

/// Returns the smallest value that at least this fraction of all values do not exceed.
fn quantile(values: &[f64], fraction: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let index = sorted.iter().enumerate().position(|(i, _)| (i + 1) as f64 >= fraction * sorted.len() as f64);
    index.map_or(f64::NAN, |index| sorted[index])
}

fn measure(
    truth: &Scenario,
    known: &[String],
    cameras: usize,
    seeds: u64,
    unseen: Unseen,
    tally: &mut Tally,
) -> Result<(), Box<dyn Error>> {
    let problem = truth.problem(Margins::default())?;
    let true_cell = problem.cell().ok_or("an exact scenario")?;
    let scene = truth.sensed()?;
    let placed = truth.default_cameras(&scene, cameras)?;
    let known = truth.with_known_bodies_only(known)?;
    let options = SeenOptions { unseen, ..SeenOptions::default() };
    for seed in 0..seeds {
        let mut views: Vec<View> = Vec::new();
        for (index, camera) in placed.iter().enumerate() {
            let noise = Noise { seed: other_seed(seed, index as u64), ..Noise::default() };
            views.push(scene.view(&camera.name, &camera.camera, &camera.sensor, &noise)?);
        }
        let begin = Instant::now();
        let seen = known.with_seen(&views, &options)?;
        tally.map_ms.push(begin.elapsed().as_secs_f64() * 1e3);
        if let Some(space) = &seen.seen {
            tally.free_m3.push(space.map.free_m3());
        }
        let begin = Instant::now();
        let problem = seen.problem(Margins::default())?;
        let budget = Budget { time: Duration::from_secs(2), ..Budget::default() };
        let answer = solve(&problem, &Request { seed, budget, ..Request::default() }, &mut Unobserved)?;
        if answer.outcome != Outcome::Solved {
            tally.others.push(answer.outcome.name().to_owned());
            continue;
        }
        tally.plan_ms.push(begin.elapsed().as_secs_f64() * 1e3);
        tally.solved += 1;
        let mut scratch = true_cell.scratch();
        let edges = answer.segments.iter().flat_map(|segment| segment.waypoints.windows(2));
        let mut motions = edges.map(|edge| true_cell.motion_is_free(&edge[0], &edge[1], &mut scratch));
        tally.collide += usize::from(!motions.all(|motion| motion.is_proven()));
    }
    Ok(())
}
