//! Recordings of moving bodies: created from a simulation, written and read.

use std::path::Path;

use cranny_collision::Body;
use cranny_scenario::Scenario;
use cranny_sim::{PickRun, RecordedBody, Recording};
use cranny_spatial::Pose;
use cranny_view::{Animation, BodyRecording, MovingBody, PictureSettings, Scene, StandardView};

use crate::arguments::Output;
use crate::failure::Failure;
use crate::file_kind::FileKind;
use crate::output_file;
use crate::progress::bar;

/// Frame rate of a GIF, in Hz; at most that of a recording.
const GIF_RATE_HZ: u16 = 25;

/// Returns the path of a recording, if `what` names one instead of a scenario.
pub fn file_of(what: &str) -> Option<&Path> {
    let path = Path::new(what);
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("json")).then_some(path)
}

/// Reads the recording of a file. No flag may add to it: `others` lists the flags that would, with true for those given.
pub fn read(file: &Path, others: &[(&str, bool)]) -> Result<BodyRecording, Failure> {
    if let Some((what, _)) = others.iter().find(|(_, is_given)| *is_given) {
        let problem = format!("a recording contains the whole scene; leave out {what}");
        return Err(Failure::File { path: file.to_owned(), problem });
    }
    Ok(BodyRecording::read(file)?)
}

/// Returns the kind of file that `--record` writes.
pub fn kind_of(file: &Path) -> Result<FileKind, Failure> {
    match file.extension().and_then(|ending| ending.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("glb") => Ok(FileKind::Glb),
        Some("gif") => Ok(FileKind::Gif),
        Some("json") => Ok(FileKind::Recording),
        _ => {
            let problem = "unknown file ending (known: .glb, .gif, .json)".to_owned();
            Err(Failure::Flag { flag: "record", problem })
        }
    }
}

/// Converts the recording of a simulation run.
pub fn of_run(name: &str, surroundings: &[Body], run: &Recording) -> BodyRecording {
    let body = |(index, body): (usize, &RecordedBody)| MovingBody {
        name: body.name.clone(),
        surface: body.surface.clone(),
        is_grasped: index == 0,
        world_from_body: body.world_from_body.clone(),
    };
    let mut recording = BodyRecording {
        name: name.to_owned(),
        times_s: run.times_s.clone(),
        bodies: run.bodies.iter().enumerate().map(body).collect(),
        ..BodyRecording::default()
    };
    recording.add_still(surroundings);
    recording
}

/// Joins picks into one recording, each pick starting at the end of the one before; takes their recordings.
pub fn of_picks(scenario: &Scenario, picks: &mut [PickRun]) -> BodyRecording {
    if let [pick] = picks {
        let run = pick.run.grasp.recording.take().unwrap_or_default();
        return of_run(&scenario.id, &pick.surroundings, &run);
    }
    let mut steps = Vec::new();
    for pick in picks {
        let run = pick.run.grasp.recording.take().unwrap_or_default();
        steps.push(RecordedStep { body: pick.body, world_from_object: pick.world_from_object, run });
    }
    let mut whole = BodyRecording { name: scenario.id.clone(), ..BodyRecording::default() };
    let arm = steps.first().into_iter().flat_map(|step| &step.run.bodies[1..]);
    let link = |(index, link): (usize, &RecordedBody)| MovingBody {
        name: link.name.clone(),
        surface: link.surface.clone(),
        is_grasped: false,
        world_from_body: steps
            .iter()
            .flat_map(|step| &step.run.bodies[index + 1].world_from_body)
            .copied()
            .collect(),
    };
    whole.bodies = arm.enumerate().map(link).collect();
    let mut begin_s = 0.0;
    for RecordedStep { run, .. } in &steps {
        whole.times_s.extend(run.times_s.iter().map(|time_s| begin_s + time_s));
        begin_s = whole.times_s.last().copied().unwrap_or_default() + PAUSE_S;
    }
    for (index, body) in scenario.world.bodies().iter().enumerate() {
        let first = whole.bodies.len();
        whole.add_still(std::slice::from_ref(body));
        if steps.iter().all(|step| step.body != index) {
            continue;
        }
        // Displacement of the body at each instant.
        let mut motions: Vec<Pose> = Vec::new();
        for RecordedStep { body, world_from_object, run } in &steps {
            let before = motions.last().copied().unwrap_or_default();
            let poses = &run.bodies[0].world_from_body;
            let before_step = world_from_object.inverse() * before;
            let moved = |pose: &Pose| if *body == index { pose * before_step } else { before };
            motions.extend(poses.iter().map(moved));
        }
        for part in &mut whole.bodies[first..] {
            let stands = part.world_from_body[0];
            part.world_from_body = motions.iter().map(|motion| motion * stands).collect();
            part.is_grasped = scenario.target == Some(index);
        }
    }
    whole
}

/// Recording of one pick.
struct RecordedStep {
    /// Index of the picked body.
    body: usize,
    /// Pose of its frame before the pick.
    world_from_object: Pose,
    run: Recording,
}

/// Time between the end of a pick and the start of the next, which show the same instant, in seconds.
const PAUSE_S: f64 = 0.01;

pub fn write(recording: &BodyRecording, file: &Path, kind: FileKind, output: Output) -> Result<(), Failure> {
    match kind {
        FileKind::Recording => return output_file::write(file, kind, recording.json()?.as_bytes(), output),
        FileKind::Glb => return Ok(Scene::of_moving_bodies(recording).write_glb(file)?),
        _ => {}
    }
    let scene = Scene::of_moving_bodies(&recording.thinned(GIF_RATE_HZ.into()));
    let frames: Vec<usize> = (0..=scene.last_frame().unwrap_or(0)).collect();
    let settings = PictureSettings { width: 640, height: 480, ghosts: 0, ..PictureSettings::default() };
    let bar = bar(frames.len() as u64, output.quiet);
    let pictures = Animation::draw(&scene, StandardView::ThreeQuarter, &settings, &frames, |_, picture| {
        bar.inc(1);
        Ok(picture)
    })?;
    bar.finish_and_clear();
    Ok(Animation { pictures, rate_hz: GIF_RATE_HZ }.write_gif(file)?)
}
