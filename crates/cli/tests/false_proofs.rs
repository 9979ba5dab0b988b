//! Regression tests: paths with a link inside a body that were reported as valid, each for another reason; and a contact that
//! appears to be free space. Each folder is a scenario with its path.

use std::path::{Path, PathBuf};

use assert_cmd::Command;
use serde_json::Value;

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/false_proofs").join(name)
}

/// Returns the verdict of `cranny verify` on the way points in a file of a folder, and the exit code.
fn verdict(name: &str, file: &str, flags: &[&str]) -> (Value, Option<i32>) {
    let folder = folder(name);
    let output = Command::cargo_bin("cranny")
        .expect("the program")
        .arg("verify")
        .args([&folder, &folder.join(file)])
        .args(flags)
        .arg("--json")
        .output()
        .expect("it runs");
    let verdict = serde_json::from_slice(&output.stdout);
    (verdict.unwrap_or_else(|_| panic!("{}", String::from_utf8_lossy(&output.stderr))), output.status.code())
}

fn violations(verdict: &Value) -> &[Value] {
    verdict["violations"].as_array().expect("a list")
}

/// Checks that `first` touches `second`, at least `depth_m` (m) deep.
fn touches(name: &str, first: &str, second: &str, depth_m: f64) {
    let (verdict, code) = verdict(name, "p.csv", &[]);
    assert_eq!((&verdict["valid"], code), (&Value::Bool(false), Some(1)), "{name}: {verdict}");
    let contact = violations(&verdict).iter().find(|violation| violation["kind"] == "contact");
    let contact = contact.unwrap_or_else(|| panic!("{name}: no contact in {verdict}"));
    let names = [&contact["first"], &contact["second"]];
    assert!(names == [first, second] || names == [second, first], "{name}: {names:?}");
    let found_m = contact["depth_m"].as_f64().expect("a depth");
    assert!(found_m >= depth_m, "{name}: {found_m} m deep, in truth {depth_m} m");
}

/// The spheres of the leaves did not cover a thin hull completely; a speck lies in the gap.
#[test]
fn a_speck_in_a_thin_hull_is_found() {
    touches("thin_hull_1", "b", "o", 69e-6);
    touches("thin_hull_2", "b", "o", 50e-6);
}

/// The SIMD code assumed angles below 2π.
#[test]
fn an_arm_that_turned_a_thousand_times_is_where_it_is() {
    // The deepest configuration lies between two sampled ones.
    touches("large_angle_1", "arm", "ball", 0.019);
    touches("large_angle_2", "arm", "ball", 0.3e-3);
}

/// An arm behind a gear has the same fault at ordinary angles.
#[test]
fn an_arm_behind_a_gear_of_a_thousand_is_where_it_is() {
    touches("geared_joint", "arm", "ball", 49e-6);
}

/// A pair of links that touched in all random configurations was excluded, although it is free at the start.
#[test]
fn a_pair_that_is_free_at_the_start_is_checked() {
    touches("always_touching", "c", "base", 0.01);
    let (verdict, _) = verdict("always_touching", "p.csv", &[]);
    let exceptions = verdict["not_checked"].as_array().expect("a list");
    assert!(exceptions.iter().all(|pair| pair["reason"] == "adjacent-free"), "{exceptions:?}");
}

/// A sphere inside a ring, 39.8 µm clear of its surface: its centre has the winding number 1, and is farther from every
/// triangle than its radius. Solids are filled, so it is in contact, with the corresponding depth.
#[test]
fn a_sphere_within_a_ring_is_in_contact_though_clear_of_its_surface() {
    let (verdict, _) = verdict("false_contact", "q.csv", &[]);
    let contacts: Vec<_> = violations(&verdict).iter().filter(|v| v["kind"] == "contact").collect();
    assert_eq!(contacts.len(), 1, "{verdict}");
    assert_eq!((&contacts[0]["first"], &contacts[0]["second"]), (&"l1".into(), &"o0".into()));
    let (depth_m, radius_m) = (contacts[0]["depth_m"].as_f64().expect("a depth"), 0.003515647149242195);
    assert!((depth_m - radius_m - 39.8e-6).abs() < 0.2e-6, "{depth_m} m");
}
