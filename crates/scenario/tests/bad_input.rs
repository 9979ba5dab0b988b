//! Faults of a file are reported with file and line.

use std::fs;
use std::path::{Path, PathBuf};

use cranny_scenario::{GivenGrasps, MoveItOptions, MoveItProblem, OpenOptions, Scenario};

/// Copy of a sound scenario, for modification. Faults of a single file are golden cases, in `crates/cli/tests/golden`.
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

    fn open(&self) -> Result<Scenario, cranny_scenario::ScenarioError> {
        Scenario::open(self.folder.path().to_str().unwrap(), &OpenOptions::default())
    }
}

#[test]
fn the_copy_itself_is_sound() {
    Copy::new().open().unwrap();
}

/// Folder in the released layout, with various faults.
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

/// A device or a pipe named as a mesh must not exhaust memory or block.
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

#[cfg(unix)]
fn make_pipe(path: &Path) {
    assert!(std::process::Command::new("mkfifo").arg(path).status().unwrap().success());
}

/// A pipe without a writer blocked each of these for ever.
#[cfg(unix)]
#[test]
fn a_pipe_in_the_place_of_any_file_is_refused() {
    let refused = |what: &str, fault: String| {
        assert!(fault.contains("it is a pipe, not a regular file"), "{what}: {fault}");
    };
    for file in ["scenario.yaml", "grasps.csv", "wedge.obj"] {
        let copy = Copy::new();
        fs::remove_file(copy.path(file)).unwrap();
        make_pipe(&copy.path(file));
        refused(file, copy.open().unwrap_err().to_string());
    }
    let copy = Copy::new();
    let text = fs::read_to_string(copy.path("scenario.yaml")).unwrap();
    let folder = copy.path("arm");
    fs::create_dir(&folder).unwrap();
    fs::write(folder.join("robot.yaml"), "urdf: ../pipe\n").unwrap();
    make_pipe(&copy.path("pipe"));
    make_pipe(&copy.path("pipe.zip"));
    for robot in ["robot: pipe", "robot: arm", "robot: panda_mobile\nsrdf: pipe"] {
        fs::write(copy.path("scenario.yaml"), text.replace("robot: panda_mobile", robot)).unwrap();
        refused(robot, copy.open().unwrap_err().to_string());
    }
    // What a plan file or a campaign names.
    let pipe = copy.path("pipe");
    let open = |what: &str, options: &OpenOptions| Scenario::open(what, options).unwrap_err().to_string();
    let grasps = OpenOptions { grasps: GivenGrasps::File(pipe.clone()), ..OpenOptions::default() };
    refused("grasps", open("021", &grasps));
    let robot = OpenOptions { robot: Some(pipe.clone()), ..OpenOptions::default() };
    refused("robot", open("021", &robot));
    refused("archive", open(copy.path("pipe.zip").to_str().unwrap(), &OpenOptions::default()));
    let fault = MoveItProblem::open(&pipe, &pipe, &MoveItOptions::default()).map(|_| ()).unwrap_err();
    refused("scene", fault.to_string());
    refused("configurations", cranny_scenario::read_configurations(&pipe, 7).unwrap_err().to_string());
}

/// Reading must not exceed the reader's budget with many obstacles, nor compare each name with all earlier ones.
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

/// A line of 10⁸ numbers must not be stored before it is refused.
#[test]
fn a_line_of_many_numbers_is_counted_and_not_kept() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("path.csv");
    fs::write(&path, format!("1,2\n{}1\n", "1,".repeat(5_000_000))).unwrap();
    let fault = cranny_scenario::read_configurations(&path, 2).unwrap_err().to_string();
    assert!(fault.contains("path.csv:2: 5000001 numbers instead of 2"), "{fault}");
}

/// Without permission, the message must not claim that the folder does not exist.
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
    // An administrator can open every folder.
    if is_kept_out {
        let said = opened.unwrap_err().to_string();
        assert!(said.contains("no permission to read it"), "{said}");
    }
}
