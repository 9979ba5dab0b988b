//! Samples smooth trajectories and compares them with all stated bounds; one thread.
//!
//! `curve_samples COUNT TILT_DEG SCENARIO…`: plans to reach, to carry home and to put down outside, with the object tilted by
//! at most `TILT_DEG`, seed after seed until there are COUNT rounded corners. Prints how many samples at 10 kHz exceed a limit
//! of position, velocity, acceleration or jerk by more than 1e-9 of it, and how many of 4000 samples of each corner are in
//! contact (exact distances) or tilted farther; exits with 1 if there are any.
//!
//! `cargo run --release -p cranny-measure --bin curve_samples -- 2000 15 012 015 023 025 031 035 041 043`

use std::process::ExitCode;
use std::time::Duration;

use cranny_collision::Margins;
use cranny_path::Trajectory;
use cranny_plan::{Budget, Unobserved};
use cranny_robot::Robot;
use cranny_scenario::{OpenOptions, Scenario};
use cranny_solve::{Request, Timing, solve};
use cranny_task::{AfterPlacing, PlaceAt, Problem, RoundedCorner, Segment, Stage, StateSequence};

const RATE_HZ: f64 = 10_000.0;
const SAMPLES: u32 = 4000;
const RELATIVE: f64 = 1e-9;

#[derive(Default)]
struct Seen {
    plans: usize,
    corners: usize,
    instants: u64,
    /// Number of samples beyond the limits of position, velocity, acceleration and jerk.
    beyond: [u64; 4],
    /// Maximum utilisation of each of these limits except position.
    greatest: [f64; 4],
    places: u64,
    in_contact: u64,
    tilted: u64,
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [count, tilt_deg, scenarios @ ..] = &arguments[..] else {
        eprintln!("usage: curve_samples COUNT TILT_DEG SCENARIO…");
        return ExitCode::from(2);
    };
    let count: usize = count.parse().expect("a number of corners");
    let tilt_deg: f64 = tilt_deg.parse().expect("a number of degrees");
    let margins = Margins { tilt_rad: Some(tilt_deg.to_radians()), ..Margins::default() };
    let problems = scenarios.iter().map(|name| {
        let scenario = Scenario::open(name, &OpenOptions::default()).expect("a scenario");
        scenario.problem(margins).expect("a problem")
    });
    let problems: Vec<Problem> = problems.collect();
    let outside = PlaceAt::named("outside");
    let tasks =
        [Vec::new(), vec![Stage::pick(), Stage::home()], Stage::put_down(outside, AfterPlacing::Home)];
    let mut seen = Seen::default();
    'seeds: for seed in 0.. {
        for problem in &problems {
            for stages in &tasks {
                seen.plan(problem, stages, seed);
                if seen.corners >= count {
                    break 'seeds;
                }
            }
        }
    }
    let Seen { plans, corners, instants, beyond, greatest, places, in_contact, tilted } = seen;
    println!("{plans} plans with {corners} rounded corners");
    for (kind, (beyond, greatest)) in
        ["position", "velocity", "acceleration", "jerk"].iter().zip(beyond.iter().zip(greatest))
    {
        println!("{kind}: {beyond} of {instants} instants beyond the limit, greatest share {greatest:.9}");
    }
    println!(
        "{in_contact} of {places} configurations on corners in contact, {tilted} tilted by more than {tilt_deg}°"
    );
    ExitCode::from(u8::from(beyond.iter().sum::<u64>() + in_contact + tilted > 0))
}

impl Seen {
    fn plan(&mut self, problem: &Problem, stages: &[Stage], seed: u64) {
        let request = Request {
            seed,
            stages: stages.to_vec(),
            timing: Some(Timing::default()),
            hold: Some(1.5),
            budget: Budget { time: Duration::from_secs(10), ..Budget::default() },
            ..Request::default()
        };
        let answer = solve(problem, &request, &mut Unobserved).expect("a good problem");
        let (true, Some(timed)) = (answer.is_solved(), &answer.timed) else { return };
        self.plans += 1;
        for leg in timed.trajectory.legs() {
            self.limits(problem.robot(), leg);
        }
        let stages = if stages.is_empty() { Stage::of_goal(problem) } else { stages.to_vec() };
        let along = StateSequence::of(problem, &stages, &answer.segments);
        let along = along.expect("a good path").expect("an exact problem");
        for (segment, state) in answer.segments.iter().zip(&along.states) {
            let (cell, mut scratch) = (state.cell(), state.cell().scratch());
            for q in segment_corners(segment) {
                self.places += 1;
                self.in_contact += u64::from(cell.first_contact(&q, &mut scratch).is_some());
                let excess_rad = cell.tilt_bound().map(|bound| cell.tool_excess(bound, &q, &mut scratch));
                self.tilted += u64::from(excess_rad.is_some_and(|excess_rad| excess_rad > 0.0));
            }
            self.corners += segment.corners.len();
        }
    }

    fn limits(&mut self, robot: &Robot, leg: &Trajectory) {
        let mut before: Option<Vec<f64>> = None;
        for sample in leg.samples(RATE_HZ).expect("a rate") {
            self.instants += 1;
            let mut worst = [0.0_f64; 4];
            for (joint, limits) in robot.limits().iter().enumerate() {
                let q = sample.position[joint];
                let over = (q - limits.upper).max(limits.lower - q);
                let width = limits.upper - limits.lower;
                worst[0] = worst[0].max(1.0 + over / width);
                worst[1] = worst[1].max(sample.velocity[joint].abs() / limits.velocity);
                let most = limits.acceleration.unwrap_or(f64::INFINITY);
                worst[2] = worst[2].max(sample.acceleration[joint].abs() / most);
                // The interval to the last sample may be shorter.
                if let Some(before) = before.as_ref().filter(|_| sample.time_s < leg.duration_s()) {
                    let jerk = (sample.acceleration[joint] - before[joint]).abs() * RATE_HZ;
                    worst[3] = worst[3].max(jerk / limits.jerk.unwrap_or(f64::INFINITY));
                }
            }
            for ((beyond, greatest), worst) in self.beyond.iter_mut().zip(&mut self.greatest).zip(worst) {
                *beyond += u64::from(worst > 1.0 + RELATIVE);
                *greatest = greatest.max(worst);
            }
            before = Some(sample.acceleration);
        }
    }
}

/// Returns configurations sampled on the corners of a segment.
fn segment_corners(segment: &Segment) -> impl Iterator<Item = Vec<f64>> {
    let of_corner = |corner: &RoundedCorner| {
        let points = corner.control_points.clone();
        (0..=SAMPLES).map(move |k| on_curve(&points, f64::from(k) / f64::from(SAMPLES)))
    };
    segment.corners.iter().flat_map(of_corner)
}

/// Evaluates a Bézier curve by de Casteljau's algorithm.
fn on_curve(points: &[Vec<f64>], t: f64) -> Vec<f64> {
    let mut row = points.to_vec();
    while row.len() > 1 {
        let between =
            |pair: &[Vec<f64>]| pair[0].iter().zip(&pair[1]).map(|(a, b)| a + t * (b - a)).collect();
        row = row.windows(2).map(between).collect();
    }
    row.remove(0)
}
