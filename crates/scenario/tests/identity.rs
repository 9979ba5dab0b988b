//! The identity of a scenario depends on its files but not on their location.

use std::fs;
use std::path::Path;

use cranny_scenario::{Credits, Identity, catalogue, pack};

fn write(folder: &Path, id: &str) {
    fs::create_dir_all(folder).expect("a folder");
    let entry = catalogue().iter().find(|entry| entry.id == id).expect("a built-in scenario");
    let (scenario, grasps) = entry.files();
    fs::write(folder.join("scenario.yaml"), scenario).expect("written");
    fs::write(folder.join("grasps.csv"), grasps).expect("written");
}

fn identity(path: &Path) -> Identity {
    Identity::of(&path.display().to_string()).expect("a scenario")
}

#[test]
fn a_built_in_scenario_its_folder_and_its_archive_are_one() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let folder = place.path().join("021");
    write(&folder, "021");
    fs::write(folder.join("021.plan.json"), "{}").expect("written");
    let archive = place.path().join("021.zip");
    pack(&folder, &archive, &Credits { licence: Some("MIT".into()), ..Credits::default() }).expect("packed");
    let built_in = Identity::of("021").expect("a scenario");
    assert_eq!((built_in.id.as_str(), built_in.sha256.len()), ("021", 64));
    assert_eq!(identity(&folder), built_in);
    assert_eq!(identity(&archive), built_in);
}

#[test]
fn a_changed_byte_makes_another_scenario_of_the_same_id() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let folder = place.path().join("021");
    write(&folder, "021");
    let before = identity(&folder);
    let grasps = fs::read_to_string(folder.join("grasps.csv")).expect("grasps");
    fs::write(folder.join("grasps.csv"), grasps + "\n").expect("written");
    let after = identity(&folder);
    assert_eq!(before.id, after.id);
    assert_ne!(before.sha256, after.sha256);
}

#[test]
fn what_is_no_scenario_has_no_identity() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let message = Identity::of(&place.path().display().to_string()).expect_err("a fault").to_string();
    assert!(message.contains("neither scenario.yaml"), "{message}");
    assert!(Identity::of("099").expect_err("a fault").to_string().contains("no built-in scenario '099'"));
}
