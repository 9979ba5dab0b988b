//! Statements of a plan file besides its path are measured; one that differs is false, or is named.

use cranny_plan::{AuditSettings, CarryEnd, Problem, Unobserved};
use cranny_scenario::{Judgement, OpenOptions, PlanFile, PlanSource, Scenario, ScenarioError};
use cranny_solve::{Carry, Request, Timing, solve};
use serde_json::{Value, json};

fn planned(id: &str, end: Option<CarryEnd>) -> (Problem, PlanSource, Value) {
    let scenario = Scenario::open(id, &OpenOptions::default()).unwrap();
    let source = PlanSource { scenario: id.to_owned(), ..PlanSource::default() };
    let problem = scenario.problem(source.margins).unwrap();
    let carry = end.map(|end| Carry { end, ..Carry::default() });
    let timing = Some(Timing::default());
    let request = Request { carry, timing, robustness: true, ..Request::default() };
    let answer = solve(&problem, &request, &mut Unobserved).unwrap();
    (problem, source.clone(), serde_json::to_value(PlanFile::of(&answer, &source)).unwrap())
}

fn read(plan: &Value) -> Result<PlanFile, ScenarioError> {
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
    let (problem, source, plan) = planned("021", None);
    let judge = |plan: &Value, source: &PlanSource| -> Judgement {
        read(plan).unwrap().judge(source, &problem, AuditSettings::default()).unwrap().unwrap()
    };
    let own = judge(&plan, &source);
    assert!(own.audit.valid && own.differs.is_empty(), "{:?}", own.differs);
    assert_eq!(serde_json::to_value(&own.measured).unwrap(), plan);
    assert!(own.compared.contains(&"robustness") && own.not_compared.contains(&"seed"));
    let clearance_m = plan["clearance_m"].as_f64().unwrap();
    for (pointer, value, says) in [
        ("/clearance_m", json!(0.00509), "clearance_m: the file states 5.09 mm, measured 4.96 mm"),
        (
            "/robustness/base/translation_m",
            json!(0.01898),
            "robustness.base.translation_m: the file states 18.98 mm",
        ),
        ("/robustness/base", Value::Null, "robustness.base: the file states nothing"),
        ("/outcome", json!("gave-up"), "outcome: the file states \"gave-up\", measured \"solved\""),
        ("/path_length", json!(1.0), "path_length: the file states 1.00, measured 2.97"),
        ("/grasp", json!(8), "grasp: the file states 8, measured 7"),
        ("/timing/duration_s", json!(0.5), "timing.duration_s: the file states 0.50 s, measured 2.16 s"),
        ("/timing/method", json!("jerk-limited"), "timing.duration_s: the file states"),
    ] {
        let other = changed(&plan, pointer, value);
        let found = judge(&other, &source);
        let violations: Vec<String> = found.audit.violations.iter().map(ToString::to_string).collect();
        assert!(
            !found.audit.valid && violations.iter().any(|line| line.starts_with(says)),
            "{says}: {violations:?}"
        );
        // In another task nothing is false, but all is named.
        let task = PlanSource { scenario: "mine".to_owned(), ..source.clone() };
        let found = judge(&other, &task);
        let named = |statement: &dyn std::fmt::Display| statement.to_string().starts_with(says);
        assert!(found.audit.valid && found.differs.iter().any(|statement| named(statement)), "{says}");
    }
    // A smaller bound is true.
    let found = judge(&changed(&plan, "/clearance_m", json!(-clearance_m)), &source);
    assert!(found.audit.valid && found.differs[0].key == "clearance_m");
    assert_eq!(found.measured.clearance_m, Some(clearance_m));
}

#[test]
fn ends_and_times_that_no_path_can_have_are_refused() {
    let (_, _, plan) = planned("035", Some(CarryEnd::Home));
    assert!(read(&plan).is_ok());
    let refused = |other: Value, says: &str| {
        let fault = read(&other).unwrap_err().to_string();
        assert!(fault.contains("x.plan.json") && fault.contains(says), "{fault}");
    };
    refused(changed(&plan, "/timing/blended", json!(true)), "corners are not cut where an object is carried");
    refused(changed(&plan, "/carry_to", json!([])), "names no configuration");
    refused(changed(&plan, "/carry_to/0", json!([0.0])), "has a configuration without");
    let mut two = plan.clone();
    two["carry_clear_m"] = json!(0.05);
    refused(two.clone(), "states more than one");
    two["carry_to"] = Value::Null;
    two["carry_clear_m"] = json!(-1.0);
    refused(two, "is no clearance");
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
