//! Tests of the export for other engines: `python/tests/test_mujoco_grasps.py` runs the golden experiment.

use std::f64::consts::PI;
use std::fs;
use std::path::Path;

use cranny_collision::Body;
use cranny_grasp::{BoxHand, ShakeTest};
use cranny_scenario::{ObjectSettings, ObjectType};
use cranny_shape::TriangleSoup;
use cranny_sim::{Disturbance, GraspOutcome, GraspTest, Physics};
use cranny_spatial::{Point, Pose, Rotation, Vector};

/// Half the edge of the cube, in metres.
const HALF_M: f64 = 0.02;

/// Test of a cube of 4 cm and 200 g on the floor, with a small hand.
fn cube_test() -> GraspTest {
    let corners: Vec<Point> = (0..8)
        .map(|corner: u32| {
            Point::from([0, 1, 2].map(|axis| if corner >> axis & 1 == 1 { HALF_M } else { -HALF_M }))
        })
        .collect();
    let soup = TriangleSoup::convex_hull(&corners).unwrap();
    let settings = ObjectSettings { friction: 0.5.into(), ..ObjectSettings::new("cube", 0.2) };
    let (object, _) = ObjectType::from_mesh(&soup, &settings).unwrap();
    let hand = BoxHand::default().hand().unwrap();
    let world_from_object = Pose::translation(0.0, 0.0, HALF_M);
    let floor = [Body::floor(0.0)];
    GraspTest::new(&hand, &object, world_from_object, &floor, Physics::default(), ShakeTest::default())
        .unwrap()
}

/// Grasps from above: one around the cube, one above it.
fn grasps() -> Vec<Pose> {
    let down = Rotation::from_axis_angle(&Vector::x_axis(), PI);
    [HALF_M, 0.2].map(|height_m| Pose::from_parts(Vector::new(0.0, 0.0, height_m).into(), down)).to_vec()
}

#[test]
fn the_cube_is_held_and_the_air_is_not() {
    let outcome = |grasp: &Pose| cube_test().run(grasp, &Disturbance::default(), false).outcome;
    let outcomes: Vec<GraspOutcome> = grasps().iter().map(outcome).collect();
    assert_eq!(outcomes, [GraspOutcome::Held, GraspOutcome::NeverClosed]);
}

/// Regression test; `CRANNY_WRITE=1` rewrites the golden file.
#[test]
fn the_experiment_with_the_cube_is_the_golden_one() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/cube_experiment.json");
    let text = serde_json::to_string_pretty(&cube_test().experiment(&grasps())).unwrap() + "\n";
    if std::env::var_os("CRANNY_WRITE").is_some() {
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, &text).unwrap();
    }
    let golden = fs::read_to_string(&path).expect("the golden experiment; CRANNY_WRITE=1 writes it");
    assert!(text == golden, "the experiment has changed; look at it, then write it anew with CRANNY_WRITE=1");
}
