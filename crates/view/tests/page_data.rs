//! Tests that page data reproduces the task number for number.

use std::sync::Arc;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use cranny_collision::{Body, Cell, Margins, World};
use cranny_path::audit;
use cranny_plan::{Observer, Outcome};
use cranny_robot::{Robot, RobotOptions};
use cranny_scenario::{OpenOptions, Scenario};
use cranny_shape::Solid;
use cranny_solve::{Timing, ik_statuses};
use cranny_spatial::nalgebra::{Quaternion, Translation3, Unit};
use cranny_spatial::{Pose, Rotation, Vector};
use cranny_task::{FailureReason, GraspFailure, Problem};
use cranny_view::{PageData, PagePlan, PageSettings, TreeRecording};
use proptest::prelude::*;
use serde_json::Value;

fn scenario(id: &str) -> Scenario {
    Scenario::open(id, &OpenOptions::default()).expect("a built-in scenario")
}

fn problem(scenario: &Scenario) -> Problem {
    scenario.problem(Margins::default()).expect("a problem")
}

fn cell(problem: &Problem) -> &Cell {
    problem.cell().expect("an exact problem")
}

/// Creates a timed and audited plan of way points.
fn plan(name: &str, waypoints: &[Vec<f64>], scenario: &Scenario) -> PagePlan {
    let problem = problem(scenario);
    let has_path = !waypoints.is_empty();
    let trajectory =
        has_path.then(|| Timing::default().along(&scenario.robot, waypoints).expect("a path")).flatten();
    let verification = has_path.then(|| audit(&problem, waypoints).expect("a path"));
    PagePlan::of_waypoints(name, waypoints, &scenario.robot, trajectory.as_ref(), verification)
        .expect("a plan")
}

fn page(scenario: &Scenario, plans: &[PagePlan]) -> Value {
    let problem = problem(scenario);
    let statuses = ik_statuses(&problem, &scenario.ik).expect("grasps");
    let cell = cell(&problem);
    let page = PageData::of(scenario, plans, cell, &statuses, PageSettings::default()).expect("a page");
    serde_json::from_slice(&page.to_json().expect("finite numbers")).expect("JSON")
}

fn bytes(row: &Value) -> Vec<u8> {
    STANDARD.decode(row.as_str().expect("a row")).expect("base64")
}

fn floats64(row: &Value) -> Vec<f64> {
    bytes(row).chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().expect("8 bytes"))).collect()
}

fn floats32(row: &Value) -> Vec<f32> {
    bytes(row).chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().expect("4 bytes"))).collect()
}

fn unsigned32(row: &Value) -> Vec<u32> {
    bytes(row).chunks_exact(4).map(|b| u32::from_le_bytes(b.try_into().expect("4 bytes"))).collect()
}

fn list(value: &Value) -> &Vec<Value> {
    value.as_array().expect("a list")
}

fn numbers(value: &Value) -> Vec<f64> {
    list(value).iter().map(|x| x.as_f64().expect("a number")).collect()
}

fn index(value: &Value) -> usize {
    usize::try_from(value.as_u64().expect("an index")).expect("small")
}

fn pose(value: &Value) -> Pose {
    let [x, y, z, qx, qy, qz, qw] = numbers(value)[..] else { panic!("a pose has seven numbers") };
    Pose::from_parts(Translation3::new(x, y, z), Rotation::from_quaternion(Quaternion::new(qw, qx, qy, qz)))
}

/// Forward kinematics from the document alone, as in the page.
fn link_poses(robot: &Value, q: &[f64]) -> Vec<Pose> {
    let links = list(&robot["links"]);
    let mut world_from_link = vec![Pose::identity(); links.len()];
    for joint in list(&robot["joints"]) {
        let child = index(&joint["child"]);
        let parent = index(&links[child]["parent"]);
        let variable = joint["variable"].as_u64().map_or(0.0, |_| q[index(&joint["variable"])]);
        let value = joint["offset"].as_f64().expect("an offset")
            + joint["factor"].as_f64().expect("a factor") * variable;
        let axis = Vector::from_vec(numbers(&joint["axis"]));
        let motion = match joint["kind"].as_str().expect("a kind") {
            "revolute" => Pose::from_parts(
                Translation3::identity(),
                Rotation::from_axis_angle(&Unit::new_normalize(axis), value),
            ),
            "prismatic" => Pose::from_parts((axis * value).into(), Rotation::identity()),
            _ => Pose::identity(),
        };
        world_from_link[child] = world_from_link[parent] * pose(&joint["parent_from_child"]) * motion;
    }
    world_from_link
}

fn agrees_with_forward_kinematics(robot: &Robot, document: &Value, shares: &[f64]) {
    let q: Vec<f64> = robot
        .limits()
        .iter()
        .zip(shares)
        .map(|(limits, share)| limits.lower + (limits.upper - limits.lower) * share)
        .collect();
    let frames = robot.frames_at(&q);
    for (link, pose) in link_poses(document, &q).iter().enumerate() {
        let difference = frames.link(link).inv_mul(pose);
        assert!(difference.translation.vector.norm() < 1e-9, "{}: {difference}", robot.links()[link].name);
        assert!(difference.rotation.imag().norm() < 1e-9, "{}: {difference}", robot.links()[link].name);
    }
}

/// Robot with a mimic joint with factor and offset, a tilted prismatic joint, and a joint below a fixed one.
const CRANE: &str = r#"<robot name="crane">
  <link name="ground"/><link name="mast"/><link name="arm"/><link name="mirror"/><link name="plate"/><link name="tip"/>
  <joint name="turn" type="revolute"><parent link="ground"/><child link="mast"/><origin xyz="0.1 0.2 0.3" rpy="0.1 0.2 0.3"/>
    <axis xyz="0 0.6 0.8"/><limit lower="-2" upper="1" velocity="1" effort="1"/></joint>
  <joint name="slide" type="prismatic"><parent link="mast"/><child link="arm"/><origin xyz="0 0 1" rpy="0 0.5 0"/>
    <axis xyz="0.6 0 0.8"/><limit lower="-0.5" upper="0.7" velocity="1" effort="1"/></joint>
  <joint name="shadow" type="revolute"><parent link="arm"/><child link="mirror"/><origin xyz="0.3 0 0" rpy="1 0 0"/>
    <axis xyz="0 1 0"/><limit lower="-9" upper="9" velocity="1" effort="1"/><mimic joint="turn" multiplier="-1.5" offset="0.4"/></joint>
  <joint name="bolt" type="fixed"><parent link="mirror"/><child link="plate"/><origin xyz="0 0.1 0" rpy="0 0 2"/></joint>
  <joint name="wrist" type="revolute"><parent link="plate"/><child link="tip"/><origin xyz="0 0 0.2" rpy="0 0 0"/>
    <axis xyz="1 0 0"/><limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
</robot>"#;

fn crane() -> Scenario {
    let robot = Robot::from_urdf_text(CRANE, "crane.urdf", None, &RobotOptions::default()).expect("a robot");
    let start = vec![0.0; robot.dof()];
    Scenario { robot: Arc::new(robot), start, ik: Vec::new(), ..scenario("021") }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn the_joints_of_the_document_give_the_poses_of_the_robot(shares in prop::collection::vec(0.0..1.0_f64, 9)) {
        thread_local! {
            static TASKS: Vec<(Scenario, Value)> =
                [scenario("021"), crane()].into_iter().map(|task| { let page = page(&task, &[]); (task, page) }).collect();
        }
        TASKS.with(|tasks| for (task, page) in tasks {
            agrees_with_forward_kinematics(&task.robot, &page["robot"], &shares);
        });
    }
}

#[test]
fn nodes_begin_with_the_links_and_shapes_and_meshes_are_whole() {
    let scenario = scenario("011");
    let page = page(&scenario, &[]);
    assert_eq!((&page["format"], &page["name"]), (&"cranny-page/1".into(), &"011".into()));
    assert_eq!(page["is_live"], false);
    assert_eq!(index(&page["robot"]["tip"]), scenario.robot.tip());
    assert_eq!(numbers(&page["robot"]["start"]), scenario.start);
    let nodes = list(&page["nodes"]);
    for (node, link) in nodes.iter().zip(scenario.robot.links()) {
        assert_eq!((node["name"].as_str(), node["role"].as_str()), (Some(&link.name[..]), Some("link")));
        assert_eq!(node["parent"].as_u64(), link.parent.map(|parent| parent as u64));
    }
    let roles = |nodes: &[Value], role: &str| nodes.iter().filter(|node| node["role"] == role).count();
    assert_eq!(roles(nodes, "link"), scenario.robot.links().len());
    assert_eq!((roles(nodes, "obstacle"), roles(nodes, "target")), (6, 1));
    let shapes = list(&page["collision_shapes"]);
    let with_geometry = scenario.robot.links().iter().filter(|link| !link.collisions.is_empty()).count();
    assert_eq!(
        (roles(shapes, "link"), roles(shapes, "obstacle"), roles(shapes, "target")),
        (with_geometry, 6, 1)
    );
    let meshes = list(&page["meshes"]);
    for node in nodes.iter().chain(shapes) {
        assert!(
            node["mesh"].as_u64().is_none_or(|mesh| usize::try_from(mesh).is_ok_and(|m| m < meshes.len()))
        );
    }
    for piece in meshes.iter().flat_map(|mesh| list(&mesh["pieces"])) {
        let corners = floats32(&piece["positions"]).len();
        assert_eq!((corners % 3, floats32(&piece["normals"]).len()), (0, corners));
        let triangles = unsigned32(&piece["triangles"]);
        assert!(
            triangles.len().is_multiple_of(3)
                && triangles.iter().all(|&corner| (corner as usize) < corners / 3)
        );
        assert!(index(&piece["material"]) < list(&page["materials"]).len());
    }
}

#[test]
fn spheres_of_a_link_contain_its_collision_shape() {
    let scenario = scenario("021");
    let page = page(&scenario, &[]);
    let spheres = list(&page["link_spheres"]);
    assert_eq!(spheres.len(), scenario.robot.links().len());
    for (link, row) in scenario.robot.links().iter().zip(spheres) {
        let balls = floats32(row);
        assert_eq!(balls.len() % 4, 0);
        assert_eq!(balls.is_empty(), link.collisions.is_empty(), "{}", link.name);
        for shape in &link.collisions {
            let soup = shape.solid.tessellation().expect("a surface");
            for corner in &soup.vertices {
                let at = shape.link_from_shape * corner;
                let is_in = |ball: &[f32]| {
                    let [x, y, z, radius] = [0, 1, 2, 3].map(|i| f64::from(ball[i]));
                    (at.coords - Vector::new(x, y, z)).norm() <= radius + 1e-5
                };
                assert!(balls.chunks_exact(4).any(is_in), "{}: {at}", link.name);
            }
        }
    }
}

#[test]
fn all_grasps_are_there_with_what_is_certain_of_them() {
    let mut scenario = scenario("041");
    // A rod as long as the opening, at the location of one finger, certainly blocks all similar grasps.
    let mut bodies = scenario.world.bodies().to_vec();
    let rod = Solid::cuboid(Vector::new(0.004, 0.05, 0.004)).expect("a size");
    bodies.push(Body::new("rod", scenario.grasps.grasps()[7].world_from_gripper, rod));
    scenario.world = World::new(bodies).expect("a world");
    let page = page(&scenario, &[]);
    let problem = problem(&scenario);
    let cell = cell(&problem);
    let mut scratch = cell.scratch();
    assert_eq!(list(&page["grasps"]).len(), scenario.grasps.len());
    let mut blocked = 0;
    for (place, (shown, grasp)) in list(&page["grasps"]).iter().zip(scenario.grasps.grasps()).enumerate() {
        assert_eq!(index(&shown["index"]), place);
        let difference = pose(&shown["world_from_gripper"]).inv_mul(&grasp.world_from_gripper);
        assert!(difference.translation.vector.norm() < 1e-12 && difference.rotation.imag().norm() < 1e-12);
        assert_eq!((shown["score"].as_f64(), shown["width_m"].as_f64()), (grasp.score, grasp.width_m));
        let hand_is_free = [grasp.world_from_gripper, grasp.twin().world_from_gripper]
            .iter()
            .any(|pose| cell.hand_is_free(pose, &mut scratch));
        assert_eq!(shown["ik"] == "hand-collides", !hand_is_free, "grasp {place}");
        blocked += usize::from(!hand_is_free);
    }
    assert!(blocked > 0 && blocked < scenario.grasps.len(), "{blocked} blocked");
}

#[test]
fn the_base_may_go_where_its_limits_let_it() {
    let scenario = scenario("021");
    let area = &page(&scenario, &[])["floor_area"];
    let (low, high) = (numbers(&area["low"]), numbers(&area["high"]));
    assert!(low.iter().chain(&high).all(|x| (x.abs() - 1.0).abs() < 1e-9), "{area}");
    assert!(low.iter().zip(&high).all(|(low, high)| low < high));
    assert_eq!(page(&crane(), &[])["floor_area"], Value::Null);
}

/// Short free path near the start, whose profile has rows to check.
fn short_path(scenario: &Scenario) -> Vec<Vec<f64>> {
    let mut end = scenario.start.clone();
    end[8] += 0.3;
    vec![scenario.start.clone(), end]
}

#[test]
fn a_path_has_a_row_for_each_instant_and_its_clearance_is_that_of_the_cell() {
    let scenario = scenario("021");
    let waypoints = short_path(&scenario);
    let plan = plan("way.csv", &waypoints, &scenario);
    let page = page(&scenario, &[plan]);
    let plan = &page["plans"][0];
    let (times, rows) = (floats64(&plan["times_s"]), floats64(&plan["configurations"]));
    assert_eq!(rows.len(), times.len() * 9);
    assert_eq!(rows[..9], waypoints[0][..]);
    assert_eq!(rows[rows.len() - 9..], waypoints[1][..]);
    assert_eq!(floats64(&plan["waypoint_times_s"]).len(), 2);
    let clearance = &plan["clearance"];
    let (instants, distances) = (floats64(&clearance["times_s"]), floats64(&clearance["distances_m"]));
    let points = floats32(&clearance["points"]);
    assert_eq!((instants.first(), instants.last()), (times.first(), times.last()));
    assert_eq!((distances.len(), points.len()), (instants.len(), 6 * instants.len()));
    let closest = unsigned32(&clearance["closest"]);
    assert!(
        closest.len() == instants.len()
            && closest.iter().all(|&pair| (pair as usize) < list(&clearance["pairs"]).len())
    );
    let problem = problem(&scenario);
    let cell = cell(&problem);
    let mut scratch = cell.scratch();
    let (mut world_is_least, mut own_is_least) = (false, false);
    for (index, ((instant, distance), points)) in
        instants.iter().zip(&distances).zip(points.chunks_exact(6)).enumerate()
    {
        let place = times
            .iter()
            .position(|time| time.to_bits() == instant.to_bits())
            .expect("an instant of the path");
        let q = &rows[place * 9..(place + 1) * 9];
        assert!((cell.clearance(q, &mut scratch) - distance).abs() < 1e-9);
        let [world, own] = ["world_m", "own_m"].map(|key| floats64(&clearance[key])[index]);
        assert!((world.min(own) - distance).abs() < 1e-9);
        world_is_least |= world < own;
        own_is_least |= own < world;
        let apart = (0..3).map(|i| f64::from(points[i] - points[i + 3]).powi(2)).sum::<f64>().sqrt();
        assert!((apart - distance).abs() < 1e-4, "{apart} {distance}");
    }
    // The clearance between own links does not hide that to the world.
    assert!(world_is_least || own_is_least);
    assert_eq!((&plan["is_valid"], &plan["grasp"]), (&false.into(), &Value::Null));
    assert!(plan["verdict"].as_str().is_some_and(|line| line.contains("from the nearest grasp")), "{plan}");
}

#[test]
fn a_failed_plan_says_what_blocked_each_grasp() {
    let scenario = scenario("021");
    let collides = FailureReason::ArmCollides { link: "panda_link5".into(), body: "table".into() };
    let reasons = [FailureReason::NoIk, collides.clone(), collides, FailureReason::NotConnected { goals: 2 }];
    let failures = reasons
        .into_iter()
        .enumerate()
        .map(|(place, reason)| GraspFailure { grasp: 10 * place, reason, attempts: 7 })
        .collect();
    let plan = PagePlan {
        outcome: Some(Outcome::NoReachableGrasp),
        failures,
        ..plan("failed.plan.json", &[], &scenario)
    };
    let page = page(&scenario, &[plan]);
    let plan = &page["plans"][0];
    assert_eq!(
        (&plan["verdict"], &plan["clearance"]),
        (&"no path: no grasp can be reached".into(), &Value::Null)
    );
    assert_eq!(plan["outcome"], "no grasp can be reached", "codes are not for people");
    assert_eq!((&plan["times_s"], &plan["is_valid"]), (&"".into(), &false.into()));
    assert_eq!(list(&plan["blocked"]).len(), 4);
    assert_eq!(plan["blocked"][1]["grasp"], 10);
    let counts = list(&plan["blocked_counts"]);
    assert_eq!(counts[0]["count"], 2);
    assert!(counts[0]["reason"].as_str().is_some_and(|reason| reason.contains("panda_link5 touched table")));
    let status = |grasp: usize| page["grasps"][grasp]["ik"].as_str().expect("a status").to_owned();
    assert_eq!(status(30), "solved");
    assert!(["solved", "no-solution", "hand-collides"].contains(&&status(10)[..]));
}

#[test]
fn trees_are_recorded_node_by_node_and_no_more_than_asked_for() {
    let scenario = scenario("021");
    let mut recording = TreeRecording::new(scenario.robot.clone(), 5);
    let mut q = scenario.start.clone();
    recording.node_added(0, &q, None);
    recording.node_added(1, &q, None);
    recording.node_added(1, &q, None);
    q[0] += 0.5;
    recording.node_added(1, &q, Some(1));
    recording.node_added(0, &q, Some(0));
    recording.node_added(0, &q, Some(1));
    assert_eq!((recording.len(), recording.left_out()), (5, 1));
    let plan =
        PagePlan { search_tree: Some(recording), ..plan("way.csv", &short_path(&scenario), &scenario) };
    let page = page(&scenario, &[plan]);
    let tree = &page["plans"][0]["search_tree"];
    assert_eq!(unsigned32(&tree["parents"]), [0, 1, 2, 2, 0]);
    assert_eq!(unsigned32(&tree["trees"]), [0, 1, 1, 1, 0]);
    let positions = floats32(&tree["positions"]);
    let frames = scenario.robot.frames_at(&q);
    let tip = frames.link(scenario.robot.tip()).translation.vector;
    for (value, expected) in positions[9..12].iter().zip(tip.iter()) {
        assert!((f64::from(*value) - expected).abs() < 1e-6);
    }
}

#[test]
fn trees_of_one_goal_after_the_other_do_not_mix() {
    let scenario = scenario("021");
    let mut recording = TreeRecording::new(scenario.robot.clone(), 100);
    for _ in 0..2 {
        recording.node_added(0, &scenario.start, None);
        recording.node_added(1, &scenario.start, None);
        recording.node_added(0, &scenario.start, Some(0));
    }
    let plan = PagePlan { search_tree: Some(recording), ..plan("way.csv", &[], &scenario) };
    let page = page(&scenario, &[plan]);
    assert_eq!(unsigned32(&page["plans"][0]["search_tree"]["parents"]), [0, 1, 0, 3, 4, 3]);
}
