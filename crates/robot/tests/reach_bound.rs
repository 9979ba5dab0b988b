//! Bound on the reach of a robot, against sampled tip positions.

use cranny_robot::{Robot, RobotOptions};
use cranny_spatial::Point;
use proptest::prelude::*;

/// An arm that turns, slides and turns, on two slides that are not perpendicular.
const ODD: &str = "<robot name='odd'>
<link name='a'/><link name='b'/><link name='c'/><link name='d'/><link name='e'/><link name='f'/><link name='g'/>
<joint name='one' type='prismatic'><origin xyz='0.1 0.2 0.3' rpy='0.4 0.5 0.6'/><parent link='a'/><child link='b'/>
<axis xyz='1 0 0'/><limit lower='-0.5' upper='2' velocity='1' effort='1'/></joint>
<joint name='two' type='prismatic'><origin rpy='1 2 3'/><parent link='b'/><child link='c'/>
<axis xyz='0.6 0.8 0'/><limit lower='0.5' upper='0.7' velocity='1' effort='1'/></joint>
<joint name='three' type='continuous'><origin xyz='0.3 0 0.1' rpy='0.3 0 1'/><parent link='c'/><child link='d'/>
<axis xyz='0 0.6 0.8'/><limit velocity='1' effort='1'/></joint>
<joint name='four' type='prismatic'><origin xyz='0 0.4 0' rpy='1 1 0'/><parent link='d'/><child link='e'/>
<axis xyz='0 0 1'/><limit lower='-0.2' upper='0.9' velocity='1' effort='1'/></joint>
<joint name='five' type='revolute'><origin xyz='0.2 0.1 0.5' rpy='0 1 0'/><parent link='e'/><child link='f'/>
<axis xyz='1 0 0'/><limit lower='-3' upper='1' velocity='1' effort='1'/></joint>
<joint name='six' type='revolute'><origin xyz='0.2 0.1 0.5'/><parent link='f'/><child link='g'/>
<axis xyz='0 1 0'/><limit lower='-3' upper='1' velocity='1' effort='1'/><mimic joint='five' multiplier='-0.5'/></joint>
</robot>";

fn robots() -> Vec<Robot> {
    let odd = Robot::from_urdf_text(ODD, "odd.urdf", None, &RobotOptions::default()).unwrap();
    vec![crate::fixture::mobile_arm(), crate::fixture::mimic(), odd]
}

fn tip_at(robot: &Robot, q: &[f64]) -> Point {
    let frames = robot.frames_at(q);
    Point::from(frames.link(robot.tip()).translation.vector)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn no_tip_is_ever_beyond_the_bound(parts in prop::collection::vec(prop_oneof![0.0..=1.0, Just(0.0), Just(1.0)], 9)) {
        for robot in robots() {
            let tip = tip_at(&robot, &crate::fixture::within_limits(&robot, &parts));
            let bound = robot.reach_bound();
            prop_assert!(bound.beyond_m(&tip) == 0.0, "{}: {} beyond", robot.name(), bound.beyond_m(&tip));
        }
    }
}

#[test]
fn the_bound_of_an_arm_is_near_its_reach() {
    // The expected value is the maximum sampled distance of the tip from the axis of the first joint, with the base fixed.
    let robot = crate::fixture::mobile_arm();
    let bound = robot.reach_bound();
    let mut random = cranny_spatial::Stream::new(3, 0);
    let mut farthest_m: f64 = 0.0;
    for _ in 0..100_000 {
        let parts: Vec<f64> = (0..9).map(|joint| if joint < 2 { 0.5 } else { random.uniform() }).collect();
        let tip = tip_at(&robot, &crate::fixture::within_limits(&robot, &parts));
        farthest_m = farthest_m.max((tip - bound_middle(&robot)).norm());
    }
    let radius_m = bound.radius_m();
    assert!(farthest_m <= radius_m && radius_m < 1.15 * farthest_m, "{farthest_m} of {radius_m}");
}

/// Returns the position of the second joint of the arm, which is the centre of the bound.
fn bound_middle(robot: &Robot) -> Point {
    let frames = robot.frames_at(&[0.0; 9]);
    Point::from(frames.link(robot.joints()[3].child_link).translation.vector)
}

#[test]
fn a_point_outside_is_beyond_by_what_it_is_outside() {
    let robot = crate::fixture::mobile_arm();
    let bound = robot.reach_bound();
    let middle = bound_middle(&robot);
    // The base moves by 1 m to each side in x and y.
    let above = Point::new(middle.x, middle.y, middle.z + bound.radius_m() + 0.25);
    assert!((bound.beyond_m(&above) - 0.25).abs() < 1e-9);
    let beside = Point::new(middle.x + 1.0 + bound.radius_m() + 0.25, middle.y, middle.z);
    assert!((bound.beyond_m(&beside) - 0.25).abs() < 1e-9, "{}", bound.beyond_m(&beside));
    assert!(bound.beyond_m(&Point::new(middle.x + 1.0, middle.y + 1.0, middle.z)) == 0.0);
}
