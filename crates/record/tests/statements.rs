//! Statements of a plan file besides its path are measured; one that differs is false, or is named.

use cranny_file::distinct;
use cranny_path::{AuditSettings, Cause, Violation};
use cranny_plan::Unobserved;
use cranny_record::{Judgement, PlanFile, PlanSource, RecordError};
use cranny_scenario::{OpenOptions, Scenario};
use cranny_solve::{Request, Timing, solve};
use cranny_task::{AfterPlacing, PlaceAt, Problem, Segment, Stage, joined};
use serde_json::{Value, json};

fn planned(id: &str, stages: Vec<Stage>) -> (Problem, PlanSource, Value) {
    let scenario = Scenario::open(id, &OpenOptions::default()).unwrap();
    let source = PlanSource { scenario: id.to_owned(), ..PlanSource::default() };
    let problem = scenario.problem(source.margins).unwrap();
    let timing = Some(Timing::default());
    let score = Some(cranny_grasp::ScoreKind::Geometric);
    let request =
        Request { stages, timing, score, robustness: true, least_length: true, ..Request::default() };
    let answer = solve(&problem, &request, &mut Unobserved).unwrap();
    (problem, source.clone(), serde_json::to_value(PlanFile::of(&answer, &source)).unwrap())
}

fn carry() -> Vec<Stage> {
    vec![Stage::pick(), Stage::home()]
}

fn read(plan: &Value) -> Result<PlanFile, RecordError> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("x.plan.json");
    std::fs::write(&file, plan.to_string()).unwrap();
    PlanFile::read(&file)
}

fn changed(plan: &Value, pointer: &str, value: Value) -> Value {
    let mut other = plan.clone();
    *other.pointer_mut(pointer).unwrap() = value;
    other
}

#[test]
fn a_figure_beyond_what_is_measured_is_a_violation() {
    let (problem, source, plan) = planned("021", Vec::new());
    let judge = |plan: &Value, source: &PlanSource| -> Judgement {
        read(plan).unwrap().judge(source, &problem, AuditSettings::default()).unwrap().unwrap()
    };
    let own = judge(&plan, &source);
    assert!(own.audit.valid && own.differs.is_empty(), "{:?}", own.differs);
    assert_eq!(serde_json::to_value(&own.measured).unwrap(), plan);
    assert!(own.compared.contains(&"robustness") && own.not_compared.contains(&"seed"));
    let clearance_m = plan["clearance_m"].as_f64().unwrap();
    let base_m = plan["robustness"]["base"]["translation_m"].as_f64().unwrap() * 1.02;
    let [false_mm, true_mm] = distinct([1.02, 1.0].map(|share| 1e3 * share * clearance_m), 2);
    let [false_base_mm, true_base_mm] = distinct([base_m, base_m / 1.02].map(|m| 1e3 * m), 2);
    let grasp = plan["grasp"].as_u64().unwrap();
    let duration_s = plan["timing"]["duration_s"].as_f64().unwrap();
    let least = plan["least_length"].as_f64().unwrap();
    for (pointer, value, says) in [
        ("/least_length", json!(1.02 * least), "least_length: the file states".to_owned()),
        (
            "/clearance_m",
            json!(1.02 * clearance_m),
            format!("clearance_m: the file states {false_mm} mm, measured {true_mm} mm"),
        ),
        (
            "/robustness/base/translation_m",
            json!(base_m),
            format!(
                "robustness.base.translation_m: the file states {false_base_mm} mm, measured {true_base_mm} mm"
            ),
        ),
        ("/robustness/base", Value::Null, "robustness.base: the file states nothing".into()),
        ("/outcome", json!("gave-up"), "outcome: the file states \"gave-up\", measured \"solved\"".into()),
        (
            "/path_length",
            json!(1.0),
            format!(
                "path_length: the file states 1.00, measured {:.2}",
                plan["path_length"].as_f64().unwrap()
            ),
        ),
        ("/grasp", json!(grasp + 1), format!("grasp: the file states {}, measured {grasp}", grasp + 1)),
        (
            "/timing/duration_s",
            json!(0.5),
            format!("timing.duration_s: the file states 0.50 s, measured {duration_s:.2} s"),
        ),
        ("/timing/method", json!("time-optimal"), "timing.duration_s: the file states".into()),
    ] {
        let other = changed(&plan, pointer, value);
        let found = judge(&other, &source);
        let violations: Vec<String> = found.audit.violations.iter().map(ToString::to_string).collect();
        assert!(
            !found.audit.valid && violations.iter().any(|line| line.starts_with(&says)),
            "{says}: {violations:?}"
        );
        // In another task no statement is false, but all differences are named.
        let task = PlanSource { scenario: "mine".to_owned(), ..source.clone() };
        let found = judge(&other, &task);
        let named = |statement: &dyn std::fmt::Display| statement.to_string().starts_with(&says);
        assert!(found.audit.valid && found.differs.iter().any(|statement| named(statement)), "{says}");
    }
    // A smaller bound is true.
    let found = judge(&changed(&plan, "/clearance_m", json!(-clearance_m)), &source);
    assert!(found.audit.valid && found.differs[0].key == "clearance_m");
    assert_eq!(found.measured.clearance_m, Some(clearance_m));
}

/// A figure stays false regardless of the other statements of a file, unless they are of another task.
#[test]
fn what_is_left_out_makes_no_other_statement_true() {
    let (problem, source, plan) = planned("035", carry());
    let judge = |plan: &Value| -> Judgement {
        read(plan).unwrap().judge(&source, &problem, AuditSettings::default()).unwrap().unwrap()
    };
    let keys = |found: &Judgement| -> Vec<String> {
        let keys = |violation: &Violation| match &violation.cause {
            Cause::Statement { key, .. } => key.clone(),
            other => panic!("{other:?}"),
        };
        found.audit.violations.iter().map(keys).collect()
    };
    let pairs = plan["not_checked"].as_array().unwrap().clone();
    assert!(!pairs.is_empty());
    let lie = changed(&plan, "/clearance_m", json!(0.5));
    // Each missing pair is one more false statement.
    for (left, count) in [(json!([]), pairs.len()), (json!(pairs[1..]), 1)] {
        let found = judge(&changed(&lie, "/not_checked", left));
        assert_eq!(keys(&found), [vec!["not_checked"; count], vec!["clearance_m"]].concat());
    }
    // An extra pair, or one of greater depth, is not a false statement.
    let mut more = pairs.clone();
    more.push(json!({"first": "a", "second": "b", "depth_m": 0.1, "reason": "always-touching"}));
    let found = judge(&changed(&lie, "/not_checked", json!(more)));
    assert_eq!(
        (keys(&found), &*found.differs[0].key),
        (vec!["clearance_m".to_owned()], &*format!("not_checked[{}]", pairs.len()))
    );
    for (allowance_m, is_false) in [(1e-6, true), (1.0, false)] {
        let found = judge(&changed(&lie, "/not_checked/0/allowance_m", json!(allowance_m)));
        assert_eq!(keys(&found).len(), 1 + usize::from(is_false), "{allowance_m}");
    }
    // A key without bearing on a clearance changes no task.
    for (key, value) in [("goal_threshold", json!(1.0)), ("grasps", json!("gone.csv"))] {
        let mut other = lie.clone();
        other[key] = value;
        let found = judge(&other);
        assert_eq!((keys(&found), &*found.differs[0].key), (vec!["clearance_m".to_owned()], key));
    }
    let another = (plan["grasp"].as_u64().unwrap() + 1) % 200;
    let mut other = changed(&plan, "/grasp", json!(another));
    assert_eq!(keys(&judge(&other)), ["grasp"]);
    other["grasps"] = json!("gone.csv");
    assert!(judge(&other).audit.valid);
}

/// Bounds for which nothing was measured are not true, except that nothing is near.
#[test]
fn invented_bounds_are_false() {
    let placing = Stage::put_down(PlaceAt::named("outside"), AfterPlacing::Home);
    let (problem, source, carried) = planned("012", placing);
    let (reaching, reach_source, reach) = planned("021", Vec::new());
    assert!(carried["least_length"].is_null() && reach["hold_demanded"].is_null());
    let keys = |plan: &Value, key: &str, (source, problem): (&PlanSource, &Problem)| -> Vec<String> {
        let mut plan = plan.clone();
        plan[key] = json!(0.1);
        let found = read(&plan).unwrap().judge(source, problem, AuditSettings::default()).unwrap().unwrap();
        found.audit.violations.iter().map(|violation| violation.kind().to_owned()).collect()
    };
    assert_eq!(keys(&carried, "least_length", (&source, &problem)), ["statement"]);
    assert_eq!(keys(&reach, "hold_demanded", (&reach_source, &reaching)), ["statement"]);
}

/// A demanded hold is measured without a stated factor, and counts in a scenario of another name.
#[test]
fn a_demanded_hold_is_measured() {
    let (problem, source, plan) = planned("012", carry());
    let elsewhere = PlanSource { scenario: "a copy".to_owned(), ..source.clone() };
    let mut plan = changed(&plan, "/hold", Value::Null);
    for (demanded, is_met) in [(0.1, true), (50.0, false)] {
        plan["hold_demanded"] = json!(demanded);
        for source in [&source, &elsewhere] {
            let judged =
                read(&plan).unwrap().judge(source, &problem, AuditSettings::default()).unwrap().unwrap();
            assert_eq!(judged.audit.valid, is_met, "{demanded} in {}", source.scenario);
            assert_eq!(judged.demanded.hold, Some(demanded));
        }
    }
}

/// A bound larger than the measured one is not proven, even by the smallest amount.
#[test]
fn a_bound_holds_to_the_last_digit() {
    let (problem, source, plan) = planned("021", Vec::new());
    for pointer in [
        "/clearance_m",
        "/robustness/base/translation_m",
        "/robustness/object/rotation_rad",
        "/robustness/joints/turning_rad",
    ] {
        let truth = plan.pointer(pointer).unwrap().as_f64().unwrap();
        for (factor, is_valid) in
            [(1.0 - 1e-6, true), (1.0 + 1e-12, true), (1.0 + 1e-6, false), (1.05, false)]
        {
            let other = read(&changed(&plan, pointer, json!(truth * factor))).unwrap();
            let found = other.judge(&source, &problem, AuditSettings::default()).unwrap().unwrap();
            assert_eq!(found.audit.valid, is_valid, "{pointer} {factor}");
        }
    }
}

/// A robot of two links that touch near their joint at some of its values, and a goal 0.3 rad from its start.
const ELBOW: &str = r#"<robot name="elbow"><link name="root"/>
  <link name="upper"><collision><origin xyz="-0.215 0 0"/><geometry><box size="0.37 0.1 0.1"/></geometry></collision></link>
  <link name="lower"><collision><origin xyz="0.2 0 0"/><geometry><box size="0.4 0.1 0.1"/></geometry></collision></link>
  <link name="tip"/>
  <joint name="f" type="fixed"><parent link="root"/><child link="upper"/></joint>
  <joint name="r" type="revolute"><parent link="upper"/><child link="lower"/><axis xyz="0 0 1"/>
    <limit lower="-1.6" upper="1.6" velocity="1" effort="1"/></joint>
  <joint name="t" type="fixed"><parent link="lower"/><child link="tip"/></joint></robot>"#;

/// A planner that compares more pairs than the audit leaves them out of the list: the audit then compares them too.
#[test]
fn pairs_that_a_plan_leaves_out_are_compared() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let (sine, cosine) = (libm::sin(0.3), libm::cos(0.3));
    write("elbow.urdf", ELBOW);
    write("grasps.csv", &format!("{cosine},-{sine},0,0,{sine},{cosine},0,0,0,0,1,0,0,0,0,1\n"));
    write(
        "scenario.yaml",
        "robot: elbow.urdf\nfloor: null\nstart: [0.0]\ntip: tip\nobstacles:\n  - name: far\n    pose: {position: [50, 50, \
         50]}\n    shapes:\n      - sphere: {radius: 0.01}\n",
    );
    let scenario = Scenario::open(folder.path().to_str().unwrap(), &OpenOptions::default()).unwrap();
    let source = PlanSource { scenario: scenario.id.clone(), ..PlanSource::default() };
    let problem = scenario.problem(source.margins).unwrap();
    let plan = |problem: &Problem| {
        let answer = solve(problem, &Request::default(), &mut Unobserved).unwrap();
        assert!(answer.is_solved());
        PlanFile::of(&answer, &source)
    };
    let judge = |plan: &PlanFile| plan.judge(&source, &problem, AuditSettings::default()).unwrap().unwrap();
    let (own, strict) = (plan(&problem), plan(&problem.clone().checking_all_pairs()));
    assert!(own.not_checked[0].can_be_checked() && strict.not_checked.is_empty());
    for plan in [&own, &strict] {
        let found = judge(plan);
        assert!(found.audit.valid && found.differs.is_empty(), "{:?}", found.audit.violations);
        assert_eq!(found.audit.not_checked, plan.not_checked);
    }
    // A path on which they touch was not compared with them.
    let mut bent = own;
    bent.waypoints.insert(1, vec![1.57]);
    bent.waypoints.insert(2, vec![0.0]);
    let segments = vec![Segment::reach(bent.waypoints.clone(), Vec::new())];
    bent = PlanFile { segments, not_checked: Vec::new(), ..bent };
    let found = judge(&bent);
    let lie = "not_checked: the file states nothing, measured";
    assert!(
        found.audit.violations.iter().any(|violation| violation.to_string().starts_with(lie)),
        "{found:?}"
    );
}

#[test]
fn ends_and_times_that_no_path_can_have_are_refused() {
    let (_, _, plan) = planned("035", carry());
    assert!(read(&plan).is_ok());
    let refused = |other: Value, says: &str| {
        let fault = read(&other).unwrap_err().to_string();
        assert!(fault.contains("x.plan.json") && fault.contains(says), "{fault}");
    };
    refused(changed(&plan, "/task/1/move", json!([])), "has a move without a configuration");
    refused(changed(&plan, "/task/1/move", json!([[0.0]])), "has a move without a configuration");
    refused(
        changed(&plan, "/task/1", json!({"move": "away"})),
        "'move' is 'home', 'clear', configurations or a region",
    );
    refused(changed(&plan, "/task/1", json!({"move": "home", "place": "x"})), "a stage has one of");
    refused(
        changed(&plan, "/task/0", json!({"pick": "target", "clear_m": 0.1})),
        "'clear_m' belongs to a stage with 'place'",
    );
    refused(changed(&plan, "/format", Value::Null), "no 'format'");
    refused(changed(&plan, "/geometry", json!("true")), "its 'geometry' is 'true'");
    for pointer in [
        "",
        "/margins",
        "/budget",
        "/statistics",
        "/timing",
        "/robustness",
        "/robustness/base",
        "/segments/1",
    ] {
        let mut other = plan.clone();
        other.pointer_mut(pointer).unwrap()["clearence_m"] = json!(1);
        refused(other, "clearence_m");
    }
    let mut failed = plan;
    failed["failures"] = json!([{"grasp": 1, "reason": "no-ik", "attempts": 3, "clearence_m": 1}]);
    refused(failed, "clearence_m");
}

/// Radii, states of the hand and figures are not computed for such a path, which takes minutes.
#[test]
fn a_plan_beyond_a_joint_limit_is_refused_before_any_figure_is_measured() {
    for (stages, segment) in [(Vec::new(), 0), (carry(), 1)] {
        let (problem, source, plan) = planned("021", stages);
        let mut plan = read(&plan).unwrap();
        let way_point = plan.segments[segment].waypoints.last_mut().unwrap();
        way_point[2] = 1e6;
        if let Some(next) = plan.segments.get_mut(segment + 1) {
            next.waypoints[0][2] = 1e6;
        }
        plan.segments.iter_mut().for_each(|segment| segment.corners.clear());
        plan.waypoints = joined(&plan.segments);
        let found = plan.judge(&source, &problem, AuditSettings::default()).unwrap().unwrap();
        let kinds: Vec<_> = found.audit.violations.iter().map(Violation::kind).collect();
        assert_eq!((kinds, found.audit.valid), (vec!["joint-limit"], false));
        assert!(found.measured.robustness.is_none());
        assert_eq!(plan.audit(&problem, AuditSettings::default()).unwrap().unwrap(), found.audit);
    }
}
