//! Large sets of random scenarios, each checked to be sound.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use cranny_collision::{Body, Margins, Part, World};
use cranny_grasp::{Grasp, GraspSet};
use cranny_robot::{Robot, RobotFiles};
use cranny_shape::{Solid, quick_lower_bound, separation};
use cranny_spatial::{CONTACT_M, Pose, Rotation, Stream, Vector};
use cranny_task::{IkAnnotationSettings, IkStatus, Problem, annotate_ik};
use serde::Serialize;

use crate::family::kind::Region;
use crate::robot::in_folder::{ROBOT, write_robot};
use crate::{
    BUILTIN_ROBOTS, Family, FamilyMaker, GraspChoice, OpenOptions, Placement, Recipe, RecipeBody,
    RecipeRobot, RecipeShape, ScenarioError, SceneScale,
};

/// What the scenarios of a set may be like.
#[derive(Clone, Debug, PartialEq)]
pub struct SetSettings {
    /// Between which values of the dial, in metres. Default: the family's usual range, in the scale of the scene.
    pub parameter_m: [f64; 2],
    /// How much smaller than the paper's the scenes are. Default: as it suits the robot.
    pub scale: SceneScale,
    /// What the arm must be able to do. Default: nothing for the paper's own robot, for which the environments were made,
    /// to hold a grasp for the other built-in ones, to get there for a robot of one's own.
    pub demand: ArmDemand,
    /// At most so many things stand about; how many is drawn. Default 3.
    pub most_clutter: usize,
    /// Seed of all randomness.
    pub seed: u64,
}

/// What the arm must be able to do in the scenarios of a set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArmDemand {
    /// Nothing is asked.
    Nothing,
    /// To hold the object at one of the grasps, free of collision, as far as some attempts at some of them show.
    Hold,
    /// That a short search ([`ReachTest`]) finds a way to a grasp. Scenarios of which only this is known favour its planner.
    Reach,
}

impl SetSettings {
    /// The defaults of a family, for a robot.
    pub fn new(family: Family, robot: &RecipeRobot, seed: u64) -> Self {
        let opening_m = robot.robot.hand().map_or(0.0, |hand| hand.description.opening_m);
        // For the paper's robot the scenes were made.
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
    /// The same in scenes that are `scene` times as large as the paper's, from 0, excluded, to 1.
    #[must_use]
    pub fn scaled(self, family: Family, scene: f64) -> Self {
        let parameter_m = family.usual_range_m().map(|end| end * scene);
        Self { parameter_m, scale: SceneScale { away: scene, across: scene, ..self.scale }, ..self }
    }
}

/// One scenario of a set.
#[derive(Clone, Debug)]
pub struct SetMember {
    /// The scenario.
    pub recipe: Recipe,
    /// The value of its dial, in metres.
    pub parameter_m: f64,
    /// Where its object lies.
    pub placement: Placement,
    /// How many things stand about.
    pub clutter: usize,
}

/// Why draws were not sound, and how many each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Rejections {
    /// The object, or a thing that stands about, touches something else than what it stands on.
    pub things_overlap: usize,
    /// The robot touches something where it starts.
    pub start_collides: usize,
    /// The hand can take no grasp.
    pub no_free_grasp: usize,
    /// The arm comes to no grasp.
    pub out_of_reach: usize,
}

impl Rejections {
    /// All of them.
    pub fn total(&self) -> usize {
        self.things_overlap + self.start_collides + self.no_free_grasp + self.out_of_reach
    }

    /// Both together.
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

/// Whether a short search finds a way to a grasp of a problem; a fault is a message.
pub type ReachTest = fn(&Problem) -> Result<bool, String>;

/// Draws scenarios of one family.
#[derive(Clone, Debug)]
pub struct SetMaker {
    maker: FamilyMaker,
    settings: SetSettings,
    start: StartPose,
    /// Of the robot, unless it is built in.
    files: Option<Arc<RobotFiles>>,
    is_reached: ReachTest,
}

/// After so many draws without a sound one a member is given up: then hardly any is sound.
const MOST_DRAWS: usize = 200;

impl SetMaker {
    /// # Errors
    /// [`FamilyError::Parameter`](crate::FamilyError::Parameter) for a range beyond the dial's; as [`FamilyMaker::new`].
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

    /// Writes the files of the robot once for all scenarios of a set, into its folder.
    pub(crate) fn write_robot(&self, folder: &Path) -> Result<(), ScenarioError> {
        self.files.as_ref().map_or(Ok(()), |files| write_robot(&folder.join(ROBOT), files))
    }

    /// Who makes its scenarios.
    pub fn family(&self) -> &FamilyMaker {
        &self.maker
    }

    /// What is unsound about a recipe, if anything: the start touches something, or no grasp is free. That
    /// the robot does not touch itself at the start is the same for all.
    ///
    /// # Errors
    /// [`ScenarioError`] for a shape that is none.
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

    /// The member `index` of the set, the first sound draw of its own random stream, and the draws that were
    /// not. Members do not depend on each other, so they may be made in any order, by any number of threads.
    ///
    /// # Errors
    /// None on a sound build.
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
        // Cheap checks first.
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

/// Whether the arm can hold the object at one of the grasps, as far as some attempts at some of them show.
fn is_held(recipe: &Recipe) -> Result<bool, ScenarioError> {
    /// So many grasps, from the best score down, are tried in turns until one is held.
    const IN_TURN: usize = 20;
    const TURNS: usize = 3;
    let settings = IkAnnotationSettings { attempts: 400, ..IkAnnotationSettings::default() };
    let order = recipe.grasps.by_score();
    for turn in order.chunks(IN_TURN).take(TURNS) {
        let some: Vec<Grasp> = turn.iter().map(|&index| recipe.grasps.grasps()[index]).collect();
        let some = Recipe { grasps: GraspSet::new(some)?, ..recipe.clone() };
        let problem = some.scenario("draw", &OpenOptions::default())?.problem(Margins::default())?;
        let annotations = annotate_ik(&problem, &settings, &|| (), &AtomicBool::new(false))?;
        if annotations.iter().any(|annotation| annotation.status == IkStatus::Solved) {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Whether a thing touches none of the others but what it stands on, which it may.
fn stands_free(thing: &Body, others: &[Body]) -> bool {
    /// So far above its ground it is asked, in metres.
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

/// A box or a cylinder, upright, turned at random, somewhere in the region.
fn thing(index: usize, region: &Region, random: &mut Stream) -> RecipeBody {
    let x_m = random.uniform_between(region.across_m[0], region.across_m[1]);
    let y_m = random.uniform_between(region.away_m[0], region.away_m[1]);
    let yaw_rad = random.uniform_between(0.0, std::f64::consts::TAU);
    /// Smaller things hide nothing.
    const SHORTEST_M: f64 = 0.05;
    let height_m = random.uniform_between(SHORTEST_M, region.tallest_m);
    // From a mug to a large carton of milk, in metres.
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

/// The solids of the robot where it starts, in the planning frame.
#[derive(Clone, Debug)]
struct StartPose {
    placed: Vec<(Pose, Solid)>,
    /// Those that no joint moves, which may touch the floor they stand on.
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
