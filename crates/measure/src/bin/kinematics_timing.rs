//! Times forward kinematics, the Jacobian and inverse kinematics of the robot of a URDF:
//! `cargo run --release -p cranny-measure --bin kinematics_timing -- ROBOT.urdf TIP [JOINT=VALUE …]`.

use std::error::Error;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use cranny_robot::{IkSearch, IkSearchSettings, Robot, RobotOptions};
use cranny_spatial::Stream;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(path), tip) = (arguments.next(), arguments.next()) else {
        return Err("usage: kinematics_timing ROBOT.urdf TIP [JOINT=VALUE …]".into());
    };
    let mut options = RobotOptions { tip, ..RobotOptions::default() };
    for argument in arguments {
        let (joint, value) = argument.split_once('=').ok_or("expected JOINT=VALUE")?;
        options.fixed.insert(joint.to_owned(), value.parse()?);
    }
    let robot = Robot::load(Path::new(&path), &options)?;
    let mut random = Stream::new(0, 0);
    let configurations: Vec<Vec<f64>> = (0..1000).map(|_| robot.random_configuration(&mut random)).collect();
    let mut frames = robot.frames();
    let mut jacobian = robot.empty_jacobian();
    println!("{}: {} links, {} joints in q", robot.name(), robot.links().len(), robot.dof());

    let rounds = 1000;
    let start = Instant::now();
    for q in configurations.iter().cycle().take(rounds * configurations.len()) {
        robot.forward_kinematics(black_box(q), &mut frames);
        black_box(&frames);
    }
    let calls = (rounds * configurations.len()) as f64;
    println!("forward kinematics, all links: {:.0} ns", start.elapsed().as_secs_f64() / calls * 1e9);

    let start = Instant::now();
    for _ in 0..rounds * configurations.len() {
        robot.jacobian(black_box(&frames), robot.tip(), &mut jacobian);
        black_box(&jacobian);
    }
    println!("Jacobian of the tip: {:.0} ns", start.elapsed().as_secs_f64() / calls * 1e9);

    let (mut attempts, mut solutions, mut iterations) = (0_usize, 0_usize, 0_usize);
    let start = Instant::now();
    for q in &configurations {
        robot.forward_kinematics(q, &mut frames);
        let mut search = IkSearch::new(&robot, frames.link(robot.tip()), IkSearchSettings::default());
        search.next_solution(&mut random, 20, &mut |_| false);
        attempts += search.attempts();
    }
    let seconds = start.elapsed().as_secs_f64();
    for q in &configurations {
        robot.forward_kinematics(q, &mut frames);
        let mut search = IkSearch::new(&robot, frames.link(robot.tip()), IkSearchSettings::default());
        for _ in 0..20 {
            let found = search.next_solution(&mut random, 1, &mut |_| true);
            solutions += usize::from(found.is_some());
            iterations += found.map_or(0, |found| found.iterations);
        }
    }
    println!(
        "inverse kinematics: {:.1} µs an attempt, {:.0} % succeed, {:.1} steps in a success",
        seconds / attempts as f64 * 1e6,
        100.0 * solutions as f64 / attempts as f64,
        iterations as f64 / solutions as f64
    );
    Ok(())
}
