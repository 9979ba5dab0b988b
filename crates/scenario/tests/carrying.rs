//! Tasks that take the target away, in the built-in scenarios.

use cranny_collision::Margins;
use cranny_plan::{Audit, AuditSettings, FailureReason, LiftOffSettings, Outcome, Problem, Unobserved};
use cranny_scenario::{OpenOptions, PlanFile, PlanSource, Scenario};
use cranny_solve::{Answer, Carry, CarryEnd, Mode, Request, Timing, solve};

fn problem(id: &str, margins: Margins) -> Problem {
    Scenario::open(id, &OpenOptions::default()).unwrap().problem(margins).unwrap()
}

fn carried(problem: &Problem, carry: Carry) -> Answer {
    let request = Request { carry: Some(carry), timing: Some(Timing::default()), ..Request::default() };
    solve(problem, &request, &mut Unobserved).unwrap()
}

fn audit_of(plan: &PlanFile, problem: &Problem) -> Audit {
    plan.audit(problem, AuditSettings { clearances: false, ..AuditSettings::default() }).unwrap().unwrap()
}

#[test]
fn the_target_of_every_scenario_can_be_carried_home() {
    let wide = Margins { margin_m: 0.005, grasp_margin_m: 0.001 };
    for family in 1..=4 {
        for level in 1..=5 {
            let id = format!("0{family}{level}");
            let margins = if level == 2 { wide } else { Margins::default() };
            let problem = problem(&id, margins);
            let answer = carried(&problem, Carry::default());
            assert!(answer.is_solved(), "{id}: {:?} {:?}", answer.outcome, answer.audit);
            let modes: Vec<Mode> = answer.segments.iter().map(|segment| segment.mode).collect();
            assert_eq!(modes, [Mode::Reach, Mode::LiftOff, Mode::Carry], "{id}");
            let [_, lift_off, carry] = &answer.segments[..] else { panic!("{id}") };
            assert_eq!(carry.waypoints.last().map(Vec::as_slice), Some(problem.start()), "{id}");
            let opening_m = lift_off.opening_m.unwrap();
            assert!(opening_m > 0.0 && opening_m < 0.08, "{id}: {opening_m}");
            // The same once more is the same.
            if level == 1 {
                let again = carried(&problem, Carry::default());
                assert_eq!(again.waypoints(), answer.waypoints(), "{id}");
            }
        }
    }
}

#[test]
fn a_plan_file_of_a_task_is_read_and_judged_and_lies_are_seen() {
    let problem = problem("021", Margins::default());
    let answer = carried(&problem, Carry::default());
    let plan = PlanFile::of(&answer, &PlanSource { scenario: "021".to_owned(), ..PlanSource::default() });
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("021.plan.json");
    plan.write(&file).unwrap();
    let read = PlanFile::read(&file).unwrap();
    assert_eq!(read, plan);
    let sound = audit_of(&read, &problem);
    assert!(sound.valid, "{:?}", sound.violations);
    assert_eq!(plan.carry_to, Some(vec![problem.start().to_vec()]));
    // The object dragged on along the table instead of off it.
    let mut dragged = plan.clone();
    let grasp = dragged.segments[1].waypoints[0].clone();
    let mut aside = grasp.clone();
    aside[0] -= 0.02;
    dragged.segments[1].waypoints = vec![grasp.clone(), aside.clone()];
    dragged.segments[2].waypoints = vec![aside];
    let kinds: Vec<&str> =
        audit_of(&dragged, &problem).violations.iter().map(cranny_plan::Violation::kind).collect();
    assert!(kinds.contains(&"lift-off"), "{kinds:?}");
    // Closed where the object is not.
    let mut missed = plan.clone();
    let mut above = grasp.clone();
    above[3] -= 0.4;
    missed.segments[0].waypoints.pop();
    missed.segments[0].waypoints.push(above);
    let violations = audit_of(&missed, &problem).violations;
    let nothing = |violation: &cranny_plan::Violation| {
        matches!(violation, cranny_plan::Violation::Grip { reason: FailureReason::ClosesOnNothing, .. })
    };
    assert!(violations.iter().any(nothing), "{violations:?}");
}

#[test]
fn where_the_object_is_carried_to_can_be_said() {
    let problem = problem("031", Margins::default());
    let mut end = problem.start().to_vec();
    end[2] += 0.3;
    let to = |end: &[f64]| Carry { end: CarryEnd::Configurations(vec![end.to_vec()]), ..Carry::default() };
    let answer = carried(&problem, to(&end));
    assert!(answer.is_solved());
    assert_eq!(answer.waypoints().last(), Some(&end));
    // An end that is in the way of nobody but itself: no grasp can be carried there.
    end[4] = 1e3;
    let request = Request {
        carry: Some(to(&end)),
        budget: cranny_plan::Budget { iterations: 20, ..cranny_plan::Budget::default() },
        ..Request::default()
    };
    let answer = solve(&problem, &request, &mut Unobserved).unwrap();
    assert_eq!(answer.outcome, Outcome::BudgetExhausted);
    assert!(answer.failures.iter().any(|failure| failure.reason == FailureReason::NotCarried));
    end[4] = f64::NAN;
    let request = Request { carry: Some(to(&end)), ..Request::default() };
    assert!(
        solve(&problem, &request, &mut Unobserved).unwrap_err().to_string().contains("not a finite number")
    );
}

#[test]
fn what_cannot_be_carried_is_refused_in_words() {
    let request = Request { carry: Some(Carry::default()), ..Request::default() };
    let refused = |problem: &Problem, request: &Request| {
        solve(problem, request, &mut Unobserved).unwrap_err().to_string()
    };
    let sound = problem("021", Margins::default());
    let other = Request { planner: Some("ik-rrt".to_owned()), ..request.clone() };
    assert!(refused(&sound, &other).contains("only `reach`"));
    let scenario = Scenario::open("021", &OpenOptions::default()).unwrap();
    let goal = cranny_plan::Goal::Configurations(vec![scenario.start.clone()]);
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
    let high = LiftOffSettings { clear_m: 0.5, ..LiftOffSettings::default() };
    let impossible = Request {
        carry: Some(Carry { lift_off: high, ..Carry::default() }),
        budget: cranny_plan::Budget { iterations: 20, ..cranny_plan::Budget::default() },
        ..Request::default()
    };
    let answer = solve(&sound, &impossible, &mut Unobserved).unwrap();
    assert_eq!(answer.outcome, Outcome::BudgetExhausted);
}
