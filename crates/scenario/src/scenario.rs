use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use cranny_collision::{Margins, ReleasedCheck, World};
use cranny_grasp::GraspSet;
use cranny_robot::Robot;
use cranny_shape::Surface;
use cranny_spatial::Pose;
use cranny_task::{Criterion, Goal, Pick, PlaceGoal, Problem, Stage, TaskError, Weight};
use strum::{EnumString, IntoStaticStr};

use crate::robot::hand;
use crate::{
    DEFAULT_FRICTION, GivenGrasps, NamedTask, ObjectSource, RobotSource, ScenarioError, StatedSpeed,
    TargetPhysics,
};

/// A task: a robot, what stands around it, what it should grasp and how it may.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// The built-in id, or the name of the folder.
    pub id: String,
    /// What counts as solved.
    pub criterion: Criterion,
    /// The robot; its root frame is the planning frame.
    pub robot: Arc<Robot>,
    /// Where it comes from.
    pub robot_source: RobotSource,
    /// All bodies, in the planning frame: obstacles, then the target, then the floor, as far as there are.
    pub world: World,
    /// Which body is to be grasped, by index.
    pub target: Option<usize>,
    /// The object that the target is, where it is one alone; its frame is that of the body's only part.
    pub target_source: Option<ObjectSource>,
    /// What is said of the target itself, which goes before what its object says; see
    /// [`Self::target_physics`].
    pub given_physics: TargetPhysics,
    /// The configuration to start from (m, rad).
    pub start: Vec<f64>,
    /// How the target can be grasped: poses of the gripper frame in the planning frame.
    pub grasps: GraspSet,
    /// Whether a path must end at one of these. Where no set is given there is none of them, and whoever plans makes a
    /// grasp of its own.
    pub has_grasp_set: bool,
    /// Configurations that reach a grasp, as known from the files; often none.
    pub ik: Vec<Vec<f64>>,
    /// Where the target can be put down.
    pub places: Vec<PlaceGoal>,
    /// Tasks of several stages, by name; often none.
    pub tasks: Vec<NamedTask>,
    /// Mass and friction of bodies besides the target, by name, as far as they are given.
    pub physics: BTreeMap<String, TargetPhysics>,
    /// Values (m, rad) between which joints of `robot` stay besides their limits, by name, as far as they are given.
    pub joint_bounds: BTreeMap<String, [f64; 2]>,
    /// Speeds of motions unless a plan is asked for others, those of all first.
    pub speeds: Vec<StatedSpeed>,
    /// The triangles, in the planning frame, that the `paper` criterion checks instead of the bodies of
    /// `world`: the released export.
    pub export: Option<Surface>,
}

/// What a scenario's files leave open, or what should be taken instead.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct OpenOptions {
    /// What counts as solved. Default: what the scenario says, else [`Criterion::Exact`].
    pub criterion: Option<Criterion>,
    /// Another robot: a built-in one by its name, a folder with a `robot.yaml`, or a URDF. Default: the scenario's own. It
    /// stands where that stood, on the same floor if its files say where its ground is, and starts where they say, if they
    /// do; known IK solutions are then left out.
    pub robot: Option<PathBuf>,
    /// The geometry of a scenario in the released layout; others have but one. Default:
    /// [`Geometry::Scene`] under `exact`, [`Geometry::Export`] under `paper`.
    pub geometry: Option<Geometry>,
    /// Which grasps a path may end at. Default: the scenario's own. Of others no known IK solutions are left.
    pub grasps: GivenGrasps,
}

/// The two geometries that a released scenario comes with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, IntoStaticStr)]
#[strum(serialize_all = "kebab-case")]
pub enum Geometry {
    /// The true scene: `scene.yaml` with the object library.
    Scene,
    /// `export/obstacles.obj`, obstacles and target in one mesh, as the released planners used it.
    Export,
}

impl Geometry {
    /// What flags and plan files call it.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

impl Scenario {
    /// The task of that name.
    ///
    /// # Errors
    /// [`ScenarioError::UnknownTask`], which lists the names that there are.
    pub fn task(&self, name: &str) -> Result<&NamedTask, ScenarioError> {
        self.tasks.iter().find(|task| task.name == name).ok_or_else(|| {
            let known: Vec<String> = self.tasks.iter().map(|task| format!("'{}'", task.name)).collect();
            let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
            ScenarioError::UnknownTask { id: self.id.clone(), name: name.to_owned(), known }
        })
    }

    /// The scenario in which a body of this name is the target. Its own target has its own grasps, mass and friction; of
    /// anything else no grasps are given, and the planner makes one.
    ///
    /// # Errors
    /// [`ScenarioError::Task`] for the name of nothing.
    pub fn with_target(&self, name: &str) -> Result<Self, ScenarioError> {
        let target = self.world.body_index(name).map_err(TaskError::from)?;
        if self.target == Some(target) {
            return Ok(self.clone());
        }
        let given_physics = self.physics_of(target);
        Ok(Self { target: Some(target), target_source: None, given_physics, ..self.without_grasps() })
    }

    /// Mass and friction of a body besides the target, as far as the scenario gives them.
    pub fn physics_of(&self, body: usize) -> TargetPhysics {
        let name = &self.world.bodies()[body].name;
        self.physics.get(name).copied().unwrap_or_default()
    }

    /// The problem to plan for.
    ///
    /// Under `exact`, the world decides, with the demanded margins. Under `paper`, the released check does:
    /// the triangles of the export where there is one, else the boxes of the world's bodies, and the frames
    /// of the links from the second turning joint on, whose origins must stay 4 cm above the root frame.
    ///
    /// Where no set of grasps is given, they are measured with the friction of [`Self::target_physics`], else with
    /// [`DEFAULT_FRICTION`].
    ///
    /// # Errors
    /// [`ScenarioError::Task`] for a start that does not fit the robot or a margin that is none, or without a set of grasps
    /// for what has no grasp to measure ([`Problem::without_grasp_set`]); [`ScenarioError::MarginUnderPaper`] for a margin
    /// that nothing would check.
    pub fn problem(&self, margins: Margins) -> Result<Problem, ScenarioError> {
        let bodies = 0..self.world.bodies().len();
        let of_body = |body| match self.target {
            Some(target) if target == body => self.target_physics(),
            _ => self.physics_of(body),
        };
        let physics: Vec<TargetPhysics> = bodies.map(of_body).collect();
        let frictions: Vec<Option<f64>> =
            physics.iter().map(|physics| physics.friction.or(Some(DEFAULT_FRICTION))).collect();
        let stated = |physics: &TargetPhysics| Weight {
            mass_kg: physics.mass_kg,
            moments: None,
            rolling_m: physics.rolling_m,
        };
        let mut weights: Vec<Weight> = physics.iter().map(stated).collect();
        if let (Some(target), Some(weight)) = (self.target, self.target_weight()) {
            weights[target] = weight;
        }
        let problem = self.problem_with_grasp_set(margins)?.with_places(&self.places);
        let problem = problem.with_frictions(&frictions).with_weights(&weights);
        if self.has_grasp_set {
            return Ok(problem);
        }
        Ok(problem.without_grasp_set(self.target_physics().friction.unwrap_or(DEFAULT_FRICTION))?)
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

    /// What must be kept free about the target that may be so far from where it is thought to be, moved and turned about the
    /// middle of a ball around it at once, in metres; `None` without a target.
    pub fn object_margin_m(&self, translation_m: f64, rotation_rad: f64) -> Option<f64> {
        self.margin_about(self.target?, translation_m, rotation_rad)
    }

    fn margin_about(&self, body: usize, translation_m: f64, rotation_rad: f64) -> Option<f64> {
        let ball = self.world.bodies()[body].ball()?;
        Some(translation_m + rotation_rad * ball.radius_m)
    }

    /// Stages each pick of which demands the clearance about its object that forgives such an error of its pose (m, rad), as
    /// [`Self::object_margin_m`] does about the target.
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

    /// The scenario with another robot lifted or lowered so that the ground that it stands on is the floor, as far as both
    /// are said. The planning frame goes with it.
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
        let places = self.places.iter().map(|place| place.seen_from(&lower)).collect();
        let bounds = self.world.tool_bounds().iter().map(|bound| bound.seen_from(&lower)).collect();
        let world = self.world.with_bodies(bodies)?.with_tool_bounds(bounds)?;
        Ok(Self { world, grasps: self.grasps.moved(&lower), places, ..self })
    }

    /// Checks that the start, which stands in `file`, has one value per joint.
    pub(crate) fn with_checked_start(self, file: &str) -> Result<Self, ScenarioError> {
        if self.start.len() == self.robot.dof() {
            return Ok(self);
        }
        Err(ScenarioError::StartCount {
            file: file.to_owned(),
            expected: self.robot.dof(),
            actual: self.start.len(),
            joints: self.robot.joint_names().join(", "),
        })
    }
}

/// The height that the released check keeps link frames above, in metres in the planning frame.
const PAPER_FLOOR_M: f64 = 0.04;

/// The id of the scenario in `folder`: its name, also where it is given as `.` or `..`.
pub(crate) fn id_of(folder: &Path) -> String {
    let whole = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
    whole.file_name().unwrap_or(whole.as_os_str()).to_string_lossy().into_owned()
}
