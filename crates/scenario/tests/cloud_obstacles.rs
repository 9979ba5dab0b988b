//! Clouds of points as obstacles.

use std::fs;
use std::path::Path;

use cranny_scenario::{CloudCounts, OpenOptions, Scenario};
use cranny_sense::PointCloud;
use cranny_spatial::Point;

const BEGIN: &str = "robot: panda_mobile
start: [0, 0, -0.0178, -0.7601, 0.0198, -2.3421, 0.0298, 1.5412, 0.7534]
floor: -0.05
frame: {position: [0, 1, 0]}
target: {name: can, pose: {position: [0.5, 0, 0.3]}, shapes: [cylinder: {radius: 0.03, length: 0.1}]}
";

const POINTS: [[f32; 3]; 3] = [[1.0, 0.0, 0.5], [1.001, 0.0, 0.5], [1.0, 0.5, 0.25]];

fn open(folder: &Path, text: &str) -> Result<Scenario, String> {
    fs::write(folder.join("shelf.pcd"), PointCloud::of(POINTS.to_vec()).pcd_bytes()).unwrap();
    fs::write(folder.join("scenario.yaml"), format!("{BEGIN}{text}")).unwrap();
    Scenario::open(folder.to_str().unwrap(), &OpenOptions::default()).map_err(|fault| fault.to_string())
}

fn obstacle(cloud: &str) -> String {
    format!(
        "obstacles:\n  - {{name: shelf, pose: {{position: [0, 0, 0.1]}}, shapes: [cloud: {{{cloud}}}]}}\n"
    )
}

#[test]
fn a_cloud_is_a_ball_around_each_point_at_its_pose() {
    let folder = tempfile::tempdir().unwrap();
    for (keys, count, radius_m) in [
        ("file: shelf.pcd, radius_m: 0.004", 3, 0.004),
        // The two near points share a voxel.
        ("file: shelf.pcd, radius_m: 0.004, voxel_m: 0.01", 2, 0.004 + 0.01 * 3_f64.sqrt()),
    ] {
        let scenario = open(folder.path(), &obstacle(keys)).unwrap();
        let part = &scenario.world.bodies()[0].parts[0];
        let union = part.solid.as_union().unwrap();
        assert_eq!(union.len(), count);
        assert!((union.radius_m() - radius_m).abs() < 1e-12);
        let nearest_m = |point: Point| {
            union.boxes().map(|aabb| (part.world_from_solid * aabb.center - point).norm()).fold(1.0, f64::min)
        };
        // The root of the robot is at (0, 1, 0) in the scene.
        assert!(nearest_m(Point::new(1.0, -1.0, 0.6)) < 1e-6);
        assert!(nearest_m(Point::new(1.0, -0.5, 0.35)) < 1e-6);
    }
}

#[test]
fn a_cloud_alone_is_an_obstacle_with_the_name_of_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let long = open(folder.path(), &obstacle("file: shelf.pcd, radius_m: 0.004, voxel_m: 0.01")).unwrap();
    let short = "{pose: {position: [0, 0, 0.1]}, cloud: shelf.pcd, radius_m: 0.004, voxel_m: 0.01}";
    let second = "{name: other, cloud: shelf.pcd, radius_m: 0.002}";
    let short = open(folder.path(), &format!("obstacles:\n  - {short}\n  - {second}\n")).unwrap();
    let names: Vec<&str> = short.world.bodies().iter().map(|body| body.name.as_str()).collect();
    assert_eq!(names, ["shelf", "other", "can", "floor"]);
    let part = |scenario: &Scenario| scenario.world.bodies()[0].parts[0].clone();
    let boxes = |scenario: &Scenario| part(scenario).solid.as_union().unwrap().boxes().collect::<Vec<_>>();
    assert_eq!(part(&short).world_from_solid, part(&long).world_from_solid);
    assert_eq!(boxes(&short), boxes(&long));
    assert_eq!(short.clouds[0], long.clouds[0]);
    assert_eq!((short.clouds[1].thinned, short.clouds[1].kept), (0, 3));
}

#[test]
fn points_that_are_left_out_are_counted() {
    let folder = tempfile::tempdir().unwrap();
    open(folder.path(), "").unwrap();
    let mut points = POINTS.to_vec();
    points.extend([[f32::NAN, 0.0, 0.0], [0.0, f32::INFINITY, 0.0]]);
    fs::write(folder.path().join("holes.pcd"), PointCloud::of(points).pcd_bytes()).unwrap();
    let scenario =
        open(folder.path(), "obstacles: [{cloud: holes.pcd, radius_m: 0.004, voxel_m: 0.01}]").unwrap();
    let expected = CloudCounts {
        body: "holes".to_owned(),
        file: "holes.pcd".to_owned(),
        points: 5,
        not_finite: 2,
        thinned: 1,
        kept: 2,
    };
    assert_eq!(scenario.clouds, [expected]);
}

#[test]
fn clouds_that_are_no_obstacles_are_refused_with_their_line() {
    let folder = tempfile::tempdir().unwrap();
    for (text, words) in [
        (obstacle("file: shelf.pcd, radius_m: 0"), "scenario.yaml:7: "),
        (obstacle("file: shelf.pcd, radius_m: 0"), "the radius of the points of a cloud"),
        (obstacle("file: shelf.pcd"), "missing field `radius_m`"),
        (obstacle("file: lost.pcd, radius_m: 0.004"), "scenario.yaml:7: "),
        (obstacle("file: shelv.pcd, radius_m: 0.004"), "file not found; did you mean"),
        (obstacle("file: scenario.yaml, radius_m: 0.004"), "no point cloud that is read"),
        (
            obstacle("file: shelf.pcd, radius_m: 0.004, voxel_m: -1"),
            "the side of a voxel, in metres, of a filter must be positive",
        ),
        ("obstacles: [{cloud: shelf.pcd}]\n".to_owned(), "missing field `radius_m`"),
        ("obstacles: [{name: a}]\n".to_owned(), "missing field `shapes`"),
        ("obstacles: [{shapes: []}]\n".to_owned(), "missing field `name`"),
        (
            "obstacles: [{name: a, shapes: [], radius_m: 0.1}]\n".to_owned(),
            "`radius_m`, `voxel_m` and `colour` of a body need `cloud: FILE`",
        ),
        (
            "obstacles: [{name: a, shapes: [], cloud: shelf.pcd, radius_m: 0.1}]\n".to_owned(),
            "a body has either `shapes` or a `cloud`",
        ),
        ("obstacles: [{cloud: lost.pcd, radius_m: 0.004}]\n".to_owned(), "scenario.yaml:6: "),
        ("obstacles: [{cloud: shelf.pcd, radius_m: 0.004, side: 1}]\n".to_owned(), "side"),
    ] {
        let fault = open(folder.path(), &text).unwrap_err();
        assert!(fault.contains(words), "no '{words}' in: {fault}");
    }
    fs::write(folder.path().join("scenario.yaml"), "").unwrap();
    let target =
        BEGIN.replace("cylinder: {radius: 0.03, length: 0.1}", "cloud: {file: shelf.pcd, radius_m: 0.004}");
    fs::write(folder.path().join("scenario.yaml"), target).unwrap();
    let fault =
        Scenario::open(folder.path().to_str().unwrap(), &OpenOptions::default()).unwrap_err().to_string();
    assert!(fault.contains(":5: a cloud of points as the target is not supported (give its mesh"), "{fault}");
}
