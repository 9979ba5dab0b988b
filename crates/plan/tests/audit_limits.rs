//! Paths that are expensive to judge are refused first, or judged within limits. Without these, each of the tests takes minutes
//! or gigabytes.

use std::sync::Arc;

use cranny_collision::Body;
use cranny_path::{
    Audit, AuditLimits, AuditSettings, Clearances, PathError, Violation, audit_task, audit_with,
};
use cranny_robot::{Robot, RobotOptions};
use cranny_spatial::CONTACT_M;
use cranny_task::{Goal, Mode, Problem, Segment, Stage};

use crate::fixture::{ball, block, exact};

/// Radius of the ball, in metres.
const RADIUS_M: f64 = 0.05;

const FROM: [f64; 3] = [-0.5, 0.0, 0.0];
const TO: [f64; 3] = [0.5, 0.0, 0.0];

/// Returns the problem of moving a ball whose joints reach as far as this (m) above a floor at this height (m).
fn above_floor(reach_m: f64, floor_m: f64) -> Problem {
    let urdf = cranny_test_robots::ball(reach_m);
    let robot = Robot::from_urdf_text(&urdf, "ball.urdf", None, &RobotOptions::default()).expect("a robot");
    let goal = Goal::Configurations(vec![TO.to_vec()]);
    exact(&Arc::new(robot), vec![Body::floor(floor_m)], &FROM, goal)
}

fn judged(problem: &Problem, path: &[[f64; 3]], settings: AuditSettings) -> Result<Audit, PathError> {
    let path: Vec<Vec<f64>> = path.iter().map(|q| q.to_vec()).collect();
    audit_with(problem, &path, settings)
}

fn kinds(audit: &Audit) -> Vec<&'static str> {
    audit.violations.iter().map(Violation::kind).collect()
}

#[test]
fn a_path_far_beyond_the_joint_limits_is_refused_before_any_proof() {
    let problem = above_floor(1.0, -0.2);
    for far in [11.1, 1e6, 1e18, 1e308, -f64::MAX] {
        for clearances in [Clearances::None, Clearances::OfPath, Clearances::OfEdges] {
            let settings = AuditSettings { clearances, ..AuditSettings::default() };
            let path = [FROM, [far, 0.0, 0.0], [f64::MIN_POSITIVE, 0.0, 5e-324], TO];
            let audit = judged(&problem, &path, settings).expect("a verdict");
            assert_eq!((kinds(&audit), audit.valid), (vec!["joint-limit"], false), "{far}");
            assert_eq!(audit.violations[0].at.edge, 1);
            let segments = [Segment::reach(path.map(|q| q.to_vec()).to_vec(), Vec::new())];
            let of_task = audit_task(&problem, &Stage::of_goal(&problem), &segments, settings);
            assert_eq!(of_task.expect("a verdict"), audit);
        }
    }
}

#[test]
fn joints_that_travel_without_end_are_refused() {
    let problem = above_floor(300.0, -0.2);
    let far = [[-0.5, 0.0, 0.0], [299.5, 0.0, 0.0]];
    let path: Vec<[f64; 3]> = (0..1000).map(|index| far[index % 2]).collect();
    let fault = judged(&problem, &path, AuditSettings::default()).unwrap_err();
    assert!(matches!(fault, PathError::TooMuchTravel { edge: 333, most: 100_000, .. }), "{fault}");
    // A turning joint may have such limits.
    let urdf = cranny_test_robots::rolling_arm(1e7, false);
    let robot = Robot::from_urdf_text(&urdf, "arm.urdf", None, &RobotOptions::default()).expect("a robot");
    let (start, mut end) = (vec![0.0; robot.dof()], vec![0.0; robot.dof()]);
    end[robot.dof() - 1] = 1e6;
    let goal = Goal::Configurations(vec![end.clone()]);
    let problem = exact(&Arc::new(robot), vec![Body::floor(-10.0)], &start, goal);
    let fault = audit_with(&problem, &[start, end], AuditSettings::default()).unwrap_err();
    assert!(matches!(fault, PathError::TooMuchTravel { edge: 0, .. }), "{fault}");
}

#[test]
fn more_way_points_than_the_limit_are_refused_however_they_are_divided() {
    let (problem, stages) = (above_floor(1.0, -0.2), [Stage::pick()]);
    let settings = AuditSettings { limits: AuditLimits::UNTRUSTED, ..AuditSettings::default() };
    let is_refused = |fault: PathError, count| {
        assert!(
            matches!(fault, PathError::TooManyWayPoints { actual, most: 10_000 } if actual == count),
            "{fault}"
        );
        assert_eq!(
            fault.to_string(),
            format!("the path has {count} way points, but at most 10000 are judged")
        );
    };
    is_refused(judged(&problem, &vec![FROM; 10_001], settings).unwrap_err(), 10_001);
    let many = vec![FROM; 1_000_001];
    let fault = judged(&problem, &many, AuditSettings::default()).unwrap_err();
    assert!(matches!(fault, PathError::TooManyWayPoints { most: 1_000_000, .. }), "{fault}");
    // Joined, these segments are a path of a single way point.
    for length in [1, 2] {
        let waypoints = vec![FROM.to_vec(); length];
        let segments = vec![Segment::empty(0, Mode::REACH, waypoints); 50_000 / length];
        is_refused(audit_task(&problem, &stages, &segments, settings).unwrap_err(), 50_000);
        let audit = audit_task(&problem, &stages, &segments, AuditSettings::default()).expect("a verdict");
        assert_eq!(kinds(&audit), ["goal"]);
    }
}

#[test]
fn a_long_path_is_judged() {
    let problem = above_floor(1.0, -0.2);
    let path: Vec<[f64; 3]> = (0..=100_000).map(|i| [-0.5 + f64::from(i) * 1e-5, 0.0, 0.0]).collect();
    let settings = AuditSettings { clearances: Clearances::None, ..AuditSettings::default() };
    let audit = judged(&problem, &path, settings).expect("a verdict");
    assert!(audit.valid, "{:?}", audit.violations);
}

#[test]
fn an_audit_ends_at_the_number_of_violations_that_are_reported() {
    let goal = Goal::Configurations(vec![TO.to_vec()]);
    let problem = exact(&ball(), vec![block("a", [0.0; 3], [0.02; 3])], &FROM, goal);
    let mut path = vec![FROM; 5];
    path.extend((0..3000).map(|i| [f64::from(i % 2) * 0.01, 0.0, 0.0]));
    for clearances in [Clearances::None, Clearances::OfPath, Clearances::OfEdges] {
        let settings =
            AuditSettings { clearances, limits: AuditLimits::UNTRUSTED, ..AuditSettings::default() };
        let audit = judged(&problem, &path, settings).expect("a verdict");
        assert_eq!((kinds(&audit), audit.violations[0].at.edge), (vec!["contact"], 4));
        assert_eq!((audit.valid, audit.clearances_per_edge_m.len()), (false, 0));
        assert!(audit.clearance_m.is_none_or(|clearance_m| clearance_m <= 0.0));
    }
    let limits = AuditLimits { violations: 1500, ..AuditLimits::default() };
    let some =
        judged(&problem, &path, AuditSettings { limits, ..AuditSettings::default() }).expect("a verdict");
    assert!((1500..2600).contains(&some.violations.len()), "{}", some.violations.len());
}

/// At this distance from a floor, 300 metres take 10⁸ intervals, of which a proof takes a million.
#[test]
fn a_motion_that_hardly_clears_a_body_is_unresolved_within_bounded_effort() {
    let problem = above_floor(300.0, -RADIUS_M - CONTACT_M - 2e-6);
    let path = [FROM, [299.0, 0.0, 0.0]];
    let settings = AuditSettings { clearances: Clearances::None, at_goal: false, ..AuditSettings::default() };
    let audit = judged(&problem, &path, settings).expect("a verdict");
    assert_eq!(kinds(&audit), ["unresolved"]);
}
