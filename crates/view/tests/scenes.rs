//! Tests that scenes contain everything of the task in its location.

use std::path::Path;

use cranny_path::Trajectory;
use cranny_robot::{Robot, RobotOptions};
use cranny_scenario::{OpenOptions, Scenario};
use cranny_solve::Timing;
use cranny_test_robots::SLIDE;
use cranny_view::{Colour, Role, SampledPath, Scene, SceneSettings, ViewError};

fn scenario(id: &str) -> Scenario {
    Scenario::open(id, &OpenOptions::default()).expect("a built-in scenario")
}

fn moved(scenario: &Scenario) -> Vec<Vec<f64>> {
    let mut end = scenario.start.clone();
    for (joint, step) in end.iter_mut().zip([0.4, -0.3, 0.5, 0.2, -0.4, 0.3, 0.6, -0.5, 0.7]) {
        *joint += step;
    }
    vec![scenario.start.clone(), end]
}

fn trajectory(scenario: &Scenario, waypoints: &[Vec<f64>]) -> Option<Trajectory> {
    Timing::default().along(&scenario.robot, waypoints).unwrap()
}

fn shown(scenario: &Scenario, waypoints: &[Vec<f64>], rate_hz: f64) -> SampledPath {
    let trajectory = trajectory(scenario, waypoints);
    SampledPath::of(&scenario.robot, waypoints, trajectory.as_ref(), rate_hz).unwrap().unwrap()
}

#[test]
fn parts_have_their_own_colours_or_those_of_their_kind() {
    let mut scenario = scenario("021");
    let material_of = |scene: &Scene, name: &str, nth: usize| {
        let node = scene.nodes.iter().filter(|node| node.name == name).nth(nth).unwrap();
        scene.materials[scene.meshes[node.mesh.unwrap()].pieces[0].material].clone()
    };
    let before = Scene::of_task(&scenario, None, &SceneSettings::default()).unwrap();
    scenario.colours.insert("table".to_owned(), vec![None, Some([1.0, 0.0, 0.0])]);
    scenario.colours.insert("ball".to_owned(), vec![Some([0.0, 0.0, 1.0])]);
    let scene = Scene::of_task(&scenario, None, &SceneSettings::default()).unwrap();
    assert_eq!(material_of(&scene, "table", 1).colour, Colour([1.0, 0.0, 0.0]));
    for part in [0, 2] {
        assert_eq!(material_of(&scene, "table", part), material_of(&before, "table", part));
    }
    assert_eq!(material_of(&scene, "ball", 0).colour, Colour([0.0, 0.0, 1.0]));
}

#[test]
fn a_faster_scene_has_the_same_motion_in_less_time() {
    let scenario = scenario("021");
    let path = shown(&scenario, &moved(&scenario), 10.0);
    let scene = Scene::of_task(&scenario, Some(&path), &SceneSettings::default()).unwrap();
    let faster = scene.clone().at_speed(4.0).motion.unwrap();
    let motion = scene.motion.unwrap();
    assert_eq!(faster.tracks, motion.tracks);
    assert!(
        faster.times_s.iter().zip(&motion.times_s).all(|(fast, time_s)| (4.0 * fast - time_s).abs() < 1e-12)
    );
}

#[test]
fn links_are_where_forward_kinematics_puts_them_at_every_instant() {
    let scenario = scenario("021");
    let path = shown(&scenario, &moved(&scenario), 10.0);
    let scene = Scene::of_task(&scenario, Some(&path), &SceneSettings::default()).unwrap();
    let mut frames = scenario.robot.frames();
    assert!(path.configurations.len() > 5);
    for (frame, q) in path.configurations.iter().enumerate() {
        scenario.robot.forward_kinematics(q, &mut frames);
        let world_from_nodes = scene.world_from_nodes(Some(frame));
        for (node, pose) in scene.nodes.iter().zip(&world_from_nodes) {
            let Role::Link(link) = node.role else { continue };
            let difference = frames.link(link).inv_mul(pose);
            assert!(difference.translation.vector.norm() < 1e-12 && difference.rotation.angle() < 1e-7);
        }
    }
    let motion = scene.motion.as_ref().unwrap();
    assert_eq!(motion.tracks.len(), scenario.robot.dof(), "a track for each joint");
    assert_eq!(motion.waypoint_times_s.len(), 2);
    assert_eq!(motion.times_s.first(), Some(&0.0));
    assert_eq!(motion.times_s.last(), motion.waypoint_times_s.last());
}

#[test]
fn a_scene_holds_robot_bodies_grasps_and_floor() {
    for (id, obstacles) in [("011", 6), ("021", 3), ("031", 2), ("041", 4)] {
        let scenario = scenario(id);
        let scene = Scene::of_task(&scenario, None, &SceneSettings { grasps: usize::MAX }).unwrap();
        let count = |is: fn(&Role) -> bool| scene.nodes.iter().filter(|node| is(&node.role)).count();
        assert_eq!(count(|role| matches!(role, Role::Link(_))), scenario.robot.links().len());
        assert_eq!(count(|role| matches!(role, Role::Obstacle(_))), obstacles, "{id}");
        assert_eq!(count(|role| matches!(role, Role::Target)), 1);
        assert_eq!(count(|role| matches!(role, Role::Grasp { .. })), 200);
        assert!(scene.world_from_floor.is_some() && scene.motion.is_none());
        for mesh in &scene.meshes {
            for piece in &mesh.pieces {
                assert_eq!(piece.positions.len(), piece.normals.len());
                assert!(piece.material < scene.materials.len());
                assert!(piece.triangles.iter().flatten().all(|&i| (i as usize) < piece.positions.len()));
                assert!(piece.positions.iter().flatten().all(|x| x.is_finite()), "{}", mesh.name);
                let length = |n: &[f32; 3]| n.iter().map(|x| x * x).sum::<f32>().sqrt();
                assert!(piece.normals.iter().all(|n| (length(n) - 1.0).abs() < 1e-3), "{}", mesh.name);
            }
        }
    }
}

#[test]
fn the_built_in_robot_is_smooth_light_and_no_larger_than_it_is() {
    let scenario = scenario("021");
    let scene = Scene::of_task(&scenario, None, &SceneSettings { grasps: 0 }).unwrap();
    let robot = &scenario.robot;
    let mut triangles = 0;
    for (node, link) in scene.nodes.iter().zip(robot.links()) {
        let Some(mesh) = node.mesh.map(|mesh| &scene.meshes[mesh]) else { continue };
        triangles += mesh.pieces.iter().map(|piece| piece.triangles.len()).sum::<usize>();
        if link.name == "mobile_platform" {
            // The wheels of the platform reach down to the floor.
            continue;
        }
        for position in mesh.pieces.iter().flat_map(|piece| &piece.positions) {
            let point = cranny_spatial::Point::from(position.map(f64::from));
            let beyond = link.collisions.iter().map(|shape| distance(shape, &point)).fold(f64::MAX, f64::min);
            // Fillets, rings and caps protrude by less than the width of a finger.
            assert!(beyond < 0.012, "{}: {beyond} m outside at {point}", link.name);
        }
    }
    assert!((20_000..60_000).contains(&triangles), "{triangles} triangles");
}

/// Returns the distance of a point from a shape of a link, in metres, by a small ball around the point.
fn distance(shape: &cranny_robot::LinkShape, point_in_link: &cranny_spatial::Point) -> f64 {
    const BALL_M: f64 = 1e-6;
    let ball = cranny_shape::Solid::sphere(BALL_M).unwrap();
    let at =
        cranny_spatial::Pose::from_parts(point_in_link.coords.into(), cranny_spatial::Rotation::identity());
    let separation = cranny_shape::separation(&shape.solid, &shape.link_from_shape, &ball, &at, 1.0);
    separation.lower_m.max(0.0)
}

#[test]
fn a_path_that_does_not_fit_is_refused() {
    let scenario = scenario("021");
    let short = SampledPath::of(&scenario.robot, &[vec![0.0; 3]], None, 10.0);
    assert!(matches!(short, Err(ViewError::Waypoint { waypoint: 0, expected: 9, actual: 3 })));
    assert_eq!(SampledPath::of(&scenario.robot, &[], None, 10.0).unwrap(), None);
    let waypoints = moved(&scenario);
    let trajectory = trajectory(&scenario, &waypoints);
    for rate_hz in [0.0, -1.0, f64::NAN, 1e9] {
        let refused = SampledPath::of(&scenario.robot, &waypoints, trajectory.as_ref(), rate_hz);
        assert!(matches!(refused, Err(ViewError::Path(_))), "{rate_hz}");
    }
}

/// Regression test: the length of such a path was shown as a duration in seconds.
#[test]
fn a_path_without_limits_of_acceleration_has_no_time() {
    let mut scenario = scenario("021");
    let timed = shown(&scenario, &moved(&scenario), 30.0);
    assert!(timed.is_timed);
    let robot = Robot::from_urdf_text(SLIDE, "slide.urdf", None, &RobotOptions::default());
    scenario.robot = std::sync::Arc::new(robot.unwrap());
    let there = SampledPath::of(&scenario.robot, &[vec![0.0], vec![0.5], vec![-0.25]], None, 30.0);
    let there = there.unwrap().unwrap();
    assert!(!there.is_timed);
    assert_eq!(there.times_s.last(), Some(&1.25), "a length of 1 a second");
}

#[test]
fn a_path_of_hours_has_no_more_instants_than_can_be_held() {
    let scenario = scenario("021");
    let [near, far] = [moved(&scenario)[0].clone(), moved(&scenario)[1].clone()];
    let there_and_back: Vec<_> =
        (0..4000).map(|i| if i % 2 == 0 { near.clone() } else { far.clone() }).collect();
    let path = shown(&scenario, &there_and_back, 10_000.0);
    assert!(path.times_s.last().is_some_and(|&last_s| last_s > 100.0), "{:?}", path.times_s.last());
    assert!(path.times_s.len() < 100_010, "{}", path.times_s.len());
}

#[test]
fn a_robot_that_is_drawn_with_a_missing_mesh_says_which() {
    let mut scenario = scenario("021");
    let urdf = r#"<robot name="r">
      <link name="base"><visual><geometry><mesh filename="gone.dae"/></geometry></visual></link>
      <link name="cart"/>
      <joint name="drive" type="prismatic">
        <parent link="base"/><child link="cart"/><limit lower="-1" upper="1" velocity="1"/>
      </joint>
    </robot>"#;
    let robot = Robot::from_urdf_text(urdf, "r.urdf", Some(Path::new("/r")), &RobotOptions::default());
    scenario.robot = std::sync::Arc::new(robot.unwrap());
    scenario.start = vec![0.0];
    let refused = Scene::of_task(&scenario, None, &SceneSettings::default()).unwrap_err().to_string();
    for word in ["base", "gone.dae", "/r/gone.dae"] {
        assert!(refused.contains(word), "{refused}");
    }
}

#[test]
fn a_glb_holds_the_scene() {
    let scenario = scenario("021");
    let path = shown(&scenario, &moved(&scenario), 30.0);
    let scene = Scene::of_task(&scenario, Some(&path), &SceneSettings::default()).unwrap();
    let bytes = scene.glb().unwrap();
    assert!(bytes.len() < 1_000_000, "{} bytes", bytes.len());
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((&bytes[..4], word(4), word(8)), (&b"glTF"[..], 2, bytes.len()));
    let json: serde_json::Value = serde_json::from_slice(&bytes[20..20 + word(12)]).unwrap();
    let binary = word(20 + word(12));
    assert_eq!(json["buffers"][0]["byteLength"], binary);
    // The planning frame and the floor are additional nodes.
    assert_eq!(json["nodes"].as_array().unwrap().len(), scene.nodes.len() + 2);
    assert_eq!(json["animations"][0]["channels"].as_array().unwrap().len(), 9);
    for view in json["bufferViews"].as_array().unwrap() {
        let end = view["byteOffset"].as_u64().unwrap_or(0) + view["byteLength"].as_u64().unwrap();
        assert!(end <= binary as u64 && view["byteOffset"].as_u64().unwrap_or(0) % 4 == 0);
    }
    assert!(bytes == scene.glb().unwrap(), "the same bytes again");
}

#[test]
fn the_released_robot_is_shown_with_its_own_meshes() {
    let Some(data) = std::env::var_os("CRANNY_DATA") else {
        eprintln!("SKIPPED: the released robot needs the data folder in CRANNY_DATA");
        return;
    };
    let folder = Path::new(&data).join("jogramop/scenarios/011");
    let scenario = Scenario::open(&folder.to_string_lossy(), &OpenOptions::default()).unwrap();
    let scene = Scene::of_task(&scenario, None, &SceneSettings::default()).unwrap();
    assert!(scene.triangle_count() > 80_000, "{}", scene.triangle_count());
    let robot = scene.materials.iter().filter(|material| material.name.starts_with("robot"));
    assert!(robot.count() >= 4, "white, grey, and the marks of the flange");
}
