//! Computation time of the load of a grasp, over the grasps of built-in scenarios, and of the hold along the motion that carries
//! the target home, with and without its timing: `load [ID…]`.

use std::error::Error;
use std::time::Instant;

use cranny_collision::Margins;
use cranny_grasp::{LoadMeasure, LoadState, Pads, ShakeTest};
use cranny_plan::Unobserved;
use cranny_scenario::{OpenOptions, Scenario, TargetObject, TargetPhysics};
use cranny_solve::{HoldFactors, Request, TaskTrajectory, Timing, solve};
use cranny_spatial::Vector;
use cranny_task::{Stage, StateSequence, robot_hand};

/// Number of evaluations of each grasp.
const TIMES: u32 = 20;

fn main() -> Result<(), Box<dyn Error>> {
    let given: Vec<String> = std::env::args().skip(1).collect();
    let known = ["011", "021", "031", "041"].map(str::to_owned).to_vec();
    println!("| scenario | grasps | µs a grasp | of 2 or more at rest | hold, ms | of which timing |");
    println!("|---|---|---|---|---|---|");
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
        let [hold_ms, timing_ms] = hold_ms(&scenario)?;
        println!("| {id} | {} | {each_us:.1} | {firm} | {hold_ms:.2} | {timing_ms:.2} |", grasps.len());
    }
    Ok(())
}

/// Time of the hold along the motion that carries the target home, and that of its timing, in milliseconds.
fn hold_ms(scenario: &Scenario) -> Result<[f64; 2], Box<dyn Error>> {
    let problem = scenario.problem(Margins::default())?;
    let stages = vec![Stage::pick(), Stage::home()];
    let answer = solve(&problem, &Request { stages: stages.clone(), ..Request::default() }, &mut Unobserved)?;
    let along = StateSequence::of(&problem, &stages, &answer.segments)?.ok_or("nothing is carried")?;
    let held: Vec<_> = answer.segments.iter().filter(|segment| segment.mode.holds).cloned().collect();
    let measured = |run: &mut dyn FnMut() -> Result<bool, Box<dyn Error>>| {
        let begin = Instant::now();
        for _ in 0..TIMES {
            run()?.then_some(()).ok_or("no times")?;
        }
        Ok::<_, Box<dyn Error>>(begin.elapsed().as_secs_f64() * 1e3 / f64::from(TIMES))
    };
    let timing = Timing::default();
    Ok([
        measured(&mut || Ok(HoldFactors::of(&problem, &along, &answer.segments, timing)?.is_some()))?,
        measured(&mut || Ok(TaskTrajectory::of(timing, &scenario.robot, &held)?.is_some()))?,
    ])
}
