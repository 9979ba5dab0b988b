//! Roadmaps of planner `prm`: content of a file, and distrust of a wrong file.

use std::path::{Path, PathBuf};

use cranny_path::audit;
use cranny_plan::{Budget, Outcome, PlanReport, Planner, Prm, RoadmapFile, Unobserved};
use cranny_task::{Goal, Problem};

use crate::fixture::{arm, ball, block, easy, exact, still_life};

const NODES: usize = 300;

fn file(name: &str, text: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, text).expect("a folder for tests");
    path
}

fn roadmap_text(problem: &Problem) -> String {
    let roadmap = Prm::default().build(problem, NODES, 0, &mut |_| true).expect("the exact criterion");
    assert!(roadmap.len() == NODES && roadmap.edges() > NODES);
    serde_json::to_string(&roadmap).expect("numbers that have a text")
}

fn plan_with(path: &Path, problem: &Problem) -> PlanReport {
    let prm = Prm { roadmap: Some(RoadmapFile::read(path).expect("a roadmap")), ..Prm::default() };
    let budget = Budget { iterations: 3000, ..Budget::default() };
    prm.plan(problem, &budget, 0, &mut Unobserved).expect("a roadmap of this robot")
}

/// Returns a goal on the other side of the arm.
fn across() -> Goal {
    Goal::Configurations(vec![vec![0.6, -1.5, 0.4, 0.2, 0.0]])
}

#[test]
fn a_question_is_answered_from_the_file_without_a_new_node() {
    let problem = easy().with_goal(across()).expect("a configuration of the robot");
    let path = file("easy.roadmap.json", &roadmap_text(&problem));
    let (with, again) = (plan_with(&path, &problem), plan_with(&path, &problem));
    assert_eq!(with.outcome, Outcome::Solved);
    assert_eq!(with.path, again.path);
    assert_eq!((with.statistics.iterations, with.statistics.nodes), (1, NODES as u64 + 2));
    assert!(audit(&problem, &with.path).expect("way points of the robot").valid);
}

#[test]
fn a_roadmap_of_another_world_costs_no_truth() {
    let path = file("other_world.roadmap.json", &roadmap_text(&easy()));
    let mut bodies = still_life();
    bodies.push(block("pillar", [0.0, 0.45, 0.3], [0.05, 0.05, 0.6]));
    let start = easy().start().to_vec();
    let problem = exact(&arm(), bodies, &start, across());
    let report = plan_with(&path, &problem);
    assert_eq!(report.outcome, Outcome::Solved);
    assert!(audit(&problem, &report.path).expect("way points of the robot").valid);
}

#[test]
fn what_is_no_roadmap_of_the_robot_is_refused_by_name_and_place() {
    let text = roadmap_text(&easy());
    let fault = |name: &str, text: &str, problem: &Problem| {
        let path = file(name, text);
        let read = RoadmapFile::read(&path);
        let planned = read.and_then(|file| {
            let prm = Prm { roadmap: Some(file), ..Prm::default() };
            prm.plan(problem, &Budget::default(), 0, &mut Unobserved)
        });
        let message = planned.expect_err("a fault").to_string();
        assert!(message.contains(name), "{message}");
        message
    };
    let easy = easy();
    let rolling = exact(&ball(), Vec::new(), &[0.0; 3], Goal::Configurations(vec![vec![0.1; 3]]));
    assert!(fault("robot.json", &text, &rolling).contains("joints"));
    assert!(fault("cut.json", &text[..text.len() / 2], &easy).contains("line 1"));
    assert!(
        fault("word.json", &text.replace("cranny-roadmap/1", "cranny-roadmap/9"), &easy).contains("format")
    );
    assert!(
        fault("edge.json", &text.replace("\"edges\":[[", "\"edges\":[[7,999999],["), &easy)
            .contains("999999")
    );
    assert!(
        fault("node.json", &text.replace("\"nodes\":[[", "\"nodes\":[[1e300,0,0,0,0],["), &easy)
            .contains("node 0")
    );
    let missing = RoadmapFile::read(Path::new("no/such.json")).expect_err("no file").to_string();
    assert!(missing.contains("no/such.json"), "{missing}");
}
