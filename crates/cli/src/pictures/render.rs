use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use cranny_plan::Registry;
use cranny_record::{PlanFile, read_waypoints};
use cranny_scenario::{GivenGrasps, OpenOptions};
use cranny_solve::Timing;
use cranny_view::{
    Camera, PageServer, Picture, PictureSettings, SampledPath, Scene, SceneSettings, SeeThrough, StandardView,
};
use serde::Serialize;
use strum::VariantArray as _;

use crate::arguments::Output;
use crate::choices::GeometryArgument;
use crate::failure::Failure;
use crate::output_file;
use crate::physics::recording;
use crate::pictures::page_task::{PageRequest, PageTask};
use crate::pictures::render_film::{self, MovingPicture};
use crate::pictures::render_format::Format;
use crate::planning::plan_task::{check_plan, read_plan};
use crate::planning::task::open_scenario;
use crate::{Answer, text};

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny render 021 -o 021.png                               the scenario, the robot at its start
  cranny render 021 021.plan.json -o 021.png                 the end of a plan, with the way to it
  cranny render 021 021.plan.json --view all -o views.png    from four sides
  cranny render 021 021.plan.json -o 021.gif                 a moving picture, also .apng
  cranny render 021 021.plan.json -o 021.mp4 --speed 0.5     a film at half the speed, encoded by ffmpeg
  cranny render 021 021.plan.json -o frames/                 its pictures one by one
  cranny render 021 021.plan.json -o 021.glb                 animated glTF, for three.js or Blender
  cranny render 021 021.plan.json -o 021.html                what `cranny view` shows, in one file to send
  cranny render --all -o sheet.png                           all built-in scenarios on one sheet
  cranny render run.json -o run.gif                          a recording of `cranny simulate … --record`

The ending of FILE selects what is written. No graphics card is needed, and the same command writes
the same bytes on any machine; an .mp4 also depends on the version of ffmpeg.")]
pub struct RenderArguments {
    /// Built-in scenario, or the folder of one; or a recording (.json)
    #[arg(value_name = "ID|RECORDING", required_unless_present = "all")]
    pub id: Option<String>,
    /// Plan file (.plan.json) or way points (.csv, .try), several for .html; with --all a folder of plan files ID.plan.json
    #[arg(value_name = "PLAN")]
    pub plans: Vec<PathBuf>,
    /// File to write, with its format: .png, .gif, .apng, .mp4, .glb, .html, or a folder (with a / at its end) for single pictures
    #[arg(long, short, value_name = "FILE")]
    pub output: PathBuf,
    /// Render a contact sheet of all built-in scenarios
    #[arg(long)]
    pub all: bool,
    /// Width and height in pixels, 16 to 8192 each, up to 2048 with --all [default: 1280x960; 640x480 for animations, 400x300
    /// for each of --all]
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<(usize, usize)>,
    /// Direction of the view [default: three-quarter]
    #[arg(long, value_enum)]
    pub view: Option<ViewArgument>,
    /// Camera direction instead of --view: degrees turned to the left from straight ahead, and above the ground
    #[arg(long, value_name = "TURN,RISE", value_parser = direction, conflicts_with = "view",
          allow_hyphen_values = true)]
    pub camera: Option<(f64, f64)>,
    /// Number of translucent poses along the path, at most 100 [default: 3; 0 for animations]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(..=MOST_GHOSTS),
          allow_negative_numbers = true)]
    pub ghosts: Option<u8>,
    /// Number of grasps shown beside the chosen one, spread over the scores [default: 14]
    #[arg(long, value_name = "N")]
    pub grasps: Option<usize>,
    /// Show the robot at this time of a plan's motion, in seconds, instead of its end, in a .png
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    pub time: Option<f64>,
    /// Frame rate of an animation in Hz, 1 to 50 [default: 20]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=50))]
    pub rate: Option<u16>,
    /// Playback speed of an animation, 0.01 to 100: 1 is real time, 2 twice as fast [default: 1]
    #[arg(long, value_name = "FACTOR", value_parser = speed, allow_negative_numbers = true)]
    pub speed: Option<f64>,
    /// Antialiasing samples per pixel [default: 4]
    #[arg(long, value_name = "N", value_parser = ["1", "4", "8"])]
    pub samples: Option<String>,
    /// Repeat each plan's search, as its file states it, and show its trees in .html
    #[arg(long)]
    pub search_tree: bool,
    /// Keep obstacles opaque that hide the robot or the target
    #[arg(long)]
    pub solid: bool,
    /// Built-in robot, robot folder or model file to use instead of the scenario's robot
    #[arg(long, value_name = "FILE")]
    pub robot: Option<PathBuf>,
    /// Obstacles of a released scenario: the true boxes, or the inflated mesh that its planners used
    #[arg(long, value_enum)]
    pub geometry: Option<GeometryArgument>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ViewArgument {
    /// From the right, slightly ahead and above
    ThreeQuarter,
    /// From behind the robot, in its viewing direction
    Front,
    /// From the right of the robot, level
    Side,
    /// From above, with the forward direction up
    Top,
    /// All four in one picture
    All,
}

impl RenderArguments {
    /// Returns the directions of the view.
    pub fn views(&self) -> Vec<StandardView> {
        self.view.unwrap_or(ViewArgument::ThreeQuarter).views()
    }

    /// Refuses flags that have no effect on a format.
    fn check_flags(&self, format: Format) -> Result<(), Failure> {
        let is_drawn = !matches!(format, Format::Glb | Format::Html);
        let is_recording = self.id.as_deref().and_then(recording::file_of).is_some();
        for (name, is_given, has_effect) in [
            ("view", self.view.is_some(), is_drawn),
            ("camera", self.camera.is_some(), is_drawn),
            ("size", self.size.is_some(), is_drawn),
            ("samples", self.samples.is_some(), is_drawn),
            ("solid", self.solid, is_drawn),
            ("ghosts", self.ghosts.is_some(), is_drawn && !is_recording),
            ("grasps", self.grasps.is_some(), format != Format::Html && !is_recording),
            ("rate", self.rate.is_some(), format.is_moving()),
        ] {
            if is_given && !has_effect {
                let file = self.output.display();
                return Err(flag(
                    name,
                    &format!("has no effect on {file}; leave it out, or give another -o"),
                ));
            }
        }
        Ok(())
    }
}

impl ViewArgument {
    pub fn views(self) -> Vec<StandardView> {
        match self {
            Self::ThreeQuarter => vec![StandardView::ThreeQuarter],
            Self::Front => vec![StandardView::Front],
            Self::Side => vec![StandardView::Side],
            Self::Top => vec![StandardView::Top],
            Self::All => StandardView::VARIANTS.to_vec(),
        }
    }
}

/// Output of `render --json`.
#[derive(Default, Serialize)]
pub struct Rendered {
    pub files: Vec<PathBuf>,
    pub pictures: usize,
    pub width: usize,
    pub height: usize,
    pub triangles: usize,
    /// Obstacles drawn transparent because they hide the robot or the target.
    pub seen_through: Vec<String>,
}

/// Sample rate of an animated glTF, in Hz; viewers interpolate between the samples.
pub const GLTF_RATE_HZ: f64 = 30.0;

/// Default frame rate of a moving picture, in Hz.
const DEFAULT_RATE_HZ: u16 = 20;

/// Number of samples of a motion for each picture.
const SAMPLES_PER_PICTURE: f64 = 4.0;

/// Maximum number of ghost poses; more would hide the path.
const MOST_GHOSTS: i64 = 100;

pub fn run(arguments: &RenderArguments, registry: &Registry, output: Output) -> Result<Answer, Failure> {
    let format = Format::of(&arguments.output)?;
    // Checked before rendering; files in a folder are checked when their names are known.
    if let Some(kind) = format.kind() {
        output_file::check(&arguments.output, kind, output)?;
    }
    let rendered = match (&arguments.id, format) {
        (Some(_), _) if arguments.search_tree && format != Format::Html => {
            return Err(flag("search-tree", "trees are shown in a page: give -o a name that ends in .html"));
        }
        (Some(_), _) if arguments.plans.len() > 1 && format != Format::Html => {
            return Err(flag("output", "several plans are shown in a page: give a name that ends in .html"));
        }
        (Some(_), _) if arguments.time.is_some() && format != Format::Png => {
            return Err(flag(
                "time",
                "one moment is shown in a still picture: give -o a name that ends in .png",
            ));
        }
        (Some(_), Format::Png | Format::Html) if arguments.speed.is_some() => {
            return Err(flag(
                "speed",
                "a film has a speed: give -o a name that ends in .gif, .apng, .mp4, .glb or /",
            ));
        }
        (Some(id), _) => {
            arguments.check_flags(format)?;
            one(id, arguments, format, registry, output)?
        }
        (None, _) => return Err(flag("all", "give the ID of a scenario, or --all")),
    };
    rendered.answer(output)
}

impl Rendered {
    /// Prints the files written.
    pub fn answer(&self, output: Output) -> Result<Answer, Failure> {
        text::answer(self, || self.page(), output)?;
        Ok(Answer::Done)
    }

    fn page(&self) -> String {
        let mut page = String::new();
        for file in &self.files {
            let _ = writeln!(page, "{}", file.display());
        }
        if !self.seen_through.is_empty() {
            let names = self.seen_through.join(", ");
            let _ = writeln!(
                page,
                "  drawn transparent, because they hide robot, path or target: {names} (--solid draws them \
                 opaque)"
            );
        }
        page
    }
}

fn one(
    id: &str,
    arguments: &RenderArguments,
    format: Format,
    registry: &Registry,
    output: Output,
) -> Result<Rendered, Failure> {
    let is_moving = format.is_moving();
    let speed = arguments.speed.unwrap_or(1.0);
    let pictures_hz = f64::from(arguments.rate.unwrap_or(DEFAULT_RATE_HZ));
    // Samples are finer than pictures, because each stretch of a motion has samples at its ends.
    let rate_hz = if is_moving { SAMPLES_PER_PICTURE * pictures_hz } else { GLTF_RATE_HZ } / speed;
    let (width, height) = arguments.size.unwrap_or(if is_moving { (640, 480) } else { (1280, 960) });
    render_film::check(format, (width, height))?;
    let plan = arguments.plans.first().map(PathBuf::as_path);
    let scene = match recording::file_of(id) {
        Some(file) => recorded(file, arguments, is_moving.then_some(rate_hz))?,
        None => scene(id, plan, arguments, rate_hz, output)?,
    };
    let settings = settings(&scene, arguments, (width, height), if is_moving { 0 } else { 3 })?;
    let seen_through = scene.seen_through(&arguments.views(), &settings);
    let mut rendered = Rendered { triangles: scene.triangle_count(), seen_through, ..Rendered::default() };
    let file = &arguments.output;
    match format {
        Format::Glb => {
            scene.at_speed(speed).write_glb(file)?;
            rendered.seen_through.clear();
            rendered.files.push(file.clone());
        }
        Format::Png => {
            let picture = views(&scene, arguments, &settings)?;
            picture.write_png(file)?;
            rendered = Rendered { pictures: 1, width: picture.width(), height: picture.height(), ..rendered };
            rendered.files.push(file.clone());
        }
        Format::Gif | Format::Apng | Format::Mp4 | Format::Folder => {
            let moving = MovingPicture {
                scene: &scene,
                settings: &settings,
                views: arguments.views(),
                rate_hz: arguments.rate.unwrap_or(DEFAULT_RATE_HZ),
                step_s: speed / pictures_hz,
                format,
            };
            let count = render_film::write(&moving, file, output)?;
            rendered = Rendered { pictures: count, width, height, ..rendered };
            rendered.files.push(file.clone());
        }
        Format::Html => return page(id, arguments, registry, output),
    }
    Ok(rendered)
}

/// Writes the viewer's page with all its data to one file.
fn page(
    id: &str,
    arguments: &RenderArguments,
    registry: &Registry,
    output: Output,
) -> Result<Rendered, Failure> {
    // Checked before any search.
    PageServer::check_page()?;
    let request = PageRequest {
        id,
        plans: &arguments.plans,
        robot: arguments.robot.as_deref(),
        geometry: arguments.geometry,
        criterion: None,
        grasps: GivenGrasps::Own,
        search_trees: arguments.search_tree.then_some(registry),
    };
    PageTask::open(&request, output)?.page.write_html(&arguments.output)?;
    Ok(Rendered { files: vec![arguments.output.clone()], ..Rendered::default() })
}

/// Renders one view, or four of half the size.
fn views(scene: &Scene, arguments: &RenderArguments, settings: &PictureSettings) -> Result<Picture, Failure> {
    let views = arguments.views();
    if let [view] = views[..] {
        return Ok(Picture::of(scene, view, settings)?);
    }
    let quarter =
        PictureSettings { width: settings.width / 2, height: settings.height / 2, ..settings.clone() };
    let draw = |view: StandardView| Ok((String::new(), Picture::of(scene, view, &quarter)?));
    let pictures = views.into_iter().map(draw).collect::<Result<Vec<_>, Failure>>()?;
    Ok(Picture::sheet(&pictures, 2))
}

/// Returns the scene of a recording, sampled at the frame rate.
fn recorded(file: &Path, arguments: &RenderArguments, rate_hz: Option<f64>) -> Result<Scene, Failure> {
    let recording = recording::read(
        file,
        &[
            ("--robot", arguments.robot.is_some()),
            ("--geometry", arguments.geometry.is_some()),
            ("the plan", !arguments.plans.is_empty()),
        ],
    )?;
    let recording = rate_hz.map_or_else(|| recording.clone(), |rate_hz| recording.sampled(rate_hz));
    Ok(Scene::of_moving_bodies(&recording))
}

pub fn scene(
    id: &str,
    plan: Option<&Path>,
    arguments: &RenderArguments,
    rate_hz: f64,
    output: Output,
) -> Result<Scene, Failure> {
    let read = plan.map(read_plan).transpose()?.flatten();
    let of_plan = |file: fn(&PlanFile) -> &Option<String>| {
        read.as_ref().and_then(|plan| file(plan).as_ref()).map(PathBuf::from)
    };
    let options = OpenOptions {
        criterion: None,
        robot: arguments.robot.clone().or(of_plan(|plan| &plan.robot)),
        geometry: arguments.geometry.map(Into::into).or(read.as_ref().and_then(PlanFile::given_geometry)),
        grasps: read.as_ref().map(PlanFile::given_grasps).unwrap_or_default(),
    };
    let scenario = open_scenario(id, &options, output)?;
    let path = match (read, plan) {
        (Some(plan), Some(file)) => {
            check_plan(file, &plan, &scenario.robot, &scenario.id, "shown in")?;
            plan.check_task(&scenario)?;
            let timed = plan.trajectory(&scenario.robot)?;
            SampledPath::of_plan(&scenario.robot, &plan, timed.as_ref(), rate_hz)?
        }
        (None, Some(file)) => {
            let waypoints = read_waypoints(file, scenario.robot.dof())?;
            let trajectory = Timing::default().along(&scenario.robot, &waypoints)?;
            SampledPath::of(&scenario.robot, &waypoints, trajectory.as_ref(), rate_hz)?
        }
        (_, None) => None,
    };
    let scene_settings =
        arguments.grasps.map_or_else(SceneSettings::default, |grasps| SceneSettings { grasps });
    Ok(Scene::of_task(&scenario, path.as_ref(), &scene_settings)?)
}

pub fn settings(
    scene: &Scene,
    arguments: &RenderArguments,
    (width, height): (usize, usize),
    ghosts: usize,
) -> Result<PictureSettings, Failure> {
    let aspect = width as f64 / height.max(1) as f64;
    let camera: Option<Camera> = arguments.camera.map(|direction| scene.camera_from(direction, aspect));
    let frame = arguments.time.map(|time_s| frame_at(scene, time_s)).transpose()?;
    Ok(PictureSettings {
        width,
        height,
        samples: arguments.samples.as_deref().and_then(|samples| samples.parse().ok()).unwrap_or(4),
        frame,
        ghosts: arguments.ghosts.map_or(ghosts, usize::from),
        camera,
        see_through: if arguments.solid { SeeThrough::Nothing } else { SeeThrough::WhatHides },
    })
}

/// Returns the index of the first frame at or after a time.
fn frame_at(scene: &Scene, time_s: f64) -> Result<usize, Failure> {
    /// Tolerance, because durations are printed in whole milliseconds.
    const ROUNDED_S: f64 = 0.0005;
    let name = &scene.name;
    let times_s = scene.motion.as_ref().map_or(&[][..], |motion| &motion.times_s);
    let Some(&last_s) = times_s.last() else {
        let problem = format!("nothing moves in {name} without the path of a plan: give a plan file");
        return Err(Failure::Flag { flag: "time", problem });
    };
    if time_s > last_s + ROUNDED_S {
        let problem = format!("{time_s} s is after the end of the motion in {name}; give 0 to {last_s:.3}");
        return Err(Failure::Flag { flag: "time", problem });
    }
    Ok(times_s.partition_point(|&instant| instant < time_s).min(times_s.len() - 1))
}

pub fn flag(flag: &'static str, problem: &str) -> Failure {
    Failure::Flag { flag, problem: problem.to_owned() }
}

fn size(text: &str) -> Result<(usize, usize), String> {
    let numbers = text.split_once(['x', '×']).and_then(|(w, h)| w.parse().ok().zip(h.parse().ok()));
    let (width, height) =
        numbers.ok_or_else(|| format!("'{text}' is not a valid size: expected a form such as 1280x960"))?;
    let sides = Picture::SIDES;
    if sides.contains(&width) && sides.contains(&height) {
        return Ok((width, height));
    }
    Err(format!("each side of a picture must be {} to {} pixels long", sides.start(), sides.end()))
}

fn direction(text: &str) -> Result<(f64, f64), String> {
    let numbers = text.split_once(',').and_then(|(turn, rise)| {
        let turn: Option<f64> = turn.trim().parse().ok();
        turn.zip(rise.trim().parse().ok())
    });
    let is_direction = |(turn, rise): &(f64, f64)| turn.abs() <= 360.0 && (-90.0..=90.0).contains(rise);
    numbers.filter(is_direction).ok_or_else(|| {
        format!("'{text}' is not a valid direction: expected two angles in degrees, such as -75,22")
    })
}

fn speed(text: &str) -> Result<f64, String> {
    let speed: Option<f64> = text.parse().ok();
    speed
        .filter(|speed| (0.01..=100.0).contains(speed))
        .ok_or_else(|| format!("'{text}' is not a valid speed: expected a factor from 0.01 to 100"))
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds: Option<f64> = text.parse().ok();
    seconds
        .filter(|s| *s >= 0.0)
        .ok_or_else(|| format!("'{text}' is not a valid time: expected seconds, at least 0"))
}
