use cranny_collision::{Body, World};
use cranny_grasp::{Grasp, GraspSet};
use cranny_robot::{Robot, RobotOptions};
use cranny_scenario::{Scenario, SeenOptions};
use cranny_sense::{Camera, CameraFrame, PlacedCamera, SensorModel};
use cranny_shape::Solid;
use cranny_spatial::{Point, Pose, Vector};

/// A ball on three slides before a wall that stands on the floor, and behind the wall a target with one grasp.
pub fn behind_a_wall() -> Scenario {
    let cuboid = |x: f64, y: f64, z: f64| Solid::cuboid(Vector::new(x, y, z)).unwrap();
    let target = Solid::sphere(0.04).unwrap();
    let bodies = vec![
        Body::new("wall", Pose::translation(0.0, 0.0, -0.1), cuboid(0.02, 0.3, 0.3)),
        Body::new("target", Pose::translation(0.45, 0.0, 0.0), target),
        Body::floor(-0.4),
    ];
    let robot = robot();
    let grasps = GraspSet::new(vec![Grasp::at(Pose::translation(0.3, 0.0, 0.0))]).unwrap();
    let world = World::new(bodies).unwrap();
    let bare = Scenario::bare("wall".to_owned(), robot.into(), world, vec![-0.45, 0.0, 0.0]);
    Scenario { target: Some(1), grasps, ..bare }
}

/// Ball on three slides.
pub fn robot() -> Robot {
    let urdf = cranny_test_robots::ball(1.0);
    Robot::from_urdf_text(&urdf, "ball.urdf", None, &RobotOptions::default()).unwrap()
}

/// Camera on the side of the start that looks at the wall.
pub fn bad_camera() -> PlacedCamera {
    let (eye, aim) = (Point::new(-1.1, 0.1, 0.2), Point::new(0.4, 0.0, -0.1));
    let pose = Camera::looking_at(&eye, &aim, &Vector::z()).unwrap();
    PlacedCamera {
        name: "bad".to_owned(),
        frame: CameraFrame::World,
        camera: Camera::with_field_of_view([160, 120], 1.3, pose).unwrap(),
        sensor: SensorModel::default(),
        configuration: None,
    }
}

/// Cells of 2 cm.
pub fn options() -> SeenOptions {
    SeenOptions { cell_m: 0.02, ..SeenOptions::default() }
}
