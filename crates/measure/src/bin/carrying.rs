//! Measures carrying the target home or putting it down, and the grasps that allow it; one thread.
//!
//! `carrying plans END SEEDS MARGIN_MM GRASP_MARGIN_MM SCENARIO…`, with END `home` or a place name: prints for each scenario
//! how many tasks are solved, judged valid and take over 2 s, and the median, mean, 95th percentile and maximum of
//! `planning_time_s`: reach, closing, lift-off and all that follows, with their proofs.
//!
//! `carrying grasps PLACE EVERY ITERATIONS SCENARIO…`: prints the number of grasps (every EVERY-th, each alone) reached within
//! ITERATIONS, the numbers of those with which the target can be carried home and can be put down at PLACE, and the reasons for
//! the failures there.
//!
//! `carrying holds SCENARIO…`: time to change the hold, and to do so with new scratch, in microseconds.
//!
//! `cargo run --release -p cranny-measure --bin carrying -- plans home 100 0 0 SCENARIO…`

use std::collections::BTreeMap;
use std::hint::black_box;
use std::time::{Duration, Instant};

use cranny_collision::Margins;
use cranny_grasp::GraspSet;
use cranny_path::{AuditSettings, Clearances};
use cranny_plan::{Budget, Outcome, Unobserved};
use cranny_scenario::{OpenOptions, Scenario};
use cranny_solve::{Request, solve};
use cranny_task::{AfterPlacing, Carrier, FailureReason, Goal, LiftOffSettings, PlaceAt, Problem, Stage};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match &words[..] {
        ["plans", end, seeds, margin, grasp_margin, scenarios @ ..] => {
            let metres = |text: &str| text.parse::<f64>().expect("a number of millimetres") / 1e3;
            let margins = Margins {
                margin_m: metres(margin),
                grasp_margin_m: metres(grasp_margin),
                ..Margins::default()
            };
            plans(end, seeds.parse().expect("a number of seeds"), margins, scenarios);
        }
        ["grasps", place, every, iterations, scenarios @ ..] => {
            let iterations = iterations.parse().expect("a number of iterations");
            grasps(place, every.parse().expect("a number of grasps"), iterations, scenarios);
        }
        ["holds", scenarios @ ..] => holds(scenarios),
        _ => {
            eprintln!(
                "usage: carrying plans home|PLACE SEEDS MARGIN_MM GRASP_MARGIN_MM SCENARIO…, carrying grasps PLACE \
                 EVERY ITERATIONS SCENARIO…, carrying holds SCENARIO…"
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

/// Returns the stages for `home` or the name of a place.
fn carry_to(end: &str) -> Vec<Stage> {
    if end == "home" {
        return vec![Stage::pick(), Stage::home()];
    }
    Stage::put_down(PlaceAt::named(end), AfterPlacing::Home)
}

fn plans(end: &str, seeds: u64, margins: Margins, scenarios: &[&str]) {
    println!("| scenario | solved | judged valid | over 2 s | median ms | mean | 95 % | max |");
    println!("|---|---|---|---|---|---|---|---|");
    for scenario in scenarios {
        let (id, problem) = opened(scenario, margins);
        let (mut times_ms, mut solved, mut valid) = (Vec::new(), 0, 0);
        for seed in 0..seeds {
            let budget = Budget { time: Duration::from_secs(10), ..Budget::default() };
            let stages = carry_to(end);
            let audit = AuditSettings { clearances: Clearances::None, ..AuditSettings::default() };
            let request = Request { seed, budget, stages, audit, ..Request::default() };
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

fn grasps(place: &str, every: usize, iterations: u64, scenarios: &[&str]) {
    println!("| scenario | grasps | reached | carried home | put down | causes of failure there |");
    println!("|---|---|---|---|---|---|");
    for scenario in scenarios {
        let (id, problem) = opened(scenario, Margins::default());
        let all = problem.grasps().expect("grasps").clone();
        let (mut reached, mut carried, mut put_down) = (0, 0, 0);
        let mut stopped: BTreeMap<&str, usize> = BTreeMap::new();
        for grasp in all.grasps().iter().step_by(every) {
            let alone = Goal::Grasps(GraspSet::new(vec![*grasp]).expect("a grasp of the set"));
            let alone = problem.with_goal(alone).expect("a good problem");
            let budget = Budget { iterations, time: Duration::from_secs(10) };
            let reach = Request { budget, keep_path: true, ..Request::default() };
            if solve(&alone, &reach, &mut Unobserved).expect("a good problem").outcome != Outcome::Solved {
                continue;
            }
            reached += 1;
            let task = |end| {
                let task = Request { stages: carry_to(end), ..reach.clone() };
                solve(&alone, &task, &mut Unobserved).expect("a good problem")
            };
            carried += usize::from(task("home").outcome == Outcome::Solved);
            let answer = task(place);
            if answer.outcome == Outcome::Solved {
                put_down += 1;
            } else if let Some(failure) = answer.failures.first() {
                *stopped.entry(short(&failure.reason)).or_default() += 1;
            }
        }
        let stopped: Vec<String> =
            stopped.iter().map(|(reason, count)| format!("{reason} {count}")).collect();
        let (count, stopped) = (all.len().div_ceil(every), stopped.join(", "));
        println!("| {id} | {count} | {reached} | {carried} | {put_down} | {stopped} |");
    }
}

fn holds(scenarios: &[&str]) {
    const TIMES: u32 = 10_000;
    println!("| scenario | another hold µs | and room to ask µs |");
    println!("|---|---|---|");
    for scenario in scenarios {
        let (id, problem) = opened(scenario, Margins::default());
        let carrier = Carrier::new(&problem, LiftOffSettings::default()).expect("something to carry");
        let request = Request { stages: carry_to("home"), ..Request::default() };
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
        FailureReason::TouchesBesidePads { .. } => "touched beside the pads",
        FailureReason::LiftOffBlocked { .. } => "lift-off blocked",
        FailureReason::LiftOffOutOfReach => "lift-off out of reach",
        FailureReason::NotCarried => "no way found",
        FailureReason::EndBlocked { .. } => "home blocked",
        FailureReason::NoPlace => "no place",
        FailureReason::PlaceBlocked { .. } => "hand blocked at the place",
        FailureReason::PlaceOutOfReach => "place out of reach",
        FailureReason::SetDownBlocked { .. } => "set-down blocked",
        FailureReason::SetDownOutOfReach => "set-down out of reach",
        FailureReason::OpeningCollides { .. } => "fingers cannot open",
        FailureReason::RetreatBlocked { .. } => "retreat blocked",
        FailureReason::RetreatOutOfReach => "retreat out of reach",
        FailureReason::NotBroughtThere => "no way there",
        FailureReason::NotReturned => "no way back",
        _ => "not reached again",
    }
}
