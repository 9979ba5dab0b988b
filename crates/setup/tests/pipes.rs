//! Files that are found and not named are regular files.

use std::path::Path;

use cranny_setup::{RobotSetup, SetupOptions};

/// An SRDF in the usual folder of a package blocked the setup for ever if it was a pipe.
#[cfg(unix)]
#[test]
fn a_pipe_in_the_folder_of_srdf_files_is_not_read() {
    let package = tempfile::tempdir().unwrap();
    let pipe = |path: &Path| {
        assert!(std::process::Command::new("mkfifo").arg(path).status().unwrap().success());
    };
    for folder in ["urdf", "srdf"] {
        std::fs::create_dir(package.path().join(folder)).unwrap();
    }
    let urdf = package.path().join("urdf/arm.urdf");
    let link = |name: &str| {
        format!(
            "<link name=\"{name}\"><collision><geometry><box size=\"0.1 0.1 0.1\"/></geometry></collision></link>"
        )
    };
    let joint = "<joint name=\"j\" type=\"revolute\"><parent link=\"a\"/><child link=\"b\"/><origin xyz=\"0 0 0.5\"/>\
        <axis xyz=\"0 0 1\"/><limit lower=\"-1\" upper=\"1\" velocity=\"1\" effort=\"1\"/></joint>";
    std::fs::write(&urdf, format!("<robot name=\"arm\">{}{}{joint}</robot>", link("a"), link("b"))).unwrap();
    pipe(&package.path().join("srdf/arm.srdf"));
    let setup = RobotSetup::of(&urdf, &SetupOptions::default()).map(|_| ());
    // An arm of one joint need not be a robot that can be set up; it must only be answered.
    let said = setup.map_or_else(|fault| fault.to_string(), |()| String::new());
    assert!(!said.contains("pipe"), "{said}");
    std::fs::remove_file(&urdf).unwrap();
    pipe(&urdf);
    let fault = RobotSetup::of(&urdf, &SetupOptions::default()).map(|_| ()).unwrap_err().to_string();
    assert!(fault.contains("it is a pipe, not a regular file"), "{fault}");
}
