//! Straight approaches and retreats of the hand.

use cranny_collision::Margins;
use cranny_path::{AuditSettings, Clearances};
use cranny_plan::Unobserved;
use cranny_record::{PlanFile, PlanOptions, PlanSource};
use cranny_robot::{Robot, between};
use cranny_scenario::{OpenOptions, Scenario};
use cranny_solve::solve;
use cranny_spatial::{Pose, Vector};
use cranny_task::{Mode, Problem, Segment, Stage};

const APPROACH_M: f64 = 0.06;
const RETREAT_M: f64 = 0.08;

fn open(id: &str) -> Problem {
    Scenario::open(id, &OpenOptions::default()).unwrap().problem(Margins::default()).unwrap()
}

fn straight(problem: &Problem, seed: u64, place: Option<&str>) -> PlanFile {
    let place = place.map(str::to_owned);
    let retreat_m = place.as_ref().map(|_| RETREAT_M);
    let ask = PlanOptions {
        seed,
        place,
        approach_m: Some(APPROACH_M),
        retreat_m,
        hold: 0.0,
        ..PlanOptions::default()
    };
    let (request, _) = ask.request(problem, None).unwrap();
    let answer = solve(problem, &request, &mut Unobserved).unwrap();
    assert!(answer.is_solved(), "{:?} {:?}", answer.outcome, answer.audit);
    PlanFile::of(&answer, &PlanSource::default())
}

fn faults(plan: &PlanFile, problem: &Problem) -> Vec<String> {
    let settings = AuditSettings { clearances: Clearances::None, ..AuditSettings::default() };
    match plan.audit(problem, settings) {
        Ok(audit) => audit.unwrap().violations.iter().map(ToString::to_string).collect(),
        Err(fault) => vec![fault.to_string()],
    }
}

fn tip(robot: &Robot, q: &[f64]) -> Pose {
    *robot.frames_at(q).link(robot.tip())
}

/// Checks by forward kinematics alone that poses of the gripper frame along edges and rounded corners lie on the line that ends
/// at `end`, within 1 mm and 1°, and that it has the required length.
fn is_straight(robot: &Robot, segment: &Segment, (end, far): (&[f64], &[f64]), least_m: f64) {
    let world_from_end = tip(robot, end);
    let in_end = |q: &[f64]| world_from_end.inverse() * tip(robot, q);
    assert!(-in_end(far).translation.z >= least_m);
    let edges = segment.waypoints.windows(2).flat_map(|edge| {
        (0..=50).map(|share| between(&edge[0], &edge[1], f64::from(share) / 50.0).collect::<Vec<f64>>())
    });
    let corners = segment.corners.iter().flat_map(|corner| corner.control_points.iter().cloned());
    let of_corner = |q: &Vec<f64>| in_end(q).translation.vector.xy().norm() < 2e-3;
    assert!(corners.collect::<Vec<_>>().iter().all(of_corner));
    for q in edges {
        let pose = in_end(&q);
        assert!(pose.translation.vector.xy().norm() <= 1e-3, "{pose}");
        assert!(pose.rotation.angle() <= 1f64.to_radians(), "{pose}");
    }
}

#[test]
fn the_hand_comes_and_leaves_on_straight_lines() {
    for (id, place) in
        [("012", Some("outside")), ("031", Some("outside")), ("043", None), ("024", Some("outside"))]
    {
        let problem = open(id);
        let robot = problem.robot();
        for seed in 0..3 {
            let plan = straight(&problem, seed, place);
            assert_eq!(faults(&plan, &problem), Vec::<String>::new(), "{id} {seed}");
            let approach = plan.segments.iter().find(|segment| segment.mode == Mode::APPROACH).unwrap();
            let ends = [&approach.waypoints[0], approach.waypoints.last().unwrap()];
            is_straight(robot, approach, (ends[1], ends[0]), APPROACH_M);
            if place.is_some() {
                let retreat = plan.segments.iter().find(|segment| segment.mode == Mode::RETREAT).unwrap();
                let ends = [&retreat.waypoints[0], retreat.waypoints.last().unwrap()];
                is_straight(robot, retreat, (ends[0], ends[1]), RETREAT_M);
            }
        }
    }
}

#[test]
fn what_is_not_straight_is_refused() {
    let problem = open("012");
    let plan = straight(&problem, 0, Some("outside"));
    let is_refused = |plan: &PlanFile, words: &str| {
        let faults = faults(plan, &problem);
        assert!(faults.iter().any(|fault| fault.contains(words)), "{words}: {faults:?}");
    };
    let approach = plan.segments.iter().position(|segment| segment.mode == Mode::APPROACH).unwrap();

    let mut other = plan.clone();
    other.segments[approach].mode = Mode::REACH;
    is_refused(&other, "0.0 mm on a straight line, 60.0 mm are demanded");

    // A stage that requires a longer motion than the path has.
    for (stage, demanded) in [(0, "70.0 mm are demanded"), (1, "380.0 mm are demanded")] {
        let mut other = plan.clone();
        match &mut other.task[stage] {
            Stage::Pick(pick) => pick.approach_m += 0.01,
            Stage::Place(place) => place.retreat_m += 0.3,
            Stage::Move(_) => {}
        }
        is_refused(&other, demanded);
    }

    // A start that lies 3 mm beside the line.
    let mut other = plan.clone();
    let robot = problem.robot();
    let begin = plan.segments[approach].waypoints[0].clone();
    let beside = tip(robot, &begin)
        * Pose::from_parts((Vector::x() * 3e-3).into(), cranny_spatial::Rotation::identity());
    let solver = &mut cranny_robot::IkSolver::new(robot, cranny_robot::IkSettings::default());
    let moved = solver.step_from(&beside, &begin).unwrap();
    other.segments[approach].waypoints[0].clone_from(&moved);
    *other.segments[approach - 1].waypoints.last_mut().unwrap() = moved;
    is_refused(&other, "the bound 'straight line' is exceeded");

    // An approach without a grasp after it.
    let mut other = plan.clone();
    other.segments[approach - 1].mode = Mode::APPROACH;
    is_refused(&other, "is an approach, but no grasp follows it");
    assert_eq!(faults(&plan, &problem), Vec::<String>::new());
}

#[test]
fn lengths_that_are_none_and_tasks_without_them_are_refused() {
    let problem = open("012");
    let fault = |ask: PlanOptions| ask.request(&problem, None).unwrap_err().to_string();
    for length_m in [-0.01, 0.6, f64::NAN] {
        let words = fault(PlanOptions { approach_m: Some(length_m), ..PlanOptions::default() });
        assert!(words.contains("not a valid length of an approach: expected 0 to 0.5 m"), "{words}");
    }
    let words = fault(PlanOptions { retreat_m: Some(0.05), ..PlanOptions::default() });
    assert!(words.contains("it is only valid with `place`"), "{words}");
    let moving =
        problem.with_goal(cranny_task::Goal::Configurations(vec![problem.start().to_vec()])).unwrap();
    let ask = PlanOptions { approach_m: Some(0.05), ..PlanOptions::default() };
    let words = ask.request(&moving, None).unwrap_err().to_string();
    assert!(words.contains("nothing is grasped"), "{words}");
}

/// An approach begins where the motion before it ends, and the hand retreats as soon as it has let go.
#[test]
fn an_approach_from_nowhere_and_a_retreat_by_another_name_are_refused() {
    let problem = open("012");
    let plan = straight(&problem, 0, Some("outside"));
    let approach = plan.segments.iter().position(|segment| segment.mode == Mode::APPROACH).unwrap();
    let mut teleported = plan.clone();
    teleported.segments.drain(..approach);
    assert!(faults(&teleported, &problem).iter().any(|fault| fault.contains("off the start")));
    let mut single = teleported;
    single.segments.truncate(1);
    let end = single.segments[0].waypoints.last().unwrap().clone();
    single.segments[0].waypoints = vec![end];
    single.segments[0].corners.clear();
    single.task = vec![Stage::pick()];
    assert!(faults(&single, &problem).iter().any(|fault| fault.contains("off the start")));
    for mode in [Mode::RETURN, Mode::REACH] {
        let mut renamed = plan.clone();
        for segment in renamed.segments.iter_mut().filter(|segment| segment.mode == Mode::RETREAT) {
            segment.mode = mode;
        }
        assert!(faults(&renamed, &problem).iter().any(|fault| fault.contains("does not retreat")));
    }
    let stage = serde_json::from_str::<Stage>(r#"{"pick": "target", "approach_m": -0.08}"#);
    assert!(stage.unwrap_err().to_string().contains("not a valid length of an approach"));
}
