//! Custom robots: the page about them, and URDFs of every malformed kind.

use std::f64::consts::PI;
use std::fmt::Write as _;
use std::path::Path;
use std::process::Output;

use assert_cmd::Command;
use cranny_collision::Margins;
use cranny_plan::{Budget, Unobserved};
use cranny_robot::{Robot, RobotOptions};
use cranny_scenario::{OpenOptions, Scenario};
use cranny_solve::{Request, solve};

fn page() -> String {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/robots.md");
    std::fs::read_to_string(page).expect("the page")
}

/// Returns the blocks of a page in a language, in order.
fn blocks<'a>(page: &'a str, language: &str) -> Vec<&'a str> {
    let opening = format!("```{language}\n");
    page.split(&opening).skip(1).filter_map(|rest| rest.split("```").next()).collect()
}

fn cranny<'a>(folder: &Path, words: impl IntoIterator<Item = &'a str>) -> Output {
    let mut command = Command::cargo_bin("cranny").expect("the program");
    command.current_dir(folder).args(words).output().expect("it runs")
}

/// Runs a command that must succeed and returns its output.
fn done<'a>(folder: &Path, words: impl IntoIterator<Item = &'a str>) -> String {
    let output = cranny(folder, words);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
fn every_file_of_the_page_is_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let page = page();
    let yaml = blocks(&page, "yaml");
    let [robot, limits, gripper] = yaml[..] else { panic!("three files, but {}", yaml.len()) };
    let arm = r#"<robot name="my_arm">
          <link name="root"/><link name="cart"/><link name="upper"/><link name="other"/><link name="lower"/>
          <link name="grasp_frame"/><link name="finger"/>
          <joint name="base" type="planar"><parent link="root"/><child link="cart"/>
            <limit velocity="1" effort="1"/></joint>
          <joint name="shoulder" type="revolute"><parent link="cart"/><child link="upper"/><axis xyz="0 0 1"/>
            <limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
          <joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/><axis xyz="0 1 0"/>
            <limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
          <joint name="other_arm_joint" type="continuous"><parent link="cart"/><child link="other"/></joint>
          <joint name="tip" type="fixed"><parent link="lower"/><child link="grasp_frame"/></joint>
          <joint name="gripper_joint" type="revolute"><parent link="lower"/><child link="finger"/><axis xyz="1 0 0"/>
            <limit lower="0" upper="0.8" velocity="1" effort="1"/></joint></robot>"#;
    let srdf = r#"<robot name="my_arm"><group name="arm"><joint name="base"/><joint name="shoulder"/>
          <joint name="elbow"/></group></robot>"#;
    let robot_folder = folder.join("my_arm");
    std::fs::create_dir(&robot_folder).expect("a folder");
    for (name, text) in
        [("arm.urdf", arm), ("arm.srdf", srdf), ("robot.yaml", robot), ("limits.yaml", limits)]
    {
        std::fs::write(robot_folder.join(name), text).expect("written");
    }
    let robot = Robot::load(&robot_folder, &RobotOptions::default()).expect("a robot");
    assert_eq!(robot.joint_names(), ["base/x", "base/y", "base/theta", "shoulder", "elbow"]);
    assert_eq!(robot.hand().map(|hand| hand.description.opening_m), Some(0.085));
    let (drive, shoulder) = (&robot.limits()[0], &robot.limits()[3]);
    assert_eq!((drive.lower, drive.upper, drive.velocity), (-1.0, 1.0, 0.5));
    assert_eq!((shoulder.acceleration, shoulder.jerk), (Some(5.0), Some(50.0)));

    std::fs::write(folder.join("gripper.yaml"), gripper).expect("written");
    done(folder, "grasps sample banana --count 5 -o made.csv --gripper gripper.yaml".split(' '));
    let grasps = *blocks(&page, "text").last().expect("grasps");
    std::fs::write(folder.join("grasps.csv"), grasps).expect("written");
    done(folder, "grasps coverage grasps.csv grasps.csv".split(' '));
}

/// Variations of a malformed robot.
#[derive(Default)]
struct Arm<'a> {
    range: Option<&'a str>,
    link: &'a str,
    hands: Option<&'a str>,
    more: &'a str,
}

/// Returns sliding fingers on both sides of a palm.
fn slides(palm: &str, second: &str) -> String {
    format!(
        r#"<link name="{palm}"><collision><geometry><box size="0.08 0.2 0.06"/></geometry></collision></link>
        <joint name="{palm}_mount" type="fixed"><origin xyz="0 0 0.45"/><parent link="lower"/><child link="{palm}"/></joint>
        <link name="{palm}_l"><collision><geometry><box size="0.02 0.01 0.05"/></geometry></collision></link>
        <joint name="{palm}_left" type="prismatic"><origin xyz="0 0.005 0.055"/><parent link="{palm}"/><child link="{palm}_l"/>
          <axis xyz="0 1 0"/><limit lower="0" upper="0.04" velocity="1" effort="0"/></joint>
        <link name="{palm}_r"><collision><geometry><box size="0.02 0.01 0.05"/></geometry></collision></link>
        <joint name="{palm}_right" type="prismatic"><origin xyz="0 -0.005 0.055"/><parent link="{palm}"/><child link="{palm}_r"/>
          <axis xyz="0 -1 0"/><limit lower="0" upper="0.04" velocity="1" effort="0"/>{second}</joint>"#
    )
}

impl Arm<'_> {
    fn urdf(&self) -> String {
        let range = self.range.unwrap_or(r#"lower="-3" upper="3""#);
        let joint = |name: &str, parent: &str, child: &str, axis: &str, height: f64| {
            format!(
                r#"<joint name="{name}" type="revolute"><origin xyz="0 0 {height}"/><parent link="{parent}"/>
                <child link="{child}"/><axis xyz="{axis}"/><limit {range} velocity="1" effort="0"/></joint>"#
            )
        };
        let body = |name: &str, length: f64| {
            format!(
                r#"<link name="{name}"><collision><origin xyz="0 0 {}"/><geometry><cylinder radius="0.04" length="{length}"/>
                </geometry></collision>{}</link>"#,
                length / 2.0 + 0.03,
                self.link
            )
        };
        [
            r#"<robot name="arm"><link name="base"><collision><geometry><box size="0.2 0.2 0.1"/></geometry></collision></link>"#,
            &joint("j1", "base", "turret", "0 0 1", 0.1),
            &body("turret", 0.2),
            &joint("j2", "turret", "upper", "0 1 0", 0.3),
            &body("upper", 0.35),
            &joint("j3", "upper", "elbow", "0 1 0", 0.45),
            r#"<link name="elbow"/>"#,
            &joint("j4", "elbow", "forearm", "0 0 1", 0.0),
            r#"<link name="forearm"/>"#,
            &joint("j5", "forearm", "wrist", "0 1 0", 0.0),
            r#"<link name="wrist"/>"#,
            &joint("j6", "wrist", "lower", "0 0 1", 0.0),
            &body("lower", 0.35),
            self.hands.unwrap_or_default(),
            self.more,
            "</robot>",
        ]
        .concat()
    }
}

#[test]
fn a_malformed_robot_is_taken_as_it_can_only_be_meant_or_refused_with_what_to_do() {
    let mimicking = slides("palm", r#"<mimic joint="palm_left"/>"#);
    let unbound = slides("palm", "");
    let two =
        slides("palm", r#"<mimic joint="palm_left"/>"#) + &slides("other", r#"<mimic joint="other_left"/>"#);
    let mut chain = String::new();
    for k in 0..10_000 {
        let parent = if k == 0 { "base".to_owned() } else { format!("c{}", k - 1) };
        let joint = r#"type="fixed""#;
        let _ = write!(
            chain,
            r#"<link name="c{k}"/><joint name="f{k}" {joint}><parent link="{parent}"/><child link="c{k}"/></joint>"#
        );
    }
    let missing = r#"<visual><geometry><mesh filename="gone.stl"/></geometry></visual>
        <collision><geometry><mesh filename="package://nowhere/gone.stl"/></geometry></collision>"#;
    let cases: [(&str, Arm<'_>, i32, &[&str]); 8] = [
        (
            "sound",
            Arm { hands: Some(&mimicking), ..Arm::default() },
            0,
            &["on palm, closed by palm_left", "80.0 mm"],
        ),
        ("no_hand", Arm::default(), 0, &["gripper", "--bare"]),
        ("two_hands", Arm { hands: Some(&two), ..Arm::default() }, 0, &["--palm LINK", "other"]),
        ("no_mimic", Arm { hands: Some(&unbound), ..Arm::default() }, 0, &["palm_left", "palm_right"]),
        ("no_range", Arm { range: Some(""), ..Arm::default() }, 2, &["j1", "lower and upper"]),
        (
            "swapped",
            Arm { range: Some(r#"lower="3" upper="-3""#), ..Arm::default() },
            2,
            &["swapped.urdf:", "greater"],
        ),
        ("no_mesh", Arm { link: missing, ..Arm::default() }, 2, &["gone.stl", "--package"]),
        (
            "many_links",
            Arm { hands: Some(&mimicking), more: &chain, ..Arm::default() },
            2,
            &["10010 links", "at most 1000"],
        ),
    ];
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    for (name, arm, code, words) in cases {
        std::fs::write(folder.join(format!("{name}.urdf")), arm.urdf()).expect("written");
        let output = cranny(folder, ["robot", "add", &format!("{name}.urdf")]);
        let said = [output.stdout.as_slice(), &output.stderr].map(String::from_utf8_lossy).concat();
        assert_eq!(output.status.code(), Some(code), "{name}: {said}");
        for word in words {
            assert!(said.contains(word), "{name}: no '{word}' in {said}");
        }
        assert_eq!(folder.join(name).exists(), code == 0, "{name}");
    }
    std::fs::write(folder.join("rigid.urdf"), r#"<robot name="rigid"><link name="only"/></robot>"#)
        .expect("written");
    std::fs::write(folder.join("arm.urdf.xacro"), "<robot>").expect("written");
    for (file, word) in
        [("rigid.urdf", "nothing here can grasp"), ("arm.urdf.xacro", "xacro"), ("gone.urdf", "gone.urdf")]
    {
        let output = cranny(folder, ["robot", "add", file]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!((output.status.code(), said.contains(word)), (Some(2), true), "{file}: {said}");
    }
}

#[test]
fn a_delivered_path_of_an_arm_with_full_turns_does_not_wind() {
    for (id, seeds) in [("012", 15), ("021", 15), ("031", 15)] {
        let options = OpenOptions { robot: Some("ur5e".into()), ..OpenOptions::default() };
        let problem = Scenario::open(id, &options).and_then(|opened| opened.problem(Margins::default()));
        let problem = problem.expect("a problem");
        let mut solved = 0;
        for seed in 0..seeds {
            let budget = Budget { iterations: 20_000, ..Budget::default() };
            let request = Request { seed, budget, ..Request::default() };
            let answer = solve(&problem, &request, &mut Unobserved).expect("an answer");
            solved += usize::from(answer.is_solved());
            let turn = problem.robot().needless_turn(&answer.waypoints());
            assert!(turn <= PI, "{id}, seed {seed}: {turn} rad beyond need");
        }
        println!("{id}: {solved} of {seeds}");
    }
}

/// Guards proofs about robots whose URDF has only visual geometry.
#[test]
fn links_that_are_seen_and_not_checked_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let urdf = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/tutorial/arm.urdf");
    let urdf = std::fs::read_to_string(urdf).expect("a URDF").replace("collision>", "visual>");
    let unseen = urdf.replacen("<visual>", "<collision>", 1).replacen("</visual>", "</collision>", 1);
    for (name, text, is_fault) in [("none", &urdf, true), ("most", &unseen, false)] {
        std::fs::write(folder.join(format!("{name}.urdf")), text).expect("written");
        let added = cranny(folder, ["robot", "add", &format!("{name}.urdf"), "--bare"]);
        let said = String::from_utf8_lossy(&added.stderr);
        assert!(
            said.contains("have a <visual> and no <collision>") && said.contains("'lower_arm'"),
            "{said}"
        );
        let checked = cranny(folder, ["robot", "check", name]);
        assert_eq!(
            checked.status.code() == Some(0),
            !is_fault,
            "{}",
            String::from_utf8_lossy(&checked.stdout)
        );
        assert!(String::from_utf8_lossy(&checked.stdout).contains("not checked"));
    }
}
