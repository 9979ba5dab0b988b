//! What is wrong with a file is said with file and line.

use std::fs;
use std::path::{Path, PathBuf};

use cranny_scenario::{OpenOptions, Scenario};

/// A copy of a sound scenario, with one file changed.
struct Copy {
    folder: tempfile::TempDir,
}

impl Copy {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let original = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/corner");
        for file in fs::read_dir(original).unwrap() {
            let file = file.unwrap();
            fs::copy(file.path(), folder.path().join(file.file_name())).unwrap();
        }
        Self { folder }
    }

    fn path(&self, file: &str) -> PathBuf {
        self.folder.path().join(file)
    }

    /// What is said of the copy once `from` in `file` is `to`.
    fn fault(&self, file: &str, from: &str, to: &str) -> String {
        let text = fs::read_to_string(self.path(file)).unwrap();
        assert!(text.contains(from), "{from}");
        fs::write(self.path(file), text.replacen(from, to, 1)).unwrap();
        let fault = self.open().unwrap_err().to_string();
        fs::write(self.path(file), text).unwrap();
        fault
    }

    fn open(&self) -> Result<Scenario, cranny_scenario::ScenarioError> {
        Scenario::open(self.folder.path().to_str().unwrap(), &OpenOptions::default())
    }
}

#[test]
fn the_copy_itself_is_sound() {
    Copy::new().open().unwrap();
}

#[test]
fn faults_of_a_scenario_file_name_file_and_line() {
    let copy = Copy::new();
    let cases = [
        // What is replaced, by what, what the message must contain.
        ("criterion: paper", "criterium: paper", "scenario.yaml:29: unknown field `criterium`"),
        ("criterion: paper", "criterion: loose", "unknown variant `loose`"),
        ("radius: 0.05}", "radius: 0.05, length: 1}", "scenario.yaml:12: unknown field `length`"),
        ("floor: 0.0", "", "missing field `floor`"),
        ("floor: 0.0", "floor: .nan", "scenario.yaml:6: 'NaN' is not a finite number"),
        ("[1.0, 1.0, 0.4]", "[1.0, .inf, 0.4]", "scenario.yaml:9: 'inf' is not a finite number"),
        ("[1.0, 1.0, 0.4]", "[1.0, 0.4]", "scenario.yaml:9"),
        (
            "base_joint_y: 0,",
            "base_joint_z: 0,",
            "scenario.yaml:4: unknown joint 'base_joint_z' (the robot has: base_joint_y",
        ),
        ("panda_joint7: 0.7534", "panda_joint7: .nan", "scenario.yaml:5: 'NaN' is not a finite number"),
        ("base_joint_y: 0,", "", "scenario.yaml:4: the start gives no value for joint 'base_joint_y'"),
        (
            "radius: 0.05",
            "radius: -0.05",
            "scenario.yaml:12: 'board': the radius of a sphere must be a positive",
        ),
        // As it stands in the file, not halved.
        (
            "size: [0.6, 0.3, 0.02]",
            "size: [0.6, -0.4, 0.02]",
            "each side of a box must be a positive number of metres, at most 1000, but is -0.4",
        ),
        (
            "length: 0.2}",
            "length: 0}",
            "the length of a capsule must be a positive number of metres, at most 1000, but is 0",
        ),
        ("floor: 0.0", "floor: 0.0\nfloor: 0.0", "scenario.yaml:7: the key 'floor' is given twice"),
        (
            "    shapes:\n      - box: {size: [0.6, 0.3, 0.02]}\n",
            "    shapes:\n      - box: {size: [1, 1, 1]}\n        hull: {file: wedge.obj}\n",
            "scenario.yaml:11: a shape is exactly one",
        ),
        ("name: pipe", "name: board", "scenario.yaml:14: the name 'board' is taken"),
        ("name: pipe", "name: floor", "scenario.yaml:14: the name 'floor' is taken"),
        (
            "[0.7071068, 0.0, 0.0, 0.7071068]",
            "[0.7, 0.0, 0.0, 0.0]",
            "scenario.yaml:15: the quaternion has length 0.7",
        ),
        ("position: [0.4, 1.0, 0.5],", "rotation_rpy_deg: [0, 0, 0],", "scenario.yaml:15: a pose has either"),
        ("mesh: {file: wedge.obj", "mesh: {file: cone.obj", "scenario.yaml:22: 'wedge': "),
        (
            "robot: panda_mobile",
            "robot: panda_movable.urdf",
            "scenario.yaml:2: there is no robot 'panda_movable.urdf'",
        ),
        ("robot: panda_mobile", "robot: panda_mobile\ntip: panda_gripper", "unknown link `panda_gripper`"),
        (
            "robot: panda_mobile",
            "robot: panda_mobile\nfixed: {panda_finger_joint3: 0.04}",
            "unknown joint `panda_finger_joint3`",
        ),
        ("- capsule: {radius: 0.03, length: 0.2}", "- capsule: {radius: 0.03, ", "scenario.yaml:19: "),
    ];
    for (from, to, expected) in cases {
        let fault = copy.fault("scenario.yaml", from, to);
        assert!(fault.contains(expected), "{to}\n  said: {fault}\n  not:  {expected}");
        assert!(!fault.contains('\n'), "one line: {fault}");
    }
}

#[test]
fn a_start_of_the_wrong_length_names_both_sides() {
    let copy = Copy::new();
    let text = fs::read_to_string(copy.path("scenario.yaml")).unwrap();
    let start = &text[text.find("start:").unwrap()..text.find("floor:").unwrap()];
    let fault = copy.fault("scenario.yaml", start, "start: [0, 0, 0, -0.8, 0, -2.3, 0, 1.5]\n");
    assert!(fault.contains("scenario.yaml:4: the start has 8 values, but the robot has 9 joints"), "{fault}");
    let fault = copy.fault("scenario.yaml", start, "start:\n  - 0\n  - .inf\n");
    assert!(fault.contains("scenario.yaml:6: 'inf' is not a finite number"), "{fault}");
    let fault = copy.fault("scenario.yaml", start, "start: home\n");
    assert!(fault.contains("scenario.yaml:4") && fault.contains("a list of numbers"), "{fault}");
}

#[test]
fn truncated_and_empty_files_are_named() {
    let copy = Copy::new();
    let text = fs::read_to_string(copy.path("scenario.yaml")).unwrap();
    let cut = text.find("pose: {position: [0.3").unwrap() + 20;
    let fault = copy.fault("scenario.yaml", &text[cut..], "");
    assert!(fault.contains("scenario.yaml:13: unclosed bracket"), "{fault}");
    let fault = copy.fault("scenario.yaml", &text, "\n");
    assert!(fault.contains("scenario.yaml: the file is empty"), "{fault}");
    let grasps = fs::read_to_string(copy.path("grasps.csv")).unwrap();
    let fault = copy.fault("grasps.csv", &grasps, "");
    assert!(fault.contains("grasps.csv: the file holds no grasps"), "{fault}");
    fs::remove_file(copy.path("grasps.csv")).unwrap();
    let fault = copy.open().unwrap_err().to_string();
    assert!(fault.contains("grasps.csv: cannot read the grasps"), "{fault}");
}

#[test]
fn a_missing_mesh_and_a_mesh_with_a_hole_are_named() {
    let copy = Copy::new();
    let fault = copy.fault("wedge.obj", "f 3 1 4\n", "");
    assert!(
        fault.contains("scenario.yaml:22: 'wedge'") && fault.contains("wedge.obj: the mesh has a hole"),
        "{fault}"
    );
    fs::remove_file(copy.path("wedge.obj")).unwrap();
    let fault = copy.open().unwrap_err().to_string();
    assert!(fault.contains("wedge.obj: cannot read the mesh"), "{fault}");
}

#[test]
fn a_broken_grasp_is_named_by_its_line() {
    let copy = Copy::new();
    let fault = copy.fault("grasps.csv", "0,1,0,1.0", "0,1,0,NaN");
    assert!(fault.contains("grasps.csv:3: number 4 is 'NaN'"), "{fault}");
    let fault = copy.fault(
        "grasps.csv",
        "1,0,0,1.0,0,-1,0,0.0,0,0,-1,0.41,0,0,0,1,0.9,0.04",
        "1,0,0,1.0,0,-1,0,0.0,0,0,-1,0.41,0,0,0",
    );
    assert!(fault.contains("grasps.csv:2: 15 numbers instead of 16"), "{fault}");
}

#[test]
fn broken_ik_solutions_are_named_by_their_line() {
    let copy = Copy::new();
    fs::write(copy.path("ik.csv"), "0,0,0,0,0,-1,0,1,0\n0,0,0,0,0,-1,0,1\n").unwrap();
    let fault = copy.open().unwrap_err().to_string();
    assert!(fault.contains("ik.csv:2: 8 numbers instead of 9"), "{fault}");
}

/// A folder in the released layout, with whatever is wrong with it.
#[test]
fn faults_of_a_released_folder_name_file_and_line() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("scenarios/099");
    fs::create_dir_all(folder.join("export")).unwrap();
    let urdf = root.path().join("slide.urdf");
    fs::write(&urdf, cranny_test_robots::SLIDE).unwrap();
    let write = |file: &str, text: &str| fs::write(folder.join(file), text).unwrap();
    let fault = || {
        let options = OpenOptions { robot: Some(urdf.clone()), ..OpenOptions::default() };
        Scenario::open(folder.to_str().unwrap(), &options).unwrap_err().to_string()
    };
    let identity = "[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]";
    let scene = |objects: &str, pose: &str| {
        format!(
            "object_library_fn: ../../library.yaml\nobjects:\n{objects}bg_objects:\n- object_type: block\n  pose: {pose}\n"
        )
    };
    let ball = format!("- object_type: ball\n  pose: {identity}\n");

    write("scene.yaml", &scene(&ball, identity));
    assert!(fault().contains("library.yaml: cannot be read"), "{}", fault());
    fs::write(root.path().join("library.yaml"), "objects:\n- {identifier: ball, mesh_fn: ball.obj}\n")
        .unwrap();
    assert!(
        fault().contains("scene.yaml:6: the object library has no 'block' (it has: ball)"),
        "{}",
        fault()
    );
    write("scene.yaml", &scene("", identity));
    assert!(fault().contains("scene.yaml"), "{}", fault());
    write("scene.yaml", &scene(&format!("{ball}{ball}"), identity));
    assert!(fault().contains("scene.yaml: 'objects' must hold exactly one"), "{}", fault());
    write("scene.yaml", &scene(&ball, "[[2,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]"));
    assert!(fault().contains("scene.yaml:7: the rotation part of the pose is no rotation"), "{}", fault());
    write("scene.yaml", &scene(&ball, "[[1,0,0,0],[0,1,0,0],[0,0,1,0]]"));
    assert!(fault().contains("scene.yaml:7"), "{}", fault());
    write("scene.yaml", &scene(&ball, identity).replace("block", "ball"));
    assert!(fault().contains("ball.obj: cannot read the mesh"), "{}", fault());
}

/// A device named as a mesh took all memory, and a pipe all time.
#[cfg(unix)]
#[test]
fn what_a_scenario_names_must_be_a_regular_file() {
    let copy = Copy::new();
    fs::remove_file(copy.path("wedge.obj")).unwrap();
    std::os::unix::fs::symlink("/dev/zero", copy.path("wedge.obj")).unwrap();
    let fault = copy.open().unwrap_err().to_string();
    assert!(fault.contains("it is a device, not a regular file"), "{fault}");
    fs::remove_file(copy.path("grasps.csv")).unwrap();
    std::os::unix::fs::symlink("/dev/zero", copy.path("grasps.csv")).unwrap();
    let fault = copy.open().unwrap_err().to_string();
    assert!(fault.contains("grasps.csv: cannot read the grasps: it is a device"), "{fault}");
}

/// The reader's budget ended at 12 450 obstacles, and each name was compared with all before it.
#[test]
fn ten_thousand_obstacles_open_in_a_moment() {
    let copy = Copy::new();
    let text = fs::read_to_string(copy.path("scenario.yaml")).unwrap();
    let entry = |index: u32| {
        let (x, y) = (0.1 * f64::from(index % 200), 5.0 + 0.1 * f64::from(index / 200));
        let pose = format!("{{position: [{x}, {y}, 0]}}");
        format!("  - {{name: b{index}, shapes: [box: {{size: [0.05, 0.05, 0.05]}}], pose: {pose}}}\n")
    };
    let boxes = (0..20_000).map(entry).collect::<Vec<_>>().concat();
    let (before, after) = text.split_once("obstacles:\n").unwrap();
    fs::write(copy.path("scenario.yaml"), format!("{before}obstacles:\n{boxes}{after}")).unwrap();
    let begin = std::time::Instant::now();
    assert!(copy.open().unwrap().world.bodies().len() > 20_000);
    assert!(begin.elapsed().as_secs() < 10, "{:?}", begin.elapsed());
}

/// A line of 10⁸ numbers was kept as a whole before it was refused.
#[test]
fn a_line_of_many_numbers_is_counted_and_not_kept() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("path.csv");
    fs::write(&path, format!("1,2\n{}1\n", "1,".repeat(5_000_000))).unwrap();
    let fault = cranny_scenario::read_waypoints(&path, 2).unwrap_err().to_string();
    assert!(fault.contains("path.csv:2: 5000001 numbers instead of 2"), "{fault}");
}

#[test]
fn what_is_no_scenario_is_told_apart() {
    let folder = tempfile::tempdir().unwrap();
    let fault = |what: &str| Scenario::open(what, &OpenOptions::default()).unwrap_err().to_string();
    assert!(fault("21").contains("did you mean 021?"), "{}", fault("21"));
    assert!(fault("026").contains("did you mean 021 or 022 or 023?"), "{}", fault("026"));
    assert!(fault("999").contains("give an id, or a folder"), "{}", fault("999"));
    let file = folder.path().join("scenario.yaml");
    fs::write(&file, "robot: panda_mobile\n").unwrap();
    let said = fault(file.to_str().unwrap());
    assert!(said.contains("this is a file, not a scenario"), "{said}");
    assert!(cranny_scenario::check("999").is_err());
}

/// Without permission a folder was called "no folder of that name".
#[cfg(unix)]
#[test]
fn a_folder_that_may_not_be_read_is_called_so() {
    use std::os::unix::fs::PermissionsExt as _;
    let copy = Copy::new();
    let set = |mode| fs::set_permissions(copy.folder.path(), fs::Permissions::from_mode(mode)).unwrap();
    set(0o000);
    let is_kept_out = fs::read_dir(copy.folder.path()).is_err();
    let opened = copy.open();
    set(0o700);
    // To an administrator every folder is open.
    if is_kept_out {
        let said = opened.unwrap_err().to_string();
        assert!(said.contains("no permission to read it"), "{said}");
    }
}
