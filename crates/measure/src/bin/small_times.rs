//! Small times: kinematics singly, in lanes and in batches; nearest neighbours; exact verdicts and proofs of edges; whole plans.
//! One thread.
//!
//! `cargo run --release -p cranny-measure --bin small_times [-- WORD…]` runs the measurements whose name contains one of the
//! words, or all. It uses built-in data, and also the released scenarios 011 and 044 if `CRANNY_DATA` names the data folder.

use std::hint::black_box;
use std::path::Path;
use std::time::{Duration, Instant};

use cranny_collision::Margins;
use cranny_plan::{Budget, NearestNeighbours, Unobserved, default_planner};
use cranny_robot::{IK_BATCH, IkBatch, IkSettings, LaneFrame, LaneKinematics, Robot, between};
use cranny_scenario::{OpenOptions, Scenario};
use cranny_spatial::{LANES, LaneArray, Pose, Stream};
use cranny_task::Problem;
use fearless_simd::{Level, dispatch};

/// Duration of one measurement.
const MEASURED: Duration = Duration::from_secs(2);

/// Minimum number of rounds of a measurement.
const ROUNDS: usize = 5;

/// Number of uniform random configurations that are checked.
const CONFIGURATIONS: usize = 2048;

/// Length of an edge as a share of the distance between two random configurations: about a step of a tree search.
const EDGE: f64 = 0.05;

/// Dimensions of the points of nearest neighbours.
const DIMENSIONS: usize = 9;

/// Number of additions and queries per copy of a tree, few enough to keep its size.
const CALLS: usize = 64;

/// Number of plans in one round: the duration of one depends on its seed.
const SEEDS: u64 = 4;

fn main() {
    let words = std::env::args().skip(1).collect();
    let table = Table { words };
    println!("| measurement | least µs | median µs | rounds |\n|---|---|---|---|");
    let problems = problems();
    let robot = problems[0].1.robot();
    forward_kinematics(&table, robot);
    inverse_kinematics(&table, robot);
    nearest_neighbours(&table);
    for (id, problem) in &problems {
        checks(&table, id, problem);
        plans(&table, id, problem);
    }
}

/// Measurements that are run, with one row each on standard output.
struct Table {
    words: Vec<String>,
}

impl Table {
    /// Measures rounds of an action, each on what `prepare` makes outside of the time, and prints the time of one of its `count`
    /// elements.
    fn measure<T>(
        &self,
        name: &str,
        count: usize,
        mut prepare: impl FnMut() -> T,
        mut action: impl FnMut(&mut T),
    ) {
        if !self.words.is_empty() && !self.words.iter().any(|word| name.contains(word)) {
            return;
        }
        let begin = Instant::now();
        let mut times_us = Vec::new();
        while times_us.len() < ROUNDS || begin.elapsed() < MEASURED {
            let mut prepared = prepare();
            let start = Instant::now();
            action(&mut prepared);
            times_us.push(start.elapsed().as_secs_f64() * 1e6 / count as f64);
        }
        times_us.sort_by(f64::total_cmp);
        let (least, median) = (times_us[0], times_us[times_us.len() / 2]);
        println!("| {name} | {least:.3} | {median:.3} | {} |", times_us.len());
    }
}

/// Returns the built-in 021, and released 011 and 044 if `CRANNY_DATA` names the data folder.
fn problems() -> Vec<(String, Problem)> {
    let mut names = vec!["021".to_owned()];
    if let Some(data) = std::env::var_os("CRANNY_DATA") {
        let scenarios = Path::new(&data).join("jogramop/scenarios");
        names.extend(["011", "044"].map(|id| scenarios.join(id).display().to_string()));
    }
    let open = |name: String| {
        let scenario = Scenario::open(&name, &OpenOptions::default()).expect("a scenario");
        let problem = scenario.problem(Margins::default()).expect("a problem");
        (scenario.id, problem)
    };
    names.into_iter().map(open).collect()
}

fn forward_kinematics(table: &Table, robot: &Robot) {
    let mut random = Stream::new(0, 0);
    let configurations: Vec<Vec<f64>> = (0..LANES).map(|_| robot.random_configuration(&mut random)).collect();
    let mut frames = robot.frames();
    table.measure(
        "forward kinematics, one at a time",
        LANES * CALLS,
        || (),
        |()| {
            for _ in 0..CALLS {
                for q in &configurations {
                    robot.forward_kinematics(black_box(q), &mut frames);
                    black_box(&frames);
                }
            }
        },
    );
    #[allow(clippy::cast_possible_truncation, reason = "lanes are `f32` by design")]
    let rows: Vec<LaneArray> = (0..robot.dof())
        .map(|joint| std::array::from_fn(|lane| configurations[lane][joint] as f32))
        .collect();
    let kinematics = LaneKinematics::new(robot);
    let mut lane_frames = vec![LaneFrame::IDENTITY; kinematics.frame_count()];
    table.measure(
        "forward kinematics, in lanes",
        LANES * CALLS,
        || (),
        |()| {
            for _ in 0..CALLS {
                let rows = black_box(&rows);
                dispatch!(Level::new(), simd => kinematics.forward(simd, rows, &[], &mut lane_frames));
                black_box(&lane_frames);
            }
        },
    );
}

fn inverse_kinematics(table: &Table, robot: &Robot) {
    let mut random = Stream::new(1, 0);
    let mut frames = robot.frames();
    let mut pose = |random: &mut Stream| -> Pose {
        robot.forward_kinematics(&robot.random_configuration(random), &mut frames);
        *frames.link(robot.tip())
    };
    let poses: Vec<Pose> = (0..64).map(|_| pose(&mut random)).collect();
    let mut batch = IkBatch::new(robot, IkSettings::default());
    let mut next = poses.iter().cycle();
    table.measure(
        "inverse kinematics, attempts in batches",
        IK_BATCH,
        || (),
        |()| {
            for (attempt, pose) in (0..IK_BATCH).zip(&mut next) {
                batch.draw(attempt, pose, &mut random);
            }
            batch.run(IK_BATCH);
            black_box((0..IK_BATCH).filter(|attempt| batch.solution(*attempt).is_some()).count());
        },
    );
}

fn nearest_neighbours(table: &Table) {
    for size in [1_000, 10_000, 100_000] {
        let mut random = Stream::new(0, 0);
        let mut point =
            || -> [f64; DIMENSIONS] { std::array::from_fn(|_| random.uniform_between(-1.0, 1.0)) };
        let mut tree = NearestNeighbours::new(DIMENSIONS);
        for _ in 0..size {
            tree.add(&point());
        }
        let points: Vec<[f64; DIMENSIONS]> = (0..CALLS).map(|_| point()).collect();
        let name = format!("nearest neighbours, a query and an addition among {size} points");
        table.measure(
            &name,
            CALLS,
            || tree.clone(),
            |tree| {
                for point in &points {
                    black_box(tree.nearest(point));
                    tree.add(point);
                }
            },
        );
    }
}

fn checks(table: &Table, id: &str, problem: &Problem) {
    let cell = problem.cell().expect("the default criterion");
    let mut random = Stream::new(0, 0);
    let configurations: Vec<f64> =
        (0..CONFIGURATIONS).flat_map(|_| cell.robot().random_configuration(&mut random)).collect();
    let dof = problem.robot().dof();
    let (mut scratch, mut verdicts) = (cell.scratch(), Vec::new());
    table.measure(
        &format!("{id}: checks, one at a time"),
        CONFIGURATIONS,
        || (),
        |()| {
            black_box(
                configurations.chunks(dof).filter(|q| cell.is_free(black_box(q), &mut scratch)).count(),
            );
        },
    );
    table.measure(
        &format!("{id}: checks, in batches"),
        CONFIGURATIONS,
        || (),
        |()| {
            cell.are_free(black_box(&configurations), &mut scratch, &mut verdicts);
        },
    );
    let rows: Vec<&[f64]> = configurations.chunks(dof).collect();
    let edges: Vec<(&[f64], Vec<f64>)> = rows
        .windows(2)
        .map(|pair| (pair[0], between(pair[0], pair[1], EDGE).collect()))
        .filter(|(a, b): &(&[f64], Vec<f64>)| cell.is_free(a, &mut scratch) && cell.is_free(b, &mut scratch))
        .collect();
    table.measure(
        &format!("{id}: proofs of edges with free ends"),
        edges.len(),
        || (),
        |()| {
            black_box(
                edges.iter().filter(|(a, b)| cell.motion_is_free(a, b, &mut scratch).is_proven()).count(),
            );
        },
    );
}

fn plans(table: &Table, id: &str, problem: &Problem) {
    let planner = default_planner(problem);
    table.measure(
        &format!("{id}: plans"),
        usize::try_from(SEEDS).unwrap_or(usize::MAX),
        || (),
        |()| {
            for seed in 0..SEEDS {
                let report = planner.plan(problem, &Budget::default(), seed, &mut Unobserved);
                assert!(!report.expect("a good problem").path.is_empty(), "{id}, seed {seed}");
            }
        },
    );
}
