use std::path::{Path, PathBuf};
use std::sync::Arc;

use cranny_collision::{Body, Part, World};
use cranny_file::TABLE;
use cranny_grasp::{GraspSet, parse_csv, pose_of_rows};
use cranny_robot::{Robot, RobotOptions};
use cranny_shape::{Solid, Surface, TriangleSoup};
use cranny_spatial::{Pose, Vector};
use cranny_task::Criterion;
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_saphyr::Spanned;

use crate::files::{number_table, yaml};
use crate::layout::released_frame::{FLOOR_M, planning_from_scene};
use crate::layout::released_grasps;
use crate::layout::released_objects::{ObjectEntry, ObjectLibrary};
use crate::robot::file;
use crate::{
    BUILTIN_ROBOTS, BuiltinRobot, Geometry, OpenOptions, Recipe, RobotSource, Scenario, ScenarioError,
    TargetPhysics, panda_mobile, scenario,
};

/// File that identifies a folder as a scenario of the paper's release.
pub(crate) const FILE: &str = "scene.yaml";

/// Opens a folder of the paper's released layout.
///
/// 1. The robot: two folders up; the detailed one under `exact`, the one of boxes under `paper`. If there is none, the built-in
///    robot.
/// 2. Bodies: of the scene, or the exported mesh instead.
/// 3. Start, grasps and IK solutions: the exported ones, which are in the planning frame.
pub(crate) fn open(folder: &Path, options: &OpenOptions) -> Result<Scenario, ScenarioError> {
    let criterion = options.criterion.unwrap_or_default();
    let robot = robot(folder, criterion, options)?;
    open_with(folder, options, robot)
}

/// Opens such a folder with a given robot instead of the released one.
pub(crate) fn open_with(
    folder: &Path,
    options: &OpenOptions,
    (robot, robot_source): (Arc<Robot>, RobotSource),
) -> Result<Scenario, ScenarioError> {
    let criterion = options.criterion.unwrap_or_default();
    let default_geometry = match criterion {
        Criterion::Exact => Geometry::Scene,
        Criterion::Paper => Geometry::Export,
    };
    let geometry = options.geometry.unwrap_or(default_geometry);
    let export = folder.join("export");
    // 2.
    let exported = match geometry {
        Geometry::Scene => None,
        Geometry::Export => Some(Exported::load(&export.join("obstacles.obj"))?),
    };
    let (mut bodies, target, given_physics) = match &exported {
        Some(exported) if criterion == Criterion::Exact => {
            (vec![exported.body()?], None, TargetPhysics::default())
        }
        _ => {
            let (bodies, physics) = scene_bodies(&folder.join(FILE))?;
            let target = bodies.len() - 1;
            (bodies, Some(target), physics)
        }
    };
    bodies.push(Body::floor(FLOOR_M));
    // 3.
    let start_file = export.join("robot_start_conf.csv");
    let start = match options.robot.as_ref().and_then(|_| robot.default_start()) {
        Some(start) => start.to_vec(),
        None => number_table::read(&start_file)?,
    };
    let ik_file = export.join("grasp_IK_solutions.csv");
    let ik = match options.robot {
        None if ik_file.is_file() => number_table::read_configurations(&ik_file, robot.dof())?,
        _ => Vec::new(),
    };
    Scenario {
        criterion,
        robot_source,
        target,
        given_physics,
        grasps: grasps(folder)?,
        ik,
        export: exported.map(|exported| exported.surface),
        ..Scenario::bare(scenario::id_of(folder), robot, World::new(bodies)?, start)
    }
    .on_its_ground(options)?
    .with_checked_start(&start_file.display().to_string())
}

fn robot(
    folder: &Path,
    criterion: Criterion,
    options: &OpenOptions,
) -> Result<(Arc<Robot>, RobotSource), ScenarioError> {
    let name = match criterion {
        Criterion::Exact => "mobile_panda.urdf",
        Criterion::Paper => "mobile_panda_fingersSmallMesh.urdf",
    };
    let released = folder.join("../../robots/franka_panda").join(name);
    if options.robot.is_none() && !released.is_file() {
        return built_in();
    }
    let urdf = options.robot.clone().unwrap_or(released);
    Ok((file::load(&urdf, &RobotOptions::default())?, RobotSource::of(&urdf)))
}

/// Returns the robot that replaces the released one.
fn built_in() -> Result<(Arc<Robot>, RobotSource), ScenarioError> {
    let BuiltinRobot { name, .. } = BUILTIN_ROBOTS[0];
    Ok((panda_mobile()?, RobotSource::Builtin(name)))
}

/// Returns the exported grasps; if there are none, those of the scene.
fn grasps(folder: &Path) -> Result<GraspSet, ScenarioError> {
    let (exported, array) = (folder.join("export/grasps.csv"), folder.join(released_grasps::FILE));
    if !exported.is_file() && array.is_file() {
        return released_grasps::read(&array);
    }
    Ok(parse_csv(&exported, &yaml::text(TABLE, &exported)?)?)
}

/// Exported mesh: obstacles and target in one, in the planning frame.
struct Exported {
    path: PathBuf,
    soup: TriangleSoup,
    surface: Surface,
}

impl Exported {
    fn load(path: &Path) -> Result<Self, ScenarioError> {
        let soup = TriangleSoup::load(path, Vector::repeat(1.0))?;
        let surface = Surface::new(&soup).map_err(|fault| fault.in_file(path))?;
        Ok(Self { path: path.to_owned(), soup, surface })
    }

    /// Returns the enclosed volume as one obstacle that includes the target.
    fn body(&self) -> Result<Body, ScenarioError> {
        let solid = Solid::mesh(&self.soup).map_err(|fault| fault.in_file(&self.path))?;
        Ok(Body::new("obstacles", Pose::identity(), solid))
    }
}

/// File `scene.yaml` as written by the BURG toolkit.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SceneFile {
    #[serde(default)]
    bg_objects: Vec<PlacedObject>,
    #[serde(default)]
    objects: Vec<PlacedObject>,
    object_library_fn: PathBuf,
    // Keys for printed markers on the ground below real scenes.
    #[serde(rename = "ground_area_x")]
    _ground_area_x: Option<IgnoredAny>,
    #[serde(rename = "ground_area_y")]
    _ground_area_y: Option<IgnoredAny>,
    #[serde(rename = "printout")]
    _printout: Option<IgnoredAny>,
    #[serde(rename = "yaml_file_type")]
    _file_type: Option<IgnoredAny>,
    #[serde(rename = "yaml_file_version")]
    _file_version: Option<IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PlacedObject {
    object_type: Spanned<String>,
    pose: Spanned<[[f64; 4]; 4]>,
}

impl PlacedObject {
    fn planning_from_object(&self, scene_file: &Path) -> Result<Pose, ScenarioError> {
        let rows: Vec<f64> = self.pose.value.concat();
        let rows: [f64; 16] = std::array::from_fn(|index| rows[index]);
        let scene_from_object = pose_of_rows(&rows).map_err(|reason| ScenarioError::Pose {
            at: yaml::at(scene_file, self.pose.referenced),
            reason,
        })?;
        Ok(planning_from_scene() * scene_from_object)
    }

    /// Returns the type of the object; the second object of a type is named `<type>-2`, and so on.
    fn name_after(&self, earlier: &[Self]) -> String {
        let name = &self.object_type.value;
        match earlier.iter().filter(|object| object.object_type.value == *name).count() {
            0 => name.clone(),
            count => format!("{name}-{}", count + 1),
        }
    }

    fn entry<'a>(
        &self,
        library: &'a ObjectLibrary,
        scene_file: &Path,
    ) -> Result<&'a ObjectEntry, ScenarioError> {
        library.object(&self.object_type.value).ok_or_else(|| ScenarioError::UnknownObject {
            at: yaml::at(scene_file, self.object_type.referenced),
            name: self.object_type.value.clone(),
            known: library.known(),
        })
    }
}

/// Returns the obstacles of a scene, then its target, and mass and friction of the target.
fn scene_bodies(path: &Path) -> Result<(Vec<Body>, TargetPhysics), ScenarioError> {
    let scene: SceneFile = yaml::read(path)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let library = ObjectLibrary::load(&folder.join(&scene.object_library_fn))?;
    let [target] = &scene.objects[..] else {
        return Err(ScenarioError::TargetCount { path: path.to_owned(), actual: scene.objects.len() });
    };
    let mut bodies: Vec<Body> = Vec::new();
    for (index, object) in scene.bg_objects.iter().enumerate() {
        let planning_from_object = object.planning_from_object(path)?;
        let place = |(object_from_solid, solid)| Part {
            world_from_solid: planning_from_object * object_from_solid,
            solid,
        };
        let parts = library.obstacle(object.entry(&library, path)?)?.into_iter().map(place).collect();
        bodies.push(Body {
            name: object.name_after(&scene.bg_objects[..index]),
            parts,
            tilt_rad: None,
            center_of_mass: None,
        });
    }
    let entry = target.entry(&library, path)?;
    let (solid, physics) = (library.target(entry)?, library.physics(entry)?);
    let name = target.name_after(&scene.bg_objects);
    bodies.push(Body::new(name, target.planning_from_object(path)?, solid));
    Ok((bodies, physics))
}

impl Recipe {
    /// Imports a folder in the paper's released layout for the built-in robot, which has the joints of the released one:
    /// obstacles, target, start, grasps and known IK solutions.
    ///
    /// # Errors
    /// [`ScenarioError`], with file and line where there is one.
    pub fn import_released(folder: &Path) -> Result<Self, ScenarioError> {
        if !folder.join(FILE).is_file() {
            return Err(ScenarioError::NoScenarioFile { folder: folder.to_owned() });
        }
        let options = OpenOptions { geometry: Some(Geometry::Scene), ..OpenOptions::default() };
        Self::of_scenario(&open_with(folder, &options, built_in()?)?)
    }
}
