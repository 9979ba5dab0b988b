//! Tests of grasps with known outcomes.

use cranny_collision::Body;
use cranny_grasp::{BoxHand, Hand, ShakeTest};
use cranny_scenario::{ObjectSettings, ObjectType};
use cranny_shape::{Solid, Surface, TriangleSoup};
use cranny_sim::{Disturbance, GraspOutcome, GraspRun, GraspTest, Physics, Uncertainty};
use cranny_spatial::{Pose, Rotation, Vector};

fn hand() -> Hand {
    BoxHand::default().hand().unwrap()
}

fn object(mesh: &TriangleSoup, mass_kg: f64, friction: f64) -> ObjectType {
    let settings = ObjectSettings { friction: friction.into(), ..ObjectSettings::new("object", mass_kg) };
    ObjectType::from_mesh(mesh, &settings).unwrap().0
}

/// Cube of 4 cm.
fn cube(mass_kg: f64, friction: f64) -> ObjectType {
    object(&Surface::cuboid_soup(&Vector::repeat(0.02)), mass_kg, friction)
}

fn floating(object: &ObjectType) -> GraspTest {
    GraspTest::new(&hand(), object, Pose::identity(), &[], Physics::default(), ShakeTest::default()).unwrap()
}

/// Pose of a grasp from above: z of the gripper down, its origin at this height in metres.
fn from_above(height_m: f64) -> Pose {
    let down = Rotation::from_axis_angle(&Vector::x_axis(), std::f64::consts::PI);
    Pose::from_parts(Vector::new(0.0, 0.0, height_m).into(), down)
}

fn run(test: &GraspTest, grasp: &Pose) -> GraspRun {
    test.run(grasp, &Disturbance::default(), false)
}

#[test]
fn what_is_held_in_the_middle_stays_there() {
    let run = run(&floating(&cube(0.2, 0.5)), &from_above(0.0));
    assert_eq!(run.outcome, GraspOutcome::Held);
    assert!(run.translation_error_m < 1e-3 && run.rotation_error_rad < 0.02, "{run:?}");
    assert!((run.held_s - ShakeTest::default().duration_s()).abs() < 1e-9);
    assert!((run.contact_force_n - 40.0).abs() < 0.8, "{} N", run.contact_force_n);
}

/// Gravity and the lift follow the direction of up, in whatever frame the robot plans.
#[test]
fn a_turned_frame_gives_the_same_load_and_the_same_outcome() {
    let turn = Pose::rotation(Vector::new(0.5, -0.3, 0.8));
    for (friction, expected) in [(0.5, GraspOutcome::Held), (0.02, GraspOutcome::Dropped)] {
        let tests = [Pose::identity(), turn].map(|turn| {
            let physics = Physics { up: turn * Vector::z(), ..Physics::default() };
            GraspTest::new(&hand(), &cube(0.3, friction), turn, &[], physics, ShakeTest::default()).unwrap()
        });
        let grasps = [from_above(0.0), turn * from_above(0.0)];
        let loads = [0, 1].map(|k| tests[k].load_of(&grasps[k]).unwrap().at_rest);
        assert!((loads[0] - loads[1]).abs() < 1e-6 * loads[0], "{loads:?}");
        let runs = [0, 1].map(|k| run(&tests[k], &grasps[k]));
        assert_eq!(runs.each_ref().map(|run| run.outcome), [expected; 2], "{runs:?}");
    }
}

/// A quarter of a pipe with a wall of 4 mm, which convex parts fill partly: the fingers close on the wall itself.
#[test]
fn fingers_close_on_a_curved_wall_and_not_on_the_convex_parts_around_it() {
    let mut outline = Vec::new();
    for (radius_m, steps) in [(0.04, 0..=8), (0.036, 0..=8)] {
        let angles: Vec<i32> = if radius_m > 0.038 { steps.collect() } else { steps.rev().collect() };
        for step in angles {
            let (sine, cosine) =
                cranny_spatial::sin_cos(std::f64::consts::PI * (0.25 + f64::from(step) / 16.0));
            outline.push([radius_m * cosine, radius_m * sine]);
        }
    }
    let count = u32::try_from(outline.len()).unwrap();
    let mut wall = TriangleSoup::default();
    for z in [-0.03, 0.03] {
        wall.vertices.extend(outline.iter().map(|[x, y]| cranny_spatial::Point::new(*x, *y, z)));
    }
    for side in 0..count {
        let next = (side + 1) % count;
        wall.triangles.extend([[side, next, next + count], [side, next + count, side + count]]);
    }
    // Both ends: the outer side of a step, and the inner one opposite to it.
    for step in 0..count / 2 - 1 {
        let quad = [step, step + 1, count - 2 - step, count - 1 - step];
        for [a, b, c] in [[0, 2, 1], [0, 3, 2]] {
            wall.triangles.push([quad[a], quad[b], quad[c]]);
            wall.triangles.push([quad[a] + count, quad[c] + count, quad[b] + count]);
        }
    }
    let test = floating(&object(&wall, 0.1, 0.5));
    let run =
        test.run(&(Pose::translation(0.0, 0.038, 0.0) * from_above(0.025)), &Disturbance::default(), true);
    assert_eq!(run.outcome, GraspOutcome::Held, "{run:?}");
    let recording = run.recording.unwrap();
    let moved = |name: &str| {
        let body = recording.bodies.iter().find(|body| body.name == name).unwrap();
        let palm = recording.bodies.iter().find(|body| body.name == "palm").unwrap();
        let at = |index: usize| palm.world_from_body[index].inverse() * body.world_from_body[index];
        (at(recording.times_s.len() - 1).translation.vector - at(0).translation.vector).norm()
    };
    let gap_m = BoxHand::default().opening_m - moved("finger 1") - moved("finger 2");
    assert!((gap_m - 0.004).abs() < 1e-3, "{gap_m}");
}

/// The springs of the pads accelerate a gram by 10⁵ m/s² where they are not in balance.
#[test]
fn what_is_light_is_not_flung_off() {
    for beside_m in [0.0, 0.004, -0.009] {
        for turn_rad in [0.0, 0.1] {
            let pose = Pose::translation(beside_m, 0.5 * beside_m, 0.0)
                * Pose::rotation(Vector::z() * turn_rad)
                * from_above(beside_m);
            let run = run(&floating(&cube(0.001, 0.5)), &pose);
            assert_eq!(run.outcome, GraspOutcome::Held, "{beside_m} m, {turn_rad} rad: {run:?}");
        }
    }
}

#[test]
fn what_is_too_smooth_or_too_heavy_falls() {
    // Friction bears 2 μ N = 1.6 N, or 4 N, of the weight.
    for (mass_kg, friction) in [(0.25, 0.02), (0.6, 0.05)] {
        let run = run(&floating(&cube(mass_kg, friction)), &from_above(0.0));
        assert_eq!(run.outcome, GraspOutcome::Dropped, "{mass_kg} kg, {friction}");
        assert!(run.held_s < 1.0 && run.simulated_s < 2.5, "{run:?}");
    }
}

#[test]
fn what_is_not_between_the_fingers_is_not_closed_on() {
    let ball = object(&TriangleSoup::geodesic_sphere(0.02, 3), 0.05, 0.3);
    let test = floating(&ball);
    let beside = run(&test, &from_above(0.1));
    assert_eq!(beside.outcome, GraspOutcome::NeverClosed);
    assert!(beside.translation_error_m < 1e-9 && beside.held_s == 0.0);
    // The tips, 7 mm ahead, close 13 mm from the middle of the ball and squeeze it out.
    let squeezed = run(&test, &from_above(0.02));
    assert_eq!(squeezed.outcome, GraspOutcome::KnockedAway, "{squeezed:?}");
}

#[test]
fn an_open_hand_that_stands_in_something_begins_no_grasp() {
    let beside = Pose::translation(0.0, 0.03, 0.0) * from_above(0.0);
    let in_cube = run(&floating(&cube(0.2, 0.5)), &beside);
    let floor = Body::floor(-0.02);
    let standing = GraspTest::new(
        &hand(),
        &cube(0.2, 0.5),
        Pose::identity(),
        &[floor],
        Physics::default(),
        ShakeTest::default(),
    );
    let in_floor = run(&standing.unwrap(), &from_above(-0.02));
    for (run, outcome) in [(in_cube, GraspOutcome::KnockedAway), (in_floor, GraspOutcome::NeverClosed)] {
        assert_eq!((run.outcome, run.simulated_s), (outcome, 0.0), "{run:?}");
    }
}

#[test]
fn what_lies_is_lifted_off_what_carries_it() {
    let floor =
        Body::new("table", Pose::translation(0.0, 0.0, 0.25), Solid::cuboid(Vector::repeat(0.25)).unwrap());
    let object = cube(0.2, 0.5);
    // The object starts 3 mm above the table, as in files of other projects, and settles first.
    let place = Pose::translation(0.0, 0.0, 0.523);
    let test =
        GraspTest::new(&hand(), &object, place, &[floor], Physics::default(), ShakeTest::default()).unwrap();
    assert!((test.world_from_object().translation.z - 0.52).abs() < 5e-4);
    let run = test.run(&from_above(0.525), &Disturbance::default(), true);
    assert_eq!(run.outcome, GraspOutcome::Held, "{run:?}");
    let recording = run.recording.unwrap();
    let names: Vec<&str> = recording.bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!(names, ["object", "palm", "finger 1", "finger 2"]);
    let heights: Vec<f64> =
        recording.bodies[0].world_from_body.iter().map(|pose| pose.translation.z).collect();
    assert_eq!(heights.len(), recording.times_s.len());
    assert!((heights[heights.len() - 1] - 0.62).abs() < 2e-3, "ends at {:?} m", heights.last());
}

#[test]
fn where_in_the_world_it_happens_makes_no_difference() {
    let floor = Body::floor(0.0);
    let object = cube(0.3, 0.3);
    let outcome = |turn_rad: f64| {
        let turn = Rotation::from_axis_angle(&Vector::z_axis(), turn_rad);
        let moved = Pose::from_parts(Vector::new(0.7, -1.3, 0.0).into(), turn);
        let place = moved * Pose::translation(0.0, 0.0, 0.02);
        let test = GraspTest::new(
            &hand(),
            &object,
            place,
            std::slice::from_ref(&floor),
            Physics::default(),
            ShakeTest::default(),
        )
        .unwrap();
        run(&test, &(moved * from_above(0.03)))
    };
    let here = outcome(0.0);
    for turn_rad in [0.5, 2.0, 4.0] {
        let there = outcome(turn_rad);
        assert_eq!(there.outcome, here.outcome);
        assert!((there.translation_error_m - here.translation_error_m).abs() < 2e-4, "{here:?} {there:?}");
    }
}

#[test]
fn the_same_test_gives_the_same_bits_on_any_number_of_threads() {
    let test = floating(&object(&TriangleSoup::geodesic_sphere(0.025, 2), 0.1, 0.3));
    let errors = Uncertainty::default().design(12, 5);
    let trials: Vec<(Pose, Disturbance)> = errors.iter().map(|error| (from_above(0.002), *error)).collect();
    let bits = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let runs = pool.install(|| test.run_all(&trials, &|| {}, &|| false));
        runs.into_iter()
            .map(|run| run.unwrap())
            .map(|run| (run.outcome, run.translation_error_m.to_bits(), run.rotation_error_rad.to_bits()))
            .collect::<Vec<_>>()
    };
    assert_eq!(bits(1), bits(3));
    // A stopped run has no result.
    let stopped = test.run_all(&trials, &|| {}, &|| true);
    assert!(stopped.iter().all(Option::is_none));
}
