//! Baselines that OMPL has too: proven edges, settings, and what lazy checks save.

use cranny_path::audit;
use cranny_plan::{Budget, Est, Kpiece, LazyPrm, Outcome, PlanError, Planner, Prm, Registry, Unobserved};
use cranny_task::Goal;
use proptest::prelude::*;

use crate::fixture::{ball, block, easy, exact};

#[test]
fn settings_that_are_no_numbers_are_refused() {
    let nan = f64::NAN;
    let planners: Vec<Box<dyn Planner>> = vec![
        Box::new(Est { radius: nan, ..Est::default() }),
        Box::new(Est { samples: 0, ..Est::default() }),
        Box::new(Est { join: f64::INFINITY, ..Est::default() }),
        Box::new(Kpiece { border: nan, ..Kpiece::default() }),
        Box::new(Kpiece { failure: 1.1, ..Kpiece::default() }),
        Box::new(Kpiece { least_share: -0.1, ..Kpiece::default() }),
        Box::new(Kpiece { cell_m: 0.0, ..Kpiece::default() }),
        Box::new(Kpiece { range: nan, ..Kpiece::default() }),
        Box::new(LazyPrm { nodes: 0, ..LazyPrm::default() }),
        Box::new(LazyPrm { enhance: 0, ..LazyPrm::default() }),
    ];
    for planner in planners {
        let refused = planner.plan(&easy(), &Budget::default(), 0, &mut Unobserved);
        assert!(matches!(refused, Err(PlanError::Setting { .. })), "{}", planner.name());
    }
}

#[test]
fn a_roadmap_that_is_checked_along_its_shortest_paths_checks_less() {
    let checks = |planner: &dyn Planner| {
        let report = planner.plan(&easy(), &Budget::default(), 0, &mut Unobserved).expect("a good problem");
        assert_eq!(report.outcome, Outcome::Solved);
        (report.statistics.collision_checks - report.statistics.goals_tried, report.statistics.nodes)
    };
    let (lazy, lazy_nodes) = checks(&LazyPrm { nodes: 300, ..LazyPrm::default() });
    let (eager, _) = checks(&Prm::default());
    assert!(lazy < eager && lazy_nodes >= 300, "{lazy} and {eager} checks, {lazy_nodes} nodes");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn the_judge_proves_every_edge_of_a_baseline(
        blocks in prop::collection::vec(prop::array::uniform3(-0.4_f64..0.4), 1..5),
        seed in 0_u64..1000,
    ) {
        let bodies = blocks.iter().enumerate().map(|(index, at)| block(&format!("block {index}"), *at, [0.12; 3]));
        let goal = Goal::Configurations(vec![vec![0.8, 0.7, 0.6]]);
        let problem = exact(&ball(), bodies.collect(), &[-0.8, -0.7, -0.6], goal);
        for name in ["est", "kpiece", "lazy-prm"] {
            let planner = Registry::default().planner(name).expect("a planner of the registry");
            let budget = Budget { iterations: 3000, ..Budget::default() };
            let report = planner.plan(&problem, &budget, seed, &mut Unobserved).expect("a good problem");
            if report.outcome == Outcome::Solved {
                prop_assert!(audit(&problem, &report.path).expect("way points").valid, "{name}");
            } else {
                prop_assert!(report.path.is_empty(), "{name}");
            }
        }
    }
}
