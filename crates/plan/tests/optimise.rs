//! Guarantees of the improvement after the first path.

use std::time::Duration;

use cranny_grasp::Grasp;
use cranny_path::{CostKind, PathCost, PathError, audit};
use cranny_plan::{
    Budget, Observer, OptimiseSettings, Optimised, Outcome, PlanError, Registry, Unobserved, better,
    default_planner, optimise,
};
use cranny_task::{Goal, Problem, TaskError};
use proptest::prelude::*;

use crate::fixture::{START, arm, ball, block, easy, easy_grasps, exact, grasps, still_life, walled_in};

const FOR_EVER: Duration = Duration::from_hours(1);

fn optimised(problem: &Problem, iterations: u64, time: Duration, seed: u64) -> Optimised {
    let budget = Budget { iterations, time: FOR_EVER };
    let settings = OptimiseSettings { time, ..OptimiseSettings::default() };
    let planner = default_planner(problem);
    optimise(planner.as_ref(), problem, &budget, settings, seed, &mut Unobserved).expect("a good problem")
}

/// Returns the easy problem with scores that increase with the index of the grasp.
fn scored() -> Problem {
    let set: Vec<Grasp> = easy_grasps();
    let count = set.len() as f64;
    let score = |(index, grasp): (usize, Grasp)| Grasp { score: Some((index + 1) as f64 / count), ..grasp };
    exact(&arm(), still_life(), &START, grasps(set.into_iter().enumerate().map(score).collect()))
}

fn cost_of(problem: &Problem, path: &[Vec<f64>]) -> f64 {
    let goal = audit(problem, path).expect("way points of the robot").goal.expect("a grasp");
    let set = problem.grasps().expect("a problem of grasps");
    let weight = OptimiseSettings::default().score_weight;
    let cost = PathCost::new(problem, CostKind::Length, weight).expect("a good weight");
    cost.of(path, set.grasps()[goal.grasp].score).expect("a path")
}

/// Returns the first path, shortened, without another search.
fn first_shortened(problem: &Problem, seed: u64) -> Optimised {
    let budget = Budget { iterations: 1_000_000, time: FOR_EVER };
    let first =
        default_planner(problem).plan(problem, &budget, seed, &mut Unobserved).expect("a good problem");
    let settings = OptimiseSettings { time: FOR_EVER, idle_searches: 0, ..OptimiseSettings::default() };
    better(problem, first, settings, seed, &mut Unobserved).expect("an exact problem")
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4))]
    #[test]
    fn costs_fall_and_the_end_is_proven_and_no_worse_than_the_first_path(seed in 0u64..1000) {
        for problem in [easy(), scored()] {
            let found = optimised(&problem, 200, FOR_EVER, seed);
            prop_assert_eq!(found.report.outcome, Outcome::Solved);
            let costs: Vec<f64> = found.improvements.iter().map(|i| i.cost).collect();
            prop_assert!(costs.windows(2).all(|pair| pair[1] < pair[0]), "{:?}", costs);
            let verification = audit(&problem, &found.report.path).expect("way points of the robot");
            prop_assert!(verification.valid, "{:?}", verification.violations);
            prop_assert_eq!(cost_of(&problem, &found.report.path).to_bits(), costs[costs.len() - 1].to_bits());
            let shortened: Vec<f64> =
                first_shortened(&problem, seed).improvements.iter().map(|i| i.cost).collect();
            prop_assert!(costs.starts_with(&shortened), "{:?} {:?}", costs, shortened);
        }
    }

    #[test]
    fn the_same_iterations_give_the_same_path_and_fewer_the_same_beginning(seed in 0u64..1000) {
        let problem = scored();
        let run = |iterations| {
            let found = optimised(&problem, iterations, FOR_EVER, seed);
            let steps = found.improvements.iter().map(|i| (i.iterations, i.cost.to_bits()));
            (found.report.path, steps.collect::<Vec<_>>())
        };
        let (whole, again, part) = (run(200), run(200), run(90));
        prop_assert_eq!(&whole, &again);
        prop_assert!(whole.1.starts_with(&part.1), "{:?} {:?}", whole.1, part.1);
    }
}

#[test]
fn time_only_cuts_the_same_sequence_short() {
    let problem = scored();
    let steps = |found: &Optimised| -> Vec<(u64, u64)> {
        found.improvements.iter().map(|i| (i.iterations, i.cost.to_bits())).collect()
    };
    let whole = steps(&optimised(&problem, 300, FOR_EVER, 3));
    assert!(whole.len() > 1, "{whole:?}");
    for milliseconds in [0, 1, 5, 20] {
        let part = steps(&optimised(&problem, 300, Duration::from_millis(milliseconds), 3));
        assert!(!part.is_empty() && whole.starts_with(&part), "{part:?} {whole:?}");
    }
}

#[test]
fn a_higher_weight_of_the_score_takes_a_better_grasp() {
    let problem = scored();
    let set = problem.grasps().expect("a problem of grasps");
    let score = |score_weight: f64| {
        let budget = Budget { iterations: 400, time: FOR_EVER };
        let settings = OptimiseSettings { time: FOR_EVER, score_weight, ..OptimiseSettings::default() };
        let reach = Registry::default().planner("reach").expect("the flagship");
        let found = optimise(reach.as_ref(), &problem, &budget, settings, 1, &mut Unobserved);
        let path = found.expect("a good problem").report.path;
        let goal = audit(&problem, &path).expect("way points of the robot").goal.expect("a grasp");
        set.grasps()[goal.grasp].score.expect("a score")
    };
    assert!(score(100.0) >= score(0.0), "{} {}", score(100.0), score(0.0));
    let best = set.grasps().iter().filter_map(|g| g.score).fold(0.0, f64::max);
    assert!(score(100.0) > best / 2.0, "{}", score(100.0));
}

#[test]
fn an_arm_without_limits_has_no_time() {
    let cost = PathCost::new(&easy(), CostKind::Time, 1.0);
    assert!(matches!(cost, Err(PathError::MissingLimit { .. })), "{cost:?}");
}

/// Returns the problem of a ball and a wall that it must avoid.
fn around_a_wall() -> Problem {
    let wall = vec![block("wall", [0.0, -0.2, 0.0], [0.01, 1.0, 2.0])];
    exact(&ball(), wall, &[-0.5, -0.9, 0.0], Goal::Configurations(vec![vec![0.5, -0.9, 0.0]]))
}

#[test]
fn a_path_that_clearance_counts_for_keeps_off_what_it_need_not_touch() {
    let problem = around_a_wall();
    let nearest_m = |cost: CostKind| {
        let settings = OptimiseSettings { time: FOR_EVER, cost, ..OptimiseSettings::default() };
        let budget = Budget { iterations: 2000, time: FOR_EVER };
        let reach = Registry::default().planner("reach").expect("the flagship");
        let found = optimise(reach.as_ref(), &problem, &budget, settings, 0, &mut Unobserved);
        let judged =
            audit(&problem, &found.expect("a good problem").report.path).expect("a path of the robot");
        assert!(judged.valid);
        judged.clearance_m.expect("a wall")
    };
    let [short_m, clear_m] = [CostKind::Length, CostKind::Clearance].map(nearest_m);
    assert!(short_m < 0.005 && clear_m > 0.8 * CostKind::DESIRED_CLEARANCE_M, "{short_m} {clear_m}");
}

#[test]
fn what_lies_farther_than_is_wished_costs_its_length() {
    let problem = around_a_wall();
    let measure = |cost: CostKind, path: &[Vec<f64>]| {
        PathCost::new(&problem, cost, 0.0).expect("a good weight").measure(path).expect("a path")
    };
    let far = [vec![-0.5, -0.9, 0.0], vec![-0.5, 0.9, 0.0]];
    let [length, clearance] = [CostKind::Length, CostKind::Clearance].map(|cost| measure(cost, &far));
    assert!((length - clearance).abs() < 1e-12);
    // The ball passes the wall at half the desired clearance.
    let ball_m = problem.cell().expect("exact").world_clearance(
        &[0.0, 0.9, 0.0],
        1.0,
        &mut problem.cell().expect("exact").scratch(),
    );
    let beside = |y: f64| vec![0.0, y + 0.9 - ball_m + 0.5 * CostKind::DESIRED_CLEARANCE_M, 0.0];
    let near = [beside(0.0), {
        let mut q = beside(0.0);
        q[2] = 0.4;
        q
    }];
    let ratio = measure(CostKind::Clearance, &near) / measure(CostKind::Length, &near);
    assert!((ratio - (1.0 + 0.5 * CostKind::PENALTY)).abs() < 0.05, "{ratio}");
}

#[test]
fn without_a_first_path_there_is_nothing_to_better() {
    let found = optimised(&walled_in(), 200, FOR_EVER, 0);
    assert_ne!(found.report.outcome, Outcome::Solved);
    assert!(found.improvements.is_empty() && found.report.path.is_empty());
}

/// Observer that stops every search after the first.
struct Impatient {
    searches: u32,
}

impl Observer for Impatient {
    fn node_added(&mut self, tree: usize, _q: &[f64], parent: Option<usize>) {
        self.searches += u32::from(tree == 0 && parent.is_none());
    }

    fn should_stop(&self) -> bool {
        self.searches > 1
    }
}

#[test]
fn an_observer_that_stops_it_keeps_the_best_path() {
    let problem = easy();
    let budget = Budget { iterations: u64::MAX, time: FOR_EVER };
    let settings = OptimiseSettings { time: FOR_EVER, ..OptimiseSettings::default() };
    let reach = Registry::default().planner("reach").expect("the flagship");
    let found = optimise(reach.as_ref(), &problem, &budget, settings, 0, &mut Impatient { searches: 0 });
    let found = found.expect("a good problem");
    assert_eq!(found.report.outcome, Outcome::Solved);
    assert!(audit(&problem, &found.report.path).expect("way points of the robot").valid);
}

#[test]
fn a_detour_costs_and_a_way_point_on_the_way_does_not() {
    for kind in [CostKind::Length, CostKind::Smooth] {
        costs_a_detour_alone(&PathCost::new(&easy(), kind, 1.0).expect("a good weight"));
    }
}

fn costs_a_detour_alone(cost: &PathCost) {
    let (a, b) = (START.to_vec(), vec![0.5, -1.0, 0.3, 0.1, 0.2]);
    let middle: Vec<f64> = a.iter().zip(&b).map(|(a, b)| 0.5 * (a + b)).collect();
    let mut aside = middle.clone();
    aside[1] += 0.3;
    let length = |path: &[Vec<f64>]| cost.measure(path).expect("a path");
    let straight = length(&[a.clone(), b.clone()]);
    assert!((length(&[a.clone(), middle, b.clone()]) - straight).abs() < 1e-12);
    assert!(length(&[a.clone(), aside, b.clone()]) > straight + 1e-3);
    assert!((length(&[b, a.clone()]) - straight).abs() < 1e-12);
    assert!((cost.of(&[a], Some(0.25)).expect("a path") + 0.25).abs() < 1e-12);
}

#[test]
fn weights_that_are_none_and_the_papers_criterion_are_refused() {
    for weight in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(
            matches!(PathCost::new(&easy(), CostKind::Length, weight), Err(PathError::ScoreWeight { .. })),
            "{weight}"
        );
    }
    let problem = crate::fixture::paper(&arm(), still_life(), &START, grasps(easy_grasps()));
    let ik_rrt = Registry::default().planner("ik-rrt").expect("a baseline");
    let settings = OptimiseSettings::default();
    let refused = optimise(ik_rrt.as_ref(), &problem, &Budget::default(), settings, 0, &mut Unobserved);
    assert!(matches!(refused, Err(PlanError::Task(TaskError::Goal { .. }))));
}
