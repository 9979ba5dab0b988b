use std::fmt::Write as _;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use cranny_file::counted;
use cranny_scenario::{
    OpenOptions, Scenario, SeenOptions, check_free_folder, write_whole_file, write_whole_folder,
};
use cranny_sense::{
    CameraFile, DepthFormat, NamedFile, Noise, PlacedCamera, SensedScene, StoredView, Unseen, Views,
};
use cranny_spatial::other_seed;
use serde::Serialize;

use crate::arguments::Output;
use crate::choices::GeometryArgument;
use crate::failure::Failure;
use crate::file_kind::FileKind;
use crate::number_argument::{positive, share_or_none, whole};
use crate::planning::task::open_scenario;
use crate::{Answer, output_file, progress, text};

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny sense 021 --default-cameras 2 -o views
  cranny sense 021 --cameras cameras.yaml -o views
  cranny sense 021 --cameras cameras.yaml --noise-seed 7 -o views
  cranny sense 021 --default-cameras 1 --format npy --clouds -o views
  cranny sense 031 --default-cameras 8 --noise-seed 1 --scenario -o seen
  cranny plan seen -o plan.json
  cranny verify 031 plan.json
  cranny sense 031 --default-cameras 4 --scenario --known platform -o seen

With --scenario the folder is a scenario of what a robot knows: itself, the target, its grasps, the floor, the obstacles
named by --known, and the views.
All space that no camera has seen to be free is an obstacle. The last line checks such a plan against the true scene.

A file of cameras:
  cameras:
    - {name: left, width: 320, height: 240, field_of_view_deg: 70,
       position_m: [0.2, 0.8, 1.1], look_at_m: [1.0, 0.0, 0.4]}
    - {name: hand, width: 320, height: 240, focal_px: 228,
       frame: link panda_hand, position_m: [0.05, 0, 0.04],
       rotation_rpy_deg: [0, 0, 90]}

Poses are in the frame of the robot's root link, or of a link. The optical frame of a camera has z forward, x to
the right of the image and y down.")]
pub struct SenseArguments {
    /// Built-in scenario, or the folder of one
    #[arg(value_name = "ID")]
    pub id: String,
    /// File of cameras (YAML)
    #[arg(long, value_name = "FILE", required_unless_present = "default_cameras")]
    pub cameras: Option<PathBuf>,
    /// Place this number of cameras around the target instead, at free positions that see it and the space before it, 1 to 8
    #[arg(long, value_name = "N", conflicts_with = "cameras", value_parser = whole::<usize>(1..=8))]
    pub default_cameras: Option<usize>,
    /// Folder to write
    #[arg(long, short, value_name = "FOLDER")]
    pub output: PathBuf,
    /// Format of the depths
    #[arg(long, value_enum, default_value_t = FormatArgument::Png)]
    pub format: FormatArgument,
    /// Draw errors within the bounds of the cameras' sensors from this seed; without it the depths are exact
    #[arg(long, value_name = "N")]
    pub noise_seed: Option<u64>,
    /// Factor on the bounds of all errors: above 1, the sensors violate their model [default: 1]
    #[arg(long, value_name = "FACTOR", requires = "noise_seed", value_parser = positive)]
    pub noise_factor: Option<f64>,
    /// Share of pixels at random places without a depth [default: 0]
    #[arg(long, value_name = "SHARE", requires = "noise_seed", value_parser = share_or_none)]
    pub dropouts: Option<f64>,
    /// Also write the points of each view in the frame of the robot's root link (NAME.pcd)
    #[arg(long)]
    pub clouds: bool,
    /// Write a scenario, as a new folder: robot, start, target, grasps and floor, with the views as obstacles
    #[arg(long)]
    pub scenario: bool,
    /// Treatment of unseen space in that scenario [default: solid]
    #[arg(long, value_enum, requires = "scenario")]
    pub unseen: Option<UnseenArgument>,
    /// Obstacles whose places are known, comma-separated: they belong to that scenario as they are
    #[arg(long, value_name = "NAMES", requires = "scenario", value_delimiter = ',')]
    pub known: Vec<String>,
    /// Robot to use instead of the scenario's
    #[arg(long, value_name = "FILE")]
    pub robot: Option<PathBuf>,
    /// Obstacles of a released scenario: the true boxes, or the inflated mesh that its planners used
    #[arg(long, value_enum)]
    pub geometry: Option<GeometryArgument>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FormatArgument {
    /// Millimetres in a PNG of 16 bits; adds 0.5 mm to the stated depth errors
    Png,
    /// Metres in a `NumPy` array
    Npy,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum UnseenArgument {
    /// It is an obstacle
    Solid,
    /// It is free, as an ordinary occupancy map assumes; for comparison
    Free,
}

/// Output of `sense --json`.
#[derive(Serialize)]
struct Sensed {
    scenario: String,
    views: Vec<SensedView>,
    files: Vec<PathBuf>,
}

#[derive(Serialize)]
struct SensedView {
    name: String,
    width: usize,
    height: usize,
    /// Number of pixels with a valid depth.
    valid: usize,
    /// Number of pixels that show the target; `None` without a target.
    target: Option<usize>,
    nearest_m: Option<f32>,
    farthest_m: Option<f32>,
}

pub fn run(arguments: &SenseArguments, output: Output) -> Result<Answer, Failure> {
    let options = OpenOptions {
        robot: arguments.robot.clone(),
        geometry: arguments.geometry.map(Into::into),
        ..OpenOptions::default()
    };
    if arguments.scenario {
        check_free_folder(&arguments.output)?;
    }
    let scenario = open_scenario(&arguments.id, &options, output)?;
    let scene = scenario.sensed()?;
    let spinner = progress::spinner("rendering", output.quiet);
    let views = cameras(arguments, &scenario, &scene)
        .and_then(|cameras| rendered(arguments, &scenario, &scene, &cameras));
    spinner.finish_and_clear();
    let views = views?;
    let format = match arguments.format {
        FormatArgument::Png => DepthFormat::Png,
        FormatArgument::Npy => DepthFormat::Npy,
    };
    let mut files = views.files(format)?;
    if arguments.clouds {
        files.extend(views.views.iter().map(|StoredView { view, .. }| NamedFile {
            name: format!("{}.pcd", view.name),
            content: view.cloud().pcd_bytes(),
        }));
    }
    let files = if arguments.scenario {
        let unseen = match arguments.unseen {
            Some(UnseenArgument::Free) => Unseen::Free,
            Some(UnseenArgument::Solid) | None => Unseen::Solid,
        };
        let options = SeenOptions { unseen, ..SeenOptions::default() };
        write_whole_folder(&arguments.output, |folder| {
            for file in &files {
                write_whole_file(&folder.join(&file.name), &file.content)?;
            }
            options.write_scenario(&scenario, &arguments.known, folder)
        })?;
        files.iter().map(|file| arguments.output.join(&file.name)).collect()
    } else {
        let files: Vec<output_file::NamedFile> = files.into_iter().map(named).collect();
        output_file::write_all(&arguments.output, &files, output)?
    };
    let sensed = Sensed::of(&scenario, &views, files);
    text::answer(&sensed, || sensed.page(), output)?;
    Ok(Answer::Done)
}

fn named(file: NamedFile) -> output_file::NamedFile {
    let kind = match file.name.rsplit_once('.') {
        Some((_, "png")) => FileKind::Png,
        Some((_, "npy")) => FileKind::Npy,
        Some((_, "pcd")) => FileKind::Pcd,
        _ => FileKind::Views,
    };
    output_file::NamedFile { name: file.name, kind, content: file.content }
}

fn cameras(
    arguments: &SenseArguments,
    scenario: &Scenario,
    scene: &SensedScene,
) -> Result<Vec<PlacedCamera>, Failure> {
    match (&arguments.cameras, arguments.default_cameras) {
        (Some(file), _) => Ok(CameraFile::read(file)?.cameras),
        (None, count) => Ok(scenario.default_cameras(scene, count.unwrap_or(1))?),
    }
}

fn rendered(
    arguments: &SenseArguments,
    scenario: &Scenario,
    scene: &SensedScene,
    cameras: &[PlacedCamera],
) -> Result<Views, Failure> {
    let mut views = Vec::new();
    for (index, placed) in cameras.iter().enumerate() {
        let camera = placed.at(&scenario.robot, &scenario.start)?;
        let moved = placed.configuration.as_ref().map(|q| scenario.sensed_at(q)).transpose()?;
        let scene = moved.as_ref().unwrap_or(scene);
        let noise = Noise {
            factor: if arguments.noise_seed.is_some() { arguments.noise_factor.unwrap_or(1.0) } else { 0.0 },
            dropout_share: arguments.dropouts.unwrap_or(0.0),
            seed: other_seed(arguments.noise_seed.unwrap_or(0), index as u64),
            ..Noise::default()
        };
        let view = scene.view(&placed.name, &camera, &placed.sensor, &noise)?;
        let view = view.at_configuration(placed.configuration.clone());
        views.push(StoredView { view, segments: Some(scene.render(&camera).segments) });
    }
    Ok(Views { views, segments: scene.segments().to_vec() })
}

impl Sensed {
    fn of(scenario: &Scenario, views: &Views, files: Vec<PathBuf>) -> Self {
        let target = scenario.target_segment();
        let of_view = |StoredView { view, segments }: &StoredView| {
            let depths = view.depth.depths_m().iter().filter(|depth_m| !depth_m.is_nan());
            let count = |number| segments.iter().flatten().filter(|segment| **segment == number).count();
            SensedView {
                name: view.name.clone(),
                width: view.camera.width_px,
                height: view.camera.height_px,
                valid: view.depth.valid_count(),
                target: target.map(count),
                nearest_m: depths.clone().copied().reduce(f32::min),
                farthest_m: depths.copied().reduce(f32::max),
            }
        };
        Self { scenario: scenario.id.clone(), views: views.views.iter().map(of_view).collect(), files }
    }

    fn page(&self) -> String {
        let mut page = format!("{}: {}\n", self.scenario, counted(self.views.len(), "view"));
        for view in &self.views {
            let valid = 100.0 * view.valid as f64 / (view.width * view.height) as f64;
            let range = match view.nearest_m.zip(view.farthest_m) {
                Some((nearest_m, farthest_m)) => format!(", {nearest_m:.3} to {farthest_m:.3} m"),
                None => String::new(),
            };
            let target = view
                .target
                .map_or_else(String::new, |count| format!(", the target in {}", counted(count, "pixel")));
            let _ = writeln!(
                page,
                "  {:<12}{} × {} pixels, {valid:.1} % with a depth{range}{target}",
                view.name, view.width, view.height
            );
        }
        let folder = self.files.first().and_then(|file| file.parent());
        if let Some(folder) = folder {
            let _ = writeln!(page, "  {:<12}{}", "written to", folder.display());
        }
        page
    }
}
