//! Plans every problem of a folder of `MotionBenchMaker` families with several seeds:
//! `cargo run --release -p cranny-measure --bin motion_bench -- FOLDER [PLANNER] [SEEDS] [SETTINGS] [--real]
//! [--cloud[=POINTS]] [--voxel=M] [--radius=M]`, SETTINGS are those of the planner as JSON.
//!
//! FOLDER contains a folder for each family, with `sceneNNNN.yaml` and `requestNNNN.yaml`, and beside them
//! `panda_spherized.urdf` and `panda.srdf`. With `--real` the robot is the detailed one in
//! `$CRANNY_DATA/jogramop/robots/franka_panda/panda.urdf`, each link as its convex hull.
//!
//! With `--cloud` each world is a cloud of POINTS on the surface of each object (10000), filtered by voxels of a side of M metres (0.02;
//! 0: not at all), each point with a ball of a radius of M metres (0.0025). A second table has the points before and after the filter,
//! the times of filter and tree in milliseconds, and the number of proven paths that are also proven free of the objects themselves:
//! others lead through gaps between the balls.
//!
//! Times are in microseconds, over the solved runs; "search" is planning without the proof of the path, if the planner
//! separates the two; "iteration" is one of the search, "verdict" is a single check of a uniform random configuration.
//! A problem is valid if its start and a goal are free.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use cranny_collision::{Cell, Margins, Motion};
use cranny_measure::clouds::{CloudSettings, CloudWorld};
use cranny_measure::motion_bench_maker::{folders_in, request_of, scenes_in};
use cranny_plan::{Budget, Outcome, Planner, Registry, Unobserved};
use cranny_scenario::{MoveItOptions, MoveItProblem};
use cranny_spatial::Stream;
use cranny_task::{Goal, Problem};

fn main() -> Result<(), Box<dyn Error>> {
    let (flags, words): (Vec<String>, Vec<String>) =
        std::env::args().skip(1).partition(|word| word.starts_with("--"));
    let (mut is_real, mut cloud) = (false, None::<CloudSettings>);
    for flag in &flags {
        let (name, value) = flag.split_once('=').map_or((flag.as_str(), None), |(name, v)| (name, Some(v)));
        let settings = cloud.unwrap_or_default();
        match (name, value) {
            ("--real", None) => is_real = true,
            ("--cloud", None) => cloud = Some(settings),
            ("--cloud", Some(count)) => {
                cloud = Some(CloudSettings { points_per_object: count.parse()?, ..settings });
            }
            ("--voxel", Some(side_m)) => {
                let side_m: f64 = side_m.parse()?;
                cloud = Some(CloudSettings { voxel_m: (side_m > 0.0).then_some(side_m), ..settings });
            }
            ("--radius", Some(radius_m)) => {
                cloud = Some(CloudSettings { radius_m: radius_m.parse()?, ..settings });
            }
            _ => return Err("the flags are --real, --cloud[=POINTS], --voxel=M and --radius=M".into()),
        }
    }
    let folder = words.first().ok_or("usage: motion_bench FOLDER [PLANNER] [SEEDS] [SETTINGS] [--real]")?;
    let settings = words.get(3).map_or(Ok(serde_json::Map::new()), |text| serde_json::from_str(text))?;
    let planner =
        Registry::default().planner_with(words.get(1).map_or("reach", String::as_str), &settings)?;
    let seeds: u64 = words.get(2).map_or(Ok(1), |word| word.parse())?;
    let robot = match (is_real, std::env::var_os("CRANNY_DATA")) {
        (false, _) => None,
        (true, Some(data)) => Some(PathBuf::from(data).join("jogramop/robots/franka_panda/panda.urdf")),
        (true, None) => return Err("--real needs CRANNY_DATA".into()),
    };
    let options = MoveItOptions { robot, ..MoveItOptions::default() };

    println!(
        "{} with {seeds} seed(s), {}{}",
        planner.name(),
        if is_real { "real geometry" } else { "spheres" },
        cloud.map_or_else(String::new, |settings| format!(", {settings:?}")),
    );
    println!(
        "{:<22} {:>8} {:>5} {:>6} {:>6} {:>6} | {:>39} | {:>39} | {:>9} {:>7}",
        "", "", "", "", "", "", "search: median mean p95 p99 max", "with proof", "iteration", "verdict"
    );
    println!(
        "{:<22} {:>8} {:>5} {:>6} {:>6} {:>6} | {:>39} | {:>39} | {:>9} {:>7}",
        "family", "problems", "valid", "runs", "solved", "proven", "µs", "µs", "µs", "µs"
    );
    let run = Run { options, cloud, planner: planner.as_ref(), seeds };
    let (mut total, mut clouds) = (Tally::default(), Vec::new());
    for family in folders_in(Path::new(folder))? {
        let mut tally = Tally::default();
        for scene in scenes_in(&family)? {
            run.problem(&scene, &mut tally)?;
        }
        if tally.problems > 0 {
            let name = family.file_name().unwrap_or_default().to_string_lossy();
            tally.print(&name);
            clouds.push(tally.clouds.row(&name, tally.proven));
        }
        total.add(tally);
    }
    total.print("all");
    if cloud.is_some() {
        println!("{CLOUD_HEAD}");
        clouds.push(total.clouds.row("all", total.proven));
        for row in &clouds {
            println!("{row}");
        }
    }
    for note in &total.notes {
        println!("{note}");
    }
    Ok(())
}

/// Results on the problems of a family.
#[derive(Default)]
struct Tally {
    problems: usize,
    valid: usize,
    runs: usize,
    solved: usize,
    proven: usize,
    search_s: Vec<f64>,
    planning_s: Vec<f64>,
    iterations: u64,
    /// Time of each verdict in seconds, as the mean over a problem.
    verdict_s: Vec<f64>,
    /// Notes on invalid problems and failed runs.
    notes: Vec<String>,
    clouds: CloudTally,
}

/// Head of the table of clouds.
const CLOUD_HEAD: &str = "family                 | points, kept: medians | filter ms, tree ms, sum: medians, p95, max of the sum | proven, also free of objects";

/// Clouds of a family.
#[derive(Default)]
struct CloudTally {
    sampled: Vec<f64>,
    kept: Vec<f64>,
    filter_s: Vec<f64>,
    build_s: Vec<f64>,
    /// Number of proven paths that meet none of the objects on which the points were sampled.
    truly_free: usize,
}

impl CloudTally {
    fn add(&mut self, other: Self) {
        self.sampled.extend(other.sampled);
        self.kept.extend(other.kept);
        self.filter_s.extend(other.filter_s);
        self.build_s.extend(other.build_s);
        self.truly_free += other.truly_free;
    }

    fn row(&self, name: &str, proven: usize) -> String {
        let sums: Vec<f64> = std::iter::zip(&self.filter_s, &self.build_s).map(|(a, b)| a + b).collect();
        let ms = |times: &[f64], fraction| 1e3 * quantile(times, fraction);
        format!(
            "{name:<22} | {:>7} {:>7} | {:>6.2} {:>6.2} {:>6.2} {:>6.2} {:>6.2} | {proven:>6} {:>6}",
            quantile(&self.sampled, 0.5),
            quantile(&self.kept, 0.5),
            ms(&self.filter_s, 0.5),
            ms(&self.build_s, 0.5),
            ms(&sums, 0.5),
            ms(&sums, 0.95),
            ms(&sums, 1.0),
            self.truly_free
        )
    }
}

impl Tally {
    fn add(&mut self, other: Self) {
        self.problems += other.problems;
        self.valid += other.valid;
        self.runs += other.runs;
        self.solved += other.solved;
        self.proven += other.proven;
        self.search_s.extend(other.search_s);
        self.planning_s.extend(other.planning_s);
        self.iterations += other.iterations;
        self.verdict_s.extend(other.verdict_s);
        self.notes.extend(other.notes);
        self.clouds.add(other.clouds);
    }

    fn print(&self, name: &str) {
        let [search, planning] = [&self.search_s, &self.planning_s].map(|times| {
            let mean = times.iter().sum::<f64>() / times.len() as f64;
            let of = |fraction| quantile(times, fraction);
            [of(0.5), mean, of(0.95), of(0.99), of(1.0)]
                .map(|time_s| format!("{:>7.0}", time_s * 1e6))
                .join(" ")
        });
        let Self { problems, valid, runs, solved, proven, .. } = self;
        let iteration = 1e6 * self.search_s.iter().sum::<f64>() / self.iterations as f64;
        let verdict = 1e6 * self.verdict_s.iter().sum::<f64>() / self.verdict_s.len() as f64;
        println!(
            "{name:<22} {problems:>8} {valid:>5} {runs:>6} {solved:>6} {proven:>6} | {search} | {planning} | \
             {iteration:>9.2} {verdict:>7.2}"
        );
    }
}

/// Returns the smallest value that at least this fraction of all values do not exceed.
fn quantile(values: &[f64], fraction: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let index = sorted.iter().enumerate().position(|(i, _)| (i + 1) as f64 >= fraction * sorted.len() as f64);
    index.map_or(f64::NAN, |index| sorted[index])
}

/// Settings of all runs.
struct Run<'a> {
    options: MoveItOptions,
    cloud: Option<CloudSettings>,
    planner: &'a dyn Planner,
    seeds: u64,
}

impl Run<'_> {
    fn problem(&self, scene: &Path, tally: &mut Tally) -> Result<(), Box<dyn Error>> {
        let mut opened = MoveItProblem::open(scene, &request_of(scene), &self.options)?;
        let true_problem = opened.problem(Margins::default())?;
        if let Some(settings) = &self.cloud {
            let cloud = CloudWorld::of(&opened.world, settings, tally.problems as u64)?;
            tally.clouds.sampled.push(cloud.sampled as f64);
            tally.clouds.kept.push(cloud.kept as f64);
            tally.clouds.filter_s.push(cloud.filter_s);
            tally.clouds.build_s.push(cloud.build_s);
            opened.world = cloud.world;
        }
        let problem = opened.problem(Margins::default())?;
        let cell = problem.cell().ok_or("a MoveIt problem is exact")?;
        let true_cell = true_problem.cell().ok_or("a MoveIt problem is exact")?;
        tally.problems += 1;
        let family = scene.parent().and_then(Path::file_name).unwrap_or_default().to_string_lossy();
        let name = format!("{family}/{}", opened.id);
        let faults = faults(&problem, cell);
        if !faults.is_empty() {
            tally.notes.push(format!("not valid: {name}: {}", faults.join("; ")));
            return Ok(());
        }
        tally.valid += 1;
        tally.verdict_s.push(seconds_per_verdict(cell));
        for seed in 0..self.seeds {
            let budget = Budget { time: Duration::from_secs(10), ..Budget::default() };
            let report = self.planner.plan(&problem, &budget, seed, &mut Unobserved)?;
            tally.runs += 1;
            if report.outcome != Outcome::Solved {
                tally.notes.push(format!("not solved: {name}, seed {seed}: {}", report.outcome.name()));
                continue;
            }
            tally.solved += 1;
            let statistics = report.statistics;
            tally.iterations += statistics.iterations;
            tally.planning_s.push(statistics.planning_time_s);
            tally.search_s.push(statistics.planning_time_s - statistics.proof_time_s);
            // The path is proven again, whichever planner found it, so that the reports of all planners are comparable.
            let is_goal = |q: &Vec<f64>| match problem.goal() {
                Goal::Configurations(goals) => goals.contains(q),
                Goal::Grasps(_) | Goal::Regions(_) => false,
            };
            let is_whole = report.path.first().is_some_and(|q| q == problem.start())
                && report.path.last().is_some_and(is_goal);
            match refuted(cell, &report.path) {
                None if is_whole => tally.proven += 1,
                None => tally.notes.push(format!("not from start to goal: {name}, seed {seed}")),
                Some(motion) => tally.notes.push(format!("not proven: {name}, seed {seed}: {motion:?}")),
            }
            if self.cloud.is_some() && refuted(true_cell, &report.path).is_none() {
                tally.clouds.truly_free += 1;
            }
        }
        Ok(())
    }
}

/// Returns the result for the first edge of a path that is not proven free; `None` if all are.
fn refuted(cell: &Cell, path: &[Vec<f64>]) -> Option<Motion> {
    let mut scratch = cell.scratch();
    let mut motions = path.windows(2).map(|edge| cell.motion_is_free(&edge[0], &edge[1], &mut scratch));
    motions.find(|motion| !motion.is_proven())
}

fn seconds_per_verdict(cell: &Cell) -> f64 {
    const COUNT: usize = 2000;
    let (mut random, mut scratch) = (Stream::new(0, 0), cell.scratch());
    let all: Vec<Vec<f64>> = (0..COUNT).map(|_| cell.robot().random_configuration(&mut random)).collect();
    let begin = Instant::now();
    let free = all.iter().filter(|q| cell.is_free(q, &mut scratch)).count();
    std::hint::black_box(free);
    begin.elapsed().as_secs_f64() / COUNT as f64
}

/// Returns the faults of start and goals; empty if the start and a goal are free.
fn faults(problem: &Problem, cell: &Cell) -> Vec<String> {
    let mut scratch = cell.scratch();
    let mut faults_of = |what: &str, q: &[f64]| -> Vec<String> {
        let limit = problem.robot().first_limit_violation(q).map(|found| {
            let joint = &problem.robot().joint_names()[found.joint];
            format!("{what}: {joint} at {} is outside {} to {}", found.value, found.lower, found.upper)
        });
        let contacts = cell.contacts(q, &mut scratch);
        let touching = contacts.iter().map(|contact| {
            let (first, second) = (cell.name(contact.first), cell.name(contact.second));
            format!("{what}: {first} meets {second}, {:.3} mm deep", contact.depth_m * 1000.0)
        });
        limit.into_iter().chain(touching).collect()
    };
    let mut faults = faults_of("start", problem.start());
    if let Goal::Configurations(goals) = problem.goal() {
        let of_goals: Vec<Vec<String>> = goals.iter().map(|goal| faults_of("goal", goal)).collect();
        if !of_goals.iter().any(Vec::is_empty) {
            faults.extend(of_goals.into_iter().flatten());
        }
    }
    faults
}
