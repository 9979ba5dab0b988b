//! Grasps that a planner makes itself: what is asked of them, and what is refused.

use cranny_collision::PairGroup;
use cranny_grasp::GraspSet;
use cranny_path::{Audit, Cause, Violation, audit};
use cranny_plan::{Budget, Registry, Unobserved};
use cranny_robot::Hold;
use cranny_spatial::Pose;
use cranny_task::{FailureReason, Goal, OwnGrasp, Problem, TaskError};

use crate::fixture::{
    GANTRY_START, OBJECT, arm, block, easy, exact, gantry, grasps, makes_grasps, paper, still_life,
    without_set,
};

/// The gantry with its gripper at the object, turned by so much about the vertical.
fn at_object(yaw: f64, shift: [f64; 3]) -> Vec<f64> {
    // The gripper frame is 105 mm before the palm.
    let (sine, cosine) = yaw.sin_cos();
    let [x, y, z] = std::array::from_fn(|axis| OBJECT[axis] + shift[axis]);
    vec![x - 0.105 * cosine, y - 0.105 * sine, z, yaw, 0.0, 0.0]
}

/// What the judge says of standing at a configuration.
fn standing_at(bodies: Vec<cranny_collision::Body>, q: &[f64]) -> Audit {
    audit(&without_set(bodies, q), &[q.to_vec()]).expect("a configuration of the gantry")
}

#[test]
fn the_score_is_that_of_the_angle_between_pads_and_faces() {
    for yaw in [0.0, 0.05, -0.1, 0.15] {
        let audit = standing_at(still_life(), &at_object(yaw, [0.0; 3]));
        assert!(audit.valid, "{yaw}: {:?}", audit.violations);
        let grasp = audit.own_grasp.expect("a grasp");
        // Straight through the middle of a cube, the line between the contacts is turned by the yaw against its faces.
        assert!((grasp.score - (1.0 - f64::tan(yaw).abs() / 0.24)).abs() < 1e-9, "{yaw}: {grasp:?}");
        // Pads 50 mm long that meet two opposite edges of a cube of 30 mm.
        let between = 0.03 * (yaw.cos() + yaw.sin().abs());
        assert!((grasp.opening_m - between).abs() < 2e-4, "{yaw}: {grasp:?}");
    }
}

/// A core with a rib on either side, at these places along the pads, 5 mm higher than the core.
fn ribbed(at: [f64; 2]) -> Vec<cranny_collision::Body> {
    let [x, y, z] = OBJECT;
    let mut bodies = still_life();
    let ribs = [1.0, -1.0].into_iter().zip(at).map(|(side, along)| {
        block("rib", [x + along, y + 0.0125 * side, z], [0.003, 0.0025, 0.015]).parts[0].clone()
    });
    let mut object = block("object", OBJECT, [0.015, 0.01, 0.015]);
    object.parts.extend(ribs);
    bodies[2] = object;
    bodies
}

/// A line between the middles of the pads meets the parallel faces of the core, which no pad touches.
#[test]
fn pads_that_meet_a_rib_each_hold_nothing_unless_the_ribs_are_opposite() {
    let q = at_object(0.0, [0.0; 3]);
    let opposite = standing_at(ribbed([0.012, 0.012]), &q);
    assert!(opposite.valid, "{:?}", opposite.violations);
    assert!(opposite.own_grasp.is_some_and(|grasp| grasp.score > 1.0 - 1e-9));
    let apart = standing_at(ribbed([0.012, -0.012]), &q);
    let [Violation { cause: Cause::WeakGrasp { score, .. }, .. }] = apart.violations[..] else {
        panic!("{apart:?}")
    };
    assert!(score <= 0.0, "{score}");
}

/// The measured clearance of the sweep of the fingers is the least of those measured at many places along it.
#[test]
fn the_clearance_of_a_closing_hand_is_that_of_its_whole_sweep() {
    let [x, y, z] = OBJECT;
    let mut bodies = still_life();
    // Beside where a finger stands half closed.
    bodies.push(block("peg", [x, y + 0.03, z - 0.0155], [0.003, 0.002, 0.003]));
    let q = at_object(0.0, [0.0; 3]);
    let problem = without_set(bodies, &q);
    let cell = problem.cell().expect("exact");
    let robot = cell.robot();
    let world_from_target = Pose::translation(x, y, z);
    let tip_from_held = robot.frames_at(&q).link(robot.tip()).inverse() * world_from_target;
    let closing = 0.6;
    let held = cell.holding(2, Hold { tip_from_held, closing }).expect("a hold");
    let measured_m = held.closing_clearance(&q, PairGroup::Around, &mut held.scratch());
    let at = |step: u32| {
        let closing = closing * f64::from(step) / 200.0;
        let placed = held.with_hold(Hold { tip_from_held, closing }).expect("a hold");
        let standing = [q.clone(), q.clone()];
        placed.group_clearance(&standing, PairGroup::Around, 0.0, &mut placed.scratch())
    };
    let least_m = (0..=200).map(at).fold(f64::INFINITY, f64::min);
    assert!((measured_m - least_m).abs() < 3e-5, "{measured_m} {least_m}");
    assert!(measured_m < at(0) - 5e-4 && measured_m < at(200) - 5e-4, "it is least on the way");
}

#[test]
fn a_grasp_that_is_none_is_a_violation() {
    let first = |audit: Audit| audit.violations.into_iter().next().expect("a violation");
    let weak = standing_at(still_life(), &at_object(0.2, [0.0; 3]));
    assert!(matches!(first(weak).cause, Cause::WeakGrasp { score, .. } if (0.1..0.2).contains(&score)));
    // The ends of the pads hold it, whatever their middles meet.
    assert!(standing_at(still_life(), &at_object(0.0, [-0.03, 0.0, 0.0])).valid);
    let beside = standing_at(still_life(), &at_object(0.0, [-0.045, 0.0, 0.0]));
    let nothing = FailureReason::ClosesOnNothing;
    assert!(matches!(first(beside).cause, Cause::Grip { reason } if reason == nothing));
    // What a finger meets between where it stands open and the object.
    let [x, y, z] = OBJECT;
    let mut bodies = still_life();
    bodies.push(block("peg", [x + 0.02, y + 0.027, z + 0.005], [0.003, 0.002, 0.003]));
    let blocked = first(standing_at(bodies, &at_object(0.0, [0.0; 3])));
    let Cause::Grip { reason: FailureReason::ClosingCollides { second, .. } } = blocked.cause else {
        panic!("{blocked:?}");
    };
    assert_eq!(second, "peg");
}

/// The finger that touches first stands still while the other goes on to the object.
#[test]
fn each_finger_is_proven_up_to_where_it_touches() {
    let [x, y, z] = OBJECT;
    // One pad is 20 mm nearer to the object than the other.
    let q = at_object(0.0, [0.0, 0.01, 0.0]);
    let free = standing_at(still_life(), &q);
    assert!(free.valid, "{:?}", free.violations);
    let uneven_m = free.own_grasp.and_then(|grasp| grasp.uneven_m).expect("a grasp of this version");
    assert!((uneven_m - 0.02).abs() < 1e-4, "{uneven_m}");
    // The far pad meets it once the near one touches.
    let mut bodies = still_life();
    bodies.push(block("peg", [x + 0.02, y + 0.02, z + 0.005], [0.003, 0.002, 0.003]));
    let blocked = standing_at(bodies, &q);
    let [Violation { cause: Cause::Grip { reason: FailureReason::ClosingCollides { second, .. } }, .. }] =
        &blocked.violations[..]
    else {
        panic!("{blocked:?}");
    };
    assert_eq!(second, "peg");
}

#[test]
fn what_is_said_of_a_grasp_must_be_so() {
    let q = at_object(0.05, [0.0; 3]);
    let problem = without_set(still_life(), &q);
    let judged = audit(&problem, std::slice::from_ref(&q)).expect("a configuration");
    let truth = judged.own_grasp.expect("a grasp");
    assert!(judged.clone().with_said_grasps(&[(0, truth)]).valid);
    let (mut elsewhere, mut nowhere) = (truth.world_from_gripper, truth.world_from_gripper);
    elsewhere[0][3] += 1e-3;
    nowhere[0][0] = f64::NAN;
    for lie in [
        OwnGrasp { score: 0.99, ..truth },
        OwnGrasp { score: f64::NAN, ..truth },
        OwnGrasp { opening_m: truth.opening_m + 2e-4, ..truth },
        OwnGrasp { opening_m: f64::INFINITY, ..truth },
        OwnGrasp { uneven_m: Some(0.01), ..truth },
        OwnGrasp { uneven_m: Some(f64::NAN), ..truth },
        OwnGrasp { world_from_gripper: elsewhere, ..truth },
        OwnGrasp { world_from_gripper: nowhere, ..truth },
    ] {
        let audit = judged.clone().with_said_grasps(&[(0, lie)]);
        assert!(
            !audit.valid
                && matches!(audit.violations[..], [Violation { cause: Cause::SaidGrasp { .. }, .. }]),
            "{lie:?}"
        );
        assert!(audit.violations[0].to_string().contains("said"), "{lie:?}");
    }
}

#[test]
fn a_grasp_is_read_back_bit_by_bit_and_what_is_none_is_refused() {
    let q = at_object(0.05, [0.0; 3]);
    let grasp = standing_at(still_life(), &q).own_grasp.expect("a grasp");
    let text = serde_json::to_string(&grasp).expect("plain numbers");
    let read: OwnGrasp = serde_json::from_str(&text).expect("a grasp");
    assert_eq!(read, grasp);
    for (from, to) in [("\"score\":", "\"score\":null,\"x\":"), ("[[", "[[1e999,"), ("[[", "[[1.0,")] {
        assert!(text.contains(from), "{text}");
        assert!(serde_json::from_str::<OwnGrasp>(&text.replace(from, to)).is_err(), "{to}");
    }
}

#[test]
fn planners_that_need_a_set_name_those_that_need_none() {
    let (with, without) = (easy(), without_set(still_life(), &GANTRY_START));
    for name in Registry::default().names() {
        let plan = |problem: &Problem| {
            let planner = Registry::default().planner(name).expect("a planner of the registry");
            planner.plan(problem, &Budget { iterations: 10, ..Budget::default() }, 0, &mut Unobserved)
        };
        if makes_grasps(name) {
            let fault = plan(&with).expect_err("it makes grasps").to_string();
            assert!(fault.contains(name) && fault.contains("--grasps none"), "{fault}");
            assert!(plan(&without).is_ok(), "{name}");
        } else {
            let fault = plan(&without).expect_err("it needs a set").to_string();
            assert!(fault.contains("grasp-reach, grasp-rrt"), "{name}: {fault}");
        }
    }
}

#[test]
fn what_has_no_grasp_to_measure_is_refused_in_words() {
    let none = || Goal::Grasps(GraspSet::default());
    let fault = |problem: Problem, friction: f64| {
        let fault = problem.without_grasp_set(friction).expect_err("nothing to measure");
        assert!(matches!(fault, TaskError::NoGraspMeasure { .. } | TaskError::Collision(_)), "{fault:?}");
        fault.to_string()
    };
    let without_fingers = exact(&arm(), still_life(), &crate::fixture::START, none());
    assert!(fault(without_fingers, 0.24).contains("a hand that can close"));
    let without_target = exact(&gantry(), vec![block("box", OBJECT, [0.01; 3])], &GANTRY_START, none());
    assert!(fault(without_target, 0.24).contains("a target"));
    let under_paper = paper(&gantry(), still_life(), &GANTRY_START, grasps(Vec::new()));
    assert!(fault(under_paper, 0.24).contains("the exact criterion"));
    let mut ground = cranny_collision::Body::floor(-1.0);
    ground.name = "object".to_owned();
    let without_end = exact(&gantry(), vec![ground], &GANTRY_START, none());
    assert!(!fault(without_end, 0.24).is_empty());
    for friction in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let slippery = exact(&gantry(), still_life(), &GANTRY_START, none());
        assert!(fault(slippery, friction).contains("friction"));
    }
}
