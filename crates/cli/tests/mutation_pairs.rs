//! Mutations of a false statement of a plan and of every other key: the statement stays false, or the plan is of another task.

use cranny_scenario::STEPS;
use cranny_spatial::Stream;
use cranny_task::Stage;
use serde_json::{Value, json};

use crate::mutation::{PlanReader, other_values};

/// Keys that state the task of a plan: with another value, all figures are of another task.
const TASK: [&str; 5] = ["scenario", "robot", "geometry", "criterion", "margins"];

/// Figures that depend on the set of grasps; only for them does another set make another task.
const OF_GRASPS: [&str; 3] = ["grasp", "translation_error_m", "rotation_error_rad"];

/// Returns false statements of a plan: a pointer to the value, and a false value.
fn lies() -> Vec<(&'static str, Value)> {
    vec![
        ("/clearance_m", json!(0.5)),
        ("/clearances_per_edge_m/0", json!(0.5)),
        ("/segments/0/clearances_m/0", json!(0.5)),
        ("/robustness/base/translation_m", json!(1.0)),
        ("/timing/duration_s", json!(0.1)),
        ("/path_length", json!(0.01)),
        ("/not_checked", json!([])),
        ("/outcome", json!("gave-up")),
        ("/grasp", json!(0)),
        ("/translation_error_m", json!(-1.0)),
        ("/rotation_error_rad", json!(-1.0)),
    ]
}

/// Number of pairs by the effect of the false statement.
#[derive(Debug, Default)]
struct Counts {
    /// Reported as a violation.
    violation: usize,
    /// File refused for another reason.
    refused: usize,
    /// Listed, with the plan being of another task.
    other_task: usize,
}

/// Returns every change of a key: its value removed, emptied, or replaced at the first leaf.
fn changes_of(value: &Value) -> Vec<Option<Value>> {
    let mut found = vec![None, Some(Value::Null), Some(json!([])), Some(json!({}))];
    let mut path = String::new();
    let mut leaf = value;
    loop {
        let next = match leaf {
            Value::Object(entries) => entries.iter().next().map(|(key, inner)| (key.clone(), inner)),
            Value::Array(list) => list.first().map(|inner| ("0".to_owned(), inner)),
            _ => None,
        };
        let Some((step, inner)) = next else { break };
        path = format!("{path}/{step}");
        leaf = inner;
    }
    for (_, other) in other_values(leaf) {
        let mut changed = value.clone();
        *changed.pointer_mut(&path).unwrap() = other;
        found.push(Some(changed));
    }
    found.retain(|change| change.as_ref() != Some(value));
    found
}

/// Checks a sampled change of each of at most `most` pairs, preferably one that can be read; in a long run, all changes of all.
fn check(name: &str, reader: &PlanReader, whole: &Value, most: usize) -> Vec<String> {
    let is_long = std::env::var_os("CRANNY_LONG").is_some();
    let mut stream = Stream::new(49, 0);
    let mut pairs = Vec::new();
    for (pointer, lie) in lies() {
        // A plan without the key, or with the same value, states nothing false.
        if whole.pointer(pointer).is_none_or(|truth| *truth == lie) {
            continue;
        }
        let own = pointer.split('/').nth(1).unwrap();
        let others = whole.as_object().unwrap().iter().filter(|(key, _)| *key != own);
        pairs.extend(others.map(|(key, value)| (pointer, own, lie.clone(), key, value)));
    }
    let all = pairs.len();
    while !is_long && pairs.len() > most {
        pairs.swap_remove(stream.index(pairs.len()));
    }
    let (mut counts, mut silent) = (Counts::default(), Vec::new());
    for (pointer, own, lie, key, value) in &pairs {
        let mut changes = changes_of(value);
        let first = stream.index(changes.len());
        changes.rotate_left(first);
        let mut is_read = false;
        for change in changes {
            let mut document = whole.clone();
            *document.pointer_mut(pointer).unwrap() = lie.clone();
            match &change {
                Some(change) => document[key.as_str()] = change.clone(),
                None => drop(document.as_object_mut().unwrap().remove(*key)),
            }
            let Some(text) = reader.read(&document.to_string()) else { continue };
            is_read = true;
            match effect(&text, own, key) {
                Some(Effect::Violation) => counts.violation += 1,
                Some(Effect::Refused) => counts.refused += 1,
                Some(Effect::OtherTask) => counts.other_task += 1,
                None => silent.push(format!("{name}: {pointer} with {key}: {change:?}")),
            }
            if !is_long {
                break;
            }
        }
        counts.refused += usize::from(!is_read);
    }
    println!("{name}: {} of {all} pairs: {counts:?}, silent: {silent:?}", pairs.len());
    silent
}

enum Effect {
    Violation,
    Refused,
    OtherTask,
}

/// Returns the effect, by a verdict as text, of the false statement of `own` if `key` is changed too; `None` if it is trusted.
fn effect(text: &str, own: &str, key: &str) -> Option<Effect> {
    let (_, text) = text.split_at(text.find(['[', '{'])?);
    let verdict: Value = serde_json::from_str(text).unwrap();
    // The verdict on a plan is listed with the files that it names.
    let whole = verdict.get(0).unwrap_or(&verdict);
    let names =
        |row: &Value| row["key"].as_str().is_some_and(|named| named.split(['.', '[']).next() == Some(own));
    let has = |list: &str| whole[list].as_array().into_iter().flatten().any(names);
    let is_other_task = TASK.contains(&key) || key == "grasps" && OF_GRASPS.contains(&own);
    if whole["valid"] == false {
        Some(if has("violations") { Effect::Violation } else { Effect::Refused })
    } else {
        (is_other_task && has("differs")).then_some(Effect::OtherTask)
    }
}

#[test]
fn no_false_statement_becomes_trusted_because_another_key_is_changed() {
    let folder = tempfile::tempdir().unwrap();
    let reach = PlanReader::new("021", folder.path());
    let mut silent = check("a reach", &reach, &reach.plan(Vec::new(), false), 400);
    let place = PlanReader::new("012", folder.path());
    let whole = place.plan(vec![Stage::pick(), Stage::place("outside"), Stage::home()], false);
    silent.extend(check("a place", &place, &whole, 120));
    let steps = PlanReader::new("235", folder.path());
    let whole = steps.plan(steps.scenario.task(STEPS).unwrap().stages.clone(), false);
    silent.extend(check("steps", &steps, &whole, 40));
    assert!(silent.is_empty(), "{silent:#?}");
}
