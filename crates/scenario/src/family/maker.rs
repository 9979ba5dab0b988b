use std::collections::BTreeMap;

use cranny_collision::{Body, World};
use cranny_grasp::{
    COVERAGE_THRESHOLD, Grasp, GraspSet, Hand, SampledGrasp, SamplerSettings, covering_subset, sample_grasps,
};
use cranny_shape::{Solid, Surface};
use cranny_spatial::{Pose, Stream, Vector};
use cranny_task::{
    APPROACH_M, HandFilter, LoadModel, Pick, PlaceGoal, PlaceRegion, Stage, Weight, robot_hand,
};

use crate::family::kind::Resting;
use crate::named_task::STEPS;
use crate::robot::short_arm::{self, ALL_POSES_DOF};
use crate::{
    Family, NamedTask, PAPER_FRICTION, Placement, Recipe, RecipeBody, RecipeRobot, ScenarioError, SceneScale,
    TargetPhysics,
};

/// Generator of scenarios of one family, with the resting object and grasps of it that are sampled once.
#[derive(Clone, Debug)]
pub struct FamilyMaker {
    /// Family of the scenarios.
    pub family: Family,
    robot: RecipeRobot,
    scale: SceneScale,
    resting: Resting,
    hand: Hand,
    /// All sampled grasps, then the few that cover them; poses in the object's frame.
    candidates: Vec<Grasp>,
    few: Vec<Grasp>,
}

/// Selection of sampled grasps for a scenario, among those that are collision-free for the hand there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GraspChoice {
    /// At most 200 grasps that cover all collision-free ones, selected for this scenario.
    Covering,
    /// The collision-free ones of 200 grasps that were selected once on level ground without obstacles; fewer, but faster.
    Few,
}

/// Mass of a column that blocks the access, in kilograms: an empty carton.
const COLUMN_KG: f64 = 0.15;

/// Number of grasps of a scenario, as in the paper.
const GRASPS: usize = 200;

/// Number of sampled grasps from which those are selected, as in the paper.
const CANDIDATES: usize = 2000;

/// Number of grasps; sampling stops if no more are accepted after `PATIENT_WAVES` waves of contacts, because the hand then fits
/// few of the remaining ones, and each may cost milliseconds.
const HOPELESS: usize = CANDIDATES / 20;
const PATIENT_WAVES: usize = 40;

impl FamilyMaker {
    /// Samples the grasps of the family's object for the robot's hand, with the object resting on level ground and the
    /// sampler's default settings: from the side or from above, with hand and fingers free of object and ground at the grasp
    /// and along the approach.
    ///
    /// # Errors
    /// [`RobotError::NoHand`](cranny_robot::RobotError::NoHand) for a robot without a known hand,
    /// [`RobotError::ToolGrasps`](cranny_robot::RobotError::ToolGrasps) for one with a tool.
    pub fn new(
        family: Family,
        robot: RecipeRobot,
        scale: SceneScale,
        seed: u64,
    ) -> Result<Self, ScenarioError> {
        let resting = family.resting(scale.object)?;
        robot.robot.hand_with_pads()?;
        let hand = robot_hand(&robot.robot);
        let mesh = &resting.mesh;
        let object_from_ground =
            Pose::from_parts(Vector::new(0.0, 0.0, resting.lift_m).into(), resting.ground_from_object)
                .inverse();
        let world = World::new(vec![
            Body::new("object", Pose::identity(), Solid::mesh(mesh)?),
            Body::new("ground", object_from_ground, Solid::half_space()),
        ])?;
        let filter = HandFilter::new(&hand, world, APPROACH_M)?;
        let settings = SamplerSettings {
            count: CANDIDATES,
            friction: PAPER_FRICTION,
            up: resting.ground_from_object.inverse() * Vector::z(),
            steepest_rise_rad: 0.0,
            ground_m: Some(-resting.lift_m),
            opening_m: hand.opening_m,
            seed,
            ..SamplerSettings::default()
        };
        let accept = |sampled: &SampledGrasp| filter.is_free(&sampled.grasp);
        let mut waves = 0;
        let mut go_on = |found: usize| {
            waves += 1;
            waves < PATIENT_WAVES || found > HOPELESS
        };
        let found = sample_grasps(&Surface::new(mesh)?, &settings, &accept, &mut go_on)?;
        let candidates: Vec<Grasp> = found.grasps.iter().map(|sampled| sampled.grasp).collect();
        let candidates = with_loads(&resting, &hand, candidates)?;
        let few = covering_subset(&candidates, GRASPS, COVERAGE_THRESHOLD);
        let few = few.into_iter().map(|index| candidates[index]).collect();
        Ok(Self { family, robot, scale, resting, hand, candidates, few })
    }

    /// Returns the robot and its pose in the scene.
    pub fn robot(&self) -> &RecipeRobot {
        &self.robot
    }

    /// Returns the scale of its scenes relative to the paper's.
    pub fn scale(&self) -> SceneScale {
        self.scale
    }

    /// Returns the object's placement in the paper at that parameter value (m), in a scene of this scale.
    pub fn paper_placement(&self, parameter_m: f64) -> Placement {
        self.scale.placement(&self.family.paper_placement(parameter_m / self.scale.of_dial(self.family)))
    }

    /// Returns the height of the object's support in the scene, in metres.
    fn support_m(&self) -> f64 {
        self.scale.shift_m[2] + self.scale.across * self.family.support_m()
    }

    /// Returns the scenario at a parameter value (m), with the object as placed in the paper.
    ///
    /// # Errors
    /// [`FamilyError::Parameter`](crate::FamilyError::Parameter) for a value outside the range of the parameter.
    pub fn at(&self, parameter_m: f64) -> Result<Recipe, ScenarioError> {
        let placement = self.paper_placement(parameter_m);
        self.scenario(parameter_m, &placement, Vec::new(), GraspChoice::Covering)
    }

    /// Returns the reversed scenario at a parameter value (m): the object starts outside and must be placed inside
    /// ([`Family::INSIDE`]).
    ///
    /// # Errors
    /// [`FamilyError::Parameter`](crate::FamilyError::Parameter) for a value outside the range of the parameter.
    pub fn insertion(&self, parameter_m: f64) -> Result<Recipe, ScenarioError> {
        let outside = self.scale.place(self.family.outside());
        let PlaceRegion::Surface { pose: outside, .. } = outside.spot else { return self.at(parameter_m) };
        let at = outside.translation.vector;
        let placement = Placement { x_m: at.x, y_m: at.y, yaw_rad: 0.0 };
        let bare = self.bare(parameter_m, &placement, at.z)?;
        let inside = self.paper_placement(parameter_m);
        let inside = PlaceRegion::Target(self.resting.scene_from_object(&inside, self.support_m()));
        let places = vec![PlaceGoal { name: Family::INSIDE.to_owned(), spot: inside }];
        self.with_grasps(Recipe { places, ..bare }, &placement, at.z, GraspChoice::Covering)
    }

    /// Returns the scenario at a parameter value (m) with columns that block the access: they must first be placed on the other
    /// side, then the object outside.
    ///
    /// # Errors
    /// [`FamilyError::Parameter`](crate::FamilyError::Parameter) for a value outside the range of the parameter.
    pub fn clearing(&self, parameter_m: f64) -> Result<Recipe, ScenarioError> {
        let columns = self.family.columns().into_iter().map(|column| self.scale.clutter(column)).collect();
        let placement = self.paper_placement(parameter_m);
        let recipe = self.scenario(parameter_m, &placement, columns, GraspChoice::Covering)?;
        let outside = recipe.places.clone().into_iter();
        let places = outside.chain([self.scale.place(self.family.other_side())]).collect();
        let to = |pick: &RecipeBody, place: &str| {
            let object = Some(pick.name.clone());
            [Stage::Pick(Pick { object, ..Pick::default() }), Stage::place(place), Stage::home()]
        };
        let names: Vec<String> = self.family.columns().into_iter().map(|column| column.name).collect();
        let columns = || recipe.obstacles.iter().filter(|body| names.contains(&body.name));
        let aside = columns().flat_map(|column| to(column, Family::OTHER_SIDE));
        let taken = recipe.target.iter().flat_map(|target| to(target, Family::OUTSIDE));
        let tasks = vec![NamedTask { name: STEPS.to_owned(), stages: aside.chain(taken).collect() }];
        let light = TargetPhysics { mass_kg: Some(COLUMN_KG), ..TargetPhysics::default() };
        let physics = columns().map(|column| (column.name.clone(), light)).collect();
        Ok(Recipe { places, tasks, physics, ..recipe })
    }

    /// Returns the scenario at a parameter value (m), with the object at `placement`, `clutter`, and the grasps that are
    /// collision-free for the hand there: at most 200, possibly none.
    ///
    /// # Errors
    /// [`FamilyError::Parameter`](crate::FamilyError::Parameter) for a value outside the range of the parameter.
    pub fn scenario(
        &self,
        parameter_m: f64,
        placement: &Placement,
        clutter: Vec<RecipeBody>,
        choice: GraspChoice,
    ) -> Result<Recipe, ScenarioError> {
        let mut recipe = self.scenario_without_grasps(parameter_m, placement)?;
        recipe.obstacles.extend(clutter);
        self.with_grasps(recipe, placement, self.support_m(), choice)
    }

    /// Returns the recipe with the collision-free grasps of the object at `placement`, on a support at this height (m).
    fn with_grasps(
        &self,
        mut recipe: Recipe,
        placement: &Placement,
        support_m: f64,
        choice: GraspChoice,
    ) -> Result<Recipe, ScenarioError> {
        let world_from_object =
            self.robot.planning_from_scene() * self.resting.scene_from_object(placement, support_m);
        let filter = HandFilter::new(&self.hand, recipe.world()?, APPROACH_M)?;
        let placed = |grasp: &Grasp| Grasp {
            world_from_gripper: world_from_object * grasp.world_from_gripper,
            ..*grasp
        };
        let robot = &self.robot.robot;
        let free = |grasps: &[Grasp]| -> Vec<Grasp> {
            let mut random = Stream::new(0, 0);
            let mut held = |grasp: Grasp| {
                if robot.dof() >= ALL_POSES_DOF {
                    Some(grasp)
                } else {
                    short_arm::held(robot, &grasp, &mut random)
                }
            };
            let near = grasps.iter().map(placed).filter_map(&mut held);
            near.filter(|grasp| filter.is_free(grasp)).collect()
        };
        let grasps = match choice {
            GraspChoice::Few => free(&self.few),
            GraspChoice::Covering => {
                let free = free(&self.candidates);
                let chosen = covering_subset(&free, GRASPS, COVERAGE_THRESHOLD);
                chosen.into_iter().map(|index| free[index]).collect()
            }
        };
        recipe.grasps = GraspSet::new(grasps)?;
        Ok(recipe)
    }

    /// Returns the scenario without clutter and grasps.
    pub(crate) fn scenario_without_grasps(
        &self,
        parameter_m: f64,
        placement: &Placement,
    ) -> Result<Recipe, ScenarioError> {
        self.bare(parameter_m, placement, self.support_m())
    }

    /// Returns the recipe with obstacles, and the object at `placement` on a support at this height (m).
    fn bare(&self, parameter_m: f64, placement: &Placement, support_m: f64) -> Result<Recipe, ScenarioError> {
        let family = self.family;
        let parameter_m = family.checked(parameter_m, &self.scale)?;
        let obstacles = family.obstacles(parameter_m / self.scale.of_dial(family)).into_iter();
        let title = format!(
            "{} {} {:.0} mm",
            family.name(),
            if family.parameter() == family.name() { "of" } else { family.parameter() },
            parameter_m * 1000.0
        );
        Ok(Recipe {
            title,
            obstacles: obstacles.map(|body| self.scale.obstacle(body)).chain(self.scale.platform()).collect(),
            target: Some(self.resting.body(placement, support_m)),
            given_physics: self.resting.given_physics,
            start: self.robot.start(),
            robot: self.robot.clone(),
            places: vec![self.scale.place(family.outside())],
            regions: BTreeMap::new(),
            tasks: Vec::new(),
            physics: BTreeMap::new(),
            colours: BTreeMap::new(),
            tool_bounds: Vec::new(),
            joint_bounds: BTreeMap::new(),
            speeds: Vec::new(),
            grasps: GraspSet::default(),
            ik: Vec::new(),
        })
    }
}

/// Returns grasps of a resting object, with poses in its frame, and with the load of each if it can be computed.
fn with_loads(resting: &Resting, hand: &Hand, grasps: Vec<Grasp>) -> Result<Vec<Grasp>, ScenarioError> {
    let placement = Placement { x_m: 0.0, y_m: 0.0, yaw_rad: 0.0 };
    let world = World::new(vec![resting.body(&placement, 0.0).body(&Pose::identity())?])?;
    let physics = resting.physics;
    let weight = Weight { mass_kg: physics.mass_kg, ..Weight::default() };
    let Some(load_model) = LoadModel::by_hand(&world, 0, hand, (physics.least_friction(), weight)) else {
        return Ok(grasps);
    };
    let scene_from_object = resting.scene_from_object(&placement, 0.0);
    let loads = GraspSet::new(grasps.clone())?.moved(&scene_from_object).with_loads(load_model.measure());
    let loads = loads.grasps().iter().map(|grasp| grasp.load);
    Ok(grasps.into_iter().zip(loads).map(|(grasp, load)| Grasp { load, ..grasp }).collect())
}
