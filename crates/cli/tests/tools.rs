//! Tools without pads: a suction cup and a hand with three fingers, whose grasps come from files.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Output;

use assert_cmd::Command;

fn cranny(folder: &Path, line: &str) -> Output {
    let mut command = Command::cargo_bin("cranny").expect("the program");
    command.current_dir(folder).args(line.split(' ')).output().expect("it runs")
}

fn done(folder: &Path, line: &str) -> String {
    let output = cranny(folder, line);
    assert_eq!(output.status.code(), Some(0), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn refused(folder: &Path, line: &str, words: &[&str]) {
    let output = cranny(folder, line);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{line}: {error}");
    assert_eq!(error.trim_end().lines().count(), 1, "{line}: {error}");
    for word in words {
        assert!(error.contains(word), "{line}: no '{word}' in: {error}");
    }
}

/// A gantry of four joints with a flange that looks down.
fn gantry(tool: &str) -> String {
    let slide = |name: &str, parent: &str, child: &str, axis: &str, range: &str, more: &str| {
        format!(
            r#"<joint name="{name}" type="prismatic"><parent link="{parent}"/><child link="{child}"/>{more}<axis xyz="{axis}"/>
              <limit {range} velocity="1" effort="1"/></joint>"#
        )
    };
    [
        r#"<robot name="gantry"><link name="post"><collision><origin xyz="-0.9 0 0.51"/><geometry><box size="0.1 0.1 1"/></geometry>
        </collision></link><link name="bridge"/><link name="trolley"/>
        <link name="mast"><collision><origin xyz="0 0 0.3"/><geometry><cylinder radius="0.03" length="0.6"/></geometry>
        </collision></link>
        <link name="flange"><collision><origin xyz="0 0 0.01"/><geometry><cylinder radius="0.03" length="0.02"/></geometry>
        </collision></link>"#,
        &slide("x", "post", "bridge", "1 0 0", r#"lower="-0.5" upper="0.5""#, r#"<origin xyz="0 0 1"/>"#),
        &slide("y", "bridge", "trolley", "0 1 0", r#"lower="-0.5" upper="0.5""#, ""),
        &slide("z", "trolley", "mast", "0 0 -1", r#"lower="0" upper="0.6""#, ""),
        r#"<joint name="turn" type="revolute"><parent link="mast"/><child link="flange"/>
        <origin rpy="3.141592653589793 0 0"/><axis xyz="0 0 1"/>
        <limit lower="-3.1" upper="3.1" velocity="1" effort="1"/></joint>"#,
        tool,
        "</robot>",
    ]
    .concat()
}

const CUP: &str = r#"<link name="cup"><collision><origin xyz="0 0 0.03"/><geometry><cylinder radius="0.02" length="0.06"/></geometry>
    </collision></link>
    <joint name="cup_mount" type="fixed"><origin xyz="0 0 0.02"/><parent link="flange"/><child link="cup"/></joint>"#;

/// A palm with three fingers around it, which close at positive values.
fn three_fingers() -> String {
    let mut text = r#"<link name="palm"><collision><origin xyz="0 0 0.015"/><geometry><cylinder radius="0.05" length="0.03"/>
        </geometry></collision></link>
        <joint name="palm_mount" type="fixed"><origin xyz="0 0 0.02"/><parent link="flange"/><child link="palm"/></joint>"#
        .to_owned();
    for (finger, place) in
        ["0.045 0 0.035", "-0.0225 0.03897 0.035", "-0.0225 -0.03897 0.035"].iter().enumerate()
    {
        let turn = 2.0943951 * finger as f64;
        let _ = write!(
            text,
            r#"<link name="finger{finger}"><collision><origin xyz="0 0 0.03"/><geometry><box size="0.01 0.02 0.06"/></geometry>
            </collision></link>
            <joint name="knuckle{finger}" type="revolute"><origin xyz="{place}" rpy="0 0 {turn}"/><parent link="palm"/>
            <child link="finger{finger}"/><axis xyz="0 -1 0"/>
            <limit lower="-0.3" upper="0.9" velocity="1" effort="1"/></joint>"#
        );
    }
    text
}

/// Returns a line of `grasps.csv`: the gripper frame looks down at a point, turned about the vertical (rad).
fn grasp([x, y, z]: [f64; 3], turn: f64) -> String {
    let (sine, cosine) = cranny_spatial::sin_cos(turn);
    format!("{cosine},{sine},0,{x},{sine},{},0,{y},0,0,-1,{z},0,0,0,1\n", -cosine)
}

/// Writes a scenario for the robot in `robot`: a box on a column, to be grasped from above.
fn write_cell(folder: &Path, robot: &str, grasps: &str) {
    let cell = folder.join("cell");
    std::fs::create_dir_all(&cell).expect("a folder");
    let yaml = format!(
        "robot: ../{robot}\nstart: {{x: -0.3, y: -0.2, z: 0.1, turn: 0}}\nfloor: 0\nobstacles:\n  - name: column\n    \
         pose: {{position: [0.2, 0.1, 0.2]}}\n    shapes: [{{box: {{size: [0.1, 0.1, 0.4]}}}}]\n  - name: wall\n    pose: \
         {{position: [0, 0, 0.35]}}\n    shapes: [{{box: {{size: [0.02, 0.3, 0.7]}}}}]\ntarget:\n  name: parcel\n  pose: \
         {{position: [0.2, 0.1, 0.43]}}\n  shapes: [{{box: {{size: [0.05, 0.05, 0.06]}}}}]\n  mass_kg: 0.2\n"
    );
    std::fs::write(cell.join("scenario.yaml"), yaml).expect("written");
    std::fs::write(cell.join("grasps.csv"), grasps).expect("written");
}

#[test]
fn a_suction_cup_reaches_imported_grasps_and_nothing_else() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    std::fs::write(folder.join("gantry.urdf"), gantry(CUP)).expect("written");
    refused(folder, "robot add gantry.urdf --tool lid -o x", &["unknown link 'lid'", "known"]);
    refused(folder, "robot add gantry.urdf --tool bridge -o x", &["bridge", "no geometry"]);
    let both = cranny(folder, "robot add gantry.urdf --tool cup --palm flange -o x");
    assert!(both.status.code() == Some(2) && String::from_utf8_lossy(&both.stderr).contains("--palm"));
    let page = done(folder, "robot add gantry.urdf --tool cup -o gantry");
    for words in
        ["cup, a body without fingers", "grasp_frame, a new link at (0.0, 0.0, 62.0) mm on cup", "ahead"]
    {
        assert!(page.contains(words), "no '{words}' in {page}");
    }
    let yaml = std::fs::read_to_string(folder.join("gantry/robot.yaml")).expect("a description");
    assert!(yaml.contains("tool:\n  name: cup\n") && !yaml.contains("opening_m"), "{yaml}");
    let page = done(folder, "robot check gantry --picture gantry.png");
    assert!(page.contains("cup: cup") && page.contains("none are sampled"), "{page}");
    // One grasp on the top face, which the cup touches nowhere.
    let on_top = [0.2, 0.1, 0.46];
    write_cell(folder, "gantry", &grasp(on_top, 0.5));
    done(folder, "scenario check cell");
    assert!(done(folder, "grasps filter cell").contains('1'));
    done(folder, "plan cell -o plan.json");
    done(folder, "verify cell plan.json");
    done(folder, "render cell plan.json -o plan.png --size 80x60 --samples 1");
    // Half a turn is another grasp: a cup may have a corner, or the object a label.
    std::fs::write(folder.join("cell/grasps.csv"), grasp(on_top, 0.5 - std::f64::consts::PI))
        .expect("written");
    let turned = cranny(folder, "verify cell plan.json --json");
    let page = String::from_utf8_lossy(&turned.stdout);
    assert_eq!(turned.status.code(), Some(1), "{page}{}", String::from_utf8_lossy(&turned.stderr));
    assert!(page.contains("grasp"), "{page}");
    done(folder, "plan cell -o other.json");
    done(folder, "verify cell other.json");
    // What needs pads is refused in a line.
    let tool = &["tool 'cup'", "no pads", "from a file"];
    refused(folder, "grasps sample cell --count 5 -o x.csv", tool);
    refused(folder, "scenario generate --family table --count 1 --robot gantry -o set", tool);
    refused(folder, "plan cell --grasps none", &["hand with pads that close", "tool"]);
    refused(folder, "plan cell --carry home", &["hand with pads that close", "tool"]);
    refused(folder, "simulate grasps cell", &["'cup'", "cannot close"]);
    assert!(!folder.join("x").exists() && !folder.join("x.csv").exists() && !folder.join("set").exists());
    let hand = "hand: {name: h, opening_m: 0.1, finger_depth_m: 0.1, closing_force_n: 1}\n";
    std::fs::write(folder.join("gantry/robot.yaml"), format!("{yaml}{hand}")).expect("written");
    refused(folder, "robot check gantry", &["robot.yaml:", "`hand`", "`tool`", "not both"]);
}

#[test]
fn a_hand_with_three_fingers_stands_open_and_reaches_imported_grasps() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    std::fs::write(folder.join("gantry.urdf"), gantry(&three_fingers())).expect("written");
    let page = done(folder, "robot add gantry.urdf --tool palm -o gantry");
    assert!(
        page.contains("4 joints move") && page.contains("palm with 3 fingers, which stand open"),
        "{page}"
    );
    assert!(page.contains("between the open fingers"), "{page}");
    let yaml = std::fs::read_to_string(folder.join("gantry/robot.yaml")).expect("a description");
    for finger in 0..3 {
        assert!(yaml.contains(&format!("  knuckle{finger}: -0.3\n")), "{yaml}");
    }
    // The fingers stand around the parcel, whose diagonal is 71 mm long.
    write_cell(folder, "gantry", &grasp([0.2, 0.1, 0.45], 0.0));
    done(folder, "scenario check cell");
    done(folder, "plan cell -o plan.json");
    done(folder, "verify cell plan.json");
    refused(folder, "grasps sample cell --count 5 -o x.csv", &["tool 'palm'", "no pads"]);
    // Another gripper frame can be named.
    let page = done(folder, "robot add gantry.urdf --tool palm --tip flange -o other");
    assert!(page.contains("as requested"), "{page}");
}
