//! Tests that targets rest at their poses in scenarios.

use cranny_collision::{Body, World};
use cranny_robot::RobotOptions;
use cranny_scenario::{BuiltinRobot, OpenOptions, Scenario, TargetPhysics, built_in};
use cranny_shape::{Solid, TriangleSoup};
use cranny_sim::Rest;
use cranny_spatial::{Point, Pose};

#[test]
fn the_target_of_every_built_in_scenario_rests_where_it_stands() {
    for entry in built_in() {
        let scenario = Scenario::open(entry.id, &OpenOptions::default()).unwrap();
        let rest = Rest::of_target(&scenario).unwrap().expect("a target on something");
        assert!(rest.is_at_rest(), "{}: {rest:?}", entry.id);
    }
}

/// Frustums of a cone on faces with 5 to 48 corners. The engine alone supports a face on a plane at its first four corners.
#[test]
fn faces_with_many_corners_stand_on_the_floor() {
    for corners in [5, 6, 7, 12, 48] {
        let ring = |radius_m: f64, z: f64| {
            (0..corners).map(move |index| {
                let angle = f64::from(index) * std::f64::consts::TAU / f64::from(corners);
                Point::new(radius_m * libm::cos(angle), radius_m * libm::sin(angle), z)
            })
        };
        let points: Vec<Point> = ring(0.04, 0.0).chain(ring(0.02, 0.09)).collect();
        let mesh = TriangleSoup::convex_hull(&points).unwrap();
        let frustum = Body::new("frustum", Pose::translation(1.0, 0.0, 0.0), Solid::mesh(&mesh).unwrap());
        let robot = BuiltinRobot::of_name("panda_mobile").unwrap().robot(&RobotOptions::default()).unwrap();
        let start = vec![0.0; robot.dof()];
        let world = World::new(vec![frustum, Body::floor(0.0)]).unwrap();
        let mut scenario = Scenario::bare("stands".to_owned(), robot, world, start);
        scenario
            .physics
            .insert("frustum".to_owned(), TargetPhysics { mass_kg: Some(0.2), ..TargetPhysics::default() });
        let rest = Rest::of_target(&scenario.with_target("frustum").unwrap())
            .unwrap()
            .expect("a target on the floor");
        assert!(rest.is_at_rest(), "{corners} corners: {rest:?}");
    }
}
