//! Scenarios with a robot that is not built in: written, opened, packed with its files.

use std::fs;
use std::path::{Path, PathBuf};

use cranny_collision::{Body, Cell, Margins, World};
use cranny_robot::{Hold, RobotFiles};
use cranny_scenario::{
    Credits, OpenOptions, RecipeRobot, Scenario, SchemaFile, TemplateRobot, check, pack, unpack,
    write_template,
};
use cranny_shape::Solid;
use cranny_spatial::{Pose, Vector};

/// Path of a file of a small arm with SRDF, limits and mesh, and of a scenario beside it.
fn sound(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../cli/tests/file_readers/sound").join(file)
}

fn open(what: &Path) -> Scenario {
    Scenario::open(what.to_str().unwrap(), &OpenOptions::default()).unwrap()
}

/// Asserts that the robots have the same joints, and the same geometry on every link.
fn assert_same_robot(one: &Scenario, other: &Scenario) {
    assert_eq!(one.robot.joint_names(), other.robot.joint_names());
    assert_eq!(one.robot.limits(), other.robot.limits());
    assert_eq!(one.robot.disabled_pairs(), other.robot.disabled_pairs());
    for (a, b) in one.robot.links().iter().zip(other.robot.links()) {
        assert_eq!((&a.name, a.collisions.len()), (&b.name, b.collisions.len()));
        for (a, b) in a.collisions.iter().zip(&b.collisions) {
            assert_eq!(a.solid.aabb(), b.solid.aabb());
        }
    }
}

#[test]
fn a_new_scenario_has_the_files_of_its_robot() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("cell");
    let robot = TemplateRobot {
        robot: sound("robot/arm.urdf"),
        group: Some("both".to_owned()),
        tip: Some("hand".to_owned()),
        ..TemplateRobot::default()
    };
    write_template(&folder, Some(&robot)).unwrap();
    assert!(check(folder.to_str().unwrap()).unwrap().is_empty());
    let scenario = open(&folder);
    assert_eq!(scenario.robot.joint_names(), ["shoulder", "elbow"]);
    assert_eq!(scenario.robot.links()[scenario.robot.tip()].name, "hand");
    assert_eq!(scenario.start, [0.0, 0.0]);
    // SRDF and limits are copied too.
    assert!(!scenario.robot.disabled_pairs().is_empty());
    assert_eq!(scenario.robot.limits()[0].jerk, Some(50.0));
    assert_same_robot(&scenario, &open(&sound("own")));
    // The robot of the template is replaced completely.
    let text = fs::read_to_string(folder.join("scenario.yaml")).unwrap();
    assert!(
        text.contains("\nrobot: \"robot/arm.urdf\"\n") && text.contains("\nsrdf: \"robot/arm.srdf\"\n"),
        "{text}"
    );
    assert!(!text.contains("panda_joint1"), "{text}");

    let wrong = TemplateRobot { tip: Some("hook".to_owned()), ..robot };
    let other = root.path().join("other");
    assert!(write_template(&other, Some(&wrong)).unwrap_err().to_string().contains("hook"));
    assert!(!other.exists());
}

#[test]
fn a_robot_from_outside_the_folder_is_packed_with_it() {
    let root = tempfile::tempdir().unwrap();
    let archive = root.path().join("own.zip");
    let files = pack(&sound("own"), &archive, &Credits::default()).unwrap_err();
    // Its obstacles need a mesh outside the folder too, which packing does not move.
    assert!(
        files.to_string().contains("does not open by itself") && files.to_string().contains("mesh.obj"),
        "{files}"
    );

    let folder = root.path().join("deep/own");
    fs::create_dir_all(&folder).unwrap();
    for (from, to) in
        [("own/grasps.csv", "grasps.csv"), ("own/ik.csv", "ik.csv"), ("mesh/mesh.obj", "mesh.obj")]
    {
        fs::copy(sound(from), folder.join(to)).unwrap();
    }
    let robot = sound("robot");
    let text = fs::read_to_string(sound("own/scenario.yaml"))
        .unwrap()
        .replace("../mesh/", "")
        .replace("../robot", robot.to_str().unwrap());
    fs::write(folder.join("scenario.yaml"), &text).unwrap();
    let files = pack(&folder, &archive, &Credits::default()).unwrap();
    let expected = ["robot/arm.srdf", "robot/arm.urdf", "robot/limits.yaml", "robot/meshes/mesh.obj"];
    assert!(expected.iter().all(|name| files.iter().any(|file| file == name)), "{files:?}");
    assert_same_robot(&open(&archive), &open(&folder));
    let unpacked = root.path().join("unpacked");
    unpack(&archive, &unpacked).unwrap();
    assert_same_robot(&open(&unpacked), &open(&folder));
    // The packed folder is unchanged, and packs again to the same bytes.
    assert_eq!(fs::read_to_string(folder.join("scenario.yaml")).unwrap(), text);
    let again = root.path().join("again.zip");
    pack(&folder, &again, &Credits::default()).unwrap();
    assert_eq!(fs::read(&again).unwrap(), fs::read(&archive).unwrap());
    // From its own folder it packs unchanged.
    let third = root.path().join("third.zip");
    pack(&unpacked, &third, &Credits::default()).unwrap();
    assert_same_robot(&open(&third), &open(&folder));
}

#[test]
fn meshes_of_packages_and_of_one_name_are_told_apart() {
    let root = tempfile::tempdir().unwrap();
    let mesh = fs::read(sound("mesh/mesh.obj")).unwrap();
    for folder in ["share/arm/a", "share/arm/b", "urdf"] {
        fs::create_dir_all(root.path().join(folder)).unwrap();
    }
    for folder in ["share/arm/a", "share/arm/b"] {
        let mut different = mesh.clone();
        different.extend(format!("# {folder}\n").bytes());
        fs::write(root.path().join(folder).join("link.obj"), different).unwrap();
    }
    let urdf = root.path().join("urdf/arm.urdf");
    let body =
        |kind: &str, mesh: &str| format!("<{kind}><geometry><mesh filename='{mesh}'/></geometry></{kind}>");
    let text = format!(
        "<robot name='r'><link name='l'>{}{}{}{}</link></robot>",
        body("collision", "package://arm/a/link.obj"),
        body("collision", "package://arm/b/link.obj"),
        // Another spelling is not another file.
        body("visual", "package://arm/a/../a/./link.obj"),
        body("visual", "package://paint/gone.dae"),
    );
    fs::write(&urdf, text).unwrap();
    let found = RobotFiles::gather(&urdf, None, &[root.path().join("share")]).unwrap();
    let names: Vec<&str> = found.contents.keys().map(String::as_str).collect();
    assert_eq!(names, ["arm.urdf", "meshes/link-2.obj", "meshes/link.obj"]);
    let text = String::from_utf8(found.contents["arm.urdf"].clone()).unwrap();
    assert_eq!(
        text.matches("meshes/link.obj").count() + text.matches("meshes/link-2.obj").count(),
        3,
        "{text}"
    );
    assert!(text.contains("package://paint/gone.dae"), "{text}");
    let fault = RobotFiles::gather(&urdf, None, &[]).unwrap_err().to_string();
    assert!(fault.contains("arm.urdf:1") && fault.contains("link.obj"), "{fault}");
}

#[test]
fn editors_know_the_keys_of_a_robot() {
    for key in ["robot", "srdf", "group", "tip", "fixed", "packages"] {
        assert!(SchemaFile::Scenario.schema().contains(&format!("\"{key}\"")), "{key}");
    }
}

/// Returns the link that touches a plank of 30 mm before a pad does, when a linkage closes on it; its near edge is at a distance
/// (m) ahead of the gripper frame.
fn touched_beside(ahead_m: f64) -> Option<String> {
    let robot = RecipeRobot::load(Path::new("ur5e")).unwrap().robot;
    let solid = Solid::cuboid(Vector::new(0.055, 0.015, 0.1)).unwrap();
    let world = World::new(vec![Body::new("plank", Pose::translation(2.0, 0.0, 1.0), solid)]).unwrap();
    let cell = Cell::new(robot.clone(), world, Margins::default()).unwrap();
    let hold = Hold { tip_from_held: Pose::translation(0.0, 0.0, ahead_m + 0.1), closing: 0.0 };
    let closing = cell.holding(0, hold).unwrap().close_on_held().unwrap();
    closing.beside.map(|link| robot.links()[link].name.clone())
}

/// Far in the hand, the knuckles of a linkage meet a plank before its pads do.
#[test]
fn a_knuckle_that_touches_before_the_pad_is_named() {
    assert_eq!(touched_beside(-0.01), None);
    let knuckle = touched_beside(-0.045).unwrap();
    assert!(knuckle.contains("inner_knuckle"), "{knuckle}");
}
