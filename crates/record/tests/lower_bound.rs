//! Lower bound of the length of paths, on built-in scenarios.

use std::time::Duration;

use cranny_collision::Margins;
use cranny_path::CostKind;
use cranny_plan::{OptimiseSettings, Unobserved};
use cranny_scenario::{OpenOptions, Scenario};
use cranny_solve::{Request, solve};
use cranny_task::Stage;

/// No path of any seed, optimised or not, is shorter than the bound that another one states.
#[test]
fn no_path_is_shorter_than_the_bound_of_another() {
    let carry = vec![Stage::pick(), Stage::home()];
    for (id, stages) in
        [("011", vec![]), ("021", vec![]), ("021", carry), ("031", vec![]), ("041", vec![Stage::pick()])]
    {
        let scenario = Scenario::open(id, &OpenOptions::default()).unwrap();
        let problem = scenario.problem(Margins::default()).unwrap();
        let (mut greatest, mut shortest) = (0.0_f64, f64::INFINITY);
        for seed in 0..4 {
            let settings = OptimiseSettings {
                cost: CostKind::L2,
                score_weight: 0.0,
                time: Duration::MAX,
                iterations: 2000,
                ..OptimiseSettings::default()
            };
            let optimise = Some(settings).filter(|_| seed == 3);
            let request =
                Request { stages: stages.clone(), seed, optimise, least_length: true, ..Request::default() };
            let answer = solve(&problem, &request, &mut Unobserved).unwrap();
            assert!(answer.is_solved(), "{id}, seed {seed}");
            greatest = greatest.max(answer.least_length.expect("a bound"));
            shortest = shortest.min(cranny_path::path_length(&answer.waypoints()));
        }
        assert!(greatest > 0.0 && greatest <= shortest, "{id}: {greatest} above {shortest}");
    }
}
