//! Plans of earlier formats are read and audited as when they were written.

use cranny_path::{AuditSettings, Violation};
use cranny_record::{Judgement, PlanFile, PlanSource, RecordError};
use cranny_scenario::{OpenOptions, Scenario};
use serde_json::{Value, json};

const PLANS: [(&str, &str, &str); 6] = [
    ("021", "a reach", include_str!("plans/reach.json")),
    ("021", "cut corners", include_str!("plans/blended.json")),
    ("035", "a carry", include_str!("plans/carry.json")),
    ("015", "a carry out", include_str!("plans/out.json")),
    ("012", "a place", include_str!("plans/place.json")),
    ("235", "steps", include_str!("plans/steps.json")),
];

fn plan(name: &str) -> Value {
    let (_, _, text) = PLANS.iter().find(|(_, known, _)| *known == name).expect("a plan of that name");
    serde_json::from_str(text).expect("a plan is JSON")
}

fn read(plan: &Value) -> Result<PlanFile, RecordError> {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("old.plan.json");
    std::fs::write(&file, plan.to_string()).expect("written");
    PlanFile::read(&file)
}

fn judged(plan: &Value) -> Judgement {
    let plan = read(plan).expect("a plan");
    let scenario = Scenario::open(&plan.scenario, &OpenOptions::default()).expect("a scenario");
    let problem = scenario.problem(plan.margins).expect("a problem");
    let source = PlanSource { scenario: scenario.id.clone(), margins: plan.margins, ..PlanSource::default() };
    let source = plan.source_in(&scenario, &source);
    plan.judge(&source, &problem, AuditSettings::default()).expect("a verdict").expect("a path")
}

#[test]
fn plans_of_every_earlier_format_are_read_and_hold() {
    for (id, name, text) in PLANS {
        let judgement = judged(&serde_json::from_str(text).expect("JSON"));
        assert!(judgement.audit.valid, "{name}: {:?}", judgement.audit.violations);
        assert!(judgement.differs.is_empty(), "{name}: {:?}", judgement.differs);
        assert_eq!(judgement.measured.scenario, id);
        // Written in the present format it has the same contents.
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("new.plan.json");
        judgement.measured.write(&file).expect("written");
        assert_eq!(PlanFile::read(&file).expect("a plan"), judgement.measured);
    }
    // Before there was any format, a plan consisted of its way points.
    let mut oldest = plan("a reach");
    for key in ["format", "segments"] {
        oldest.as_object_mut().expect("a plan").remove(key);
    }
    assert!(judged(&oldest).audit.valid);
}

#[test]
fn lies_in_plans_of_earlier_formats_are_seen() {
    for (name, pointer, lie, kind) in [
        ("a reach", "/clearance_m", json!(0.5), "statement"),
        ("a carry", "/timing/closing_s/0", json!(0.1), "statement"),
        ("a carry", "/segments/1/attached", json!("floor"), "grip"),
        ("a carry out", "/carry_clear_m", json!(0.9), "goal"),
        ("a place", "/place/clear_m", json!(0.2), "retreat"),
        ("a place", "/place/then", json!("home"), "goal"),
        ("steps", "/duration_s", json!(1.0), "statement"),
        ("steps", "/steps/1/clearance_m", json!(0.5), "statement"),
        ("steps", "/steps/1/own_grasp/score", json!(1.0), "grip"),
        ("steps", "/steps/2/place/name", json!("other side"), "goal"),
    ] {
        let mut other = plan(name);
        *other.pointer_mut(pointer).expect(pointer) = lie;
        let judgement = judged(&other);
        let kinds: Vec<&str> = judgement.audit.violations.iter().map(Violation::kind).collect();
        assert!(kinds.contains(&kind), "{name}, {pointer}: {kinds:?}");
    }
    let mut short = plan("steps");
    short["steps"].as_array_mut().expect("steps").pop();
    assert!(!judged(&short).audit.valid, "two of three steps");
}

#[test]
fn what_is_no_plan_of_an_earlier_format_is_refused() {
    let refused = |plan: &Value, says: &str| {
        let fault = read(plan).expect_err(says).to_string();
        assert!(fault.contains("old.plan.json") && fault.contains(says), "{fault}");
    };
    let changed = |name: &str, pointer: &str, value: Value| {
        let mut other = plan(name);
        *other.pointer_mut(pointer).expect(pointer) = value;
        other
    };
    refused(&changed("a carry", "/format", Value::Null), "no 'format'");
    refused(&changed("a carry", "/carry_to", json!([])), "has a move without a configuration");
    let mut two = plan("a carry");
    two["carry_clear_m"] = json!(0.05);
    refused(&two, "more than one");
    refused(&changed("steps", "/steps/1/scenario", json!("021")), "step 2 states another scenario");
    refused(&changed("steps", "/steps/2/criterion", json!("paper")), "step 3 states another criterion");
    refused(&changed("steps", "/steps/0/format", json!("cranny-plan/2")), "not of format 'cranny-plan/1'");
    refused(&changed("steps", "/steps", json!(3)), "it has no steps");
    refused(&changed("steps", "/steps/0/planner", json!(1)), "invalid type");
    refused(&changed("steps", "/steps/2/margins/margin_m", json!(0.02)), "step 3 states another margin_m");
    let mut more = plan("steps");
    more["speed"] = json!(2);
    refused(&more, "unknown field `speed`");
}
