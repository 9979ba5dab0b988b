//! Grasp files of other projects: poses in our gripper frame, masks respected, and nothing trusted.

use std::io::Write as _;
use std::path::PathBuf;

use cranny_grasp::{
    ClosingAxis, FRANKA_PADS_M, FRANKA_TIPS_TO_PADS_M, GraspFormat, ImportSettings, Imported, import_grasps,
};
use cranny_spatial::{Point, Pose, Vector};

/// Temporary folder, with a reader of the files in it.
pub struct Files(tempfile::TempDir);

impl Files {
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("a folder"))
    }

    fn write(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, bytes).expect("written");
        path
    }

    pub fn read(&self, bytes: &[u8], settings: &ImportSettings) -> Result<Imported, String> {
        import_grasps(&self.write("file", bytes), settings).map_err(|fault| {
            let fault = fault.to_string();
            assert!(fault.contains("file: "), "{fault}");
            fault
        })
    }
}

pub fn npy(shape: &[u64], numbers: &[f64]) -> Vec<u8> {
    let mut bytes = cranny_file::npy_header("<f8", shape);
    bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    bytes
}

pub fn npz(arrays: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for (name, array) in arrays {
        archive
            .start_file(format!("{name}.npy"), zip::write::SimpleFileOptions::default())
            .expect("an entry");
        archive.write_all(array).expect("bytes");
    }
    archive.finish().expect("an archive").into_inner()
}

/// Pose rotated by 90° about x, at (1, 2, 3) m.
pub const QUARTER: [f64; 16] =
    [1.0, 0.0, 0.0, 1.0, 0.0, 0.0, -1.0, 2.0, 0.0, 1.0, 0.0, 3.0, 0.0, 0.0, 0.0, 1.0];

pub fn json(transforms: &[[f64; 16]], labels: &str) -> Vec<u8> {
    let rows = |pose: &[f64; 16]| {
        let rows: Vec<String> = pose.chunks(4).map(|row| format!("{row:?}")).collect();
        format!("[{}]", rows.join(","))
    };
    let transforms: Vec<String> = transforms.iter().map(rows).collect();
    format!(
        "{{\"object\": {{\"file\": \"mug.obj\", \"scale\": 0.5}}, \"grasps\": {{\"transforms\": [{}]{labels}, \"score\": [0.1]}}}}",
        transforms.join(",")
    )
    .into_bytes()
}

/// Origin, closing axis and approach direction of a gripper at a pose.
fn axes(pose: &Pose) -> (Point, Vector, Vector) {
    (pose * Point::origin(), pose * Vector::y(), pose * Vector::z())
}

#[track_caller]
pub fn assert_axes(pose: &Pose, origin: [f64; 3], closing: [f64; 3], approach: [f64; 3]) {
    let (at, y, z) = axes(pose);
    let is_near = |a: Vector, b: [f64; 3]| (a - Vector::from(b)).norm() < 1e-9;
    assert!(is_near(at.coords, origin), "{at} is not {origin:?}");
    // Half a turn exchanges the fingers.
    assert!(is_near(y, closing) || is_near(-y, closing), "{y} is not {closing:?}");
    assert!(is_near(z, approach), "{z} is not {approach:?}");
}

#[test]
fn graspgen_closes_along_x_and_counts_from_the_base_of_the_hand() {
    let files = Files::new();
    let two = json(&[QUARTER, QUARTER], ", \"object_in_gripper\": [true, 0]");
    let read = files.read(&two, &ImportSettings::default()).expect("grasps");
    assert_eq!(
        (read.format, read.closing, read.object_scale),
        (GraspFormat::Graspgen, ClosingAxis::X, Some(0.5))
    );
    assert!(read.notes.iter().any(|note| note == "not read: grasps.score"), "{:?}", read.notes);
    let grasps = read.grasps.grasps();
    assert_eq!([grasps[0].score, grasps[1].score], [Some(1.0), Some(0.0)]);
    // Its approach, z, is −y of the object.
    let pads = [1.0, 2.0 - FRANKA_PADS_M, 3.0];
    assert_axes(&grasps[0].world_from_gripper, pads, [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]);
    let kept = files.read(&two, &ImportSettings { min_score: Some(0.5), ..ImportSettings::default() });
    assert_eq!(kept.map(|kept| (kept.grasps.len(), kept.in_file, kept.below)), Ok((1, 2, 1)));
    let fault = files.read(&two, &ImportSettings { object: Some(7), ..ImportSettings::default() });
    assert!(fault.is_err_and(|fault| fault.contains("no ids of objects")));
    let own =
        ImportSettings { closing: Some(ClosingAxis::Y), offset_m: Some(0.0), ..ImportSettings::default() };
    let own = files.read(&two, &own).expect("grasps");
    let pose = own.grasps.grasps()[0].world_from_gripper;
    assert_axes(&pose, [1.0, 2.0, 3.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]);
}

#[test]
fn isaacs_frame_is_named_by_the_user() {
    let files = Files::new();
    let text = |version: &str, orientation: &str| {
        format!(
            "format: isaac_grasp\nformat_version: {version}\nobject_frame: /mug\ngripper_frame: /panda_hand\ngrasps:\n  \
             grasp_0:\n    confidence: 0.75\n    position: [1, 2, 3]\n    orientation: {orientation}\n    cspace_position: \
             {{finger: 0.02}}\n"
        )
        .into_bytes()
    };
    let quarter = "{w: 0.7071067811865476, xyz: [0.7071067811865476, 0, 0]}";
    let sound = text("1.0", quarter);
    let unsaid = files.read(&sound, &ImportSettings::default()).expect_err("nobody knows its axes");
    assert!(unsaid.contains("along which axis it closes"), "{unsaid}");
    let settings =
        ImportSettings { closing: Some(ClosingAxis::Y), offset_m: Some(0.1), ..ImportSettings::default() };
    let read = files.read(&sound, &settings).expect("grasps");
    assert_eq!((read.format, read.grasps.grasps()[0].score), (GraspFormat::Isaac, Some(0.75)));
    assert_axes(
        &read.grasps.grasps()[0].world_from_gripper,
        [1.0, 1.9, 3.0],
        [0.0, 0.0, 1.0],
        [0.0, -1.0, 0.0],
    );
    for (bytes, words) in [
        (text("2.0", quarter), "isaac_grasp 1.0 is read"),
        (text("1.0", "{w: 1, xyz: [1, 0, 0]}"), "'grasp_0': its orientation is of norm 1.41"),
        (text("1.0", "{w: .nan, xyz: [1, 0, 0]}"), "its orientation is of norm NaN"),
        (text("1.0", "{w: 1, xyz: [1, 0]}"), "line 9"),
    ] {
        let fault = files.read(&bytes, &settings).expect_err("no grasps");
        assert!(fault.contains(words), "{fault}");
    }
}

#[test]
fn a_grasp_group_approaches_along_x_to_its_fingertips() {
    let files = Files::new();
    // The frame of QUARTER, 20 mm deep, 50 mm wide, of object 5.
    let row = |score: f64, object: f64| {
        let [a, b, c, x, d, e, f, y, g, h, i, z, ..] = QUARTER;
        [score, 0.05, 0.02, 0.02, a, b, c, d, e, f, g, h, i, x, y, z, object]
    };
    let group = |rows: &[[f64; 17]]| npy(&[rows.len() as u64, 17], &rows.concat());
    let read =
        files.read(&group(&[row(0.5, 5.0), row(-1.0, 5.0)]), &ImportSettings::default()).expect("grasps");
    assert_eq!((read.format, read.grasps.len(), read.masked), (GraspFormat::GraspnetGroup, 1, 1));
    let grasp = read.grasps.grasps()[0];
    assert_eq!((grasp.score, grasp.width_m), (Some(0.5), Some(0.05)));
    let ahead = 1.0 + 0.02 + FRANKA_TIPS_TO_PADS_M;
    assert_axes(&grasp.world_from_gripper, [ahead, 2.0, 3.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]);
    let two = group(&[row(0.5, 5.0), row(2.0, 7.0)]);
    assert!(
        files.read(&two, &ImportSettings::default()).expect_err("two objects").contains("ids [5.0, 7.0]")
    );
    let of_seven = ImportSettings { object: Some(7), ..ImportSettings::default() };
    assert_eq!(files.read(&two, &of_seven).expect("grasps").grasps.grasps()[0].score, Some(1.0));
    let mut mirrored = row(0.5, 5.0);
    mirrored[4] = -1.0;
    assert!(
        files
            .read(&group(&[mirrored]), &ImportSettings::default())
            .expect_err("a mirror")
            .contains("grasp 0: ")
    );
}

#[test]
fn labels_of_graspnet_have_the_views_of_its_api() {
    let files = Files::new();
    const LABELS: usize = 300 * 12 * 4;
    let mut scores = vec![-1.0; LABELS];
    let mut offsets = vec![0.0; 3 * LABELS];
    // View 17, sixth angle, third depth.
    let label = (17 * 12 + 5) * 4 + 2;
    scores[label] = 0.4;
    offsets[3 * label..3 * label + 3].copy_from_slice(&[0.6, 0.03, 0.045]);
    let labels = |points: &[u64]| {
        npz(&[
            ("points", npy(points, &[0.1, 0.2, 0.3])),
            ("scores", npy(&[1, 300, 12, 4], &scores)),
            ("offsets", npy(&[1, 300, 12, 4, 3], &offsets)),
        ])
    };
    let read = files.read(&labels(&[1, 3]), &ImportSettings::default()).expect("grasps");
    assert_eq!((read.format, read.grasps.len(), read.masked), (GraspFormat::GraspnetLabels, 1, LABELS - 1));
    let grasp = read.grasps.grasps()[0];
    assert!((grasp.score.expect("a score") - 0.7).abs() < 1e-12 && grasp.width_m == Some(0.045));
    // By NumPy: towards = -generate_views(300)[17]; batch_viewpoint_params_to_matrix(towards, 0.6), columns x and y.
    let towards = VIEW_17;
    let (at, closing, approach) = axes(&grasp.world_from_gripper);
    assert!((approach - Vector::from(towards)).norm() < 1e-6, "{approach}");
    assert!((closing - Vector::from(CLOSING_17)).norm() < 1e-6, "{closing}");
    let expected = Vector::new(0.1, 0.2, 0.3) + Vector::from(towards) * (0.03 + FRANKA_TIPS_TO_PADS_M);
    assert!((at.coords - expected).norm() < 1e-6);
    let fault = files.read(&labels(&[3, 1]), &ImportSettings::default()).expect_err("no points");
    assert!(fault.contains("points is of shape [3, 1]"), "{fault}");
}

#[test]
fn poses_keep_their_mask() {
    let files = Files::new();
    let poses = npy(&[3, 4, 4], &[QUARTER; 3].concat());
    let plain = files.read(&poses, &ImportSettings::default()).expect("grasps");
    assert_eq!(
        (plain.format, plain.grasps.len(), plain.grasps.grasps()[0].score),
        (GraspFormat::Poses, 3, None)
    );
    assert_axes(
        &plain.grasps.grasps()[0].world_from_gripper,
        [1.0, 2.0, 3.0],
        [0.0, 0.0, 1.0],
        [0.0, -1.0, 0.0],
    );
    let mut wrong = QUARTER;
    wrong[0] = f64::NAN;
    let masked = [
        ("poses", npy(&[3, 4, 4], &[QUARTER, wrong, QUARTER].concat())),
        ("mask", npy(&[3], &[0.0, 1.0, 0.0])),
    ];
    let scores = ("scores", npy(&[3], &[0.25, f64::NAN, f64::NAN]));
    let read =
        files.read(&npz(&[&masked[..], &[scores]].concat()), &ImportSettings::default()).expect("grasps");
    assert_eq!((read.grasps.len(), read.masked), (2, 1));
    assert_eq!([0, 1].map(|grasp| read.grasps.grasps()[grasp].score), [Some(0.25), None]);
    // Values under a mask are ignored; without the mask they are a fault.
    let fault = files.read(&npz(&masked[..1]), &ImportSettings::default()).expect_err("NaN");
    assert!(fault.contains("grasp 1: "), "{fault}");
}

#[test]
fn hostile_files_are_refused_by_name() {
    let files = Files::new();
    let huge = |shape: &str| {
        let head = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}\n");
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend(u16::try_from(head.len()).expect("short").to_le_bytes());
        bytes.extend(head.as_bytes());
        bytes
    };
    let mut sheared = QUARTER;
    sheared[1] = 0.1;
    let cases = [
        (huge("(4000000000, 4, 4)"), "more than any set"),
        (huge("(18446744073709551615, 4, 4)"), ""),
        (huge("(2, 4, 4)"), ""),
        (npy(&[2, 4, 3], &[0.0; 24]), "is of shape [2, 4, 3], not (N, 4, 4)"),
        (npy(&[0, 4, 4], &[]), "none is left"),
        (npy(&[1, 4, 4], &sheared), "grasp 0: the rotation part of the pose is no rotation"),
        (npz(&[("points", npy(&[1], &[0.0]))]), "it holds points, but neither"),
        (
            npz(&[("poses", npy(&[1, 4, 4], &QUARTER)), ("scores", npy(&[2], &[0.0, 0.0]))]),
            "scores is of shape [2]",
        ),
        (
            npz(&[("poses", npy(&[1, 4, 4], &QUARTER)), ("scores", npy(&[1], &[2.0]))]),
            "the score of grasp 0 is 2",
        ),
        (b"PK\x03\x04 and nothing".to_vec(), "the archive"),
        (b"\x89HDF\r\n\x1a\n and nothing".to_vec(), "HDF5"),
        (b"\xff\xfe".to_vec(), "neither HDF5"),
        (b"{}".to_vec(), "GraspGen"),
        (b"grasps: 3".to_vec(), "Isaac"),
        (json(&[QUARTER], ", \"object_in_gripper\": [1, 1]"), "has 2 entries for 1 transforms"),
        (json(&[QUARTER], ", \"object_in_gripper\": [7]"), "the score of grasp 0 is 7"),
        (json(&[sheared], ""), "grasp 0: "),
    ];
    for (bytes, words) in cases {
        let fault = files.read(&bytes, &ImportSettings::default()).expect_err(words);
        assert!(fault.contains(words), "no '{words}' in: {fault}");
    }
    let other = ImportSettings { format: Some(GraspFormat::Acronym), ..ImportSettings::default() };
    assert!(
        files
            .read(&json(&[QUARTER], ""), &other)
            .expect_err("another")
            .contains("it is graspgen, not acronym")
    );
}

/// Columns 0 and 1 of the matrix that `NumPy` computes for view 17 and an angle of 0.6 rad.
const VIEW_17: [f64; 3] = [0.468345087, 0.0193675397, 0.883333333];
const CLOSING_17: [f64; 3] = [-0.532442671, 0.804022833, 0.264673545];
