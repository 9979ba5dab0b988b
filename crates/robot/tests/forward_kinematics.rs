//! Forward kinematics of mimic joints against a tree written out by hand, and of paths between links against whole robots. The
//! tests of the Python package compare every link of the built-in and other robots with Pinocchio.

use cranny_spatial::Stream;
use cranny_spatial::nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3};

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
