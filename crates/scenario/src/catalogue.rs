use cranny_collision::{Body, World};
use cranny_grasp::{Grasp, GraspSet};
use cranny_robot::RobotOptions;
use cranny_shape::Solid;
use cranny_spatial::nalgebra::Translation3;
use cranny_spatial::{Pose, Stream, Vector};

use crate::released::{FLOOR_M, planning_from_scene};
use crate::{Obstacle, OpenOptions, Scenario, ScenarioError, builtin_robot, hand, robot_file};

/// A scenario that needs no file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CatalogueEntry {
    /// What to open it by: `0`, environment, level.
    pub id: &'static str,
    /// The environment, in a few words.
    pub environment: &'static str,
    /// What is special about this one, in a line.
    pub description: &'static str,
}

/// All built-in scenarios, by id.
pub fn catalogue() -> &'static [CatalogueEntry] {
    &CATALOGUE
}

const UNDER_TABLE: &str = "ball under a table";

const CATALOGUE: [CatalogueEntry; 5] = [
    CatalogueEntry {
        id: "021",
        environment: UNDER_TABLE,
        description: "the ball lies 0.2 m behind the front edge",
    },
    CatalogueEntry {
        id: "022",
        environment: UNDER_TABLE,
        description: "the ball lies 0.3 m behind the front edge",
    },
    CatalogueEntry {
        id: "023",
        environment: UNDER_TABLE,
        description: "the ball lies 0.4 m behind the front edge",
    },
    CatalogueEntry {
        id: "024",
        environment: UNDER_TABLE,
        description: "the ball lies 0.5 m behind the front edge",
    },
    CatalogueEntry {
        id: "025",
        environment: UNDER_TABLE,
        description: "the ball lies 0.6 m behind the front edge",
    },
];

/// The built-in ids, for a message about an unknown one.
pub(crate) fn known_ids() -> String {
    CATALOGUE.map(|entry| entry.id).join(", ")
}

/// The built-in scenario of that id, if there is one.
pub(crate) fn open(id: &str, options: &OpenOptions) -> Option<Result<Scenario, ScenarioError>> {
    let level = CATALOGUE.iter().position(|entry| entry.id == id)?;
    Some(ball_under_table(id, level, options))
}

/// Environment 02. `level` counts from 0.
fn ball_under_table(id: &str, level: usize, options: &OpenOptions) -> Result<Scenario, ScenarioError> {
    let robot = match &options.robot {
        Some(urdf) => robot_file::load(urdf, &RobotOptions::default())?,
        None => builtin_robot::panda_mobile()?,
    };
    let planning_from_scene = planning_from_scene();
    let ball_in_scene = Vector::new(1.0, 0.8 + 0.1 * level as f64, 0.034);
    let planning_from_ball = planning_from_scene * Translation3::from(ball_in_scene);
    let planning_from_table = planning_from_scene * Pose::translation(0.0, 0.6, 0.0);
    let bodies = vec![
        Obstacle::TABLE.body("table", &planning_from_table)?,
        Body::new("ball", planning_from_ball, Solid::sphere(BALL_RADIUS_M)?),
        Body::floor(FLOOR_M),
    ];
    Scenario {
        id: id.to_owned(),
        criterion: options.criterion.unwrap_or_default(),
        hand_links: hand::hand_links(&robot),
        robot,
        world: World::new(bodies)?,
        target: Some(1),
        start: START.to_vec(),
        grasps: sphere_grasps(&planning_from_ball, BALL_RADIUS_M)?,
        ik: Vec::new(),
        export: None,
    }
    .with_checked_start(id)
}

/// The radius of the tennis ball of the YCB object set, whose diameter is given as 64.7 mm.
const BALL_RADIUS_M: f64 = 0.03235;

/// The start of every scenario of the paper (base y, base x in m; the seven joints of the arm in rad).
const START: [f64; 9] = [0.0, 0.0, -0.0178, -0.7601, 0.0198, -2.3421, 0.0298, 1.5412, 0.7534];

/// Grasps of a sphere: closing axes through its centre, uniform over all directions, approach directions
/// uniform about them, the gripper frame's origin at the centre. Together that is a rotation uniform over
/// SO(3). Every level of an environment has the same ones, so that levels differ in nothing but the place.
///
/// A sphere looks the same from everywhere, so an open hand fits around it for all of them or for none. They
/// have no score: for each, the contact normals lie on the closing axis, so any score by friction would be
/// one constant.
fn sphere_grasps(planning_from_ball: &Pose, radius_m: f64) -> Result<GraspSet, ScenarioError> {
    let mut random = Stream::new(GRASP_SEED, 0);
    let grasps = (0..GRASPS).map(|_| Grasp {
        world_from_gripper: Pose::from_parts(planning_from_ball.translation, random.rotation()),
        score: None,
        width_m: Some(2.0 * radius_m),
    });
    Ok(GraspSet::new(grasps.collect())?)
}

/// As many as each scenario of the paper has.
const GRASPS: usize = 200;

/// The environment's number; any other would do as well.
const GRASP_SEED: u64 = 2;
