use std::fmt;

use cranny_file::excerpt;
use cranny_path::{Cause, Violation};
use serde::Serialize;
use serde_json::Value;

/// A value of a plan file that differs from the measured one.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Statement {
    /// Path of the key through objects and lists: `robustness.base.translation_m`.
    pub key: String,
    /// Value in the file.
    pub stated: Value,
    /// Measured value.
    pub measured: Value,
    /// True if the file promises more than was measured, beyond the tolerance of the measurement.
    #[serde(skip)]
    pub is_false: bool,
}

impl Statement {
    /// Returns both values, with their unit and enough digits to distinguish them.
    pub fn in_words(&self) -> [String; 2] {
        let (Some(stated), Some(measured)) = (self.stated.as_f64(), self.measured.as_f64()) else {
            return [&self.stated, &self.measured].map(|value| match value {
                Value::Null => "nothing".to_owned(),
                Value::Number(number) => {
                    number.as_f64().map_or_else(String::new, |value| self.number(value, 2))
                }
                other => excerpt(&other.to_string()),
            });
        };
        if self.stated.is_u64() && self.measured.is_u64() {
            return [&self.stated, &self.measured].map(Value::to_string);
        }
        let words = |digits| [stated, measured].map(|value| self.number(value, digits));
        let apart = (2..MOST_DIGITS).map(words).find(|[a, b]| a != b);
        apart.unwrap_or_else(|| [stated, measured].map(|value| value.to_string()))
    }

    /// Converts the statement to a violation of the plan.
    pub(crate) fn violation(self) -> Violation {
        let [stated, measured] = self.in_words();
        Violation::at_way_point(0, Cause::Statement { key: self.key, stated, measured })
    }

    fn number(&self, value: f64, digits: usize) -> String {
        let name = self.key.trim_end_matches(|c: char| c == '[' || c == ']' || c.is_ascii_digit());
        if name.ends_with("_m") {
            format!("{:.digits$} mm", value * 1e3)
        } else if name.ends_with("_rad") {
            format!("{:.digits$}°", value.to_degrees())
        } else if name.ends_with("_s") {
            format!("{value:.digits$} s")
        } else {
            format!("{value:.digits$}")
        }
    }
}

/// More digits than a number has.
const MOST_DIGITS: usize = 18;

impl fmt::Display for Statement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [stated, measured] = self.in_words();
        write!(f, "{}: the file states {stated}, measured {measured}", self.key)
    }
}

/// Condition under which a differing value is false.
#[derive(Clone, Copy)]
enum Law {
    /// A lower bound: false above the measured value, or without one, because nothing proves it. A weaker bound is true. A
    /// version measures a path identically each time, so only rounding is allowed.
    AtLeast,
    /// A clearance: a lower bound that no value exceeds if nothing is near, so that none is measured.
    Clearance,
    /// An upper bound: false below the measured value by more than [`DEPTH_TOLERANCE_M`].
    AtMost,
    /// Never false.
    Reported,
    /// False only if it is not a number: the audit of the path has compared numbers.
    Judged,
    /// Always false.
    Equal,
}

impl Law {
    /// Returns the law of a key of a plan file.
    fn of(key: &str) -> Self {
        match key {
            "clearance_m" | "clearances_per_edge_m" => Self::Clearance,
            "least_length" | "robustness" | "hold" | "hold_demanded" => Self::AtLeast,
            "own_grasp" => Self::Judged,
            // Under `paper` the audit uses its own threshold: it measures which grasp is reached, and how exactly.
            "goal_threshold" => Self::Reported,
            _ => Self::Equal,
        }
    }

    /// Returns the law of a key within a value.
    fn within(self, key: &str) -> Self {
        match key {
            "clearances_m" => Self::Clearance,
            "slack_m" | "slack_rad" => Self::AtLeast,
            "opening_m" => Self::Judged,
            "greatest_rad" => Self::AtMost,
            "mass_assumed" => Self::Equal,
            // Files of older versions do not have this key.
            "uneven_m" => Self::Reported,
            _ => self,
        }
    }

    fn is_false(self, stated: &Value, measured: &Value) -> bool {
        match (self, stated.as_f64(), measured.as_f64()) {
            (Self::Reported, _, _) | (Self::Judged, Some(_), Some(_)) | (Self::Clearance, Some(_), None) => {
                false
            }
            (Self::AtLeast | Self::Clearance, Some(stated), Some(measured)) => stated > measured,
            (Self::AtMost, Some(stated), Some(measured)) => stated < measured - DEPTH_TOLERANCE_M,
            (_, Some(stated), Some(measured)) => !is_near(stated, measured, TOLERANCE),
            _ => true,
        }
    }
}

/// Tolerance of depths, which are measured to 10 µm: other versions may take other samples.
const DEPTH_TOLERANCE_M: f64 = 1.1e-5;
/// Absolute (m, rad, s) and relative tolerance of a figure: other versions may sum in another order.
const TOLERANCE: f64 = 1e-6;
/// Relative difference below which two figures count as the same.
const ROUNDING: f64 = 1e-9;

fn is_near(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance * b.abs().max(1.0)
}

/// Returns the values under these keys that differ.
pub(crate) fn differences(keys: &[&str], stated: &Value, measured: &Value) -> Vec<Statement> {
    let mut found = Vec::new();
    for key in keys {
        let (stated, measured) = (&stated[*key], &measured[*key]);
        match (*key, stated.as_array(), measured.as_array()) {
            (NOT_CHECKED, Some(stated), Some(measured)) => compare_pairs(stated, measured, &mut found),
            _ => compare(key, Law::of(key), stated, measured, &mut found),
        }
    }
    found
}

pub(crate) const NOT_CHECKED: &str = "not_checked";

/// Compares the stated exceptions with the pairs that are not compared. A missing pair is false, because it is stated as
/// compared. An extra pair is not.
fn compare_pairs(stated: &[Value], measured: &[Value], found: &mut Vec<Statement>) {
    let key = |index: usize| format!("{NOT_CHECKED}[{index}]");
    let mut named = vec![false; stated.len()];
    for pair in measured {
        let at = stated.iter().zip(&named).position(|(other, named)| !named && is_pair(other, pair));
        let Some(index) = at else {
            let (key, stated, measured) = (NOT_CHECKED.to_owned(), Value::Null, pair.clone());
            found.push(Statement { key, stated, measured, is_false: true });
            continue;
        };
        named[index] = true;
        for (name, law) in [("depth_m", Law::AtMost), ("allowance_m", Law::AtMost), ("reason", Law::Reported)]
        {
            compare(&format!("{}.{name}", key(index)), law, &stated[index][name], &pair[name], found);
        }
    }
    for (index, _) in named.iter().enumerate().filter(|(_, named)| !**named) {
        let (stated, measured) = (stated[index].clone(), Value::Null);
        found.push(Statement { key: key(index), stated, measured, is_false: false });
    }
}

/// Returns true if a stated exception covers a pair that is not compared: for the same reason, in the same segment. Any reason
/// covers a pair that is proven never to touch.
fn is_pair(stated: &Value, measured: &Value) -> bool {
    let is = |key: &str, other: &str| stated[key] == measured[other];
    let are_named = is("first", "first") && is("second", "second");
    let are_swapped = is("first", "second") && is("second", "first");
    let is_reason = is("reason", "reason") || measured["reason"] == "adjacent-free";
    (are_named || are_swapped) && is_reason && is("segment", "segment")
}

fn compare(key: &str, law: Law, stated: &Value, measured: &Value, found: &mut Vec<Statement>) {
    match (stated, measured) {
        (Value::Object(a), Value::Object(b)) => {
            let more = b.keys().filter(|name| !a.contains_key(*name));
            for name in a.keys().chain(more) {
                let (a, b) = (&stated[name], &measured[name]);
                compare(&format!("{key}.{name}"), law.within(name), a, b, found);
            }
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            for (index, (a, b)) in a.iter().zip(b).enumerate() {
                compare(&format!("{key}[{index}]"), law, a, b, found);
            }
        }
        _ => {
            let is_same = match (stated.as_f64(), measured.as_f64()) {
                (Some(a), Some(b)) => (a - b).abs() <= ROUNDING * b.abs(),
                _ => stated == measured,
            };
            if !is_same {
                let is_false = law.is_false(stated, measured);
                let (stated, measured) = (stated.clone(), measured.clone());
                found.push(Statement { key: key.to_owned(), stated, measured, is_false });
            }
        }
    }
}
