//! Every fixture of `tests/fixtures/bad` is refused with a message that gives the location and the fault. Other URDFs are
//! golden cases, in `crates/cli/tests/golden/bad_input`.

use std::collections::BTreeSet;
use std::path::Path;

use cranny_robot::{JointGroup, Robot, RobotError, RobotOptions, TextSource};

/// File, line (0 if none is expected), and further text expected in the message.
const URDF: &[(&str, u32, &[&str])] = &[
    ("missing_mesh.urdf", 6, &["link `b`", "`meshes/absent.stl` not found", "bad/meshes/absent.stl"]),
    (
        "missing_package_mesh.urdf",
        6,
        &["link `b`", "fixtures/some_arm/absent.stl", "given/some_arm/absent.stl"],
    ),
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
    let mut options = crate::fixture::mobile_arm_options();
    change(&mut options);
    Robot::load(&crate::fixture::path("mobile_arm/mobile_arm.urdf"), &options).expect_err("a bad option")
}

#[test]
fn every_bad_urdf_is_refused_where_it_is_wrong() {
    for (file, line, parts) in URDF {
        let options = RobotOptions { packages: vec!["given".into()], ..RobotOptions::default() };
        let error = Robot::load(&crate::fixture::path("bad").join(file), &options).expect_err(file);
        assert_says(&error.to_string(), file, *line, parts);
    }
}

#[test]
fn every_bad_srdf_is_refused_where_it_is_wrong() {
    for (file, line, parts) in SRDF {
        let error = arm_with(|options| {
            options.srdf = Some(TextSource::Path(crate::fixture::path("bad").join(file)));
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
            options.limits = Some(TextSource::Path(crate::fixture::path("bad").join(file)));
        });
        assert_says(&error.to_string(), file, *line, parts);
    }
}

#[test]
fn every_bad_fixture_is_in_a_table() {
    let listed: BTreeSet<String> =
        [URDF, SRDF, LIMITS].into_iter().flatten().map(|(file, ..)| (*file).to_owned()).collect();
    let present: BTreeSet<String> = std::fs::read_dir(crate::fixture::path("bad"))
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
    let text = std::fs::read_to_string(crate::fixture::path("bad/missing_mesh.urdf")).unwrap();
    let error = Robot::from_urdf_text(&text, "inline", None, &RobotOptions::default()).unwrap_err();
    assert!(error.to_string().starts_with("inline:6: link `b`"), "{error}");
}

/// Returns a robot whose links form a chain, or are all children of the root.
fn large(links: usize, is_chain: bool) -> String {
    let mut text = vec!["<robot name=\"large\">\n<link name=\"l0\"/>\n".to_owned()];
    for link in 1..links {
        let parent = if is_chain { link - 1 } else { 0 };
        text.push(format!(
            "<link name=\"l{link}\"><collision><geometry><sphere radius=\"0.1\"/></geometry></collision></link>\n\
             <joint name=\"j{link}\" type=\"revolute\"><parent link=\"l{parent}\"/><child link=\"l{link}\"/>\n\
             <axis xyz=\"0 0 1\"/><limit lower=\"-1\" upper=\"1\" velocity=\"1\"/></joint>\n"
        ));
    }
    text.concat() + "</robot>\n"
}

fn fault_of(urdf: &str) -> String {
    Robot::from_urdf_text(urdf, "large.urdf", None, &RobotOptions::default()).unwrap_err().to_string()
}

/// Guards against a chain of 10 000 joints and a star of 20 000 links, which took more than 40 s each and gigabytes.
#[test]
fn a_robot_of_more_links_than_any_has_is_refused_at_once() {
    let begin = std::time::Instant::now();
    for (links, is_chain) in [(10_000, true), (20_000, false)] {
        let said = fault_of(&large(links, is_chain));
        assert!(
            said.contains(&format!("{links} links in one robot, but at most 1000 are read; leave out")),
            "{said}"
        );
    }
    let robot = Robot::from_urdf_text(&large(1000, true), "l.urdf", None, &RobotOptions::default()).unwrap();
    assert_eq!(robot.dof(), 999);
    assert!(begin.elapsed().as_secs() < 5, "{:?}", begin.elapsed());
}

/// Guards against the comparison of all pairs of attributes: 100 000 of them took minutes.
#[test]
fn an_element_of_very_many_attributes_is_refused_at_once() {
    let many = (0..100_000).map(|index| format!(" a{index}=\"<>\"")).collect::<Vec<_>>().concat();
    let urdf = format!("<robot name=\"a\">\n<!-- <a b='> -->\n<link name=\"a\"{many}/>\n</robot>");
    let said = fault_of(&urdf);
    assert!(said.contains("large.urdf:3: 100001 attributes in one element, but at most 64"), "{said}");
    let deep = format!("<robot name=\"a\">{}{}</robot>", "<a>".repeat(100_000), "</a>".repeat(100_000));
    assert!(fault_of(&deep).contains("257 elements inside each other, but at most 256"));
}

/// Guards against the misleading error "has no link": elements of xacro are not links.
#[test]
fn a_xacro_file_is_called_by_its_name() {
    let with_namespace = "<robot name=\"a\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\">\n\
                          <xacro:macro name=\"arm\"/>\n</robot>";
    let without = "<robot name=\"a\">\n<xacro:include filename=\"b\"/>\n</robot>";
    for urdf in [with_namespace, without] {
        let said = Robot::from_urdf_text(urdf, "arm.urdf.xacro", None, &RobotOptions::default());
        let said = said.unwrap_err().to_string();
        assert!(said.contains("arm.urdf.xacro:2: this is a xacro file"), "{said}");
        assert!(said.contains("xacro arm.urdf.xacro > arm.urdf"), "{said}");
    }
    // The output of xacro still declares its namespace.
    let expanded =
        large(3, true).replacen("<robot", "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\"", 1);
    Robot::from_urdf_text(&expanded, "arm.urdf", None, &RobotOptions::default()).unwrap();
}

/// Guards against exponential time: each group that contains two others was walked twice as often as the one before.
#[test]
fn groups_within_groups_are_walked_once() {
    let mut srdf =
        vec!["<robot name=\"large\">\n<group name=\"g0\"><joint name=\"j1\"/></group>\n".to_owned()];
    for group in 1..60 {
        let below = group - 1;
        srdf.push(format!(
            "<group name=\"g{group}\"><group name=\"g{below}\"/><group name=\"g{below}\"/></group>\n"
        ));
    }
    let options = RobotOptions {
        srdf: Some(TextSource::Text { name: "large.srdf".into(), text: srdf.concat() + "</robot>" }),
        group: JointGroup::Srdf("g59".into()),
        ..RobotOptions::default()
    };
    let robot = Robot::from_urdf_text(&large(3, true), "large.urdf", None, &options).unwrap();
    assert_eq!(robot.dof(), 1);
}

/// Guards against blocking on a device: a pipe named as a mesh made the loader wait forever.
#[cfg(unix)]
#[test]
fn a_device_named_as_a_mesh_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let link = folder.path().join("zero.stl");
    std::os::unix::fs::symlink("/dev/zero", &link).unwrap();
    let mesh = format!("<mesh filename=\"{}\"/>", link.display());
    let urdf = large(2, true).replace("<sphere radius=\"0.1\"/>", &mesh);
    let said = fault_of(&urdf);
    assert!(said.contains("it is a device, not a regular file"), "{said}");
}
