use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;
use std::sync::atomic::Ordering;

use cranny_bench::statistics::wilson;
use cranny_collision::Body;
use cranny_grasp::{GraspSet, Hand, read_csv};
use cranny_plan::robot_hand;
use cranny_scenario::{
    ObjectType, OpenOptions, ScenarioError, TargetObject, TargetPhysics, is_scenario, panda_hand,
    read_gripper,
};
use cranny_shape::Solid;
use cranny_sim::{Course, Disturbance, GraspOutcome, GraspRun, GraspTest, Physics, Recording, Uncertainty};
use cranny_spatial::Pose;
use cranny_view::{Animation, MovingBody, PictureSettings, Scene, StandardView};
use serde::Serialize;

use crate::Answer;
use crate::arguments::Output;
use crate::failure::Failure;
use crate::file_kind::FileKind;
use crate::progress::{bar, stop_on_interrupt};
use crate::simulate::SimulateGraspsArguments;
use crate::task::open_scenario;
use crate::{object, output_file, text};

/// What `simulate grasps --json` prints; the keys stay.
#[derive(Serialize)]
struct Simulated {
    subject: String,
    hand: String,
    grasps: usize,
    held: usize,
    success_rate: f64,
    /// Of the success rate, 95 %.
    wilson_interval: Option<[f64; 2]>,
    /// Whether Ctrl-C left grasps over.
    stopped: bool,
    rows: Vec<Row>,
}

#[derive(Serialize)]
struct Row {
    grasp: usize,
    outcome: &'static str,
    translation_error_m: f64,
    rotation_error_rad: f64,
    held_s: f64,
    contact_force_n: f64,
    /// The geometric score.
    score: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    robust: Option<Robust>,
}

/// Of trials in which everything is a little wrong.
#[derive(Serialize)]
struct Robust {
    trials: usize,
    held: usize,
    score: f64,
    /// 95 %.
    wilson_interval: Option<[f64; 2]>,
}

/// Everything that a simulation of grasps is about.
struct Subject {
    name: String,
    hand: Hand,
    object: ObjectType,
    world_from_object: Pose,
    surroundings: Vec<Body>,
    /// In the planning frame.
    grasps: GraspSet,
}

pub fn run(arguments: &SimulateGraspsArguments, output: Output) -> Result<Answer, Failure> {
    let recorded =
        arguments.record.as_deref().map(|file| kind_of(file).map(|kind| (file, kind))).transpose()?;
    if let Some((file, kind)) = recorded {
        output_file::check(file, kind, output)?;
    }
    let subject = Subject::open(arguments, output)?;
    let all = subject.grasps.grasps();
    let chosen: Vec<usize> = match arguments.grasp {
        None => (0..all.len()).collect(),
        Some(grasp) if grasp < all.len() => vec![grasp],
        Some(_) => return Err(flag("grasp", format!("there are {} grasps, from 0 on", all.len()))),
    };
    let Subject { hand, object, world_from_object, surroundings, .. } = &subject;
    let test = GraspTest::new(
        hand,
        object,
        *world_from_object,
        surroundings,
        Physics::default(),
        Course::default(),
    )?;
    // Each grasp as it is, then with each of the errors.
    let errors = Uncertainty::default().design(arguments.trials, arguments.seed);
    let each = || std::iter::once(Disturbance::default()).chain(errors.iter().copied());
    let trials: Vec<(Pose, Disturbance)> = chosen
        .iter()
        .flat_map(|&grasp| each().map(move |disturbance| (grasp, disturbance)))
        .map(|(grasp, disturbance)| (all[grasp].world_from_gripper, disturbance))
        .collect();
    let stop = stop_on_interrupt()?;
    let progress = bar(trials.len() as u64, output.quiet);
    let runs = test.run_all(&trials, &|| progress.inc(1), &stop);
    progress.finish_and_clear();

    let mut rows = Vec::new();
    for (&grasp, runs) in chosen.iter().zip(runs.chunks(1 + errors.len())) {
        let Some(runs) = runs.iter().cloned().collect::<Option<Vec<GraspRun>>>() else { continue };
        rows.push(Row::of(grasp, all[grasp].score, &runs[0], &runs[1..]));
    }
    let held = rows.iter().filter(|row| row.outcome == GraspOutcome::Held.name()).count();
    let simulated = Simulated {
        subject: subject.name.clone(),
        hand: hand.name.clone(),
        grasps: rows.len(),
        held,
        success_rate: held as f64 / rows.len().max(1) as f64,
        wilson_interval: interval(held, rows.len()),
        stopped: stop.load(Ordering::Relaxed),
        rows,
    };
    if let (Some((file, kind)), [grasp]) = (recorded, &chosen[..]) {
        let run = test.run(&all[*grasp].world_from_gripper, &Disturbance::default(), true);
        let scene = scene(&subject, &run.recording.unwrap_or_default());
        write(&scene, file, kind, output)?;
    }
    text::answer(&simulated, || simulated.page(), output)?;
    Ok(if held > 0 && !simulated.stopped { Answer::Done } else { Answer::No })
}

impl Subject {
    fn open(arguments: &SimulateGraspsArguments, output: Output) -> Result<Self, Failure> {
        let given = arguments.gripper.as_deref().map(read_gripper).transpose()?;
        let grasps = arguments.grasps.as_deref().map(read_csv).transpose().map_err(ScenarioError::from)?;
        let instead = TargetPhysics { mass_kg: arguments.mass, friction: arguments.friction };
        let mut subject = if is_scenario(&arguments.subject) {
            Self::of_scenario(arguments, given, grasps, &instead, output)?
        } else {
            Self::of_object(arguments, given, grasps, &instead)?
        };
        if let Some(force_n) = arguments.closing_force {
            subject.hand.closing_force_n = force_n;
        }
        Ok(subject)
    }

    fn of_scenario(
        arguments: &SimulateGraspsArguments,
        given: Option<Hand>,
        grasps: Option<GraspSet>,
        instead: &TargetPhysics,
        output: Output,
    ) -> Result<Self, Failure> {
        if arguments.pose.is_some() {
            return Err(flag("pose", "the object stands where the scenario has it".to_owned()));
        }
        let scenario = open_scenario(&arguments.subject, &OpenOptions::default(), output)?;
        let (Some(target), Some(found)) = (scenario.target, scenario.target_object(instead)?) else {
            return Err(Failure::NoTarget { id: scenario.id });
        };
        let TargetObject { object, world_from_object } = found;
        let bodies = scenario.world.bodies();
        let around: Vec<usize> = if arguments.support_only {
            scenario.world.supports_of(target)
        } else {
            (0..bodies.len()).filter(|&body| body != target).collect()
        };
        Ok(Self {
            name: scenario.id.clone(),
            hand: given.unwrap_or_else(|| robot_hand(&scenario.robot)),
            object,
            world_from_object,
            surroundings: around.into_iter().map(|body| bodies[body].clone()).collect(),
            grasps: grasps.unwrap_or(scenario.grasps),
        })
    }

    /// An object floats at the origin, or lies on the ground.
    fn of_object(
        arguments: &SimulateGraspsArguments,
        given: Option<Hand>,
        grasps: Option<GraspSet>,
        instead: &TargetPhysics,
    ) -> Result<Self, Failure> {
        if arguments.support_only {
            return Err(flag(
                "support-only",
                "an object stands on nothing but the ground, by --pose".to_owned(),
            ));
        }
        let object = object::open(&arguments.subject)?;
        let (mass_kg, friction) =
            (instead.mass_kg.unwrap_or(object.mass_kg), instead.friction.unwrap_or(object.friction));
        let object = object.with_mass_and_friction(mass_kg, friction)?;
        let Some(grasps) = grasps else {
            let name = &arguments.subject;
            let problem = format!(
                "grasps of an object stand in a file; make one: cranny grasps sample {name} -o {name}.csv"
            );
            return Err(flag("grasps", problem));
        };
        let (world_from_object, surroundings) = if let Some(index) = arguments.pose {
            let Some(stable) = object.stable_poses.get(index) else {
                let count = object.stable_poses.len();
                return Err(flag(
                    "pose",
                    format!("{} has {count} stable poses, counted from 0", object.name),
                ));
            };
            let floor = Body::new("floor", Pose::identity(), Solid::half_space());
            (stable.ground_from_body, vec![floor])
        } else {
            (Pose::identity(), Vec::new())
        };
        let mut placed = Vec::new();
        for grasp in grasps.grasps() {
            placed.push(cranny_grasp::Grasp {
                world_from_gripper: world_from_object * grasp.world_from_gripper,
                ..*grasp
            });
        }
        let hand = given.map_or_else(|| panda_hand().map_err(ScenarioError::from), Ok)?;
        let grasps = GraspSet::new(placed).map_err(ScenarioError::from)?;
        Ok(Self { name: object.name.clone(), hand, object, world_from_object, surroundings, grasps })
    }
}

impl Row {
    fn of(grasp: usize, score: Option<f64>, run: &GraspRun, trials: &[GraspRun]) -> Self {
        let held = trials.iter().filter(|run| run.outcome == GraspOutcome::Held).count();
        let robust = Robust {
            trials: trials.len(),
            held,
            score: held as f64 / trials.len().max(1) as f64,
            wilson_interval: interval(held, trials.len()),
        };
        Self {
            grasp,
            outcome: run.outcome.name(),
            translation_error_m: run.translation_error_m,
            rotation_error_rad: run.rotation_error_rad,
            held_s: run.held_s,
            contact_force_n: run.contact_force_n,
            score,
            robust: Some(robust).filter(|robust| robust.trials > 0),
        }
    }
}

impl Simulated {
    fn page(&self) -> String {
        let percent = |share: f64| format!("{:.1} %", 100.0 * share);
        let sure = self.wilson_interval.map_or_else(String::new, |[low, high]| {
            format!(", {} to {} at 95 %", percent(low), percent(high))
        });
        let mut page = format!(
            "{}: {} of {} grasps are held by {} ({}{sure})\n",
            self.subject,
            self.held,
            self.grasps,
            self.hand,
            percent(self.success_rate)
        );
        let mut outcomes: BTreeMap<&str, usize> = BTreeMap::new();
        for row in &self.rows {
            *outcomes.entry(row.outcome).or_default() += 1;
        }
        for (outcome, count) in outcomes {
            let _ = writeln!(page, "  {count:>5}  {outcome}");
        }
        let mut robust: Vec<&Row> = self.rows.iter().filter(|row| row.robust.is_some()).collect();
        let score = |row: &Row| row.robust.as_ref().map_or(0.0, |robust| robust.score);
        robust.sort_by(|a, b| score(b).total_cmp(&score(a)));
        for row in robust.iter().take(MOST_SHOWN) {
            let _ = writeln!(
                page,
                "  grasp {:>4}: robust score {:.2}, geometric {}",
                row.grasp,
                score(row),
                text::score(row.score)
            );
        }
        if let [Row { translation_error_m, rotation_error_rad, contact_force_n, held_s, .. }] = self.rows[..]
        {
            let (moved, turned) = (text::millimetres(translation_error_m), text::degrees(rotation_error_rad));
            let _ = writeln!(
                page,
                "  moved {moved}, turned {turned}, held {held_s:.2} s, pressed with {contact_force_n:.1} N"
            );
        }
        page
    }
}

/// The best of the robust scores that a person is shown.
const MOST_SHOWN: usize = 10;

fn interval(held: usize, trials: usize) -> Option<[f64; 2]> {
    wilson(held, trials).map(|interval| [interval.low, interval.high])
}

fn flag(flag: &'static str, problem: String) -> Failure {
    Failure::Flag { flag, problem }
}

fn kind_of(file: &Path) -> Result<FileKind, Failure> {
    match file.extension().and_then(|ending| ending.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("glb") => Ok(FileKind::Glb),
        Some("gif") => Ok(FileKind::Gif),
        _ => Err(flag("record", "the file's ending says what to write: .glb or .gif".to_owned())),
    }
}

/// What is seen of a recorded simulation.
fn scene(subject: &Subject, recording: &Recording) -> Scene {
    let body = |(index, body): (usize, &cranny_sim::RecordedBody)| MovingBody {
        name: body.name.clone(),
        surface: body.surface(),
        is_grasped: index == 0,
        world_from_body: body.world_from_body.clone(),
    };
    let moving: Vec<MovingBody> = recording.bodies.iter().enumerate().map(body).collect();
    Scene::of_moving_bodies(&subject.name, &subject.surroundings, &moving, recording.times_s.clone())
}

/// Pictures a second of a GIF, at most those of a recording.
const GIF_RATE_HZ: u16 = 25;

fn write(scene: &Scene, file: &Path, kind: FileKind, output: Output) -> Result<(), Failure> {
    if kind == FileKind::Glb {
        return Ok(scene.write_glb(file)?);
    }
    let times_s = scene.motion.as_ref().map_or(&[][..], |motion| &motion.times_s);
    let period_s = 1.0 / f64::from(GIF_RATE_HZ);
    let mut frames: Vec<usize> = Vec::new();
    for (frame, &time_s) in times_s.iter().enumerate() {
        if time_s + 1e-9 >= frames.len() as f64 * period_s {
            frames.push(frame);
        }
    }
    let settings = PictureSettings { width: 640, height: 480, ghosts: 0, ..PictureSettings::default() };
    let bar = bar(frames.len() as u64, output.quiet);
    let pictures = Animation::draw(scene, StandardView::ThreeQuarter, &settings, &frames, |_, picture| {
        bar.inc(1);
        Ok(picture)
    })?;
    bar.finish_and_clear();
    Ok(Animation { pictures, rate_hz: GIF_RATE_HZ }.write_gif(file)?)
}
