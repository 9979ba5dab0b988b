//! Links that do not touch only in a window of a joint's range, and their treatment by `RobotSetup`.

use std::fmt::Write as _;

use cranny_collision::{Cell, Margins, World};
use cranny_setup::{RobotSetup, SetupOptions};

/// Returns an arm of three joints; its last link turns in a ring of blocks that is open for that share of the turn.
fn ring(window: f64, slide: &str) -> String {
    const BLOCKS: u32 = 200;
    let turn = std::f64::consts::TAU;
    let open_rad = window * turn + 0.004 / 0.2;
    let mut text =
        String::from(r#"<robot name="ring"><link name="base"/><link name="column"/><link name="ring">"#);
    for block in 0..BLOCKS {
        let angle = 1.0 + 0.5 * open_rad + (turn - open_rad) * (f64::from(block) + 0.5) / f64::from(BLOCKS);
        let width = 0.2 * (turn - open_rad) / f64::from(BLOCKS);
        let (x, y) = (0.2 * angle.cos(), 0.2 * angle.sin());
        let _ = write!(
            text,
            r#"<collision><origin xyz="{x} {y} 0" rpy="0 0 {angle}"/><geometry><box size="0.02 {width} 0.06"/></geometry></collision>"#
        );
    }
    let joint = |name: &str, kind: &str, parent: &str, child: &str, reach: &str| {
        format!(
            r#"<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><origin xyz="0 0 0.3"/>
            <axis xyz="0 0 1"/><limit lower="-{reach}" upper="{reach}" velocity="1" effort="1"/></joint>"#
        )
    };
    text += r#"</link><link name="hub"/><link name="fin"><collision><origin xyz="0.2 0 -0.3"/><geometry><box size="0.05 0.002 0.01"/>
        </geometry></collision></link>"#;
    text += &joint("j1", "revolute", "base", "column", "3");
    text += &joint("j2", "revolute", "column", "ring", "3");
    text += &joint("slide", "prismatic", "ring", "hub", slide).replace("0 0 0.3", "0 0 0");
    text + &joint("j3", "revolute", "hub", "fin", "3.1") + "</robot>"
}

fn setup(name: &str, urdf: &str) -> RobotSetup {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(format!("{name}.urdf"));
    std::fs::write(&path, urdf).unwrap();
    RobotSetup::of(&path, &SetupOptions { is_bare: true, ..SetupOptions::default() }).unwrap()
}

/// Guards against dropped pairs: one that was free for 4.5 % of a joint's turn was dropped, and so were all with less.
#[test]
fn a_pair_that_is_free_in_a_window_is_checked_and_the_start_lies_in_it() {
    for window in [0.045, 0.005] {
        let setup = setup("ring", &ring(window, "0.01"));
        let robot = &setup.robot;
        assert!(robot.disabled_pairs().is_empty(), "{:?}", setup.choices);
        let cell = Cell::new(robot.clone(), World::new(Vec::new()).unwrap(), Margins::default()).unwrap();
        let mut scratch = cell.scratch();
        let mut q = robot.default_start().unwrap().to_vec();
        assert!(cell.is_free(&q, &mut scratch));
        q[3] -= 0.5;
        assert!(!cell.is_free(&q, &mut scratch));
    }
}

/// Checks that a pair that touches everywhere is exempted as proven, and that the files state it.
#[test]
fn a_pair_that_is_proven_to_touch_always_is_written_down_as_that() {
    let urdf = ring(0.0, "0.01").replace(r#"<box size="0.05 0.002 0.01"/>"#, r#"<sphere radius="0.025"/>"#);
    let setup = setup("ball", &urdf);
    assert_eq!(setup.robot.disabled_pairs().len(), 1);
    let srdf = String::from_utf8(setup.files["ball.srdf"].clone()).unwrap();
    assert!(srdf.contains("proven: at least") || srdf.contains("Always in samples"), "{srdf}");
    let choice = setup.choices.iter().find(|choice| choice.what == "unchecked pairs").unwrap();
    assert!(choice.chosen.contains("mm deep"), "{}", choice.chosen);
    assert!(String::from_utf8_lossy(&setup.files["robot.yaml"]).contains("# unchecked pairs:"));
}
