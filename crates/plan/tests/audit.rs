//! Tests of the audit with paths that have known faults.

use cranny_collision::{Body, Margins, World};
use cranny_grasp::Grasp;
use cranny_path::{
    Audit, AuditSettings, Clearances, CurvedPath, MotionLimits, TimingMethod, Trajectory, Violation, audit,
    audit_task, path_length,
};
use cranny_robot::{JointLimits, JointUnit};
use cranny_shape::Solid;
use cranny_spatial::{CONTACT_M, Pose, Vector};
use cranny_task::{Goal, Problem, RoundedCorner, Segment, Stage};

use crate::fixture::{ball, block, exact, grasps, paper};

/// Radius of the ball, in metres.
const RADIUS_M: f64 = 0.05;

const FROM: [f64; 3] = [-0.5, 0.0, 0.0];
const TO: [f64; 3] = [0.5, 0.0, 0.0];

fn there() -> Goal {
    Goal::Configurations(vec![TO.to_vec()])
}

fn judged(bodies: Vec<Body>, path: &[[f64; 3]]) -> Audit {
    verify_path(&exact(&ball(), bodies, &FROM, there()), path)
}

fn verify_path(problem: &Problem, path: &[[f64; 3]]) -> Audit {
    let path: Vec<Vec<f64>> = path.iter().map(|q| q.to_vec()).collect();
    let verification = audit(problem, &path).expect("way points of the robot");
    assert_eq!(verification.valid, verification.violations.is_empty());
    verification
}

fn only(verification: &Audit) -> &Violation {
    assert_eq!(verification.violations.len(), 1, "{verification:?}");
    &verification.violations[0]
}

/// Returns the number under a key of a violation as JSON.
fn number(violation: &Violation, key: &str) -> f64 {
    serde_json::json!(violation)[key].as_f64().unwrap_or_else(|| panic!("no {key} in {violation:?}"))
}

fn word(violation: &Violation, key: &str) -> String {
    serde_json::json!(violation)[key]
        .as_str()
        .unwrap_or_else(|| panic!("no {key} in {violation:?}"))
        .to_owned()
}

fn kinds(verification: &Audit) -> Vec<&'static str> {
    verification.violations.iter().map(Violation::kind).collect()
}

/// Checks that the clearance is that of the curve which cuts a corner past a post, not that of the edges.
#[test]
fn the_clearance_of_a_path_with_rounded_corners_is_that_of_the_curve() {
    let corner = [[-0.98, 0.0, 0.0], [0.0; 3], [0.0, 0.98, 0.0]];
    let path = corner.map(|q| q.to_vec());
    let post = |at: f64| {
        let solid = Solid::sphere(0.05).expect("a positive radius");
        Body::new("post", Pose::translation(-at, at, 0.0), solid)
    };
    let goal = || Goal::Configurations(vec![path[2].clone()]);
    let problem = exact(&ball(), vec![post(0.36)], &corner[0], goal());
    let cell = problem.cell().expect("exact");
    let joint = JointLimits {
        lower: -1.0,
        upper: 1.0,
        velocity: 1.0,
        acceleration: Some(2.0),
        jerk: None,
        unit: JointUnit::Metre,
    };
    let limits = MotionLimits::new(cell.robot().joint_names(), &[joint; 3], TimingMethod::TimeOptimal);
    let limits = limits.expect("limits");
    let corners = CurvedPath::stopping(&path).rounded(&limits, |_, _| true);
    let curved = CurvedPath { corners: &corners, ..CurvedPath::stopping(&path) };
    let trajectory = Trajectory::along_curve(&curved, &limits).expect("a trajectory");
    let edges = verify_path(&problem, &corner);
    let judged = |problem: &Problem| {
        let segment = Segment { corners: corners.clone(), ..Segment::reach(path.to_vec(), Vec::new()) };
        let stages = Stage::of_goal(problem);
        audit_task(problem, &stages, &[segment], AuditSettings::default()).expect("a path")
    };
    let curve = judged(&problem);
    assert!(curve.valid, "{:?}", curve.violations);
    let [of_edges_m, of_curve_m] = [&edges, &curve].map(|audit| audit.clearance_m.expect("a post"));
    let mut scratch = cell.scratch();
    let samples = trajectory.samples(2000.0).expect("samples");
    let seen_m =
        samples.map(|sample| cell.clearance(&sample.position, &mut scratch)).fold(f64::INFINITY, f64::min);
    assert!(of_curve_m <= seen_m && of_curve_m > 0.98 * seen_m - 1e-4, "{of_curve_m} {seen_m}");
    assert!(of_curve_m < of_edges_m - 5e-3, "{of_curve_m} {of_edges_m}");
    assert_eq!(curve.clearances_per_edge_m, [Some(of_curve_m); 2]);
    // The first cell requires more clearance than the curve keeps, and in the second the curve collides.
    let margins = Margins { margin_m: 0.5 * (of_curve_m + of_edges_m), ..Margins::default() };
    let world = || World::new(vec![post(0.36)]).expect("a world");
    let asking = Problem::exact(ball(), world(), None, corner[0].to_vec(), goal(), margins);
    assert_eq!(kinds(&judged(&asking.expect("a problem"))), ["clearance"]);
    assert_eq!(kinds(&judged(&exact(&ball(), vec![post(0.1225)], &corner[0], goal()))), ["contact"]);
}

/// Checks that a corner beyond a limit by rounding is a fault with and without clearances, because no proof was tried.
#[test]
fn a_corner_beyond_a_limit_by_rounding_is_not_accepted() {
    let path = [vec![-0.5, -1.0, 0.0], vec![0.5, -1.0, 0.0], vec![0.5, 0.5, 0.0]];
    let judged = |below: f64| {
        let from = [0.0, -1.0 - below, 0.0];
        let corner = RoundedCorner::new(1, [&from, &path[1], &[0.5, -0.5, 0.0]]);
        let problem =
            exact(&ball(), Vec::new(), &[-0.5, -1.0, 0.0], Goal::Configurations(vec![path[2].clone()]));
        let segment = Segment { corners: vec![corner], ..Segment::reach(path.to_vec(), Vec::new()) };
        let settings = AuditSettings { clearances: Clearances::None, ..AuditSettings::default() };
        audit_task(&problem, &Stage::of_goal(&problem), &[segment], settings).expect("a path")
    };
    assert!(judged(0.0).valid, "{:?}", judged(0.0).violations);
    assert_eq!(kinds(&judged(5e-10)), ["joint-limit"]);
}

#[test]
fn a_good_path_is_valid_with_the_clearance_of_each_edge() {
    let verification = judged(vec![Body::floor(-0.4)], &[FROM, [0.0, 0.0, -0.2], TO]);
    assert!(verification.valid && verification.goal.is_none());
    let least = 0.4 - 0.2 - RADIUS_M;
    assert!(verification.clearance_m.is_some_and(|clearance| (clearance - least).abs() <= 1.1e-5));
    assert_eq!(verification.clearances_per_edge_m.len(), 2);
}

#[test]
fn where_there_is_nothing_to_touch_there_is_no_clearance() {
    let verification = judged(Vec::new(), &[FROM, TO]);
    assert!(verification.valid);
    assert_eq!((verification.clearance_m, verification.clearances_per_edge_m), (None, vec![None]));
}

#[test]
fn a_path_that_begins_elsewhere_is_told() {
    let verification = judged(Vec::new(), &[[-0.5, 0.1, 0.0], TO]);
    let violation = only(&verification);
    assert_eq!((violation.kind(), violation.at.edge, word(violation, "first").as_str()), ("start", 0, "y"));
    assert!((number(violation, "off") - 0.1).abs() < 1e-12);
    assert_eq!(violation.to_string(), "y is 0.100000 m off the start");
    // Way points written with six digits still begin at the start.
    assert!(judged(Vec::new(), &[[-0.500004, 0.000004, 0.0], TO]).valid);
}

#[test]
fn a_path_that_ends_elsewhere_is_told() {
    let verification = judged(Vec::new(), &[FROM, [0.0, 0.0, 0.0], [0.5, -0.2, 0.0]]);
    let violation = only(&verification);
    assert_eq!((violation.kind(), violation.at.edge, word(violation, "first").as_str()), ("goal", 2, "y"));
    assert!((number(violation, "off") - 0.2).abs() < 1e-12);
}

fn ball_grasp(at: [f64; 3], score: f64) -> Grasp {
    let world_from_gripper = Pose::translation(at[0], at[1], at[2]);
    Grasp { score: Some(score), ..Grasp::at(world_from_gripper) }
}

#[test]
fn the_end_is_measured_at_the_nearest_grasp_or_its_twin() {
    let near = ball_grasp([0.5, 0.002, 0.0], 0.1).twin();
    let problem = exact(&ball(), Vec::new(), &FROM, grasps(vec![ball_grasp([0.0, 0.5, 0.0], 0.9), near]));
    let verification = verify_path(&problem, &[FROM, TO]);
    let violation = only(&verification);
    assert_eq!((violation.kind(), violation.at.edge), ("goal", 1));
    let goal = verification.goal.expect("the nearest grasp");
    assert_eq!(goal.grasp, 1);
    for off_m in [number(violation, "translation_error_m"), goal.translation_error_m] {
        assert!((off_m - 0.002).abs() < 1e-12);
    }
    assert!(goal.rotation_error_rad < 1e-9);
    assert!(verify_path(&problem, &[FROM, [0.5, 0.0015, 0.0]]).valid);
}

#[test]
fn a_gripper_that_is_turned_too_far_has_not_arrived() {
    for (degrees, has_arrived) in [(0.9_f64, true), (1.1, false)] {
        let turned = Pose::new(TO.into(), Vector::new(degrees.to_radians(), 0.0, 0.0));
        let grasp = Grasp::at(turned);
        let verification = verify_path(&exact(&ball(), Vec::new(), &FROM, grasps(vec![grasp])), &[FROM, TO]);
        assert_eq!(verification.valid, has_arrived, "{degrees}");
        let goal = verification.goal.expect("the only grasp");
        let says = |words: &str| verification.violations.iter().any(|v| v.to_string().contains(words));
        assert_eq!(
            says("ends 0.00 mm and 1.10° from the nearest grasp, 0"),
            !has_arrived,
            "{verification:?}"
        );
        assert!((goal.rotation_error_rad - degrees.to_radians()).abs() < 1e-9);
    }
}

#[test]
fn of_the_grasps_at_which_a_path_ends_the_best_scored_is_named() {
    let set =
        vec![ball_grasp(TO, 0.1), ball_grasp([0.5, 0.0005, 0.0], 0.7), ball_grasp([0.0, 0.5, 0.0], 0.9)];
    let verification = verify_path(&exact(&ball(), Vec::new(), &FROM, grasps(set)), &[FROM, TO]);
    assert!(verification.valid);
    assert_eq!(verification.goal.map(|goal| goal.grasp), Some(1));
}

#[test]
fn a_way_point_outside_the_limits_does_not_hide_what_its_edges_touch() {
    let wall = block("wall", [0.0, 0.0, 0.0], [0.02, 0.4, 0.4]);
    let verification = judged(vec![wall], &[FROM, [0.0, 1.2, 0.0], TO]);
    let limit = &verification.violations[0];
    assert_eq!((limit.kind(), limit.at.edge, word(limit, "first").as_str()), ("joint-limit", 1, "y"));
    assert!((number(limit, "off") - 0.2).abs() < 1e-12);
    assert_eq!(word(limit, "unit"), "m");
    assert_eq!(verification.violations.len(), 1, "round the wall there is no contact");
    let wall = block("wall", [0.0, 0.0, 0.0], [0.02, 2.0, 0.4]);
    let verification = judged(vec![wall], &[FROM, [0.0, 1.2, 0.0], TO]);
    let expected = ["joint-limit", "contact", "contact"];
    assert_eq!(kinds(&verification), expected);
    assert_eq!(verification.clearance_m, Some(0.0));
}

#[test]
fn a_contact_is_told_with_its_depth_and_place() {
    // The ball passes 0.08 m above the middle of a block 0.1 m high: 0.07 m deep.
    let verification = judged(vec![block("block", [0.0, 0.0, -0.08], [0.3, 0.3, 0.1])], &[FROM, TO]);
    let violation = only(&verification);
    assert_eq!((violation.kind(), violation.at.edge), ("contact", 0));
    assert_eq!(["first", "second"].map(|key| word(violation, key)), ["ball", "block"]);
    assert!((number(violation, "depth_m") - 0.07).abs() < 1e-6, "{violation:?}");
    // The edge is 1 m long, and the ball is over the block from 0.15 to 0.85 of it.
    assert!(number(violation, "at") > 0.15 && number(violation, "at") < 0.85);
    assert_eq!(verification.clearances_per_edge_m, [Some(0.0)]);
}

#[test]
fn everything_that_an_edge_touches_is_listed_and_the_others_keep_their_clearance() {
    let bodies = vec![
        block("second", [0.2, 0.0, 0.0], [0.02; 3]),
        block("first", [-0.2, 0.0, 0.0], [0.02; 3]),
        Body::floor(-0.5),
    ];
    let verification = judged(bodies, &[FROM, [0.5, 0.0, 0.0], [0.5, 0.5, 0.0], TO]);
    let touched: Vec<_> = verification.violations.iter().map(|v| (v.at.edge, word(v, "second"))).collect();
    assert_eq!(touched, [(0, "second".to_owned()), (0, "first".to_owned())]);
    assert_eq!(verification.clearance_m, Some(0.0));
    assert_eq!(verification.clearances_per_edge_m[0], Some(0.0));
    assert!(verification.clearances_per_edge_m[1..].iter().all(|c| c.is_some_and(|c| c > 0.2)));
}

/// Checks that the verdicts on the edges of a long path, judged in parallel, equal those on single edges.
#[test]
fn the_edges_of_a_long_path_are_judged_as_each_is_alone() {
    let bodies = || vec![Body::floor(-0.4), block("b", [0.3, 0.0, 0.0], [0.02; 3])];
    let path: Vec<[f64; 3]> =
        (0..3000).map(|i| [-0.5 + f64::from(i) / 2999.0, 0.0, f64::from(i % 7) * 0.01]).collect();
    let whole = judged(bodies(), &path);
    for edge in (0..2999).step_by(37) {
        let alone = judged(bodies(), &path[edge..edge + 2]);
        assert_eq!(alone.clearances_per_edge_m[0], whole.clearances_per_edge_m[edge], "edge {edge}");
        let contacts = |v: &Audit, edge: usize| {
            let of_edge = |v: &&Violation| v.at.edge == edge && v.kind() == "contact";
            v.violations
                .iter()
                .filter(of_edge)
                .map(|v| (number(v, "at"), number(v, "depth_m")))
                .collect::<Vec<_>>()
        };
        assert_eq!(contacts(&alone, 0), contacts(&whole, edge), "edge {edge}");
    }
}

/// Checks that further faulty edges report one pair each, which bounds the time for a million colliding way points.
#[test]
fn after_a_thousand_edges_with_faults_each_further_one_has_one() {
    let bodies = vec![block("a", [0.0, 0.0, 0.0], [0.02; 3]), block("b", [0.02, 0.0, 0.0], [0.02; 3])];
    let path: Vec<[f64; 3]> = (0..5000).map(|i| [f64::from(i % 2) * 0.01, 0.0, 0.0]).collect();
    let verification = judged(bodies, &path);
    let count = |edge: usize| {
        verification.violations.iter().filter(|v| v.at.edge == edge && v.kind() == "contact").count()
    };
    assert_eq!((count(0), count(999), count(4998)), (2, 2, 1));
}

fn with_margin(margin_m: f64, bodies: Vec<Body>) -> Problem {
    let world = World::new(bodies).expect("good poses");
    let margins = Margins { margin_m, ..Margins::default() };
    Problem::exact(ball(), world, None, FROM.to_vec(), there(), margins).expect("a good problem")
}

#[test]
fn what_comes_nearer_than_the_margin_is_told_apart_from_contact() {
    let floor = || vec![Body::floor(-0.02 - RADIUS_M)];
    let verification = verify_path(&with_margin(0.03, floor()), &[FROM, TO]);
    let violation = only(&verification);
    assert_eq!((violation.kind(), word(violation, "second").as_str()), ("clearance", "floor"));
    assert!((number(violation, "clearance_m") - 0.02).abs() < 1e-9);
    assert!((number(violation, "required_m") - 0.03).abs() < 1e-12);
    assert!(verify_path(&with_margin(0.019, floor()), &[FROM, TO]).valid);
    // A contact remains a contact under a margin.
    let deep = vec![Body::floor(-0.01)];
    let verification = verify_path(&with_margin(0.03, deep), &[FROM, TO]);
    assert_eq!(only(&verification).kind(), "contact");
    assert!((number(only(&verification), "depth_m") - 0.04).abs() < 1e-9);
}

#[test]
fn what_is_neither_proven_nor_refuted_is_told_as_that() {
    let goal = Goal::Configurations(vec![vec![-0.499, 0.0, 0.0]]);
    let floor = Body::floor(-RADIUS_M - CONTACT_M - 5e-8);
    let verification = verify_path(&exact(&ball(), vec![floor], &FROM, goal), &[FROM, [-0.499, 0.0, 0.0]]);
    assert_eq!(only(&verification).kind(), "unresolved");
    assert_eq!(word(only(&verification), "second"), "floor");
    assert_eq!(verification.clearance_m, Some(0.0));
}

#[test]
fn a_path_of_one_way_point_is_judged_like_any_other() {
    let stay = || Goal::Configurations(vec![FROM.to_vec()]);
    let free = verify_path(&exact(&ball(), vec![Body::floor(-0.2)], &FROM, stay()), &[FROM]);
    assert!(free.valid);
    assert!(free.clearance_m.is_some_and(|clearance| (clearance - 0.15).abs() <= 1.1e-5));
    let sunk = verify_path(&exact(&ball(), vec![Body::floor(-0.02)], &FROM, stay()), &[FROM]);
    assert_eq!(only(&sunk).kind(), "contact");
    assert!((number(only(&sunk), "depth_m") - 0.03).abs() < 1e-9);
    let elsewhere = judged(Vec::new(), &[FROM]);
    assert_eq!((only(&elsewhere).kind(), only(&elsewhere).at.edge), ("goal", 0));
}

/// Returns a path from `FROM` to `TO`, 1 m apart, in `count` edges.
fn in_steps(count: u32) -> Vec<[f64; 3]> {
    (0..=count).map(|k| [-0.5 + f64::from(k) / f64::from(count), 0.0, 0.0]).collect()
}

#[test]
fn under_paper_only_way_points_between_start_and_goal_are_checked() {
    let judge =
        |bodies: Vec<Body>, path: &[[f64; 3]]| verify_path(&paper(&ball(), bodies, &FROM, there()), path);
    assert!(judge(Vec::new(), &in_steps(10)).valid);
    assert_eq!(judge(Vec::new(), &in_steps(10)).clearance_m, None);
    // The surface of the plate touches the ball at the fourth way point.
    let plate = || block("plate", [-0.2, 0.0, 0.0], [0.001, 0.2, 0.2]);
    let verification = judge(vec![plate()], &in_steps(10));
    assert_eq!((only(&verification).kind(), only(&verification).at.edge), ("contact", 3));
    // Contacts at start and goal do not count.
    for x in [-0.5, 0.5] {
        assert!(judge(vec![block("plate", [x, 0.0, 0.0], [0.001, 0.02, 0.02])], &in_steps(10)).valid);
    }
}

#[test]
fn under_paper_a_step_beyond_the_released_one_is_told() {
    let problem = paper(&ball(), Vec::new(), &FROM, there());
    let mut path = in_steps(10);
    path.remove(4);
    let verification = verify_path(&problem, &path);
    assert_eq!((only(&verification).kind(), only(&verification).at.edge), ("step", 3));
    assert_eq!(kinds(&verify_path(&problem, &in_steps(8))), ["step"; 8]);
}

#[test]
fn under_paper_a_gripper_within_ten_centimetres_has_arrived() {
    let goal = |off_m: f64| grasps(vec![ball_grasp([0.5, off_m, 0.0], 0.5)]);
    for (off_m, has_arrived) in [(0.099, true), (0.101, false)] {
        let problem = paper(&ball(), Vec::new(), &FROM, goal(off_m));
        assert_eq!(verify_path(&problem, &in_steps(10)).valid, has_arrived, "{off_m}");
    }
}

#[test]
fn the_length_of_a_path_is_the_sum_of_its_edges() {
    let path = [[0.0, 0.0, 0.0], [0.3, 0.0, 0.4], [0.3, 1.2, 0.9]].map(|q| q.to_vec());
    assert!((path_length(&path) - 1.8).abs() < 1e-12);
    for short in [&path[..1], &[]] {
        assert_eq!(path_length(short).to_bits(), 0.0_f64.to_bits());
    }
}
