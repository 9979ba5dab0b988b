//! Measures the quality of delivered paths, and the time to obtain them:
//! `cargo run --release -p cranny-measure --bin path_quality -- FOLDER EVERY SEEDS COST MILLISECONDS…`
//!
//! FOLDER contains families of `MotionBenchMaker` problems, or scenario folders; COST is a cost of paths (`length`, `l2`,
//! `time`, `clearance`), which is optimised and by which all paths are measured.
//!
//! Prints one line of JSON for each problem (every EVERY-th), seed and method: the first path as found, the path as
//! delivered, and the path after each number of MILLISECONDS of optimisation; with the total time, and the duration of the
//! trajectory in seconds if the robot has the limits for it.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use cranny_collision::Margins;
use cranny_measure::motion_bench_maker::{folders_in, request_of, scenes_in};
use cranny_path::{CostKind, MotionLimits, PathCost, TimingMethod, Trajectory};
use cranny_plan::{Budget, OptimiseSettings, Outcome, Registry, Unobserved, better, optimise};
use cranny_scenario::{MoveItOptions, MoveItProblem, OpenOptions, Scenario};
use cranny_task::Problem;

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [folder, every, seeds, cost, budgets @ ..] = &words[..] else {
        return Err("FOLDER EVERY SEEDS COST MILLISECONDS…".into());
    };
    let (every, seeds): (usize, u64) = (every.parse()?, seeds.parse()?);
    let cost: CostKind = cost.parse()?;
    let budgets: Vec<f64> = budgets.iter().map(|word| word.parse()).collect::<Result<_, _>>()?;
    for folder in folders_in(Path::new(folder))? {
        for (name, problem) in problems_in(&folder, every)? {
            for seed in 0..seeds {
                measure(&name, &problem, seed, cost, &budgets)?;
            }
        }
    }
    Ok(())
}

/// Returns every `every`-th problem of a family; or the problem of a scenario.
fn problems_in(folder: &Path, every: usize) -> Result<Vec<(String, Problem)>, Box<dyn Error>> {
    let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
    if folder.join("scene.yaml").exists() || folder.join("scenario.yaml").exists() {
        let scenario = Scenario::open(&folder.to_string_lossy(), &OpenOptions::default())?;
        return Ok(vec![(name, scenario.problem(Margins::default())?)]);
    }
    let open = |scene: PathBuf| {
        let opened = MoveItProblem::open(&scene, &request_of(&scene), &MoveItOptions::default())?;
        Ok((format!("{name}/{}", opened.id), opened.problem(Margins::default())?))
    };
    scenes_in(folder)?.into_iter().step_by(every).map(open).collect()
}

fn measure(
    name: &str,
    problem: &Problem,
    seed: u64,
    cost: CostKind,
    budgets: &[f64],
) -> Result<(), Box<dyn Error>> {
    let measured = PathCost::new(problem, cost, 0.0)?;
    let limits = MotionLimits::of(problem.robot(), TimingMethod::TimeOptimal).ok();
    let reach = Registry::default().planner("reach")?;
    let budget = Budget { time: Duration::from_secs(10), ..Budget::default() };
    let tell = |way: &str, begin: Instant, path: &[Vec<f64>]| {
        let time_s = begin.elapsed().as_secs_f64();
        let trajectory = limits.as_ref().map(|limits| Trajectory::along(path, limits)).transpose()?;
        let trajectory_s = trajectory.map(|trajectory| trajectory.duration_s());
        let value = measured.measure(path)?;
        println!(
            "{}",
            serde_json::json!({
                "problem": name, "seed": seed, "way": way, "time_s": time_s, "cost": value,
                "trajectory_s": trajectory_s,
            })
        );
        Ok::<_, Box<dyn Error>>(())
    };
    let begin = Instant::now();
    let first = reach.plan(problem, &budget, seed, &mut Unobserved)?;
    if first.outcome != Outcome::Solved {
        return Ok(());
    }
    tell("first", begin, &first.path)?;
    let delivered = better(
        problem,
        first,
        OptimiseSettings { score_weight: 0.0, ..OptimiseSettings::delivery() },
        seed,
        &mut Unobserved,
    )?;
    tell("delivered", begin, &delivered.report.path)?;
    for milliseconds in budgets {
        let problem = problem.clone();
        let begin = Instant::now();
        let time = Duration::from_secs_f64(milliseconds * 1e-3);
        let settings = OptimiseSettings { time, score_weight: 0.0, cost, ..OptimiseSettings::default() };
        let found = optimise(reach.as_ref(), &problem, &budget, settings, seed, &mut Unobserved)?;
        tell(&format!("{milliseconds} ms"), begin, &found.report.path)?;
    }
    Ok(())
}
