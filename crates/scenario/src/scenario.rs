use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use cranny_collision::{Margins, ReleasedCheck, World};
use cranny_grasp::GraspSet;
use cranny_robot::Robot;
use cranny_shape::Surface;
use cranny_spatial::Pose;
use cranny_task::{Criterion, Goal, Pick, PlaceGoal, Problem, Region, Stage, TaskError, Weight};
use strum::{EnumString, IntoStaticStr};

use crate::robot::hand;
use crate::{
    CloudCounts, DEFAULT_FRICTION, GivenGrasps, NamedTask, ObjectSource, ObjectType, RobotSource,
    ScenarioError, SeenSpace, StatedSpeed, TargetPhysics,
};

/// Colours of bodies by name, one for each part: red, green and blue, 0 to 1, sRGB; `None` for a part without one. Bodies without
/// any colour are left out.
pub type BodyColours = BTreeMap<String, Vec<Option<[f64; 3]>>>;

/// Scenario: robot, environment, target and grasps.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// Built-in id, or name of the folder.
    pub id: String,
    /// Criterion under which paths are checked.
    pub criterion: Criterion,
    /// Robot; its root frame is the planning frame.
    pub robot: Arc<Robot>,
    /// Source of the robot.
    pub robot_source: RobotSource,
    /// All bodies, in the planning frame: obstacles, then the target and the floor if there are any.
    pub world: World,
    /// Index of the body to grasp.
    pub target: Option<usize>,
    /// Objects that bodies consist of, by name of the body, if each is a single one; its frame is that of the body's only part.
    pub sources: BTreeMap<String, ObjectSource>,
    /// Frame of each body of several shapes, in the frame of its first shape, by name.
    pub body_frames: BTreeMap<String, Pose>,
    /// Mass and friction that the scenario states for the target, before those of its object ([`Self::target_physics`]).
    pub given_physics: TargetPhysics,
    /// Start configuration (m, rad).
    pub start: Vec<f64>,
    /// Grasps of the target: poses of the gripper frame in the planning frame.
    pub grasps: GraspSet,
    /// True if a path must end at one of `grasps`. Otherwise `grasps` is empty, and the planner computes its own.
    pub has_grasp_set: bool,
    /// Known configurations at grasps, from the files (m, rad); often none.
    pub ik: Vec<Vec<f64>>,
    /// Goals where the target can be placed.
    pub places: Vec<PlaceGoal>,
    /// Goal regions by name, in the planning frame; often none.
    pub regions: BTreeMap<String, Region>,
    /// Named tasks of several stages; often none.
    pub tasks: Vec<NamedTask>,
    /// Stated mass and friction of bodies other than the target, by name.
    pub physics: BTreeMap<String, TargetPhysics>,
    /// Colours of bodies, for display.
    pub colours: BodyColours,
    /// Stated bounds (m, rad) of joints of `robot` in addition to their limits, by name.
    pub joint_bounds: BTreeMap<String, [f64; 2]>,
    /// Default speeds of motions, used unless a plan specifies others; the entry for all motions comes first.
    pub speeds: Vec<StatedSpeed>,
    /// Triangles of the released export, in the planning frame, which the `paper` criterion checks instead of the bodies.
    pub export: Option<Surface>,
    /// Space that cameras have seen, if the obstacles are a map of it.
    pub seen: Option<SeenSpace>,
    /// Numbers of points of the clouds that its files name as obstacles, in their order.
    pub clouds: Vec<CloudCounts>,
}

/// Options that complete or override the files of a scenario.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct OpenOptions {
    /// Criterion under which paths are checked. Default: that of the scenario, otherwise [`Criterion::Exact`].
    pub criterion: Option<Criterion>,
    /// Another robot: the name of a built-in one, a folder with a `robot.yaml`, or a URDF. Default: the scenario's own. It
    /// takes the position of that one, on the same floor if its files give the height of its ground, and the start
    /// configuration of its files, if they give one; known IK solutions are dropped.
    pub robot: Option<PathBuf>,
    /// Geometry of a scenario in the released layout; others have only one. Default: [`Geometry::Scene`] under `exact`,
    /// [`Geometry::Export`] under `paper`.
    pub geometry: Option<Geometry>,
    /// Grasps at which a path may end. Default: the scenario's own. Other grasps have no known IK solutions.
    pub grasps: GivenGrasps,
}

/// Geometries of a released scenario.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, IntoStaticStr)]
#[strum(serialize_all = "kebab-case")]
pub enum Geometry {
    /// True scene: `scene.yaml` with the object library.
    Scene,
    /// `export/obstacles.obj`: obstacles and target in one mesh, as the released planners used it.
    Export,
}

impl Geometry {
    /// Returns the name in flags and plan files.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

impl Scenario {
    /// Returns the scenario of a robot in a world, under [`Criterion::Exact`], with a start (m, rad; one value per joint) that is not
    /// checked, and with nothing else.
    pub fn bare(id: String, robot: Arc<Robot>, world: World, start: Vec<f64>) -> Self {
        Self {
            id,
            criterion: Criterion::Exact,
            robot,
            robot_source: RobotSource::Other,
            world,
            target: None,
            sources: BTreeMap::new(),
            body_frames: BTreeMap::new(),
            given_physics: TargetPhysics::default(),
            start,
            grasps: GraspSet::default(),
            has_grasp_set: true,
            ik: Vec::new(),
            places: Vec::new(),
            regions: BTreeMap::new(),
            tasks: Vec::new(),
            physics: BTreeMap::new(),
            colours: BTreeMap::new(),
            joint_bounds: BTreeMap::new(),
            speeds: Vec::new(),
            export: None,
            seen: None,
            clouds: Vec::new(),
        }
    }

    /// Returns the task of that name.
    ///
    /// # Errors
    /// [`ScenarioError::UnknownTask`], which lists the names of the scenario's tasks.
    pub fn task(&self, name: &str) -> Result<&NamedTask, ScenarioError> {
        self.tasks.iter().find(|task| task.name == name).ok_or_else(|| {
            let known: Vec<String> = self.tasks.iter().map(|task| format!("'{}'", task.name)).collect();
            let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
            ScenarioError::UnknownTask { id: self.id.clone(), name: name.to_owned(), known }
        })
    }

    /// Returns the scenario with the named body as its target. The scenario's own target keeps its grasps, mass and friction.
    /// For any other body no grasps are given, and the planner computes them.
    ///
    /// # Errors
    /// [`ScenarioError::Task`] if there is no body of that name.
    pub fn with_target(&self, name: &str) -> Result<Self, ScenarioError> {
        let target = self.world.body_index(name).map_err(TaskError::from)?;
        if self.target == Some(target) {
            return Ok(self.clone());
        }
        let mut physics = self.physics.clone();
        if let Some(own) = self.target {
            physics.insert(self.world.bodies()[own].name.clone(), self.given_physics);
        }
        let given_physics = physics.remove(name).unwrap_or_default();
        Ok(Self { target: Some(target), physics, given_physics, ..self.without_grasps() })
    }

    /// Returns mass and friction of a body: those that the scenario states, otherwise those of its object.
    pub fn physics_of(&self, body: usize) -> TargetPhysics {
        let stated = match self.target {
            Some(target) if target == body => Some(self.given_physics),
            _ => self.physics.get(&self.world.bodies()[body].name).copied(),
        };
        let of_object = self.source_of(body).map(ObjectSource::physics);
        stated.unwrap_or_default().or(of_object.unwrap_or_default())
    }

    /// Returns mass and rolling resistance of a body, and the mass distribution that the file of its object states.
    pub(crate) fn weight_of(&self, body: usize) -> Weight {
        let moments = self.source_of(body).and_then(ObjectSource::own).map(ObjectType::mass_moments);
        let TargetPhysics { mass_kg, rolling_m, .. } = self.physics_of(body);
        Weight { mass_kg, moments, rolling_m }
    }

    /// Returns the object that a body consists of, if it is a single one.
    pub(crate) fn source_of(&self, body: usize) -> Option<&ObjectSource> {
        let body = &self.world.bodies()[body];
        self.sources.get(&body.name).filter(|_| body.parts.len() == 1)
    }

    /// Returns the planning problem.
    ///
    /// Under `exact`, the world is checked with the requested margins. Under `paper`, the released check applies: the triangles
    /// of the export, or else the boxes of the world's bodies, and the frames of the links from the second revolute joint on,
    /// whose origins must stay 4 cm above the root frame.
    ///
    /// If no set of grasps is given, grasps are evaluated with the friction of [`Self::target_physics`], otherwise with
    /// [`DEFAULT_FRICTION`].
    ///
    /// # Errors
    /// [`ScenarioError::Task`] for a start that does not fit the robot or an invalid margin, or without a set of grasps for a
    /// target whose grasps cannot be evaluated ([`Problem::without_grasp_set`]); [`ScenarioError::MarginUnderPaper`] for a
    /// margin that nothing would check.
    pub fn problem(&self, margins: Margins) -> Result<Problem, ScenarioError> {
        let bodies = || 0..self.world.bodies().len();
        let friction = |body| Some(self.physics_of(body).least_friction().unwrap_or(DEFAULT_FRICTION));
        let frictions: Vec<Option<f64>> = bodies().map(friction).collect();
        let weights: Vec<Weight> = bodies().map(|body| self.weight_of(body)).collect();
        let problem =
            self.problem_with_grasp_set(margins)?.with_places(&self.places).with_regions(&self.regions);
        let problem = problem.with_frictions(&frictions).with_weights(&weights);
        if self.has_grasp_set {
            return Ok(problem);
        }
        Ok(problem.without_grasp_set(self.target_physics().least_friction().unwrap_or(DEFAULT_FRICTION))?)
    }

    fn problem_with_grasp_set(&self, margins: Margins) -> Result<Problem, ScenarioError> {
        let (robot, start) = (self.robot.clone(), self.start.clone());
        let goal = Goal::Grasps(self.grasps.clone());
        match self.criterion {
            Criterion::Exact => {
                Ok(Problem::exact(robot, self.world.clone(), self.target, start, goal, margins)?)
            }
            Criterion::Paper if margins != Margins::default() || !self.world.tool_bounds().is_empty() => {
                Err(ScenarioError::MarginUnderPaper)
            }
            Criterion::Paper => {
                let obstacles = match &self.export {
                    Some(surface) => vec![(Pose::identity(), surface.clone())],
                    None => ReleasedCheck::surfaces_of(&self.world),
                };
                let floor_links = hand::floor_links(&robot);
                let check = ReleasedCheck::new(robot, obstacles, floor_links, PAPER_FLOOR_M)
                    .map_err(TaskError::from)?;
                Ok(Problem::paper(check, self.world.clone(), start, goal)?)
            }
        }
    }

    /// Returns the clearance that the target needs to tolerate an error of its pose, in metres: a translation, and a rotation
    /// about the centre of its bounding ball. `None` without a target.
    pub fn object_margin_m(&self, translation_m: f64, rotation_rad: f64) -> Option<f64> {
        self.margin_about(self.target?, translation_m, rotation_rad)
    }

    fn margin_about(&self, body: usize, translation_m: f64, rotation_rad: f64) -> Option<f64> {
        let ball = self.world.bodies()[body].ball()?;
        Some(translation_m + rotation_rad * ball.radius_m)
    }

    /// Returns the stages with an object margin for each pick that tolerates such an error of the object's pose (m, rad), as
    /// [`Self::object_margin_m`] does for the target.
    pub fn forgiving(&self, stages: &[Stage], translation_m: f64, rotation_rad: f64) -> Vec<Stage> {
        let forgiving = |stage: &Stage| match stage {
            Stage::Pick(pick @ Pick { object: Some(object), .. }) => {
                let body = self.world.body_index(object).ok();
                let object_margin_m =
                    body.and_then(|body| self.margin_about(body, translation_m, rotation_rad));
                Stage::Pick(Pick { object_margin_m, ..pick.clone() })
            }
            other => other.clone(),
        };
        stages.iter().map(forgiving).collect()
    }

    /// Returns the scenario with another robot, and the planning frame, raised or lowered so that its ground coincides with the
    /// floor, if both heights are given.
    pub(crate) fn on_its_ground(self, options: &OpenOptions) -> Result<Self, ScenarioError> {
        let parts = || self.world.bodies().iter().flat_map(|body| &body.parts);
        let floor = parts().find(|part| part.solid.is_half_space()).map(|part| part.world_from_solid);
        let heights =
            floor.zip(self.robot.floor_m()).filter(|_| options.robot.is_some() && self.export.is_none());
        let Some((floor, ground_m)) = heights else { return Ok(self) };
        let lower = Pose::translation(0.0, 0.0, ground_m - floor.translation.z);
        let mut bodies = self.world.bodies().to_vec();
        for part in bodies.iter_mut().flat_map(|body| &mut body.parts) {
            part.world_from_solid = lower * part.world_from_solid;
        }
        let places = self.places.iter().map(|place| place.in_frame(&lower)).collect();
        let bounds = self.world.tool_bounds().iter().map(|bound| bound.in_frame(&lower)).collect();
        let world = self.world.with_bodies(bodies)?.with_tool_bounds(bounds)?;
        let regions = in_frame(&self.regions, &lower);
        Ok(Self { world, grasps: self.grasps.moved(&lower), places, regions, ..self })
    }

    /// Returns the scenario with grasps that suit its robot: half a turn of a tool is another grasp.
    pub(crate) fn with_own_twins(self) -> Self {
        if self.robot.tool().is_none() {
            return self;
        }
        Self { grasps: self.grasps.without_twins(), ..self }
    }

    /// Checks that the start, given in `file`, has one value per joint.
    pub(crate) fn with_checked_start(self, file: &str) -> Result<Self, ScenarioError> {
        if self.start.len() == self.robot.dof() {
            return Ok(self.with_own_twins());
        }
        Err(ScenarioError::StartCount {
            file: file.to_owned(),
            expected: self.robot.dof(),
            actual: self.start.len(),
            joints: self.robot.joint_names().join(", "),
        })
    }
}

/// Returns regions in a new frame; `new_from_old` is the pose of the present frame in it.
pub(crate) fn in_frame(regions: &BTreeMap<String, Region>, new_from_old: &Pose) -> BTreeMap<String, Region> {
    regions.iter().map(|(name, region)| (name.clone(), region.in_frame(new_from_old))).collect()
}

/// Minimum height of link frames in the released check, in metres in the planning frame.
const PAPER_FLOOR_M: f64 = 0.04;

/// Returns the id of the scenario in `folder`: the name of the folder, also if the path is `.` or `..`.
pub(crate) fn id_of(folder: &Path) -> String {
    let whole = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
    whole.file_name().unwrap_or(whole.as_os_str()).to_string_lossy().into_owned()
}
