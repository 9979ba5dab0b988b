//! Tests that errors in YAML and JSON texts name their line, in words of the author of the text.

use std::collections::BTreeMap;
use std::num::NonZeroU32;

use serde::Deserialize;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(dead_code, reason = "each test uses a part of it")]
struct Box {
    size: [f64; 3],
    name: Option<String>,
    count: Option<NonZeroU32>,
    open: Option<bool>,
}

fn yaml(text: &str) -> (usize, String) {
    let fault = cranny_file::yaml::<Box>(text).unwrap_err();
    (fault.line, fault.problem)
}

fn json(text: &str) -> (usize, String) {
    let fault = cranny_file::json::<Box>(text.as_bytes()).unwrap_err();
    (fault.line, fault.problem)
}

/// Words of the library or of Rust that mean nothing to a user.
const FOREIGN: [&str; 14] = [
    "Options", "budget", "Budget", "f64", "u32", "nonzero", "non-zero", "scalar", "sequence", "Spanned",
    "serde", "untagged", "at line", "policy",
];

#[test]
fn no_fault_speaks_the_language_of_the_library() {
    let cases = [
        ("size: [1, 1, 1]\nsize: [1, 1, 1]\n", 2, "the key 'size' is given twice"),
        ("name: a\n", 1, "missing field `size`"),
        ("size: [1, 1, 1]\nheight: 3\n", 2, "unknown field `height`"),
        ("size: 3\n", 1, "expected a list"),
        ("size: [1, x, 1]\n", 1, "this is not a number"),
        ("size: [1, 1, 1]\nopen: perhaps\n", 2, "this is neither true nor false"),
        ("size: [1, 1, 1]\n---\nsize: 3\n", 0, "a second document"),
        ("size: [1, 1", 0, ""),
        ("size: [1, 1, 1]\ncount: 0\n", 0, ""),
        ("size: [1, 1, 1]\nname: [a]\n", 0, ""),
        ("size: {a: 1}\n", 0, ""),
        ("size: [1, 1]\n", 0, ""),
        ("- 1\n", 0, ""),
        ("size: *a\n", 1, "its anchor (&name) must come before it"),
        ("size: &a [1, 1, 1]\nname: !!binary \"//8=\"\n", 0, ""),
        ("\"", 0, ""),
    ];
    for (text, line, words) in cases {
        let (found, said) = yaml(text);
        assert!(line == 0 || found == line, "{text:?}: line {found}: {said}");
        assert!(said.contains(words), "{text:?}: {said}");
        assert!(!FOREIGN.iter().any(|word| said.contains(word)), "{text:?}: {said}");
    }
    let cases = [
        ("{\n\"size\": 1}", 2, "invalid type"),
        ("{\"size\": [1, 1, 1], \"count\": 0}", 1, "a whole number"),
        ("{\"size\": [1, 1, 1]", 1, "ends too early"),
        ("{\"size\": [1, null, 1]}", 1, "nothing"),
        ("{\"size\": [1, 1, 1], \"size\": 2}", 1, ""),
        ("[1", 1, ""),
    ];
    for (text, line, words) in cases {
        let (found, said) = json(text);
        assert!(found == line && said.contains(words), "{text:?}: line {found}: {said}");
        assert!(!FOREIGN.iter().any(|word| said.contains(word)), "{text:?}: {said}");
    }
}

#[test]
fn a_key_that_looks_like_a_location_moves_none() {
    let (line, problem) = yaml("size: [1, 1, 1]\n\"b at line y\": 3\n");
    assert_eq!(
        (line, problem.as_str()),
        (2, "unknown field `b at line y`, expected one of size, name, count, open")
    );
}

/// The default node budget of the library would refuse scenes of more than 12 450 obstacles.
#[test]
fn a_long_list_is_read_and_one_that_multiplies_itself_is_not() {
    let long = format!("a: [{}]\n", "{b: [1, 2, 3]}, ".repeat(45_000));
    let read: BTreeMap<String, Vec<BTreeMap<String, Vec<f64>>>> = cranny_file::yaml(&long).unwrap();
    assert_eq!(read["a"].len(), 45_000);
    let mut bomb = vec!["a0: &a0 [x, x, x, x, x, x, x, x, x]\n".to_owned()];
    for level in 1..10 {
        let list = format!("*a{}, ", level - 1).repeat(9);
        bomb.push(format!("a{level}: &a{level} [{list}]\n"));
    }
    let fault = cranny_file::yaml::<serde_json::Value>(&bomb.concat()).unwrap_err();
    assert!(fault.problem.contains("aliases"), "{fault}");
    let deep = "[".repeat(100_000);
    let fault = cranny_file::yaml::<serde_json::Value>(&deep).unwrap_err();
    assert!(!fault.problem.is_empty());
}
