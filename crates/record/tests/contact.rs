//! Allowed contacts of an object during lift-off and set-down, in scenarios with another body beside it.

use cranny_collision::{Body, CollisionError, Margins};
use cranny_path::{AuditSettings, Violation};
use cranny_plan::{Outcome, Unobserved};
use cranny_record::{PlanFile, PlanSource};
use cranny_scenario::{OpenOptions, Scenario};
use cranny_shape::Solid;
use cranny_solve::{Answer, Request, solve};
use cranny_spatial::{Point, Pose, Vector};
use cranny_task::{
    CLEAR_M, Carrier, ContactSegment, LiftOffSettings, NotCheckedReason, PlaceAt, PlaceGoal, PlaceRegion,
    Placer, Problem, Stage, TaskError,
};

fn opened(id: &str) -> Scenario {
    Scenario::open(id, &OpenOptions::default()).unwrap()
}

fn problem(scenario: &Scenario, margin_m: f64) -> Problem {
    scenario.problem(Margins { margin_m, ..Margins::default() }).unwrap()
}

fn carry() -> Vec<Stage> {
    vec![Stage::pick(), Stage::home()]
}

fn asked(problem: &Problem, stages: Vec<Stage>) -> Answer {
    let request = Request {
        stages,
        robustness: true,
        seed: 1,
        budget: cranny_plan::Budget { iterations: 3000, ..cranny_plan::Budget::default() },
        ..Request::default()
    };
    solve(problem, &request, &mut Unobserved).unwrap()
}

/// Returns the corners of the bounding box of the target, along the axes of the planning frame.
fn target_box(scenario: &Scenario) -> [Point; 2] {
    let part = &scenario.world.bodies()[scenario.target.unwrap()].parts[0];
    let aabb = part.solid.aabb().transformed(&part.world_from_solid);
    [aabb.low(), aabb.high()]
}

fn block(name: &str, low: Point, high: Point) -> Body {
    let middle = 0.5 * (low.coords + high.coords);
    let solid = Solid::cuboid(0.5 * (high - low)).unwrap();
    Body::new(name, Pose::translation(middle.x, middle.y, middle.z), solid)
}

/// Opens 021 with a post at the distance `gap_m` (m) beside the ball, below the hand.
fn with_post(gap_m: f64) -> Scenario {
    let scenario = opened("021");
    let [low, high] = target_box(&scenario);
    let middle = 0.5 * (low.coords + high.coords);
    let near = Point::new(high.x + gap_m, middle.y - 0.005, low.z);
    let far = Point::new(high.x + gap_m + 0.01, middle.y + 0.005, middle.z + 0.002);
    scenario.with_body(block("post", near, far)).unwrap()
}

#[test]
fn a_post_beside_the_object_is_an_obstacle_of_its_lift_off() {
    let scenario = with_post(0.001);
    let free = problem(&scenario, 0.0);
    let answer = asked(&free, carry());
    assert!(answer.is_solved(), "{:?} {:?}", answer.outcome, answer.failures);
    let audit = answer.audit.as_ref().unwrap();
    let clearance_m = audit.clearance_m.unwrap();
    assert!(clearance_m <= 0.001 && clearance_m > 0.0005, "{clearance_m}");
    // The object has this clearance for slip in the hand, and no more.
    let slip_m = answer.robustness.unwrap().slip.unwrap().translation_m;
    assert!(slip_m <= 0.001, "{slip_m}");
    let object_margin = Margins { object_margin_m: 0.015, ..Margins::default() };
    let robust = scenario.problem(object_margin).unwrap();
    assert_ne!(asked(&robust, carry()).outcome, Outcome::Solved);
    // A greater margin does not hide the post.
    let answer = asked(&problem(&scenario, 0.004), carry());
    assert_ne!(answer.outcome, Outcome::Solved);
    let names_post = answer.failures.iter().any(|failure| failure.reason.sentence().contains("post"));
    assert!(names_post, "{:?}", answer.failures);
}

#[test]
fn the_contact_that_is_allowed_is_named_with_every_answer() {
    let scenario = opened("021");
    let problem = problem(&scenario, 0.0);
    let answer = asked(&problem, vec![Stage::pick(), Stage::place("outside")]);
    assert!(answer.is_solved());
    let audit = answer.audit.as_ref().unwrap();
    let contacts: Vec<_> =
        audit.not_checked.iter().filter_map(|pair| pair.contact.map(|at| (pair, at))).collect();
    let [(off, lift_off), (down, set_down)] = contacts[..] else { panic!("{:?}", audit.not_checked) };
    assert_eq!([lift_off.segment, set_down.segment], [ContactSegment::LiftOff, ContactSegment::SetDown]);
    for pair in [off, down] {
        assert_eq!((&*pair.first, pair.reason), ("ball", NotCheckedReason::Resting));
        assert!(pair.depth_m <= 1e-4);
    }
    let mut plan = PlanFile::of(&answer, &PlanSource { scenario: "021".to_owned(), ..PlanSource::default() });
    let text = serde_json::to_string(&plan).unwrap();
    assert!(text.contains(r#""reason":"resting","segment":"set-down","allowance_m":0.0001"#), "{text}");
    // The audit names the contacts, regardless of the statements of the file.
    plan.not_checked.clear();
    let judged = plan.audit(&problem, AuditSettings::default()).unwrap().unwrap();
    assert_eq!(judged.not_checked, audit.not_checked);
}

#[test]
fn what_does_not_carry_the_object_is_not_touched_at_the_start() {
    let sunk = opened("021").with_target_moved(&Pose::translation(0.0, 0.0, -8e-4)).unwrap();
    for (scenario, other, depth_m) in [(with_post(-2e-4), "post", 2e-4), (sunk, "floor", 8e-4)] {
        match Carrier::new(&problem(&scenario, 0.0), LiftOffSettings::default()) {
            Err(TaskError::Collision(CollisionError::Touches { other: met, depth_m: deep, .. })) => {
                assert_eq!(met, other);
                assert!((deep - depth_m).abs() < 0.75 * depth_m, "{deep}");
            }
            other => panic!("{:?}", other.map(|_| ())),
        }
    }
}

/// Returns the placer of the target at a goal.
fn placer(problem: &Problem, carrier: &Carrier, goal: PlaceGoal) -> Result<Placer, TaskError> {
    let place = PlaceAt { clear_m: CLEAR_M, ..PlaceAt::named(&goal.name) };
    Placer::new(&problem.clone().with_places(&[goal]), carrier, &place)
}

/// Returns the fault of putting the target down at its present pose moved by `motion`, if any.
fn fault(scenario: &Scenario, motion: &Pose) -> Option<String> {
    let problem = problem(scenario, 0.0);
    let carrier = Carrier::new(&problem, LiftOffSettings::default()).unwrap();
    let now = scenario.world.bodies()[scenario.target.unwrap()].parts[0].world_from_solid;
    let goal = PlaceGoal { name: "there".to_owned(), spot: PlaceRegion::Target(motion * now) };
    placer(&problem, &carrier, goal).unwrap().fault_at(&(motion * now))
}

#[test]
fn an_object_is_put_down_on_level_faces_below_it() {
    let scenario = opened("031");
    let [low, high] = target_box(&scenario);
    let size = high - low;
    let aside = |z: f64| Pose::translation(-0.1, -0.15, z);
    let there = [low, high].map(|corner| corner + Vector::new(-0.1, -0.15, 0.0));
    assert_eq!(fault(&scenario, &aside(0.0)), None);
    assert_eq!(fault(&scenario, &aside(-5e-5)), None);
    assert!(fault(&scenario, &aside(-8e-4)).unwrap().contains("0.80 mm deep in floor"));
    assert!(fault(&scenario, &aside(0.0015)).unwrap().contains("1.50 mm above floor"));
    // Beside a post and above the floor.
    let post = block(
        "post",
        Point::new(there[1].x + 0.0015, there[0].y, 0.0),
        Point::new(there[1].x + 0.02, there[1].y, 1.5),
    );
    let beside = scenario.with_body(post).unwrap();
    assert_eq!(fault(&beside, &aside(0.0)), None);
    assert!(fault(&beside, &aside(0.88)).unwrap().contains("nothing"));
    // Over an edge, and on one.
    let shelf = |from_x: f64| {
        let low = Point::new(there[0].x + from_x * size.x, there[0].y - 0.1, there[0].z + 0.1);
        block("board", low, Point::new(there[1].x + 0.1, there[1].y + 0.1, low.z + 0.1))
    };
    let on_board = scenario.with_body(shelf(0.4)).unwrap();
    assert_eq!(fault(&on_board, &aside(0.2)), None);
    let off_board = scenario.with_body(shelf(0.6)).unwrap();
    assert!(fault(&off_board, &aside(0.2)).unwrap().contains("centre of mass"));
    let middle = there[0] + 0.5 * size;
    let about = Pose::translation(middle.x, middle.y, middle.z)
        * Pose::rotation(Vector::y() * size.x.atan2(size.z))
        * Pose::translation(-middle.x, -middle.y, -middle.z);
    let diagonal_m = 0.5 * (size.x.hypot(size.z) - size.z);
    let on_edge = Pose::translation(0.0, 0.0, diagonal_m) * about * aside(0.0);
    assert!(fault(&scenario, &on_edge).unwrap().contains("from any resting pose"));
}

#[test]
fn a_slope_is_no_place_for_a_robot_that_is_tilted_as_it_is() {
    let scenario = opened("031");
    // In the frame of a root that leans by 20°, a face that is level for the root is a slope.
    let up = Pose::rotation(Vector::x() * 0.35).rotation * Vector::z();
    let world = scenario.world.clone().with_up(&up);
    let tilted = Scenario { world, ..scenario };
    let fault = fault(&tilted, &Pose::translation(-0.1, -0.15, 0.0));
    assert!(fault.as_ref().is_some_and(|fault| fault.contains("slope of 20.05°")), "{fault:?}");
    let problem = problem(&tilted, 0.0);
    let carrier = Carrier::new(&problem, LiftOffSettings::default()).unwrap();
    let goal = problem.place("outside").unwrap().clone();
    assert!(placer(&problem, &carrier, goal).unwrap_err().to_string().contains("not level"));
}

#[test]
fn a_plan_that_drags_the_object_past_a_post_is_not_valid() {
    let scenario = opened("021");
    let answer = asked(&problem(&scenario, 0.0), carry());
    let plan = PlanFile::of(&answer, &PlanSource { scenario: "021".to_owned(), ..PlanSource::default() });
    let judged = |scenario: &Scenario, margin_m: f64| {
        plan.audit(&problem(scenario, margin_m), AuditSettings::default()).unwrap().unwrap()
    };
    assert!(judged(&with_post(0.001), 0.0).clearance_m.unwrap() <= 0.001);
    let near = judged(&with_post(0.001), 0.002);
    let is_post = |violation: &Violation| violation.to_string().contains("post");
    assert!(near.violations.iter().any(is_post), "{:?}", near.violations);
}

#[test]
fn a_rectangle_is_level_in_the_scene_however_the_robot_stands() {
    let folder = tempfile::tempdir().unwrap();
    let places = |rpy_deg: &str| {
        let text = format!(
            "about: {{title: tilted}}\nrobot: panda_mobile\nframe: {{position: [0, 0, 0.05], rotation_rpy_deg: [0, 4, 0]}}\n\
             start: [0, 0, -0.0178, -0.7601, 0.0198, -2.3421, 0.0298, 1.5412, 0.7534]\nfloor: -0.5\nobstacles:\n\
             - {{name: board, pose: {{position: [0.9, 0, 0.6]}}, shapes: [{{box: {{size: [0.4, 0.8, 0.02]}}}}]}}\n\
             target: {{name: can, pose: {{position: [0.8, 0, 0.67]}}, shapes: [{{cylinder: {{radius: 0.03, length: 0.12}}}}]}}\n\
             places:\n- {{name: there, on: board, size: [0.3, 0.3], \
             pose: {{position: [0.9, 0.2, 0.61], rotation_rpy_deg: {rpy_deg}}}}}\n"
        );
        std::fs::write(folder.path().join("scenario.yaml"), text).unwrap();
        let grasp = "-1,0,0,0.8,0,1,0,0,0,0,-1,0.67,0,0,0,1\n";
        std::fs::write(folder.path().join("grasps.csv"), grasp).unwrap();
        Scenario::open(folder.path().to_str().unwrap(), &OpenOptions::default()).map(|scenario| {
            let problem = problem(&scenario, 0.0);
            let carrier = Carrier::new(&problem, LiftOffSettings::default()).unwrap();
            let goal = scenario.places[0].clone();
            placer(&problem, &carrier, goal).unwrap().with_placements(0).placements().count()
        })
    };
    assert!(places("[0, 0, 20]").unwrap() > 0);
    // A rectangle that is level for the robot is not level in the scene.
    assert!(places("[0, 4, 0]").unwrap_err().to_string().contains("not level"));
}
