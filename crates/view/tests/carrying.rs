//! Tests of scenes, pages and pictures of plans that carry their object away.

use std::sync::{Arc, OnceLock};

use cranny_collision::Margins;
use cranny_path::AuditSettings;
use cranny_plan::Unobserved;
use cranny_record::{PlanFile, PlanSource};
use cranny_robot::Hold;
use cranny_scenario::{OpenOptions, Scenario};
use cranny_solve::{CLOSING_S, Request, TaskTrajectory, Timing, solve};
use cranny_spatial::Pose;
use cranny_task::{Mode, Problem, Stage, State};
use cranny_view::{
    CarriedObjectMotion, ClearanceProfile, PageCells, PageData, PagePlan, PageServer, PageSettings, Picture,
    PictureSettings, Role, SampledPath, Scene, SceneSettings, ServerLimits, StandardView, ViewError,
};
use serde_json::Value;

struct Carried {
    scenario: Scenario,
    problem: Problem,
    plan: PlanFile,
    timed: TaskTrajectory,
}

fn carried() -> &'static Carried {
    static CARRIED: OnceLock<Carried> = OnceLock::new();
    CARRIED.get_or_init(|| {
        let scenario = Scenario::open("031", &OpenOptions::default()).unwrap();
        let problem = scenario.problem(Margins::default()).unwrap();
        let stages = vec![Stage::pick(), Stage::home()];
        let request = Request { stages, timing: Some(Timing::default()), ..Request::default() };
        let answer = solve(&problem, &request, &mut Unobserved).unwrap();
        assert!(answer.is_solved());
        let plan = PlanFile::of(&answer, &PlanSource { scenario: "031".to_owned(), ..PlanSource::default() });
        let timed = plan.trajectory(&scenario.robot).unwrap().unwrap();
        Carried { scenario, problem, plan, timed }
    })
}

impl Carried {
    fn path(&self, rate_hz: f64) -> SampledPath {
        let path = SampledPath::of_plan(&self.scenario.robot, &self.plan, Some(&self.timed), rate_hz);
        path.unwrap().unwrap()
    }

    fn scene(&self, path: &SampledPath) -> Scene {
        Scene::of_task(&self.scenario, Some(path), &SceneSettings { grasps: 0 }).unwrap()
    }

    fn hold(&self) -> Hold {
        self.states()[1].held().expect("a hand that closes").1.hold
    }

    fn states(&self) -> Vec<State> {
        self.plan.states(&self.problem).unwrap().expect("the default criterion is exact").states
    }

    fn page_plan(&self) -> PagePlan {
        let verification = self.plan.audit(&self.problem, AuditSettings::default()).unwrap();
        let states = self.states();
        let robot = &self.scenario.robot;
        PagePlan::of_file("p", &self.plan, robot, Some(&self.timed), verification, states).unwrap()
    }

    fn page(&self, plan: PagePlan) -> Value {
        let cell = self.problem.cell().unwrap();
        let page = PageData::of(&self.scenario, &[plan], cell, &[], PageSettings::default()).unwrap();
        serde_json::from_slice(&page.to_json().unwrap()).unwrap()
    }
}

fn is_near(a: &Pose, b: &Pose) -> bool {
    let difference = a.inv_mul(b);
    difference.translation.vector.norm() < 1e-9 && difference.rotation.imag().norm() < 1e-9
}

fn carry_of(path: &SampledPath) -> &CarriedObjectMotion {
    path.carries.first().expect("something is carried")
}

#[test]
fn the_object_stands_until_the_hand_has_closed_and_then_stays_in_it() {
    let carried = carried();
    let (path, hold) = (carried.path(30.0), carried.hold());
    let scene = carried.scene(&path);
    let robot = carried.scenario.robot.holding("box");
    let mut frames = robot.frames();
    let targets: Vec<usize> =
        (0..scene.nodes.len()).filter(|&node| scene.nodes[node].role == Role::Target).collect();
    let goes_on_s = carry_of(&path).modes[1].from_s;
    for (frame, (q, &time_s)) in path.configurations.iter().zip(&path.times_s).enumerate() {
        let closing = carry_of(&path).closing_at(time_s);
        robot.place_held(&Hold { closing, ..hold }, &mut frames);
        robot.forward_kinematics(q, &mut frames);
        let world_from_nodes = scene.world_from_nodes(Some(frame));
        let (first, standing) = (&world_from_nodes[targets[0]], scene.nodes[targets[0]].parent_from_node);
        if time_s < goes_on_s {
            assert_eq!(*first, standing, "at {time_s} s");
        } else {
            assert!(is_near(first, &(frames.link(robot.tip()) * hold.tip_from_held)), "at {time_s} s");
        }
        // All components of the object move alike, and every link with its fingers is at its forward kinematics.
        for &node in &targets {
            let parts = standing.inv_mul(&scene.nodes[node].parent_from_node);
            assert!(is_near(&world_from_nodes[node], &(first * parts)));
        }
        let links = carried.scenario.robot.links().len();
        for (link, world_from_link) in world_from_nodes[..links].iter().enumerate() {
            assert!(is_near(world_from_link, frames.link(link)), "link {link} at {time_s} s");
        }
    }
    let closing = carry_of(&path).closing_at(path.ends_s());
    assert!((closing - hold.closing).abs() < 1e-12 && closing > 0.1, "{closing}");
    let end = scene.world_from_nodes(scene.last_frame())[targets[0]];
    assert!(
        (end.translation.vector - scene.nodes[targets[0]].parent_from_node.translation.vector).norm() > 0.1
    );
}

#[test]
fn modes_follow_each_other_and_the_hand_closes_between_the_first_two() {
    let carried = carried();
    for timed in [Some(&carried.timed), None] {
        let path =
            SampledPath::of_plan(&carried.scenario.robot, &carried.plan, timed, 20.0).unwrap().unwrap();
        let [reach, lift_off, carry] = carry_of(&path).modes[..] else { panic!("three modes") };
        assert_eq!([reach.mode, lift_off.mode, carry.mode], [Mode::REACH, Mode::LIFT_OFF, Mode::CARRY]);
        assert_eq!((reach.from_s, carry.until_s), (0.0, path.ends_s()));
        assert!((lift_off.from_s - reach.until_s - CLOSING_S).abs() < 1e-12);
        assert!(lift_off.until_s > lift_off.from_s && lift_off.until_s.to_bits() == carry.from_s.to_bits());
        assert!(path.times_s.windows(2).all(|pair| pair[0] < pair[1]));
        assert_eq!(path.times_s.len(), path.configurations.len());
        assert_eq!(path.waypoint_times_s.len(), carried.plan.waypoints.len());
        assert_eq!((path.is_timed, path.grasp), (timed.is_some(), carried.plan.grasp));
        // At the time of a way point, the robot is at that way point.
        let to_grasp = carried.plan.segments[0].waypoints.len() - 1;
        assert_eq!(path.waypoint_times_s[to_grasp].to_bits(), reach.until_s.to_bits());
        assert_eq!(carry_of(&path).grasp, carried.plan.waypoints[to_grasp]);
        assert_eq!(path.configurations.last(), carried.plan.waypoints.last());
    }
}

#[test]
fn the_way_of_the_gripper_is_marked_and_object_and_fingers_move_in_gltf() {
    let carried = carried();
    let scene = carried.scene(&carried.path(30.0));
    let ways = scene.nodes.iter().filter(|node| node.role == Role::GripperPath);
    let names: Vec<&str> = ways.map(|node| &node.name[..]).collect();
    assert_eq!(names, ["gripper path, reach", "gripper path, lift-off", "gripper path, carry"]);
    let bytes = scene.glb().unwrap();
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let json: Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    let channels = json["animations"][0]["channels"].as_array().unwrap();
    let moves = |node: usize| channels.iter().any(|channel| channel["target"]["node"] == node + 1);
    let hand = carried.scenario.robot.hand().unwrap();
    assert!(hand.joints.iter().all(|joint| moves(joint.link)));
    let target = scene.nodes.iter().position(|node| node.role == Role::Target).unwrap();
    assert!(moves(target) && !moves(target + 1));
}

#[test]
fn poses_on_the_way_out_have_the_object_too() {
    let carried = carried();
    let scene = carried.scene(&carried.path(10.0));
    let mut without = scene.clone();
    let target = scene.nodes.iter().position(|node| node.role == Role::Target).unwrap();
    // This scene is equal except that the object moves only at the last instant.
    let motion = without.motion.as_mut().unwrap();
    let last = motion.times_s.len() - 1;
    let track = motion.tracks.iter_mut().find(|track| track.node == target).unwrap();
    track.poses[..last].fill(scene.nodes[target].parent_from_node);
    let settings = PictureSettings { width: 320, height: 240, ..PictureSettings::default() };
    let draw = |scene: &Scene, ghosts| {
        let settings = PictureSettings { ghosts, ..settings.clone() };
        Picture::of(scene, StandardView::Side, &settings).unwrap()
    };
    assert!(draw(&scene, 3) != draw(&without, 3));
    assert!(draw(&scene, 0) == draw(&without, 0));
}

#[test]
fn a_page_is_told_what_becomes_of_the_object_and_measures_all_of_the_way() {
    let carried = carried();
    let page = carried.page(carried.page_plan());
    let plan = &page["plans"][0];
    let modes = plan["carries"][0]["modes"].as_array().unwrap();
    let names: Vec<&str> = modes.iter().map(|mode| mode["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["reach", "lift-off", "carry"]);
    assert_eq!(plan["carries"][0]["object"], "box");
    let strokes =
        page["robot"]["joints"].as_array().unwrap().iter().filter(|joint| joint["stroke"].is_f64()).count();
    assert_eq!(strokes, 2);
    let pairs = plan["clearance"]["pairs"].as_array().unwrap();
    assert!(pairs.iter().any(|pair| pair["first"] == "box"), "{pairs:?}");
    // Where the hold is unknown, the profile ends.
    let (path, cell) = (carried.path(60.0), carried.problem.cell().unwrap());
    let profile = |states: &[State]| ClearanceProfile::along(&path, cell, states, 240).unwrap();
    let (whole, reach) = (profile(&carried.states()), profile(&[]));
    assert_eq!(whole.times_s.last(), Some(&path.ends_s()));
    assert_eq!(reach.times_s.last(), Some(&carry_of(&path).modes[0].until_s));
    assert!(whole.times_s.windows(2).all(|pair| pair[0] < pair[1]));
    assert!(whole.closest.iter().all(|closest| closest.distance_m > 0.0), "a proven plan");
    let bare = PagePlan::of_waypoints("w", &carried.plan.waypoints, &carried.scenario.robot, None, None);
    assert!(carried.page(bare.unwrap())["plans"][0]["carries"].as_array().unwrap().is_empty());
}

/// A held object collides where the empty hand is free.
#[test]
fn postures_with_the_object_in_the_hand_are_judged_with_it() {
    let carried = carried();
    let plan = carried.page_plan();
    let grasp = carried.plan.segments[1].waypoints[0].clone();
    let cell = carried.problem.cell().unwrap().clone();
    let page = PageData::of(&carried.scenario, &[], &cell, &[], PageSettings::default()).unwrap();
    let server = PageServer::bind(0, ServerLimits::default()).unwrap();
    let url = server.url();
    let cells = PageCells::of(cell, std::slice::from_ref(&plan));
    let (stop, told) = tokio::sync::oneshot::channel::<()>();
    let (tell, ready) = std::sync::mpsc::channel();
    let serving = std::thread::spawn(move || {
        let stop = async {
            let _ = told.await;
        };
        server.serve(&page, Some(cells), stop, || tell.send(()).unwrap())
    });
    ready.recv().unwrap();
    let ask = |during: Value| ask(&url, &serde_json::json!({"q": grasp, "during": during}));
    assert_eq!(ask(Value::Null)["is_free"], true);
    assert_eq!(ask(serde_json::json!({"plan": 0, "segment": 1}))["is_free"], true);
    let resting = ask(serde_json::json!({"plan": 0, "segment": 2}));
    assert_eq!((&resting["is_free"], &resting["contacts"][0]["first"]), (&false.into(), &"box".into()));
    assert_eq!(ask(serde_json::json!({"plan": 0, "segment": 0}))["is_free"], true);
    for (plan, segment) in [(0, 3), (1, 0)] {
        let refused = ask(serde_json::json!({"plan": plan, "segment": segment}));
        assert!(refused["error"].as_str().is_some_and(|said| said.contains("no segment")), "{refused}");
    }
    stop.send(()).unwrap();
    let ended: Result<(), ViewError> = serving.join().unwrap();
    ended.unwrap();
}

/// Sends a question to the server at `url` and returns its answer.
fn ask(url: &str, question: &Value) -> Value {
    use std::io::{Read as _, Write as _};
    let (host, token) = url.strip_prefix("http://").and_then(|rest| rest.split_once('/')).unwrap();
    let body = question.to_string();
    let mut stream = std::net::TcpStream::connect(host).unwrap();
    let head = format!(
        "POST /{token}verdict HTTP/1.1\r\nHost: {host}\r\nContent-Length: {}\r\nConnection: close\r\n\r\n",
        body.len()
    );
    stream.write_all((head + &body).as_bytes()).unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    serde_json::from_str(answer.split_once("\r\n\r\n").unwrap().1).unwrap()
}

/// Without a known hand, the finger opening in a plan is ignored.
#[test]
fn a_robot_whose_hand_is_not_known_carries_with_fingers_as_they_are() {
    let carried = carried();
    let urdf = cranny_test_robots::SLIDE;
    let robot =
        cranny_robot::Robot::from_urdf_text(urdf, "slide.urdf", None, &cranny_robot::RobotOptions::default());
    let scenario = Scenario { robot: Arc::new(robot.unwrap()), start: vec![0.0], ..carried.scenario.clone() };
    let mut plan = carried.plan.clone();
    for (segment, ways) in plan.segments.iter_mut().zip([[0.0, 0.5], [0.5, 0.4], [0.4, 0.0]]) {
        segment.waypoints = ways.map(|q| vec![q]).to_vec();
    }
    let path = SampledPath::of_plan(&scenario.robot, &plan, None, 10.0).unwrap().unwrap();
    assert_eq!(carry_of(&path).closing.to_bits(), 0.0_f64.to_bits());
    let scene = Scene::of_task(&scenario, Some(&path), &SceneSettings { grasps: 0 }).unwrap();
    let target = scene.nodes.iter().position(|node| node.role == Role::Target).unwrap();
    let moved = scene.world_from_nodes(scene.last_frame())[target].translation.vector
        - scene.nodes[target].parent_from_node.translation.vector;
    assert!((moved.norm() - 0.5).abs() < 1e-12, "{moved}");
}
