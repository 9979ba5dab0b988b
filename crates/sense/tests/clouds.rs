use cranny_collision::{Body, World};
use cranny_robot::{Robot, RobotOptions};
use cranny_sense::{
    Camera, CloudField, CloudMessage, PointCloud, SensedScene, SensorModel, View, robot_solids,
    sample_surfaces,
};
use cranny_shape::{Aabb, Solid, TriangleSoup, separation};
use cranny_spatial::{Point, Pose, Rotation, Stream, Vector};

const POINTS: [[f32; 3]; 4] = [[0.0, 0.25, -1.5], [1.0, 2.0, 3.0], [0.125, -0.5, 1e-3], [7.0, 7.0, 7.0]];

fn points_of(bytes: &[u8]) -> Vec<[f32; 3]> {
    PointCloud::of_bytes(bytes).unwrap().cloud.points
}

fn fault_of(bytes: &[u8]) -> String {
    PointCloud::of_bytes(bytes).map(|read| read.dropped).unwrap_err()
}

fn refused(bytes: &[u8], words: &str) {
    let fault = fault_of(bytes);
    assert!(fault.contains(words), "no '{words}' in: {fault}");
    assert!(fault.len() < 400, "{fault}");
}

fn text_rows() -> String {
    POINTS.map(|[x, y, z]| format!("{x} {y} {z}\n")).concat()
}

fn pcd_header(fields: &str, form: &str) -> String {
    format!(
        "# .PCD v.7\nVERSION .7\n{fields}\nWIDTH 2\nHEIGHT 2\nVIEWPOINT 1 2 3 1 0 0 0\nPOINTS 4\nDATA {form}\n"
    )
}

const XYZ: &str = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1";

/// Fields before, between and behind the coordinates, of other types and counts.
const MIXED: &str = "FIELDS rgb x normal y z label\nSIZE 4 8 4 4 2 1\nTYPE U F F F I U\nCOUNT 1 1 3 1 1 1";

/// Points whose z is a whole number of metres, for the fields of [`MIXED`].
const WHOLE: [[f32; 3]; 4] = [[0.0, 0.25, -1.0], [1.0, 2.0, 3.0], [0.125, -0.5, 0.0], [7.0, 7.0, 7.0]];

/// Bytes of each field of [`MIXED`] for a point.
#[allow(clippy::cast_possible_truncation, reason = "whole numbers")]
fn mixed_fields([x, y, z]: [f32; 3]) -> Vec<Vec<u8>> {
    vec![
        7_u32.to_le_bytes().to_vec(),
        f64::from(x).to_le_bytes().to_vec(),
        [f32::NAN, 1.0, 2.0].iter().flat_map(|normal| normal.to_le_bytes()).collect(),
        y.to_le_bytes().to_vec(),
        (z as i16).to_le_bytes().to_vec(),
        vec![9],
    ]
}

/// LZF of literals and of references to the byte before.
fn packed(data: &[u8]) -> Vec<u8> {
    let mut packed = Vec::new();
    let (mut rest, mut before) = (data, None);
    while let Some(first) = rest.first() {
        let run = rest.iter().take(264).take_while(|byte| Some(**byte) == before).count();
        if run >= 3 {
            let length = run - 2;
            let byte = |length: usize| u8::try_from(length).unwrap();
            match length {
                0..7 => packed.push(byte(length) << 5),
                _ => packed.extend([7 << 5, byte(length - 7)]),
            }
            packed.push(0);
            rest = &rest[run..];
        } else {
            packed.extend([0, *first]);
            before = Some(*first);
            rest = &rest[1..];
        }
    }
    packed
}

fn compressed(fields: &str, data: &[u8]) -> Vec<u8> {
    let packed = packed(data);
    let sizes = [packed.len(), data.len()].map(|size| u32::try_from(size).unwrap().to_le_bytes());
    [pcd_header(fields, "binary_compressed").as_bytes(), &sizes.concat(), &packed].concat()
}

#[test]
fn each_form_of_pcd_is_read() {
    let rows = text_rows();
    let text = pcd_header(XYZ, "ascii") + &rows;
    assert_eq!(points_of(text.as_bytes()), POINTS);
    assert_eq!(points_of(text.trim_end().as_bytes()), POINTS);
    assert_eq!(points_of(text.replace('\n', "\r\n").as_bytes()), POINTS);
    assert_eq!(points_of(text.replace("COUNT 1 1 1\n", "").as_bytes()), POINTS);
    let viewpoint = PointCloud::of_bytes(text.as_bytes()).unwrap().cloud.viewpoint.unwrap();
    assert_eq!(viewpoint, Pose::translation(1.0, 2.0, 3.0));

    let mixed = WHOLE.map(|[x, y, z]| format!("7 {x} nan 1 2 {y} {z} 9\n")).concat();
    assert_eq!(points_of((pcd_header(MIXED, "ascii") + &mixed).as_bytes()), WHOLE);

    let bytes: Vec<u8> = POINTS.iter().flatten().flat_map(|number| number.to_le_bytes()).collect();
    assert_eq!(points_of(&[pcd_header(XYZ, "binary").as_bytes(), &bytes].concat()), POINTS);
    let rows: Vec<u8> = WHOLE.iter().flat_map(|point| mixed_fields(*point).concat()).collect();
    assert_eq!(points_of(&[pcd_header(MIXED, "binary").as_bytes(), &rows].concat()), WHOLE);

    let column = |field: usize| WHOLE.iter().flat_map(move |point| mixed_fields(*point)[field].clone());
    let columns: Vec<u8> = (0..6).flat_map(column).collect();
    assert_eq!(points_of(&compressed(MIXED, &columns)), WHOLE);

    let cloud = PointCloud { points: POINTS.to_vec(), viewpoint: Some(viewpoint) };
    assert_eq!(PointCloud::of_bytes(&cloud.pcd_bytes()).unwrap().cloud, cloud);
}

#[test]
fn a_pcd_with_a_false_header_is_refused() {
    let rows = text_rows();
    let text = |from: &str, to: &str| (pcd_header(XYZ, "ascii") + &rows).replacen(from, to, 1).into_bytes();
    let bytes: Vec<u8> = POINTS.iter().flatten().flat_map(|number| number.to_le_bytes()).collect();
    let binary =
        |from: &str, to: &str| [pcd_header(XYZ, "binary").replacen(from, to, 1).as_bytes(), &bytes].concat();
    for (from, to, words) in [
        ("POINTS 4", "POINTS 5", "POINTS is 5, but WIDTH × HEIGHT is 2 × 2"),
        ("WIDTH 2", "WIDTH 9223372036854775807", "but WIDTH × HEIGHT"),
        ("WIDTH 2", "WIDTH -2", "line 7: '-2' is not a whole number"),
        ("WIDTH 2\n", "", "the header has no line WIDTH"),
        ("SIZE 4 4 4", "SIZE 4 4", "line 4: SIZE has 2 values for 3 fields"),
        ("TYPE F F F", "TYPE F F F F", "line 5: TYPE has 4 values for 3 fields"),
        ("SIZE 4 4 4", "SIZE 4 4 3", "type F of 3 bytes is not read"),
        ("TYPE F F F", "TYPE F F Q", "type Q of 4 bytes"),
        ("COUNT 1 1 1", "COUNT 1 1 2", "the field 'z' has 2 numbers instead of one"),
        ("COUNT 1 1 1", "COUNT 1 1 0", "a field has 1 to 1048576 numbers, not 0"),
        ("FIELDS x y z", "FIELDS x y w", "line 3: there is no field 'z'"),
        ("FIELDS x y z", "FIELDS x y y", "line 3: there are two fields 'y'"),
        ("VERSION .7", "VERSION 0.6", "version 0.6 of PCD is not read, only 0.7"),
        ("VIEWPOINT 1", "VIEWPOINT", "VIEWPOINT is seven numbers"),
        ("VIEWPOINT 1 2 3 1", "VIEWPOINT 1 2 3 2", "has length 2 instead of 1"),
        ("HEIGHT 2", "HEIGHT 2\nHEIGHT 2", "line 9: HEIGHT is given twice"),
        ("HEIGHT 2", "HIGHT 2", "line 8: 'HIGHT' is no line of a PCD header"),
    ] {
        refused(&text(from, to), words);
        refused(&binary(from, to), words);
    }
    refused(&text("DATA ascii", "DATA base64"), "DATA is ascii, binary or binary_compressed");
    refused(&text("\n1 2 3", "\n1 2"), "line 13: 2 values instead of 3");
    refused(&text("0.125", "near"), "line 14: 'near' is not a number");
    refused(&text("7 7 7\n", ""), "the data ends after 3 of 4 points");
    refused(&text("7 7 7\n", "7 7 7\n7 7 7\n"), "more lines follow after 4 points");
    refused(&text("7 7 7", "7 7 7000"), "point 3 has the coordinate 7000, but points are given in metres");
    refused(&binary("", "")[..170], "4 points of 12 bytes are announced, which are 48 bytes, but");
    refused(&[&binary("", "")[..], &[0]].concat(), "but 49 follow");
    let huge = pcd_header(XYZ, "binary")
        .replace("WIDTH 2", "WIDTH 4000000000")
        .replace("POINTS 4", "POINTS 8000000000");
    refused(huge.as_bytes(), "8000000000 points of 12 bytes");
    refused(
        huge.replace("DATA binary", "DATA ascii").as_bytes(),
        "8000000000 points are announced, but only 0 bytes",
    );
    refused(pcd_header(XYZ, "ascii").split("DATA").next().unwrap().as_bytes(), "the header has no line DATA");

    let column = |axis: usize| POINTS.iter().flat_map(move |point| point[axis].to_le_bytes());
    let columns: Vec<u8> = (0..3).flat_map(column).collect();
    let sound = compressed(XYZ, &columns);
    assert_eq!(points_of(&sound), POINTS);
    let begin = pcd_header(XYZ, "binary_compressed").len();
    let changed = |at: usize, value: u8| {
        let mut bytes = sound.clone();
        bytes[begin + at] = value;
        bytes
    };
    refused(&changed(0, 1), "1 compressed bytes are announced, but");
    refused(&changed(4, 49), "4 points take 48 bytes, but the compressed data states 49");
    refused(&changed(8, 31), "the compressed data");
    refused(&changed(8, 0x20), "beyond its start");
    refused(&sound[..sound.len() - 1], "compressed bytes are announced, but");
    refused(&sound[..begin + 3], "the sizes of the compressed data are missing");
}

fn ply(form: &str, elements: &str) -> String {
    format!("ply\nformat {form} 1.0\ncomment made by hand\n{elements}end_header\n")
}

const VERTEX: &str = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n";

#[test]
fn each_form_of_ply_is_read() {
    let rows = text_rows();
    assert_eq!(points_of((ply("ascii", VERTEX) + &rows).as_bytes()), POINTS);
    // With faces behind the vertices, and a camera before them.
    let faces = "element camera 1\nproperty double z\n".to_owned()
        + VERTEX
        + "element face 1\nproperty list uchar int vertex_indices\n";
    assert_eq!(points_of((ply("ascii", &faces) + "5\n" + &rows + "3 0 1 2\n").as_bytes()), POINTS);
    let mixed = "element camera 1\nproperty double z\nelement vertex 4\nproperty uchar red\nproperty double y\n\
                 property float x\nproperty short z\n";
    for (form, is_big) in [("binary_little_endian", false), ("binary_big_endian", true)] {
        let order = |bytes: &[u8]| -> Vec<u8> {
            if is_big { bytes.iter().rev().copied().collect() } else { bytes.to_vec() }
        };
        let plain: Vec<u8> =
            POINTS.iter().flatten().flat_map(|number| order(&number.to_le_bytes())).collect();
        assert_eq!(points_of(&[ply(form, VERTEX).as_bytes(), &plain].concat()), POINTS);
        let mut bytes = ply(form, mixed).into_bytes();
        bytes.extend([0; 8]);
        for [x, y, z] in WHOLE {
            #[allow(clippy::cast_possible_truncation, reason = "a whole number")]
            let z = z as i16;
            bytes.push(200);
            bytes.extend(order(&f64::from(y).to_le_bytes()));
            bytes.extend(order(&x.to_le_bytes()));
            bytes.extend(order(&z.to_le_bytes()));
        }
        assert_eq!(points_of(&bytes), WHOLE);
    }
}

#[test]
fn an_unfit_ply_is_refused() {
    let rows = text_rows();
    let text = |from: &str, to: &str| (ply("ascii", VERTEX) + &rows).replacen(from, to, 1).into_bytes();
    for (from, to, words) in [
        ("vertex 4", "vertex 5", "the data ends after 4 of 5 points"),
        ("vertex 4", "vertex 3", "more lines follow after 3 vertices"),
        ("vertex 4", "vertex 99999999999999", "are announced, but only"),
        ("vertex 4", "vertex many", "line 4: 'many' is no count"),
        ("element vertex", "element point", "the file has no element 'vertex'"),
        ("property float z\n", "", "of 'vertex', there is no field 'z'"),
        ("property float z", "property list uchar float z", "the list 'z' of 'vertex' is not read"),
        ("property float z", "property half z", "'property half z' is no line of a PLY header"),
        ("format ascii", "format base64", "is no line of a PLY header"),
        ("format ascii 1.0\n", "", "no line 'format'"),
        ("end_header\n", "", "is no line of a PLY header"),
        ("1 2 3", "1 2 three", "'three' is not a number"),
        ("1 2 3", "nan 2 3", ""),
    ] {
        if words.is_empty() {
            let read = PointCloud::of_bytes(&text(from, to)).unwrap();
            assert_eq!((read.dropped, read.cloud.points.len()), (1, 3));
        } else {
            refused(&text(from, to), words);
        }
    }
    let bytes: Vec<u8> = POINTS.iter().flatten().flat_map(|number| number.to_le_bytes()).collect();
    let binary = |bytes: &[u8]| [ply("binary_little_endian", VERTEX).as_bytes(), bytes].concat();
    refused(&binary(&bytes[..47]), "4 elements 'vertex' are announced, but only 47 bytes are left");
    refused(&binary(&[&bytes[..], &[1, 2]].concat()), "2 bytes follow the last vertex");
    let nan = f32::NAN.to_le_bytes().repeat(12);
    refused(&binary(&nan), "the cloud has no valid point: all 4 have a coordinate that is not finite");
    refused(ply("ascii", &VERTEX.replace('4', "0")).as_bytes(), "the cloud has no points");
    refused(b"solid mesh", "no point cloud that is read: PLY, PCD or a NumPy array");
    refused(b"", "no point cloud that is read");
}

#[test]
fn arrays_of_points_are_read() {
    let array =
        |kind: &str, shape: &[u64], bytes: &[u8]| [&cranny_file::npy_header(kind, shape)[..], bytes].concat();
    let narrow: Vec<u8> = POINTS.iter().flatten().flat_map(|number| number.to_le_bytes()).collect();
    let wide: Vec<u8> = POINTS.iter().flatten().flat_map(|number| f64::from(*number).to_le_bytes()).collect();
    assert_eq!(points_of(&array("<f4", &[4, 3], &narrow)), POINTS);
    assert_eq!(points_of(&array("<f8", &[2, 2, 3], &wide)), POINTS);
    let mut columns = array("<f4", &[4, 3], &[]);
    let text = String::from_utf8_lossy(&columns[10..]).replace("False", "True ");
    columns.truncate(10);
    columns.extend(text.bytes());
    columns.extend((0..3).flat_map(|axis| POINTS.iter().flat_map(move |point| point[axis].to_le_bytes())));
    assert_eq!(points_of(&columns), POINTS);
    refused(
        &array("<f4", &[3, 4], &narrow),
        "the shape is [3, 4], but a cloud is an array of float32 or float64 of shape (n, 3)",
    );
    refused(&array("<f4", &[5, 3], &narrow), "cut short");
    refused(&array("<f4", &[1 << 40, 3], &narrow), "more numbers are announced than the file holds");
    refused(&array("<f4", &[3, 3], &narrow), "bytes follow the last number");
    refused(&array("<i4", &[4, 3], &narrow), "the type is '<i4'");
    refused(&array("<f4", &[0, 3], &[]), "the cloud has no points");
}

#[test]
fn messages_of_ros_are_read() {
    let field =
        |name: &str, offset, datatype| CloudField { name: name.to_owned(), offset, datatype, count: 1 };
    let mut data = Vec::new();
    for row in POINTS.chunks(2) {
        for [x, y, z] in row {
            data.extend(
                [&y.to_be_bytes()[..], &[0; 4], &f64::from(*x).to_be_bytes(), &z.to_be_bytes()].concat(),
            );
        }
        data.extend([0xaa; 6]);
    }
    let message = CloudMessage {
        height: 2,
        width: 2,
        fields: vec![field("y", 0, 7), field("rgb", 4, 7), field("x", 8, 8), field("z", 16, 7)],
        is_bigendian: true,
        point_step: 20,
        row_step: 46,
        data: &data,
    };
    assert_eq!(message.read().unwrap().cloud.points, POINTS);
    let fault = |change: fn(&mut CloudMessage)| {
        let mut changed = message.clone();
        change(&mut changed);
        changed.read().unwrap_err()
    };
    assert!(
        fault(|message| message.width = 3).contains("3 points of 20 bytes do not fit into a row of 46 bytes")
    );
    assert!(fault(|message| message.height = 3).contains("but the data has 92 bytes"));
    assert!(fault(|message| message.fields[3].offset = 17).contains("'z' ends beyond the 20 bytes"));
    assert!(fault(|message| message.fields[3].datatype = 9).contains("'z' is no single number"));
    assert!(fault(|message| message.fields.truncate(3)).contains("no field 'z'"));
    assert!(fault(|message| message.fields[2].offset = usize::MAX).contains("'x' ends beyond"));
    assert!(fault(|message| (message.width, message.point_step) = (0, 0)).contains("no points"));
}

#[test]
fn a_view_projects_back_onto_the_surfaces_that_it_shows() {
    let ball = Body::new("ball", Pose::translation(0.0, 0.0, 0.3), Solid::sphere(0.2).unwrap());
    let world = World::new(vec![ball, Body::floor(0.0)]).unwrap();
    let scene = SensedScene::of_world(&world).unwrap();
    let pose = Camera::looking_at(&Point::new(-1.0, 0.4, 0.8), &Point::origin(), &Vector::z()).unwrap();
    let camera = Camera::with_field_of_view([80, 60], 1.0, pose).unwrap();
    let view = View::new("a", camera.clone(), scene.render(&camera).depth, SensorModel::exact()).unwrap();
    let cloud = view.cloud();
    assert_eq!((cloud.points.len(), cloud.viewpoint), (view.depth.valid_count(), Some(pose)));
    for point in &cloud.points {
        let [x, y, z] = point.map(f64::from);
        let off_ball = ((x * x + y * y + (z - 0.3) * (z - 0.3)).sqrt() - 0.2).abs();
        assert!(off_ball.min(z.abs()) < 1e-6, "{point:?}");
    }
    let back = cloud.transformed(&pose.inverse());
    assert!(back.points.iter().all(|point| point[2] > 0.0));
}

/// Oracle: distances of the collision check to a tiny ball, without any shortcut.
#[test]
fn points_near_the_robot_and_the_target_are_removed() {
    let urdf = cranny_test_robots::plane_arm();
    let robot = Robot::from_urdf_text(&urdf, "arm.urdf", None, &RobotOptions::default()).unwrap();
    let mut solids = robot_solids(&robot, &vec![0.3; robot.dof()]);
    let soup = TriangleSoup::geodesic_sphere(0.2, 2);
    solids.push((Pose::translation(0.3, -0.5, 0.2), Solid::mesh(&soup).unwrap()));
    let mut random = Stream::new(2, 0);
    let points = (0..3000).map(|_| {
        #[allow(clippy::cast_possible_truncation, reason = "points are f32")]
        [0; 3].map(|_: i32| random.uniform_between(-0.8, 0.8) as f32)
    });
    let cloud = PointCloud::of(points.collect());
    let probe = Solid::sphere(1e-9).unwrap();
    for margin_m in [0.0, 0.03] {
        let cleared = cloud.without_near(&solids, margin_m).unwrap();
        let is_clear = |point: &&[f32; 3]| {
            let at = Pose::from_parts(Vector::from(point.map(f64::from)).into(), Rotation::identity());
            solids.iter().all(|(pose, solid)| separation(solid, pose, &probe, &at, 5.0).lower_m > margin_m)
        };
        let expected: Vec<[f32; 3]> = cloud.points.iter().filter(is_clear).copied().collect();
        assert_eq!(cleared.cloud.points, expected);
        assert_eq!(cleared.removed, cloud.points.len() - expected.len());
        assert!(cleared.removed > 20 && expected.len() > 1000, "{}", cleared.removed);
    }
    let floor = [(Pose::identity(), Solid::half_space())];
    let above = cloud.without_near(&floor, 0.1).unwrap().cloud;
    assert!(above.points.iter().all(|point| point[2] > 0.0999) && above.points.len() > 1000);
    assert!(cloud.without_near(&floor, -1.0).unwrap_err().to_string().contains("margin"));
}

#[test]
fn a_crop_keeps_what_lies_within_the_box() {
    let cloud = PointCloud::of(POINTS.to_vec());
    let aabb = Aabb { center: Point::new(1.0, 2.0, 3.0), half_extents: Vector::repeat(0.5) };
    assert_eq!(cloud.cropped(&aabb, &Pose::identity()).points, [POINTS[1]]);
    let turned = Pose::new(Vector::zeros(), Vector::z() * std::f64::consts::PI);
    assert!(cloud.cropped(&aabb, &turned).points.is_empty());
    let other = Aabb { center: Point::new(-1.0, -2.0, 3.0), ..aabb };
    assert_eq!(cloud.cropped(&other, &turned).points, [POINTS[1]]);
}

/// Moments of area of each shape by its formula: the mean of z² over the surface.
#[test]
fn samples_are_uniform_by_area_on_the_surfaces() {
    let mean_squared_height = |solid: &Solid| {
        let cloud = sample_surfaces([(Pose::identity(), solid)], 40_000, 5).unwrap();
        let squares = cloud.points.iter().map(|point| f64::from(point[2]).powi(2));
        for point in cloud.points.iter().step_by(97) {
            let at = Pose::from_parts(Vector::from(point.map(f64::from)).into(), Rotation::identity());
            let probe = Solid::sphere(1e-6).unwrap();
            assert!(separation(solid, &Pose::identity(), &probe, &at, 1.0).upper_m < 1e-6);
        }
        squares.sum::<f64>() / 40_000.0
    };
    let (r, h) = (0.2_f64, 0.3_f64);
    let ball = r * r / 3.0;
    assert!((mean_squared_height(&Solid::sphere(r).unwrap()) / ball - 1.0).abs() < 0.02);
    // Caps: area 2πr², height h; side: area 4πrh, mean square h²/3.
    let cylinder = (2.0 * r * r * h * h + 4.0 * r * h * h * h / 3.0) / (2.0 * r * r + 4.0 * r * h);
    assert!((mean_squared_height(&Solid::cylinder(h, r).unwrap()) / cylinder - 1.0).abs() < 0.02);
    // Half-balls: area 4πr², mean of (h + |z|)² = h² + hr + r²/3.
    let capsule = (4.0 * r * r * (h * h + h * r + r * r / 3.0) + 4.0 * r * h * h * h / 3.0)
        / (4.0 * r * r + 4.0 * r * h);
    assert!((mean_squared_height(&Solid::capsule(h, r).unwrap()) / capsule - 1.0).abs() < 0.02);
    let cuboid = Solid::cuboid(Vector::repeat(0.1)).unwrap();
    // Two faces of z² = 0.01, four of mean 0.01/3.
    assert!((mean_squared_height(&cuboid) / (0.01 * (2.0 + 4.0 / 3.0) / 6.0) - 1.0).abs() < 0.02);
    let both = [(Pose::identity(), &cuboid), (Pose::translation(5.0, 0.0, 0.0), &cuboid)];
    let cloud = sample_surfaces(both, 10_000, 1).unwrap();
    let far = cloud.points.iter().filter(|point| point[0] > 2.0).count();
    assert!((4800..5200).contains(&far), "{far}");
    assert_eq!(cloud, sample_surfaces(both, 10_000, 1).unwrap());
    let floor = Solid::half_space();
    assert!(
        sample_surfaces([(Pose::identity(), &floor)], 5, 0).unwrap_err().to_string().contains("no surface")
    );
}
