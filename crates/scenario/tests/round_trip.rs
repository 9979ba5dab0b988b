//! Round trips of the released scenarios through Cranny's files.

use std::fs;
use std::io::{Write as _, stderr};
use std::path::{Path, PathBuf};

use cranny_collision::Body;
use cranny_scenario::{Geometry, OpenOptions, Recipe, Scenario};
use cranny_shape::{TriangleSoup, VolumeMoments};
use cranny_spatial::{PoseDifference, Vector};
use cranny_task::Criterion;

/// Returns the folder of the released data; `None`, with a message, if there is none.
fn data() -> Option<PathBuf> {
    let data = std::env::var_os("CRANNY_DATA").map(PathBuf::from);
    if data.is_none() {
        assert!(std::env::var_os("CRANNY_REQUIRE_ALL").is_none(), "CRANNY_DATA is not set");
        let _ = writeln!(stderr(), "SKIPPED: CRANNY_DATA is not set, so no released scenario goes round");
    }
    data.map(|data| data.join("jogramop"))
}

fn open(folder: &Path, robot: Option<&Path>) -> Scenario {
    let options = OpenOptions { robot: robot.map(Path::to_owned), ..OpenOptions::default() };
    Scenario::open(folder.to_str().unwrap(), &options).unwrap()
}

/// Returns bounds in the planning frame, and volume, of an obstacle's cuboids.
fn measure(body: &Body) -> (Vector, Vector, f64) {
    let mut low = Vector::repeat(f64::INFINITY);
    let (mut high, mut volume_m3) = (-low, 0.0);
    for part in &body.parts {
        let half = part.solid.as_cuboid().expect("obstacles are cuboids");
        let aabb = part.solid.aabb().transformed(&part.world_from_solid);
        low = low.inf(&aabb.low().coords);
        high = high.sup(&aabb.high().coords);
        volume_m3 += 8.0 * half.x * half.y * half.z;
    }
    (low, high, volume_m3)
}

#[test]
fn all_twenty_come_back_as_they_were() {
    let Some(data) = data() else { return };
    let root = tempfile::tempdir().unwrap();
    for (environment, level) in (1..=4).flat_map(|e| (1..=5).map(move |l| (e, l))) {
        let id = format!("0{environment}{level}");
        let source = data.join("scenarios").join(&id);
        let original = open(&source, None);
        // Import.
        let own = root.path().join("own").join(&id);
        Recipe::import_released(&source).unwrap().write_folder(&own).unwrap();
        let imported = open(&own, None);
        same(&original, &imported, &id);
        // Export.
        let released = root.path().join("scenarios").join(&id);
        Recipe::of_scenario(&imported).unwrap().write_released(&released).unwrap();
        let exported = open(&released, None);
        same(&original, &exported, &id);
        // The array alone, in single precision.
        fs::remove_file(released.join("export/grasps.csv")).unwrap();
        same_grasps(&original, &open(&released, None), &id);
        // The merged mesh contains target and obstacles, as volumes.
        let merged = TriangleSoup::load(&released.join("export/obstacles.obj"), Vector::repeat(1.0)).unwrap();
        let target_m3 = volume_of_target(&original);
        let obstacles_m3: f64 = obstacles(&original).map(|body| measure(body).2).sum();
        let volume_m3 = VolumeMoments::of_mesh(&merged).unwrap().volume_m3;
        assert!((volume_m3 - target_m3 - obstacles_m3).abs() < 1e-6, "{id}: {volume_m3}");
        let options = OpenOptions {
            criterion: Some(Criterion::Paper),
            geometry: Some(Geometry::Export),
            ..OpenOptions::default()
        };
        fs::copy(source.join("export/grasps.csv"), released.join("export/grasps.csv")).unwrap();
        assert!(Scenario::open(released.to_str().unwrap(), &options).unwrap().export.is_some());
    }
}

fn obstacles(scenario: &Scenario) -> impl Iterator<Item = &Body> {
    let target = scenario.target.unwrap();
    scenario.world.bodies()[..target].iter()
}

fn volume_of_target(scenario: &Scenario) -> f64 {
    let target = &scenario.world.bodies()[scenario.target.unwrap()];
    let (corners, _) = target.parts[0].solid.bounding_points().unwrap();
    VolumeMoments::of_mesh(&TriangleSoup::from_corners(corners).unwrap()).unwrap().volume_m3
}

fn same(first: &Scenario, second: &Scenario, id: &str) {
    assert_eq!((&first.start, &first.ik, first.target), (&second.start, &second.ik, second.target), "{id}");
    same_grasps(first, second, id);
    assert_eq!(obstacles(first).count(), obstacles(second).count(), "{id}");
    for (a, b) in obstacles(first).zip(obstacles(second)) {
        let ((low_a, high_a, volume_a), (low_b, high_b, volume_b)) = (measure(a), measure(b));
        assert!((low_a - low_b).amax() < 1e-6 && (high_a - high_b).amax() < 1e-6, "{id} {}", a.name);
        assert!((volume_a - volume_b).abs() < 1e-6, "{id} {}: {volume_a} {volume_b}", a.name);
    }
    let target = |scenario: &Scenario| {
        let part = scenario.world.bodies()[scenario.target.unwrap()].parts[0].clone();
        let aabb = part.solid.aabb().transformed(&part.world_from_solid);
        (aabb.low().coords, aabb.high().coords)
    };
    let ((low_a, high_a), (low_b, high_b)) = (target(first), target(second));
    assert!((low_a - low_b).amax() < 1e-6 && (high_a - high_b).amax() < 1e-6, "{id} target");
    assert!((volume_of_target(first) - volume_of_target(second)).abs() < 1e-6, "{id} target");
}

fn same_grasps(first: &Scenario, second: &Scenario, id: &str) {
    assert_eq!(first.grasps.len(), second.grasps.len(), "{id}");
    for (a, b) in first.grasps.grasps().iter().zip(second.grasps.grasps()) {
        let apart = PoseDifference::between(&a.world_from_gripper, &b.world_from_gripper);
        assert!(apart.translation_m < 1e-6 && apart.rotation_rad < 1e-6, "{id}: {apart:?}");
    }
}
