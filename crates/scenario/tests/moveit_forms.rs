//! Forms of `MoveIt` scenes and requests: each is read correctly or refused by name; nothing is ignored.

use std::fs;
use std::time::Duration;

use cranny_collision::ToolRegion;
use cranny_scenario::{MoveItDeviation, MoveItProblem, MoveItRobot, moveit_document, read_moveit_scene};
use cranny_spatial::Vector;

use crate::moveit_folder::{Folder, REQUEST, SCENE, SRDF};

/// Returns scene and request of a folder as one document.
fn document(folder: &Folder) -> serde_json::Value {
    let read = |file: &str| {
        let text = fs::read_to_string(folder.path(file)).unwrap();
        moveit_document(&text).unwrap_or_else(|fault| panic!("{text}\n{fault}"))
    };
    serde_json::json!({"planning_scene": read("scene.yaml"), "motion_plan_request": read("request.yaml")})
}

#[test]
fn messages_in_memory_are_read_like_files() {
    let folder = Folder::new();
    let mut robot = MoveItRobot::open(&folder.path("bot.urdf"), None).unwrap();
    assert_eq!((robot.name(), robot.srdf().groups[0].name.as_str()), ("bot", "arm"));
    let of_files = folder.open().unwrap();
    for _ in 0..2 {
        let of_memory = MoveItProblem::of_document(document(&folder), &mut robot).unwrap();
        assert_eq!((of_memory.group.as_str(), of_memory.allowed_time), ("arm", Some(Duration::from_secs(5))));
        assert_eq!((&of_memory.start, &of_memory.goals), (&of_files.start, &of_files.goals));
        assert_eq!(of_memory.deviations, of_files.deviations);
        assert_eq!(of_memory.robot.limits(), of_files.robot.limits());
        assert_eq!(format!("{:?}", of_memory.world.bodies()), format!("{:?}", of_files.world.bodies()));
    }
    // Every fault in a file has a location in memory: the entry.
    let mut wrong = document(&folder);
    wrong["motion_plan_request"]["goal_constraints"][0]["joint_constraints"][1]["joint_name"] = "j9".into();
    let fault = MoveItProblem::of_document(wrong, &mut robot).unwrap_err().to_string();
    let entry = "motion_plan_request.goal_constraints[0].joint_constraints[1].joint_name: ";
    assert!(fault.starts_with(entry) && fault.contains("j9"), "{fault}");
    // A relative name of a mesh would depend on the folder of the process.
    let mut wrong = document(&folder);
    wrong["planning_scene"]["world"] = serde_json::json!({"collision_objects": [
        {"id": "cup", "pose": {}, "meshes": [{"resource": "cup.stl"}]},
    ]});
    let fault = MoveItProblem::of_document(wrong, &mut robot).unwrap_err().to_string();
    assert!(fault.starts_with("planning_scene.world.collision_objects[0].meshes[0]: "), "{fault}");
    let fault = folder.changed("request.yaml", "planning_time: 5", "planning_time: -1").fault();
    assert!(fault.contains("an invalid planning time"), "{fault}");
}

/// Returns the position of the first body, in the root frame.
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

/// Returns the offsets of the ends of the keys of a text, each before its `:`.
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
            // A value without effect on the problem may have any keys.
            let passed = [
                "  type: {",
                "object_colors: [",
                "polygon: {",
                "workspace_parameters: {",
                "effort: [], header: {",
            ];
            if passed.iter().any(|passed| line.contains(passed)) {
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
fn path_constraints_that_cannot_be_kept_are_refused_by_name() {
    let folder = Folder::new();
    for (constraints, fault) in [
        ("{orientation_constraints: [{}]}", "missing field `link_name`"),
        ("{visibility_constraints: [{}]}", "a visibility constraint"),
        (
            "{position_constraints: [{link_name: thumb, constraint_region: {primitives: [{type: 1, dimensions: [1, 1, 1]}]}}]}",
            "a link that the robot does not have",
        ),
        (
            "{position_constraints: [{link_name: fore, constraint_region: {primitives: [{type: 3, dimensions: [1, 1]}], primitive_poses: [{}]}}]}",
            "no box of three dimensions and no sphere of one",
        ),
        (
            "{position_constraints: [{link_name: fore, constraint_region: {primitives: [{type: 2, dimensions: [-1]}], primitive_poses: [{}]}}]}",
            "a dimension that is not positive",
        ),
        (
            "{position_constraints: [{link_name: fore, constraint_region: {primitives: []}}]}",
            "whose region is not one primitive",
        ),
        (
            "{orientation_constraints: [{link_name: fore, absolute_x_axis_tolerance: 0.1, absolute_y_axis_tolerance: 0, absolute_z_axis_tolerance: 3}]}",
            "an axis tolerance of 0",
        ),
        (
            "{orientation_constraints: [{link_name: fore, absolute_x_axis_tolerance: 0.1, absolute_y_axis_tolerance: 0.1, absolute_z_axis_tolerance: 3, parameterization: 7}]}",
            "an unknown parameterization",
        ),
        ("{joint_constraints: [{joint_name: j9, position: 0}]}", "j9"),
        (
            "{joint_constraints: [{joint_name: j1, position: 0, tolerance_above: -1}]}",
            "a tolerance that is no finite number of at least 0",
        ),
        (
            "{joint_constraints: [{joint_name: j1, position: 99, tolerance_above: 1}]}",
            "no value within the joint's limits keeps",
        ),
    ] {
        let request = REQUEST.replace("{name: '', joint_constraints: []}", constraints);
        let said = folder.write("request.yaml", &request).fault();
        assert!(said.contains(fault), "{constraints}\n{said}");
    }
}

#[test]
fn what_a_message_holds_and_is_not_read_is_refused_by_name() {
    let folder = Folder::new();
    for (file, from, to, fault) in [
        ("scene.yaml", "data: []", "data: [1, 2]", "an octomap with probabilities is not supported"),
        ("scene.yaml", "planes: []", "planes: [{coef: [0, 0, 1, 0]}]", "a plane"),
        ("scene.yaml", "type: box", "type: 5", "unknown primitive 'prism'"),
        ("scene.yaml", "operation: 0", "operation: 2", "a change to an object"),
        ("scene.yaml", "operation: 0", "operation: remove", "a change to an object"),
        ("scene.yaml", "scale: 1", "scale: 1.1", "padding or scaling"),
        ("scene.yaml", "attached_collision_objects: []", "attached_collision_objects: [{}]", "an attached"),
        ("scene.yaml", "joint_names: [stand]", "joint_names: [stnd]", "'stnd' is no virtual joint"),
        ("scene.yaml", "joint_names: [stand]", "joint_names: []", "0 names, but 1 transforms"),
        ("scene.yaml", "{header: {frame_id: world}, joint", "{header: {frame_id: arm}, joint", "frame 'arm'"),
        (
            "scene.yaml",
            "child_frame_id: shelf",
            "child_frame_id: base_link",
            "frame 'base_link' is already known",
        ),
        ("scene.yaml", "[true, false]]", "[false, false]]", "must be symmetric"),
        ("scene.yaml", "[{enabled: [false, true]}, ", "[", "must be symmetric, with 2 rows"),
        ("scene.yaml", "default_entry_names: []", "default_entry_names: [arm]", "a value for each default"),
        ("request.yaml", "{constraints: []}", "{constraints: [{}]}", "a trajectory constraint"),
        (
            "request.yaml",
            "position_constraints: []",
            "position_constraints: [{link_name: fore, constraint_region: {}}]",
            "no configuration",
        ),
        (
            "request.yaml",
            "max_cartesian_speed: 0",
            "max_cartesian_speed: -1",
            "an invalid limit of Cartesian speed",
        ),
        (
            "request.yaml",
            "limited_link: ''\nmax_cartesian_speed: 0",
            "limited_link: arm\nmax_cartesian_speed: 1",
            "that is not the tip",
        ),
        ("request.yaml", "factor: 0.5", "factor: 1.5", "a scaling factor outside 0 to 1"),
    ] {
        let original = fs::read_to_string(folder.path(file)).unwrap();
        let said = folder.changed(file, from, to).fault();
        assert!(said.contains(fault), "{to}\n{said}");
        folder.write(file, &original);
    }
}

#[test]
fn a_joint_that_the_path_constraints_hold_has_their_limits() {
    let folder = Folder::new();
    let free = folder.open().unwrap().robot.limits()[1];
    folder.changed(
        "request.yaml",
        "joint_constraints: []}",
        "joint_constraints: [{joint_name: j1, position: 0.1, tolerance_above: 0.2, tolerance_below: 0.3}]}",
    );
    let robot = folder.open().unwrap().robot;
    let held = robot.limits()[0];
    assert!((held.lower + 0.2).abs() < 1e-12 && (held.upper - 0.3).abs() < 1e-12, "{held:?}");
    assert_eq!(robot.limits()[1], free);
    assert!(robot.within_limits(&[0.29, 0.0]) && !robot.within_limits(&[0.31, 0.0]));
}

#[test]
fn constraints_on_the_pose_of_the_tip_are_bounds_of_the_tool() {
    let folder = Folder::new();
    folder.changed(
        "request.yaml",
        "path_constraints: {name: '', joint_constraints: []}",
        "path_constraints:
  position_constraints:
    - header: {frame_id: shelf}
      link_name: flag
      target_point_offset: {x: 0.1, y: 0, z: 0}
      constraint_region:
        primitives: [{type: 1, dimensions: [0.2, 0.4, 0.6]}]
        primitive_poses: [{position: [1, 2, 3], orientation: [0, 0, 0, 1]}]
  orientation_constraints:
    - {link_name: fore, orientation: [0, 0, 0, 1], absolute_x_axis_tolerance: 0.2, absolute_y_axis_tolerance: 0.1,
       absolute_z_axis_tolerance: 3.2}",
    );
    folder.changed("request.yaml", "max_cartesian_speed: 0", "max_cartesian_speed: 0.3");
    let problem = folder.open().unwrap();
    assert_eq!(problem.tool_speed_m_s, Some(0.3));
    let [position, orientation] = problem.world.tool_bounds() else {
        panic!("{:?}", problem.world.tool_bounds())
    };
    let ToolRegion::Box { point_in_link, world_from_box, half_m } = &position.region else {
        panic!("{position:?}")
    };
    // The shelf is 1 m above the world origin.
    assert!((point_in_link.coords - Vector::new(0.1, 0.0, 0.0)).norm() < 1e-12, "{point_in_link}");
    assert_eq!(position.link.as_deref(), Some("flag"));
    assert!((world_from_box.translation.vector - Vector::new(1.0, 2.0, 4.0)).norm() < 1e-12);
    assert!((half_m - Vector::new(0.1, 0.2, 0.3)).norm() < 1e-12);
    let ToolRegion::Cone { axis_in_link, toward, most_rad } = &orientation.region else {
        panic!("{orientation:?}")
    };
    assert!((axis_in_link - Vector::z()).norm() < 1e-12 && (toward - Vector::z()).norm() < 1e-12);
    assert!((most_rad - 0.1).abs() < 1e-12);
    assert!(folder.deviations().iter().any(|deviation| deviation.contains("kept in cones")));
}

#[test]
fn an_operation_is_a_number_a_byte_or_a_name() {
    let folder = Folder::new();
    for (operation, is_addition) in [
        ("0", true),
        ("ADD", true),
        ("\"\\0\"", true),
        ("!!binary AA==", true),
        ("null", true),
        ("1", false),
        ("\"\\x01\"", false),
        ("!!binary Ag==", false),
        ("addition", false),
    ] {
        let scene = SCENE.replace("operation: 0", &format!("operation: {operation}"));
        assert_eq!(folder.write("scene.yaml", &scene).open().is_ok(), is_addition, "{operation}");
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
    assert!(folder.deviations()[0].contains("not a movable virtual joint of its SRDF"));
}

#[test]
fn the_planning_frame_is_that_of_the_virtual_joint() {
    let folder = Folder::new();
    folder.changed("bot.srdf", "parent_frame=\"world\"", "parent_frame=\"odom\"");
    assert!(folder.fault().contains("unknown frame 'world'"));
    let text = SCENE.replace("frame_id: world", "frame_id: odom");
    assert!((place(&folder.write("scene.yaml", &text).open().unwrap()).x - 0.4).abs() < 1e-12);
    // A frame that the scene fixes has the pose given by the scene, also if it is named like the planning frame.
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
fn a_mesh_of_a_package_is_found_above_the_scene() {
    let folder = Folder::new();
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    folder.write("parts/meshes/wedge.obj", obj);
    let scene = "world: {collision_objects: [{id: wedge, meshes: [{resource: 'package://parts/meshes/wedge.obj'}], mesh_poses: [{}]}]}\n";
    folder.write("scenes/scene.yaml", scene);
    assert_eq!(folder.open_scene("scenes/scene.yaml").unwrap().world.bodies()[0].name, "wedge");
}
