use std::fmt::Write;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use cranny_scenario::{
    DEFAULT_FRICTION, Friction, OBJECT_FILE, ObjectSettings, ObjectType, RestingPose, ScenarioError,
    builtin_object, builtin_object_names, check_free_folder, write_whole_file, write_whole_folder,
};
use cranny_shape::{DecompositionSettings, RepairedMesh, TriangleSoup, VolumeError, mesh_colour};
use cranny_spatial::Vector;
use cranny_view::{Picture, PictureSettings, Scene, StandardView};
use serde::Serialize;

use crate::arguments::Output;
use crate::failure::Failure;
use crate::file_kind::FileKind;
use crate::number_argument::{positive, whole};
use crate::{Answer, output_file, progress, text};

#[derive(Clone, Debug, Args)]
pub struct ObjectArguments {
    #[command(subcommand)]
    pub command: ObjectCommand,
}

#[derive(Clone, Debug, Subcommand)]
pub enum ObjectCommand {
    /// List the built-in objects
    List,
    /// Show an object: size, mass, convex parts, stable poses; or size and volume of a mesh file
    Show(ShowArguments),
    /// Create an object from a mesh: repair it, decompose it into convex parts, compute its inertia and its stable poses
    Add(AddArguments),
    /// Write a built-in object as a folder, to change it or use it elsewhere
    Export(ExportArguments),
}

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny object show banana
  cranny object show banana --picture banana.png
  cranny object show path/to/mug --json")]
pub struct ShowArguments {
    /// Built-in object, the folder of one, or a mesh file without an object folder
    #[arg(value_name = "OBJECT")]
    pub object: String,
    /// Also render it to this PNG file
    #[arg(long, value_name = "FILE")]
    pub picture: Option<PathBuf>,
}

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny object add mug.obj --mass 0.118
  cranny object add box.stl --mass 0.4 --scale 0.001 -o objects/box

The mesh must enclose a volume. Doubled vertices and faces the wrong way round are repaired; holes and
faces that pass through each other are not.")]
pub struct AddArguments {
    /// Mesh file: OBJ, STL, PLY, DAE or MSH, in metres
    #[arg(value_name = "MESH")]
    pub mesh: PathBuf,
    /// Mass in kilograms
    #[arg(long, value_name = "KG")]
    pub mass: f64,
    /// Coefficient of friction between the object and the pads of a gripper, or its range, such as 0.35..0.6
    #[arg(long, value_name = "MU", default_value_t = DEFAULT_FRICTION.into())]
    pub friction: Friction,
    /// Factor that scales the mesh's coordinates: 0.001 for millimetres
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = positive)]
    pub scale: f64,
    /// Maximum number of convex parts
    #[arg(long, value_name = "N", default_value_t = DecompositionSettings::default().most_parts,
          value_parser = whole::<u32>(1..=10_000))]
    pub parts: u32,
    /// Resolution of the decomposition: number of voxels along the longest side
    #[arg(long, value_name = "N", default_value_t = DecompositionSettings::default().resolution,
          value_parser = whole::<u32>(8..=400))]
    pub resolution: u32,
    /// Name of the object [default: the name of the mesh file]
    #[arg(long)]
    pub name: Option<String>,
    /// Folder to write [default: the object's name, in this folder]
    #[arg(long, short, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
}

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny object export flat_screwdriver
  cranny object export banana -o objects/banana")]
pub struct ExportArguments {
    /// Built-in object
    #[arg(value_name = "OBJECT")]
    pub object: String,
    /// Folder to write [default: the object's name, in this folder]
    #[arg(long, short, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
}

/// Output of `object show` and `object add` with `--json`.
#[derive(Serialize)]
struct Shown {
    object: String,
    size_m: [f64; 3],
    triangles: usize,
    volume_m3: f64,
    mass_kg: f64,
    friction: Friction,
    center_of_mass: [f64; 3],
    inertia_kg_m2: [[f64; 3]; 3],
    convex_parts: usize,
    volume_error: VolumeError,
    stable_poses: Vec<RestingPose>,
    repaired: Option<RepairedMesh>,
    folder: Option<PathBuf>,
    picture: Option<PathBuf>,
}

/// Output of `object show` for a mesh file.
#[derive(Serialize)]
struct ShownMesh {
    mesh: PathBuf,
    size_m: [f64; 3],
    triangles: usize,
    volume_m3: f64,
    repaired: RepairedMesh,
}

impl ShownMesh {
    fn of(path: &Path) -> Result<Self, ScenarioError> {
        let repaired = TriangleSoup::load(path, Vector::repeat(1.0)).and_then(|soup| RepairedMesh::of(&soup));
        let repaired = repaired.map_err(|fault| ScenarioError::from(fault).in_mesh(path))?;
        Ok(Self {
            mesh: path.to_owned(),
            size_m: size_m(&repaired.soup),
            triangles: repaired.soup.triangles.len(),
            volume_m3: repaired.soup.signed_volume_m3(),
            repaired,
        })
    }

    fn page(&self) -> String {
        let (mesh, litres) = (self.mesh.display(), self.volume_m3 * 1000.0);
        let [x, y, z] = self.size_m.map(|size| size * 1000.0);
        format!(
            "{mesh}\n  size          {x:.1} × {y:.1} × {z:.1} mm, {} triangles\n  volume        {litres:.4} l\n\
             an object is made of it by: cranny object add {mesh} --mass KG\n",
            self.triangles
        )
    }
}

/// Returns the side lengths of the bounding box of a mesh, in metres.
fn size_m(mesh: &TriangleSoup) -> [f64; 3] {
    let first = mesh.vertices[0];
    let (low, high) = mesh.vertices.iter().fold((first, first), |(l, h), p| (l.inf(p), h.sup(p)));
    (high - low).into()
}

/// Opens the object that `what` names: a built-in one, or a folder.
pub fn open(what: &str) -> Result<ObjectType, ScenarioError> {
    let folder = Path::new(what);
    if folder.join(OBJECT_FILE).is_file() { ObjectType::read_folder(folder) } else { builtin_object(what) }
}

pub fn run(arguments: &ObjectArguments, output: Output) -> Result<Answer, Failure> {
    match &arguments.command {
        ObjectCommand::List => list(output),
        ObjectCommand::Show(ShowArguments { object, picture: None }) if Path::new(object).is_file() => {
            let mesh = ShownMesh::of(Path::new(object))?;
            text::answer(&mesh, || mesh.page(), output)?;
            Ok(Answer::Done)
        }
        ObjectCommand::Show(arguments) => {
            let object = open(&arguments.object)?;
            if let Some(file) = &arguments.picture {
                let picture = drawn(&object, file, PICTURE_POINTS)?;
                output_file::write(file, FileKind::Png, &picture, output)?;
            }
            show(&Shown { picture: arguments.picture.clone(), ..Shown::of(&object) }, output)
        }
        ObjectCommand::Add(arguments) => add(arguments, output),
        ObjectCommand::Export(arguments) => {
            let folder = PathBuf::from(&arguments.object);
            if folder.join(OBJECT_FILE).is_file() {
                let problem =
                    "this is an object folder already: copy and edit it directly (only built-in objects are \
                     exported)"
                        .to_owned();
                return Err(Failure::File { path: folder, problem });
            }
            let object = builtin_object(&arguments.object)?;
            let folder = arguments.output.clone().unwrap_or_else(|| arguments.object.clone().into());
            written(Shown::of(&object), &object, folder, output)
        }
    }
}

fn list(output: Output) -> Result<Answer, Failure> {
    let names = builtin_object_names();
    let page = || format!("{}\n\nTry: cranny object show {}\n", names.join("\n"), names[0]);
    text::answer(&names, page, output.aloud())?;
    Ok(Answer::Done)
}

fn add(arguments: &AddArguments, output: Output) -> Result<Answer, Failure> {
    let stem = arguments.mesh.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let settings = ObjectSettings {
        friction: arguments.friction,
        decomposition: DecompositionSettings {
            resolution: arguments.resolution,
            most_parts: arguments.parts,
            ..DecompositionSettings::default()
        },
        ..ObjectSettings::new(arguments.name.clone().unwrap_or(stem), arguments.mass)
    };
    let folder = arguments.output.clone().unwrap_or_else(|| settings.name.clone().into());
    // Checks the folder before the decomposition.
    check_free_folder(&folder)?;
    let spinner = progress::spinner("repairing, cutting into convex parts", output.quiet);
    let soup = TriangleSoup::load(&arguments.mesh, Vector::repeat(arguments.scale));
    let made = soup.map_err(ScenarioError::from).and_then(|soup| ObjectType::from_mesh(&soup, &settings));
    spinner.finish_and_clear();
    let (mut object, repaired) = made.map_err(|fault| fault.in_mesh(&arguments.mesh))?;
    object.colour = mesh_colour(&arguments.mesh);
    written(Shown { repaired: Some(repaired), ..Shown::of(&object) }, &object, folder, output)
}

fn written(
    mut shown: Shown,
    object: &ObjectType,
    folder: PathBuf,
    output: Output,
) -> Result<Answer, Failure> {
    let thumbnail = folder.join(THUMBNAIL);
    let picture = drawn(object, &thumbnail, THUMBNAIL_POINTS)?;
    write_whole_folder(&folder, |folder| {
        object.write_folder(folder)?;
        write_whole_file(&folder.join(THUMBNAIL), &picture)
    })?;
    shown.picture = Some(thumbnail);
    shown.folder = Some(folder);
    show(&shown, output)
}

/// File name of the picture in an object's folder; the constants below are side lengths in pixels.
const THUMBNAIL: &str = "thumbnail.png";
const THUMBNAIL_POINTS: usize = 256;
const PICTURE_POINTS: usize = 640;

/// Renders an object and returns the bytes of a PNG file.
fn drawn(object: &ObjectType, file: &Path, side: usize) -> Result<Vec<u8>, Failure> {
    let settings = PictureSettings { width: side, height: side, samples: 8, ..PictureSettings::default() };
    let picture = Picture::of(&Scene::of_object(object), StandardView::ThreeQuarter, &settings)?;
    Ok(picture.png(file)?)
}

fn show(shown: &Shown, output: Output) -> Result<Answer, Failure> {
    text::answer(shown, || shown.page(), output)?;
    Ok(Answer::Done)
}

/// Maximum number of stable poses printed; `--json` lists all.
const POSES_SHOWN: usize = 12;

impl Shown {
    fn of(object: &ObjectType) -> Self {
        let inertia = &object.inertia_kg_m2;
        Self {
            object: object.name.clone(),
            size_m: size_m(&object.mesh),
            triangles: object.mesh.triangles.len(),
            volume_m3: object.volume_m3,
            mass_kg: object.mass_kg,
            friction: object.friction,
            center_of_mass: object.center_of_mass.into(),
            inertia_kg_m2: [0, 1, 2].map(|i| [0, 1, 2].map(|j| inertia[(i, j)])),
            convex_parts: object.parts.parts.len(),
            volume_error: object.parts.error,
            stable_poses: object.stable_poses.iter().map(RestingPose::of).collect(),
            repaired: None,
            folder: None,
            picture: None,
        }
    }

    fn page(&self) -> String {
        let mut page = format!("{}\n", self.object);
        let mut line = |name: &str, value: String| {
            let _ = writeln!(page, "  {name:<14}{value}");
        };
        let [x, y, z] = self.size_m.map(|size| size * 1000.0);
        line("size", format!("{x:.1} × {y:.1} × {z:.1} mm, {} triangles", self.triangles));
        let litres = self.volume_m3 * 1000.0;
        line("mass", format!("{} kg, {litres:.4} l, friction {}", self.mass_kg, self.friction));
        let VolumeError { excess, missing } = self.volume_error;
        let (excess, missing) = (excess * 100.0, missing * 100.0);
        let parts = self.convex_parts;
        line("convex parts", format!("{parts}: {excess:.2} % too much, {missing:.2} % missing"));
        for (index, pose) in self.stable_poses.iter().enumerate().take(POSES_SHOWN) {
            let name = if index == 0 { "rests" } else { "" };
            let height = text::millimetres(pose.position[2]);
            let percent = pose.probability * 100.0;
            line(name, format!("pose {index}: {percent:.1} %, origin {height} above the ground"));
        }
        if self.stable_poses.len() > POSES_SHOWN {
            line("", format!("{} more", self.stable_poses.len() - POSES_SHOWN));
        }
        if let Some(repaired) = &self.repaired {
            line(
                "repaired",
                format!(
                    "{} vertices merged, {} triangles left out, {} turned round, {} shallow folds left",
                    repaired.merged_vertices,
                    repaired.dropped_triangles,
                    repaired.flipped_triangles,
                    repaired.shallow_crossings
                ),
            );
        }
        if let Some(folder) = &self.folder {
            line("written to", folder.display().to_string());
        }
        if let Some(picture) = &self.picture {
            line("picture", picture.display().to_string());
        }
        page
    }
}
