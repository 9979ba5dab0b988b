//! Corners that are cut: proven free, within every limit, faster than stops.

use cranny_collision::Margins;
use cranny_path::{MotionLimits, PathError, TimingMethod, Trajectory};
use cranny_plan::{Budget, Unobserved, default_planner};
use cranny_scenario::{OpenOptions, Scenario};

/// Every sample must be free, with the margins that were demanded.
#[test]
fn a_blended_trajectory_is_free_and_keeps_every_limit_at_1_khz() {
    for (id, margin_m) in [("021", 0.0), ("023", 0.0), ("023", 0.005), ("025", 0.0)] {
        let scenario = Scenario::open(id, &OpenOptions::default()).expect("a scenario");
        let demands = Margins { margin_m, grasp_margin_m: 0.0, ..Margins::default() };
        let problem = scenario.problem(demands).expect("a problem");
        let cell = problem.cell().expect("exact is the default");
        let limits = MotionLimits::of(problem.robot(), TimingMethod::TimeOptimal).expect("limits");
        let planner = default_planner(&problem);
        for seed in 0..3 {
            let budget = Budget::default();
            let report = planner.plan(&problem, &budget, seed, &mut Unobserved).expect("a problem to plan");
            let stopping = Trajectory::along(&report.path, &limits).expect("a trajectory");
            let blended = Trajectory::blended(&report.path, &limits, cell).expect("a trajectory");
            assert!(blended.is_blended() && blended.duration_s() < stopping.duration_s());
            let mut scratch = cell.scratch();
            for sample in blended.samples(1000.0).expect("samples") {
                assert!(cell.is_free(&sample.position, &mut scratch), "{id} {seed} at {} s", sample.time_s);
                for (joint, limits) in problem.robot().limits().iter().enumerate() {
                    assert!(sample.velocity[joint].abs() <= limits.velocity);
                    assert!(sample.acceleration[joint].abs() <= limits.acceleration.expect("known"));
                }
            }
        }
        let smooth = MotionLimits::of(problem.robot(), TimingMethod::JerkLimited).expect("limits");
        let refused = Trajectory::blended(&[problem.start().to_vec()], &smooth, cell);
        assert!(matches!(refused, Err(PathError::BlendedJerk)));
    }
}
