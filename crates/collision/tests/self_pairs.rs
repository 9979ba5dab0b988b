//! Which links are checked against each other.

mod fixture;

use cranny_collision::{Cell, Collider};
use cranny_robot::{JointGroup, RobotOptions, TextSource};
use fixture::{FOLDED, arm, cell, robot};

/// A base with a bare hub that carries two arms; the left one has a forearm of the given radius.
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

const EMPTY_SRDF: &str = r#"<robot name="two_arms"/>"#;

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

#[test]
fn neighbours_and_siblings_over_a_bare_hub_are_left_out() {
    assert_eq!(names(&two_arms(0.05, EMPTY_SRDF)), [["base", "forearm"], ["forearm", "right"]]);
}

#[test]
fn a_pair_that_the_srdf_disables_is_left_out() {
    let srdf = r#"<robot name="two_arms"><disable_collisions link1="forearm" link2="right"/></robot>"#;
    assert_eq!(names(&two_arms(0.05, srdf)), [["base", "forearm"]]);
}

#[test]
fn pairs_that_are_always_in_contact_are_left_out() {
    // The forearm hangs at most 0.5 m from the hub, so that it always reaches base and right arm.
    assert!(names(&two_arms(1.0, EMPTY_SRDF)).is_empty());
}

#[test]
fn links_that_no_joint_moves_against_each_other_are_left_out() {
    let robot = arm();
    let cell = cell(&robot, Vec::new(), 0.0);
    let hand = fixture::hand(&robot);
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
    let cell = two_arms(0.08, EMPTY_SRDF);
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
