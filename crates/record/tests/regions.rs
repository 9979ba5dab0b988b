//! Regions of a `scenario.yaml` as goals: plans end in them, audits check that, and they are written again.

use std::fs;
use std::path::{Path, PathBuf};

use cranny_collision::Margins;
use cranny_path::AuditSettings;
use cranny_plan::{Outcome, Unobserved};
use cranny_record::{PlanFile, PlanOptions, PlanSource};
use cranny_scenario::{OpenOptions, Scenario};
use cranny_solve::solve;
use cranny_task::{Move, Region, Stage};

const REGIONS: &str = "regions:
  over the table:
    frames:
      - pose: {position: [1, 0.6, 0.75]}
        x: [-0.2, 0.2]
        y: [-0.1, 0.1]
        yaw_deg: [-180, 180]
        end: {rotation_rpy_deg: [180, 0, 0]}
  beside:
    frames:
      - pose: {position: [1, 0.6, 0.9]}
        yaw_deg: [-180, 180]
        end: {position: [-0.12, 0, 0], rotation_rpy_deg: [0, 90, 0]}
  point: {hand: {position: [1, 0.5, 1], rotation_rpy_deg: [180, 0, 0]}, within_deg: 60}
  sky: {hand: {position: [1, 0.5, 9]}}
";

/// Creates scenario 021 with regions, in a folder.
fn folder() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("021");
    Scenario::open("021", &OpenOptions::default()).unwrap().write_folder(&path).unwrap();
    let file = path.join("scenario.yaml");
    let text = fs::read_to_string(&file).unwrap();
    fs::write(&file, format!("{text}{REGIONS}")).unwrap();
    (folder, path)
}

fn opened(path: &Path) -> Scenario {
    Scenario::open(path.to_str().unwrap(), &OpenOptions::default()).unwrap()
}

fn options(names: &[&str]) -> PlanOptions {
    let names = names.iter().map(|name| (*name).to_owned()).collect();
    PlanOptions { goal_region: Some(Move::NamedRegions(names)), ..PlanOptions::default() }
}

#[test]
fn a_plan_ends_in_a_region_and_a_file_that_ends_elsewhere_is_refused() {
    let (_folder, path) = folder();
    let scenario = opened(&path);
    let problem = scenario.problem(Margins::default()).unwrap();
    let robot = problem.robot();
    let source = PlanSource { scenario: "021".to_owned(), ..PlanSource::default() };
    // The half turn of a hand, which is as good at a grasp, is none of `beside`.
    let beside = (0..6).map(|seed| (vec!["beside"], None, seed));
    for (names, planner, seed) in [
        (vec!["over the table"], None, 0),
        (vec!["point", "over the table"], Some("rrt-connect"), 0),
        (vec!["point"], Some("cbirrt2"), 0),
        (vec!["beside"], Some("cbirrt2"), 0),
    ]
    .into_iter()
    .chain(beside)
    {
        let options = PlanOptions { planner: planner.map(str::to_owned), seed, ..options(&names) };
        let (request, _) = options.request(&problem, Some(&scenario)).unwrap();
        let answer = solve(&problem, &request, &mut Unobserved).unwrap();
        assert!(answer.is_valid(), "{names:?}");
        let plan = PlanFile::of(&answer, &source);
        let pose = *robot.frames_at(plan.waypoints.last().unwrap()).link(robot.tip());
        assert!(names.iter().any(|name| scenario.regions[*name].off(&pose).is_exact()), "{names:?}");
        let other = scenario.start.clone();
        let mut elsewhere = answer.segments.clone();
        elsewhere[0].waypoints = vec![other.clone(), other];
        let audit =
            cranny_path::audit_task(&problem, &request.stages, &elsewhere, AuditSettings::default()).unwrap();
        assert!(!audit.valid);
    }
}

#[test]
fn regions_that_are_out_of_reach_or_unknown_are_distinct() {
    let (_folder, path) = folder();
    let scenario = opened(&path);
    let problem = scenario.problem(Margins::default()).unwrap();
    let (request, _) = options(&["sky"]).request(&problem, Some(&scenario)).unwrap();
    assert_eq!(solve(&problem, &request, &mut Unobserved).unwrap().outcome, Outcome::RegionOutOfReach);
    let unknown = options(&["moon"]).request(&problem, Some(&scenario)).unwrap_err().to_string();
    assert!(unknown.contains("unknown region 'moon'") && unknown.contains("'over the table'"), "{unknown}");
    let stages = vec![Stage::Move(Move::NamedRegions(Vec::new()))];
    let fault = Stage::check_all(&stages, &problem).unwrap_err().to_string();
    assert!(fault.contains("no region"), "{fault}");
}

#[test]
fn regions_are_written_with_the_scenario() {
    let (folder, path) = folder();
    let scenario = opened(&path);
    let again = folder.path().join("again");
    scenario.write_folder(&again).unwrap();
    let again = opened(&again);
    assert_eq!(scenario.regions.len(), 4);
    for (name, region) in &scenario.regions {
        let other: &Region = &again.regions[name];
        let pose = region.draw(&mut cranny_spatial::Stream::new(4, 0));
        assert!(other.off(&pose).is_exact(), "{name}");
    }
}

#[test]
fn a_scenario_with_a_region_needs_neither_target_nor_grasps() {
    let hover = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/tutorial/hover");
    assert_eq!(cranny_scenario::check_folder(&hover).unwrap().len(), 0);
    let scenario = opened(&hover);
    let problem = scenario.problem(Margins::default()).unwrap();
    let (request, _) = options(&["above the table"]).request(&problem, Some(&scenario)).unwrap();
    assert!(solve(&problem, &request, &mut Unobserved).unwrap().is_valid());
    let without = PlanOptions::default().request(&problem, Some(&scenario)).unwrap().0;
    let fault = solve(&problem, &without, &mut Unobserved).unwrap_err().to_string();
    assert!(fault.contains("cranny plan --goal-region"), "{fault}");
}
