//! MJCF and SDF: what becomes of contacts, shapes, free bodies and planes; what is refused, and what is named as not read.
//! `crates/cli/tests/golden/robots` compares poses with `MuJoCo`.

use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;
use std::fs;
use std::path::Path;

use cranny_robot::{JointGroup, ModelText, ModelUse, Robot, RobotError, RobotOptions};
use cranny_spatial::{Point, Vector};
use tempfile::TempDir;

/// Writes a model and further files into a folder.
fn folder(files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("created");
        fs::write(path, text).expect("written");
    }
    folder
}

fn read(text: &str) -> Result<Robot, RobotError> {
    let folder = folder(&[("m.xml", text)]);
    Robot::load(&folder.path().join("m.xml"), &RobotOptions::default())
}

fn refusal(text: &str) -> String {
    let folder = folder(&[("m.xml", text)]);
    let refused = ModelText::read(&folder.path().join("m.xml"), ModelUse::Robot, &[]);
    let prefix = format!("{}/", folder.path().display());
    refused.expect_err(text).to_string().replace(&prefix, "")
}

/// Returns an MJCF of an arm with this content of its last body, and further sections.
fn arm(last: &str, sections: &str) -> String {
    format!(
        "<mujoco><worldbody><body name='a'><joint name='j1' range='-90 90'/><geom size='0.1'/>\
         <body name='b' pos='1 0 0'><joint name='j2' range='-90 90'/>{last}</body></body></worldbody>{sections}</mujoco>"
    )
}

fn pairs(robot: &Robot) -> Vec<[&str; 2]> {
    let name = |link: usize| robot.links()[link].name.as_str();
    robot.disabled_pairs().iter().map(|&(a, b)| [name(a), name(b)]).collect()
}

#[test]
fn pairs_that_have_no_contacts_in_the_model_are_not_checked() {
    let last = "<geom name='g' size='0.1'/><body name='c' pos='1 0 0'><joint name='j3' range='0 1'/>\
                <geom size='0.1' contype='2' conaffinity='4'/><geom size='0.2'/>\
                <body name='d' pos='1 0 0'><geom size='0.1'/></body></body>";
    let robot = read(&arm(last, "<contact><exclude body1='a' body2='d'/></contact>")).expect("a robot");
    let all = pairs(&robot);
    for (pair, expected) in [
        // Parent and child, also over a body without a joint between them.
        (["a", "b"], true),
        (["b", "c"], true),
        (["b", "d"], true),
        (["a", "d"], true),
        (["a", "c_contact"], false),
        // The first geom of c collides with nothing: no bit of it is in another mask.
        (["a", "c"], true),
    ] {
        assert_eq!(all.contains(&pair), expected, "{pair:?}: {all:?}");
    }
    // Rigid links have no contacts in any robot.
    assert!(!all.contains(&["c", "d"]), "{all:?}");
}

#[test]
fn a_pair_collides_regardless_of_masks() {
    let last = "<geom name='g' size='0.1' contype='0' conaffinity='0'/><body name='c' pos='1 0 0'>\
                <joint name='j3' range='0 1'/><geom name='h' size='0.1' contype='0' conaffinity='0'/></body>";
    let robot = read(&arm(last, "<contact><pair geom1='g' geom2='h'/></contact>")).expect("a robot");
    assert!(!pairs(&robot).contains(&["b", "c"]), "{:?}", pairs(&robot));
    assert!(pairs(&robot).contains(&["a", "c"]), "{:?}", pairs(&robot));
    let visual = read(&arm(last, "")).expect("a robot");
    let c = visual.link_index("c").expect("a link");
    assert!(visual.links()[c].collisions.is_empty() && visual.links()[c].visuals.len() == 1);
}

#[test]
fn shapes_have_the_sizes_and_places_of_the_file() {
    let last = "<geom type='capsule' size='0.1' fromto='0 0 0 0 0 2'/>\
                <geom type='box' size='0.1 0.2 0.3' pos='1 0 0' euler='0 0 90'/>\
                <geom type='ellipsoid' size='0.1 0.2 0.3'/>\
                <geom type='mesh' mesh='corner'/>";
    let mesh = "<asset><mesh name='corner' vertex='0 0 0  1 0 0  0 1 0  0 0 1' scale='1 2 3' refpos='0 0 0.5'/></asset>";
    let robot = read(&arm(last, mesh)).expect("a robot");
    let link = &robot.links()[robot.link_index("b").expect("a link")];
    let reach = |shape: usize, direction: Vector| {
        let shape = &link.collisions[shape];
        let local = shape.link_from_shape.rotation.inverse() * direction;
        let point = shape.solid.support_point(&local).expect("a convex solid");
        (shape.link_from_shape * point).coords.dot(&direction)
    };
    let near = |found: f64, expected: f64, within: f64| {
        assert!((found - expected).abs() <= within, "{found} {expected}");
    };
    near(reach(0, Vector::z()), 2.1, 1e-12);
    near(reach(0, -Vector::z()), 0.1, 1e-12);
    near(reach(1, Vector::x()), 1.2, 1e-12);
    near(reach(1, Vector::y()), 0.1, 1e-12);
    // The hull around an ellipsoid exceeds it by at most half a percent.
    for (axis, radius) in [(Vector::x(), 0.1), (Vector::y(), 0.2), (Vector::z(), 0.3)] {
        let found = reach(2, axis);
        assert!(found >= radius && found <= 1.005 * radius, "{found} {radius}");
    }
    near(reach(3, Vector::y()), 2.0, 1e-12);
    near(reach(3, Vector::z()), 1.5, 1e-12);
    near(reach(3, -Vector::z()), 1.5, 1e-12);
}

#[test]
fn free_bodies_and_planes_are_named_and_no_part_of_a_robot() {
    let world = "<geom name='ground' type='plane' size='1 1 1'/><body name='cube' pos='3 0 0'><freejoint/><geom size='0.1'/></body>";
    let text = arm("<geom size='0.1'/>", &format!("<worldbody>{world}</worldbody>"));
    let robot = read(&text).expect("a robot");
    assert!(robot.link_index("cube").is_none());
    let notes = robot.notes().join("\n");
    assert!(
        notes.contains("no part of the robot: cube") && notes.contains("no part of the robot: ground"),
        "{notes}"
    );
    let folder = folder(&[("m.xml", &text)]);
    let model = ModelText::read(&folder.path().join("m.xml"), ModelUse::World, &[]).expect("a world");
    assert_eq!(model.movable, [["cube".to_owned()]]);
    assert_eq!(model.planes.len(), 1);
}

#[test]
fn a_free_body_with_joints_floats() {
    let text = "<mujoco><worldbody><body name='a' pos='0 0 1'><freejoint/><geom size='0.1'/><body name='b'>\
                <joint name='j' range='-1 1'/><geom size='0.1'/></body></body></worldbody></mujoco>";
    let robot = read(text).expect("a robot");
    assert_eq!(robot.dof(), 7, "{:?}", robot.joint_names());
}

#[test]
fn what_is_not_read_is_named_once_for_each_kind() {
    let sections = "<actuator><motor joint='j1'/><motor joint='j2'/></actuator><sensor/><tendon/>\
                    <keyframe><key name='home' qpos='0.1 0.2'/><key qpos='1'/></keyframe>";
    let last = "<geom size='0.1' friction='1 1 1' mass='2'/><site name='s'/><site/>";
    let robot = read(&arm(last, sections)).expect("a robot");
    let notes = robot.notes().join("\n");
    for expected in [
        "element <actuator> of <mujoco> is not read",
        "element <sensor> of <mujoco> is not read",
        "element <tendon> of <mujoco> is not read",
        "element <site> of <body> is not read, here and at 1 more place",
        "not read of <geom>: friction, mass",
        "a keyframe of 1 value is not read: the model has 2",
    ] {
        assert_eq!(notes.matches(expected).count(), 1, "{expected}: {notes}");
    }
    assert_eq!(robot.group_state("home"), Some(vec![0.1, 0.2]));
}

#[test]
fn content_that_would_change_the_robot_is_refused_with_its_line() {
    let body =
        |inside: &str| format!("<mujoco>\n<worldbody>\n<body name='a'>{inside}</body></worldbody></mujoco>");
    for (text, expected) in [
        (body("<joint type='ball'/>"), "m.xml:3: joint `` is of type `ball`"),
        (body("<composite/>"), "m.xml:3: <composite> in a body is not supported"),
        (body("<replicate count='1000000000'/>"), "m.xml:3: <replicate> in a body is not supported"),
        (body("<attach/>"), "m.xml:3: <attach> in a body is not supported"),
        (body("<geom type='sdf'/>"), "m.xml:3: a geom that is a signed distance field is not supported"),
        (body("<geom type='hfield' hfield='h'/>"), "m.xml:3: a geom that is a height field is not supported"),
        (body("<geom><plugin/></geom>"), "m.xml:3: a <plugin> is not supported"),
        (
            body("<geom size='0.1' tpye='box'/>"),
            "m.xml:3: attribute `tpye` in <geom> of body `a` is not understood",
        ),
        (body("<joint axis='0 0 0' name='j'/>"), "m.xml:3: joint `j` can move, but its axis is zero"),
        (body("<geom size='0.1' class='no'/>"), "m.xml:3: unknown default class `no`"),
        (
            body("<geom type='box' size='0.1 0.1'/>"),
            "m.xml:3: size of <geom> of body `a` must be greater than 0",
        ),
        (body("<geom type='mesh' mesh='no'/>"), "m.xml:3: the unknown mesh `no` is not supported"),
        (body("<geom type='plane'/><joint/>"), ""),
        (body("<joint/><geom type='plane'/>"), "m.xml:3: a plane that moves is not supported"),
        (
            body("<geom size='0.1' quat='1 0 0 0' euler='0 0 0'/>"),
            "m.xml:3: `quat` beside `euler` is not supported",
        ),
        (body("<geom size='0.1' pos='1 nan 0'/>"), "m.xml:3: pos=\"1 nan 0\" of <geom>"),
        (
            "<mujoco><compiler coordinate='global'/></mujoco>".into(),
            "m.xml:1: coordinate=\"global\" is not supported",
        ),
        ("<mujoco><deformable/></mujoco>".into(), "m.xml:1: <deformable> is not supported"),
        ("<mujoco><asset><model/></asset></mujoco>".into(), "m.xml:1: <model> is not supported"),
        (
            arm(
                "<geom size='0.1'/>",
                "<equality><joint joint1='j1' joint2='j2' polycoef='0 1 2'/></equality>",
            ),
            "m.xml:1: a curved constraint of joint `j1` is not supported",
        ),
        (
            arm("<geom size='0.1'/>", "<equality><tendon tendon1='t'/></equality>"),
            "m.xml:1: a constraint of the unknown tendon `t` is not supported",
        ),
        (arm("", "<contact><exclude body1='a' body2='x'/></contact>"), "m.xml:1: unknown body `x`"),
        (
            "<mujoco><include file='m.xml'/></mujoco>".into(),
            "m.xml:1: a second <include> of m.xml is not supported",
        ),
        ("<mujoco><include file='no.xml'/></mujoco>".into(), "no.xml: cannot be read"),
        (format!("<mujoco>{}", "<a>".repeat(300)), "m.xml:1: 257 elements inside each other"),
    ] {
        if !expected.is_empty() {
            let message = refusal(&text);
            assert!(message.starts_with(expected), "{text}: {message}");
        }
    }
}

#[test]
fn a_fixed_tendon_over_two_joints_couples_them() {
    let sections = "<tendon><fixed name='t'><joint joint='j1' coef='2'/><joint joint='j2' coef='-4'/></fixed></tendon>\
                    <equality><tendon tendon1='t' polycoef='0.4 1 0 0 0'/></equality>";
    let robot = read(&arm("<geom size='0.1'/>", sections)).expect("a robot");
    assert_eq!(robot.joint_names(), ["j1"]);
    // 2 q1 - 4 q2 = 0.4
    let q2 = robot.joint_value("j2", &[0.3]).expect("a joint");
    assert!((2.0 * 0.3 - 4.0 * q2 - 0.4).abs() < 1e-12, "{q2}");
}

/// Nesting over files is bounded too: each file alone is within the limits.
#[test]
fn bodies_inside_each_other_over_many_files_are_refused() {
    let deep =
        |inside: &str| format!("<mujoco>{}{inside}{}</mujoco>", "<body>".repeat(200), "</body>".repeat(200));
    let main = format!("<mujoco><worldbody>{}</worldbody></mujoco>", "<include file='a.xml'/>");
    let files = folder(&[
        ("m.xml", main.as_str()),
        ("a.xml", deep("<include file='b.xml'/>").as_str()),
        ("b.xml", deep("").as_str()),
    ]);
    let refused = ModelText::read(&files.path().join("m.xml"), ModelUse::World, &[]).expect_err("too deep");
    assert!(refused.to_string().contains("bodies inside each other"), "{refused}");
}

#[test]
fn an_include_must_be_a_regular_file() {
    let files = folder(&[("m.xml", "<mujoco><include file='.'/></mujoco>")]);
    let refused = ModelText::read(&files.path().join("m.xml"), ModelUse::World, &[]).expect_err("a folder");
    assert!(matches!(refused, RobotError::Unreadable { .. }), "{refused}");
}

/// A cabinet whose drawer follows a knob, and a can on it.
const CABINET: &str = "<mujoco><worldbody><geom name='wall' type='box' size='1 0.1 1' pos='0 2 0'/>
  <body name='cabinet' pos='1 0 0'><geom type='box' size='0.2 0.2 0.2'/>
    <body name='drawer' pos='0 0 0.5'><joint name='drawer' type='slide' axis='1 0 0' range='0 0.4'/><geom size='0.1'/></body>
    <body name='door'><joint name='door' axis='0 0 1' range='0 90'/><geom size='0.1' pos='0.3 0 0'/></body>
  </body>
  <body name='can' pos='0 0 2'><freejoint/><geom type='cylinder' size='0.03 0.05'/></body></worldbody>
  <equality><joint joint1='door' joint2='drawer' polycoef='0 2'/></equality></mujoco>";

#[test]
fn links_of_a_world_are_where_its_joint_values_put_them() {
    let folder = folder(&[("w.xml", CABINET)]);
    let path = folder.path().join("w.xml");
    let model = ModelText::read(&path, ModelUse::World, &[]).expect("a world");
    let values = BTreeMap::from([("drawer".to_owned(), 0.3)]);
    let links = model.world_links(&path, &[], &values).expect("links");
    let place = |name: &str| {
        let link = links.iter().find(|link| link.name == name).expect("a link");
        link.solids[0].0 * Point::origin()
    };
    assert!((place("drawer") - Point::new(1.3, 0.0, 0.5)).norm() < 1e-12);
    let (sine, cosine) = 0.6_f64.sin_cos();
    assert!((place("door") - Point::new(1.0 + 0.3 * cosine, 0.3 * sine, 0.0)).norm() < 1e-12);
    assert!((place("can") - Point::new(0.0, 0.0, 2.0)).norm() < 1e-12);
    assert_eq!(
        links.iter().find(|link| link.name == "drawer").expect("a link").ancestors,
        ["cabinet", "world"]
    );
    let with = |name: &str, value: f64| {
        let values = BTreeMap::from([(name.to_owned(), value)]);
        model.world_links(&path, &[], &values).expect_err(name)
    };
    assert!(matches!(with("drawer", 0.5), RobotError::HeldOutsideLimits { .. }));
    assert!(matches!(with("drawre", 0.1), RobotError::UnknownName { .. }));
    assert!(matches!(with("door", 0.1), RobotError::NotFree { .. }));
}

#[test]
fn a_world_of_an_sdf_has_its_free_models_and_its_ground() {
    let world = "<sdf version='1.9'><world name='w'>
      <model name='ground'><static>true</static><link name='l'><collision name='c'><geometry><plane><normal>0 0 1</normal></plane></geometry></collision></link></model>
      <model name='table'><static>1</static><pose>1 0 0.5 0 0 0</pose><link name='top'><collision name='c'><geometry><box><size>1 1 0.1</size></box></geometry></collision></link></model>
      <include><uri>model://can</uri><name>first</name><pose relative_to='table'>0 0 0.1 0 0 0</pose></include>
      <light name='sun'/></world></sdf>";
    let can = "<sdf version='1.6'><model name='can'><link name='body'><collision name='c'><geometry><cylinder><radius>0.03</radius><length>0.1</length></cylinder></geometry></collision></link></model></sdf>";
    let folder = folder(&[("worlds/w.sdf", world), ("models/can/model.sdf", can)]);
    let path = folder.path().join("worlds/w.sdf");
    let nowhere = ModelText::read(&path, ModelUse::World, &[]).expect_err("the folder is not above the file");
    assert!(nowhere.to_string().contains("model://can"), "{nowhere}");
    let folders = [folder.path().join("models")];
    let model = ModelText::read(&path, ModelUse::World, &folders).expect("a world");
    assert_eq!(model.movable, [["first::body".to_owned()]]);
    assert_eq!(model.planes.len(), 1);
    assert!(model.notes.iter().any(|note| note.contains("element <light>")), "{:?}", model.notes);
    let links = model.world_links(&path, &folders, &BTreeMap::new()).expect("links");
    let names: Vec<&str> = links.iter().map(|link| link.name.as_str()).collect();
    assert_eq!(names, ["table::top", "first::body"]);
    assert!((links[1].solids[0].0.translation.vector - Vector::new(1.0, 0.0, 0.6)).norm() < 1e-12);
}

/// Masses that the model computes are not known, and never those of its text.
#[test]
fn masses_that_a_model_computes_count_as_not_stated() {
    let inertial = "<inertial pos='0 0 0' mass='2' diaginertia='1 1 1'/>";
    let masses = |text: &str| -> (Vec<Option<f64>>, Vec<String>) {
        let robot = read(text).expect("a robot");
        let masses = robot.links().iter().map(|link| link.inertial.map(|inertial| inertial.mass_kg));
        (masses.collect(), robot.notes().to_vec())
    };
    let plain =
        arm(&format!("{inertial}<geom size='0.1'/>"), "<compiler inertiafromgeom='auto' settotalmass='-1'/>");
    assert!(masses(&plain).0.contains(&Some(2.0)));
    for changed in ["inertiafromgeom='true'", "settotalmass='5'", "boundmass='0.1'", "balanceinertia='true'"]
    {
        let text = arm(&format!("{inertial}<geom size='0.1'/>"), &format!("<compiler {changed}/>"));
        let (found, notes) = masses(&text);
        assert!(found.iter().all(Option::is_none), "{changed}: {found:?}");
        let name = changed.split('=').next().unwrap_or_default();
        assert!(notes.iter().any(|note| note.contains(name) && note.contains("without mass")), "{notes:?}");
    }
    let sdf = "<sdf version='1.11'><model name='m'><link name='a'/>
      <link name='b'><pose>0 0 0.4 0 0 0</pose><inertial auto='true'><density>5000</density></inertial>
        <collision name='c'><geometry><box><size>0.6 0.1 0.1</size></box></geometry></collision></link>
      <joint name='j' type='revolute'><parent>a</parent><child>b</child><axis><xyz>0 1 0</xyz><initial_position>0.4</initial_position>
        <limit><lower>-1</lower><upper>1</upper><stiffness>3</stiffness></limit></axis></joint></model></sdf>";
    let (found, notes) = masses(sdf);
    assert!(found.iter().all(Option::is_none), "{found:?}");
    for part in ["auto", "<initial_position>", "<stiffness>"] {
        assert!(notes.iter().any(|note| note.contains(part)), "{part}: {notes:?}");
    }
}

/// Models of Gazebo of versions before 1.7 name joints like links, state limits of 1e12 and begin with an empty line.
#[test]
fn an_old_sdf_of_gazebo_is_read() {
    let text = "\n<?xml version='1.0'?>\n<sdf version='1.5'><model name='m'>
      <link name='a'/><link name='wheel'><pose>1 0 0 0 0 0</pose></link>
      <joint name='wheel' type='revolute'><pose>0 0.5 0 0 0 0</pose><parent>a</parent><child>wheel</child>
        <axis><xyz>0 0 1</xyz><limit><lower>-1e12</lower><upper>1e12</upper></limit></axis></joint></model></sdf>";
    let robot = read(text).expect("a robot");
    assert_eq!(robot.joint_names(), ["wheel"]);
    assert!(robot.limits()[0].upper < 1e4, "{:?}", robot.limits());
    // A quarter turn about (1, 0.5) moves the origin of the wheel.
    let wheel = robot.link_index("wheel").expect("a link");
    let place = robot.frames_at(&[FRAC_PI_2]).link(wheel).translation.vector;
    assert!((place - Vector::new(1.5, 0.5, 0.0)).norm() < 1e-12, "{place}");
    let double = text.replacen("1.5", "1.9", 1);
    let refused = read(&double).expect_err("a joint named like a link").to_string();
    assert!(refused.contains("m.xml:5: frame `wheel` is defined twice, first in line 4"), "{refused}");
}

#[test]
fn faults_of_an_sdf_are_refused_with_their_lines() {
    let model =
        |inside: &str| format!("<sdf version='1.9'><model name='m'><link name='a'/>\n{inside}</model></sdf>");
    for (text, expected) in [
        ("<sdf version='2.0'/>".to_owned(), "m.xml:1: version 2.0 of SDF is not supported"),
        ("<sdf version='1.9'/>".to_owned(), "m.xml:1: <sdf> has no"),
        (model("<link name='b'><pose relative_to='c'/></link>"), "m.xml:2: unknown frame `c`"),
        (
            model(
                "<frame name='f'><pose relative_to='f'/></frame><link name='b'><pose relative_to='f'/></link>",
            ),
            "m.xml:2: frame `f`",
        ),
        (
            model("<link name='b'><pose>1 2 3</pose></link>"),
            "m.xml:2: a <pose> of 3 numbers is not supported",
        ),
        (model("<link name='b'><pose>1 2 x 0 0 0</pose></link>"), "m.xml:2: `x` in <pose> is not supported"),
        (model("<link name='a'/>"), "m.xml:2: frame `a` is defined twice"),
        (
            model("<joint name='j' type='ball'><parent>a</parent><child>a</child></joint>"),
            "m.xml:2: joint `j` is of type `ball`",
        ),
        (
            model(
                "<link name='b'/><joint name='j' type='fixed'><parent>a</parent><child>b</child></joint><joint name='k' type='fixed'><parent>a</parent><child>b</child></joint>",
            ),
            "m.xml:2: link `b` has two parents",
        ),
        (
            model("<link name='b'/><joint name='j' type='fixed'><parent>b</parent><child>b</child></joint>"),
            "m.xml:2: the joints `j` form a loop",
        ),
        (
            model("<link name='b'><collision name='c'><geometry><heightmap/></geometry></collision></link>"),
            "m.xml:2: the geometry <heightmap> is not supported",
        ),
        (model("<include><uri>https://fuel/can</uri></include>"), "m.xml:2: the address https://fuel/can"),
        (
            model("<include><uri>model://no</uri></include>"),
            "m.xml:2: the model `model://no` that is included was not found; tried ",
        ),
    ] {
        let message = refusal(&text);
        assert!(message.starts_with(expected), "{text}: {message}");
    }
}

/// A model that includes itself ends at a bound.
#[test]
fn an_sdf_that_includes_itself_is_refused() {
    let text = "<sdf version='1.9'><model name='m'><include><uri>m.sdf</uri></include></model></sdf>";
    let folder = folder(&[("m.sdf", text)]);
    let refused = ModelText::read(&folder.path().join("m.sdf"), ModelUse::World, &[]).expect_err("a cycle");
    assert!(refused.to_string().contains("models inside each other"), "{refused}");
}

#[test]
fn the_files_of_a_model_are_a_urdf_with_its_pairs_and_speeds() {
    let folder = folder(&[("arm.xml", &arm("<geom size='0.1'/>", ""))]);
    let path = folder.path().join("arm.xml");
    let files = cranny_robot::RobotFiles::gather(&path, None, &[]).expect("files");
    assert_eq!((files.urdf.as_str(), files.srdf.as_deref()), ("arm.urdf", Some("arm.srdf")));
    let written = tempfile::tempdir().expect("a folder");
    for (name, content) in &files.contents {
        fs::write(written.path().join(name), content).expect("written");
    }
    let (own, again) = (load(&path), load(&written.path().join("arm.urdf")));
    assert_eq!(own.disabled_pairs(), again.disabled_pairs());
    assert_eq!(own.limits(), again.limits());
}

fn load(path: &Path) -> Robot {
    let joints = JointGroup::Joints(vec!["j1".to_owned(), "j2".to_owned()]);
    Robot::load(path, &RobotOptions { group: joints, ..RobotOptions::default() }).expect("a robot")
}
