use std::collections::BTreeMap;
use std::sync::Arc;

use cranny_collision::{Cell, Margins, ReleasedCheck, World};
use cranny_grasp::GraspSet;
use cranny_robot::Robot;
use cranny_spatial::PoseDifference;
use serde::{Deserialize, Serialize};
use strum::{EnumString, IntoStaticStr};

use crate::grasping::grasp_filter::GraspFilter;
use crate::grasping::grasp_poses;
use crate::grasping::load_model::{LoadModel, Weight, Weights};
use crate::{FailureReason, Goal, GraspMeasure, NotChecked, PlaceGoal, Region, TaskError};

/// A motion planning problem with its criterion of validity. Its start and goal are checked against the robot on creation.
#[derive(Clone, Debug)]
pub struct Problem {
    robot: Arc<Robot>,
    target: Option<usize>,
    start: Vec<f64>,
    goal: Goal,
    /// Measure of grasps, if no set of them is given.
    grasp_measure: Option<Arc<GraspMeasure>>,
    grasp_filter: Option<GraspFilter>,
    /// Goals for putting an object down.
    places: Arc<[PlaceGoal]>,
    /// Regions by name.
    regions: Arc<BTreeMap<String, Region>>,
    /// Coefficients of friction between bodies and pads, by index of the body.
    frictions: Arc<[Option<f64>]>,
    pub(crate) weights: Arc<Weights>,
    validity: Validity,
}

/// Criterion by which a problem counts as solved (README, "What solved means").
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, EnumString, IntoStaticStr)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum Criterion {
    /// Gripper within 1 mm and 1° of a grasp, exact geometry, and the whole path proven.
    #[default]
    Exact,
    /// Measure of the released planners, for comparison only: gripper within `d < 50`, and only way points checked.
    Paper,
}

impl Criterion {
    /// Name in files and flags.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// Definition of free configurations, with the geometry that decides it.
#[derive(Clone, Debug)]
pub enum Validity {
    /// Exact shapes, and proofs of whole motions.
    Exact(Arc<Cell>),
    /// The released check of single configurations, and arrival by `d = ½·mm + ½·deg`.
    Paper {
        /// The released check.
        check: Arc<ReleasedCheck>,
        /// Value of `d` below which the gripper has arrived.
        threshold: f64,
        /// Cell for distances, which the released check does not compute.
        distances: Arc<Cell>,
    },
}

/// Value of `d = ½·mm + ½·deg` below which the released planners stop.
pub const PAPER_THRESHOLD: f64 = 50.0;

impl Problem {
    /// Creates a problem from `start` (m, rad; one per joint) under the `exact` criterion. Certain pairs of links are not
    /// checked, such as those proven to touch at all joint values ([`Cell::unchecked`]).
    ///
    /// # Errors
    /// [`TaskError::JointCount`] or [`TaskError::NotFinite`] for a start or goal configuration that does not
    /// fit the robot, [`TaskError::Collision`] for a negative margin.
    ///
    /// # Panics
    /// If the world has no body `target`.
    pub fn exact(
        robot: Arc<Robot>,
        world: World,
        target: Option<usize>,
        start: Vec<f64>,
        goal: Goal,
        margins: Margins,
    ) -> Result<Self, TaskError> {
        let cell = match target {
            Some(target) => Cell::for_grasp(robot.clone(), world, target, margins)?,
            None => Cell::new(robot.clone(), world, margins)?,
        };
        Self { target, ..Self::of(Validity::Exact(Arc::new(cell)), robot, start, goal) }.checked()
    }

    /// Creates a problem from `start` (m, rad; one per joint) under the `exact` criterion in an existing cell.
    ///
    /// # Errors
    /// [`TaskError::JointCount`] or [`TaskError::NotFinite`] for a start or goal configuration that does not fit the robot.
    pub fn in_cell(cell: Arc<Cell>, start: Vec<f64>, goal: Goal) -> Result<Self, TaskError> {
        let robot = cell.robot().clone();
        Self::of(Validity::Exact(cell), robot, start, goal).checked()
    }

    /// Creates a problem from `start` (m, rad; one per joint) under the `paper` criterion: `check` decides; planners may use
    /// distances to `world` for their step size.
    ///
    /// # Errors
    /// [`TaskError::JointCount`] or [`TaskError::NotFinite`] for a start or goal configuration that does not fit the robot.
    pub fn paper(check: ReleasedCheck, world: World, start: Vec<f64>, goal: Goal) -> Result<Self, TaskError> {
        let robot = check.robot().clone();
        let distances = Arc::new(Cell::new(robot.clone(), world, Margins::default())?);
        let validity = Validity::Paper { check: Arc::new(check), threshold: PAPER_THRESHOLD, distances };
        Self::of(validity, robot, start, goal).checked()
    }

    /// Creates an unchecked problem without a target.
    fn of(validity: Validity, robot: Arc<Robot>, start: Vec<f64>, goal: Goal) -> Self {
        Self {
            robot,
            target: None,
            start,
            goal,
            grasp_measure: None,
            grasp_filter: None,
            places: Arc::default(),
            regions: Arc::default(),
            frictions: Arc::default(),
            weights: Arc::default(),
            validity,
        }
    }

    /// Returns this problem without a set of grasps: its planner generates a grasp, which is measured on the surface of the
    /// target with this coefficient of friction between target and pads.
    ///
    /// # Errors
    /// [`TaskError::NoGraspMeasure`] for a problem under `paper`, without a target or with one that has no surface, of a robot
    /// whose hand cannot close, or for a friction that is not positive; [`TaskError::Collision`] for an unbounded target.
    pub fn without_grasp_set(&self, friction: f64) -> Result<Self, TaskError> {
        let grasp_measure = Some(Arc::new(self.new_grasp_measure(friction)?));
        Ok(Self { goal: Goal::Grasps(GraspSet::default()), grasp_measure, ..self.clone() })
    }

    /// Returns this problem with a filter of grasps: no IK is run at the grasps that the filter refuses.
    #[must_use]
    pub fn with_grasp_filter(self, filter: GraspFilter) -> Self {
        Self { grasp_filter: Some(filter), ..self }
    }

    /// Filter of grasps, if there is one.
    pub fn grasp_filter(&self) -> Option<&GraspFilter> {
        self.grasp_filter.as_ref()
    }

    /// Returns this problem with coefficients of friction between bodies, by index, and the pads. They are used to measure
    /// grasps of objects other than the target.
    #[must_use]
    pub fn with_frictions(self, frictions: &[Option<f64>]) -> Self {
        Self { frictions: frictions.into(), ..self }
    }

    /// Returns this problem with the weights of bodies, by index, as far as they are known.
    #[must_use]
    pub fn with_weights(self, weights: &[Weight]) -> Self {
        Self { weights: Arc::new(Weights::new(weights)), ..self }
    }

    /// Returns the grasps of the target with the load of each; `None` if there are none, or no load can be computed
    /// ([`LoadModel`]).
    pub fn loaded_grasps(&self) -> Option<GraspSet> {
        let load_model = self.load_model(self.cell()?, self.target?)?;
        Some(self.grasps()?.with_loads(load_model.measure()))
    }

    /// Returns the load model of grasps of a body where it stands in a cell; `None` if it cannot be computed ([`LoadModel`]).
    pub(crate) fn load_model(&self, cell: &Cell, body: usize) -> Option<Arc<LoadModel>> {
        LoadModel::new(cell, body, self.frictions.get(body).copied().flatten(), &self.weights)
    }

    /// Returns this problem in a cell that differs only in the bounds of the tool, from another start (m, rad; one per joint).
    ///
    /// # Errors
    /// As [`Self::with_start`].
    pub fn with_start_in_cell(&self, start: &[f64], cell: &Arc<Cell>) -> Result<Self, TaskError> {
        Ok(Self { validity: Validity::Exact(cell.clone()), ..self.with_start(start)? })
    }

    /// Returns this problem with another start (m, rad; one per joint).
    ///
    /// # Errors
    /// [`TaskError::JointCount`] or [`TaskError::NotFinite`] for a start that does not fit the robot.
    pub fn with_start(&self, start: &[f64]) -> Result<Self, TaskError> {
        if self.start == start {
            return Ok(self.clone());
        }
        Self { start: start.to_vec(), ..self.clone() }.checked()
    }

    /// Returns the problem of grasping a body from a configuration (m, rad; one per joint) in a cell in which bodies may have
    /// moved. The target keeps its grasps, which move with it; for another body the planner generates grasps.
    ///
    /// # Errors
    /// As [`Self::without_grasp_set`].
    pub(crate) fn picking(&self, cell: Arc<Cell>, body: usize, start: &[f64]) -> Result<Self, TaskError> {
        let is_same = self.cell().is_some_and(|own| Arc::ptr_eq(own, &cell));
        if is_same && self.target == Some(body) && self.start == start {
            return Ok(self.clone());
        }
        let is_target = self.target == Some(body);
        let grasps = match self.grasps().filter(|_| is_target) {
            Some(grasps) => {
                let first =
                    |cell: &Cell| cell.world().bodies()[body].parts.first().map(|part| part.world_from_solid);
                let moved = self.cell().and_then(|own| Some(first(&cell)? * first(own)?.inverse()));
                moved.map_or_else(|| grasps.clone(), |moved| grasps.moved(&moved))
            }
            None => GraspSet::default(),
        };
        let friction = match &self.grasp_measure {
            Some(measure) if is_target => Some(measure.friction()),
            _ => self.frictions.get(body).copied().flatten(),
        };
        let is_measured = !is_target || self.grasp_measure.is_some();
        let (validity, goal) = (Validity::Exact(cell), Goal::Grasps(grasps));
        let picking = Self {
            target: Some(body),
            start: start.to_vec(),
            goal,
            grasp_measure: None,
            validity,
            ..self.clone()
        };
        let picking = picking.checked()?;
        if is_measured { picking.without_grasp_set(friction.unwrap_or_default()) } else { Ok(picking) }
    }

    /// Returns this problem with goals for putting the target down.
    #[must_use]
    pub fn with_places(self, places: &[PlaceGoal]) -> Self {
        Self { places: places.into(), ..self }
    }

    /// Goals for putting the target down.
    pub fn places(&self) -> &[PlaceGoal] {
        &self.places
    }

    /// Returns this problem with regions by name, which tasks may refer to.
    #[must_use]
    pub fn with_regions(self, regions: &BTreeMap<String, Region>) -> Self {
        Self { regions: Arc::new(regions.clone()), ..self }
    }

    /// Returns true if the hand alone is free at one of the given grasps, or if none are given; otherwise no path reaches one.
    pub fn may_be_grasped(&self) -> bool {
        let (Some(cell), Some(grasps)) =
            (self.cell(), self.grasps().filter(|_| self.grasp_measure.is_none()))
        else {
            return true;
        };
        let mut scratch = cell.scratch();
        grasps.grasps().iter().any(|grasp| {
            FailureReason::of_width(cell.robot(), grasp).is_none()
                && grasp_poses::gripper_poses(grasp).iter().any(|pose| cell.hand_is_free(pose, &mut scratch))
        })
    }

    /// Returns the placement goal of that name.
    ///
    /// # Errors
    /// [`TaskError::UnknownPlace`], which lists the available names.
    pub fn place(&self, name: &str) -> Result<&PlaceGoal, TaskError> {
        self.places.iter().find(|place| place.name == name).ok_or_else(|| {
            let known = listed(self.places.iter().map(|place| &place.name));
            TaskError::UnknownPlace { name: name.to_owned(), known }
        })
    }

    /// Returns the region of that name.
    ///
    /// # Errors
    /// [`TaskError::UnknownRegion`], which lists the available names.
    pub fn region(&self, name: &str) -> Result<&Region, TaskError> {
        self.regions.get(name).ok_or_else(|| {
            let known = listed(self.regions.keys());
            TaskError::UnknownRegion { name: name.to_owned(), known }
        })
    }

    /// The robot; its root frame is the planning frame.
    pub fn robot(&self) -> &Arc<Robot> {
        &self.robot
    }

    /// Index of the body of the world that is grasped and may later be carried.
    pub fn target(&self) -> Option<usize> {
        self.target
    }

    /// Start configuration (m, rad; one value per joint).
    pub fn start(&self) -> &[f64] {
        &self.start
    }

    /// Goal of the path.
    pub fn goal(&self) -> &Goal {
        &self.goal
    }

    /// Measure of grasps, if no set of them is given ([`Self::without_grasp_set`]).
    pub fn grasp_measure(&self) -> Option<&GraspMeasure> {
        self.grasp_measure.as_deref()
    }

    /// Goal grasps; `None` for another goal.
    pub fn grasps(&self) -> Option<&GraspSet> {
        if let Goal::Grasps(grasps) = &self.goal { Some(grasps) } else { None }
    }

    /// The criterion that decides.
    pub fn criterion(&self) -> Criterion {
        match self.validity {
            Validity::Exact(_) => Criterion::Exact,
            Validity::Paper { .. } => Criterion::Paper,
        }
    }

    /// Robot and world under `exact`.
    pub fn cell(&self) -> Option<&Arc<Cell>> {
        match &self.validity {
            Validity::Exact(cell) => Some(cell),
            Validity::Paper { .. } => None,
        }
    }

    /// Under `paper`: value of `d = ½·mm + ½·deg` below which the gripper has arrived; 0 for a search that never arrives.
    pub fn goal_threshold(&self) -> Option<f64> {
        match self.validity {
            Validity::Exact(_) => None,
            Validity::Paper { threshold, .. } => Some(threshold),
        }
    }

    /// Returns true if the start is free.
    pub fn start_is_free(&self) -> bool {
        match &self.validity {
            Validity::Exact(cell) => cell.is_free(&self.start, &mut cell.scratch()),
            Validity::Paper { check, .. } => check.is_free(&self.start, &mut check.scratch()),
        }
    }

    /// Returns this problem with another goal.
    ///
    /// # Errors
    /// [`TaskError::JointCount`] or [`TaskError::NotFinite`] for a goal configuration that does not fit the robot.
    pub fn with_goal(&self, goal: Goal) -> Result<Self, TaskError> {
        Self { goal, grasp_measure: None, ..self.clone() }.checked()
    }

    /// Returns this problem with another threshold under `paper`; under `exact` nothing changes.
    #[must_use]
    pub fn with_goal_threshold(mut self, value: f64) -> Self {
        if let Validity::Paper { threshold, .. } = &mut self.validity {
            *threshold = value;
        }
        self
    }

    /// Returns this problem with every pair of links checked that can be checked ([`Cell::with_all_pairs`]).
    #[must_use]
    pub fn checking_all_pairs(mut self) -> Self {
        if let Some(cell) = self.cell().filter(|cell| !cell.unchecked().is_empty()) {
            self.validity = Validity::Exact(Arc::new(cell.with_all_pairs()));
            self.renew_grasp_measure();
        }
        self
    }

    fn new_grasp_measure(&self, friction: f64) -> Result<GraspMeasure, TaskError> {
        GraspMeasure::new(self.cell().map(Arc::as_ref), self.target, friction)
    }

    /// Recomputes the grasp measure, so that the closing hand is checked as the robot is.
    fn renew_grasp_measure(&mut self) {
        if let Some(measure) = &self.grasp_measure
            && let Ok(renewed) = self.new_grasp_measure(measure.friction())
        {
            self.grasp_measure = Some(Arc::new(renewed));
        }
    }

    /// Returns the pairs that are not checked; none under `paper`.
    pub fn not_checked(&self) -> Vec<NotChecked> {
        self.cell().map_or_else(Vec::new, |cell| NotChecked::of(cell))
    }

    /// Returns robot and world for `asker`, a planner that proves its motions.
    ///
    /// # Errors
    /// [`TaskError::Goal`] under `paper`.
    pub fn exact_cell(&self, asker: &'static str) -> Result<&Arc<Cell>, TaskError> {
        self.cell().ok_or(TaskError::Goal { planner: asker, needs: "the exact criterion" })
    }

    /// Returns the goal of a problem that has one, for a planner that generates no grasps.
    ///
    /// # Errors
    /// [`TaskError::NoGraspSet`], [`TaskError::NoGoal`].
    pub fn some_goal(&self) -> Result<&Goal, TaskError> {
        if self.grasp_measure.is_some() {
            return Err(TaskError::NoGraspSet);
        }
        if self.goal.is_empty() { Err(TaskError::NoGoal) } else { Ok(&self.goal) }
    }

    /// Returns the measure of grasps for `planner`, which generates its own.
    ///
    /// # Errors
    /// [`TaskError::Goal`] under another criterion than `exact`, [`TaskError::GraspSet`] if grasps are given.
    pub fn own_grasp_measure(&self, planner: &'static str) -> Result<&GraspMeasure, TaskError> {
        self.exact_cell(planner)?;
        self.grasp_measure().ok_or(TaskError::GraspSet { planner })
    }

    /// Geometry that decides which configurations are free.
    pub fn validity(&self) -> &Validity {
        &self.validity
    }

    /// Returns true if a gripper with this difference from a grasp has arrived.
    pub fn is_arrival(&self, difference: &PoseDifference) -> bool {
        match self.validity {
            Validity::Exact(_) => difference.is_exact(),
            Validity::Paper { threshold, .. } => difference.paper_metric() < threshold,
        }
    }

    /// Goal configurations (m, rad; one value per joint); empty for another goal.
    pub fn goal_configurations(&self) -> &[Vec<f64>] {
        if let Goal::Configurations(goals) = &self.goal { goals } else { &[] }
    }

    /// Checks this problem. Moves the start within the limits of continuous joints, and the goals by whole turns of these
    /// joints to the nearest equivalents of the start.
    fn checked(mut self) -> Result<Self, TaskError> {
        let goals = self.goal_configurations();
        for (what, q) in std::iter::once(("start", &self.start)).chain(goals.iter().map(|q| ("goal", q))) {
            self.check_configuration(what, q)?;
        }
        if let Some(problem) = self.goal.region_fault() {
            return Err(TaskError::Region { problem });
        }
        let (robot, start) = (self.robot.clone(), &mut self.start);
        robot.turn_into_limits(start);
        // Half a turn of a tool is another grasp.
        if let (Goal::Grasps(grasps), Some(_)) = (&mut self.goal, self.robot.tool()) {
            *grasps = grasps.without_twins();
        }
        if let Goal::Configurations(goals) = &mut self.goal {
            for goal in goals {
                robot.wrap_towards(start, goal);
            }
        }
        Ok(self)
    }

    /// Checks that a configuration fits the robot: one finite value per joint, m or rad.
    ///
    /// # Errors
    /// [`TaskError::JointCount`] or [`TaskError::NotFinite`], with `what` as the name of the configuration.
    pub fn check_configuration(&self, what: &'static str, q: &[f64]) -> Result<(), TaskError> {
        if q.len() != self.robot.dof() {
            return Err(TaskError::JointCount { what, expected: self.robot.dof(), actual: q.len() });
        }
        match q.iter().position(|x| !x.is_finite()) {
            Some(joint) => Err(TaskError::NotFinite { what, joint: self.robot.joint_names()[joint].clone() }),
            None => Ok(()),
        }
    }
}

/// Returns quoted names in a row; `none` if there are none.
fn listed<'a>(names: impl Iterator<Item = &'a String>) -> String {
    let names: Vec<String> = names.map(|name| format!("'{name}'")).collect();
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}
