//! Reports for each scenario how many of its grasps have an IK solution by the paper's single shot and by the restarting
//! search, why the others fail, and how long it takes, on all cores and without loading.
//!
//! `cargo run --release -p cranny-measure --bin ik_table -- SCENARIO…`

use std::sync::atomic::AtomicBool;
use std::time::Instant;

use cranny_collision::Margins;
use cranny_scenario::{OpenOptions, Scenario};
use cranny_task::{
    AnnotatedSolution, IkAnnotation, IkAnnotationSettings, IkMethod, IkStatus, Problem, annotate_ik,
};

fn main() {
    let scenarios: Vec<String> = std::env::args().skip(1).collect();
    if scenarios.is_empty() {
        eprintln!("usage: ik_table SCENARIO…");
        std::process::exit(2);
    }
    println!(
        "| scenario | grasps | single shot | ms | restarts | ms | hand collides | arm collides | not reached | proven impossible | undecided | attempts | error mm | error ° | clearance mm |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    for id in &scenarios {
        let scenario = Scenario::open(id, &OpenOptions::default()).expect("a scenario");
        let problem = scenario.problem(Margins::default()).expect("a problem");
        let grasps = problem.grasps().expect("a scenario has grasps");
        let (shot, shot_ms) = timed(&problem, IkMethod::SingleShot);
        let (full, full_ms) = timed(&problem, IkMethod::Restarts);
        let count = |annotations: &[IkAnnotation], is_counted: fn(&IkStatus) -> bool| {
            annotations.iter().filter(|annotation| is_counted(&annotation.status)).count()
        };
        let solutions: Vec<&AnnotatedSolution> = full.iter().flat_map(|a| &a.solutions).collect();
        let worst = |value: fn(&AnnotatedSolution) -> f64| {
            solutions.iter().map(|solution| value(solution)).fold(0.0, f64::max)
        };
        let mut clearances: Vec<f64> = solutions.iter().map(|solution| solution.clearance_m * 1e3).collect();
        clearances.sort_by(f64::total_cmp);
        println!(
            "| {} | {} | {} | {shot_ms:.1} | {} | {full_ms:.0} | {} | {} | {} | {} | {} | {} | {:.3} | {:.4} | {:.2} |",
            scenario.id,
            grasps.len(),
            count(&shot, |status| *status == IkStatus::Solved),
            count(&full, |status| *status == IkStatus::Solved),
            count(&full, |status| matches!(status, IkStatus::HandCollides { .. })),
            count(&full, |status| matches!(status, IkStatus::NoSolution { blocked: 1.., .. })),
            count(&full, |status| matches!(status, IkStatus::NoSolution { blocked: 0, .. })),
            count(&full, IkStatus::is_proven_impossible),
            count(&full, |status| *status != IkStatus::Solved && !status.is_proven_impossible()),
            full.iter().map(|annotation| annotation.attempts).sum::<usize>(),
            worst(|solution| solution.translation_error_m * 1e3),
            worst(|solution| solution.rotation_error_rad.to_degrees()),
            clearances.get(clearances.len() / 2).copied().unwrap_or(f64::NAN),
        );
    }
}

/// Returns the annotations and their computation time, in milliseconds.
fn timed(problem: &Problem, method: IkMethod) -> (Vec<IkAnnotation>, f64) {
    let settings = IkAnnotationSettings { method, ..IkAnnotationSettings::default() };
    let begin = Instant::now();
    let found = annotate_ik(problem, &settings, &|| (), &AtomicBool::new(false)).expect("an exact problem");
    (found, begin.elapsed().as_secs_f64() * 1e3)
}
