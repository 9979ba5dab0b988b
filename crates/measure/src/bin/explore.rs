//! Explores true scenarios view by view until a plan is proven in the space that the views show, and judges it in the true scenario:
//! `cargo run --release -p cranny-measure --bin explore -- VIEWS SEEDS fixed|hand none|support|all SCENARIO…`.
//!
//! The first view is that of the first default camera (320 × 240 pixels, errors of up to 1 mm + 0.5 % and half a pixel); then a
//! free-standing camera, or one on the hand, is moved up to VIEWS views in all, once per seed of the errors. The places of no obstacle,
//! of the target's support or of all obstacles are known. Prints for each
//! exploration the number of views, the outcome, the verdict in the true scenario, the time, and what blocked the last candidate.

use std::error::Error;
use std::time::{Duration, Instant};

use cranny_collision::Margins;
use cranny_explore::{CameraKind, Candidate, ExploreSettings, ViewReport, explore, true_contact};
use cranny_measure::known_bodies::known_bodies;
use cranny_plan::{Budget, Unobserved};
use cranny_scenario::{OpenOptions, Scenario};
use cranny_sense::{Camera, CameraFrame, PlacedCamera, SensorModel};
use cranny_solve::Request;
use cranny_spatial::{Pose, Vector};

/// Time limit of each search.
const SEARCH_TIME: Duration = Duration::from_secs(2);

/// Place of the camera on the hand, in the gripper frame (m): above the fingers, beside them.
const HAND_CAMERA_M: [f64; 3] = [0.07, 0.0, -0.08];

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [views, seeds, kind, known, scenarios @ ..] = &words[..] else {
        return Err("usage: explore VIEWS SEEDS fixed|hand none|support|all SCENARIO…".into());
    };
    let kind = match kind.as_str() {
        "fixed" => CameraKind::Fixed,
        "hand" => CameraKind::Hand,
        _ => return Err("a camera is 'fixed' or 'hand'".into()),
    };
    let (views, seeds): (usize, u64) = (views.parse()?, seeds.parse()?);
    println!("| scenario | seed | views | outcome | true scene | s | last obstruction |");
    println!("|---|---|---|---|---|---|---|");
    let (mut solved, mut all, mut used) = (0, 0, Vec::new());
    for id in scenarios {
        let truth = Scenario::open(id, &OpenOptions::default())?;
        let known = known_bodies(&truth, known)?;
        for seed in 0..seeds {
            let (row, count) = explored(&truth, &known, views, kind, seed)?;
            println!("| {id} | {seed} {row}");
            all += 1;
            solved += usize::from(count.is_some());
            used.extend(count);
        }
    }
    used.sort_unstable();
    let median = used.get(used.len().saturating_sub(1) / 2);
    println!(
        "| all | | {} | {solved} of {all} solved | | | |",
        median.map_or("–".to_owned(), usize::to_string)
    );
    Ok(())
}

/// Returns the row of an exploration, and its number of views if it was solved.
fn explored(
    truth: &Scenario,
    known: &[String],
    views: usize,
    kind: CameraKind,
    seed: u64,
) -> Result<(String, Option<usize>), Box<dyn Error>> {
    let mut cameras = truth.default_cameras(&truth.sensed()?, 1)?;
    let tip = truth.robot.links()[truth.robot.tip()].name.clone();
    let tip_from_camera =
        Pose::from_parts(Vector::from(HAND_CAMERA_M).into(), cranny_spatial::Rotation::identity());
    cameras.push(PlacedCamera {
        name: "hand".to_owned(),
        frame: CameraFrame::Link(tip),
        camera: Camera::with_field_of_view([320, 240], 70_f64.to_radians(), tip_from_camera)?,
        sensor: SensorModel::default(),
        configuration: None,
    });
    let budget = Budget { time: SEARCH_TIME, ..Budget::default() };
    let settings = ExploreSettings {
        views,
        cameras,
        kind,
        noise_seed: Some(seed),
        known: known.to_vec(),
        request: Request { budget, seed, ..Request::default() },
        ..ExploreSettings::default()
    };
    let begin = Instant::now();
    let explored =
        explore(truth, &settings, &mut Unobserved, &mut |report| eprintln!("{}", line(truth, report)))?;
    let time_s = begin.elapsed().as_secs_f64();
    let solved = explored.answer.is_solved();
    let verdict = if solved {
        let fault = true_contact(&truth.problem(Margins::default())?, &explored.answer)?;
        fault.unwrap_or_else(|| "free".to_owned())
    } else {
        "–".to_owned()
    };
    let last = explored.reports.last().filter(|_| !solved).and_then(|report| obstruction(truth, report));
    let row = format!(
        "| {} | {} | {verdict} | {time_s:.1} | {} |",
        explored.reports.len(),
        explored.answer.outcome.name(),
        last.unwrap_or_default()
    );
    Ok((row, solved.then_some(explored.reports.len())))
}

fn line(truth: &Scenario, report: &ViewReport) -> String {
    let next = report.next.as_ref().map_or("no next view".to_owned(), |next| {
        let place = next.camera.world_from_camera.translation.vector;
        let frees = next.frees.unwrap_or_default();
        format!(
            "next {:.2} {:.2} {:.2} sees {}, frees {frees}, refused {}",
            place.x, place.y, place.z, next.sees, next.refused
        )
    });
    format!(
        "{} {}: {:.2} m³ free, {:.2} occupied, {:.2} unseen; {}; {}; {next}",
        truth.id,
        report.name,
        report.free_m3,
        report.occupied_m3,
        report.unseen_m3,
        report.outcome.name(),
        obstruction(truth, report).unwrap_or_else(|| "no candidate".to_owned())
    )
}

/// Returns a phrase on what blocks the candidate.
fn obstruction(truth: &Scenario, report: &ViewReport) -> Option<String> {
    let blockage = report.blockage.as_ref()?;
    let candidate = match blockage.candidate {
        Candidate::Path(_) => "path",
        Candidate::BlockedPath(_) => "blocked path",
        Candidate::Grasp { .. } => "grasp",
    };
    let unseen = blockage.unseen_count();
    let link = blockage.first.map(|first| truth.robot.links()[first.link].name.clone());
    Some(format!(
        "{candidate}: {unseen} unseen and {} occupied cells, {}",
        blockage.cells.len() - unseen,
        link.unwrap_or_default()
    ))
}
