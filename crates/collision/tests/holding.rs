//! Tests that a cell with a held object agrees with a robot that was built with the object in its hand.

use std::sync::Arc;

use cranny_collision::{Body, Cell, CollisionError, Extent, Margins, World};
use cranny_robot::{HandDescription, Hold, Robot, RobotDescription, RobotOptions};
use cranny_shape::Solid;
use cranny_spatial::{Pose, Stream, Vector};
use proptest::prelude::*;

const THING: [f64; 3] = [0.06, 0.03, 0.12];
const MARGINS: Margins =
    Margins { margin_m: 0.004, grasp_margin_m: 0.001, object_margin_m: 0.0, tilt_rad: None };

/// Returns an arm with two sliding fingers (`finger`: the URDF of the left one with +, of the right one with −), and `carried`.
fn arm(finger: &dyn Fn(f64) -> String, carried: &str) -> String {
    format!(
        r#"<robot name="arm">
  <link name="rail"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
  <link name="cart"><collision><origin xyz="0 0 0.1"/><geometry><box size="0.2 0.1 0.04"/></geometry></collision></link>
  <link name="upper"><collision><origin xyz="0 0 0.18"/><geometry><capsule radius="0.03" length="0.36"/></geometry></collision></link>
  <link name="lower"><collision><origin xyz="0 0 0.15"/><geometry><cylinder radius="0.03" length="0.3"/></geometry></collision></link>
  <link name="wrist"><collision><geometry><sphere radius="0.04"/></geometry></collision></link>
  <link name="palm"><collision><origin xyz="0 0 0.05"/><geometry><box size="0.04 0.16 0.04"/></geometry></collision></link>
  <link name="left"><collision><origin xyz="0 0 0.12"/><geometry><box size="0.02 0.01 0.08"/></geometry></collision></link>
  <link name="right"><collision><origin xyz="0 0 0.12"/><geometry><box size="0.02 0.01 0.08"/></geometry></collision></link>
  <joint name="slide" type="prismatic"><parent link="rail"/><child link="cart"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
  <joint name="turn" type="revolute"><parent link="cart"/><child link="upper"/><origin xyz="0 0 0.2"/>
    <axis xyz="0 0.6 0.8"/><limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0 0 0.45" rpy="0.3 0 0"/>
    <axis xyz="1 0 0"/><limit lower="-2.8" upper="2.8" velocity="1" effort="1"/></joint>
  <joint name="bend" type="revolute"><parent link="lower"/><child link="wrist"/><origin xyz="0 0 0.4"/>
    <axis xyz="0 1 0"/><limit lower="-2.9" upper="2.9" velocity="1" effort="1"/></joint>
  <joint name="to_palm" type="fixed"><parent link="wrist"/><child link="palm"/></joint>
  {left}{right}{carried}
</robot>"#,
        left = finger(1.0),
        right = finger(-1.0),
    )
}

fn open(urdf: &str, hand: Option<HandDescription>) -> Arc<Robot> {
    let options = RobotOptions {
        tip: Some("palm".to_owned()),
        known_hands: hand.into_iter().collect(),
        ..Default::default()
    };
    Arc::new(Robot::from_urdf_text(urdf, "arm.urdf", None, &options).unwrap())
}

/// Builds the arm with fingers that slide from 7 cm off the centre to it.
fn sliding() -> Arc<Robot> {
    let finger = |side: f64| {
        let name = if side > 0.0 { "left" } else { "right" };
        format!(
            r#"<joint name="to_{name}" type="prismatic"><parent link="palm"/><child link="{name}"/><origin xyz="0 0 0"/>
               <axis xyz="0 {side} 0"/><limit lower="0" upper="0.07" velocity="1" effort="1"/></joint>"#
        )
    };
    let description = RobotDescription::parse(
        "hand: {name: pair, tip: palm, opening_m: 0.13, finger_depth_m: 0.08, closing_force_n: 40, fingers: \
         {to_left: {open: 0.07, closed: 0.0}, to_right: {open: 0.07, closed: 0.0}}}",
        "robot.yaml",
    );
    open(&arm(&finger, ""), description.unwrap().hand)
}

/// Builds the arm with fixed fingers and the object fixed to the palm.
fn built(place: [f64; 3], turn: [f64; 3], closing: f64) -> Arc<Robot> {
    let finger = |side: f64| {
        let name = if side > 0.0 { "left" } else { "right" };
        let y = side * 0.07 * (1.0 - closing);
        format!(
            r#"<joint name="to_{name}" type="fixed"><parent link="palm"/><child link="{name}"/><origin xyz="0 {y} 0"/></joint>"#
        )
    };
    let ([x, y, z], [roll, pitch, yaw], [a, b, c]) = (place, turn, THING);
    let carried = format!(
        r#"<link name="thing"><collision><geometry><box size="{a} {b} {c}"/></geometry></collision></link>
           <joint name="to_thing" type="fixed"><parent link="palm"/><child link="thing"/>
           <origin xyz="{x} {y} {z}" rpy="{roll} {pitch} {yaw}"/></joint>"#
    );
    open(&arm(&finger, &carried), None)
}

fn hold(place: [f64; 3], [roll, pitch, yaw]: [f64; 3], closing: f64) -> Hold {
    let turn = cranny_spatial::Rotation::from_euler_angles(roll, pitch, yaw);
    Hold { tip_from_held: Pose::from_parts(Vector::from(place).into(), turn), closing }
}

/// Scatters boxes around the robot on a floor, and puts the object on the floor.
fn world(random: &mut Stream) -> Vec<Body> {
    let mut bodies = vec![Body::floor(-0.3)];
    for index in 0..8 {
        let mut draw = |low: f64, high: f64| random.uniform_between(low, high);
        let size = Vector::new(draw(0.02, 0.3), draw(0.02, 0.2), draw(0.02, 0.2));
        let place = Vector::new(draw(-1.2, 1.2), draw(-1.0, 1.0), draw(-0.2, 1.4));
        let pose = Pose::new(place, Vector::new(draw(-3.0, 3.0), draw(-3.0, 3.0), 0.0));
        bodies.push(Body::new(format!("box {index}"), pose, Solid::cuboid(size).unwrap()));
    }
    bodies
}

fn thing() -> Body {
    let [a, b, c] = THING;
    let solid = Solid::cuboid(0.5 * Vector::new(a, b, c)).unwrap();
    // An obstacle there would block most motions.
    Body::new("thing", Pose::translation(0.0, 0.0, 0.5), solid)
}

fn configurations(cell: &Cell, random: &mut Stream, count: usize) -> Vec<Vec<f64>> {
    let mut scratch = cell.scratch();
    let mut all = Vec::new();
    while all.len() < count {
        let mut ends = [(); 2].map(|()| cell.robot().random_configuration(random));
        all.push(ends[0].clone());
        let free = ends.each_ref().map(|q: &Vec<f64>| cell.is_free(q, &mut scratch));
        if free[0] == free[1] {
            continue;
        }
        for _ in 0..24 {
            let middle: Vec<f64> = cranny_robot::between(&ends[0], &ends[1], 0.5).collect();
            let is_free = cell.is_free(&middle, &mut scratch);
            ends[usize::from(is_free != free[0])] = middle;
        }
        all.extend(ends);
    }
    all
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn holding_is_like_being_built_so(
        seed in any::<u64>(),
        places in prop::array::uniform2(prop::array::uniform3(-0.15..0.15)),
        turns in prop::array::uniform2(prop::array::uniform3(-3.0..3.0)),
        closings in prop::array::uniform2(0.0..1.0),
    ) {
        let mut random = Stream::new(seed, 0);
        let around = world(&mut random);
        let with_thing = World::new(around.iter().cloned().chain([thing()]).collect()).unwrap();
        let empty = Cell::for_grasp(sliding(), with_thing, around.len(), MARGINS).unwrap();
        let first = empty.holding(around.len(), hold(places[0], turns[0], closings[0])).unwrap();
        let second = first.with_hold(hold(places[1], turns[1], closings[1])).unwrap();
        for (cell, index) in [(first, 0), (second, 1)] {
            let robot = built(places[index], turns[index], closings[index]);
            let expected = Cell::new(robot, World::new(around.clone()).unwrap(), MARGINS).unwrap();
            let configurations = configurations(&cell, &mut random, 300);
            let (mut scratch, mut other) = (cell.scratch(), expected.scratch());
            let mut verdicts = Vec::new();
            cell.are_free(&configurations.concat(), &mut scratch, &mut verdicts);
            for (q, lanes) in configurations.iter().zip(&verdicts) {
                prop_assert_eq!(cell.is_clear(q, &mut scratch), *lanes, "the law of the lanes at {:?}", q);
                let [own, theirs] = [cell.clearance(q, &mut scratch), expected.clearance(q, &mut other)];
                prop_assert!((own - theirs).abs() < 1e-7, "{own} and {theirs} at {q:?}");
            }
            for ends in configurations.chunks(2).take(60) {
                let [a, b] = ends else { break };
                let b: Vec<f64> = cranny_robot::between(a, b, 0.1).collect();
                let proofs = [cell.motion_is_free(a, &b, &mut scratch), expected.motion_is_free(a, &b, &mut other)];
                prop_assert_eq!(proofs[0].is_proven(), proofs[1].is_proven(), "{:?}", proofs);
            }
        }
    }
}

#[test]
fn what_is_held_is_named_and_what_it_is_spared_is_not_met() {
    let around = [Body::floor(-0.3)];
    let bodies = World::new(around.iter().cloned().chain([thing()]).collect()).unwrap();
    let empty = Cell::for_grasp(sliding(), bodies, 1, MARGINS).unwrap();
    let long = hold([0.0, 0.0, 0.5], [0.0; 3], 0.5);
    let held = empty.holding(1, long).unwrap();
    let (mut random, mut scratch) = (Stream::new(3, 0), held.scratch());
    // Here only the object is in collision with the floor.
    let names = |q: &[f64], scratch: &mut cranny_collision::Scratch| {
        let named = |contact: &cranny_collision::Contact| {
            [contact.first, contact.second].map(|thing| held.name(thing).to_owned())
        };
        held.contacts(q, scratch).iter().map(named).collect::<Vec<_>>()
    };
    let q = std::iter::repeat_with(|| -> Vec<f64> { held.robot().random_configuration(&mut random) })
        .take(100_000)
        .find(|q| names(q, &mut scratch) == [["thing", "floor"]])
        .unwrap();
    // The object rests on the floor.
    let on_floor = Pose::translation(0.0, 0.0, -0.3 + 0.5 * THING[2]);
    let spared = held.with_allowed_contacts(&held.resting_at(1, &Extent::of(&thing()).unwrap(), &on_floor));
    assert!(spared.is_free(&q, &mut spared.scratch()));
    let shorter = held.with_hold(hold([0.0, 0.0, 0.1], [0.0; 3], 0.5)).unwrap();
    assert!(shorter.is_free(&q, &mut shorter.scratch()));
    assert!(!held.is_free(&q, &mut scratch));
}

#[test]
fn what_cannot_be_held_is_refused() {
    let bodies = World::new(vec![Body::floor(-0.3), thing()]).unwrap();
    let empty = Cell::new(sliding(), bodies, MARGINS).unwrap();
    let good = hold([0.0; 3], [0.0; 3], 0.5);
    let held = empty.holding(1, good).unwrap();
    let far = hold([3.0, 0.0, 0.0], [0.0; 3], 0.5);
    let refused = [
        empty.holding(0, good),
        empty.holding(1, far),
        empty.holding(1, Hold { closing: 1.5, ..good }),
        empty.holding(1, Hold { closing: f64::NAN, ..good }),
        held.holding(1, good),
        held.with_hold(far),
    ];
    for cell in refused {
        assert!(matches!(cell, Err(CollisionError::Hold { .. })));
    }
}
