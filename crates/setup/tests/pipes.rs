//! Files that are found and not named are regular files.

use std::path::Path;

use cranny_scenario::BUILTIN_ROBOTS;
use cranny_setup::{RobotSetup, SetupOptions};

/// An SRDF in the usual folder of a package blocked the setup for ever if it was a pipe.
#[cfg(unix)]
#[test]
fn a_pipe_in_the_folder_of_srdf_files_is_not_read() {
    let package = tempfile::tempdir().unwrap();
    let urdf = BUILTIN_ROBOTS[0].write(&package.path().join("urdf")).unwrap();
    let beside = urdf.with_extension("srdf");
    let found = package.path().join("srdf").join(beside.file_name().unwrap());
    std::fs::create_dir(found.parent().unwrap()).unwrap();
    std::fs::rename(&beside, &found).unwrap();
    let chosen = || {
        let setup = RobotSetup::of(&urdf, &SetupOptions::default()).unwrap();
        setup.choices.into_iter().find(|choice| choice.what == "SRDF").expect("a choice")
    };
    assert!(chosen().chosen.starts_with("pairs and states of "), "{:?}", chosen());
    let pipe = |path: &Path| {
        std::fs::remove_file(path).unwrap();
        assert!(std::process::Command::new("mkfifo").arg(path).status().unwrap().success());
    };
    pipe(&found);
    let choice = chosen();
    assert!(choice.chosen == "none" && choice.why.contains("it is a pipe, not a regular file"), "{choice:?}");
    pipe(&urdf);
    let fault = RobotSetup::of(&urdf, &SetupOptions::default()).map(|_| ()).unwrap_err().to_string();
    assert!(fault.contains("it is a pipe, not a regular file"), "{fault}");
}
