//! Every fixture of `tests/fixtures/bad` is refused with a message that says where and what.

mod fixture;

use std::collections::BTreeSet;
use std::path::Path;

use cranny_robot::{JointGroup, Robot, RobotError, RobotOptions, TextSource};

/// File, line (0: none to name), and what the message must say besides.
const URDF: &[(&str, u32, &[&str])] = &[
    ("defined_twice.urdf", 5, &["link `b` is defined twice, first in line 3"]),
    ("empty.urdf", 0, &["the file is empty"]),
    ("floating.urdf", 5, &["joint `ab`", "`floating`", "supported: fixed, revolute"]),
    ("four_numbers.urdf", 14, &["xyz=\"0 0 1 0\" of <axis>: expected 3 finite number(s)"]),
    ("infinite.urdf", 14, &["xyz=\"0 0 inf\" of <axis>"]),
    ("limits_reversed.urdf", 8, &["joint `elbow`: lower limit 1.5 is greater than upper limit -1.5"]),
    ("loop.urdf", 6, &["the joints `ab`, `bc`, `cd` form a loop"]),
    ("mimic_loop.urdf", 5, &["joint `ab` mimics itself"]),
    ("mimic_unknown.urdf", 5, &["joint `ab` mimics another: unknown joint `bx`; did you mean", "`bc`"]),
    ("missing_mesh.urdf", 6, &["link `b`", "`meshes/absent.stl` not found", "bad/meshes/absent.stl"]),
    (
        "missing_package_mesh.urdf",
        6,
        &["link `b`", "fixtures/some_arm/absent.stl", "given/some_arm/absent.stl"],
    ),
    ("negative_size.urdf", 6, &["size of <box> must be greater than 0, but is -0.1"]),
    ("no_limit.urdf", 5, &["joint `ab` has no <limit>"]),
    ("no_links.urdf", 0, &["the robot has no link"]),
    ("no_velocity.urdf", 5, &["joint `ab`", "no velocity limit"]),
    ("not_a_number.urdf", 15, &["upper=\"NaN\" of <limit>"]),
    ("not_a_robot.urdf", 1, &["expected <robot>", "found <sdf>"]),
    ("nothing_moves.urdf", 0, &["the group is empty"]),
    ("truncated.urdf", 6, &["not well-formed XML"]),
    ("two_parents.urdf", 11, &["link `c` has two parents, through joints `ac` and `bc`"]),
    ("two_roots.urdf", 4, &["`a`, `c` have no parent joint"]),
    ("unclosed.urdf", 10, &["not well-formed XML"]),
    ("unknown_geometry.urdf", 6, &["link `b`: unknown geometry <torus>", "capsule"]),
    ("unknown_link.urdf", 11, &["joint `bc`: unknown link `cc`; did you mean", "`c`"]),
    ("zero_axis.urdf", 14, &["joint `bc` can move, but its axis is zero"]),
    ("zero_radius.urdf", 6, &["radius of <sphere> must be greater than 0, but is 0"]),
];

const SRDF: &[(&str, u32, &[&str])] = &[
    ("broken_chain.srdf", 2, &["link `link0` does not descend from link `link3`"]),
    ("group_loop.srdf", 2, &["group `arm` contains itself"]),
    ("not_a_number.srdf", 3, &["value=\"half\" of <joint>"]),
    ("unknown_link.srdf", 2, &["unknown link `lnik0`; did you mean", "`link0`"]),
];

const LIMITS: &[(&str, u32, &[&str])] = &[
    ("negative.limits.yaml", 4, &["acceleration of joint `joint2` must be greater than 0, but is -15"]),
    ("not_a_number.limits.yaml", 2, &["jerk of joint `joint1`", "NaN"]),
    ("truncated.limits.yaml", 2, &[]),
    ("unknown_joint.limits.yaml", 3, &["unknown joint `jiont2`; did you mean", "`joint2`"]),
    ("unknown_key.limits.yaml", 3, &["snap"]),
];

fn assert_says(message: &str, file: &str, line: u32, parts: &[&str]) {
    let place = if line == 0 { format!("{file}:") } else { format!("{file}:{line}:") };
    assert!(message.contains(&place), "expected {place} in: {message}");
    for part in parts {
        assert!(message.contains(part), "{file}: expected {part:?} in: {message}");
    }
}

fn arm_with(change: impl FnOnce(&mut RobotOptions)) -> RobotError {
    let mut options = fixture::mobile_arm_options();
    change(&mut options);
    Robot::load(&fixture::path("mobile_arm/mobile_arm.urdf"), &options).expect_err("a bad option")
}

#[test]
fn every_bad_urdf_is_refused_where_it_is_wrong() {
    for (file, line, parts) in URDF {
        let options = RobotOptions { packages: vec!["given".into()], ..RobotOptions::default() };
        let error = Robot::load(&fixture::path("bad").join(file), &options).expect_err(file);
        assert_says(&error.to_string(), file, *line, parts);
    }
}

#[test]
fn every_bad_srdf_is_refused_where_it_is_wrong() {
    for (file, line, parts) in SRDF {
        let error = arm_with(|options| {
            options.srdf = Some(TextSource::Path(fixture::path("bad").join(file)));
            if file.contains("group") || file.contains("chain") {
                options.group = JointGroup::Srdf("arm".to_owned());
            }
        });
        assert_says(&error.to_string(), file, *line, parts);
    }
}

#[test]
fn every_bad_limits_file_is_refused_where_it_is_wrong() {
    for (file, line, parts) in LIMITS {
        let error = arm_with(|options| {
            options.limits = Some(TextSource::Path(fixture::path("bad").join(file)));
        });
        assert_says(&error.to_string(), file, *line, parts);
    }
}

#[test]
fn every_bad_fixture_is_in_a_table() {
    let listed: BTreeSet<String> =
        [URDF, SRDF, LIMITS].into_iter().flatten().map(|(file, ..)| (*file).to_owned()).collect();
    let present: BTreeSet<String> = std::fs::read_dir(fixture::path("bad"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    assert_eq!(listed, present);
}

#[test]
fn options_that_do_not_fit_the_robot_name_what_does_not() {
    let names = |names: &[&str]| JointGroup::Joints(names.iter().map(|&name| name.to_owned()).collect());
    let hold = |joint: &'static str, value: f64| {
        move |options: &mut RobotOptions| {
            options.fixed.insert(joint.to_owned(), value);
        }
    };
    let cases: Vec<(RobotError, &str)> = vec![
        (
            arm_with(|o| o.tip = Some("grasp_farme".into())),
            "unknown link `grasp_farme`; did you mean `grasp_frame`",
        ),
        (arm_with(|o| o.group = names(&["jiont1"])), "unknown joint `jiont1`; did you mean `joint1`"),
        (arm_with(|o| o.group = names(&["joint1", "joint1"])), "joint `joint1` is named twice"),
        (arm_with(|o| o.group = names(&["mount"])), "joint `mount` cannot be moved: it is of type `fixed`"),
        (arm_with(|o| o.group = names(&["right_finger_joint"])), "it mimics joint `left_finger_joint`"),
        (arm_with(|o| o.group = names(&["left_finger_joint"])), "it belongs to the joint group"),
        (arm_with(|o| o.group = names(&[])), "the group is empty"),
        (
            arm_with(|o| o.group = JointGroup::Srdf("arn".into())),
            "unknown SRDF group `arn`; did you mean `arm`",
        ),
        (arm_with(hold("left_finger", 0.0)), "unknown joint `left_finger`; did you mean `left_finger_joint`"),
        (arm_with(hold("left_finger_joint", 0.05)), "cannot be held at 0.05: its limits are 0 to 0.04"),
        (arm_with(hold("left_finger_joint", f64::NAN)), "NaN is not a finite number"),
        (
            arm_with(hold("right_finger_joint", 0.01)),
            "mimics joint `left_finger_joint`, which puts it at 0.04",
        ),
        (arm_with(hold("mount", 0.0)), "cannot be held at a value: it is of type `fixed`"),
        (
            arm_with(|o| o.limits = Some(TextSource::Path("absent.yaml".into()))),
            "absent.yaml: cannot be read",
        ),
    ];
    for (error, part) in cases {
        let message = error.to_string();
        assert!(message.contains(part), "expected {part:?} in: {message}");
    }
}

#[test]
fn a_missing_file_and_a_mesh_without_a_folder_are_named() {
    let error = Robot::load(Path::new("absent.urdf"), &RobotOptions::default()).unwrap_err();
    assert!(error.to_string().starts_with("absent.urdf: cannot be read"), "{error}");
    let text = std::fs::read_to_string(fixture::path("bad/missing_mesh.urdf")).unwrap();
    let error = Robot::from_urdf_text(&text, "inline", None, &RobotOptions::default()).unwrap_err();
    assert!(error.to_string().starts_with("inline:6: link `b`"), "{error}");
}
