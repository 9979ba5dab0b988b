//! Tasks of several stages: their plans, the statements of their files, and plans of earlier formats.

use cranny_collision::Margins;
use cranny_grasp::{Grasp, GraspSet};
use cranny_path::{AuditSettings, Violation};
use cranny_plan::{Outcome, Unobserved};
use cranny_record::{Judgement, PlanFile, PlanOptions, PlanSource, TaskSelection};
use cranny_scenario::{OpenOptions, STEPS, Scenario, sequences};
use cranny_solve::{PoseRadius, solve};
use cranny_spatial::{Pose, Vector};
use cranny_task::{Move, Pick, Stage};

fn solved(id: &str, ask: &PlanOptions) -> (Scenario, PlanFile) {
    let scenario = Scenario::open(id, &OpenOptions::default()).unwrap();
    let margins = cranny_record::margins_forgiving(&scenario, Margins::default(), ask.robust).unwrap();
    let problem = scenario.problem(margins).unwrap();
    let (request, task) = ask.request(&problem, Some(&scenario)).unwrap();
    let answer = solve(&problem, &request, &mut Unobserved).unwrap();
    assert!(answer.is_solved(), "{id}: {:?} {:?}", answer.outcome, answer.audit);
    let source = PlanSource { scenario: id.to_owned(), margins, task, ..PlanSource::default() };
    let plan = PlanFile::of(&answer, &source);
    (scenario, plan)
}

fn steps() -> PlanOptions {
    PlanOptions { task: Some(TaskSelection::Named(STEPS.to_owned())), ..PlanOptions::default() }
}

fn judged(scenario: &Scenario, plan: &PlanFile) -> Judgement {
    let source = PlanSource {
        scenario: plan.scenario.clone(),
        margins: plan.margins,
        grasps: plan.given_grasps(),
        ..PlanSource::default()
    };
    let problem = scenario.problem(plan.margins).unwrap();
    let source = plan.source_in(scenario, &source);
    plan.judge(&source, &problem, AuditSettings::default()).unwrap().unwrap()
}

#[test]
fn what_stands_in_the_way_is_put_aside_and_then_the_object() {
    for entry in sequences() {
        let (scenario, plan) = solved(entry.id, &steps());
        assert_eq!(plan.outcome, Outcome::Solved, "{}", entry.id);
        assert_eq!(plan.task, scenario.task(STEPS).unwrap().stages);
        let timing = plan.timing.as_ref().unwrap();
        let picks = plan.task.len() / 3;
        assert!(timing.duration_s > 10.0 && timing.hand_s.len() == 2 * picks);
        let judgement = judged(&scenario, &plan);
        assert!(judgement.audit.valid && judgement.differs.is_empty(), "{}: {:?}", entry.id, judgement);
        // The moved objects stand where they were put, and the robot is home.
        let after = plan.scenario_after(&scenario, &scenario.problem(Margins::default()).unwrap()).unwrap();
        assert_eq!(after.start, scenario.start);
        let moved = scenario.world.bodies().iter().zip(after.world.bodies());
        let moved = moved.filter(|(a, b)| a.parts[0].world_from_solid != b.parts[0].world_from_solid);
        assert_eq!(moved.count(), picks, "{}", entry.id);
    }
}

#[test]
fn a_file_of_several_stages_is_read_and_judged_and_lies_are_seen() {
    let (scenario, plan) = solved("213", &steps());
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("213.plan.json");
    plan.write(&file).unwrap();
    assert_eq!(PlanFile::read(&file).unwrap(), plan);
    let kinds = |plan: &PlanFile| -> Vec<&str> {
        judged(&scenario, plan).audit.violations.iter().map(Violation::kind).collect()
    };
    assert!(kinds(&plan).is_empty());
    // The columns alone: the path ends before the task does.
    let mut short = plan.clone();
    short.segments.retain(|segment| segment.stage < 6);
    assert_eq!(kinds(&short), ["goal"]);
    // Other stages than those of the named task: the columns in the other order, or another goal.
    let mut swapped = plan.clone();
    swapped.task.swap(0, 3);
    assert!(kinds(&swapped).contains(&"grip"), "the hand closes on another column");
    let mut elsewhere = plan.clone();
    elsewhere.task[1] = Stage::place("outside");
    assert!(kinds(&elsewhere).contains(&"goal"));
    let mut fewer = plan.clone();
    fewer.task.truncate(6);
    fewer.segments.retain(|segment| segment.stage < 6);
    let lies = kinds(&fewer);
    assert!(!lies.is_empty() && lies.iter().all(|kind| *kind == "statement"), "{lies:?}");
    fewer.task_name = None;
    let open = kinds(&fewer);
    assert!(!open.contains(&"goal"), "without a name its stages are what is demanded: {open:?}");
    // A grasp of a later pick, and the times of the hand.
    let mut better = plan.clone();
    better.picks[0].own_grasp.as_mut().unwrap().score = 1.0;
    assert_eq!(kinds(&better), ["grip"]);
    let mut faster = plan.clone();
    faster.timing.as_mut().unwrap().hand_s[3][1] -= 0.1;
    assert_eq!(kinds(&faster), ["statement"]);
}

#[test]
fn an_error_that_is_to_be_forgiven_is_demanded_of_every_pick() {
    let radius = PoseRadius { translation_m: 0.0005, rotation_rad: 0.001 };
    let (scenario, plan) = solved("235", &PlanOptions { robust: Some(radius), ..steps() });
    let margins = plan.task.iter().filter_map(|stage| match stage {
        Stage::Pick(Pick { object_margin_m, .. }) => *object_margin_m,
        _ => None,
    });
    let margins: Vec<f64> = margins.collect();
    assert!(margins.len() == 3 && margins.iter().all(|margin_m| *margin_m > radius.translation_m));
    assert!(judged(&scenario, &plan).audit.valid);
}

#[test]
fn another_body_becomes_the_target() {
    let scenario = Scenario::open("213", &OpenOptions::default()).unwrap();
    let own = scenario.with_target("screwdriver").unwrap();
    assert!(own.has_grasp_set && own.target == scenario.target);
    let column = scenario.with_target("column 1").unwrap();
    assert!(!column.has_grasp_set && column.grasps.is_empty());
    assert_eq!(column.world.bodies()[column.target.unwrap()].name, "column 1");
    assert_eq!(column.target_physics().mass_kg, Some(0.15));
    assert!(scenario.with_target("vase").unwrap_err().to_string().contains("vase"));
    assert!(scenario.task("tidy").unwrap_err().to_string().contains("'steps'"));
}

fn example(name: &str) -> String {
    format!("{}/../../examples/tasks/{name}", env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn objects_are_put_so_that_there_is_room_for_the_later_ones() {
    for name in ["ledge", "row", "tray"] {
        let (scenario, plan) = solved(&example(name), &steps());
        assert!(judged(&scenario, &plan).audit.valid, "{name}");
    }
}

#[test]
fn cans_and_mugs_are_carried_upright() {
    let ask = PlanOptions { place: Some("tray".to_owned()), ..PlanOptions::default() };
    for name in ["can_gap", "can_shelf", "mug_gap", "mug_shelf"] {
        let (scenario, plan) = solved(&example(name), &ask);
        assert!(judged(&scenario, &plan).audit.valid, "{name}");
        assert!(
            plan.tilt.as_ref().expect("a bound").greatest_rad <= 15_f64.to_radians(),
            "{name}: {:?}",
            plan.tilt
        );
    }
}

/// A task that begins with a motion has a single goal there. If the stages after it fail from there, they are searched again.
#[test]
fn a_first_motion_to_one_configuration_does_not_end_the_search_of_the_later_stages() {
    let stages = vec![Stage::home(), Stage::pick(), Stage::Move(Move::Clear { clear_m: 0.05 })];
    let ask = PlanOptions { task: Some(TaskSelection::Stages(stages)), ..PlanOptions::default() };
    for name in ["mug_gap", "mug_shelf"] {
        let (scenario, plan) = solved(&example(name), &ask);
        assert!(judged(&scenario, &plan).audit.valid, "{name}");
    }
}

#[test]
fn a_first_motion_before_a_pick_that_cannot_be_is_not_repeated_until_the_time_is_over() {
    let far = GraspSet::new(vec![Grasp::at(Pose::translation(9.0, 0.0, 1.0))]).unwrap();
    let scenario = Scenario { grasps: far, ..Scenario::open("021", &OpenOptions::default()).unwrap() };
    let stages = vec![Stage::home(), Stage::pick(), Stage::Move(Move::Clear { clear_m: 0.05 })];
    let ask = PlanOptions { task: Some(TaskSelection::Stages(stages)), ..PlanOptions::default() };
    let problem = scenario.problem(Margins::default()).unwrap();
    let (request, _) = ask.request(&problem, Some(&scenario)).unwrap();
    let answer = solve(&problem, &request, &mut Unobserved).unwrap();
    assert_eq!(answer.outcome, Outcome::GaveUp);
    assert!(answer.statistics.iterations < 1000, "{:?}", answer.statistics);
}

#[test]
fn an_object_is_brought_into_a_region_of_poses() {
    let ask = PlanOptions { task: Some(TaskSelection::Named("sort".to_owned())), ..PlanOptions::default() };
    let (scenario, mut plan) = solved(&example("sort"), &ask);
    assert!(judged(&scenario, &plan).audit.valid);
    let Stage::Move(Move::Regions(regions)) = &plan.task[5] else { panic!("{:?}", plan.task) };
    // The scene turns the robot by 90°.
    let middle = regions[0].frames[0].pose.translation.vector;
    assert!((middle.x - 0.5).abs() < 1e-9 && middle.y.abs() < 1e-9, "{middle}");
    let up = regions[0].in_frame(&Pose::translation(0.0, 0.0, 0.3));
    plan.task[5] = Stage::Move(Move::Regions(vec![up]));
    plan.task_name = None;
    let judged = judged(&scenario, &plan);
    assert!(judged.audit.violations.iter().any(|violation| violation.kind() == "goal"), "{judged:?}");
}

#[test]
fn the_hand_is_moved_to_a_pose_and_to_none_that_is_no_pose() {
    let scenario = Scenario::open("021", &OpenOptions::default()).unwrap();
    let to = |row: &str| serde_json::from_str::<Stage>(&format!("{{\"move\": {row}}}"));
    let stage = to(r#"{"hand": {"position": [0.4, 0.2, 0.6], "quaternion_xyzw": [1, 0, 0, 0]}}"#).unwrap();
    let ask = PlanOptions {
        task: Some(TaskSelection::Stages(vec![stage, Stage::home()])),
        ..PlanOptions::default()
    };
    let problem = scenario.problem(Margins::default()).unwrap();
    let (request, _) = ask.request(&problem, Some(&scenario)).unwrap();
    let answer = solve(&problem, &request, &mut Unobserved).unwrap();
    assert!(answer.is_solved(), "{:?}", answer.outcome);
    let robot = problem.robot();
    let there = answer.segments[0].waypoints.last().unwrap();
    let tip = *robot.frames_at(there).link(robot.tip());
    assert!((tip.translation.vector - Vector::new(0.4, 0.2, 0.6)).norm() < 1e-4, "{tip}");
    for (row, why) in [
        (r#"{"hand": {"quaternion_xyzw": [0, 0, 0, 0]}}"#, "not a rotation"),
        (r#"{"hand": {}, "object": {}}"#, "either"),
        (r#"{"hand": {}, "within_deg": 200}"#, "within_deg"),
        (r#"{"hand": {}, "within_m": [-1, 0, 0]}"#, "within_m"),
        ("\"away\"", "'away'"),
    ] {
        let error = to(row).unwrap_err().to_string();
        assert!(error.contains(why), "{row}: {error}");
    }
    let held = to(r#"{"object": {"position": [0.4, 0.2, 0.6]}}"#).unwrap();
    let ask = PlanOptions { task: Some(TaskSelection::Stages(vec![held])), ..PlanOptions::default() };
    let error = ask.request(&problem, Some(&scenario)).unwrap_err().to_string();
    assert!(error.contains("nothing is in the hand"), "{error}");
}
