//! Tests of the pairs of links that are checked against each other.

use std::fmt::Write as _;

use crate::fixture::{FOLDED, arm, cell, robot};
use cranny_collision::{Cell, Collider, ExemptPair, UncheckedReason};
use cranny_robot::{JointGroup, RobotOptions, TextSource};

/// Creates a base with a bare hub that carries two arms; the left one has a forearm of the given radius (m).
fn two_arms(forearm_radius_m: f64, srdf: &str) -> Cell {
    let urdf = format!(
        r#"<robot name="two_arms">
  <link name="base"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
  <link name="hub"/>
  <link name="left"><collision><origin xyz="0 0 0.2"/>
    <geometry><sphere radius="0.05"/></geometry></collision></link>
  <link name="right"><collision><origin xyz="0 0 0.2"/>
    <geometry><sphere radius="0.05"/></geometry></collision></link>
  <link name="forearm"><collision><origin xyz="0 0 0.2"/>
    <geometry><sphere radius="{forearm_radius_m}"/></geometry></collision></link>
  <joint name="post" type="fixed"><parent link="base"/><child link="hub"/><origin xyz="0 0 0.2"/></joint>
  <joint name="l" type="revolute"><parent link="hub"/><child link="left"/><axis xyz="1 0 0"/>
    <limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
  <joint name="r" type="revolute"><parent link="hub"/><child link="right"/><axis xyz="1 0 0"/>
    <limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
  <joint name="f" type="revolute"><parent link="left"/><child link="forearm"/><origin xyz="0 0 0.3"/>
    <axis xyz="1 0 0"/><limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
</robot>"#
    );
    let options = RobotOptions {
        group: JointGroup::Joints(["l", "f", "r"].map(str::to_owned).to_vec()),
        srdf: Some(TextSource::Text { name: "test.srdf".to_owned(), text: srdf.to_owned() }),
        ..RobotOptions::default()
    };
    cell(&robot(&urdf, &options), Vec::new(), 0.0)
}

/// The upper arms turn about one axis, where they pass through each other.
const UPPER_ARMS_PASS: &str =
    r#"<robot name="two_arms"><disable_collisions link1="left" link2="right"/></robot>"#;

fn names(cell: &Cell) -> Vec<[&str; 2]> {
    let mut names: Vec<[&str; 2]> = cell
        .self_pairs()
        .into_iter()
        .map(|(a, b)| {
            let mut pair = [a, b].map(|link| cell.name(Collider::Link(link)));
            pair.sort_unstable();
            pair
        })
        .collect();
    names.sort_unstable();
    names
}

/// Two arms on a hub are moved relative to each other by two joints, so they are checked.
#[test]
fn neighbours_over_a_bare_hub_are_checked_where_they_can_touch_and_arms_on_it_always_are() {
    let cell = two_arms(0.05, r#"<robot name="two_arms"/>"#);
    // The upper arms swing down into the base; the forearm never meets the upper arm.
    let expected =
        [["base", "forearm"], ["base", "left"], ["base", "right"], ["forearm", "right"], ["left", "right"]];
    assert_eq!(names(&cell), expected);
    let adjacent =
        cell.unchecked().iter().map(|pair| (cell.name(pair.first), cell.name(pair.second), pair.reason));
    assert_eq!(adjacent.collect::<Vec<_>>(), [("left", "forearm", UncheckedReason::AdjacentFree)]);
    assert!(!cell.is_free(&[3.0, 0.0, 0.0], &mut cell.scratch()));
}

#[test]
fn a_pair_that_the_srdf_disables_is_left_out() {
    let srdf = r#"<robot name="two_arms"><disable_collisions link1="forearm" link2="right"/></robot>"#;
    let expected = [["base", "forearm"], ["base", "left"], ["base", "right"], ["left", "right"]];
    assert_eq!(names(&two_arms(0.05, srdf)), expected);
}

#[test]
fn pairs_that_are_always_in_contact_are_left_out_and_named() {
    // The forearm is attached at most 0.5 m from the hub, so that it always reaches base, right arm and left arm.
    let cell = two_arms(1.0, UPPER_ARMS_PASS);
    assert_eq!(names(&cell), [["base", "left"], ["base", "right"]]);
    let named = |reason| -> Vec<_> {
        let pairs = cell.unchecked().iter().filter(|pair| pair.reason == reason && pair.depth_m > 0.3);
        pairs.map(|pair| [pair.first, pair.second].map(|c| cell.name(c))).collect()
    };
    assert_eq!(named(UncheckedReason::AlwaysTouching), [["base", "forearm"], ["forearm", "right"]]);
    assert_eq!(named(UncheckedReason::AdjacentTouching), [["left", "forearm"]]);
}

#[test]
fn a_pair_that_was_left_out_is_checked_where_that_is_asked_for() {
    let cell = two_arms(1.0, UPPER_ARMS_PASS);
    let mut scratch = cell.scratch();
    let q = [0.0, 0.0, 0.0];
    assert!(cell.is_free(&q, &mut scratch));
    let strict = cell.with_all_pairs();
    assert_eq!(
        names(&strict),
        [["base", "forearm"], ["base", "left"], ["base", "right"], ["forearm", "right"]]
    );
    // A pair that touches at its joint at every value is listed.
    assert!(unchecked(&strict).iter().all(|pair| pair.reason == UncheckedReason::AdjacentTouching));
    assert!(!strict.is_free(&q, &mut strict.scratch()));
}

/// Checks a slot that random samples almost never hit: one configuration of some ten thousand is free.
#[test]
fn a_pair_that_is_free_in_a_slot_is_checked_from_the_start() {
    let urdf = r#"<robot name="slot"><link name="root"/>
  <link name="base">
    <collision><origin xyz="1 0 0"/><geometry><box size="1.8 3 0.2"/></geometry></collision>
    <collision><origin xyz="-1 1.0003 0"/><geometry><box size="3 2 0.2"/></geometry></collision>
    <collision><origin xyz="-1 -1.0003 0"/><geometry><box size="3 2 0.2"/></geometry></collision></link>
  <link name="between"><collision><origin xyz="0 0 0.5"/><geometry><sphere radius="0.01"/></geometry></collision></link>
  <link name="blade"><collision><origin xyz="-0.4 0 0"/><geometry><box size="0.7 0.0002 0.05"/></geometry></collision></link>
  <joint name="slide" type="prismatic"><parent link="root"/><child link="base"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
  <joint name="post" type="fixed"><parent link="base"/><child link="between"/></joint>
  <joint name="turn" type="revolute"><parent link="between"/><child link="blade"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" velocity="1" effort="1"/></joint></robot>"#;
    let cell = cell(&robot(urdf, &RobotOptions::default()), Vec::new(), 0.0);
    assert!(unchecked(&cell).is_empty());
    let (free, touching) = ([0.0, 0.0], [0.0, 1.0]);
    let mut scratch = cell.scratch();
    assert!(cell.is_free(&free, &mut scratch) && !cell.is_free(&touching, &mut scratch));
    assert!(!cell.motion_is_free(&free, &touching, &mut scratch).is_proven());
}

/// Creates a fin that turns in a ring of blocks, with one window of the given fraction of a turn between them; a ball between
/// fin and ring keeps them from being adjacent.
fn ring(window: f64, is_adjacent: bool) -> Cell {
    const BLOCKS: u32 = 400;
    let turn = std::f64::consts::TAU;
    // The fin's corners take 1 mm on either side of it, the corners of the blocks less.
    let open_rad = window * turn + 2.0 * 0.001 / 0.3;
    let mut blocks = String::new();
    for block in 0..BLOCKS {
        let angle = 1.0 + 0.5 * open_rad + (turn - open_rad) * (f64::from(block) + 0.5) / f64::from(BLOCKS);
        let (x, y) = (0.3 * angle.cos(), 0.3 * angle.sin());
        let width = 0.3 * (turn - open_rad) / f64::from(BLOCKS);
        let _ = write!(
            blocks,
            r#"<collision><origin xyz="{x} {y} 0" rpy="0 0 {angle}"/><geometry><box size="0.02 {width} 0.02"/></geometry></collision>"#
        );
    }
    let ball = r#"<collision><geometry><sphere radius="0.01"/></geometry></collision>"#;
    let ball = if is_adjacent { "" } else { ball };
    let urdf = format!(
        r#"<robot name="ring"><link name="ring">{blocks}</link><link name="hub">{ball}</link>
  <link name="fin"><collision><origin xyz="0.3 0 0"/><geometry><box size="0.05 0.002 0.01"/></geometry></collision></link>
  <joint name="post" type="fixed"><parent link="ring"/><child link="hub"/></joint>
  <joint name="turn" type="revolute"><parent link="hub"/><child link="fin"/><axis xyz="0 0 1"/>
    <limit lower="-3.1" upper="3.1" velocity="1" effort="1"/></joint></robot>"#
    );
    cell(&robot(&urdf, &RobotOptions::default()), Vec::new(), 0.0)
}

#[test]
fn links_that_are_free_in_a_window_of_their_joint_alone_are_checked() {
    for is_adjacent in [false, true] {
        for window in [0.05, 0.01, 0.005] {
            let cell = ring(window, is_adjacent);
            assert!(names(&cell).contains(&["fin", "ring"]), "{window} {is_adjacent} {:?}", cell.unchecked());
            let mut scratch = cell.scratch();
            assert!(cell.is_free(&[1.0], &mut scratch) && !cell.is_free(&[0.5], &mut scratch));
        }
        let closed = ring(-2.0 * 0.001 / 0.3 / std::f64::consts::TAU, is_adjacent);
        let is_named = !unchecked(&closed).is_empty();
        assert_eq!(is_named, !names(&closed).contains(&["fin", "ring"]));
    }
}

/// Creates a base with a hub at the axis of a turning arm, which the arm touches deeply at some angles, and a pin far from it.
fn sweeper(pin: &str, arm: &str) -> Cell {
    let urdf = format!(
        r#"<robot name="sweeper"><link name="base"><collision><origin xyz="0.03 0 0"/><geometry>
  <box size="0.03 0.03 0.04"/></geometry></collision>{pin}</link><link name="arm">{arm}</link>
  <joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
  <limit lower="-2" upper="2" velocity="1" effort="1"/></joint></robot>"#
    );
    cell(&robot(&urdf, &RobotOptions::default()), Vec::new(), 0.0)
}

#[test]
fn a_deep_contact_at_a_joint_hides_none_far_from_it() {
    let collision = |at: &str, size: &str| {
        format!(r#"<collision><origin {at}/><geometry><box size="{size}"/></geometry></collision>"#)
    };
    let thick = collision(r#"xyz="0.25 0 0""#, "0.46 0.02 0.02");
    // The pin is thinner than the spacing of samples, and between two sampled angles.
    let thin =
        collision(r#"xyz="0.02 0 0""#, "0.05 0.02 0.02") + &collision(r#"xyz="0.25 0 0""#, "0.46 0.001 0.02");
    let post = collision(r#"xyz="0.40 0 0""#, "0.006 0.006 0.04");
    let blade = collision(r#"xyz="0.449996 0.001767 0" rpy="0 0 0.003926""#, "0.02 0.001 0.04");
    for (pin, arm) in [(&post, &thick), (&blade, &thin)] {
        let with_pin = sweeper(pin, arm);
        assert_eq!(names(&with_pin), [["arm", "base"]]);
        let without = sweeper("", arm);
        assert!(names(&without).is_empty());
        let [at_joint] = without.unchecked() else { panic!("one pair") };
        assert!(at_joint.reason == UncheckedReason::AdjacentAtJoint && at_joint.depth_m > 0.0);
    }
}

/// Returns the pairs that an answer lists as exceptions.
fn unchecked(cell: &Cell) -> Vec<ExemptPair> {
    let exceptions = cell.unchecked().iter().filter(|pair| pair.reason != UncheckedReason::AdjacentFree);
    exceptions.copied().collect()
}

/// A fixed base in contact with a body cannot be freed by planning, so the pair is listed.
#[test]
fn a_link_that_stands_still_in_a_body_is_named() {
    let robot = arm();
    let bodies = vec![
        crate::fixture::block("table", [0.0, 0.0, 0.0], [0.5; 3]),
        crate::fixture::block("far", [9.0; 3], [0.1; 3]),
    ];
    let cell = cell(&robot, bodies, 0.0);
    let still = robot.ancestors(0).is_empty() && !robot.links()[0].collisions.is_empty();
    let named = cell.unchecked().iter().filter(|pair| pair.reason == UncheckedReason::NeverMoves);
    let named: Vec<_> = named.map(|u| (cell.name(u.first), cell.name(u.second), u.depth_m > 0.0)).collect();
    assert_eq!(named, if still { vec![("rail", "table", true)] } else { vec![] });
}

#[test]
fn links_that_no_joint_moves_against_each_other_are_left_out() {
    let robot = arm();
    let cell = cell(&robot, Vec::new(), 0.0);
    let hand = crate::fixture::hand(&robot);
    assert!(cell.self_pairs().iter().all(|(a, b)| !(hand.contains(a) && hand.contains(b))));
    assert!(names(&cell).contains(&["left_finger", "lower"]));
}

#[test]
fn an_arm_that_is_folded_onto_itself_is_not_free() {
    let cell = cell(&arm(), Vec::new(), 0.0);
    let mut scratch = cell.scratch();
    assert!(cell.is_free(&[0.0; 4], &mut scratch));
    assert!(cell.clearance(&[0.0; 4], &mut scratch) > 0.0);
    assert!(!cell.is_free(&FOLDED, &mut scratch));
    assert!(cell.clearance(&FOLDED, &mut scratch) <= 0.0);
    let contacts = cell.contacts(&FOLDED, &mut scratch);
    let touching = |a: &str, b: &str| {
        contacts.iter().any(|contact| {
            let names = [cell.name(contact.first), cell.name(contact.second)];
            names.contains(&a) && names.contains(&b) && contact.depth_m > 0.0
        })
    };
    assert!(touching("palm", "upper"), "{contacts:?}");
    assert!(!touching("lower", "upper"));
}

#[test]
fn two_arms_that_meet_touch_as_deep_wherever_they_meet() {
    let cell = two_arms(0.08, UPPER_ARMS_PASS);
    let mut scratch = cell.scratch();
    // In the plane of the left arm the right ball is 0.2 m out, the folded forearm 0.2 m back from 0.3 m.
    let (back, aside) = (0.2 * 3.0_f64.cos(), 0.2 * 3.0_f64.sin());
    let expected_m = 0.05 + 0.08 - (0.3 + back - 0.2).hypot(aside);
    for angle in [-1.0, 0.0, 1.0] {
        assert!(cell.is_free(&[angle, 0.0, angle], &mut scratch));
        let folded = [angle, 3.0, angle];
        assert!(!cell.is_free(&folded, &mut scratch));
        let contact = cell.first_contact(&folded, &mut scratch).expect("the arms touch");
        assert!((contact.depth_m - expected_m).abs() < 1e-6, "{contact:?}");
    }
}
