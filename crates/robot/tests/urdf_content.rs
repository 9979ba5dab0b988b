//! Each piece of content of a URDF is read, refused if it could affect geometry or motion, or noted.

use cranny_robot::{Robot, RobotError, RobotOptions, TextSource};
use cranny_spatial::Point;

/// A URDF with all content that is read.
const WHOLE: &str = r#"<robot name="whole" version="1.2">
<link name="foot"><visual rounding="0.01" blend="0.01"><origin xyz="0 0 0.1" rpy="0 0 0"/><geometry><box size="1 1 1"/></geometry><material name="m"><color rgba="1 0 0 1"/></material></visual></link>
<link name="bar"><inertial><origin xyz="0 0 0" rpy="0 0 0"/><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial><collision><origin xyz="0.5 0 0.5" quat_xyzw="0 0 0 1"/><geometry><cylinder length="1" radius="0.1"/></geometry></collision><collision><geometry><box size="1 2 3"/></geometry></collision></link>
<link name="finger"><collision><geometry><capsule length="1" radius="0.1"/></geometry></collision></link>
<joint name="turn" type="revolute"><origin xyz="0 0 1" rpy="0 0 0"/><parent link="foot"/><child link="bar"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" velocity="1" effort="1" acceleration="2" jerk="20"/></joint>
<joint name="follow" type="prismatic"><parent link="bar"/><child link="finger"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" velocity="1" effort="1"/><mimic joint="turn" multiplier="0.5" offset="0"/></joint>
</robot>"#;

fn read(text: &str) -> Result<Robot, RobotError> {
    Robot::from_urdf_text(text, "r.urdf", None, &RobotOptions::default())
}

/// Returns the robot of [`WHOLE`] with one passage replaced by another.
fn with(old: &str, new: &str) -> Result<Robot, RobotError> {
    assert!(WHOLE.contains(old), "{old}");
    read(&WHOLE.replacen(old, new, 1))
}

#[test]
fn everything_of_a_whole_urdf_is_read() {
    let robot = read(WHOLE).expect("a good URDF");
    assert!(robot.notes().is_empty(), "{:?}", robot.notes());
    let [turn] = robot.limits() else { panic!("one joint moves") };
    assert_eq!((turn.acceleration, turn.jerk), (Some(2.0), Some(20.0)));
}

/// Tests the names of attributes and elements in turn, each with an added letter, in capitals and with a prefix.
#[test]
fn no_name_is_lost_in_any_spelling() {
    let mut changed = 0;
    let starts =
        WHOLE.char_indices().filter(|(_, c)| *c == ' ' || *c == '<' || *c == '/').map(|(at, _)| at + 1);
    for start in starts {
        let rest = &WHOLE[start..];
        let end = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(rest.len());
        let (name, before, after) = (&rest[..end], &WHOLE[..start], &rest[end..]);
        let is_element = before.ends_with('<');
        let has_no_name =
            name.is_empty() || before.ends_with('/') || !is_element && !after.starts_with("=\"");
        if has_no_name {
            continue;
        }
        // An element also has its name at its end.
        let close = if after[..after.find('>').unwrap_or(0)].ends_with('/') {
            None
        } else {
            Some(format!("</{name}>"))
        };
        for other in [format!("{name}x"), name.to_uppercase(), format!("other:{name}")] {
            let after = match &close {
                Some(close) if is_element => after.replacen(close, &format!("</{other}>"), 1),
                _ => after.to_owned(),
            };
            changed += 1;
            let text = format!("{before}{other}{after}");
            if let Ok(robot) = read(&text) {
                assert!(!robot.notes().is_empty(), "{name} as {other} is lost at {start}");
            }
        }
    }
    assert!(changed > 200, "{changed}");
}

#[test]
fn nothing_stands_twice_in_silence() {
    for (element, count) in [
        (r#"<origin xyz="0.5 0 0.5" quat_xyzw="0 0 0 1"/>"#, 2),
        (r#"<geometry><cylinder length="1" radius="0.1"/></geometry>"#, 2),
        (r#"<cylinder length="1" radius="0.1"/>"#, 2),
        (r#"<origin xyz="0 0 1" rpy="0 0 0"/>"#, 2),
        (r#"<parent link="foot"/>"#, 2),
        (r#"<child link="bar"/>"#, 2),
        (r#"<axis xyz="0 0 1"/>"#, 2),
        (r#"<limit lower="-3" upper="3" velocity="1" effort="1" acceleration="2" jerk="20"/>"#, 2),
        (r#"<mimic joint="turn" multiplier="0.5" offset="0"/>"#, 3),
    ] {
        let error = with(element, &element.repeat(count)).expect_err(element).to_string();
        assert!(error.starts_with("r.urdf:") && error.contains("a second"), "{error}");
    }
}

#[test]
fn what_may_change_geometry_or_motion_is_refused_with_its_place() {
    for (old, new, place) in [
        (
            "quat_xyzw=",
            "degrees=\"true\" quat_xyzw=",
            "r.urdf:3: attribute `degrees` in <origin> of link `bar`",
        ),
        (
            r#"<axis xyz="0 0 1"/>"#,
            "<axis>0 0 1</axis>",
            "r.urdf:5: the text `0 0 1` in <axis> of joint `turn`",
        ),
        (
            "<collision><geometry>",
            "<collision><pose>0 0 0 0 0 0</pose><geometry>",
            "r.urdf:3: element <pose>",
        ),
        (
            "<link name=\"finger\">",
            "<link name=\"finger\"><Collision/>",
            "r.urdf:4: element <Collision> in link `finger`",
        ),
        ("</robot>", "<group><link name=\"z\"/></group></robot>", "r.urdf:7: element <group> in <robot>"),
        ("</robot>", "<include file=\"more.urdf\"/></robot>", "r.urdf:7: element <include> in <robot>"),
        (
            "<mimic ",
            "<mimic factor=\"2\" ",
            "r.urdf:6: attribute `factor` in <mimic> of joint `follow` is not understood",
        ),
        (
            "quat_xyzw=",
            "rpy=\"0 0 0\" quat_xyzw=",
            "r.urdf:3: `quat_xyzw` beside `rpy` in <origin> of link `bar`",
        ),
        (
            "quat_xyzw=\"0 0 0 1\"",
            "quat_xyzw=\"0 0 0 2\"",
            "r.urdf:3: `quat_xyzw` of <origin> has the length 2",
        ),
        (
            "acceleration=\"2\"",
            "acceleration=\"-2\"",
            "r.urdf:5: acceleration of <limit> must be greater than 0",
        ),
        ("<cylinder length", "<cylinder height=\"2\" length", "(known there: length, radius)"),
    ] {
        let error = with(old, new).expect_err(new).to_string();
        assert!(error.contains(place), "{error}");
    }
}

#[test]
fn what_changes_neither_is_named_or_known() {
    for known in
        ["<gazebo reference=\"bar\"/>", "<transmission><joint name=\"turn\"/></transmission>", "<material/>"]
    {
        assert!(with("</robot>", &format!("{known}</robot>")).expect(known).notes().is_empty());
    }
    for kind in ["fixed", "floating"] {
        // This is an additional joint with a meaningless axis.
        let joint = format!(
            "<link name=\"tag\"/><joint name=\"tagged\" type=\"{kind}\"><parent link=\"foot\"/><child link=\"tag\"/>\
             <axis xyz=\"0 0 1\"/><limit velocity=\"1\" effort=\"1\"/></joint></robot>"
        );
        let robot = with("</robot>", &joint).expect(kind);
        assert!(robot.notes().is_empty(), "{:?}", robot.notes());
    }
    for (old, new, note) in [
        (
            "</robot>",
            "<world name=\"w\"/><world/></robot>",
            "r.urdf:7: element <world> of <robot> is not read, here and at 1 more place",
        ),
        ("version=\"1.2\"", "version=\"3\"", "r.urdf:1: attribute `version` of <robot> is not read"),
        ("type=\"revolute\"", "type=\"continuous\"", "r.urdf:5: attribute `lower` of <limit> is not read"),
        ("<limit ", "<limit maker:peak=\"3\" ", "r.urdf:5: attribute `maker:peak` of <limit> is not read"),
        ("<parent", "# a remark\n<parent", "r.urdf:5: the text `# a remark` of <joint> is not read"),
    ] {
        let robot = with(old, new).expect(new);
        assert!(robot.notes().iter().any(|line| line == note), "{:?}", robot.notes());
    }
}

#[test]
fn a_quaternion_turns_as_the_same_angles_do() {
    let half = std::f64::consts::FRAC_1_SQRT_2.to_string();
    let turned =
        with("quat_xyzw=\"0 0 0 1\"", &format!("quat_xyzw=\"0 {half} 0 {half}\"")).expect("a rotation");
    let bar = &turned.links()[turned.link_index("bar").expect("it is there")];
    let end = bar.collisions[0].link_from_shape * Point::new(0.0, 0.0, 0.5);
    assert!((end - Point::new(1.0, 0.0, 0.5)).norm() < 1e-12, "{end}");
}

#[test]
fn extensions_of_drake_are_read_with_and_without_their_namespace() {
    for declared in ["", " xmlns:drake=\"http://drake.mit.edu\""] {
        let text = WHOLE
            .replace("<robot ", &format!("<robot{declared} "))
            .replace("<capsule", "<drake:capsule")
            .replace(" acceleration=", " drake:acceleration=");
        let robot = read(&text).expect("read by others");
        assert_eq!(robot.limits()[0].acceleration, Some(2.0));
        assert!(robot.notes().is_empty(), "{:?}", robot.notes());
    }
}

#[test]
fn what_an_srdf_contradicts_or_leaves_unread_is_named() {
    let text = r#"<robot name="r"><group name="arm"><joint name="turn"/></group>
<group name="arm"><link name="foot"/></group>
<virtual_joint name="world" type="floating" parent_frame="world" child_link="bar"/>
<group_state name="home" group="arm"><joint name="turn" value="0"/><joint name="turn" value="0.1"/></group_state>
<group_state name="home" group="arm"><joint name="world" value="0 0 0 0 0 0 1"/></group_state>
<group_state name="home" group="leg"/><end_effector name="tool" group="hand" parent_link="bar"/></robot>"#;
    let srdf = TextSource::Text { name: "r.srdf".to_owned(), text: text.to_owned() };
    let options = RobotOptions { srdf: Some(srdf), ..RobotOptions::default() };
    let robot = Robot::from_urdf_text(WHOLE, "r.urdf", None, &options).expect("it is read");
    let expected = [
        "r.srdf:2: group `arm` is defined twice: the first definition is used",
        "r.srdf:4: state `home` has joint `turn` twice: the last value is used",
        "r.srdf:5: state `home` of group `arm` is defined twice: the first definition is used",
        "r.srdf:5: state `home` has a pose of joint `world`, which is not read",
        "r.srdf:6: state `home` refers to the unknown group `leg`",
        "r.srdf:6: end effector `tool` refers to the unknown group `hand`",
    ];
    assert_eq!(robot.notes(), expected);
}
