//! Rounded corners: proven free, within every limit, faster than stops; and statements of a file on them are checked.

use cranny_collision::Margins;
use cranny_path::TimingMethod;
use cranny_plan::Unobserved;
use cranny_record::{PlanFile, PlanSource};
use cranny_scenario::{OpenOptions, Scenario};
use cranny_solve::{Request, Timing, solve};
use cranny_task::{Move, Stage};
use serde_json::{Value, json};

/// Every sample must be free, with the required margins, and the acceleration must change no faster than the jerk limit.
#[test]
fn a_rounded_trajectory_is_free_and_keeps_every_limit_at_1_khz() {
    let mut rounded = 0;
    for (id, margin_m) in [("021", 0.0), ("023", 0.0), ("023", 0.005), ("025", 0.0), ("043", 0.0)] {
        let scenario = Scenario::open(id, &OpenOptions::default()).expect("a scenario");
        let demands = Margins { margin_m, grasp_margin_m: 0.0, ..Margins::default() };
        let problem = scenario.problem(demands).expect("a problem");
        let cell = problem.cell().expect("exact is the default");
        for (method, seed) in
            [(TimingMethod::TimeOptimal, 0), (TimingMethod::JerkLimited, 0), (TimingMethod::JerkLimited, 1)]
        {
            let of = |stops: bool| {
                let timing =
                    Some(Timing { method: Some(method), stops, is_demanded: true, ..Timing::default() });
                let request = Request { seed, timing, ..Request::default() };
                let answer = solve(&problem, &request, &mut Unobserved).expect("a good request");
                assert!(answer.is_valid());
                answer.timed.expect("limits").trajectory
            };
            let (round, stopping) = (of(false), of(true));
            assert!(round.duration_s() <= stopping.duration_s());
            rounded += usize::from(round.is_rounded());
            let mut scratch = cell.scratch();
            let mut before: Option<Vec<f64>> = None;
            let samples: Vec<_> = round.samples(1000.0).expect("samples").collect();
            for sample in &samples[..samples.len() - 1] {
                assert!(cell.is_free(&sample.position, &mut scratch), "{id} {seed} at {} s", sample.time_s);
                for (joint, limits) in problem.robot().limits().iter().enumerate() {
                    assert!(sample.velocity[joint].abs() <= limits.velocity);
                    assert!(sample.acceleration[joint].abs() <= limits.acceleration.expect("known"));
                    if let (Some(before), TimingMethod::JerkLimited) = (&before, method) {
                        let change = (sample.acceleration[joint] - before[joint]).abs();
                        assert!(change <= 1e-3 * limits.jerk.expect("known"), "{id} joint {joint}");
                    }
                }
                before = Some(sample.acceleration.clone());
            }
        }
    }
    assert!(rounded > 10, "{rounded}");
}

fn carried() -> (Scenario, Value) {
    let scenario = Scenario::open("043", &OpenOptions::default()).unwrap();
    let problem = scenario.problem(Margins::default()).unwrap();
    let stages = vec![Stage::pick(), Stage::Move(Move::Home)];
    let request = Request { stages, timing: Some(Timing::default()), robustness: true, ..Request::default() };
    let answer = solve(&problem, &request, &mut Unobserved).unwrap();
    assert!(
        answer.is_solved()
            && answer.segments.iter().all(|s| s.mode.rests_at.is_some() || !s.corners.is_empty())
    );
    let source = PlanSource { scenario: "043".into(), ..PlanSource::default() };
    (scenario, serde_json::to_value(PlanFile::of(&answer, &source)).unwrap())
}

/// A corner of other edges, of more than half an edge, of another form, out of order, at an invalid way point, or where the
/// object may rest makes a file invalid; one through an obstacle, or another pace, is a fault of the plan.
#[test]
fn corners_that_a_file_states_are_judged_from_their_control_points() {
    let (scenario, plan) = carried();
    let problem = scenario.problem(Margins::default()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("x.plan.json");
    let read = |plan: &Value| {
        std::fs::write(&file, plan.to_string()).unwrap();
        PlanFile::read(&file).map_err(|fault| fault.to_string())
    };
    let verdict = |plan: &PlanFile| {
        let source = PlanSource { scenario: "043".into(), ..PlanSource::default() };
        plan.judge(&source, &problem, cranny_path::AuditSettings::default()).unwrap().unwrap()
    };
    let sound = read(&plan).unwrap();
    assert!(verdict(&sound).audit.valid, "{:?}", verdict(&sound).audit.violations);
    let changed = |pointer: &str, value: Value| {
        let mut other = plan.clone();
        *other.pointer_mut(pointer).unwrap() = value;
        other
    };
    let number = |pointer: &str| plan.pointer(pointer).unwrap().as_f64().unwrap();
    let first = "/segments/0/corners/0";
    let control = |point: usize| format!("{first}/control_points/{point}/2");
    for point in 0..5 {
        let moved = json!(number(&control(point)) + 1e-3);
        let fault = read(&changed(&control(point), moved)).unwrap_err();
        assert!(fault.contains("has a rounded corner that does not fit its edges"), "{fault}");
    }
    for (at, says) in [
        (json!(0), "rounds a corner where this is not allowed"),
        (json!(999), "rounds a corner where this is not allowed"),
    ] {
        let fault = read(&changed(&format!("{first}/waypoint"), at)).unwrap_err();
        assert!(fault.contains(says), "{fault}");
    }
    let corners = plan.pointer("/segments/0/corners").unwrap().as_array().unwrap();
    let reversed: Vec<Value> = corners.iter().rev().cloned().collect();
    if reversed.len() > 1 {
        let fault = read(&changed("/segments/0/corners", json!(reversed))).unwrap_err();
        assert!(fault.contains("out of order"), "{fault}");
    }
    // The path stops at the missing corner, so that its times are false.
    let fewer = read(&changed("/segments/0/corners", json!(corners[1..]))).unwrap();
    assert!(!verdict(&fewer).audit.valid);
    let mut slower = plan.clone();
    slower["segments"][0]["pace"] = json!({"velocity": 0.5, "acceleration": 1.0});
    assert!(!verdict(&read(&slower).unwrap()).audit.valid);
    for pace in [json!({"velocity": 0.0}), json!({"acceleration": 1.5}), json!({"tool_m_s": -1.0})] {
        slower["segments"][0]["pace"] = pace;
        assert!(read(&slower).unwrap_err().contains("has an invalid pace: shares of the limits"));
    }
}
