use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use cranny_collision::{Body, Part, World};
use cranny_file::{TABLE, TEXT, did_you_mean};
use cranny_grasp::{GraspError, GraspSet, parse_csv};
use cranny_robot::{JointGroup, Location, Robot, RobotOptions, TextSource};
use cranny_sense::{View, Views};
use cranny_shape::{ShapeError, Solid};
use cranny_spatial::{EXACT_ROTATION_RAD, Pose, Rotation, Vector};
use cranny_task::{PlaceGoal, PlaceRegion};
use serde_saphyr::Spanned;

use crate::cloud_obstacle::cloud_obstacle;
use crate::files::mesh_solids::{MeshSolids, SolidOfMesh};
use crate::files::{number_table, sizes, yaml};
use crate::layout::own_file::{BodyEntry, MeshEntry, PlaceEntry, PoseEntry, ScenarioFile, ShapeEntry};
use crate::robot::file;
use crate::scenario::in_frame;
use crate::{
    BodyColours, BuiltinRobot, CloudCounts, Friction, OBJECT_FILE, ObjectSource, ObjectType, OpenOptions,
    RobotSource, Scenario, ScenarioError, TargetPhysics, scenario,
};

/// File that identifies a folder as a scenario in Cranny's layout.
pub(crate) const FILE: &str = "scenario.yaml";

/// Texts of a scenario in Cranny's layout, and the folder of its further files.
pub(crate) struct Texts {
    /// Folder of the files, also used in error messages.
    pub folder: PathBuf,
    pub scenario: String,
    /// Grasps; `None`: no set of grasps is given, and planners compute their own.
    pub grasps: Option<String>,
    pub ik: Option<String>,
}

impl Texts {
    /// Reads a folder: `scenario.yaml` and, if they exist, `grasps.csv` and `ik.csv`.
    fn read(folder: &Path) -> Result<Self, ScenarioError> {
        let scenario = yaml::text(TEXT, &folder.join(FILE))?;
        let grasps = folder.join(GRASPS_FILE);
        let grasps = if is_there(&grasps)? { Some(grasps_text(&grasps)?) } else { None };
        let ik = folder.join(IK_FILE);
        let ik = if ik.is_file() { Some(yaml::text(TABLE, &ik)?) } else { None };
        Ok(Self { folder: folder.to_owned(), scenario, grasps, ik })
    }
}

/// Returns true if the path exists; a missing permission is an error.
pub(crate) fn is_there(path: &Path) -> Result<bool, ScenarioError> {
    cranny_file::is_there(path).map_err(|reason| ScenarioError::Unreadable { path: path.to_owned(), reason })
}

fn grasps_text(path: &Path) -> Result<String, GraspError> {
    TABLE.text(path).map_err(|reason| GraspError::Unreadable { path: path.to_owned(), reason })
}

pub(crate) const GRASPS_FILE: &str = "grasps.csv";

pub(crate) const IK_FILE: &str = "ik.csv";

/// Opens a folder in Cranny's layout.
pub(crate) fn open(folder: &Path, options: &OpenOptions) -> Result<Scenario, ScenarioError> {
    open_texts(scenario::id_of(folder), &Texts::read(folder)?, options)
}

/// Opens a scenario from texts.
pub(crate) fn open_texts(
    id: String,
    texts: &Texts,
    options: &OpenOptions,
) -> Result<Scenario, ScenarioError> {
    let folder = &texts.folder;
    let path = folder.join(FILE);
    let file: ScenarioFile = yaml::parse(&path, &texts.scenario)?;
    let layout = Layout { folder, path: &path, meshes: MeshSolids::default() };
    let (robot, robot_source) = layout.robot(&file, options)?;
    let robot = layout.with_bounded_joints(robot, &file)?;
    let planning_from_scene = layout.pose(file.frame.as_ref())?.inverse();

    let mut colours = BodyColours::new();
    let (mut bodies, mut clouds): (Vec<Body>, Vec<CloudCounts>) = (Vec::new(), Vec::new());
    let (mut names, mut body_frames, mut sources) = (HashSet::new(), BTreeMap::new(), BTreeMap::new());
    let mut objects_kg = BTreeMap::new();
    for entry in &file.obstacles {
        layout.check_name(entry, &mut names)?;
        let read = layout.body(entry, &planning_from_scene, Solid::mesh_with_small_holes)?;
        body_frames.extend(read.frame.map(|frame| (read.body.name.clone(), frame)));
        sources.extend(read.source.map(|source| (read.body.name.clone(), source)));
        objects_kg.extend(read.objects_kg.map(|mass_kg| (read.body.name.clone(), mass_kg)));
        bodies.push(read.body);
        clouds.extend(read.clouds);
        layout.add_colours(entry, &mut colours)?;
    }
    let mut given_physics = TargetPhysics::default();
    if let Some(entry) = &file.target {
        layout.check_name(entry, &mut names)?;
        layout.refuse_cloud(entry)?;
        given_physics = layout.physics_of(entry)?;
        let read = layout.body(entry, &planning_from_scene, Solid::mesh)?;
        given_physics.mass_kg = given_physics.mass_kg.or(read.objects_kg);
        sources.extend(read.source.map(|source| (read.body.name.clone(), source)));
        layout.add_colours(entry, &mut colours)?;
        body_frames.extend(read.frame.map(|frame| (read.body.name.clone(), frame)));
        bodies.push(read.body);
    }
    let target = file.target.as_ref().map(|_| bodies.len() - 1);
    if let Some(height) = &file.floor {
        bodies.push(layout.floor(height, &planning_from_scene)?);
    }
    let places = layout.places(&file, &planning_from_scene)?;
    let regions = in_frame(&file.regions, &planning_from_scene);
    let ik = match (&options.robot, &texts.ik) {
        (None, Some(text)) => number_table::parse_configurations(&folder.join(IK_FILE), text, robot.dof())?,
        _ => Vec::new(),
    };
    let world = World::new(bodies)?.with_up(&(planning_from_scene.rotation * Vector::z()));
    let world = layout.with_tool_bounds((world, &robot), &file, &planning_from_scene)?;
    let criterion = options.criterion.or(file.criterion).unwrap_or_default();
    let grasps_file = folder.join(GRASPS_FILE);
    let stated = match &texts.grasps {
        Some(text) => parse_csv(&grasps_file, text)?,
        None if target.is_some() || !regions.is_empty() => GraspSet::default(),
        // Without a target the grasps cannot be computed.
        None => parse_csv(&grasps_file, &grasps_text(&grasps_file)?)?,
    };
    // Loads are valid only for the hand that the scenario names.
    let grasps = if options.robot.is_some() { stated.without_loads() } else { stated };
    let scenario = Scenario {
        id,
        criterion,
        start: layout.start(&file, &robot, options)?,
        robot,
        robot_source,
        world,
        target,
        sources,
        body_frames,
        given_physics,
        grasps,
        has_grasp_set: texts.grasps.is_some() || target.is_none(),
        ik,
        places,
        regions,
        tasks: layout.tasks(&file, &planning_from_scene)?,
        physics: with_masses(layout.physics_of_obstacles(&file)?, objects_kg),
        colours,
        speeds: layout.speeds(&file)?,
        joint_bounds: file
            .joint_bounds
            .iter()
            .map(|(joint, between)| (joint.clone(), between.value))
            .collect(),
        export: None,
        seen: None,
        clouds,
    }
    .on_its_ground(options)?
    .with_checked_start(&layout.at(file.start_place()).to_string())?;
    let Some(seen) = &file.seen else { return Ok(scenario) };
    let views = Views::read(&folder.join(&seen.value.views))?;
    let views: Vec<View> = views.views.into_iter().map(|stored| stored.view).collect();
    scenario.with_seen(&views, &seen.value.options())
}

/// Returns stated masses and frictions, with these masses (kg) of the bodies that state none.
fn with_masses(
    mut physics: BTreeMap<String, TargetPhysics>,
    masses: BTreeMap<String, f64>,
) -> BTreeMap<String, TargetPhysics> {
    for (name, mass_kg) in masses {
        physics.entry(name).or_default().mass_kg.get_or_insert(mass_kg);
    }
    physics
}

pub(crate) const FLOOR: &str = "floor";

/// Body as read.
pub(crate) struct ReadBody {
    pub body: Body,
    /// Its frame in that of its first shape, if it has several shapes.
    pub frame: Option<Pose>,
    /// Its object, if it is a single one.
    pub source: Option<ObjectSource>,
    /// Sum of the masses of its objects (kg), if it consists of several and of nothing else.
    pub objects_kg: Option<f64>,
    /// Numbers of points of its clouds.
    pub clouds: Vec<CloudCounts>,
}

/// Solid of a shape as read: with its object, if it is one, or the numbers of points of its cloud.
type ReadShape = (Solid, Option<ObjectSource>, Option<CloudCounts>);

/// Folder that is read, and file that errors name.
pub(crate) struct Layout<'a> {
    pub folder: &'a Path,
    pub path: &'a Path,
    /// Meshes that were read.
    pub meshes: MeshSolids,
}

impl Layout<'_> {
    pub fn at(&self, location: serde_saphyr::Location) -> Location {
        yaml::at(self.path, location)
    }

    /// Checks that the name of a body is neither that of the floor nor in `taken`, and adds it to `taken`.
    pub fn check_name<'b>(
        &self,
        entry: &'b BodyEntry,
        taken: &mut HashSet<&'b str>,
    ) -> Result<(), ScenarioError> {
        let name = &entry.name.value;
        if name.trim().is_empty() || name.contains(['\n', '\r']) {
            return Err(ScenarioError::UnreadableName {
                at: self.at(entry.name.referenced),
                name: name.clone(),
            });
        }
        if name == FLOOR || !taken.insert(name) {
            let at = self.at(entry.name.referenced);
            return Err(ScenarioError::NameTaken { at, name: name.clone() });
        }
        Ok(())
    }

    pub fn floor(&self, height: &Spanned<f64>, planning_from_scene: &Pose) -> Result<Body, ScenarioError> {
        let height_m = yaml::finite(self.path, height.value, height.referenced)?;
        let planning_from_floor = planning_from_scene * Pose::translation(0.0, 0.0, height_m);
        Ok(Body::new(FLOOR, planning_from_floor, Solid::half_space()))
    }

    pub fn robot(
        &self,
        file: &ScenarioFile,
        options: &OpenOptions,
    ) -> Result<(Arc<Robot>, RobotSource), ScenarioError> {
        if let Some(other) = &options.robot {
            return Ok((file::load(other, &RobotOptions::default())?, RobotSource::of(other)));
        }
        let robot_options = RobotOptions {
            srdf: file.srdf.as_ref().map(|srdf| TextSource::Path(self.folder.join(srdf))),
            group: file.group.clone().map_or(JointGroup::RootToTip, JointGroup::Srdf),
            tip: file.tip.clone(),
            fixed: file.fixed.clone(),
            unchecked_pairs: file.unchecked_pairs.clone(),
            packages: file.packages.iter().map(|folder| self.folder.join(folder)).collect(),
            ..RobotOptions::default()
        };
        let name = &file.robot.value;
        let pairs = &robot_options.unchecked_pairs;
        let exempting = RobotOptions { unchecked_pairs: pairs.clone(), ..RobotOptions::default() };
        let source_of = |source| match robot_options == exempting {
            true if pairs.is_empty() => source,
            true => RobotSource::Exempting(Box::new(source), pairs.clone()),
            false => RobotSource::Other,
        };
        if let Some(builtin) = BuiltinRobot::of_name(name) {
            return Ok((builtin.robot(&robot_options)?, source_of(RobotSource::Builtin(builtin.name))));
        }
        let path = self.folder.join(name);
        if !path.exists() {
            let (at, name) = (self.at(file.robot.referenced), name.clone());
            return Err(ScenarioError::UnknownRobot { at, name, path, known: BuiltinRobot::known() });
        }
        let robot = file::load(&path, &robot_options)?;
        Ok((robot, source_of(RobotSource::Files(path))))
    }

    /// Returns the body. A target must be closed; an obstacle may have small holes.
    pub fn body(
        &self,
        entry: &BodyEntry,
        planning_from_scene: &Pose,
        mesh: SolidOfMesh,
    ) -> Result<ReadBody, ScenarioError> {
        let planning_from_body = planning_from_scene * self.pose(entry.pose.as_ref())?;
        let name = &entry.name.value;
        let (mut parts, mut sources, mut clouds) = (Vec::new(), Vec::new(), Vec::new());
        for shape in &entry.shapes {
            let world_from_solid = planning_from_body * self.pose(shape.value.pose.as_ref())?;
            let (solid, source, counts) = self.solid(shape, name, mesh)?;
            parts.push(Part { world_from_solid, solid });
            sources.push(source);
            clouds.extend(counts);
        }
        if parts.is_empty() {
            return Err(ScenarioError::ShapeCount { at: self.at(entry.name.referenced), actual: 0 });
        }
        // Several objects that are one body weigh their sum.
        let masses: Option<Vec<f64>> =
            sources.iter().map(|source: &Option<ObjectSource>| source.as_ref()?.physics().mass_kg).collect();
        let objects_kg = masses.filter(|masses| masses.len() > 1).map(|masses| masses.iter().sum());
        let source = if sources.len() == 1 { sources.pop().flatten() } else { None };
        let tilt_rad = entry.upright_deg.as_ref().map(|degrees| self.upright(degrees)).transpose()?;
        let frame = match &parts[..] {
            [first, _, ..] => Some(first.world_from_solid.inverse() * planning_from_body),
            _ => None,
        };
        // An object's file states its centre of mass; solids of the body are in the frame of the object.
        let center_of_mass = source.as_ref().and_then(ObjectSource::own).map(|own| own.center_of_mass);
        let body = Body { name: name.clone(), parts, tilt_rad, center_of_mass };
        Ok(ReadBody { body, frame, source, objects_kg, clouds })
    }

    /// Returns the place goals of the target.
    pub fn places(
        &self,
        file: &ScenarioFile,
        planning_from_scene: &Pose,
    ) -> Result<Vec<PlaceGoal>, ScenarioError> {
        let obstacles = file.obstacle_names();
        let mut taken = HashSet::new();
        let place = |entry| self.place(entry, (file, &obstacles), planning_from_scene, &mut taken);
        file.places.iter().map(place).collect()
    }

    /// Returns a place goal, on one of the obstacles of these names; adds its own name to `taken`.
    pub fn place<'b>(
        &self,
        entry: &'b Spanned<PlaceEntry>,
        (file, obstacles): (&ScenarioFile, &HashSet<&str>),
        planning_from_scene: &Pose,
        taken: &mut HashSet<&'b str>,
    ) -> Result<PlaceGoal, ScenarioError> {
        let Spanned { value: PlaceEntry { name, on, pose, size, target_pose }, referenced, .. } = entry;
        let refuse = |problem: String| ScenarioError::Place { at: self.at(*referenced), problem };
        if !taken.insert(&name.value) {
            return Err(ScenarioError::NameTaken { at: self.at(name.referenced), name: name.value.clone() });
        }
        let spot = match (on, size, pose, target_pose) {
            (None, None, None, Some(target_pose)) => {
                let Some(target) = &file.target else {
                    return Err(refuse("`target_pose` needs a target, but the scenario has none".to_owned()));
                };
                let body_from_first = target.shapes.first().map(|shape| self.pose(shape.value.pose.as_ref()));
                let planning_from_body = planning_from_scene * self.pose(Some(target_pose))?;
                PlaceRegion::Target(planning_from_body * body_from_first.transpose()?.unwrap_or_default())
            }
            (Some(on), Some(size_m), _, None) => {
                let is_floor = on == FLOOR && file.floor.is_some();
                if !is_floor && !obstacles.contains(on.as_str()) {
                    let floor = file.floor.as_ref().map(|_| FLOOR);
                    let known = file.obstacles.iter().map(|obstacle| obstacle.name.value.as_str());
                    let known = known.chain(floor).collect::<Vec<_>>().join(", ");
                    let meant = did_you_mean(on, known.split(", "));
                    return Err(refuse(format!("unknown obstacle '{on}' (known: {known}){meant}")));
                }
                if !size_m.iter().all(|size_m| size_m.is_finite() && *size_m > 0.0) {
                    return Err(refuse(format!(
                        "{size_m:?} is not a valid size of a rectangle: both numbers must be positive"
                    )));
                }
                let pose = planning_from_scene * self.pose(pose.as_ref())?;
                // Up is the z axis of the scene, independent of the robot's orientation.
                let tilt = (pose.rotation * Vector::z() - planning_from_scene.rotation * Vector::z()).norm();
                if tilt > EXACT_ROTATION_RAD {
                    return Err(refuse("the rectangle is not level: its z axis must point up".to_owned()));
                }
                PlaceRegion::Surface { on: on.clone(), pose, size_m: *size_m }
            }
            _ => {
                return Err(refuse(
                    "a place is a rectangle, with `on` and `size`, or a `target_pose`, and not both"
                        .to_owned(),
                ));
            }
        };
        Ok(PlaceGoal { name: name.value.clone(), spot })
    }

    /// Returns mass and friction of an entry.
    pub fn physics(
        &self,
        mass_kg: Option<&Spanned<f64>>,
        friction: Option<&Spanned<Friction>>,
    ) -> Result<TargetPhysics, ScenarioError> {
        let mass_kg =
            mass_kg.map(|n| yaml::positive(self.path, "mass", n.value, n.referenced)).transpose()?;
        let friction = friction.map(|n| yaml::friction(self.path, n.value, n.referenced)).transpose()?;
        Ok(TargetPhysics { mass_kg, friction, ..TargetPhysics::default() })
    }

    /// Returns mass, friction and rolling resistance of a body.
    pub fn physics_of(&self, entry: &BodyEntry) -> Result<TargetPhysics, ScenarioError> {
        let physics = self.physics(entry.mass_kg.as_ref(), entry.friction.as_ref())?;
        // Zero is a valid rolling resistance.
        let given = entry.rolling_m.as_ref();
        let some = given.filter(|rolling_m| rolling_m.value != 0.0);
        some.map(|n| yaml::positive(self.path, "rolling_m", n.value, n.referenced)).transpose()?;
        Ok(TargetPhysics { rolling_m: given.map(|rolling_m| rolling_m.value), ..physics })
    }

    /// Returns all faults of a body except those of its name.
    pub fn body_faults(&self, entry: &BodyEntry, mesh: SolidOfMesh) -> Vec<ScenarioError> {
        let mut faults: Vec<ScenarioError> = self.pose(entry.pose.as_ref()).err().into_iter().collect();
        for shape in &entry.shapes {
            faults.extend(self.pose(shape.value.pose.as_ref()).err());
            faults.extend(self.solid(shape, &entry.name.value, mesh).err());
            faults.extend(self.stated_colour(shape).err());
        }
        if entry.shapes.is_empty() {
            faults.push(ScenarioError::ShapeCount { at: self.at(entry.name.referenced), actual: 0 });
        }
        faults
    }

    /// Returns the pose of an entry, in the frame of its body for a shape, otherwise in the scene frame; default: the identity.
    pub fn pose(&self, entry: Option<&Spanned<PoseEntry>>) -> Result<Pose, ScenarioError> {
        let Some(Spanned { value: entry, referenced, .. }) = entry else { return Ok(Pose::identity()) };
        let given = [&entry.position[..], entry.rotation_rpy_deg.as_ref().map_or(&[], |rpy| &rpy[..])];
        for number in given.concat() {
            yaml::finite(self.path, number, *referenced)?;
        }
        let rotation = match (entry.rotation_rpy_deg, entry.quaternion_xyzw) {
            (None, None) => Rotation::identity(),
            (Some(rpy_deg), None) => {
                let [roll, pitch, yaw] = rpy_deg.map(f64::to_radians);
                Rotation::from_euler_angles(roll, pitch, yaw)
            }
            (None, Some(quaternion)) => yaml::rotation(self.path, quaternion, *referenced)?,
            (Some(_), Some(_)) => return Err(ScenarioError::TwoRotations { at: self.at(*referenced) }),
        };
        Ok(Pose::from_parts(Vector::from(entry.position).into(), rotation))
    }

    fn mesh_solid(&self, entry: &MeshEntry, of_mesh: Option<SolidOfMesh>) -> Result<Solid, ShapeError> {
        self.meshes.solid(self.folder.join(&entry.file), entry.scale, of_mesh)
    }

    /// Returns the solid of a shape.
    fn solid(
        &self,
        shape: &Spanned<ShapeEntry>,
        body: &str,
        of_mesh: SolidOfMesh,
    ) -> Result<ReadShape, ScenarioError> {
        let ShapeEntry { cuboid, sphere, cylinder, capsule, mesh, hull, object, cloud, .. } = &shape.value;
        let at = self.at(shape.referenced);
        let mut solids: Vec<Result<Solid, ShapeError>> = Vec::new();
        solids.extend(cuboid.iter().map(|entry| sizes::cuboid(entry.size)));
        solids.extend(sphere.iter().map(|entry| Solid::sphere(entry.radius)));
        solids.extend(cylinder.iter().map(|entry| sizes::cylinder(entry.length, entry.radius)));
        solids.extend(capsule.iter().map(|entry| sizes::capsule(entry.length, entry.radius)));
        solids.extend(mesh.iter().map(|entry| self.mesh_solid(entry, Some(of_mesh))));
        solids.extend(hull.iter().map(|entry| self.mesh_solid(entry, None)));
        let in_file = |fault| ScenarioError::At { at: at.clone(), fault: Box::new(fault) };
        let source = object.as_ref().map(|name| self.object(name)).transpose().map_err(in_file)?;
        if let Some(source) = &source {
            solids.push(Ok(source.solid().map_err(in_file)?));
        }
        let cloud = cloud
            .as_ref()
            .map(|entry| cloud_obstacle(&self.folder.join(&entry.file), entry.radius_m, entry.voxel_m, body));
        let (cloud, counts) = cloud.transpose().map_err(in_file)?.unzip();
        solids.extend(cloud.map(Ok));
        match (solids.pop(), solids.len()) {
            (Some(solid), 0) => match solid {
                Ok(solid) => Ok((solid, source, counts)),
                Err(reason) => Err(ScenarioError::Shape { at, body: body.to_owned(), reason }),
            },
            (last, others) => {
                Err(ScenarioError::ShapeCount { at, actual: others + usize::from(last.is_some()) })
            }
        }
    }

    /// Returns an object from a folder of its own, otherwise the built-in one.
    fn object(&self, name: &str) -> Result<ObjectSource, ScenarioError> {
        let folder = self.folder.join(name);
        if folder.join(OBJECT_FILE).is_file() {
            return Ok(ObjectType::read_folder(&folder)?.into());
        }
        ObjectSource::builtin(name)
    }

    /// Refuses a cloud as the target: it has no surface to grasp.
    pub fn refuse_cloud(&self, target: &BodyEntry) -> Result<(), ScenarioError> {
        let Some(shape) = target.shapes.iter().find(|shape| shape.value.cloud.is_some()) else {
            return Ok(());
        };
        let (what, hint) = ("a cloud of points as the target", "give its mesh, at its pose");
        Err(ScenarioError::Unsupported { at: self.at(shape.referenced), what, hint })
    }
}
