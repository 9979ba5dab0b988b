//! Optimisation of paths by their duration.

use std::time::Duration;

use cranny_collision::Margins;
use cranny_path::{CostKind, MotionLimits, TimingMethod, Trajectory, audit};
use cranny_plan::{Budget, OptimiseSettings, Unobserved, default_planner, optimise};
use cranny_scenario::{OpenOptions, Scenario};

/// Searches are bounded by one measure, and paths are chosen by another.
#[test]
fn by_time_the_seconds_of_the_trajectory_fall() {
    let scenario = Scenario::open("021", &OpenOptions::default()).expect("a scenario");
    let problem = scenario.problem(Margins::default()).expect("a problem");
    let (planner, budget) = (default_planner(&problem), Budget { iterations: 1000, ..Budget::default() });
    let settings = OptimiseSettings {
        time: Duration::from_mins(10),
        score_weight: 0.0,
        cost: CostKind::Time,
        ..OptimiseSettings::default()
    };
    let found = optimise(planner.as_ref(), &problem, &budget, settings, 0, &mut Unobserved);
    let found = found.expect("an arm with limits");
    let costs: Vec<f64> = found.improvements.iter().map(|i| i.cost).collect();
    assert!(costs.len() > 1 && costs.windows(2).all(|pair| pair[1] < pair[0]), "{costs:?}");
    let limits = MotionLimits::of(problem.robot(), TimingMethod::TimeOptimal).expect("limits");
    let trajectory = Trajectory::along(&found.report.path, &limits).expect("a trajectory");
    assert_eq!(costs.last().map(|cost| cost.to_bits()), Some(trajectory.duration_s().to_bits()));
    assert!(audit(&problem, &found.report.path).expect("way points of the robot").valid);
}
