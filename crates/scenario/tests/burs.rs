//! Motions that a bubble certifies as free are also proven free without bubbles, among real shapes.

use cranny_collision::{Margins, Motion};
use cranny_robot::between;
use cranny_scenario::{OpenOptions, Scenario};
use cranny_spatial::Stream;

/// Number of free configurations in a scenario, and of spines of each bur.
const BURS: usize = 100;
const SPINES: usize = 7;

#[test]
fn every_spine_of_a_bur_is_proven_again_by_the_judge() {
    for id in ["011", "021", "035", "044"] {
        let scenario = Scenario::open(id, &OpenOptions::default()).unwrap();
        let problem = scenario.problem(Margins::default()).unwrap();
        let cell = problem.cell().unwrap();
        let (mut scratch, mut random) = (cell.scratch(), Stream::new(0, 0));
        let robot = cell.robot();
        let (mut burs, mut total) = (0, 0.0);
        while burs < BURS {
            let q = robot.random_configuration(&mut random);
            if !cell.is_free(&q, &mut scratch) {
                continue;
            }
            let Some(bubble) = cell.bubble(&q, 0.01, &mut scratch) else { continue };
            burs += 1;
            for _ in 0..SPINES {
                let target = robot.random_configuration(&mut random);
                let share = cell.free_share(&bubble, &target, &mut scratch);
                let end: Vec<f64> = between(&q, &target, share).collect();
                assert_eq!(cell.motion_is_free(&q, &end, &mut scratch), Motion::Proven, "{id}");
                total += share;
            }
        }
        // Spines of length zero would be proven too.
        let mean = total / (BURS * SPINES) as f64;
        assert!(mean > 0.02, "{id}: a spine is {mean} of the way");
    }
}
