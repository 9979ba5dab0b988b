//! Robot of a `MoveIt` problem: joint values, limits, and the effect of its SRDF on joints and on pairs of links.

use std::fs;

use cranny_scenario::MoveItDeviation;

use crate::moveit_folder::{Folder, REQUEST, SRDF};

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
    assert!(follows.contains("j1' of the start is -2.00001, read as its limit -2.00000"), "{follows}");
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
    // The scene requires a check of the pair.
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
        ("<enable_collisions link1=\"arm\" link2=\"frore\"/>", "unknown link `frore`"),
    ] {
        let said = folder.write("bot.srdf", &with(element)).fault();
        assert!(said.contains(fault), "{said}");
    }
    // Other elements do not affect groups and pairs, as in SRDFs for several hands and programs.
    folder.write("bot.srdf", &with("<passive_joint name=\"j3\"/><gripper><tip/></gripper>"));
    let notes = folder.open().unwrap().robot.notes().to_vec();
    assert!(notes[0].contains("element <gripper> of <robot> is not read"), "{notes:?}");
    assert!(notes[1].contains("passive_joint: unknown joint `j3`"), "{notes:?}");
}

#[test]
fn limits_of_moveit_go_before_those_of_the_urdf() {
    let folder = Folder::new();
    let limits = "default_velocity_scaling_factor: 0.1
joint_limits:
  j1: {has_position_limits: true, min_position: -0.5, max_position: 1.5, has_velocity_limits: true, max_velocity: 0.4, max_acceleration: 2}
";
    for file in ["joint_limits.yaml", "config/joint_limits.yaml"] {
        folder.write(file, limits);
        // They go before those that only Cranny reads, which stay where they state none.
        folder.write(
            "limits.yaml",
            "joints: {j1: {velocity: 0.9, acceleration: 9, jerk: 7}, j2: {acceleration: 3}}\n",
        );
        let problem = folder.open().unwrap();
        let [first, second] = problem.robot.limits() else { panic!("two joints") };
        assert_eq!((first.lower, first.upper, first.acceleration), (-0.5, 1.5, Some(2.0)));
        assert_eq!((first.jerk, second.acceleration), (Some(7.0), Some(3.0)));
        // The value of the request takes precedence over the default of the file.
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
    fs::remove_file(folder.path("limits.yaml")).unwrap();
    let problem = folder.open().unwrap();
    assert!((problem.robot.limits()[0].velocity - 0.5).abs() < 1e-12);
}
