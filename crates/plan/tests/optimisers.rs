//! Planners that improve a curve, and what they claim.

use cranny_path::audit;
use cranny_plan::{
    ApproachRrt, Budget, Chomp, CostRange, CurveSettings, Descent, FirstCurve, Gomp, Omg, Outcome, PlanError,
    Planner, Registry, Stomp, Unobserved,
};
use cranny_task::{Goal, Problem};
use proptest::prelude::*;

use crate::fixture::{ball, block, easy, exact};

/// Names of the planners that improve a curve.
const OPTIMISERS: [&str; 4] = ["chomp", "stomp", "omg", "gomp"];

/// Number of way points of a curve whose edges reach through a thin wall.
const FEW: usize = 6;

fn run(planner: &dyn Planner, problem: &Problem, iterations: u64) -> cranny_plan::PlanReport {
    let budget = Budget { iterations, ..Budget::default() };
    planner.plan(problem, &budget, 3, &mut Unobserved).expect("a problem it can take")
}

/// Returns a problem whose start and goal lie on either side of a wall that leaves no gap.
fn behind_glass() -> Problem {
    let glass = block("glass", [0.0; 3], [1e-4, 3.0, 3.0]);
    let goal = Goal::Configurations(vec![vec![0.9, 0.0, 0.0]]);
    exact(&ball(), vec![glass], &[-0.9, 0.0, 0.0], goal)
}

#[test]
fn a_curve_through_a_thin_wall_is_claimed_and_not_proven() {
    let curve = CurveSettings { way_points: FEW, ..CurveSettings::default() };
    let range = CostRange { epsilon_m: 1e-3, ..CostRange::default() };
    let planners: [Box<dyn Planner>; 4] = [
        Box::new(Chomp { curve, range, ..Chomp::default() }),
        Box::new(Stomp { curve, range, noise: 1e-3, ..Stomp::default() }),
        Box::new(Omg { curve, range, tail: 1, ..Omg::default() }),
        Box::new(Gomp { curve, ..Gomp::default() }),
    ];
    for planner in planners {
        let name = planner.name();
        let report = run(planner.as_ref(), &behind_glass(), 30);
        assert_eq!((report.outcome, report.path.len()), (Outcome::ClaimedNotProven, 0), "{name}");
        let refused = report.refused.expect("a refused claim");
        assert_eq!(refused.pair, Some(["ball".to_owned(), "glass".to_owned()]), "{name}");
        assert!(refused.depth_m > 0.0 && refused.edge < FEW, "{name}: {refused:?}");
        assert!(refused.to_string().ends_with("mm deep at ball–glass"), "{name}: {refused}");
    }
}

#[test]
fn what_is_solved_or_never_claimed_has_no_refused_claim() {
    for name in OPTIMISERS {
        let planner = Registry::default().planner(name).expect("a planner of the registry");
        let report = run(planner.as_ref(), &easy(), 100_000);
        assert_eq!((report.outcome, report.refused), (Outcome::Solved, None), "{name}");
    }
}

#[test]
fn a_warm_start_gives_a_proven_path_and_the_same_bytes_again() {
    for name in OPTIMISERS {
        let settings = serde_json::json!({"first": "reach"});
        let settings = settings.as_object().expect("an object");
        let planner = Registry::default().planner_with(name, settings).expect("a planner");
        let problem = easy();
        let report = run(planner.as_ref(), &problem, 100_000);
        assert_eq!(report.outcome, Outcome::Solved, "{name}");
        assert!(audit(&problem, &report.path).expect("way points of the robot").valid, "{name}");
        assert_eq!(run(planner.as_ref(), &problem, 100_000).path, report.path, "{name}");
    }
}

#[test]
fn settings_that_are_no_numbers_are_refused() {
    let nan = f64::NAN;
    let planners: Vec<Box<dyn Planner>> = vec![
        Box::new(Chomp { descent: Descent { rate: nan, ..Descent::default() }, ..Chomp::default() }),
        Box::new(Chomp { range: CostRange { epsilon_m: nan, ..CostRange::default() }, ..Chomp::default() }),
        Box::new(Chomp {
            curve: CurveSettings { way_points: 4, ..CurveSettings::default() },
            ..Chomp::default()
        }),
        Box::new(Stomp { noise: nan, ..Stomp::default() }),
        Box::new(Stomp { decay: 2.0, ..Stomp::default() }),
        Box::new(Stomp { rollouts: 0, ..Stomp::default() }),
        Box::new(Omg { standoff_m: nan, ..Omg::default() }),
        Box::new(Omg { tail: 29, ..Omg::default() }),
        Box::new(Gomp { price: f64::INFINITY, ..Gomp::default() }),
        Box::new(Gomp { trust: nan, ..Gomp::default() }),
        Box::new(ApproachRrt { retreat_m: nan, ..ApproachRrt::default() }),
        Box::new(ApproachRrt { back_m: 1e-9, ..ApproachRrt::default() }),
    ];
    for planner in planners {
        let refused = planner.plan(&easy(), &Budget::default(), 0, &mut Unobserved);
        assert!(matches!(refused, Err(PlanError::Setting { .. })), "{}", planner.name());
    }
}

#[test]
fn first_curves_have_names() {
    assert_eq!(serde_json::json!(FirstCurve::Reach), "reach");
    assert_eq!(serde_json::json!(Gomp::default())["limit_use"], "acceleration");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn the_judge_proves_every_edge_that_an_optimiser_delivers(
        blocks in prop::collection::vec(prop::array::uniform3(-0.4_f64..0.4), 1..5),
        seed in 0_u64..1000,
    ) {
        let bodies = blocks.iter().enumerate().map(|(index, at)| block(&format!("block {index}"), *at, [0.12; 3]));
        let goal = Goal::Configurations(vec![vec![0.8, 0.7, 0.6]]);
        let problem = exact(&ball(), bodies.collect(), &[-0.8, -0.7, -0.6], goal);
        for name in OPTIMISERS.into_iter().chain(["approach-rrt"]) {
            let planner = Registry::default().planner(name).expect("a planner of the registry");
            let budget = Budget { iterations: 60, ..Budget::default() };
            let report = planner.plan(&problem, &budget, seed, &mut Unobserved).expect("a good problem");
            if report.outcome == Outcome::Solved {
                prop_assert!(audit(&problem, &report.path).expect("way points").valid, "{name}");
            } else {
                prop_assert!(report.path.is_empty(), "{name}");
            }
        }
    }
}
