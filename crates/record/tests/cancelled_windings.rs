//! Regression tests for scenarios with meshes whose windings cancel: they were opened as empty space, and a path inside an
//! obstacle was proven. They must be repaired, with a report, or refused.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use cranny_collision::Margins;
use cranny_path::audit;
use cranny_record::read_waypoints;
use cranny_robot::{MeshUse, Robot, RobotOptions};
use cranny_scenario::{OpenOptions, Scenario, check, mesh_repairs};

fn false_proofs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../cli/tests/fixtures/false_proofs")
}

/// Returns true if the path of the folder is valid in its scenario; and the repairs of the meshes.
fn judged(folder: &Path) -> (bool, String) {
    let scenario = Scenario::open(&folder.to_string_lossy(), &OpenOptions::default()).unwrap();
    let problem = scenario.problem(Margins::default()).unwrap();
    let path = read_waypoints(&folder.join("p.csv"), problem.robot().dof()).unwrap();
    let verification = audit(&problem, &path).unwrap();
    (verification.valid, mesh_repairs(&scenario.robot, &scenario.world).join("\n"))
}

#[test]
fn a_link_inside_a_mesh_whose_windings_cancel_is_in_contact() {
    for (name, said) in
        [("two_sided", "12 of 24 triangles left out"), ("overlap_opposite", "12 of 24 triangles turned")]
    {
        let (valid, repairs) = judged(&false_proofs().join(name));
        assert!(!valid, "{name}");
        assert!(repairs.contains("body 'ob'") && repairs.contains(said), "{name}: {repairs}");
    }
}

/// Creates a copy of the scenario `two_sided` with another mesh, in a folder of its own.
fn with_mesh(mesh: &str, text: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for file in ["r.urdf", "p.csv", "grasps.csv", "scenario.yaml"] {
        fs::copy(false_proofs().join("two_sided").join(file), folder.path().join(file)).unwrap();
    }
    let yaml = folder.path().join("scenario.yaml");
    fs::write(&yaml, fs::read_to_string(&yaml).unwrap().replace("m.obj", mesh)).unwrap();
    fs::write(folder.path().join(mesh), text).unwrap();
    folder
}

/// Returns the triangles of the fixture, to write them in other formats.
fn two_sided_triangles() -> Vec<[[f64; 3]; 3]> {
    let text = fs::read_to_string(false_proofs().join("two_sided/m.obj")).unwrap();
    let numbers = |line: &str| -> Vec<f64> { line.split(' ').skip(1).map(|w| w.parse().unwrap()).collect() };
    let vertices: Vec<Vec<f64>> = text.lines().filter(|l| l.starts_with("v ")).map(numbers).collect();
    let faces = text.lines().filter(|l| l.starts_with("f ")).map(numbers);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small whole numbers")]
    let vertex = |index: f64| [0, 1, 2].map(|axis| vertices[index as usize - 1][axis]);
    faces.map(|face| [vertex(face[0]), vertex(face[1]), vertex(face[2])]).collect()
}

#[test]
fn no_format_lets_windings_cancel() {
    let triangles = two_sided_triangles();
    let words = |numbers: &[f64]| numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
    let mut stl = String::from("solid s\n");
    let (mut points, mut faces, mut indices) = (String::new(), String::new(), String::new());
    for (index, triangle) in triangles.iter().enumerate() {
        stl += "facet normal 0 0 1\nouter loop\n";
        for corner in triangle {
            let _ = writeln!(stl, "vertex {}", words(corner));
            let _ = writeln!(points, "{}", words(corner));
        }
        stl += "endloop\nendfacet\n";
        let first = 3 * index;
        let _ = writeln!(faces, "3 {} {} {}", first, first + 1, first + 2);
        let _ = write!(indices, "{} {} {} ", first, first + 1, first + 2);
    }
    stl += "endsolid s\n";
    let (count, corners) = (triangles.len(), 3 * triangles.len());
    let ply = format!(
        "ply\nformat ascii 1.0\nelement vertex {corners}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {count}\nproperty list uchar int vertex_indices\nend_header\n{points}{faces}"
    );
    let dae = format!(
        "<COLLADA version='1.4.1'><library_geometries><geometry id='g'><mesh><source id='s'><float_array id='a'>\
         {points}</float_array><technique_common><accessor source='#a' count='{corners}' stride='3'/>\
         </technique_common></source><vertices id='v'><input semantic='POSITION' source='#s'/></vertices>\
         <triangles count='{count}'><input semantic='VERTEX' source='#v' offset='0'/><p>{indices}</p></triangles>\
         </mesh></geometry></library_geometries></COLLADA>"
    );
    for (mesh, text) in [("m.stl", stl), ("m.ply", ply), ("m.dae", dae)] {
        let folder = with_mesh(mesh, &text);
        let (valid, repairs) = judged(folder.path());
        assert!(!valid && repairs.contains("12 of 24 triangles left out"), "{mesh}: {repairs}");
    }
}

#[test]
fn a_mesh_that_cannot_be_repaired_is_refused_with_its_file_and_a_hint() {
    let text = fs::read_to_string(false_proofs().join("two_sided/m.obj")).unwrap();
    // Remove two of its faces, in both orientations.
    let open: Vec<&str> = text.lines().filter(|line| !["f 1 2 4", "f 4 2 1"].contains(line)).collect();
    let folder = with_mesh("m.obj", &open.join("\n"));
    let faults = check(&folder.path().to_string_lossy()).expect("a folder");
    let said = faults.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
    assert!(said.contains("m.obj") && said.contains("hole") && said.contains("convex hull"), "{said}");
}

#[test]
fn a_link_mesh_is_full_too_also_where_a_scale_mirrors_it() {
    for scale in ["1 1 1", "-1 1 1"] {
        let folder =
            with_mesh("m.obj", &fs::read_to_string(false_proofs().join("overlap_opposite/m.obj")).unwrap());
        let urdf = folder.path().join("r.urdf");
        let mesh = format!("<mesh filename=\"m.obj\" scale=\"{scale}\"/>");
        let text = fs::read_to_string(&urdf).unwrap().replace("<sphere radius=\"0.05\"/>", &mesh);
        fs::write(&urdf, &text).unwrap();
        let options = RobotOptions { meshes: MeshUse::Solid, ..RobotOptions::default() };
        let robot = Robot::load(&urdf, &options).unwrap();
        let solid = &robot.links().iter().find(|link| link.name == "b").unwrap().collisions[0].solid;
        let repairs = solid.mesh_repairs().unwrap();
        assert_eq!((repairs.flipped_triangles, repairs.doubled_triangles), (12, 0), "{scale}");
    }
}
