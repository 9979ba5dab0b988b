//! Files of 1 to 10 megabytes whose elements refer to each other. Time in proportion to the square of their number would end
//! each test only after minutes.

use cranny_robot::{Robot, RobotError, RobotOptions, Srdf, TextSource, UrdfText};

/// Chain of two links with a prismatic joint, and more content.
fn arm(more: &str) -> String {
    format!(
        r#"<robot name="arm"><link name="a"/><link name="b"/>{more}
<joint name="j" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="1 0 0"/>
  <limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>"#
    )
}

fn repeated(count: usize, element: impl Fn(usize) -> String) -> String {
    (0..count).map(element).collect::<Vec<_>>().concat()
}

fn load(urdf: &str, srdf: &str) -> Result<Robot, RobotError> {
    let srdf = format!("<robot name=\"arm\">{srdf}</robot>");
    let srdf = Some(TextSource::Text { name: "arm.srdf".into(), text: srdf });
    Robot::from_urdf_text(urdf, "arm.urdf", None, &RobotOptions { srdf, ..RobotOptions::default() })
}

fn fault_of(urdf: &str, srdf: &str) -> String {
    load(urdf, srdf).expect_err("too much content").to_string()
}

#[test]
fn attributes_and_namespaces_beyond_any_file_are_refused() {
    let attributes = |count| repeated(count, |index| format!(" a{index}=\"0\""));
    let namespaces = |count| repeated(count, |index| format!(" xmlns:n{index}=\"u\""));
    for (more, words) in [
        (format!("<x{}/>", attributes(65)), "65 attributes in one element, but at most 64"),
        (format!("<x{}/>", namespaces(100_000)), "100000 attributes in one element, but at most 64"),
        (
            repeated(200_000, |index| format!("<x xmlns:n{index}=\"u\">")),
            "65 namespaces declared for one element, but at most 64",
        ),
        (repeated(100_000, |_| "<x>".to_owned()), "elements inside each other, but at most 256"),
        (format!("<x xmlns:n=\"{}\"/>", "u".repeat(1_000_000)), "bytes in the declaration of one namespace"),
        (repeated(2_100_000, |_| "<x/>".to_owned()), "`<` in one XML text, but at most 2000000"),
        (format!("<!--{}-->", "=".repeat(2_100_000)), "`=` in one XML text, but at most 2000000"),
    ] {
        let said = fault_of(&arm(&more), "");
        assert!(said.contains("arm.urdf:1: ") && said.contains(words), "no '{words}' in {said}");
        let said = fault_of(&arm(""), &more);
        assert!(said.contains("arm.srdf:1: ") && said.contains(words), "no '{words}' in {said}");
    }
    // Many elements may have a few of each.
    let few = repeated(10_000, |_| format!("<transmission{} {}/>", attributes(20), namespaces(20)));
    load(&arm(&few), "").expect("a robot");
}

#[test]
fn every_undeclared_prefix_costs_one_pass() {
    let visual = |index: usize| {
        format!("<visual p{}:x=\"1\"><geometry><sphere radius=\"1\"/></geometry></visual>", index % 16)
    };
    let robot = arm("")
        .replace("<link name=\"a\"/>", &format!("<link name=\"a\">{}</link>", repeated(20_000, visual)));
    let notes = load(&robot, "").expect("a robot").notes().to_vec();
    let of_first = "attribute `p0:x` of <visual> is not read, here and at 1249 more places";
    assert!(notes.iter().any(|note| note.contains(of_first)), "{notes:?}");
}

#[test]
fn comments_in_front_of_a_robot_are_passed_over_once() {
    let robot = arm(&repeated(100_000, |_| "<gazebo/>".to_owned()));
    load(&format!("{}{robot}", "<!---->".repeat(200_000)), "").expect("a robot");
}

#[test]
fn names_of_an_srdf_are_compared_by_sorting() {
    let states = repeated(100_000, |index| format!("<group_state name=\"s{index}\" group=\"g\"/>"));
    let values = repeated(100_000, |index| format!("<joint name=\"v/{index}\" value=\"0\"/>"));
    let ends =
        repeated(100_000, |index| format!("<end_effector name=\"e{index}\" group=\"x\" parent_link=\"b\"/>"));
    let srdf = format!(
        "<group name=\"g\"/>{states}<group_state name=\"t\" group=\"g\">{values}</group_state>{ends}\
         <virtual_joint name=\"v\" type=\"fixed\" parent_frame=\"w\" child_link=\"a\"/>"
    );
    let notes = load(&arm(""), &srdf).expect("a robot").notes().to_vec();
    assert_eq!(notes.iter().filter(|note| note.contains("unknown group `x`")).count(), 100_000);
    let subgroups = repeated(100_000, |index| format!("<group name=\"h{index}\"/>"));
    let srdf = Srdf::parse(&format!("<robot><group name=\"g\">{subgroups}</group></robot>"), "arm.srdf");
    assert!(!srdf.expect("an SRDF").has_joint("g", "j"));
}

#[test]
fn pairs_of_an_srdf_are_kept_once() {
    let links = repeated(900, |index| {
        format!(
            "<link name=\"l{index}\"/><joint name=\"f{index}\" type=\"fixed\"><parent link=\"a\"/><child link=\"l{index}\"/></joint>"
        )
    });
    // All pairs with the first 100 links, each named a thousand times.
    let untested =
        repeated(100_000, |index| format!("<disable_default_collisions link=\"l{}\"/>", index % 100));
    let pairs = repeated(100_000, |index| {
        format!("<disable_collisions link1=\"l{}\" link2=\"l{}\"/>", index % 300, 300 + index % 600)
    });
    let robot = load(&arm(&links), &(untested + &pairs)).expect("a robot");
    assert!(robot.disabled_pairs().len() < 200_000, "{}", robot.disabled_pairs().len());
}

#[test]
fn more_elements_than_any_robot_has_are_refused() {
    let of = |count: usize, element: &str| repeated(count, |index| element.replace('#', &index.to_string()));
    for (element, what) in [
        ("<group name=\"#\"/>", "groups"),
        ("<group name=\"#\"><chain base_link=\"a\" tip_link=\"b\"/></group>", "groups"),
        ("<passive_joint name=\"#\"/>", "passive joints"),
        ("<virtual_joint name=\"#\" type=\"fixed\" parent_frame=\"w\" child_link=\"a\"/>", "virtual joints"),
    ] {
        let said = fault_of(&arm(""), &of(30_000, element));
        let words = format!("arm.srdf:1: 30000 {what} in one SRDF, but at most 1000 are read");
        assert!(said.contains(&words), "no '{words}' in {said}");
    }
    let chains = of(30_000, "<chain base_link=\"a\" tip_link=\"b\"/>");
    assert!(
        fault_of(&arm(""), &format!("<group name=\"g\">{chains}</group>"))
            .contains("30000 chains in one SRDF")
    );
    let joint = "<joint name=\"#\" type=\"floating\"><parent link=\"a\"/><child link=\"#\"/></joint>";
    assert!(fault_of(&arm(&of(30_000, joint)), "").contains("30001 joints in one robot, but at most 1000"));
    let ball = "<collision><geometry><sphere radius=\"1\"/></geometry></collision>";
    let body =
        arm("").replace("<link name=\"a\"/>", &format!("<link name=\"a\">{}</link>", ball.repeat(20_000)));
    assert!(fault_of(&body, "").contains("20000 collision shapes in one robot, but at most 10000"));
}

#[test]
fn bodies_are_removed_in_one_pass() {
    let body = "<collision><geometry><sphere radius=\"1\"/></geometry></collision>";
    let bodies = repeated(9000, |_| body.to_owned());
    let urdf = arm("").replace("<link name=\"a\"/>", &format!("<link name=\"a\">{bodies}</link>"));
    let bare = UrdfText::new(urdf, "arm.urdf").expect("a robot").without_body("a").expect("a robot");
    assert_eq!(bare.text(), arm("").replace("<link name=\"a\"/>", "<link name=\"a\"></link>"));
}
