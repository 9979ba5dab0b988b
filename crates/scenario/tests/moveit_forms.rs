//! Forms in which `MoveIt` scenes, requests and their robots are written: each is read for what it is, or refused by
//! name; nothing is passed over.

use std::fs;
use std::path::PathBuf;

use cranny_scenario::{MoveItDeviation, MoveItOptions, MoveItProblem, ScenarioError, read_moveit_scene};
use cranny_spatial::Vector;

const URDF: &str = r#"<robot name="bot">
<link name="base_link"><collision><origin xyz="0 0 0.05"/><geometry><cylinder length="0.1" radius="0.08"/></geometry></collision></link>
<link name="arm"><collision><origin xyz="0 0 0.3"/><geometry><box size="0.05 0.05 0.5"/></geometry></collision></link>
<link name="fore"><collision><origin xyz="0 0 0.15"/><geometry><box size="0.04 0.04 0.28"/></geometry></collision></link>
<link name="flag"><collision><origin xyz="0.2 0 0"/><geometry><box size="0.1 0.02 0.02"/></geometry></collision></link>
<link name="slide"/>
<joint name="j1" type="revolute"><origin xyz="0 0 0.1"/><parent link="base_link"/><child link="arm"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
<joint name="j2" type="revolute"><origin xyz="0 0 0.57"/><parent link="arm"/><child link="fore"/><axis xyz="0 1 0"/><limit lower="-2.6" upper="2.6" velocity="1" effort="1"/></joint>
<joint name="roll" type="continuous"><origin xyz="0 0 0.33"/><parent link="fore"/><child link="flag"/><axis xyz="0 0 1"/><limit velocity="1" effort="1"/></joint>
<joint name="lower" type="prismatic"><parent link="fore"/><child link="slide"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" velocity="1" effort="1"/><mimic joint="j1" multiplier="0.5"/></joint>
</robot>"#;

const SRDF: &str = r#"<robot name="bot"><virtual_joint name="stand" type="floating" parent_frame="world" child_link="base_link"/>
<group name="arm"><joint name="j1"/><joint name="j2"/></group></robot>"#;

/// A scene with every key that its messages have.
const SCENE: &str = "name: ''
robot_model_name: bot
robot_state:
  joint_state: {header: {seq: 0, stamp: 0, frame_id: base_link}, name: [j1, j2, roll], position: [0, 0, 0], velocity: [0, 0, 0], effort: []}
  multi_dof_joint_state: {header: {frame_id: world}, joint_names: [stand], transforms: [{translation: [0, 0, 0], rotation: [0, 0, 0, 1]}], twist: [], wrench: []}
  attached_collision_objects: []
  is_diff: false
fixed_frame_transforms:
  - {header: {frame_id: world}, child_frame_id: shelf, transform: {translation: [0, 0, 1], rotation: [0, 0, 0, 1]}}
allowed_collision_matrix:
  entry_names: [base_link, arm]
  entry_values: [{enabled: [false, true]}, [true, false]]
  default_entry_names: []
  default_entry_values: []
link_padding: [{link_name: arm, padding: 0}]
link_scale: [{link_name: arm, scale: 1}]
object_colors: [{id: wall, color: {r: 1, g: 0, b: 0, a: 1}}]
world:
  collision_objects:
    - header: {frame_id: world}
      pose: {position: [0.4, 0, 0.5], orientation: [0, 0, 0, 1]}
      id: wall
      type: {key: '', db: ''}
      primitives: [{type: box, dimensions: [0.02, 1.0, 1.2], polygon: {points: []}}]
      primitive_poses: [{position: [0, 0, 0], orientation: [0, 0, 0, 1]}]
      meshes: [{vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], triangles: [{vertex_indices: [0, 2, 1]}, [0, 1, 3], [0, 3, 2], [1, 2, 3]]}]
      mesh_poses: [{position: {x: 9, y: 0, z: 0}, orientation: {x: 0, y: 0, z: 0, w: 1}}]
      planes: []
      plane_poses: []
      subframe_names: []
      subframe_poses: []
      operation: 0
  octomap: {header: {frame_id: ''}, origin: {}, octomap: {header: {}, binary: false, id: '', resolution: 0, data: []}}
is_diff: false
";

/// A request with every key that its messages have.
const REQUEST: &str = "workspace_parameters: {header: {frame_id: world}}
start_state:
  joint_state: {name: [j1, j2], position: [0, 0]}
  is_diff: true
goal_constraints:
  - name: ''
    joint_constraints:
      - {joint_name: j1, position: 0.1, tolerance_above: 0.01, tolerance_below: 0.01, weight: 1}
      - {joint_name: j2, position: 0.3}
    position_constraints: []
    orientation_constraints: []
    visibility_constraints: []
path_constraints: {name: '', joint_constraints: []}
trajectory_constraints: {constraints: []}
reference_trajectories: []
pipeline_id: ompl
planner_id: ''
group_name: arm
num_planning_attempts: 1
allowed_planning_time: 5
max_velocity_scaling_factor: 0.5
max_acceleration_scaling_factor: 0
cartesian_speed_end_effector_link: ''
cartesian_speed_limited_link: ''
max_cartesian_speed: 0
";

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        for (file, text) in
            [("bot.urdf", URDF), ("bot.srdf", SRDF), ("scene.yaml", SCENE), ("request.yaml", REQUEST)]
        {
            folder.write(file, text);
        }
        folder
    }

    fn path(&self, file: &str) -> PathBuf {
        self.0.path().join(file)
    }

    fn write(&self, file: &str, text: &str) -> &Self {
        fs::create_dir_all(self.path(file).parent().unwrap()).unwrap();
        fs::write(self.path(file), text).unwrap();
        self
    }

    fn changed(&self, file: &str, from: &str, to: &str) -> &Self {
        let text = fs::read_to_string(self.path(file)).unwrap();
        assert!(text.contains(from), "{from}");
        self.write(file, &text.replacen(from, to, 1))
    }

    fn open(&self) -> Result<MoveItProblem, ScenarioError> {
        self.open_scene("scene.yaml")
    }

    fn open_scene(&self, scene: &str) -> Result<MoveItProblem, ScenarioError> {
        let options = MoveItOptions { robot: Some(self.path("bot.urdf")), ..MoveItOptions::default() };
        MoveItProblem::open(&self.path(scene), &self.path("request.yaml"), &options)
    }

    fn fault(&self) -> String {
        self.open().unwrap_err().to_string()
    }

    fn deviations(&self) -> Vec<String> {
        self.open().unwrap().deviations.iter().map(ToString::to_string).collect()
    }
}

/// Where the first body stands, in the root frame.
fn place(problem: &MoveItProblem) -> Vector {
    problem.world.bodies()[0].parts[0].world_from_solid.translation.vector
}

const WALL: &str = "id: wall, primitives: [{type: box, dimensions: [0.02, 1, 1.2]}], primitive_poses: [{position: [0.4, 0, 0.5]}]";

#[test]
fn every_form_of_a_scene_has_the_same_world() {
    let folder = Folder::new();
    let scene = format!("world: {{collision_objects: [{{{WALL}}}]}}");
    let indented = scene.replace("world:", "  world:");
    for text in [
        scene.clone(),
        format!("scene:\n{indented}\n"),
        format!("planning_scene:\n{indented}\n"),
        format!("- {scene}\n"),
        format!("collision_objects: [{{{WALL}}}]\noctomap: null\n"),
        format!("{{{WALL}}}\n"),
        format!("- {{{WALL}}}\n"),
        format!("{scene}\n---\n"),
        format!("{scene}\n...\n---\n"),
        "(noname)+\n* wall\n0.1 0 0\n0 0 0 1\n1\nbox\n0.02 1 1.2\n0.3 0 0.5\n0 0 0 1\n0 0 0 0\n1\nrim\n0 0 0\n0 0 0 1\n.\n"
            .to_owned(),
        "(noname)+\n* wall\n1\nbox\n0.02 1 1.2\n0.4 0 0.5\n0 0 0 1\n1 0 0 1\n.\n".to_owned(),
    ] {
        folder.write("scene.yaml", &text);
        let problem = folder.open().unwrap_or_else(|fault| panic!("{text}\n{fault}"));
        assert_eq!(problem.world.bodies().len(), 1, "{text}");
        assert_eq!(problem.world.bodies()[0].name, "wall", "{text}");
        assert!((place(&problem) - Vector::new(0.4, 0.0, 0.5)).norm() < 1e-12, "{text}");
    }
    for (text, fault) in [
        ("robot_model_name: bot\n".to_owned(), "no world"),
        ("robot_model_name: bot\nworld:\n".to_owned(), "no world"),
        ("[]\n".to_owned(), "a list of 0 messages"),
        (format!("- {scene}\n- {scene}\n"), "a list of 2 messages"),
        (scene.replace("collision_objects", "collision_object"), "unknown field `collision_object`"),
        (format!("{scene}\nis_diff: true\n"), "a change to another scene"),
        (format!("{scene}\n---\n{scene}\n"), "a second document"),
        ("wall\n".to_owned(), "a mapping"),
    ] {
        let said = folder.write("scene.yaml", &text).fault();
        assert!(said.contains(fault), "{text}\n{said}");
    }
    folder.write("scene.yaml", "world: {collision_objects: []}\n");
    assert!(folder.open().unwrap().deviations.contains(&MoveItDeviation::EmptyWorld));
}

#[test]
fn a_scene_text_is_read_to_its_end_or_refused() {
    let folder = Folder::new();
    let text = "s
* can
0 0 1
0 0 0 1
2
cylinder
0.05 0.3
1 2 3
0 0 0 1
0 0 0 0
mesh
4 4
0 0 0
1 0 0
0 1 0
0 0 1
0 2 1
0 1 3
0 3 2
1 2 3
0 0 0
0 0 0 1
0 0 0 0
0
.
";
    folder.write("s.scene", text);
    let problem = folder.open_scene("s.scene").unwrap();
    assert!((place(&problem) - Vector::new(1.0, 2.0, 4.0)).norm() < 1e-12);
    let solid = &problem.world.bodies()[0].parts[0].solid;
    let up = solid.support_point(&Vector::z()).unwrap().z;
    assert!((up - 0.15).abs() < 1e-12, "radius first, then length: {up}");
    for (from, to, fault) in [
        ("cylinder", "cone", "s.scene:6: a cone is not supported"),
        ("cylinder", "plane", "s.scene:6: a plane is not supported"),
        ("cylinder", "torus", "s.scene:6: expected a shape (box, sphere, cylinder, mesh), not 'torus'"),
        ("0.05 0.3", "0.05 x", "s.scene:7: expected a number, not 'x'"),
        ("0.05 0.3", "0.05 -0.3", "s.scene:6: 'can': the length of a cylinder"),
        ("1 2 3\n0 0 0 1\n0 0 0 0\nmesh", "1 2 3\n0 0 0 2\n0 0 0 0\nmesh", "s.scene:9: the quaternion"),
        ("\n.\n", "\n", "the end of the file"),
        ("\n.\n", "\n.\nmore\n", "s.scene:26: expected the end of the file, not 'more'"),
        ("1 2 3\n0 0 0\n", "1 2 9\n0 0 0\n", "names vertex 9"),
    ] {
        let said = folder.write("s.scene", &text.replacen(from, to, 1)).open_scene("s.scene");
        let said = said.unwrap_err().to_string();
        assert!(said.contains(fault), "{to}\n{said}");
    }
}

/// Where the keys of a text end, each before its `:`.
fn keys(text: &str) -> Vec<usize> {
    let is_key = |(at, _): &(usize, &str)| text[..*at].ends_with(|c: char| c.is_ascii_alphanumeric());
    text.match_indices(':').filter(is_key).map(|(at, _)| at).collect()
}

#[test]
fn a_key_that_is_misspelt_is_refused_wherever_it_stands() {
    let folder = Folder::new();
    assert_eq!(folder.deviations(), [] as [&str; 0]);
    let mut tried = 0;
    for (file, text) in [("scene.yaml", SCENE), ("request.yaml", REQUEST)] {
        for at in keys(text) {
            let line = text[..at].rsplit('\n').next().unwrap();
            // Of a value that has no bearing on the problem the keys may be any.
            let passed = [
                "type: {",
                "color",
                "workspace_parameters: {",
                "octomap: {header: {",
                "joint_state: {header: {",
            ];
            if passed.iter().any(|passed| line.contains(passed)) && !line.contains("multi_dof") {
                continue;
            }
            let mutated = format!("{}x{}", &text[..at], &text[at..]);
            folder.write(file, &mutated);
            assert!(folder.open().is_err(), "{file}: {line}x");
            tried += 1;
        }
        folder.write(file, text);
    }
    assert!(tried > 80, "{tried}");
}

#[test]
fn what_a_message_holds_and_is_not_read_is_refused_by_name() {
    let folder = Folder::new();
    for (file, from, to, fault) in [
        ("scene.yaml", "data: []", "data: [1, 2]", "an octomap is not supported"),
        ("scene.yaml", "planes: []", "planes: [{coef: [0, 0, 1, 0]}]", "a plane"),
        ("scene.yaml", "type: box", "type: 5", "unknown primitive 'prism'"),
        ("scene.yaml", "operation: 0", "operation: 2", "a change to an object"),
        ("scene.yaml", "operation: 0", "operation: remove", "a change to an object"),
        ("scene.yaml", "scale: 1", "scale: 1.1", "padding or scaling"),
        ("scene.yaml", "attached_collision_objects: []", "attached_collision_objects: [{}]", "an attached"),
        ("scene.yaml", "joint_names: [stand]", "joint_names: [stnd]", "'stnd' is no virtual joint"),
        ("scene.yaml", "joint_names: [stand]", "joint_names: []", "0 names, but 1 transforms"),
        ("scene.yaml", "{header: {frame_id: world}, joint", "{header: {frame_id: arm}, joint", "frame 'arm'"),
        ("scene.yaml", "child_frame_id: shelf", "child_frame_id: base_link", "frame 'base_link' is known"),
        ("scene.yaml", "[true, false]]", "[false, false]]", "must be symmetric"),
        ("scene.yaml", "[{enabled: [false, true]}, ", "[", "must be symmetric, with 2 rows"),
        ("scene.yaml", "default_entry_names: []", "default_entry_names: [arm]", "a value for each default"),
        (
            "request.yaml",
            "path_constraints: {name: '', joint_constraints: []}",
            "path_constraints: {orientation_constraints: [{}]}",
            "a path constraint",
        ),
        ("request.yaml", "{constraints: []}", "{constraints: [{}]}", "a trajectory constraint"),
        ("request.yaml", "position_constraints: []", "position_constraints: [{}]", "no configuration"),
        ("request.yaml", "max_cartesian_speed: 0", "max_cartesian_speed: 1", "Cartesian speed"),
        ("request.yaml", "factor: 0.5", "factor: 1.5", "a scaling factor outside 0 to 1"),
    ] {
        let original = fs::read_to_string(folder.path(file)).unwrap();
        let said = folder.changed(file, from, to).fault();
        assert!(said.contains(fault), "{to}\n{said}");
        folder.write(file, &original);
    }
}

#[test]
fn the_base_stands_where_either_state_has_it() {
    let folder = Folder::new();
    folder.changed("scene.yaml", "[{translation: [0, 0, 0]", "[{translation: [0.25, 0, 0]");
    assert!((place(&folder.open().unwrap()) - Vector::new(0.15, 0.0, 0.5)).norm() < 1e-12);
    let robot = folder.open().unwrap().robot;
    let world = read_moveit_scene(&folder.path("scene.yaml"), &robot).unwrap();
    let wall = world.bodies()[0].parts[0].world_from_solid.translation.vector;
    assert!((wall - Vector::new(0.15, 0.0, 0.5)).norm() < 1e-12);
    folder.changed("request.yaml", "start_state:\n", "start_state:
  multi_dof_joint_state: {joint_names: [stand], transforms: [{translation: [0.1, 0, 0], rotation: [0, 0, 0, 1]}]}\n");
    assert!((place(&folder.open().unwrap()) - Vector::new(0.3, 0.0, 0.5)).norm() < 1e-12);
    folder.changed("bot.srdf", "floating", "planar").changed("request.yaml", "[0.1, 0, 0]", "[0.1, 0, 0.2]");
    assert!(folder.fault().contains("leaves its plane"));
    folder.changed("bot.srdf", "planar", "fixed");
    assert!(folder.deviations()[0].contains("no virtual joint of its SRDF that moves"));
}

#[test]
fn the_planning_frame_is_that_of_the_virtual_joint() {
    let folder = Folder::new();
    folder.changed("bot.srdf", "parent_frame=\"world\"", "parent_frame=\"odom\"");
    assert!(folder.fault().contains("unknown frame 'world'"));
    let text = SCENE.replace("frame_id: world", "frame_id: odom");
    assert!((place(&folder.write("scene.yaml", &text).open().unwrap()).x - 0.4).abs() < 1e-12);
    // A frame that the scene fixes is where it says, whatever it is called.
    folder.write("bot.srdf", &SRDF.replace("<virtual_joint name=\"stand\" type=\"floating\" parent_frame=\"world\" child_link=\"base_link\"/>", ""));
    let text = SCENE.replace(
        "{header: {frame_id: world}, child_frame_id: shelf",
        "{header: {frame_id: base_link}, child_frame_id: world",
    );
    let text = text.replace("header: {frame_id: world}, joint_names: [stand], transforms: [{translation: [0, 0, 0], rotation: [0, 0, 0, 1]}]", "joint_names: []");
    let problem = folder.write("scene.yaml", &text).open().unwrap();
    assert!((place(&problem) - Vector::new(0.4, 0.0, 1.5)).norm() < 1e-12);
}

#[test]
fn joints_stand_where_they_can_and_each_change_is_named() {
    let folder = Folder::new();
    folder.changed(
        "scene.yaml",
        "name: [j1, j2, roll], position: [0, 0, 0]",
        "name: [j1, j2, roll], position: [0, 0, 37.7]",
    );
    let problem = folder.open().unwrap();
    assert_eq!(problem.deviations, [], "a continuous joint turns on");
    let flag = problem.robot.frames();
    let flag =
        flag.link(problem.robot.link_index("flag").unwrap()) * cranny_spatial::Point::new(1.0, 0.0, 0.0);
    assert!((flag.x - 37.7_f64.cos()).abs() < 1e-9, "{flag}");

    folder.changed(
        "request.yaml",
        "name: [j1, j2], position: [0, 0]",
        "name: [j1, j2, lower], position: [-2.00001, 0, 0.4]",
    );
    let [rounded, follows] = &folder.deviations()[..] else { panic!("{:?}", folder.deviations()) };
    assert!(follows.contains("j1' of the start is -2.00001, taken for its limit -2.00000"), "{follows}");
    assert!(rounded.contains("'lower' stands at -1.0000 instead of 0.4000"), "{rounded}");
    assert_eq!(folder.open().unwrap().start, [-2.0, 0.0]);
    folder.changed("request.yaml", "-2.00001", "-2.001");
    assert_eq!(folder.open().unwrap().start, [-2.001, 0.0], "left for the planner to refuse");

    folder.write("request.yaml", REQUEST);
    folder.changed(
        "request.yaml",
        "      - {joint_name: j2",
        "      - {joint_name: lower, position: 0.05}\n      - {joint_name: j2",
    );
    assert_eq!(folder.open().unwrap().goals, [[0.1, 0.3]]);
    folder.changed("request.yaml", "position: 0.05", "position: 0.15");
    assert!(
        folder
            .fault()
            .contains("asks joint 'lower' to be at 0.1500, but it does not move freely, and is at 0.0500")
    );
    folder.changed("request.yaml", "lower, position: 0.15", "upper, position: 0.15");
    assert!(folder.fault().contains("unknown joint 'upper'"));
}

#[test]
fn continuous_joints_of_the_group_are_turned_into_their_limits() {
    let folder = Folder::new();
    folder.changed("bot.srdf", "<joint name=\"j2\"/>", "<joint name=\"roll\"/>");
    folder.changed("request.yaml", "[j1, j2], position: [0, 0]", "[j1, j2, roll], position: [0, 0.3, 37.7]");
    folder.changed(
        "request.yaml",
        "{joint_name: j2, position: 0.3}",
        "{joint_name: roll, position: 15}\n      - {joint_name: j2, position: 0.3}",
    );
    let problem = folder.open().unwrap();
    let turn = std::f64::consts::TAU;
    assert!(
        (problem.start[1] - (37.7 - 6.0 * turn)).abs() < 1e-9
            && (problem.goals[0][1] - (15.0 - 2.0 * turn)).abs() < 1e-9
    );
    assert!(problem.deviations[0].to_string().contains("whole turns from"));
}

#[test]
fn virtual_and_passive_joints_of_a_group_are_no_error() {
    let folder = Folder::new();
    let group = "<group name=\"arm\"><joint name=\"j1\"/><joint name=\"j2\"/></group>";
    let stand = |kind: &str| SRDF.replace("floating", kind);
    for (kind, members, deviations) in [
        ("fixed", "<joint name=\"stand\"/><joint name=\"j1\"/><joint name=\"j2\"/>", 0),
        ("fixed", "<chain base_link=\"world\" tip_link=\"fore\"/>", 0),
        ("planar", "<joint name=\"stand\"/><joint name=\"j1\"/><joint name=\"j2\"/>", 1),
        ("planar", "<chain base_link=\"world\" tip_link=\"fore\"/>", 1),
    ] {
        let members = format!("<group name=\"arm\">{members}</group><passive_joint name=\"stand\"/>");
        folder.write("bot.srdf", &stand(kind).replace(group, &members));
        let problem = folder.open().unwrap();
        assert_eq!(
            (problem.robot.joint_names().len(), problem.deviations.len()),
            (2, deviations),
            "{members}"
        );
    }
    folder.write("bot.srdf", &SRDF.replace(group, &format!("{group}<passive_joint name=\"j2\"/>")));
    let problem = folder.open().unwrap();
    assert_eq!(problem.deviations, [MoveItDeviation::PassiveMoves { joint: "j2".into() }]);
    folder.changed("request.yaml", "position: 0.3", "position: 0");
    let problem = folder.open().unwrap();
    assert_eq!((problem.robot.joint_names(), &problem.goals), (&["j1".to_owned()][..], &vec![vec![0.1]]));
    folder.changed("request.yaml", "      - {joint_name: j2, position: 0}\n", "");
    assert_eq!(folder.open().unwrap().robot.joint_names(), ["j1"]);
}

#[test]
fn pairs_are_checked_as_srdf_and_matrix_have_it() {
    let folder = Folder::new();
    let disabled = |folder: &Folder| {
        let problem = folder.open().unwrap();
        let name = |link: usize| problem.robot.links()[link].name.clone();
        problem
            .robot
            .disabled_pairs()
            .iter()
            .map(|&(a, b)| format!("{} {}", name(a), name(b)))
            .collect::<Vec<_>>()
    };
    let with = |elements: &str| SRDF.replace("</robot>", &format!("{elements}</robot>"));
    folder.write("bot.srdf", &with("<disable_default_collisions link=\"flag\"/><enable_collisions link1=\"flag\" link2=\"base_link\"/>"));
    assert_eq!(disabled(&folder), ["arm flag", "fore flag", "flag slide"]);
    assert!(folder.deviations()[0].contains("'flag' may touch any object by its files"));
    folder.write(
        "bot.srdf",
        &with("<disable_collisions link1=\"base_link\" link2=\"fore\" reason=\"Never\"/>"),
    );
    assert_eq!(disabled(&folder), ["base_link fore"]);
    // The scene has the pair checked.
    folder.changed("scene.yaml", "[base_link, arm]", "[base_link, fore]");
    folder.changed(
        "scene.yaml",
        "[{enabled: [false, true]}, [true, false]]",
        "[[false, false], [false, false]]",
    );
    assert_eq!(disabled(&folder), [] as [&str; 0]);
    for (element, fault) in [
        ("<disable_collision link1=\"arm\" link2=\"fore\"/>", "unknown element `disable_collision`"),
        ("<disable_collisions link1=\"arm\" link2=\"fore\" resaon=\"\"/>", "unknown attribute `resaon`"),
        ("<group name=\"g\"><joints name=\"j1\"/></group>", "unknown element `joints`"),
        (
            "<virtual_joint name=\"v\" type=\"ball\" parent_frame=\"w\" child_link=\"arm\"/>",
            "unknown type of virtual joint `ball`",
        ),
        ("<passive_joint name=\"j3\"/>", "unknown joint `j3`"),
        ("<enable_collisions link1=\"arm\" link2=\"frore\"/>", "unknown link `frore`"),
    ] {
        let said = folder.write("bot.srdf", &with(element)).fault();
        assert!(said.contains(fault), "{said}");
    }
}

#[test]
fn limits_of_moveit_go_before_those_of_the_urdf() {
    let folder = Folder::new();
    let limits = "default_velocity_scaling_factor: 0.1
joint_limits:
  j1: {has_position_limits: true, min_position: -0.5, max_position: 2.5, has_velocity_limits: true, max_velocity: 0.4, max_acceleration: 2}
";
    for file in ["joint_limits.yaml", "config/joint_limits.yaml"] {
        folder.write(file, limits);
        let problem = folder.open().unwrap();
        let [first, second] = problem.robot.limits() else { panic!("two joints") };
        assert_eq!((first.lower, first.upper, first.acceleration), (-0.5, 2.5, Some(2.0)));
        // Of the request, which goes before the file's default.
        assert!((first.velocity - 0.2).abs() < 1e-12 && (second.velocity - 0.5).abs() < 1e-12);
        assert!(problem.deviations[0].to_string().contains("joint_limits.yaml"));
        folder.write(file, &limits.replace("max_velocity", "max_velocty"));
        assert!(
            folder.fault().contains("joint_limits.yaml:3: unknown field `max_velocty`"),
            "{}",
            folder.fault()
        );
        fs::remove_file(folder.path(file)).unwrap();
    }
    let problem = folder.open().unwrap();
    assert!((problem.robot.limits()[0].velocity - 0.5).abs() < 1e-12);
}

#[test]
fn a_mesh_of_a_package_is_found_above_the_scene() {
    let folder = Folder::new();
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    folder.write("parts/meshes/wedge.obj", obj);
    let scene = "world: {collision_objects: [{id: wedge, meshes: [{resource: 'package://parts/meshes/wedge.obj'}], mesh_poses: [{}]}]}\n";
    folder.write("scenes/scene.yaml", scene);
    assert_eq!(folder.open_scene("scenes/scene.yaml").unwrap().world.bodies()[0].name, "wedge");
}
