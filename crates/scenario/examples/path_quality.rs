//! How short the paths to `MotionBenchMaker` problems are, by plain L2 length:
//! `cargo run --release -p cranny-scenario --example path_quality -- FOLDER EVERY SEEDS MILLISECONDS…`
//!
//! One line of JSON for each problem (every so-many-th), seed and way: the first path as it is found and shortened, and
//! after so many milliseconds more of looking for better ones; with what all of it took.

use std::error::Error;
use std::path::Path;
use std::time::{Duration, Instant};

use cranny_collision::Margins;
use cranny_plan::{
    Budget, CostKind, OptimiseSettings, Outcome, PathCost, Problem, ShortcutSettings, Unobserved, optimise,
    planner, shortcut,
};
use cranny_scenario::{MoveItOptions, MoveItProblem};

use motion_bench_maker::{folders_in, request_of, scenes_in};

mod motion_bench_maker;

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [folder, every, seeds, budgets @ ..] = &words[..] else {
        return Err("FOLDER EVERY SEEDS MILLISECONDS…".into());
    };
    let (every, seeds): (usize, u64) = (every.parse()?, seeds.parse()?);
    let budgets: Vec<f64> = budgets.iter().map(|word| word.parse()).collect::<Result<_, _>>()?;
    for family in folders_in(Path::new(folder))? {
        for scene in scenes_in(&family)?.into_iter().step_by(every) {
            let opened = MoveItProblem::open(&scene, &request_of(&scene), &MoveItOptions::default())?;
            let name = format!("{}/{}", family.file_name().unwrap_or_default().to_string_lossy(), opened.id);
            let problem = opened.problem(Margins::default())?;
            for seed in 0..seeds {
                measure(&name, &problem, seed, &budgets)?;
            }
        }
    }
    Ok(())
}

fn measure(name: &str, problem: &Problem, seed: u64, budgets: &[f64]) -> Result<(), Box<dyn Error>> {
    let cost = PathCost::new(problem.robot(), CostKind::L2, 0.0)?;
    let reach = planner("reach")?;
    let budget = Budget { time: Duration::from_secs(10), ..Budget::default() };
    let tell = |way: &str, begin: Instant, path: &[Vec<f64>]| {
        let time_s = begin.elapsed().as_secs_f64();
        let length = cost.measure(path)?;
        println!(
            "{}",
            serde_json::json!({"problem": name, "seed": seed, "way": way, "time_s": time_s, "l2": length})
        );
        Ok::<_, Box<dyn Error>>(())
    };
    let begin = Instant::now();
    let first = reach.plan(problem, &budget, seed, &mut Unobserved)?;
    if first.outcome != Outcome::Solved {
        return Ok(());
    }
    tell("first", begin, &first.path)?;
    let settings = ShortcutSettings { seed, ..ShortcutSettings::default() };
    let shortened = shortcut(problem, &first.path, settings)?;
    tell("shortened", begin, &shortened.path)?;
    for milliseconds in budgets {
        let begin = Instant::now();
        let time = Duration::from_secs_f64(milliseconds * 1e-3);
        let settings = OptimiseSettings { time, score_weight: 0.0, cost: CostKind::L2 };
        let found = optimise(reach.as_ref(), &mut problem.clone(), &budget, settings, seed, &mut Unobserved)?;
        tell(&format!("{milliseconds} ms"), begin, &found.report.path)?;
    }
    Ok(())
}
