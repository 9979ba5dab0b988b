//! What carrying the target home takes, and which grasps allow it; one thread.
//!
//! `carrying plans SEEDS MARGIN_MM GRASP_MARGIN_MM SCENARIO…`: for each scenario how many tasks are solved, judged and
//! done within 2 s, and median, mean, 95th percentile and maximum of `planning_time_s`: reach, closing, lift-off and the way
//! home with their proofs.
//!
//! `carrying grasps SCENARIO…`: of all grasps, each for itself, how many can be reached within so many iterations, with how
//! many of those the target can be carried home, and what stops the others.
//!
//! `carrying holds SCENARIO…`: how long another hold takes, and room to ask with it, in microseconds.
//!
//! `cargo run --release -p cranny-measure --bin carrying -- plans 100 0 0 SCENARIO…`

use std::collections::BTreeMap;
use std::hint::black_box;
use std::time::{Duration, Instant};

use cranny_collision::Margins;
use cranny_grasp::GraspSet;
use cranny_plan::{Budget, Carrier, FailureReason, Goal, LiftOffSettings, Outcome, Problem, Unobserved};
use cranny_scenario::{OpenOptions, Scenario};
use cranny_solve::{Carry, Request, solve};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match &words[..] {
        ["plans", seeds, margin, grasp_margin, scenarios @ ..] => {
            let metres = |text: &str| text.parse::<f64>().expect("a number of millimetres") / 1e3;
            let margins = Margins {
                margin_m: metres(margin),
                grasp_margin_m: metres(grasp_margin),
                ..Margins::default()
            };
            plans(seeds.parse().expect("a number of seeds"), margins, scenarios);
        }
        ["grasps", scenarios @ ..] => grasps(scenarios),
        ["holds", scenarios @ ..] => holds(scenarios),
        _ => {
            eprintln!(
                "usage: carrying plans SEEDS MARGIN_MM GRASP_MARGIN_MM SCENARIO…, carrying grasps|holds SCENARIO…"
            );
            std::process::exit(2);
        }
    }
}

fn opened(scenario: &str, margins: Margins) -> (String, Problem) {
    let scenario = Scenario::open(scenario, &OpenOptions::default()).expect("a scenario");
    let problem = scenario.problem(margins).expect("a problem");
    (scenario.id, problem)
}

fn plans(seeds: u64, margins: Margins, scenarios: &[&str]) {
    println!("| scenario | solved | judged valid | over 2 s | median ms | mean | 95 % | max |");
    println!("|---|---|---|---|---|---|---|---|");
    for scenario in scenarios {
        let (id, problem) = opened(scenario, margins);
        let (mut times_ms, mut solved, mut valid) = (Vec::new(), 0, 0);
        for seed in 0..seeds {
            let budget = Budget { time: Duration::from_secs(10), ..Budget::default() };
            let request = Request { seed, budget, carry: Some(Carry::default()), ..Request::default() };
            let answer = solve(&problem, &request, &mut Unobserved).expect("a good problem");
            solved += u64::from(answer.outcome == Outcome::Solved);
            valid += u64::from(answer.is_solved());
            times_ms.push(answer.statistics.planning_time_s * 1e3);
        }
        times_ms.sort_unstable_by(f64::total_cmp);
        let quantile = |share: f64| {
            let rank = (share * (times_ms.len() - 1) as f64).round();
            times_ms.iter().zip(0_u32..).find(|(_, index)| f64::from(*index) >= rank).map_or(0.0, |(t, _)| *t)
        };
        let mean = times_ms.iter().sum::<f64>() / times_ms.len() as f64;
        let late = times_ms.iter().filter(|time_ms| **time_ms > 2e3).count();
        println!(
            "| {id} | {solved}/{seeds} | {valid} | {late} | {:.1} | {mean:.1} | {:.1} | {:.1} |",
            quantile(0.5),
            quantile(0.95),
            quantile(1.0)
        );
    }
}

/// How long a single grasp is looked at.
const ITERATIONS: u64 = 3000;

fn grasps(scenarios: &[&str]) {
    println!("| scenario | reached | carried home | what stops the others |");
    println!("|---|---|---|---|");
    for scenario in scenarios {
        let (id, problem) = opened(scenario, Margins::default());
        let all = problem.grasps().expect("grasps").clone();
        let (mut reached, mut carried) = (0, 0);
        let mut stopped: BTreeMap<&str, usize> = BTreeMap::new();
        for grasp in all.grasps() {
            let alone = Goal::Grasps(GraspSet::new(vec![*grasp]).expect("a grasp of the set"));
            let alone = problem.with_goal(alone).expect("a good problem");
            let budget = Budget { iterations: ITERATIONS, time: Duration::from_secs(10) };
            let reach = Request { budget, keep_path: true, ..Request::default() };
            if solve(&alone, &reach, &mut Unobserved).expect("a good problem").outcome != Outcome::Solved {
                continue;
            }
            reached += 1;
            let task = Request { carry: Some(Carry::default()), ..reach };
            let answer = solve(&alone, &task, &mut Unobserved).expect("a good problem");
            if answer.outcome == Outcome::Solved {
                carried += 1;
            } else if let Some(failure) = answer.failures.first() {
                *stopped.entry(short(&failure.reason)).or_default() += 1;
            }
        }
        let stopped: Vec<String> =
            stopped.iter().map(|(reason, count)| format!("{reason} {count}")).collect();
        println!("| {id} | {reached} | {carried} | {} |", stopped.join(", "));
    }
}

fn holds(scenarios: &[&str]) {
    const TIMES: u32 = 10_000;
    println!("| scenario | another hold µs | and room to ask µs |");
    println!("|---|---|---|");
    for scenario in scenarios {
        let (id, problem) = opened(scenario, Margins::default());
        let carrier = Carrier::new(&problem, LiftOffSettings::default()).expect("something to carry");
        let request = Request { carry: Some(Carry::default()), ..Request::default() };
        let answer = solve(&problem, &request, &mut Unobserved).expect("a good problem");
        let grasp = answer.segments[0].waypoints.last().expect("a path");
        let grip = carrier.close(grasp).expect("a grip");
        let mean_us = |work: &dyn Fn()| {
            let begin = Instant::now();
            (0..TIMES).for_each(|_| work());
            begin.elapsed().as_secs_f64() * 1e6 / f64::from(TIMES)
        };
        let held = || grip.cells()[1].with_hold(grip.hold).expect("a hold");
        let hold_us = mean_us(&|| drop(black_box(held())));
        let with_room_us = mean_us(&|| drop(black_box(held().scratch())));
        println!("| {id} | {hold_us:.2} | {with_room_us:.2} |");
    }
}

fn short(reason: &FailureReason) -> &'static str {
    match reason {
        FailureReason::ClosesOnNothing => "closes on nothing",
        FailureReason::ClosingCollides { .. } => "fingers cannot close",
        FailureReason::LiftOffBlocked { .. } => "lift-off blocked",
        FailureReason::LiftOffOutOfReach => "lift-off out of reach",
        FailureReason::NotCarried => "no way found",
        FailureReason::EndBlocked { .. } => "home blocked",
        _ => "not reached again",
    }
}
