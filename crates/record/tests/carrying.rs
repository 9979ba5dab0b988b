//! Tasks that carry the target away, in the built-in scenarios.

use cranny_collision::Margins;
use cranny_path::{Audit, AuditSettings, Cause, Clearances, Violation};
use cranny_plan::{Outcome, Unobserved};
use cranny_record::{PlanFile, PlanSource};
use cranny_scenario::{OpenOptions, Scenario};
use cranny_solve::{Answer, Request, Timing, solve};
use cranny_spatial::Stream;
use cranny_task::{FailureReason, Mode, Move, Problem, Stage};

fn problem(id: &str, margins: Margins) -> Problem {
    Scenario::open(id, &OpenOptions::default()).unwrap().problem(margins).unwrap()
}

fn carried(problem: &Problem, goal: Move) -> Answer {
    let request = Request { timing: Some(Timing::default()), ..carry(goal) };
    solve(problem, &request, &mut Unobserved).unwrap()
}

fn carry(goal: Move) -> Request {
    Request { stages: vec![Stage::pick(), Stage::Move(goal)], ..Request::default() }
}

fn audit_of(plan: &PlanFile, problem: &Problem) -> Audit {
    plan.audit(problem, AuditSettings { clearances: Clearances::None, ..AuditSettings::default() })
        .unwrap()
        .unwrap()
}

#[test]
fn the_target_of_every_scenario_can_be_carried_home() {
    let wide = Margins { margin_m: 0.005, grasp_margin_m: 0.001, ..Margins::default() };
    for family in 1..=4 {
        for level in 1..=5 {
            let id = format!("0{family}{level}");
            let margins = if level == 2 { wide } else { Margins::default() };
            let problem = problem(&id, margins);
            let answer = carried(&problem, Move::Home);
            assert!(answer.is_solved(), "{id}: {:?} {:?}", answer.outcome, answer.audit);
            let modes: Vec<Mode> = answer.segments.iter().map(|segment| segment.mode).collect();
            assert_eq!(modes, [Mode::REACH, Mode::LIFT_OFF, Mode::CARRY], "{id}");
            let [_, lift_off, carry] = &answer.segments[..] else { panic!("{id}") };
            assert_eq!(carry.waypoints.last().map(Vec::as_slice), Some(problem.start()), "{id}");
            let opening_m = lift_off.opening_m.unwrap();
            assert!(opening_m > 0.0 && opening_m < 0.08, "{id}: {opening_m}");
            if level == 1 {
                let again = carried(&problem, Move::Home);
                assert_eq!(again.waypoints(), answer.waypoints(), "{id}");
            }
        }
    }
}

#[test]
fn a_plan_file_of_a_task_is_read_and_judged_and_lies_are_seen() {
    let problem = problem("021", Margins::default());
    let answer = carried(&problem, Move::Home);
    let plan = PlanFile::of(&answer, &PlanSource { scenario: "021".to_owned(), ..PlanSource::default() });
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("021.plan.json");
    plan.write(&file).unwrap();
    let read = PlanFile::read(&file).unwrap();
    assert_eq!(read, plan);
    let sound = audit_of(&read, &problem);
    assert!(sound.valid, "{:?}", sound.violations);
    assert_eq!(plan.task, [Stage::pick(), Stage::home()]);
    let again = solve(&problem, &plan.request(), &mut Unobserved).unwrap();
    assert_eq!(again.waypoints(), plan.waypoints);
    // The audit checks the stated hand and goal, along the edges alone.
    let mut plan = plan;
    plan.segments.iter_mut().for_each(|segment| segment.corners.clear());
    let kinds = |plan: &PlanFile| -> Vec<&str> {
        audit_of(plan, &problem).violations.iter().map(Violation::kind).collect()
    };
    let mut wider = plan.clone();
    wider.segments[2].opening_m = Some(0.07);
    assert_eq!(kinds(&wider), ["grip"]);
    let mut other = plan.clone();
    other.segments[1].attached = Some("table".to_owned());
    assert_eq!(kinds(&other), ["grip"]);
    let mut elsewhere = plan.clone();
    let mut aside = problem.start().to_vec();
    aside[1] += 0.01;
    elsewhere.task[1] = Stage::Move(Move::Configurations(vec![aside]));
    assert_eq!(kinds(&elsewhere), ["goal"]);
    let mut short = plan.clone();
    short.segments[2].waypoints.pop();
    short.segments[2].waypoints.truncate(1);
    short.task[1] = Stage::Move(Move::Clear { clear_m: 1.0 });
    assert_eq!(kinds(&short), ["goal"]);
    // Move up and down again until the object has gone too far.
    let mut long = plan.clone();
    let lift_off = long.segments[1].waypoints.clone();
    for _ in 0..5 {
        long.segments[1].waypoints.extend(lift_off.iter().rev().skip(1).cloned());
        long.segments[1].waypoints.extend(lift_off.iter().skip(1).cloned());
    }
    assert_eq!(kinds(&long), ["lift-off"]);
    // Drag the object along the table instead of lifting it.
    let mut dragged = plan.clone();
    let grasp = dragged.segments[1].waypoints[0].clone();
    let mut aside = grasp.clone();
    aside[0] -= 0.02;
    dragged.segments[1].waypoints = vec![grasp.clone(), aside.clone()];
    dragged.segments[2].waypoints = vec![aside];
    assert!(kinds(&dragged).contains(&"lift-off"), "{:?}", kinds(&dragged));
    // Close the hand where there is no object.
    let mut missed = plan.clone();
    let mut above = grasp.clone();
    above[3] -= 0.4;
    missed.segments[0].waypoints.pop();
    missed.segments[0].waypoints.push(above.clone());
    missed.segments[1].waypoints[0] = above;
    let violations = audit_of(&missed, &problem).violations;
    let nothing = |violation: &Violation| {
        matches!(violation.cause, Cause::Grip { reason: FailureReason::ClosesOnNothing })
    };
    assert!(violations.iter().any(nothing), "{violations:?}");
}

#[test]
fn where_the_object_is_carried_to_can_be_said() {
    let problem = problem("031", Margins::default());
    let mut end = problem.start().to_vec();
    end[2] += 0.3;
    let to = |end: &[f64]| Move::Configurations(vec![end.to_vec()]);
    let answer = carried(&problem, to(&end));
    assert!(answer.is_solved());
    assert_eq!(answer.waypoints().last(), Some(&end));
    // At this goal the arm itself collides: every grasp is refused, without a search.
    let cell = problem.cell().expect("the default criterion is exact");
    let mut scratch = cell.scratch();
    let mut random = Stream::new(0, 0);
    let mut draws = (0..10_000).map(|_| cell.robot().random_configuration(&mut random));
    let is_in_the_floor = |q: &Vec<f64>| {
        let contacts = cell.contacts(q, &mut scratch);
        contacts.iter().any(|contact| contact.names(cell) == ["panda_link5", "floor"].map(str::to_owned))
    };
    let low = draws.find(is_in_the_floor).expect("a low elbow");
    let answer = carried(&problem, to(&low));
    assert_eq!(answer.outcome, Outcome::NoReachableGrasp);
    let is_of_end = |reason: &FailureReason| matches!(reason, FailureReason::EndBlocked { .. });
    assert!(answer.failures.iter().any(|failure| is_of_end(&failure.reason)), "{:?}", answer.failures);
    let refused = |goal: Move| solve(&problem, &carry(goal), &mut Unobserved).unwrap_err().to_string();
    end[4] = 1e3;
    let far = refused(Move::Configurations(vec![end.clone()]));
    assert!(far.contains("cannot be at 1000: its limits are"), "{far}");
    end[4] = f64::NAN;
    assert!(refused(Move::Configurations(vec![end])).contains("not a finite number"));
    assert!(refused(Move::Configurations(Vec::new())).contains("no configuration"));
    assert!(refused(Move::Clear { clear_m: f64::NAN }).contains("not a valid clearance"));
}

#[test]
fn out_is_where_the_object_is_clear_of_everything_but_the_floor() {
    for (id, clear_m) in [("015", 0.05), ("025", 0.1), ("035", 0.05), ("045", 0.02)] {
        let problem = problem(id, Margins::default());
        let answer = carried(&problem, Move::Clear { clear_m });
        assert!(answer.is_solved(), "{id}: {:?} {:?}", answer.outcome, answer.audit);
        let home = carried(&problem, Move::Home);
        assert!(answer.waypoints().last() != home.waypoints().last(), "{id}: no farther than needed");
        let source = PlanSource { scenario: id.to_owned(), ..PlanSource::default() };
        let mut plan = PlanFile::of(&answer, &source);
        assert_eq!(plan.task[1], Stage::Move(Move::Clear { clear_m }));
        plan.task[1] = Stage::Move(Move::Clear { clear_m: 1.0 });
        let kinds: Vec<&str> = audit_of(&plan, &problem).violations.iter().map(Violation::kind).collect();
        assert_eq!(kinds, ["goal"], "{id}");
    }
}

#[test]
fn what_cannot_be_carried_is_refused_in_words() {
    let request = carry(Move::Home);
    let refused = |problem: &Problem, request: &Request| {
        solve(problem, request, &mut Unobserved).unwrap_err().to_string()
    };
    let sound = problem("021", Margins::default());
    // Every planner carries: one whose search cannot continue starts again for each grasp.
    for planner in ["ik-rrt", "rrt-connect", "j-plus-rbt"] {
        let other = Request { planner: Some(planner.to_owned()), ..request.clone() };
        let answer = solve(&sound, &other, &mut Unobserved).unwrap();
        assert!(answer.is_valid() && answer.segments.len() == 3, "{planner} {:?}", answer.outcome);
    }
    let scenario = Scenario::open("021", &OpenOptions::default()).unwrap();
    let goal = cranny_task::Goal::Configurations(vec![scenario.start.clone()]);
    let no_target = Problem::exact(
        scenario.robot.clone(),
        scenario.world.clone(),
        None,
        scenario.start.clone(),
        goal,
        Margins::default(),
    )
    .unwrap();
    assert!(refused(&no_target, &request).contains("needs a target"));
}
