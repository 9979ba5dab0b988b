//! Large sets of random scenarios, each checked for soundness.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use cranny_collision::{Body, Margins, Part, World};
use cranny_grasp::{Grasp, GraspSet};
use cranny_robot::{Robot, RobotFiles};
use cranny_shape::{Solid, quick_lower_bound, separation};
use cranny_spatial::{CONTACT_M, Pose, Rotation, Stream, Vector};
use cranny_task::{IkAnnotationSettings, IkStatus, Problem, annotate_ik};
use serde::{Deserialize, Serialize};

use crate::family::kind::Region;
use crate::robot::in_folder::{ROBOT, write_robot};
use crate::{
    BUILTIN_ROBOTS, Family, FamilyMaker, GraspChoice, OpenOptions, Placement, Recipe, RecipeBody,
    RecipeRobot, RecipeShape, ScenarioError, SceneScale,
};

/// Settings of a set of scenarios.
#[derive(Clone, Debug, PartialEq)]
pub struct SetSettings {
    /// Range of the difficulty parameter, in metres. Default: the usual range of the family, in the scale of the scene.
    pub parameter_m: [f64; 2],
    /// Scale of the scenes relative to the paper's. Default: as suits the robot.
    pub scale: SceneScale,
    /// Required capability of the arm. Default: nothing for the paper's robot, for which the environments were designed;
    /// holding a grasp for the other built-in robots; reaching a grasp for a user's robot.
    pub demand: ArmDemand,
    /// Maximum number of clutter objects; the actual number is random. Default 3.
    pub most_clutter: usize,
    /// Random seed.
    pub seed: u64,
}

/// Required capability of the arm in the scenarios of a set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArmDemand {
    /// No requirement.
    Nothing,
    /// Holding the object at one of the grasps, free of collision, as far as some attempts at some grasps can show.
    Hold,
    /// Reaching a grasp by a short search ([`ReachTest`]). Scenarios selected by this test alone favour its planner.
    Reach,
}

impl SetSettings {
    /// Returns the defaults of a family, for a robot.
    pub fn new(family: Family, robot: &RecipeRobot, seed: u64) -> Self {
        let opening_m = robot.robot.hand().map_or(0.0, |hand| hand.description.opening_m);
        // The scenes were designed for the paper's robot.
        let is_papers = robot.named == BUILTIN_ROBOTS[0].name;
        let scale =
            if is_papers { SceneScale::PAPER } else { SceneScale::of(&robot.robot, family, opening_m) };
        let parameter_m = family.usual_range_m().map(|end| end * scale.of_dial(family));
        let demand = match (is_papers, &robot.files) {
            (true, _) => ArmDemand::Nothing,
            (false, None) => ArmDemand::Hold,
            (false, Some(_)) => ArmDemand::Reach,
        };
        Self { parameter_m, scale, most_clutter: 3, demand, seed }
    }
}

impl SetSettings {
    /// Returns the settings for scenes that are `scene` times as large as the paper's, from 0, excluded, to 1.
    #[must_use]
    pub fn scaled(self, family: Family, scene: f64) -> Self {
        let parameter_m = family.usual_range_m().map(|end| end * scene);
        Self { parameter_m, scale: SceneScale { away: scene, across: scene, ..self.scale }, ..self }
    }
}

/// Scenario of a set.
#[derive(Clone, Debug)]
pub struct SetMember {
    /// The scenario.
    pub recipe: Recipe,
    /// Value of its difficulty parameter, in metres.
    pub parameter_m: f64,
    /// Placement of its object.
    pub placement: Placement,
    /// Number of clutter objects.
    pub clutter: usize,
}

/// Numbers of rejected draws, by reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rejections {
    /// The object or a clutter object touches something other than its support.
    pub things_overlap: usize,
    /// The robot is in collision at its start.
    pub start_collides: usize,
    /// No grasp is collision-free for the hand.
    pub no_free_grasp: usize,
    /// The arm reaches no grasp.
    pub out_of_reach: usize,
}

impl Rejections {
    /// Returns the number of all rejections.
    pub fn total(&self) -> usize {
        self.things_overlap + self.start_collides + self.no_free_grasp + self.out_of_reach
    }

    /// Returns the sum of both, by reason.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self {
            things_overlap: self.things_overlap + other.things_overlap,
            start_collides: self.start_collides + other.start_collides,
            no_free_grasp: self.no_free_grasp + other.no_free_grasp,
            out_of_reach: self.out_of_reach + other.out_of_reach,
        }
    }
}

/// Returns true if a short search finds a path to a grasp of a problem; an error is a message.
pub type ReachTest = fn(&Problem) -> Result<bool, String>;

/// Generator of random scenarios of one family.
#[derive(Clone, Debug)]
pub struct SetMaker {
    maker: FamilyMaker,
    settings: SetSettings,
    start: StartPose,
    /// Files of the robot, unless it is built in.
    files: Option<Arc<RobotFiles>>,
    is_reached: ReachTest,
}

/// Number of rejected draws after which a member is given up: then hardly any draw is sound.
const MOST_DRAWS: usize = 200;

impl SetMaker {
    /// # Errors
    /// [`FamilyError::Parameter`](crate::FamilyError::Parameter) for a range that exceeds that of the parameter; as
    /// [`FamilyMaker::new`].
    pub fn new(
        family: Family,
        robot: RecipeRobot,
        settings: SetSettings,
        is_reached: ReachTest,
    ) -> Result<Self, ScenarioError> {
        for value in settings.parameter_m {
            family.checked(value, &settings.scale)?;
        }
        let start = StartPose::new(&robot.robot, &robot.start());
        let maker = FamilyMaker::new(family, robot.in_set(), settings.scale, settings.seed)?;
        Ok(Self { maker, settings, start, files: robot.files, is_reached })
    }

    /// Writes the files of the robot into its folder, once for all scenarios of a set.
    pub(crate) fn write_robot(&self, folder: &Path) -> Result<(), ScenarioError> {
        self.files.as_ref().map_or(Ok(()), |files| write_robot(&folder.join(ROBOT), files))
    }

    /// Returns the files of the robot, unless it is built in.
    pub(crate) fn files(&self) -> Option<&RobotFiles> {
        self.files.as_deref()
    }

    pub(crate) fn settings(&self) -> &SetSettings {
        &self.settings
    }

    /// Returns the maker of its scenarios.
    pub fn family(&self) -> &FamilyMaker {
        &self.maker
    }

    /// Returns the reason why a recipe is unsound, if any: the start is in collision, for which self-collision does not count,
    /// or no grasp is collision-free.
    ///
    /// # Errors
    /// [`ScenarioError`] for an invalid shape.
    pub fn rejection(&self, recipe: &Recipe) -> Result<Option<Rejections>, ScenarioError> {
        let one = Rejections::default();
        Ok(if self.start.touches(&recipe.world()?) {
            Some(Rejections { start_collides: 1, ..one })
        } else if recipe.grasps.is_empty() {
            Some(Rejections { no_free_grasp: 1, ..one })
        } else if !self.meets(recipe)? {
            Some(Rejections { out_of_reach: 1, ..one })
        } else {
            None
        })
    }

    /// Returns member `index` of the set, the first sound draw of its own random stream, and the rejected draws. Members do not
    /// depend on each other, so any number of threads can generate them in any order.
    ///
    /// # Errors
    /// None unless the built-in files are broken.
    pub fn member(&self, index: u64) -> Result<(Option<SetMember>, Rejections), ScenarioError> {
        let mut random = Stream::new(self.settings.seed, index);
        let mut rejected = Rejections::default();
        for _ in 0..MOST_DRAWS {
            match self.draw(&mut random)? {
                Ok(member) => return Ok((Some(member), rejected)),
                Err(rejection) => rejected = rejected.plus(rejection),
            }
        }
        Ok((None, rejected))
    }

    fn meets(&self, recipe: &Recipe) -> Result<bool, ScenarioError> {
        match self.settings.demand {
            ArmDemand::Nothing => Ok(true),
            ArmDemand::Hold => is_held(recipe),
            ArmDemand::Reach => {
                let problem =
                    || recipe.scenario("draw", &OpenOptions::default())?.problem(Margins::default());
                let search = |problem| ScenarioError::Search { problem };
                Ok(is_held(recipe)? && (self.is_reached)(&problem()?).map_err(search)?)
            }
        }
    }

    fn draw(&self, random: &mut Stream) -> Result<Result<SetMember, Rejections>, ScenarioError> {
        let family = self.maker.family;
        let between = |[low, high]: [f64; 2], random: &mut Stream| random.uniform_between(low, high);
        let parameter_m = between(self.settings.parameter_m, random);
        let (x_m, y_m) = family.object_region();
        let scale = self.maker.scale();
        let paper = self.maker.paper_placement(parameter_m);
        let x_m = between(x_m, random);
        let drawn = y_m.map(|y_m| between(y_m, random));
        let place = scale.point(&Vector::new(x_m, drawn.unwrap_or_default(), 0.0));
        let placement = Placement {
            x_m: place.x,
            y_m: drawn.map_or(paper.y_m, |_| place.y),
            yaw_rad: random.uniform_between(0.0, std::f64::consts::TAU),
        };
        let count = random.index(self.settings.most_clutter + 1);
        let region = family.clutter_region();
        let clutter_of = |index: usize, random: &mut Stream| scale.clutter(thing(index, &region, random));
        let clutter: Vec<RecipeBody> = (0..count).map(|index| clutter_of(index, random)).collect();
        // Cheap checks come first.
        let bare = self.maker.scenario_without_grasps(parameter_m, &placement)?;
        let planning_from_scene = self.maker.robot().planning_from_scene();
        let placed = |body: &RecipeBody| body.body(&planning_from_scene);
        let mut bodies: Vec<Body> = bare.obstacles.iter().map(placed).collect::<Result<_, _>>()?;
        for body in bare.target.iter().chain(&clutter) {
            let body = placed(body)?;
            if !stands_free(&body, &bodies) {
                return Ok(Err(Rejections { things_overlap: 1, ..Rejections::default() }));
            }
            bodies.push(body);
        }
        if self.start.touches(&World::new(bodies)?) {
            return Ok(Err(Rejections { start_collides: 1, ..Rejections::default() }));
        }
        let recipe = self.maker.scenario(parameter_m, &placement, clutter, GraspChoice::Few)?;
        Ok(match self.rejection(&recipe)? {
            Some(rejection) => Err(rejection),
            None => Ok(SetMember { recipe, parameter_m, placement, clutter: count }),
        })
    }
}

/// Returns true if the arm can hold the object at one of the grasps, as far as some attempts at some grasps show.
fn is_held(recipe: &Recipe) -> Result<bool, ScenarioError> {
    /// Number of grasps tried per turn, by descending score; the turns end at the first success.
    const IN_TURN: usize = 20;
    const TURNS: usize = 3;
    /// Attempts for each grasp: few at all of them first, as most placements need no more, and an attempt in collision is slow.
    const FEW: usize = 32;
    const MOST: usize = 400;
    let is_solved = |problem: &Problem, attempts: usize| -> Result<bool, ScenarioError> {
        let settings = IkAnnotationSettings { attempts, ..IkAnnotationSettings::default() };
        let annotations = annotate_ik(problem, &settings, &|| (), &AtomicBool::new(false))?;
        Ok(annotations.iter().any(|annotation| annotation.status == IkStatus::Solved))
    };
    let order = recipe.grasps.by_score();
    let mut tried = Vec::new();
    for turn in order.chunks(IN_TURN).take(TURNS) {
        let some: Vec<Grasp> = turn.iter().map(|&index| recipe.grasps.grasps()[index]).collect();
        let some = Recipe { grasps: GraspSet::new(some)?, ..recipe.clone() };
        let problem = some.scenario("draw", &OpenOptions::default())?.problem(Margins::default())?;
        if is_solved(&problem, FEW)? {
            return Ok(true);
        }
        tried.push(problem);
    }
    for problem in &tried {
        if is_solved(problem, MOST)? {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Returns true if a body touches none of the others except its support, which it may touch.
fn stands_free(thing: &Body, others: &[Body]) -> bool {
    /// Height above its support at which the body is checked, in metres.
    const LIFT_M: f64 = 1e-3;
    let lift = Pose::translation(0.0, 0.0, LIFT_M);
    thing.parts.iter().all(|own| {
        let lifted = lift * own.world_from_solid;
        others
            .iter()
            .flat_map(|other| &other.parts)
            .all(|part| is_apart(&own.solid, &lifted, &part.solid, &part.world_from_solid, 0.0))
    })
}

/// Returns an upright box or cylinder with random size, yaw and position in the region.
fn thing(index: usize, region: &Region, random: &mut Stream) -> RecipeBody {
    let x_m = random.uniform_between(region.across_m[0], region.across_m[1]);
    let y_m = random.uniform_between(region.away_m[0], region.away_m[1]);
    let yaw_rad = random.uniform_between(0.0, std::f64::consts::TAU);
    /// Minimum height, in metres; smaller objects occlude nothing.
    const SHORTEST_M: f64 = 0.05;
    let height_m = random.uniform_between(SHORTEST_M, region.tallest_m);
    // Sizes range from a mug to a large milk carton, in metres.
    let shape = if random.uniform() < 0.5 {
        let side = |random: &mut Stream| random.uniform_between(0.04, 0.12);
        RecipeShape::Cuboid(Vector::new(side(random), side(random), height_m))
    } else {
        RecipeShape::Cylinder(random.uniform_between(0.02, 0.05), height_m)
    };
    let turn = Rotation::from_axis_angle(&Vector::z_axis(), yaw_rad);
    let middle = Vector::new(x_m, y_m, region.floor_m + 0.5 * height_m);
    RecipeBody::new(&format!("clutter {}", index + 1), Pose::from_parts(middle.into(), turn), shape)
}

/// Solids of the robot at its start, in the planning frame.
#[derive(Clone, Debug)]
struct StartPose {
    placed: Vec<(Pose, Solid)>,
    /// Solids that no joint moves; they may touch the floor.
    standing: Vec<(Pose, Solid)>,
}

impl StartPose {
    fn new(robot: &Arc<Robot>, start: &[f64]) -> Self {
        let frames = robot.frames_at(start);
        let (mut placed, mut standing) = (Vec::new(), Vec::new());
        for (index, link) in robot.links().iter().enumerate() {
            let list = if robot.ancestors(index).is_empty() { &mut standing } else { &mut placed };
            for shape in &link.collisions {
                list.push((frames.link(index) * shape.link_from_shape, shape.solid.clone()));
            }
        }
        Self { placed, standing }
    }

    fn touches(&self, world: &World) -> bool {
        let parts = || world.bodies().iter().flat_map(|body| &body.parts);
        let is_free = |(pose, solid): &(Pose, Solid), part: &Part| {
            is_apart(solid, pose, &part.solid, &part.world_from_solid, CONTACT_M)
        };
        !(self.placed.iter().all(|placed| parts().all(|part| is_free(placed, part)))
            && self.standing.iter().all(|standing| {
                parts().filter(|part| !part.solid.is_half_space()).all(|part| is_free(standing, part))
            }))
    }
}

fn is_apart(first: &Solid, first_pose: &Pose, second: &Solid, second_pose: &Pose, gap_m: f64) -> bool {
    quick_lower_bound(first, first_pose, second, second_pose, gap_m) > gap_m
        || separation(first, first_pose, second, second_pose, gap_m.max(CONTACT_M)).lower_m > gap_m
}
