//! Conversion of plans of earlier formats to the present one.

use std::collections::HashSet;

use cranny_scenario::STEPS;
use serde_json::{Map, Value, json};

use crate::PlanFile;

/// Format before stages: at most one carry or place.
pub(crate) const FIRST: &str = "cranny-plan/1";
/// List of plans of that format, one for each pick of a scenario.
pub(crate) const SEQUENCE: &str = "cranny-sequence/1";

/// Converts a plan of the first format, or one of the time before formats, to the present format.
///
/// # Errors
/// A sentence: segments without a format, or several ends.
pub(crate) fn of_first(plan: &mut Map<String, Value>) -> Result<(), String> {
    let had_format =
        plan.insert("format".into(), PlanFile::FORMAT.into()).is_some_and(|format| !format.is_null());
    let has_segments = plan.get("segments").and_then(Value::as_array).is_some_and(|list| !list.is_empty());
    let has_path = plan.get("waypoints").and_then(Value::as_array).is_some_and(|list| !list.is_empty());
    if !had_format && has_segments {
        return Err(format!("it has segments, but no 'format' ('{FIRST}')"));
    }
    if !had_format && has_path {
        let segment = json!({
            "kind": "polyline", "mode": "reach", "attached": null, "opening_m": null,
            "waypoints": plan["waypoints"],
            "clearances_m": plan.get("clearances_per_edge_m").cloned().unwrap_or_else(|| json!([])),
        });
        plan.insert("segments".into(), json!([segment]));
    }
    let end = take(plan, "carry_to");
    let clear_m = take(plan, "carry_clear_m");
    let place = take(plan, "place");
    if [&end, &clear_m, &place].into_iter().flatten().count() > 1 {
        return Err("of 'carry_to', 'carry_clear_m' and 'place' it states more than one".to_owned());
    }
    let task = match (end, clear_m, place) {
        (Some(ends), _, _) => vec![json!({"pick": "target"}), json!({"move": ends})],
        (_, Some(clear_m), _) => {
            vec![json!({"pick": "target"}), json!({"move": "clear", "clear_m": clear_m})]
        }
        (_, _, Some(place)) => {
            let stage = json!({"place": place["name"], "clear_m": place["clear_m"]});
            let home = (place["then"] == "home").then(|| json!({"move": "home"}));
            [json!({"pick": "target"}), stage].into_iter().chain(home).collect()
        }
        _ => Vec::new(),
    };
    for segment in plan.get_mut("segments").and_then(Value::as_array_mut).into_iter().flatten() {
        let stage = match segment["mode"].as_str() {
            Some("carry" | "set-down" | "retreat") => 1,
            Some("return") => 2,
            _ => 0,
        };
        if let Some(keys) = segment.as_object_mut() {
            keys.insert("stage".into(), stage.into());
        }
    }
    plan.insert("task".into(), task.into());
    if let Some(timing) = plan.get_mut("timing").and_then(Value::as_object_mut) {
        let motions = ["closing_s", "opening_s"].into_iter().filter_map(|key| take(timing, key));
        let motions: Vec<Value> = motions.collect();
        timing.insert("hand_s".into(), motions.into());
    }
    Ok(())
}

fn take(keys: &mut Map<String, Value>, key: &str) -> Option<Value> {
    keys.remove(key).filter(|value| !value.is_null())
}

/// Joins the plans of a list to one plan.
///
/// # Errors
/// A sentence that names the fault of the list.
pub(crate) fn of_sequence(mut sequence: Map<String, Value>) -> Result<Map<String, Value>, String> {
    let Some(Value::Array(steps)) = sequence.remove("steps") else {
        return Err("it has no steps".to_owned());
    };
    let scenario = sequence.remove("scenario").unwrap_or_default();
    let stated_s = sequence.remove("duration_s").unwrap_or_default();
    sequence.remove("format");
    if let Some(key) = sequence.keys().next() {
        return Err(format!("unknown field `{key}`"));
    }
    let mut whole: Option<Map<String, Value>> = None;
    for (number, step) in steps.into_iter().enumerate() {
        let Value::Object(mut step) = step else { return Err(format!("step {} is no plan", number + 1)) };
        if step.get("format").and_then(Value::as_str) != Some(FIRST) {
            return Err(format!("the plan of step {} is not of format '{FIRST}'", number + 1));
        }
        of_first(&mut step)?;
        // The target of a plan is the object that it picks.
        if let Some(object) = picked(&step) {
            step["task"][0] = json!({"pick": object});
        }
        whole = Some(match whole {
            Some(before) => joined(before, step, number + 1)?,
            None if step.get("scenario") != Some(&scenario) => return Err(disagreement("scenario", 1)),
            None => step,
        });
    }
    let mut whole = whole.ok_or("it has no steps")?;
    whole.insert("task_name".into(), STEPS.into());
    if let Some(timing) = whole.get_mut("timing").and_then(Value::as_object_mut) {
        timing.insert("duration_s".into(), stated_s);
    }
    Ok(whole)
}

/// Returns the name of the object that a plan states to have in the hand.
fn picked(plan: &Map<String, Value>) -> Option<String> {
    let segments = plan.get("segments")?.as_array()?;
    segments.iter().find_map(|segment| Some(segment["attached"].as_str()?.to_owned()))
}

fn disagreement(key: &str, step: usize) -> String {
    format!("step {step} states another {key} than the plan, or the steps before it")
}

/// Keys that the plans of one list share.
const SHARED: [&str; 5] = ["scenario", "robot", "geometry", "criterion", "joint_names"];

/// Joins a plan and the next one of the list.
fn joined(
    mut whole: Map<String, Value>,
    mut next: Map<String, Value>,
    number: usize,
) -> Result<Map<String, Value>, String> {
    if let Some(key) = SHARED.into_iter().find(|key| whole.get(*key) != next.get(*key)) {
        return Err(disagreement(key, number));
    }
    let margins = ["margin_m", "grasp_margin_m"];
    if let Some(key) = margins.into_iter().find(|key| whole["margins"][key] != next["margins"][key]) {
        return Err(disagreement(key, number));
    }
    let list = |plan: &Map<String, Value>, key: &str| {
        plan.get(key).and_then(Value::as_array).cloned().unwrap_or_default()
    };
    let first_stage = whole.get("task").and_then(Value::as_array).map_or(0, Vec::len);
    let of_pick = ["grasp", "translation_error_m", "rotation_error_rad", "own_grasp"];
    let has_path = !list(&next, "waypoints").is_empty();
    if has_path {
        let mut pick: Map<String, Value> =
            of_pick.into_iter().filter_map(|key| Some((key.to_owned(), next.get(key)?.clone()))).collect();
        pick.insert("stage".into(), first_stage.into());
        append(&mut whole, "picks", [pick.into()]);
    }
    for segment in next.get_mut("segments").and_then(Value::as_array_mut).into_iter().flatten() {
        let stage = segment["stage"].as_u64().unwrap_or_default();
        segment["stage"] = (stage + first_stage as u64).into();
    }
    let mut task = list(&next, "task");
    let margin = &next["margins"]["object_margin_m"];
    if let Some(pick) = task.first_mut().filter(|_| !margin.is_null()) {
        pick["object_margin_m"] = margin.clone();
    }
    append(&mut whole, "task", task);
    append(&mut whole, "waypoints", list(&next, "waypoints").into_iter().skip(1));
    for key in ["segments", "clearances_per_edge_m"] {
        append(&mut whole, key, list(&next, key));
    }
    let mut new = list(&next, "not_checked");
    let known = whole.get("not_checked").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    let known: HashSet<&Value> = known.iter().collect();
    new.retain(|pair| !known.contains(pair));
    append(&mut whole, "not_checked", new);
    if has_path {
        let least = [&whole, &next].map(|plan| plan.get("clearance_m").and_then(Value::as_f64));
        let least = least.into_iter().flatten().reduce(f64::min);
        whole.insert("clearance_m".into(), least.map_or(Value::Null, Value::from));
        let length = [&whole, &next].map(|plan| plan["path_length"].as_f64().unwrap_or_default());
        whole.insert("path_length".into(), (length[0] + length[1]).into());
        let timing = timing_of(whole.remove("timing"), next.get("timing"));
        whole.insert("timing".into(), timing.unwrap_or_default());
        let robustness = least_of(whole.get("robustness"), next.get("robustness"));
        whole.insert("robustness".into(), robustness);
    }
    for key in ["outcome", "failures", "no_grasp", "refused", "goal_faults"] {
        match next.remove(key) {
            Some(value) => whole.insert(key.into(), value),
            None => whole.remove(key),
        };
    }
    let statistics = next.remove("statistics").unwrap_or_default();
    for (key, value) in whole.get_mut("statistics").and_then(Value::as_object_mut).into_iter().flatten() {
        let sum = match (value.as_u64(), statistics[key].as_u64()) {
            (Some(a), Some(b)) => (a + b).into(),
            _ => (value.as_f64().unwrap_or_default() + statistics[key].as_f64().unwrap_or_default()).into(),
        };
        *value = sum;
    }
    Ok(whole)
}

/// Appends values to a list, which is empty if it is missing.
fn append(plan: &mut Map<String, Value>, key: &str, values: impl IntoIterator<Item = Value>) {
    let entry = plan.entry(key).or_insert_with(|| Value::Array(Vec::new()));
    if !entry.is_array() {
        *entry = Value::Array(Vec::new());
    }
    if let Some(list) = entry.as_array_mut() {
        list.extend(values);
    }
}

/// Joins the times of a plan and of one that begins where it ends.
fn timing_of(before: Option<Value>, next: Option<&Value>) -> Option<Value> {
    let Value::Object(mut timing) = before? else { return None };
    let (next, begin_s) = (next?.as_object()?, timing.get("duration_s")?.as_f64()?);
    let later = |value: &Value| Some(Value::from(begin_s + value.as_f64()?));
    let times =
        next.get("waypoint_times_s")?.as_array()?.iter().skip(1).map(later).collect::<Option<Vec<_>>>()?;
    let motion =
        |pair: &Value| Some(Value::from(pair.as_array()?.iter().map(later).collect::<Option<Vec<_>>>()?));
    let motions = next.get("hand_s")?.as_array()?.iter().map(motion).collect::<Option<Vec<_>>>()?;
    timing.get_mut("waypoint_times_s")?.as_array_mut()?.extend(times);
    timing.get_mut("hand_s")?.as_array_mut()?.extend(motions);
    timing.insert("duration_s".into(), later(next.get("duration_s")?)?);
    Some(timing.into())
}

/// Returns the smaller of each pair of radii; `null` if one of the two is missing.
fn least_of(a: Option<&Value>, b: Option<&Value>) -> Value {
    match (a, b) {
        (Some(Value::Object(a)), Some(Value::Object(b))) => {
            let keys = a.keys().map(|key| (key.clone(), least_of(a.get(key), b.get(key))));
            keys.collect::<Map<_, _>>().into()
        }
        // `null` means an unlimited radius.
        (Some(Value::Null), Some(b)) => b.clone(),
        (Some(a), Some(Value::Null)) => a.clone(),
        (Some(a), Some(b)) => a.as_f64().zip(b.as_f64()).map_or(Value::Null, |(a, b)| Value::from(a.min(b))),
        _ => Value::Null,
    }
}
