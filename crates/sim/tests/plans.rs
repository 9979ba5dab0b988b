//! Tests of an arm that executes plans with known outcomes.

use std::sync::{Arc, LazyLock};

use cranny_collision::Body;
use cranny_grasp::{Hand, ShakeTest};
use cranny_path::{MotionLimits, TimingMethod, Trajectory};
use cranny_robot::{IkSearchSettings, Robot, RobotOptions, solve_restarts};
use cranny_scenario::{ObjectSettings, ObjectType, panda_hand};
use cranny_shape::{Solid, Surface};
use cranny_sim::{
    ContactPhase, Disturbance, GraspOutcome, GraspTest, Physics, PlacedError, PlanOutcome, PlanRun, PlanTest,
};
use cranny_solve::TaskTrajectory;
use cranny_spatial::{Pose, Rotation, Stream, Vector};

const URDF: &str = include_str!("../../scenario/robots/panda_mobile/panda_mobile.urdf");
const DESCRIPTION: &str = include_str!("../../scenario/robots/panda_mobile/robot.yaml");
const LIMITS: &str = include_str!("../../scenario/robots/panda_mobile/limits.yaml");
const SRDF: &str = include_str!("../../scenario/robots/panda_mobile/panda_mobile.srdf");

/// Height of the table and half the edge of the cube, in metres.
const TABLE_M: f64 = 0.3;
const HALF_M: f64 = 0.02;

fn robot(urdf: &str) -> Arc<Robot> {
    let text =
        |name: &str, text: &str| cranny_robot::TextSource::Text { name: name.into(), text: text.into() };
    let options = RobotOptions {
        srdf: Some(text("panda.srdf", SRDF)),
        limits: Some(text("limits.yaml", LIMITS)),
        description: Some(text("robot.yaml", DESCRIPTION)),
        tip: Some("panda_grasptarget".to_owned()),
        ..RobotOptions::default()
    };
    Arc::new(Robot::from_urdf_text(urdf, "panda.urdf", None, &options).unwrap())
}

static PANDA: LazyLock<Arc<Robot>> = LazyLock::new(|| robot(URDF));
static HAND_OF_PANDA: LazyLock<Hand> = LazyLock::new(|| panda_hand().unwrap());

/// Test of a cube on a table.
fn test(mass_kg: f64, friction: f64) -> GraspTest {
    let settings = ObjectSettings { friction: friction.into(), ..ObjectSettings::new("cube", mass_kg) };
    let mesh = Surface::cuboid_soup(&Vector::repeat(HALF_M));
    let cube: ObjectType = ObjectType::from_mesh(&mesh, &settings).unwrap().0;
    let half = Vector::new(0.2, 0.2, 0.5 * TABLE_M);
    let table = Solid::cuboid(half).unwrap();
    let table = Body::new("table", Pose::translation(0.6, 0.0, half.z), table);
    let place = Pose::translation(0.6, 0.0, TABLE_M + HALF_M);
    GraspTest::new(&HAND_OF_PANDA, &cube, place, &[table], Physics::default(), ShakeTest::default()).unwrap()
}

/// Path from 10 cm above the cube down to it, `below_m` metres below its middle.
fn way(below_m: f64) -> [Vec<f64>; 2] {
    let down = Rotation::from_axis_angle(&Vector::x_axis(), std::f64::consts::PI);
    let at = |z: f64| Pose::from_parts(Vector::new(0.6, 0.0, z).into(), down);
    let solve = |z: f64, near: &[f64]| {
        let mut solver = cranny_robot::IkSolver::new(&PANDA, cranny_robot::IkSettings::default());
        solver.solve_from(&at(z), near).unwrap().q
    };
    let grasp_m = TABLE_M + HALF_M - below_m;
    let above = solve_restarts(
        &PANDA,
        &at(grasp_m + 0.1),
        &mut Stream::new(1, 0),
        IkSearchSettings::default(),
        1,
        100,
        &mut |_| true,
    );
    let start = above[0].q.clone();
    let end = (1..=10).fold(start.clone(), |q, step| solve(grasp_m + 0.1 - 0.01 * f64::from(step), &q));
    [start, end]
}

fn timed(robot: &Robot, way: &[Vec<f64>; 2]) -> TaskTrajectory {
    let limits = MotionLimits::of(robot, TimingMethod::TimeOptimal).unwrap();
    TaskTrajectory::of_reach(Trajectory::along(way, &limits).unwrap())
}

fn run(robot: &Arc<Robot>, test: GraspTest, way: &[Vec<f64>; 2]) -> PlanRun {
    let plan = PlanTest::new(test, robot.clone()).unwrap();
    plan.run(&timed(robot, way), 0.03, &Disturbance::default(), true).unwrap()
}

#[test]
fn an_arm_reaches_closes_and_lifts() {
    let run = run(&PANDA, test(0.2, 0.5), &way(0.0));
    assert_eq!(run.grasp.outcome, GraspOutcome::Held);
    assert!(run.contacts.is_empty(), "{:?}", run.contacts);
    assert!(run.pushed_m < 1e-4 && (run.lift_m - 0.03).abs() < 1e-12);
    assert!((run.rose_m - 0.03).abs() < 2e-3, "{}", run.rose_m);
    assert!(run.grasp.is_in_hand && run.grasp.world_from_released.is_none());
    assert_eq!(run.outcome(), PlanOutcome::Grasped(GraspOutcome::Held));
    // A released object is placed or misplaced, but never held.
    let off = |translation_m, is_there| Some(PlacedError { translation_m, rotation_rad: 0.0, is_there });
    let let_go = PlanRun { released: off(1e-4, true), ..run.clone() };
    let thrown = PlanRun { placed: off(2.7, false), ..let_go.clone() };
    let stands = PlanRun { placed: off(1e-3, true), ..let_go };
    assert_eq!([thrown, stands].map(|run| run.outcome().name()), ["misplaced", "placed"]);
    // Bodies: object, palm, two fingers, and those of the arm: the static one, the base, and nine joints.
    let recording = run.grasp.recording.unwrap();
    assert_eq!(recording.bodies.len(), 4 + 10);
    assert!(recording.bodies.iter().all(|body| body.world_from_body.len() == recording.times_s.len()));
}

#[test]
fn the_same_plan_gives_the_same_bits() {
    let [first, second] = [(); 2].map(|()| run(&PANDA, test(0.2, 0.5), &way(0.0)));
    assert_eq!(first.grasp.world_from_object, second.grasp.world_from_object);
    assert_eq!(first.pushed_m.to_bits(), second.pushed_m.to_bits());
}

#[test]
fn what_is_too_smooth_stays_behind() {
    let run = run(&PANDA, test(0.4, 0.02), &way(0.0));
    assert_eq!(run.grasp.outcome, GraspOutcome::Dropped);
    assert!(run.rose_m < 0.01, "{}", run.rose_m);
}

#[test]
fn a_plan_into_the_table_is_seen_to_touch_it() {
    let run = run(&PANDA, test(0.2, 0.5), &way(0.015));
    let before = run.contacts.iter().filter(|contact| contact.phase == ContactPhase::Reach);
    let touched: Vec<(&str, &str)> = before.map(|contact| (&contact.link[..], &contact.body[..])).collect();
    assert_eq!(touched, [("hand", "table")]);
}

#[test]
fn motions_that_cannot_be_simulated_are_refused() {
    let plan = PlanTest::new(test(0.2, 0.5), PANDA.clone()).unwrap();
    let [start, _] = way(0.0);
    let sideways = |m: f64| {
        let mut end = start.clone();
        end[0] += m;
        timed(&PANDA, &[start.clone(), end])
    };
    for (path, lift_m, said) in [(sideways(800.0), 0.03, "time of the motion"), (sideways(0.1), -0.1, "lift")]
    {
        let fault = plan.run(&path, lift_m, &Disturbance::default(), false).unwrap_err();
        assert!(fault.to_string().contains(said), "{fault}");
    }
}
