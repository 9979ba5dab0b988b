//! The released scenarios, each with a path of the planner under test.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, Once, OnceLock};
use std::time::Duration;

use cranny_collision::{Cell, Margins};
use cranny_path::{ShortcutSettings, shortcut};
use cranny_plan::{Budget, Outcome, Registry, Unobserved};
use cranny_scenario::{OpenOptions, Scenario};
use cranny_solve::{Request, solve};
use cranny_task::{Criterion, PlaceRegion, Problem, Stage};

use crate::judge::Oracle;

/// A released scenario.
pub struct Case {
    pub id: String,
    pub oracle: Oracle,
    /// Cell under test.
    pub cell: Arc<Cell>,
    pub start: Vec<f64>,
    scenario: Scenario,
    problem: Problem,
    path: OnceLock<Option<Vec<Vec<f64>>>>,
}

impl Case {
    /// Way points from the start to a grasp, by `reach` with the first seed that solves it, shortened as delivered; `None` if
    /// the planner found none. Planned once.
    pub fn path(&self) -> Option<&Vec<Vec<f64>>> {
        self.path.get_or_init(|| path(&self.id, &self.problem)).as_ref()
    }

    /// Plans the target's way in the closed hand: from the grasp to the end of the lift-off, and from there home.
    pub fn carried(&self) -> Option<[Vec<Vec<f64>>; 2]> {
        carried(&self.problem)
    }

    /// Plans all segments of a task that puts the target down outside and goes home.
    pub fn placed(&self) -> Option<Vec<Vec<Vec<f64>>>> {
        placed(&self.scenario, &self.problem)
    }
}

/// Returns true in the longer form of the tests.
pub fn is_long() -> bool {
    std::env::var_os("CRANNY_LONG").is_some()
}

/// Returns the second and the hardest of each object, or with `CRANNY_LONG` all twenty; `None`, with a message, if the data
/// does not exist.
pub fn cases() -> Option<&'static [Case]> {
    static CASES: OnceLock<Vec<Case>> = OnceLock::new();
    let Some(folder) = scenarios() else {
        assert!(std::env::var_os("CRANNY_REQUIRE_ALL").is_none(), "CRANNY_DATA is not set");
        static SAID: Once = Once::new();
        // Write to the stream directly: the output of a test is shown only if it fails.
        SAID.call_once(|| {
            let _ =
                writeln!(io::stderr(), "SKIPPED: the oracle judges no released scenario; set CRANNY_DATA");
        });
        return None;
    };
    Some(CASES.get_or_init(|| {
        let levels: &[u32] = if is_long() { &[1, 2, 3, 4, 5] } else { &[2, 5] };
        let ids: Vec<String> =
            (1..=4).flat_map(|object| levels.iter().map(move |level| format!("0{object}{level}"))).collect();
        for_each(&ids, |id| case(&folder.join(id)))
    }))
}

fn scenarios() -> Option<PathBuf> {
    std::env::var_os("CRANNY_DATA").map(|data| PathBuf::from(data).join("jogramop/scenarios"))
}

fn case(folder: &Path) -> Case {
    let scenario = Scenario::open(folder.to_str().unwrap(), &OpenOptions::default()).unwrap();
    assert_eq!(scenario.criterion, Criterion::Exact);
    let problem = scenario.problem(Margins::default()).unwrap();
    let cell = problem.cell().expect("the criterion is exact");
    Case {
        id: scenario.id.clone(),
        oracle: Oracle::new(scenario.robot.clone(), folder),
        cell: cell.clone(),
        start: problem.start().to_vec(),
        path: OnceLock::new(),
        scenario,
        problem,
    }
}

/// Solves that task with the goal of the built-in scenario of the same id.
fn placed(scenario: &Scenario, problem: &Problem) -> Option<Vec<Vec<Vec<f64>>>> {
    let own = Scenario::open(&scenario.id, &OpenOptions::default()).unwrap();
    let mut goal = own.places[0].clone();
    if let PlaceRegion::Surface { on, .. } = &mut goal.spot {
        // The surface may have another name there.
        let bodies = scenario.world.bodies();
        let known = bodies.iter().find(|body| body.name.contains(on.as_str()));
        *on = known.unwrap_or_else(|| panic!("{}: no {on}", scenario.id)).name.clone();
    }
    let stages = vec![Stage::pick(), Stage::place(&goal.name), Stage::home()];
    let problem = problem.clone().with_places(&[goal]);
    // The oracle checks shapes, not the firmness of the hold.
    let request = Request { stages, hold: None, ..Request::default() };
    let answer = solve(&problem, &request, &mut Unobserved).unwrap();
    assert!(answer.segments.is_empty() || answer.is_solved(), "{:?}", answer.audit);
    let pieces: Vec<_> = answer.segments.into_iter().map(|segment| segment.waypoints).collect();
    (!pieces.is_empty()).then_some(pieces)
}

fn carried(problem: &Problem) -> Option<[Vec<Vec<f64>>; 2]> {
    let request = Request { stages: vec![Stage::pick(), Stage::home()], hold: None, ..Request::default() };
    let answer = solve(problem, &request, &mut Unobserved).unwrap();
    assert!(answer.segments.is_empty() || answer.is_solved(), "{:?}", answer.audit);
    let [_, lift_off, carry] = &answer.segments[..] else { return None };
    Some([lift_off, carry].map(|segment| segment.waypoints.clone()))
}

fn path(id: &str, problem: &Problem) -> Option<Vec<Vec<f64>>> {
    const SEEDS: u64 = 3;
    let planner = Registry::default().planner("reach").unwrap();
    let budget = Budget { time: Duration::from_secs(30), ..Budget::default() };
    for seed in 0..SEEDS {
        let report = planner.plan(problem, &budget, seed, &mut Unobserved).unwrap();
        let (outcome, seconds) = (report.outcome.name(), report.statistics.planning_time_s);
        println!("{id}: seed {seed}: {outcome} after {seconds:.1} s");
        if report.outcome == Outcome::Solved {
            return Some(shortcut(problem, &report.path, ShortcutSettings::default()).unwrap().path);
        }
    }
    None
}

/// Applies `work` to each item, on two threads; returns the results in the order of the items.
pub fn for_each<I: Sync, T: Send>(items: &[I], work: impl Fn(&I) -> T + Sync) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let done = Mutex::new(BTreeMap::new());
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(item) = items.get(index) else { break };
                    let result = work(item);
                    done.lock().unwrap().insert(index, result);
                }
            });
        }
    });
    done.into_inner().unwrap().into_values().collect()
}
