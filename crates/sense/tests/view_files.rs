use std::fs;
use std::path::Path;

use cranny_collision::{Body, World};
use cranny_robot::{Robot, RobotOptions};
use cranny_sense::{
    Camera, CameraFile, CameraFrame, DepthFormat, Noise, SensedScene, SensorModel, StoredView, Views,
};
use cranny_shape::Solid;
use cranny_spatial::{Point, Pose, Vector};

fn views(sensor: &SensorModel) -> Views {
    let ball = Body::new("ball: \"blue\"", Pose::translation(0.0, 0.1, 0.2), Solid::sphere(0.2).unwrap());
    let scene = SensedScene::of_world(&World::new(vec![ball, Body::floor(0.0)]).unwrap()).unwrap();
    let pose = Camera::looking_at(&Point::new(-1.0, 0.0, 0.6), &Point::origin(), &Vector::z()).unwrap();
    let camera = Camera::with_field_of_view([32, 24], 1.1, pose).unwrap();
    let stored = |name: &str, seed| StoredView {
        view: scene.view(name, &camera, sensor, &Noise { seed, ..Noise::default() }).unwrap(),
        segments: Some(scene.render(&camera).segments),
    };
    Views { views: vec![stored("left", 1), stored("right", 2)], segments: scene.segments().to_vec() }
}

fn write(folder: &Path, views: &Views, format: DepthFormat) {
    for file in views.files(format).unwrap() {
        fs::write(folder.join(file.name), file.content).unwrap();
    }
}

#[test]
fn written_views_are_read_back_within_the_stated_errors() {
    let folder = tempfile::tempdir().unwrap();
    let sensor = SensorModel { position_error_m: 0.002, turn_error_rad: 0.01, ..SensorModel::default() };
    let written = views(&sensor);
    for (format, rounding_m) in [(DepthFormat::Npy, 0.0), (DepthFormat::Png, 0.0005)] {
        write(folder.path(), &written, format);
        let read = Views::read(folder.path()).unwrap();
        assert_eq!(read.segments, written.segments);
        for (read, written) in read.views.iter().zip(&written.views) {
            assert_eq!((&read.view.name, &read.segments), (&written.view.name, &written.segments));
            let (pose, truth) = (read.view.camera.world_from_camera, written.view.camera.world_from_camera);
            assert!((pose.translation.vector - truth.translation.vector).norm() < 1e-15);
            assert!(pose.rotation.angle_to(&truth.rotation) < 1e-7);
            let (stated, own) = (read.view.sensor, written.view.sensor);
            assert!((stated.depth_error_m - own.depth_error_m - rounding_m).abs() < 1e-15);
            assert!((stated.turn_error_rad - own.turn_error_rad).abs() < 1e-15);
            let pairs = read.view.depth.depths_m().iter().zip(written.view.depth.depths_m());
            for (read_m, written_m) in pairs {
                assert_eq!(read_m.is_nan(), written_m.is_nan());
                let is_near = f64::from(read_m - written_m).abs() <= rounding_m + 1e-6;
                assert!(read_m.is_nan() || is_near, "{read_m} {written_m}");
            }
        }
    }
    assert_eq!(Views::read(&folder.path().join("views.yaml")).unwrap(), Views::read(folder.path()).unwrap());
}

/// Writes the views after a change of one file, and returns the error.
fn fault_of(name: &str, change: impl Fn(Vec<u8>) -> Vec<u8>) -> String {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &views(&SensorModel::default()), DepthFormat::Png);
    let path = folder.path().join(name);
    fs::write(&path, change(fs::read(&path).unwrap())).unwrap();
    let fault = Views::read(folder.path()).unwrap_err().to_string();
    fault.replace(&format!("{}/", folder.path().display()), "")
}

fn fault_of_text(from: &'static str, to: &'static str) -> String {
    fault_of("views.yaml", |content| {
        let text = String::from_utf8(content).unwrap();
        assert!(text.contains(from));
        text.replacen(from, to, 1).into_bytes()
    })
}

#[test]
fn unfit_views_are_refused_with_file_and_line() {
    for (from, to, words) in [
        (
            "cranny-views/1",
            "cranny-views/9",
            "views.yaml:1: the format is 'cranny-views/1', not 'cranny-views/9'",
        ),
        ("width: 32", "width: 31", "left.depth.png: the image has 32 × 24 pixels, but its camera 31 × 24"),
        ("width: 32", "width: 99999", "views.yaml:3: camera 'left': the width in pixels"),
        ("name: right", "name: LEFT", "the name 'LEFT' is taken by a camera before"),
        ("name: left", "name: ../left", "letters, digits"),
        ("    depth: left.depth.png\n", "", "view 'left' has no file of depths"),
        ("depth: left.depth.png", "depth: ../left.png", "give the name of a file in the folder"),
        ("depth_unit_m: 0.001", "depth_unit_m: 0", "depth_unit_m is above 0, at most 1, not 0"),
        ("    focal_px:", "    focal:", "unknown field `focal`"),
        ("lateral_error_px: 0.5", "lateral_error_px: -1", "lateral_error_px of a sensor must be 0 to 16"),
        (
            "quaternion_xyzw: [",
            "quaternion_xyzw: [9, 9, 9, 9] # [",
            "camera 'left': the quaternion has length",
        ),
        ("depth: left.depth.png", "depth: lost.png", "lost.png: cannot be read: file not found"),
    ] {
        let fault = fault_of_text(from, to);
        assert!(fault.contains(words), "no '{words}' in: {fault}");
    }
    // The images are not read before.
    let large = fault_of("views.yaml", |content| {
        let text = String::from_utf8(content).unwrap();
        text.replacen("width: 32", "width: 8192", 1).replacen("height: 24", "height: 513", 1).into_bytes()
    });
    assert!(large.starts_with("views.yaml:3: ") && large.contains("--large-files"), "{large}");
    let cut = fault_of("left.depth.png", |content| content[..content.len() / 2].to_vec());
    assert!(cut.starts_with("left.depth.png: no valid PNG: "), "{cut}");
    let text = fault_of("left.depth.png", |_| b"depths".to_vec());
    assert!(text.contains("one channel of 16 bits or a NumPy array"), "{text}");
    let none = fault_of("views.yaml", |_| b"format: cranny-views/1\nviews: []\n".to_vec());
    assert!(none.contains("the list of views is empty"), "{none}");
    let empty = fault_of("views.yaml", |_| Vec::new());
    assert!(empty.contains("the file is empty"), "{empty}");
}

/// The header of a PNG states its size; nothing of that size may be allocated before it is compared.
#[test]
fn an_image_with_a_false_size_is_refused_without_memory_for_it() {
    let fault = fault_of("left.depth.png", |mut content| {
        content[16..20].copy_from_slice(&0x7fff_ffff_u32.to_be_bytes());
        content
    });
    assert!(fault.starts_with("left.depth.png: "), "{fault}");
    let segments = fault_of("left.segments.png", |_| fs::read(png_of_bytes().path()).unwrap());
    assert!(
        segments.contains("one channel of 16 bits is read, but this PNG is Grayscale of 8 bits"),
        "{segments}"
    );
}

fn png_of_bytes() -> tempfile::NamedTempFile {
    let file = tempfile::NamedTempFile::new().unwrap();
    let mut encoder = png::Encoder::new(file.reopen().unwrap(), 32, 24);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.write_header().unwrap().write_image_data(&[0; 32 * 24]).unwrap();
    file
}

#[test]
fn arrays_of_any_type_and_order_are_read() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &views(&SensorModel::default()), DepthFormat::Npy);
    let expected = Views::read(folder.path()).unwrap();
    let depth = &expected.views[0].view.depth;
    // Millimetres as u16, the first index fastest.
    let mut bytes = cranny_file::npy_header("<u2", &[24, 32]);
    let text = String::from_utf8_lossy(&bytes[10..]).replace("False", "True ");
    bytes.truncate(10);
    bytes.extend(text.bytes());
    for u in 0..32 {
        for v in 0..24 {
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "below 65 m")]
            let millimetres = depth.depth_m(u, v).map_or(0, |depth_m| (depth_m * 1000.0).round() as u16);
            bytes.extend(millimetres.to_le_bytes());
        }
    }
    fs::write(folder.path().join("left.depth.npy"), &bytes).unwrap();
    let yaml = folder.path().join("views.yaml");
    let text = fs::read_to_string(&yaml).unwrap().replacen("depth_unit_m: 1", "depth_unit_m: 0.001", 1);
    fs::write(&yaml, text).unwrap();
    let read = Views::read(folder.path()).unwrap();
    let pairs = depth.depths_m().iter().zip(read.views[0].view.depth.depths_m());
    assert!(pairs.clone().all(|(a, b)| (a.is_nan() && b.is_nan()) || (a - b).abs() <= 0.000_501));
    fs::write(folder.path().join("left.depth.npy"), &bytes[..bytes.len() - 1]).unwrap();
    assert!(Views::read(folder.path()).unwrap_err().to_string().contains("cut short"));
    bytes.push(0);
    fs::write(folder.path().join("left.depth.npy"), &bytes).unwrap();
    assert!(Views::read(folder.path()).unwrap_err().to_string().contains("bytes follow"));
}

fn cameras(text: &str) -> Result<CameraFile, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cameras.yaml");
    fs::write(&path, text).unwrap();
    CameraFile::read(&path).map_err(|fault| fault.to_string())
}

#[test]
fn cameras_stand_in_the_world_or_on_a_link() {
    let file = cameras(
        "sensor: {depth_error_m: 0.002}
cameras:
  - {name: left, width: 320, height: 240, field_of_view_deg: 60, position_m: [0, -1, 1], look_at_m: [0, 0, 1]}
  - name: hand
    width: 64
    height: 48
    focal_px: [50, 51.5]
    center_px: [30, 20]
    frame: link palm
    position_m: [0.05, 0, 0]
    rotation_rpy_deg: [0, 0, 90]
    sensor: {farthest_m: 2, turn_error_deg: 1}
",
    )
    .unwrap();
    let [left, hand] = &file.cameras[..] else { panic!("two cameras") };
    assert_eq!(
        (left.frame.clone(), hand.frame.clone()),
        (CameraFrame::World, CameraFrame::Link("palm".to_owned()))
    );
    assert!(
        (left.sensor.depth_error_m - 0.002).abs() < 1e-15 && (left.sensor.farthest_m - 5.0).abs() < 1e-15
    );
    assert!((hand.sensor.turn_error_rad - 1_f64.to_radians()).abs() < 1e-15);
    assert!((left.camera.world_from_camera.rotation * Vector::z() - Vector::y()).norm() < 1e-12);
    let urdf = cranny_test_robots::plane_arm();
    let robot = Robot::from_urdf_text(&urdf, "arm.urdf", None, &RobotOptions::default()).unwrap();
    let q = vec![0.1; robot.dof()];
    let camera = hand.at(&robot, &q).unwrap();
    let link = robot.frames_at(&q);
    let link = link.link(robot.link_index("palm").unwrap());
    assert!(
        (camera.world_from_camera.translation.vector - (link * Point::new(0.05, 0.0, 0.0)).coords).norm()
            < 1e-12
    );
    let mut lost = hand.clone();
    lost.frame = CameraFrame::Link("plam".to_owned());
    let fault = lost.at(&robot, &q).unwrap_err().to_string();
    assert!(
        fault.contains("camera 'hand': the robot has no link 'plam'")
            && fault.contains("did you mean 'palm'")
    );
}

#[test]
fn unfit_cameras_are_refused_with_their_line() {
    let with = |keys: &str| {
        cameras(&format!("cameras:\n  - {{name: a, width: 32, height: 24, {keys}}}\n")).unwrap_err()
    };
    for (keys, words) in [
        ("focal_px: 30", "missing field `position_m`"),
        (
            "position_m: [0, 0, 0], look_at_m: [1, 0, 0]",
            ":2: camera 'a': give either focal_px or field_of_view_deg",
        ),
        (
            "focal_px: 30, position_m: [0, 0, 0]",
            "exactly one of look_at_m, rotation_rpy_deg and quaternion_xyzw",
        ),
        ("focal_px: 30, position_m: [0, 0, 0], look_at_m: [0, 0, 0]", "must differ from position_m"),
        (
            "focal_px: 30, position_m: [0, 0, 0], up: [0, 0, 1], rotation_rpy_deg: [0, 0, 0]",
            "up needs look_at_m",
        ),
        ("focal_px: [1, 2, 3], position_m: [0, 0, 0]", "a number, or a list of two"),
        ("focal_px: wide, position_m: [0, 0, 0]", "a number, or a list of two"),
        (
            "focal_px: 0, position_m: [0, 0, 0], look_at_m: [1, 0, 0]",
            "focal length in pixels of a camera must be above 0",
        ),
        (
            "field_of_view_deg: 180, position_m: [0, 0, 0], look_at_m: [1, 0, 0]",
            "above 0 and below 180, but is 180",
        ),
        ("focal_px: 30, position_m: [.nan, 0, 0], look_at_m: [1, 0, 0]", "finite"),
        (
            "focal_px: 30, frame: palm, position_m: [0, 0, 0], look_at_m: [1, 0, 0]",
            ":2: the frame of a camera is `world`",
        ),
        ("focal_px: 30, depth: a.png, position_m: [0, 0, 0], look_at_m: [1, 0, 0]", "under `views`"),
        ("focal_px: 30, lens: 3, position_m: [0, 0, 0], look_at_m: [1, 0, 0]", "unknown field `lens`"),
    ] {
        let fault = with(keys);
        assert!(fault.contains(words), "no '{words}' in: {fault}");
    }
    assert!(cameras("cameras: []").unwrap_err().contains("the list of cameras is empty"));
    assert!(cameras("").unwrap_err().contains("the file is empty"));
}
