//! A guessed path: followed where it is free, corrected at its end, and never a reason for a false path.

use cranny_path::audit;
use cranny_plan::{Budget, Outcome, PlanError, PlanReport, Planner, Reach, Unobserved};
use cranny_task::{Goal, Problem};

use crate::fixture::{ball, block, easy_for, exact};

/// A point robot before a wall with one way around it.
fn behind_a_wall() -> Problem {
    let wall = vec![block("wall", [0.0, -0.2, 0.0], [0.01, 1.0, 2.0])];
    exact(&ball(), wall, &[-0.5, -0.9, 0.0], Goal::Configurations(vec![vec![0.5, -0.9, 0.0]]))
}

fn searched(problem: &Problem, guess: &[Vec<f64>], seed: u64) -> PlanReport {
    let planner = Reach { guess: guess.to_vec(), ..Reach::default() };
    planner.plan(problem, &Budget::default(), seed, &mut Unobserved).expect("a good problem")
}

fn assert_valid(problem: &Problem, report: &PlanReport) {
    assert_eq!(report.outcome, Outcome::Solved);
    assert_eq!(report.path[0], problem.start());
    assert!(audit(problem, &report.path).expect("way points of the robot").valid);
    assert!(report.path.windows(2).all(|edge| edge[0] != edge[1]), "{:?}", report.path);
}

#[test]
fn a_free_guess_is_the_path() {
    let problem = behind_a_wall();
    let guess = [vec![-0.5, -0.9, 0.0], vec![-0.3, 0.95, 0.0], vec![0.3, 0.95, 0.0], vec![0.5, -0.9, 0.0]];
    let report = searched(&problem, &guess, 0);
    assert_valid(&problem, &report);
    assert_eq!((&report.path[..], report.statistics.iterations), (&guess[..], 0));
    // It needs neither the start nor the goal themselves.
    let report = searched(&problem, &guess[1..3], 0);
    assert_valid(&problem, &report);
    assert_eq!((&report.path[..], report.statistics.iterations), (&guess[..], 0));
}

#[test]
fn a_guess_that_is_blocked_or_beyond_the_limits_is_where_the_search_begins() {
    let problem = behind_a_wall();
    for guess in [
        vec![vec![0.5, -0.9, 0.0]],
        vec![vec![-0.3, 0.95, 0.0], vec![0.3, -0.9, 0.0]],
        vec![vec![0.0, 0.0, 0.0], vec![0.3, 0.95, 0.0]],
        vec![vec![-1e9, 1e9, 1e9], vec![1e9, 1e9, -1e9]],
    ] {
        for seed in 0..3 {
            assert_valid(&problem, &searched(&problem, &guess, seed));
        }
    }
}

#[test]
fn the_end_of_a_guess_is_moved_to_a_grasp() {
    let problem = easy_for("reach");
    for seed in 0..4 {
        let known = searched(&problem, &[], seed);
        assert_valid(&problem, &known);
        let mut guess = known.path.clone();
        for value in guess.last_mut().expect("a path") {
            *value += 0.01;
        }
        let report = searched(&problem, &guess, seed + 10);
        assert_valid(&problem, &report);
        assert!(report.statistics.iterations <= 1, "{:?}", report.statistics);
        let apart = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let [end, expected] = [&report, &known].map(|report| report.path.last().expect("a path"));
        assert!(apart(end, expected) < 0.2, "{end:?} {expected:?}");
    }
}

#[test]
fn without_a_guess_nothing_changes_and_with_one_the_seed_decides() {
    let problem = behind_a_wall();
    let guess = [vec![0.0, 0.5, 0.0]];
    assert_eq!(searched(&problem, &guess, 3).path, searched(&problem, &guess, 3).path);
    let plain = Reach::default().plan(&problem, &Budget::default(), 3, &mut Unobserved).expect("a problem");
    assert_eq!(searched(&problem, &[], 3).path, plain.path);
}

#[test]
fn way_points_of_another_robot_are_refused() {
    let problem = behind_a_wall();
    let fault = |guess: Vec<Vec<f64>>| {
        let planner = Reach { guess, ..Reach::default() };
        let fault: Result<PlanReport, PlanError> =
            planner.check().and_then(|()| planner.plan(&problem, &Budget::default(), 0, &mut Unobserved));
        fault.expect_err("a fault").to_string()
    };
    assert!(fault(vec![vec![0.0; 2]]).contains("have 2 values, but the robot has 3 joints"));
    assert!(fault(vec![vec![0.0; 3], vec![0.0; 2]]).contains("way point 1 of 'guess'"));
    assert!(fault(vec![vec![0.0, f64::NAN, 0.0]]).contains("way point 0 of 'guess'"));
}
