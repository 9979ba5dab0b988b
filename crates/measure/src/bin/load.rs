//! Computation time of the load of a grasp, over the grasps of built-in scenarios: `load [ID…]`.

use std::error::Error;
use std::time::Instant;

use cranny_grasp::{LoadMeasure, LoadState, Pads, ShakeTest};
use cranny_scenario::{OpenOptions, Scenario, TargetObject, TargetPhysics};
use cranny_spatial::Vector;
use cranny_task::robot_hand;

/// Number of evaluations of each grasp.
const TIMES: u32 = 20;

fn main() -> Result<(), Box<dyn Error>> {
    let given: Vec<String> = std::env::args().skip(1).collect();
    let known = ["011", "021", "031", "041"].map(str::to_owned).to_vec();
    println!("| scenario | grasps | µs a grasp | of 2 or more at rest |\n|---|---|---|---|");
    for id in if given.is_empty() { known } else { given } {
        let scenario = Scenario::open(&id, &OpenOptions::default())?;
        let found = scenario.target_object(&TargetPhysics::default())?.ok_or("no target")?;
        let TargetObject { object, world_from_object } = found;
        let hand = robot_hand(&scenario.robot);
        let (held, pads) = object.held().zip(Pads::of(&hand)).ok_or("nothing to hold, or no pads")?;
        let up = world_from_object.rotation.inverse() * Vector::z();
        let states = LoadState::along(&ShakeTest::default());
        let measure = LoadMeasure::new(held, pads, hand.closing_force_n, up, states);
        let grasps = scenario.grasps.moved(&world_from_object.inverse());
        let begin = Instant::now();
        let mut firm = 0;
        for _ in 0..TIMES {
            let loads = grasps.grasps().iter().map(|grasp| measure.of(&grasp.world_from_gripper).at_rest);
            firm = loads.filter(|load| *load >= 2.0).count();
        }
        let each_us = begin.elapsed().as_secs_f64() * 1e6 / f64::from(TIMES) / grasps.len().max(1) as f64;
        println!("| {id} | {} | {each_us:.1} | {firm} |", grasps.len());
    }
    Ok(())
}
