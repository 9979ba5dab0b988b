//! Hands described in a `robot.yaml`.

use cranny_robot::{
    HandDescription, JointGroup, JointKind, Robot, RobotDescription, RobotError, RobotOptions, TextSource,
};

const GRIPPER: &str = r#"<robot name="gripper"><link name="base"/><link name="flange"/>
  <link name="palm"><collision><geometry><box size="0.1 0.1 0.04"/></geometry></collision></link>
  <link name="jaw_a"><collision><geometry><box size="0.02 0.01 0.05"/></geometry></collision></link>
  <link name="jaw_b"><collision><geometry><box size="0.02 0.01 0.05"/></geometry></collision></link>
  <link name="between"/><link name="camera"/>
  <joint name="turn" type="revolute"><parent link="base"/><child link="flange"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
  <joint name="mount" type="fixed"><parent link="flange"/><child link="palm"/></joint>
  <joint name="slide_a" type="prismatic"><parent link="palm"/><child link="jaw_a"/><axis xyz="0 1 0"/>
    <limit lower="0" upper="0.03" velocity="1" effort="1"/></joint>
  <joint name="slide_b" type="prismatic"><parent link="palm"/><child link="jaw_b"/><axis xyz="0 -1 0"/>
    <limit lower="0" upper="0.03" velocity="1" effort="1"/></joint>
  <joint name="reach" type="fixed"><parent link="palm"/><child link="between"/><origin xyz="0 0 0.1"/></joint>
  <joint name="see" type="fixed"><parent link="palm"/><child link="camera"/></joint>
</robot>"#;

const HAND: &str = "hand:
  name: jaws
  tip: between
  fingers:
    slide_a: {open: 0.03, closed: 0.0}
    slide_b: {open: 0.03, closed: 0.0}
  opening_m: 0.06
  finger_depth_m: 0.04
  closing_force_n: 30
";

fn hand() -> HandDescription {
    RobotDescription::parse(HAND, "robot.yaml").unwrap().hand.unwrap()
}

fn robot(options: &RobotOptions) -> Result<Robot, RobotError> {
    Robot::from_urdf_text(GRIPPER, "gripper.urdf", None, options)
}

#[test]
fn a_described_hand_stands_open_and_reaches_with_its_own_frame() {
    let options = RobotOptions { known_hands: vec![hand()], ..RobotOptions::default() };
    let robot = robot(&options).unwrap();
    assert_eq!(robot.joint_names(), ["turn"]);
    assert_eq!(robot.links()[robot.tip()].name, "between");
    let names: Vec<&str> = robot.hand_links().iter().map(|&link| robot.links()[link].name.as_str()).collect();
    assert_eq!(names, ["palm", "jaw_a", "jaw_b"]);
    let known = robot.hand().unwrap();
    assert_eq!((known.description.opening_m, known.fingers), (0.06, 2));
    let frames = robot.frames();
    for (finger, side) in known.joints.iter().zip([1.0, -1.0]) {
        assert_eq!(finger.kind, JointKind::Prismatic);
        assert!((frames.link(finger.link).translation.y - 0.03 * side).abs() < 1e-12);
        assert!((finger.axis_in_link.y - side).abs() < 1e-12);
    }
}

#[test]
fn what_the_robot_lacks_is_left_out_and_what_is_asked_for_goes_first() {
    let mut other = hand();
    other.tip = Some("nowhere".into());
    other.fingers.insert("slide_c".into(), other.fingers["slide_a"]);
    let options = RobotOptions {
        known_hands: vec![other],
        fixed: [("slide_b".to_owned(), 0.01)].into(),
        tip: Some("camera".into()),
        ..RobotOptions::default()
    };
    let halfway = robot(&options).unwrap();
    assert!(halfway.hand().is_none());
    assert_eq!(halfway.links()[halfway.tip()].name, "camera");
    let at = |name: &str| halfway.frames().link(halfway.link_index(name).unwrap()).translation.y;
    assert!((at("jaw_a") - 0.03).abs() < 1e-12 && (at("jaw_b") + 0.01).abs() < 1e-12);
    // A finger's joint in the group moves.
    let joints = ["turn", "slide_a"].map(str::to_owned).to_vec();
    let options = RobotOptions {
        known_hands: vec![hand()],
        group: JointGroup::Joints(joints),
        ..RobotOptions::default()
    };
    assert_eq!(robot(&options).unwrap().dof(), 2);
}

#[test]
fn a_finger_that_mimics_another_follows_it() {
    let mimic = GRIPPER.replace(
        r#"<limit lower="0" upper="0.03" velocity="1" effort="1"/></joint>
  <joint name="reach""#,
        r#"<limit lower="0" upper="0.03" velocity="1" effort="1"/><mimic joint="slide_a"/></joint>
  <joint name="reach""#,
    );
    assert_ne!(mimic, GRIPPER);
    let at = |options: &RobotOptions| {
        let robot = Robot::from_urdf_text(&mimic, "gripper.urdf", None, options).unwrap();
        robot.frames().link(robot.link_index("jaw_b").unwrap()).translation.y
    };
    let open = RobotOptions { known_hands: vec![hand()], ..RobotOptions::default() };
    assert!((at(&open) + 0.03).abs() < 1e-12);
    let closed = RobotOptions { fixed: [("slide_a".to_owned(), 0.0)].into(), ..open };
    assert!(at(&closed).abs() < 1e-12);
}

#[test]
fn a_hand_beside_the_urdf_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let urdf = folder.path().join("gripper.urdf");
    std::fs::write(&urdf, GRIPPER).unwrap();
    assert!(Robot::load(&urdf, &RobotOptions::default()).unwrap().hand().is_none());
    std::fs::write(folder.path().join("robot.yaml"), HAND).unwrap();
    let robot = Robot::load(&urdf, &RobotOptions::default()).unwrap();
    assert_eq!(robot.hand().unwrap().description, hand());
    // Nothing of the robot's own hand may be missing.
    for (from, to, says) in [
        ("slide_b", "slide_c", "robot.yaml:6: fingers: unknown joint 'slide_c'"),
        ("tip: between", "tip: betwen", "robot.yaml:3: tip: unknown link 'betwen'"),
        ("slide_b: {open: 0.03", "slide_b: {open: 0.031", "robot.yaml:6: open of finger 'slide_b' is 0.031"),
    ] {
        std::fs::write(folder.path().join("robot.yaml"), HAND.replace(from, to)).unwrap();
        let fault = Robot::load(&urdf, &RobotOptions::default()).unwrap_err().to_string();
        assert!(fault.replace('`', "'").contains(says), "{fault}");
    }
}

#[test]
fn a_faulty_description_is_refused_with_its_line() {
    for (from, to, says) in [
        ("opening_m: 0.06", "opening_m: -0.06", "robot.yaml:7: "),
        ("closing_force_n: 30", "closing_force_n: .nan", "robot.yaml:9: "),
        ("finger_depth_m: 0.04", "finger_depth: 0.04", "robot.yaml:8: "),
        ("open: 0.03, closed", "open: wide, closed", "robot.yaml:5: "),
        (
            "slide_b: {open: 0.03, closed: 0.0}",
            "slide_b: {open: 0.03, closed: .inf}",
            "robot.yaml:6: closed of finger",
        ),
    ] {
        let fault =
            RobotDescription::parse(&HAND.replacen(from, to, 1), "robot.yaml").unwrap_err().to_string();
        assert!(fault.starts_with(says), "{fault}");
    }
    let fault = RobotDescription::parse(" ", "robot.yaml").unwrap_err().to_string();
    assert!(fault.contains("empty"), "{fault}");
}

/// Returns the robot of [`GRIPPER`] with another text of its URDF and `robot.yaml`.
fn with_files(urdf: &str, description: &str) -> Result<Robot, RobotError> {
    let description = TextSource::Text { name: "robot.yaml".to_owned(), text: description.to_owned() };
    let options = RobotOptions { description: Some(description), ..RobotOptions::default() };
    Robot::from_urdf_text(urdf, "gripper.urdf", None, &options)
}

#[test]
fn what_contradicts_hand_or_group_is_refused() {
    let with = |from: &str, to: &str| HAND.replacen(from, to, 1);
    for (description, says) in [
        (
            format!("{HAND}fixed: {{slide_a: 0}}\n"),
            "robot.yaml:10: joint 'slide_a' cannot be held at another",
        ),
        (format!("{HAND}start: {{turn: 0, slide_a: 0}}\n"), "joint 'slide_a' cannot be in the start"),
        (format!("{HAND}start: {{slide_a: 0}}\n"), "joint 'slide_a' cannot be in the start"),
        (with("opening_m: 0.06", "opening_m: 60"), "at most 1, in metres"),
        (with("closed: 0.0}", "closed: 0.03}"), "must be other than"),
    ] {
        let fault = with_files(GRIPPER, &description).expect_err(&description).to_string();
        assert!(fault.replace('`', "'").contains(says), "{fault}");
    }
    assert!(with_files(GRIPPER, &format!("{HAND}fixed: {{slide_a: 0.03}}\nstart: {{turn: 0.2}}\n")).is_ok());
    let two = GRIPPER.replace(
        r#"<joint name="mount" type="fixed"><parent link="flange"/>"#,
        r#"<link name="wrist"/><joint name="bend" type="revolute"><parent link="flange"/><child link="wrist"/>
        <axis xyz="1 0 0"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
        <joint name="mount" type="fixed"><parent link="wrist"/>"#,
    );
    let robot = with_files(&two, &format!("{HAND}start: {{turn: 0.2}}\n")).unwrap();
    assert_eq!(robot.default_start(), Some(&[0.2, 0.0][..]), "`bend` is as near to 0 as it can be");
}

#[test]
fn a_joint_that_mimics_a_held_one_keeps_its_limits() {
    let coupled = |limits: &str, mimic: &str| {
        let joint = r#"<axis xyz="0 -1 0"/>
    <limit lower="0" upper="0.03" velocity="1" effort="1"/>"#;
        let mimic = format!(
            r#"<axis xyz="0 -1 0"/><limit {limits} velocity="1" effort="1"/><mimic joint="slide_a" {mimic}/>"#
        );
        GRIPPER.replacen(joint, &mimic, 1)
    };
    let one = HAND.replace("    slide_b: {open: 0.03, closed: 0.0}\n", "");
    assert!(with_files(&coupled(r#"lower="0" upper="0.03""#, ""), &one).is_ok());
    for (limits, mimic) in [
        (r#"lower="0" upper="0.01""#, ""),
        (r#"lower="0" upper="0.03""#, r#"multiplier="1.5""#),
        (r#"lower="0" upper="0.03""#, r#"multiplier="0" offset="0.3""#),
    ] {
        let fault = with_files(&coupled(limits, mimic), &one).expect_err(mimic).to_string();
        assert!(fault.contains("outside its limits"), "{fault}");
    }
    // A finger follows its master to the value that mimicry gives.
    let urdf = coupled(r#"lower="0" upper="0.03""#, "");
    let alone = HAND.replace("    slide_a: {open: 0.03, closed: 0.0}\n", "");
    assert!(with_files(&urdf, &alone).is_err());
    assert!(with_files(&urdf, HAND).is_ok());
    assert!(with_files(&urdf, &HAND.replace("slide_b: {open: 0.03", "slide_b: {open: 0.02")).is_err());
}
