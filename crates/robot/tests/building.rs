//! Properties of a robot built from its files.

use std::path::Path;

use cranny_robot::{
    CONTINUOUS_LIMIT_RAD, JointGroup, JointKind, JointUnit, LimitViolation, LinkForm, MeshUse, Robot,
    RobotOptions, TextSource,
};

fn names(robot: &Robot, pairs: &[(usize, usize)]) -> Vec<(String, String)> {
    let name = |link: usize| robot.links()[link].name.clone();
    pairs.iter().map(|&(first, second)| (name(first), name(second))).collect()
}

#[test]
fn the_arm_has_its_joints_limits_and_rates_in_the_order_of_q() {
    let robot = crate::fixture::mobile_arm();
    assert_eq!(robot.name(), "mobile_arm");
    assert_eq!(robot.dof(), 9);
    assert_eq!(robot.joint_names()[..3], ["base_y", "base_x", "joint1"]);
    let limits = robot.limits();
    assert_eq!((limits[0].lower, limits[0].upper, limits[0].velocity), (-1.0, 1.0, 0.5));
    assert_eq!((limits[0].acceleration, limits[0].jerk), (Some(1.0), Some(10.0)));
    assert_eq!((limits[3].acceleration, limits[3].jerk), (Some(7.5), None));
    assert_eq!(limits[8].acceleration, None);
    assert_eq!((limits[1].unit, limits[2].unit), (JointUnit::Metre, JointUnit::Radian));
    assert_eq!(robot.joints()[0].kind, JointKind::Prismatic);
    assert_eq!(robot.links()[robot.joints()[4].child_link].name, "link3");
}

#[test]
fn links_come_after_their_parents_and_know_what_moves_them() {
    let robot = crate::fixture::mobile_arm();
    for (index, link) in robot.links().iter().enumerate() {
        assert!(link.parent.is_none_or(|parent| parent < index));
        assert_eq!(link.parent.is_none(), index == robot.root());
        assert_eq!(robot.link_index(&link.name), Some(index));
    }
    let movers = |link: &str| -> Vec<usize> {
        robot.ancestors(robot.link_index(link).unwrap()).iter().map(|mover| mover.joint).collect()
    };
    assert!(movers("root").is_empty());
    assert_eq!(movers("link0"), [0, 1]);
    assert_eq!(movers("right_finger"), (0..9).collect::<Vec<_>>());
    // A mimic joint counts towards its master, with the factor of the whole chain of mimic joints.
    let mimic = crate::fixture::mimic();
    let movers: Vec<_> = mimic.ancestors(4).iter().map(|mover| (mover.joint, mover.multiplier)).collect();
    assert_eq!(movers, [(0, 1.0), (0, -0.5), (1, 1.0), (0, -1.0)]);
    assert!(mimic.ancestors(4).iter().all(|mover| (mover.axis_in_child.norm() - 1.0).abs() < 1e-12));
}

#[test]
fn held_fingers_stand_open_whether_one_or_both_are_named() {
    let mut options = crate::fixture::mobile_arm_options();
    options.fixed.insert("right_finger_joint".to_owned(), 0.04);
    let robots = [
        crate::fixture::mobile_arm(),
        Robot::load(&crate::fixture::path("mobile_arm/mobile_arm.urdf"), &options).unwrap(),
    ];
    for robot in robots {
        let frames = robot.frames_at(&crate::fixture::HOME);
        let hand_from = |link: &str| {
            let frame = |name: &str| frames.link(robot.link_index(name).unwrap());
            frame("hand").inverse() * frame(link)
        };
        assert!((hand_from("left_finger").translation.y - 0.04).abs() < 1e-12);
        assert!((hand_from("right_finger").translation.y + 0.04).abs() < 1e-12);
    }
}

#[test]
fn links_are_adjacent_across_bare_ones_and_not_across_solid_ones() {
    let robot = crate::fixture::mobile_arm();
    let pairs = names(&robot, robot.adjacent_pairs());
    let has = |first: &str, second: &str| pairs.contains(&(first.to_owned(), second.to_owned()));
    assert!(has("platform", "link0") && has("link6", "link7"));
    assert!(has("link7", "hand"), "the flange between them is bare: {pairs:?}");
    assert!(has("hand", "left_finger") && has("hand", "right_finger"));
    assert!(!has("left_finger", "right_finger") && !has("link5", "link7"));
    // The robot has eleven solid links in a row, and a second finger.
    assert_eq!(pairs.len(), 11);
}

#[test]
fn the_srdf_gives_pairs_states_groups_and_the_tip() {
    let robot = crate::fixture::mobile_arm();
    let pairs = names(&robot, robot.disabled_pairs());
    assert_eq!(pairs, [("link0".into(), "link2".into()), ("link6".into(), "hand".into())]);
    assert_eq!(robot.group_state("ready"), None, "it says nothing of the base");
    let load = |group: &str| {
        let options = RobotOptions { group: JointGroup::Srdf(group.to_owned()), ..RobotOptions::default() };
        Robot::load(&crate::fixture::path("mobile_arm/mobile_arm.urdf"), &options).unwrap()
    };
    let arm = load("arm");
    assert_eq!(arm.dof(), 7);
    assert_eq!(arm.links()[arm.tip()].name, "flange");
    assert_eq!(arm.group_state("ready"), Some(vec![0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]));
    let whole = load("whole");
    assert_eq!(whole.joint_names(), robot.joint_names());
    assert_eq!(whole.links()[whole.tip()].name, "flange", "where the end effector is mounted");
}

#[test]
fn without_an_srdf_the_tip_is_the_bare_leaf_below_the_most_joints() {
    let text = std::fs::read_to_string(crate::fixture::path("mobile_arm/mobile_arm.urdf")).unwrap();
    let options = RobotOptions { tip: None, ..crate::fixture::mobile_arm_options() };
    let robot = Robot::from_urdf_text(&text, "text", None, &options).unwrap();
    assert_eq!(robot.links()[robot.tip()].name, "grasp_frame");
    assert_eq!(robot.limits()[0].acceleration, None, "a text has no file beside it");
}

#[test]
fn a_group_of_names_keeps_their_order_and_holds_the_rest() {
    let group = ["joint3", "joint1"].map(str::to_owned).to_vec();
    let options =
        RobotOptions { group: JointGroup::Joints(group.clone()), ..crate::fixture::mobile_arm_options() };
    let robot = Robot::load(&crate::fixture::path("mobile_arm/mobile_arm.urdf"), &options).unwrap();
    assert_eq!(robot.joint_names(), group);
    assert_eq!(robot.ancestors(robot.tip()).iter().map(|mover| mover.joint).collect::<Vec<_>>(), [1, 0]);
    // All other joints have the values of the whole arm at 0, joint 4 at its limit nearest to 0.
    let whole = crate::fixture::mobile_arm();
    let (mut frames, mut whole_frames) = (robot.frames(), whole.frames());
    robot.forward_kinematics(&[0.3, -0.2], &mut frames);
    whole.forward_kinematics(&[0.0, 0.0, -0.2, 0.0, 0.3, 0.0, 0.0, 0.0, 0.0], &mut whole_frames);
    for (actual, expected) in frames.all().iter().zip(whole_frames.all()) {
        assert!((actual.to_homogeneous() - expected.to_homogeneous()).norm() < 1e-12);
    }
}

#[test]
fn limits_are_closed_and_exclude_nan() {
    let robot = crate::fixture::mobile_arm();
    let mut q = crate::fixture::HOME;
    q[0] = 1.0;
    assert!(robot.within_limits(&q));
    q[0] = 1.0 + f64::EPSILON;
    let violation = LimitViolation { joint: 0, value: q[0], lower: -1.0, upper: 1.0 };
    assert_eq!(robot.first_limit_violation(&q), Some(violation));
    q[0] = f64::NAN;
    assert!(!robot.within_limits(&q));
    // A joint with a follower is limited by it.
    let lead = crate::fixture::mimic().limits()[0];
    assert_eq!((lead.lower, lead.upper), (-8.0, CONTINUOUS_LIMIT_RAD));
}

#[test]
fn a_mesh_is_found_in_its_package_scaled_and_kept() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("packages/some_arm/meshes");
    std::fs::create_dir_all(&folder).unwrap();
    let tetrahedron = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    std::fs::write(folder.join("tetrahedron.obj"), tetrahedron).unwrap();
    let text = std::fs::read_to_string(crate::fixture::path("bad/missing_package_mesh.urdf"))
        .unwrap()
        .replace("absent.stl\"", "meshes/tetrahedron.obj\" scale=\"2 2 2\"");
    for meshes in [MeshUse::Hull, MeshUse::Solid] {
        let packages = vec![Path::new(env!("CARGO_TARGET_TMPDIR")).join("packages")];
        let options = RobotOptions { packages, meshes, ..RobotOptions::default() };
        let robot = Robot::from_urdf_text(&text, "text", None, &options).unwrap();
        let soup = robot.links()[1].collisions[0].soup.as_ref().unwrap();
        assert_eq!(soup.triangles.len(), 4);
        let farthest = soup.vertices.iter().map(|vertex| vertex.x).fold(0.0, f64::max);
        assert!((farthest - 2.0).abs() < 1e-12);
    }
}

#[test]
fn every_released_robot_loads() {
    let Some(data) = crate::fixture::data_folder("loading the released robots") else { return };
    let names = [
        "panda",
        "mobile_panda",
        "mobile_panda_fingers",
        "mobile_panda_fingersSmallMesh",
        "mobile_panda_fingersSmallMeshVis",
    ];
    for name in names {
        let urdf = data.join("jogramop/robots/franka_panda").join(format!("{name}.urdf"));
        let options = RobotOptions { tip: Some("panda_grasptarget".to_owned()), ..RobotOptions::default() };
        let robot = Robot::load(&urdf, &options).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(robot.dof(), if name == "panda" { 7 } else { 9 }, "{name}");
    }
    let folder = data.join("motion_bench_maker");
    let options = RobotOptions {
        srdf: Some(TextSource::Path(folder.join("panda.srdf"))),
        group: JointGroup::Srdf("panda_arm".to_owned()),
        ..RobotOptions::default()
    };
    let robot = Robot::load(&folder.join("panda_spherized.urdf"), &options).unwrap();
    assert_eq!(robot.links().iter().map(|link| link.collisions.len()).sum::<usize>(), 59);
    assert_eq!(robot.links()[robot.tip()].name, "panda_link8");
    assert!(robot.group_state("ready").is_some_and(|ready| robot.within_limits(&ready)));
}

#[test]
fn a_robot_is_shared_between_threads() {
    fn assert_shared<T: Send + Sync>(_: &T) {}
    assert_shared(&crate::fixture::mobile_arm());
}

#[test]
fn texts_stand_in_for_files() {
    let text = |name: &str| TextSource::Text {
        name: name.to_owned(),
        text: std::fs::read_to_string(crate::fixture::path("mobile_arm").join(name)).unwrap(),
    };
    let urdf = std::fs::read_to_string(crate::fixture::path("mobile_arm/mobile_arm.urdf")).unwrap();
    let options = RobotOptions {
        srdf: Some(text("mobile_arm.srdf")),
        limits: Some(text("limits.yaml")),
        ..crate::fixture::mobile_arm_options()
    };
    let robot = Robot::from_urdf_text(&urdf, "built-in", None, &options).unwrap();
    assert_eq!(robot.limits(), crate::fixture::mobile_arm().limits());
    assert_eq!(robot.disabled_pairs(), crate::fixture::mobile_arm().disabled_pairs());
}

#[test]
fn a_link_looks_as_its_visuals_say() {
    let urdf = r#"<robot name="r">
      <material name="red"><color rgba="1 0 0 1"/></material>
      <link name="base">
        <visual><origin xyz="0 0 1"/><geometry><box size="1 2 3"/></geometry><material name="red"/></visual>
        <visual blend="0.02" rounding="0.01">
          <geometry><cylinder length="1" radius="0.5"/></geometry>
          <material name="later"/>
        </visual>
        <visual><geometry><mesh filename="no/such.dae" scale="1 1 -1"/></geometry></visual>
      </link>
      <link name="cart">
        <visual>
          <geometry><sphere radius="1"/></geometry>
          <material name="later"><color rgba="0 0 1 0.5"/></material>
        </visual>
      </link>
      <joint name="drive" type="prismatic">
        <parent link="base"/><child link="cart"/><limit lower="-1" upper="1" velocity="1"/>
      </joint>
    </robot>"#;
    let robot = Robot::from_urdf_text(urdf, "r.urdf", None, &RobotOptions::default()).unwrap();
    let [box_, cylinder, mesh] = &robot.links()[0].visuals[..] else { panic!("three visuals") };
    assert_eq!(box_.colour, Some([1.0, 0.0, 0.0, 1.0]));
    assert!((box_.link_from_visual.translation.z - 1.0).abs() < 1e-12);
    assert_eq!(cylinder.colour, Some([0.0, 0.0, 1.0, 0.5]), "a material is known by its name everywhere");
    assert_eq!((cylinder.rounding_m, cylinder.blend_m), (0.01, 0.02));
    // The file is needed only for display.
    assert!(matches!(&mesh.form, LinkForm::Mesh { name, .. } if name == "no/such.dae"));
    assert!(robot.links()[0].collisions.is_empty());
}

#[test]
fn a_visual_that_is_none_is_refused_with_its_place() {
    let refused = |visual: &str| {
        let urdf = format!("<robot name='r'><link name='base'>\n{visual}</link></robot>");
        Robot::from_urdf_text(&urdf, "r.urdf", None, &RobotOptions::default()).unwrap_err().to_string()
    };
    for (visual, word) in [
        ("<visual/>", "<visual> of link `base`"),
        ("<visual><geometry><box size='1 2'/></geometry></visual>", "size"),
        ("<visual><geometry><torus/></geometry></visual>", "torus"),
        ("<visual blend='-1'><geometry><sphere radius='1'/></geometry></visual>", "blend"),
    ] {
        let fault = refused(visual);
        assert!(fault.contains("r.urdf:2") && fault.contains(word), "{fault}");
    }
}
