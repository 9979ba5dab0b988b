//! Planar and floating joints, represented by chains of joints with one degree of freedom each.

use std::f64::consts::FRAC_PI_2;

use cranny_robot::{CONTINUOUS_LIMIT_RAD, FREE_JOINT_LIMIT_M, JointKind, Robot, RobotOptions, TextSource};
use cranny_spatial::{Pose, Rotation, Vector};
use proptest::prelude::*;

fn urdf(joint: &str) -> String {
    format!(
        r#"<robot name="r"><link name="ground"/><link name="body"/>
<joint name="base" {joint}</joint></robot>"#
    )
}

fn robot(joint: &str, limits: &str) -> Result<Robot, String> {
    let limits = TextSource::Text { name: "limits.yaml".to_owned(), text: limits.to_owned() };
    let options = RobotOptions { limits: Some(limits), ..RobotOptions::default() };
    Robot::from_urdf_text(&urdf(joint), "r.urdf", None, &options).map_err(|fault| fault.to_string())
}

const ENDS: &str = r#"<parent link="ground"/><child link="body"/>"#;

const SPEEDS: &str = "joints: {base/x: {velocity: 1}, base/y: {velocity: 1}, base/z: {velocity: 1}, base/yaw: \
                      {velocity: 1}, base/pitch: {velocity: 1}, base/roll: {velocity: 1}}";

#[test]
fn a_planar_joint_has_the_limits_that_are_said() {
    let said = r#"<limit lower="-3" upper="2.5" velocity="0.5" effort="1"/>"#;
    let planar = robot(&format!(r#"type="planar">{ENDS}{said}"#), "joints: {}").unwrap();
    assert_eq!(planar.joint_names(), ["base/x", "base/y", "base/theta"]);
    let ranges: Vec<_> = planar.limits().iter().map(|limits| (limits.lower, limits.upper)).collect();
    let turn = CONTINUOUS_LIMIT_RAD;
    assert_eq!(ranges, [(-3.0, 2.5), (-3.0, 2.5), (-turn, turn)]);
    assert!(planar.limits().iter().all(|limits| (limits.velocity - 0.5).abs() < 1e-12));
    let silent = robot(
        &format!(r#"type="planar">{ENDS}"#),
        "joints: {base/x: {velocity: 1, lower: -1, upper: 0.5}, base/y: {velocity: 1}, base/theta: {velocity: 1}}",
    )
    .unwrap();
    let reach = FREE_JOINT_LIMIT_M;
    assert_eq!((silent.limits()[0].lower, silent.limits()[0].upper), (-1.0, 0.5));
    assert_eq!((silent.limits()[1].lower, silent.limits()[1].upper), (-reach, reach));
}

#[test]
fn what_limits_cannot_say_is_refused_with_its_line() {
    let joint = &format!(r#"type="planar">{ENDS}"#);
    for (limits, said) in [
        ("joints:\n  base/x: {velocity: 1}", "base/y` is to be moved, but has no velocity limit"),
        ("joints:\n  base/x: {lower: -3}", "limits.yaml:2: lower of joint `base/x` is -3"),
        ("joints:\n  base/x: {upper: .nan}", "limits.yaml:2: upper of joint `base/x`"),
        ("joints:\n  base/x: {lower: 1, upper: 0}", "lower limit 1 is greater than upper limit 0"),
        ("joints:\n  base/x: {velocity: 0}", "velocity of joint `base/x` must be greater than 0"),
        ("joints:\n  base: {velocity: 1}", "unknown joint `base`"),
    ] {
        let fault = robot(joint, limits).unwrap_err();
        assert!(fault.contains(said), "{fault}");
    }
}

proptest! {
    #[test]
    fn a_planar_joint_moves_in_its_plane(
        x in -2.0..2.0, y in -2.0..2.0, theta in -9.0..9.0, nx in -1.0..1.0, ny in -1.0..1.0, nz in -1.0..1.0
    ) {
        prop_assume!(f64::hypot(nx, ny).hypot(nz) > 0.1);
        let planar = robot(
            &format!(r#"type="planar">{ENDS}<origin xyz="1 2 3" rpy="0.1 0.2 0.3"/><axis xyz="{nx} {ny} {nz}"/>
                     <limit lower="-2" upper="2" velocity="1" effort="1"/>"#),
            "joints: {}",
        ).unwrap();
        let at_zero = planar.frames_at(&[0.0; 3]);
        let moved = planar.frames_at(&[x, y, theta]);
        let body = |frames: &cranny_robot::LinkFrames| *frames.link(planar.link_index("body").unwrap());
        let between = body(&at_zero).inv_mul(&body(&moved));
        let normal = Vector::new(nx, ny, nz).normalize();
        prop_assert!(between.translation.vector.dot(&normal).abs() < 1e-12);
        prop_assert!((between.translation.vector.norm() - x.hypot(y)).abs() < 1e-12);
        prop_assert!(((between.rotation * normal) - normal).norm() < 1e-12);
    }

    #[test]
    fn a_floating_joint_goes_anywhere(
        place in prop::array::uniform3(-2.0..2.0), yaw in -3.0..3.0, pitch in -1.5..1.5, roll in -3.0..3.0
    ) {
        let floating = robot(&format!(r#"type="floating">{ENDS}"#), SPEEDS).unwrap();
        let [x, y, z] = place;
        let frames = floating.frames_at(&[x, y, z, yaw, pitch, roll]);
        let expected =
            Pose::from_parts(Vector::from(place).into(), Rotation::from_euler_angles(roll, pitch, yaw));
        let between = expected.inv_mul(frames.link(floating.tip()));
        prop_assert!(between.translation.vector.norm() < 1e-12 && between.rotation.angle() < 1e-7);
    }
}

#[test]
fn a_floating_joint_stays_off_where_yaw_and_roll_are_one() {
    let floating = robot(&format!(r#"type="floating">{ENDS}"#), SPEEDS).unwrap();
    assert!((floating.limits()[4].upper - FRAC_PI_2).abs() < 1e-12);
    let kinds: Vec<_> = floating.joints().iter().map(|joint| joint.kind).collect();
    assert_eq!(kinds[..3], [JointKind::Prismatic; 3]);
    assert_eq!(kinds[3..], [JointKind::Revolute; 3]);
}

/// Covers files for other programs, whose attributes have undeclared namespaces.
#[test]
fn a_prefix_that_nobody_declares_is_read_over() {
    let text = urdf(&format!(
        r#"type="revolute">{ENDS}<limit drake:acceleration="2" lower="-1" upper="1" velocity="1" effort="1"/>
        <drake:rotor_inertia value="1"/>"#
    ));
    let robot = Robot::from_urdf_text(&text, "r.urdf", None, &RobotOptions::default()).unwrap();
    assert_eq!(robot.dof(), 1);
    let fault =
        Robot::from_urdf_text(&text.replace("drake:", "xacro:"), "r.urdf", None, &RobotOptions::default());
    assert!(fault.unwrap_err().to_string().contains("xacro"));
}
