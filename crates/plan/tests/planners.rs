//! Guarantees of every planner of the registry.

use std::time::Duration;

use cranny_path::audit;
use cranny_plan::{Budget, Observer, Outcome, PlanReport, Planner, Reach, Registry, Unobserved};
use cranny_task::{Goal, Problem};

use crate::fixture::{
    GANTRY_START, START, arm, ball, block, divided, easy_for, easy_grasps, exact, grasps, makes_grasps,
    out_of_reach_for, plan, still_life, walled_in_for, without_set,
};

/// Returns the names of the planners that also accept goal configurations, and that filter grasps by the hand alone.
fn take_configurations() -> Vec<&'static str> {
    Registry::default()
        .names()
        .into_iter()
        .filter(|name| !name.starts_with("j-plus") && !makes_grasps(name))
        .collect()
}

fn bits(report: &PlanReport) -> Vec<Vec<u64>> {
    report.path.iter().map(|q| q.iter().map(|value| value.to_bits()).collect()).collect()
}

/// Names of the planners released with the paper, which support its criterion.
const RELEASED: [&str; 4] = ["ik-rrt", "ik-rbt", "j-plus-rrt", "j-plus-rbt"];

fn under_paper() -> Problem {
    crate::fixture::paper(&arm(), still_life(), &START, grasps(easy_grasps()))
}

/// Returns true for a spent budget, with or without a claim that the proof refused.
fn is_spent(report: &PlanReport) -> bool {
    matches!(report.outcome, Outcome::BudgetExhausted | Outcome::ClaimedNotProven)
}

fn assert_solves(name: &str, problem: &Problem, seed: u64) -> PlanReport {
    let report = plan(name, problem, 1_000_000, seed);
    assert_eq!(report.outcome, Outcome::Solved, "{name}");
    assert_eq!(report.path[0], problem.start(), "{name}");
    let verification = audit(problem, &report.path).expect("way points of the robot");
    assert!(verification.valid, "{name}: {:?}", verification.violations);
    report
}

#[test]
fn a_solved_path_verifies() {
    for name in Registry::default().names() {
        for seed in 0..3 {
            let report = assert_solves(name, &easy_for(name), seed);
            assert!(report.path.len() > 1 && report.statistics.collision_checks > 0, "{name}");
        }
    }
}

#[test]
fn a_path_under_the_papers_criterion_verifies_by_it() {
    let problem = under_paper();
    for seed in 0..3 {
        for name in RELEASED {
            assert_solves(name, &problem, seed);
        }
    }
}

#[test]
fn under_the_papers_criterion_a_seed_gives_the_same_bytes_too() {
    for name in RELEASED {
        let run = || plan(name, &under_paper(), 100_000, 7);
        assert_eq!(run().outcome, Outcome::Solved, "{name}");
        assert_eq!(bits(&run()), bits(&run()), "{name}");
    }
}

#[test]
fn a_seed_and_a_number_of_iterations_give_the_same_bytes() {
    for name in Registry::default().names() {
        let run = |seed| plan(name, &easy_for(name), 100_000, seed);
        let (first, again) = (run(7), run(7));
        assert_eq!(first.outcome, again.outcome, "{name}");
        assert_eq!(bits(&first), bits(&again), "{name}");
        assert_eq!(first.statistics.iterations, again.statistics.iterations, "{name}");
        assert_eq!(first.statistics.nodes, again.statistics.nodes, "{name}");
        assert_eq!(first.statistics.collision_checks, again.statistics.collision_checks, "{name}");
        assert_ne!(bits(&first), bits(&run(8)), "{name}");
    }
}

#[test]
fn a_greater_budget_does_not_change_a_path_that_was_found() {
    for name in Registry::default().names() {
        let found = plan(name, &easy_for(name), u64::MAX, 7);
        let just_enough = plan(name, &easy_for(name), found.statistics.iterations + 1, 7);
        assert_eq!(bits(&found), bits(&just_enough), "{name}");
    }
}

#[test]
fn a_start_at_a_grasp_is_solved() {
    let end_of = |name| {
        let path = assert_solves(name, &easy_for(name), 0).path;
        path.last().expect("a path has way points").clone()
    };
    let problem = exact(&arm(), still_life(), &end_of("reach"), grasps(easy_grasps()));
    let without = without_set(still_life(), &end_of("grasp-reach"));
    for name in Registry::default().names() {
        assert_solves(name, if makes_grasps(name) { &without } else { &problem }, 0);
    }
}

#[test]
fn a_start_in_collision_or_outside_the_limits_is_told() {
    let mut bodies = still_life();
    bodies.push(block("rock", [START[0], 0.0, 0.3], [0.1; 3]));
    let in_rock = exact(&arm(), bodies, &START, grasps(easy_grasps()));
    let outside = exact(&arm(), still_life(), &[1.1, 1.5, 0.0, 0.0, 0.0], grasps(easy_grasps()));
    let mut bodies = still_life();
    let [x, y, z, ..] = GANTRY_START;
    bodies.push(block("rock", [x, y, z], [0.1; 3]));
    let gantry_in_rock = without_set(bodies, &GANTRY_START);
    let gantry_outside = without_set(still_life(), &[1.1, 0.0, 0.5, 0.0, 0.0, 0.0]);
    for name in Registry::default().names() {
        let own = [&gantry_in_rock, &gantry_outside];
        for problem in if makes_grasps(name) { own } else { [&in_rock, &outside] } {
            let report = plan(name, problem, 1000, 0);
            assert_eq!((report.outcome, report.path.len()), (Outcome::StartInvalid, 0), "{name}");
        }
    }
}

#[test]
fn a_hand_that_collides_at_every_grasp_is_told_apart_from_a_spent_budget() {
    for name in Registry::default().names() {
        let excluded = plan(name, &walled_in_for(name), 200, 0).outcome;
        let unreached = plan(name, &out_of_reach_for(name), 200, 0);
        assert_eq!((unreached.outcome, unreached.path.len()), (Outcome::BudgetExhausted, 0), "{name}");
        if take_configurations().contains(&name) {
            assert_eq!(excluded, Outcome::NoReachableGrasp, "{name}");
        } else {
            assert_ne!(excluded, Outcome::Solved, "{name}");
        }
    }
}

#[test]
fn iterations_are_kept_to() {
    for name in Registry::default().names() {
        for iterations in [0, 1, 33] {
            let report = plan(name, &out_of_reach_for(name), iterations, 0);
            assert_eq!(report.outcome, Outcome::BudgetExhausted, "{name}");
            assert_eq!(report.statistics.iterations, iterations, "{name}");
        }
    }
    for name in take_configurations() {
        for iterations in [1, 500] {
            let report = plan(name, &divided(), iterations, 0);
            assert!(is_spent(&report), "{name}");
            assert_eq!(report.statistics.iterations, iterations, "{name}");
        }
    }
}

#[test]
fn time_ends_a_search_that_nothing_else_would_end() {
    let allowed = Duration::from_millis(50);
    let mut cases: Vec<_> =
        Registry::default().names().into_iter().map(|name| (name, out_of_reach_for(name))).collect();
    cases.extend(take_configurations().into_iter().map(|name| (name, divided())));
    for (name, problem) in cases {
        let budget = Budget { time: allowed, ..Budget::default() };
        let report = Registry::default()
            .planner(name)
            .and_then(|planner| planner.plan(&problem, &budget, 0, &mut Unobserved))
            .expect("a problem it can take");
        assert!(is_spent(&report), "{name}");
        assert!(report.statistics.planning_time_s >= allowed.as_secs_f64(), "{name}");
    }
}

/// Observer that stops a search, and counts its reports.
#[derive(Default)]
struct Impatient {
    stop_after: u64,
    reports: u64,
    nodes: u64,
}

impl Observer for Impatient {
    fn node_added(&mut self, _tree: usize, _q: &[f64], _parent: Option<usize>) {
        self.nodes += 1;
    }

    fn progress(&mut self, _iterations: u64) {
        self.reports += 1;
    }

    fn should_stop(&self) -> bool {
        self.reports >= self.stop_after
    }
}

#[test]
fn an_observer_can_stop_a_search() {
    for name in Registry::default().names() {
        let mut observer = Impatient { stop_after: 3, ..Impatient::default() };
        let planner = Registry::default().planner(name).expect("a planner of the registry");
        let report = planner.plan(&out_of_reach_for(name), &Budget::default(), 0, &mut observer);
        let report = report.expect("a good problem");
        assert_eq!((report.outcome, report.path.len()), (Outcome::Cancelled, 0), "{name}");
        assert_eq!(observer.reports, 3, "{name}");
    }
}

#[test]
fn watching_does_not_change_a_search() {
    for name in Registry::default().names() {
        let mut observer = Impatient { stop_after: u64::MAX, ..Impatient::default() };
        let planner = Registry::default().planner(name).expect("a planner of the registry");
        let watched =
            planner.plan(&easy_for(name), &Budget::default(), 7, &mut observer).expect("a good problem");
        assert_eq!(bits(&watched), bits(&plan(name, &easy_for(name), u64::MAX, 7)), "{name}");
        assert!(observer.nodes >= watched.path.len() as u64, "{name}");
    }
}

#[test]
fn a_goal_configuration_in_collision_does_not_keep_a_planner_from_the_next() {
    let goals = [vec![0.5, 1.0, -2.6, 0.0, 0.0], vec![0.5, 2.0, -1.0, 0.5, 0.1]];
    let robot = arm();
    let frames = robot.frames_at(&goals[0]);
    let hand = frames.link(robot.tip()).translation;
    let cushion = || vec![block("cushion", [hand.x, hand.y, hand.z], [0.08; 3])];
    let to = |goals: &[Vec<f64>]| exact(&robot, cushion(), &START, Goal::Configurations(goals.to_vec()));
    for name in take_configurations() {
        let hopeless = plan(name, &to(&goals[..1]), 500, 2);
        assert_eq!(hopeless.outcome, Outcome::GoalsInvalid, "{name}");
        assert_eq!(hopeless.statistics.iterations, 0, "{name} searched for what cannot be");
        let report = assert_solves(name, &to(&goals), 2);
        assert_eq!(report.path.last(), Some(&goals[1]), "{name}");
    }
}

#[test]
fn a_way_far_from_the_box_between_start_and_goal_is_found_in_time() {
    let wall = || vec![block("wall", [0.0, -0.2, 0.0], [0.01, 1.0, 2.0])];
    let goal = Goal::Configurations(vec![vec![0.5, -0.9, 0.0]]);
    let problem = exact(&ball(), wall(), &[-0.5, -0.9, 0.0], goal);
    for detour in [0.05, 0.5] {
        let planner = Reach { detour, ..Reach::default() };
        let report = planner.plan(&problem, &Budget::default(), 3, &mut Unobserved).expect("a good problem");
        assert_eq!(report.outcome, Outcome::Solved);
        assert!(audit(&problem, &report.path).expect("way points of the robot").valid);
        let farthest = report.path.iter().map(|q| q[1]).fold(f64::NEG_INFINITY, f64::max);
        assert!(farthest > 0.8, "there is no other way: {farthest}");
    }
}

#[test]
fn every_planner_has_a_name_and_settings_for_the_record() {
    for name in Registry::default().names() {
        let planner = Registry::default().planner(name).expect("a planner of the registry");
        assert_eq!(planner.name(), name);
        assert!(planner.settings().is_object(), "{name}");
    }
}
