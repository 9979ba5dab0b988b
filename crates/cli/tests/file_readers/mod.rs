//! Readers of external input: files, answers of external programs, requests to a page. The fuzz targets (`fuzz/`) and
//! `any_bytes.rs` feed them with malformed input, which a reader may refuse; it must return.

mod asked_page;
mod stored_results;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use cranny_bench::{Campaign, read_output};
use cranny_grasp::{ImportSettings, check_csv, import_grasps};
use cranny_plan::Registry;
use cranny_record::read_waypoints;
use cranny_robot::{ModelText, ModelUse, Robot, RobotOptions, TextSource};
use cranny_scenario::{
    Credits, MoveItOptions, MoveItProblem, MoveItRobot, ObjectType, OpenOptions, Scenario, check_folder,
    moveit_document, pack, read_gripper, unpack,
};
use cranny_sense::{CameraFile, Octree, PointCloud, StoredView, Views};
use cranny_shape::{RepairedMesh, Solid, TriangleSoup};
use cranny_spatial::Vector;
use cranny_task::Stage;
use cranny_view::{BodyRecording, Scene};

/// Reader of one kind of file.
pub struct FileReader {
    /// Name of its fuzz target and of the folder of its cases.
    pub name: &'static str,
    /// Sound file that is replaced.
    pub file: &'static str,
    /// Reads that file, in a folder with all sound files.
    read: fn(&Path),
}

const fn reader(name: &'static str, file: &'static str, read: fn(&Path)) -> FileReader {
    FileReader { name, file, read }
}

/// All readers.
pub const FILE_READERS: [FileReader; 40] = [
    reader("urdf", "robot/arm.urdf", read_robot),
    reader("mjcf", "model/arm.xml", |folder| read_model(&folder.join("model/arm.xml"))),
    reader("sdf", "model/arm.sdf", |folder| read_model(&folder.join("model/arm.sdf"))),
    reader("srdf", "robot/arm.srdf", read_robot),
    reader("limits", "robot/limits.yaml", read_robot),
    reader("hand", "robot/robot.yaml", read_robot),
    reader("obj", "mesh/mesh.obj", |folder| read_mesh(&folder.join("mesh/mesh.obj"))),
    reader("stl", "mesh/mesh.stl", |folder| read_mesh(&folder.join("mesh/mesh.stl"))),
    reader("ply", "mesh/mesh.ply", |folder| read_mesh(&folder.join("mesh/mesh.ply"))),
    reader("msh", "mesh/mesh.msh", |folder| read_mesh(&folder.join("mesh/mesh.msh"))),
    reader("dae", "mesh/mesh.dae", |folder| read_mesh(&folder.join("mesh/mesh.dae"))),
    reader("scenario", "own/scenario.yaml", read_own),
    reader("grasps_csv", "own/grasps.csv", |folder| {
        let path = folder.join("own/grasps.csv");
        if let Ok(text) = fs::read_to_string(&path) {
            let _ = check_csv(&path, &text);
        }
    }),
    reader("grasps_npy", "released/scenarios/desk/grasps.npy", read_released),
    reader("import_hdf5", "import/acronym.h5", |folder| import(&folder.join("import/acronym.h5"))),
    reader("import_npz", "import/poses.npz", |folder| import(&folder.join("import/poses.npz"))),
    reader("import_json", "import/graspgen.json", |folder| import(&folder.join("import/graspgen.json"))),
    reader("scene", "released/scenarios/desk/scene.yaml", read_released),
    reader("object_library", "released/library/object_library.yaml", read_released),
    reader("moveit_scene", "moveit/scene.yaml", read_moveit),
    reader("moveit_request", "moveit/request.yaml", read_moveit),
    reader("moveit_document", "moveit/document.json", read_moveit_document),
    reader("plan", "plan.json", |folder| {
        let _ = read_waypoints(&folder.join("plan.json"), 9);
    }),
    reader("recording", "recording.json", |folder| {
        if let Ok(recording) = BodyRecording::read(&folder.join("recording.json")) {
            let _ = Scene::of_moving_bodies(&recording.thinned(20.0));
        }
    }),
    reader("waypoints", "waypoints.csv", |folder| {
        let _ = read_waypoints(&folder.join("waypoints.csv"), 2);
    }),
    reader("archive", "corner.zip", |folder| {
        let unpacked = folder.join("unpacked");
        let _ = unpack(&folder.join("corner.zip"), &unpacked);
        let _ = fs::remove_dir_all(&unpacked);
    }),
    reader("gripper", "gripper.yaml", |folder| {
        let _ = read_gripper(&folder.join("gripper.yaml"));
    }),
    reader("object", "object/object.yaml", |folder| {
        let _ = ObjectType::read_folder(&folder.join("object"));
    }),
    reader("folder", "folder.txt", read_folder),
    reader("campaign", "campaign.yaml", |folder| {
        let _ = Campaign::read(&folder.join("campaign.yaml"), &Registry::default());
    }),
    reader("exec_answer", "answer.json", |folder| {
        let _ = read_output(
            &fs::read(folder.join("answer.json")).unwrap_or_default(),
            2,
            &[Stage::pick(), Stage::home()],
        );
    }),
    reader("released_answer", "trial.txt", read_released_answer),
    reader("results", "results.changes", stored_results::read),
    reader("cameras", "sense/cameras.yaml", |folder| {
        let _ = CameraFile::read(&folder.join("sense/cameras.yaml"));
    }),
    reader("views", "sense/views.yaml", read_views),
    reader("depth_image", "sense/left.depth.png", read_views),
    reader("cloud_pcd", "sense/cloud.pcd", |folder| read_cloud(&folder.join("sense/cloud.pcd"))),
    reader("cloud_ply", "sense/cloud.ply", |folder| read_cloud(&folder.join("sense/cloud.ply"))),
    reader("octree", "sense/octree.bt", |folder| {
        let _ = Octree::read(&folder.join("sense/octree.bt"));
    }),
    reader("question", "question.json", asked_page::ask),
];

fn read_views(folder: &Path) {
    if let Ok(views) = Views::read(&folder.join("sense")) {
        for StoredView { view, .. } in &views.views {
            let _ = view.cloud().thinned(0.01);
        }
    }
}

fn read_cloud(path: &Path) {
    if let Ok(read) = PointCloud::read(path) {
        let _ = read.cloud.thinned(0.001);
    }
}

fn import(path: &Path) {
    let _ = import_grasps(path, &ImportSettings::default());
}

/// Reads a whole folder: each of its files begins with a line `=== name`.
fn read_folder(folder: &Path) {
    let listed = fs::read(folder.join("folder.txt")).unwrap_or_default();
    let listed = String::from_utf8_lossy(&listed);
    let whole = folder.join("whole");
    for (name, content) in listed.split("=== ").filter_map(|file| file.split_once('\n')) {
        let is_plain = |part: &str| {
            !part.is_empty() && part.len() < 50 && part != ".." && part.chars().all(|c| c.is_ascii_graphic())
        };
        let path = whole.join(name);
        if name.split('/').all(is_plain)
            && path.starts_with(&whole)
            && fs::create_dir_all(path.parent().unwrap_or(&whole)).is_ok()
        {
            let _ = fs::write(path, content);
        }
    }
    let _ = check_folder(&whole);
    let _ = pack(&whole, &folder.join("whole.zip"), &Credits::default());
    let _ = fs::remove_dir_all(&whole);
}

/// Reads the summary and, after a line `===`, the way points.
fn read_released_answer(folder: &Path) {
    let both = fs::read(folder.join("trial.txt")).unwrap_or_default();
    let separator = b"===\n";
    let at = both.windows(separator.len()).position(|window| window == separator);
    let (summary, path) = at.map_or((&both[..], &b""[..]), |at| (&both[..at], &both[at + separator.len()..]));
    fs::write(folder.join("answer.txt"), summary).expect("a file to read");
    fs::write(folder.join("answer.try"), path).expect("a file to read");
    let _ = cranny_bench::read_released(&folder.join("answer"), 2);
}

fn read_robot(folder: &Path) {
    let srdf = Some(TextSource::Path(folder.join("robot/arm.srdf")));
    let _ = Robot::load(&folder.join("robot/arm.urdf"), &RobotOptions { srdf, ..RobotOptions::default() });
}

/// Reads a model as robot and as world.
fn read_model(path: &Path) {
    let _ = Robot::load(path, &RobotOptions::default());
    if let Ok(model) = ModelText::read(path, ModelUse::World, &[]) {
        let _ = model.world_links(path, &[], &BTreeMap::new());
    }
}

/// Reads a mesh as obstacles, links and objects do.
fn read_mesh(path: &Path) {
    if let Ok(soup) = TriangleSoup::load(path, Vector::repeat(1.0)) {
        let _ = Solid::hull(&soup.vertices);
        let _ = Solid::mesh(&soup);
        let _ = RepairedMesh::of(&soup);
    }
}

fn read_own(folder: &Path) {
    let own = folder.join("own");
    let _ = check_folder(&own);
    let _ = Scenario::open(&own.to_string_lossy(), &OpenOptions::default());
}

fn read_released(folder: &Path) {
    let desk = folder.join("released/scenarios/desk");
    let _ = Scenario::open(&desk.to_string_lossy(), &OpenOptions::default());
}

fn read_moveit(folder: &Path) {
    let options = MoveItOptions {
        robot: Some(folder.join("robot/arm.urdf")),
        srdf: Some(folder.join("robot/arm.srdf")),
    };
    let _ =
        MoveItProblem::open(&folder.join("moveit/scene.yaml"), &folder.join("moveit/request.yaml"), &options);
}

fn read_moveit_document(folder: &Path) {
    let text = fs::read(folder.join("moveit/document.json")).unwrap_or_default();
    let document = moveit_document(&String::from_utf8_lossy(&text));
    let robot = MoveItRobot::open(&folder.join("robot/arm.urdf"), Some(&folder.join("robot/arm.srdf")));
    if let (Ok(document), Ok(mut robot)) = (document, robot) {
        let _ = MoveItProblem::of_document(document, &mut robot);
    }
}

/// Reader with a folder of its own for the sound files.
pub struct ReaderAtWork {
    reader: &'static FileReader,
    folder: tempfile::TempDir,
}

impl ReaderAtWork {
    /// Creates the reader of this name.
    ///
    /// # Panics
    /// If there is no such reader, or no folder can be created.
    pub fn new(name: &str) -> Self {
        let reader = FILE_READERS.iter().find(|reader| reader.name == name).expect("a reader of this name");
        let folder = tempfile::tempdir().expect("a folder of its own");
        copy_all(&here().join("sound"), folder.path());
        Self { reader, folder }
    }

    /// Reads `bytes` instead of the sound file.
    ///
    /// # Panics
    /// If the reader panics, or the file cannot be written.
    pub fn read(&self, bytes: &[u8]) {
        fs::write(self.folder.path().join(self.reader.file), bytes).expect("a file to read");
        (self.reader.read)(self.folder.path());
    }
}

/// Returns the folder of this module.
pub fn here() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(super::HERE)
}

fn copy_all(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("a folder");
    for entry in fs::read_dir(from).expect("the sound files") {
        let path = entry.expect("a sound file").path();
        let copy = to.join(path.file_name().expect("a name"));
        if path.is_dir() {
            copy_all(&path, &copy);
        } else {
            fs::copy(&path, &copy).expect("a copy");
        }
    }
}
