//! Forward kinematics against the `k` crate, which shares no code with this one.

use std::path::Path;

use cranny_robot::{Robot, RobotOptions};
use cranny_spatial::Stream;
use cranny_spatial::nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3};

/// Compares all links at random configurations. `k` moves every joint that does not mimic, so the joints outside the
/// group are set to `others`.
fn assert_agrees_with_k(robot: &Robot, urdf: &Path, others: &[(&str, f64)]) {
    let chain: k::Chain<f64> = k::Chain::from_urdf_file(urdf).expect("k reads the file");
    let mut random = Stream::new(1, 0);
    let mut frames = robot.frames();
    for _ in 0..200 {
        let q: Vec<f64> = robot.random_configuration(&mut random);
        robot.forward_kinematics(&q, &mut frames);
        let values: Vec<f64> = chain
            .iter_joints()
            .map(|joint| {
                let of_group = robot.joint_names().iter().position(|name| *name == joint.name);
                let of_others = others.iter().find(|(name, _)| *name == joint.name);
                of_group.map(|index| q[index]).or(of_others.map(|(_, value)| *value)).expect("a known joint")
            })
            .collect();
        chain.set_joint_positions_unchecked(&values);
        chain.update_transforms();
        for (index, link) in robot.links().iter().enumerate() {
            let expected = chain.find_link(&link.name).and_then(k::Node::world_transform);
            let expected = expected.expect("k knows the link").to_homogeneous();
            let actual = frames.link(index).to_homogeneous();
            for (row, column) in (0..4).flat_map(|row| (0..4).map(move |column| (row, column))) {
                let difference = (actual[(row, column)] - expected[(row, column)]).abs();
                assert!(difference < 1e-9, "{}: {actual} {expected}", link.name);
            }
        }
    }
}

#[test]
fn all_links_of_the_arm_are_where_k_puts_them() {
    let fingers = [("left_finger_joint", 0.04), ("right_finger_joint", 0.04)];
    assert_agrees_with_k(
        &crate::fixture::mobile_arm(),
        &crate::fixture::path("mobile_arm/mobile_arm.urdf"),
        &fingers,
    );
}

#[test]
fn all_links_of_the_released_panda_are_where_k_puts_them() {
    let Some(data) = crate::fixture::data_folder("forward kinematics of the released Panda") else { return };
    let path = data.join("jogramop/robots/franka_panda/mobile_panda.urdf");
    let options = RobotOptions {
        tip: Some("panda_grasptarget".to_owned()),
        fixed: [("panda_finger_joint1".to_owned(), 0.04)].into(),
        ..RobotOptions::default()
    };
    let robot = Robot::load(&path, &options).expect("the released robot loads");
    let fingers = [("panda_finger_joint1", 0.04), ("panda_finger_joint2", 0.04)];
    assert_agrees_with_k(&robot, &path, &fingers);
    assert_eq!((robot.dof(), robot.links().len()), (9, 16));
}

#[test]
fn mimic_joints_follow_with_factor_and_offset() {
    let robot = crate::fixture::mimic();
    assert_eq!(robot.joint_names(), ["lead", "slide"]);
    let (value, shift) = (0.7, 0.3);
    let frames = robot.frames_at(&[value, shift]);
    // The expected tree is written out by hand with nalgebra.
    let pose = |x, y, z, roll, pitch, yaw| {
        Isometry3::from_parts(Translation3::new(x, y, z), UnitQuaternion::from_euler_angles(roll, pitch, yaw))
    };
    let turn = |axis: Vector3<f64>, angle| {
        Isometry3::from_parts(
            Translation3::identity(),
            UnitQuaternion::from_axis_angle(&Unit::new_normalize(axis), angle),
        )
    };
    let followed = -0.5 * value + 0.25;
    let expected = pose(0.1, 0.2, 0.3, 0.3, -0.4, 0.5)
        * turn(Vector3::new(0.0, 2.0, 1.0), value)
        * pose(0.3, 0.0, 0.1, 0.0, 0.2, 0.0)
        * turn(Vector3::x(), followed)
        * pose(0.0, 0.2, 0.0, 1.0, 0.0, 0.0)
        * Translation3::from(Vector3::new(1.0, 1.0, 0.0).normalize() * shift)
        * pose(0.0, 0.1, 0.2, 0.0, 0.0, 0.0)
        * Translation3::new(0.0, 0.0, -(2.0 * followed + 0.5));
    let actual = frames.link(robot.link_index("e").unwrap());
    assert!((actual.to_homogeneous() - expected.to_homogeneous()).norm() < 1e-12, "{actual} {expected}");
}

#[test]
fn the_path_between_two_links_determines_their_relative_pose() {
    let robot = crate::fixture::mobile_arm();
    let (mut random, links) = (Stream::new(2, 0), robot.links().len());
    for (a, b) in (0..links).flat_map(|a| (0..links).map(move |b| (a, b))) {
        let path = robot.path_between([a, b]);
        let [q, elsewhere] = [0; 2].map(|_| robot.random_configuration(&mut random));
        let whole = robot.frames_at(&q);
        // Other links may be anywhere.
        let mut partial = robot.frames_at(&elsewhere);
        robot.path_kinematics(&path, &q, &mut partial);
        let [expected, relative] =
            [&whole, &partial].map(|frames| frames.link(a).inv_mul(frames.link(b)).to_homogeneous());
        assert!((relative - expected).abs().max() < 1e-12, "{a} {b}");
    }
}
