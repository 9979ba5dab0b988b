//! Conversions between JSON of the crates and dictionaries and lists.

use pyo3::prelude::*;
use serde::Serialize;
use serde_json::{Map, Value};

use crate::handover::fault::{bad_type, fault};

/// Converts a value to Python through its JSON.
pub fn python_of<'py>(py: Python<'py>, value: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    let text = serde_json::to_string(value).map_err(fault)?;
    py.import("json")?.call_method1("loads", (text,))
}

/// Reads a dictionary of settings.
pub fn settings_of(settings: Option<&Bound<'_, PyAny>>) -> PyResult<Map<String, Value>> {
    let Some(settings) = settings else { return Ok(Map::new()) };
    match value_of("settings", "a dictionary of plain values", settings)? {
        Value::Object(settings) => Ok(settings),
        other => Err(bad_type(format!("settings: a dictionary of plain values is expected, not {other}"))),
    }
}

/// Converts plain values of Python to JSON.
pub fn value_of(what: &str, expected: &str, value: &Bound<'_, PyAny>) -> PyResult<Value> {
    let text: String = value
        .py()
        .import("json")?
        .call_method1("dumps", (value,))
        .map_err(|reason| bad_type(format!("{what}: {expected} is expected ({reason})")))?
        .extract()?;
    serde_json::from_str(&text).map_err(|_| bad_type(format!("{what}: {expected} is expected, not {text}")))
}
