//! Hands with linkages: joints that mimic the closing joint, one mounted on the other.

use std::fmt::Write as _;

use cranny_robot::{Hold, Robot, RobotOptions, TextSource};
use cranny_spatial::{Point, Pose, Vector};
use proptest::prelude::*;

/// Returns two fingers on parallelograms: the outer bar turns by q, the finger on it back by q; an inner bar turns along.
fn hand() -> Robot {
    hand_with(&RobotOptions::default())
}

fn hand_with(options: &RobotOptions) -> Robot {
    let mut urdf = String::from(
        "<robot name='h'><link name='base'/><link name='palm'/><link name='between'/>\
         <joint name='turn' type='revolute'><parent link='base'/><child link='palm'/><axis xyz='0 0 1'/>\
         <limit lower='-1' upper='1' velocity='1' effort='1'/></joint>\
         <joint name='frame' type='fixed'><parent link='palm'/><child link='between'/><origin xyz='0 0 0.12'/></joint>",
    );
    for (side, sign) in [("left", 1.0), ("right", -1.0)] {
        let mimic = |factor: f64| match (side, factor > 0.0) {
            ("left", true) => String::new(),
            _ => format!("<mimic joint='left_bar' multiplier='{factor}'/>"),
        };
        for (name, parent, place, factor, size) in [
            ("bar", "palm".to_owned(), [0.0, 0.03 * sign, 0.06], 1.0, "0.01 0.01 0.04"),
            ("finger", format!("{side}_bar"), [0.0, 0.03 * sign, 0.04], -1.0, "0.02 0.005 0.04"),
            ("inner", "palm".to_owned(), [0.0, 0.012 * sign, 0.065], 1.0, "0.01 0.004 0.03"),
        ] {
            let [x, y, z] = place;
            let mimic = if name == "inner" {
                "<mimic joint='left_bar' multiplier='1'/>".to_owned()
            } else {
                mimic(factor)
            };
            let _ = write!(
                urdf,
                "<link name='{side}_{name}'><collision><origin xyz='0 0 0.015'/><geometry><box size='{size}'/></geometry>\
                 </collision></link><joint name='{side}_{name}' type='revolute'><parent link='{parent}'/>\
                 <child link='{side}_{name}'/><origin xyz='{x} {y} {z}'/><axis xyz='{sign} 0 0'/>\
                 <limit lower='-1' upper='1' velocity='1' effort='1'/>{mimic}</joint>"
            );
        }
    }
    let description = "hand: {name: h, tip: between, fingers: {left_bar: {open: 0, closed: 0.7}}, opening_m: 0.115, \
                       finger_depth_m: 0.05, closing_force_n: 40}";
    let description = TextSource::Text { name: "robot.yaml".to_owned(), text: description.to_owned() };
    let options = RobotOptions { description: Some(description), ..options.clone() };
    Robot::from_urdf_text(&(urdf + "</robot>"), "h.urdf", None, &options).unwrap()
}

fn at(robot: &Robot, closing: f64) -> Vec<Pose> {
    let holding = robot.holding("thing");
    let mut frames = holding.frames();
    holding.place_held(&Hold { tip_from_held: Pose::identity(), closing }, &mut frames);
    holding.forward_kinematics(&[0.3], &mut frames);
    (0..holding.links().len()).map(|link| *frames.link(link)).collect()
}

#[test]
fn all_that_follows_the_driving_joint_closes_with_it() {
    let robot = hand();
    let known = robot.hand().unwrap();
    assert_eq!((known.joints.len(), known.fingers), (6, 2));
    assert_eq!(robot.joint_names(), ["turn"]);
    let finger = |name: &str| robot.finger_of(robot.link_index(name).unwrap());
    assert_eq!(finger("left_finger"), finger("left_inner"));
    assert_ne!(finger("left_finger"), finger("right_finger"));
    assert_eq!(finger("palm"), None);
    let link = |name: &str| robot.link_index(name).unwrap();
    let gap = |poses: &[Pose]| {
        (poses[link("left_finger")].translation.vector - poses[link("right_finger")].translation.vector)
            .norm()
    };
    let (open, closed) = (at(&robot, 0.0), at(&robot, 1.0));
    assert!(gap(&closed) < gap(&open) - 0.02, "{} {}", gap(&open), gap(&closed));
    // The pads stay parallel.
    for closing in [0.0, 0.3, 1.0] {
        let poses = at(&robot, closing);
        let turned = poses[link("left_finger")].rotation.angle_to(&poses[link("palm")].rotation);
        assert!(turned < 1e-9, "{turned}");
    }
}

/// Compares with a robot whose joint is fixed at that value and whose hand is empty.
#[test]
fn a_hand_that_holds_stands_as_its_joints_do() {
    let robot = hand();
    for closing in [0.0, 0.25, 0.8] {
        let fixed = [("left_bar".to_owned(), 0.7 * closing)].into();
        let options = RobotOptions { fixed, ..RobotOptions::default() };
        let expected = hand_with(&options);
        for (link, pose) in at(&robot, closing).iter().enumerate().take(expected.links().len()) {
            let between = expected.frames_at(&[0.3]).link(link).inv_mul(pose);
            assert!(between.translation.vector.norm() < 1e-12 && between.rotation.angle() < 1e-7, "{link}");
        }
    }
}

proptest! {
    /// Checks that `closing_motion_bound_m` bounds the motion of any point.
    #[test]
    fn no_point_of_a_finger_goes_farther_than_the_bound(
        from in 0.0..1.0, to in 0.0..1.0, x in -0.02..0.02, y in -0.02..0.02, z in -0.02..0.04
    ) {
        let robot = hand();
        let (low, high) = (at(&robot, from), at(&robot, to));
        let point = Point::new(x, y, z);
        for name in ["left_bar", "left_finger", "left_inner", "right_finger"] {
            let link = robot.link_index(name).unwrap();
            let way_m = robot.closing_motion_bound_m(link, (Point::origin(), Vector::new(x, y, z).norm()));
            let gone_m = (low[link] * point - high[link] * point).norm();
            prop_assert!(gone_m <= way_m * f64::abs(to - from) + 1e-12, "{name}: {gone_m} {way_m}");
        }
        prop_assert!(robot.closing_motion_bound_m(robot.tip(), (Point::origin(), 1.0)) <= 0.0);
    }
}
